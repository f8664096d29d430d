/* matrig scale: scenes and studies at another scale, or with joints turned to a diagonal lay. */
#ifndef MATRIG_HOST_LANDING_SERIES_SCALE_H
#define MATRIG_HOST_LANDING_SERIES_SCALE_H

#include "common/similitude.h"
#include "host/base/answer.h"

#define SCALE_WORDS_MAX 32

struct scale_request {
    enum mr_similitude_rule rule;
    bool to_model;
    double n;
    double lay_deg;        /* 0: the pattern stays */
    const char *to, *keep; /* as they were given; NULL: not */
    const char *output_path;
    bool force;
    const char *words[SCALE_WORDS_MAX];
    size_t count;
};

/* What a value of this dimension is multiplied by. */
double scale_factor(const struct scale_request *request, struct mr_dimension dimension);
/* What every answer begins with: rule, n and side, for programs. */
struct answer *scale_answer(const struct scale_request *request);

/* A scene or a campaign, as the file shows; returns the exit code. */
int scale_file(const struct scale_request *request, const struct cli *cli);

#endif
