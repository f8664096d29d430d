/* matrig params: what it has found, and the part that a push test adds to it. */
#ifndef MATRIG_HOST_COMMANDS_PARAMS_PUSH_H
#define MATRIG_HOST_COMMANDS_PARAMS_PUSH_H

#include "host/analyse/params.h"
#include "host/base/answer.h"
#include "host/push/ground.h"

#define PARAMETERS_MAX 16

struct params_found {
    const char *key; /* of the scene */
    const char *unit;
    const char *from;
    struct estimate estimate;
    double low, high; /* 95 %; NaN: 1.96 errors either side */
    bool given;       /* told, not measured: without an error */
};

struct params_reader {
    const char *path;
    const json_t *root;
    struct params_found parameters[PARAMETERS_MAX];
    char from[PARAMETERS_MAX][96]; /* texts made here */
    size_t count;
    struct error *error;
};

struct params_request {
    const char *output_path, *push_path, *plot_path;
    int64_t mats;
    double axle_load_lb, mat_weight_lb, mat_length_ft, force_error_lb, moved_error_in,
        expected_lb_ft;
    bool force;
};

#define PARAMS_LINES 3
struct params_push {
    struct push_readings readings;
    struct push_setting setting;
    struct push_ground ground;
    char line[PARAMS_LINES][48]; /* of the board's configuration; "": none */
};

/* No more than PARAMETERS_MAX. */
void params_add(struct params_reader *reader, const char *key, const char *unit, const char *from,
                struct estimate estimate);

/* Reads the tests and adds the keys that they tell; a key that is there stays, and is used. An
 * error goes to reader->error. params_push_free in any case. */
enum mr_status params_push_find(const struct params_request *request, struct params_reader *reader,
                                struct params_push *push);
void params_push_free(struct params_push *push);
/* What is said beside the keys. */
void params_push_answer(const struct params_push *push, struct answer *answer);
/* A panel for each test: its readings and both laws. */
enum mr_status params_push_plot(const struct params_request *request,
                                const struct params_push *push, struct error *error);

#endif
