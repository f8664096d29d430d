/* matrig scale, between its files: scale_command.c (options, quantities), scale_file.c (scenes and
 * campaigns), scale_lay.c (joints turned to a diagonal lay). */
#ifndef MATRIG_HOST_SCALE_H
#define MATRIG_HOST_SCALE_H

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

/* What a scene key's value is multiplied by when joints that ran straight across the runway are
 * turned by `deg`: of a strip along the runway (sim/MODIFICATIONS.md, "Diagonal pattern"). 1 for
 * keys that stay. */
double scale_lay_factor(const char *key, double deg);
/* The scene's lay_deg, and its N so that the runway stays as long. MR_USAGE when it lies so
 * already, or has a list by joint. `path` begins the error. */
enum mr_status scale_lay_scene(json_t *scene, double deg, const char *path, struct error *error);

#endif
