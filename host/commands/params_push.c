#include "host/commands/params_push.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/base/output.h"
#include "host/push/push_answer.h"
#include "host/push/push_page.h"

#define Z_95            1.96
/* What a scene takes: a share that springs back is above 0. */
#define UNLOADING_LEAST 0.01
#define AXLE_LAW_MOST   2.0

static const struct params_found *found(const struct params_reader *reader, const char *key)
{
    for (size_t i = 0; i < reader->count; i++) {
        if (strcmp(reader->parameters[i].key, key) == 0)
            return &reader->parameters[i];
    }
    return NULL;
}

/* A value that the scene takes, with its interval cut to what it takes. */
static void add_told(struct params_reader *reader, const char *key, const char *unit,
                     const struct push_told *told, double least, double most)
{
    const struct push_interval *of = &told->of;
    if (isnan(of->value) || found(reader, key))
        return;
    params_add(
        reader, key, unit, told->reason,
        (struct estimate){fmin(most, fmax(least, of->value)), (of->high - of->low) / (2.0 * Z_95)});
    struct params_found *last = &reader->parameters[reader->count - 1];
    last->low = fmin(most, fmax(least, of->low));
    last->high = fmin(most, fmax(least, of->high));
}

static void add_given(struct params_reader *reader, const char *key, const char *unit,
                      const char *from, double value)
{
    if (found(reader, key))
        return;
    params_add(reader, key, unit, from, (struct estimate){value, 0.0});
    reader->parameters[reader->count - 1].given = true;
}

static void add_keys(const struct params_request *request, struct params_reader *reader,
                     const struct params_push *push)
{
    const struct push_ground *ground = &push->ground;
    add_told(reader, "f", "1", &ground->friction, 0.0, HUGE_VAL);
    if (ground->law != PUSH_ELASTIC || isnan(ground->k_lb_ft.of.value))
        return; /* the other keys mean nothing without it */
    add_told(reader, "gear_k_lb_ft", "lb/ft", &ground->k_lb_ft, 0.0, HUGE_VAL);
    add_told(reader, "gear_unloading", "1", &ground->unloading, UNLOADING_LEAST, 1.0);
    add_told(reader, "gear_axle_law", "1", &ground->axle_law, 0.0, AXLE_LAW_MOST);
    add_given(reader, "wheel_load", "lb",
              request->axle_load_lb > 0.0 ? "--axle-load" : "least load tested, of one axle",
              ground->axle_load_lb);
    if (request->mat_length_ft > 0.0 && request->mats > 1)
        add_given(reader, "gear_foot_ft", "ft", "as many mats pressed as in the test (--mats)",
                  (double)(request->mats - 1) * request->mat_length_ft);
}

static void add_lines(const struct params_reader *reader, struct params_push *push)
{
    const struct params_found *f = found(reader, "f"), *weight = found(reader, "W");
    size_t count = 0;
    /* weight / axles: what stands on one axle */
    snprintf(push->line[count++], sizeof push->line[0], "predict.thrust_lb_per_g = %.6g",
             push->ground.axle_load_lb);
    if (f)
        snprintf(push->line[count++], sizeof push->line[0], "predict.friction = %.6g",
                 f->estimate.value);
    if (weight)
        snprintf(push->line[count++], sizeof push->line[0], "predict.mat_weight_lb = %.6g",
                 weight->estimate.value);
}

enum mr_status params_push_find(const struct params_request *request, struct params_reader *reader,
                                struct params_push *push)
{
    const struct params_found *f = found(reader, "f"), *weight = found(reader, "W");
    if (request->mats == 0)
        return error_set(reader->error, MR_USAGE,
                         "how many mats does the load press in this test? %s does not say; give "
                         "--mats 1 or --mats 2 (k is of one of them)",
                         request->push_path);
    if (push_readings_load(request->push_path, &push->readings, reader->error) != MR_OK)
        return reader->error->status;
    push->setting = (struct push_setting){
        .gages = {request->force_error_lb, request->moved_error_in},
        .mats = (unsigned)request->mats,
        .mat_weight_lb = request->mat_weight_lb > 0.0 ? request->mat_weight_lb
                       : weight                       ? weight->estimate.value
                                                      : 0.0,
        .friction = f ? f->estimate.value : 0.0,
        .axle_load_lb = request->axle_load_lb,
        .expected_lb_ft = request->expected_lb_ft,
    };
    if (push_ground_find(&push->readings, &push->setting, &push->ground, reader->error) != MR_OK)
        return reader->error->status;
    add_keys(request, reader, push);
    add_lines(reader, push);
    return MR_OK;
}

void params_push_free(struct params_push *push)
{
    push_readings_free(&push->readings);
    push_ground_free(&push->ground);
}

void params_push_answer(const struct params_push *push, struct answer *answer)
{
    push_answer_law(answer, &push->ground, &push->setting);
    push_answer_tests(answer, &push->readings, &push->ground);
    answer_list(answer, "predictor", "board's configuration, of its predictor (no elastic ground)");
    for (size_t i = 0; i < PARAMS_LINES && push->line[i][0]; i++)
        answer_words(answer, NULL, "", "%s", push->line[i]);
    answer_close(answer);
}

enum mr_status params_push_page(const struct params_request *request,
                                const struct params_reader *reader, const struct params_push *push,
                                struct error *error)
{
    struct push_page_row rows[PARAMETERS_MAX];
    const char *lines[PARAMS_LINES + 1] = {NULL};
    struct output output;
    for (size_t i = 0; i < reader->count; i++) {
        const struct params_found *p = &reader->parameters[i];
        double half = p->estimate.error > 0.0 ? Z_95 * p->estimate.error : (double)NAN;
        bool own = !isnan(p->low);
        rows[i] = (struct push_page_row){p->key,
                                         p->unit,
                                         p->from,
                                         {p->estimate.value,
                                          own ? p->low : p->estimate.value - half,
                                          own ? p->high : p->estimate.value + half}};
    }
    for (size_t i = 0; i < PARAMS_LINES && push->line[i][0]; i++)
        lines[i] = push->line[i];
    if (!request->page_path)
        return MR_OK;
    if (output_begin(&output, request->page_path, request->force, error) != MR_OK)
        return error->status;
    push_page(output.file, request->push_path, &push->readings, &push->setting, &push->ground, rows,
              reader->count, lines);
    return output_end(&output, error);
}
