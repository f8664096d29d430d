#include "host/commands/params_push.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/base/plot.h"
#include "host/push/push_answer.h"

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

/* Up at the zero, and along the limit; beyond the plot where the limit is not known. */
static void plot_rigid(struct plot *plot, const struct push_series *series,
                       const struct push_fit *fit, double limit_lb)
{
    double top_lb = 0.0, right_in = fit->zero_in;
    for (size_t i = 0; i < series->count; i++) {
        top_lb = fmax(top_lb, series->force_lb[i]);
        right_in = fmax(right_in, series->moved_in[i]);
    }
    bool known = isfinite(limit_lb) && limit_lb < 2.5 * top_lb;
    if (known)
        top_lb = limit_lb;
    plot_draw(plot, &(struct plot_series){.kind = PLOT_LINE,
                                          .key = known ? "Coulomb, rigid, to its limit"
                                                       : "Coulomb, rigid",
                                          .colour = 5,
                                          .dashed = true,
                                          .x = (double[]){fit->zero_in, fit->zero_in, right_in},
                                          .y = (double[]){0.0, top_lb, top_lb},
                                          .count = known ? 3 : 2});
}

enum mr_status params_push_plot(const struct params_request *request,
                                const struct params_push *push, struct error *error)
{
    const struct push_readings *readings = &push->readings;
    double law_in[PUSH_READINGS_MAX];
    unsigned rows = (unsigned)(readings->count + 1) / 2;
    struct plot *plot = plot_new(request->push_path, 1000, 60 + 380 * rows, 2);
    for (size_t i = 0; i < readings->count; i++) {
        const struct push_series *series = &readings->series[i];
        const struct push_fit *fit = &push->ground.fit[i];
        char title[PUSH_NAME + 40];
        snprintf(title, sizeof title, "test %s, %.4g lb", series->name, series->load_lb);
        plot_panel(plot, title, (struct plot_axis){.label = "displacement (in)"},
                   (struct plot_axis){.label = "force (lb)"});
        plot_draw(plot, &(struct plot_series){.kind = PLOT_LINE_POINTS,
                                              .key = "read",
                                              .colour = PLOT_GREY,
                                              .x = series->moved_in,
                                              .y = series->force_lb,
                                              .count = series->count});
        push_fit_curve(series, push->setting.gages, fit, law_in);
        plot_draw(plot, &(struct plot_series){.kind = PLOT_LINE,
                                              .key = isnan(fit->k_lb_in.value)
                                                       ? "elastic, least stiffness"
                                                       : "elastic ground",
                                              .colour = 1,
                                              .x = law_in,
                                              .y = series->force_lb,
                                              .count = series->count});
        plot_rigid(plot, series, fit,
                   fit->slid > 0
                       ? fabs(fit->limit_lb)
                       : push_ground_limit_lb(&push->ground, &push->setting, series->load_lb));
    }
    return plot_write(plot, request->plot_path, error);
}
