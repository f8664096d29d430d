/* matrig params: readings of section 3.4 to scene parameters. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/analyse/params.h"
#include "host/base/answer.h"
#include "host/base/output.h"
#include "host/base/plot.h"
#include "host/base/quantity.h"
#include "host/commands/commands.h"
#include "host/push/ground.h"

#define READINGS_MAX   1000
#define IN_PER_FT      12.0
#define RAD_PER_DEG    (M_PI / 180.0)
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
    double axle_load_lb, force_error_lb, moved_error_in;
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
static void params_add(struct params_reader *reader, const char *key, const char *unit,
                       const char *from, struct estimate estimate)
{
    reader->parameters[reader->count++] = (struct params_found){.key = key,
                                                                .unit = unit,
                                                                .from = from,
                                                                .estimate = estimate,
                                                                .low = (double)NAN,
                                                                .high = (double)NAN};
}

/* ---- push tests ---- */

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

static enum mr_status params_push_find(const struct params_request *request,
                                       struct params_reader *reader, struct params_push *push)
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
        .mat_weight_lb = weight ? weight->estimate.value : 0.0,
        .friction = f ? f->estimate.value : 0.0,
        .axle_load_lb = request->axle_load_lb,
    };
    if (push_ground_find(&push->readings, &push->setting, &push->ground, reader->error) != MR_OK)
        return reader->error->status;
    add_keys(request, reader, push);
    add_lines(reader, push);
    return MR_OK;
}

static void params_push_free(struct params_push *push)
{
    push_readings_free(&push->readings);
    push_ground_free(&push->ground);
}

static void params_push_answer(const struct params_push *push, struct answer *answer)
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

static enum mr_status params_push_plot(const struct params_request *request,
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

/* ---- readings ---- */

/* In the unit that the reading's name ends with, or as text with its own; NaN: neither. */
static double number_of(const char *name, const json_t *value)
{
    double number;
    struct quantity_wrong wrong;
    return quantity_json(value, quantity_unit_of_name(name), &number, &wrong) ? number
                                                                              : (double)NAN;
}

static bool is_number(const char *name, const json_t *value)
{
    return !isnan(number_of(name, value));
}

static bool is_reading(const char *name, const json_t *value)
{
    const json_t *list = json_object_get(value, "readings"),
                 *error = json_object_get(value, "error"), *entry;
    size_t i;
    if (is_number(name, value))
        return true;
    if (!json_is_object(value) || (error && !is_number(name, error)))
        return false;
    json_array_foreach(list, i, entry)
    {
        if (!is_number(name, entry))
            return false;
    }
    return json_array_size(list) > 0 ? json_array_size(list) <= READINGS_MAX
                                     : is_number(name, json_object_get(value, "value"));
}

/* A reading: a number (taken as exact), or {"value", "error"}, or {"readings": [...], "error"}.
 * Must be above 0. */
static enum mr_status take(struct params_reader *reader, const char *group, const char *name,
                           struct estimate *estimate)
{
    const json_t *value = json_object_get(json_object_get(reader->root, group), name);
    const json_t *list = json_object_get(value, "readings");
    const json_t *error = json_object_get(value, "error");
    double each = error ? number_of(name, error) : 0.0;
    double readings[READINGS_MAX];
    size_t count = 1;
    if (!value)
        return error_set(reader->error, MR_MALFORMED, "reading missing: %s: %s; give %s",
                         reader->path, group, name);
    if (!is_reading(name, value))
        return error_set(reader->error, MR_MALFORMED,
                         "no reading: %s: %s.%s; give a number, or text with a unit of it, "
                         "{\"value\": V, \"error\": E} or "
                         "{\"readings\": [at most %d numbers]}",
                         reader->path, group, name, READINGS_MAX);
    if (!(each >= 0.0))
        return error_set(reader->error, MR_MALFORMED,
                         "reading out of range: %s: %s.%s has error %g; give 0 or more",
                         reader->path, group, name, each);
    if (is_number(name, value))
        readings[0] = number_of(name, value);
    else if (list)
        for (count = 0; count < json_array_size(list); count++)
            readings[count] = number_of(name, json_array_get(list, count));
    else
        readings[0] = number_of(name, json_object_get(value, "value"));
    for (size_t i = 0; i < count; i++) {
        if (!(readings[i] > 0.0))
            return error_set(reader->error, MR_MALFORMED,
                             "reading out of range: %s: %s.%s is %g; give a number above 0",
                             reader->path, group, name, readings[i]);
    }
    *estimate = params_mean(readings, count, each);
    return MR_OK;
}

/* A list of numbers, for a slope. */
static enum mr_status take_list(struct params_reader *reader, const char *group, const char *name,
                                double factor, double *values, size_t *count)
{
    const json_t *list = json_object_get(json_object_get(reader->root, group), name);
    if (!json_is_array(list) || json_array_size(list) > READINGS_MAX)
        return error_set(reader->error, MR_MALFORMED,
                         "list missing: %s: %s; give %s, at most %d numbers", reader->path, group,
                         name, READINGS_MAX);
    *count = json_array_size(list);
    for (size_t i = 0; i < *count; i++) {
        if (!is_number(name, json_array_get(list, i)))
            return error_set(reader->error, MR_MALFORMED,
                             "not a number: %s: %s.%s[%zu]; give numbers", reader->path, group,
                             name, i);
        values[i] = factor * number_of(name, json_array_get(list, i));
    }
    return MR_OK;
}

static enum mr_status same_length(struct params_reader *reader, const char *group, size_t a,
                                  size_t b)
{
    if (a != b)
        return error_set(reader->error, MR_MALFORMED,
                         "lists of different lengths: %s: %s has %zu and %zu; give pairs",
                         reader->path, group, a, b);
    return MR_OK;
}

static bool has(const struct params_reader *reader, const char *group, const char *name)
{
    return json_object_get(json_object_get(reader->root, group), name) != NULL;
}

static enum mr_status read_inertia(struct params_reader *reader)
{
    struct estimate weight, spacing, cord, period;
    if (take(reader, "inertia", "weight_lb", &weight) != MR_OK ||
        take(reader, "inertia", "spacing_ft", &spacing) != MR_OK ||
        take(reader, "inertia", "cord_ft", &cord) != MR_OK ||
        take(reader, "inertia", "period_s", &period) != MR_OK)
        return reader->error->status;
    params_add(reader, "W", "lb", "weighing", weight);
    params_add(reader, "I", "slug ft2", "period on two cords",
               params_inertia(weight, spacing, cord, period));
    return MR_OK;
}

static enum mr_status refuse_travel(struct params_reader *reader, const char *group,
                                    const struct params_travel *travel, size_t count,
                                    const char *y_unit)
{
    return error_set(reader->error, MR_TOO_FEW,
                     "no spring beyond a free travel: %s: %s: %zu of %zu readings lie beyond it, "
                     "scatter %.2g %s; check the signs, and give three or more beyond",
                     reader->path, group, travel->beyond, count, travel->scatter, y_unit);
}

/* "WHAT", or "WHAT, 4 of 7 readings beyond the free travel". */
static const char *from_travel(struct params_reader *reader, const char *what,
                               const struct params_travel *travel, size_t count)
{
    char *text = reader->from[reader->count];
    if (travel->beyond == count)
        snprintf(text, sizeof reader->from[0], "%s", what);
    else
        snprintf(text, sizeof reader->from[0], "%s, %zu of %zu readings beyond the free travel",
                 what, travel->beyond, count);
    return text;
}

/* Either the slope itself, or forces and stretches of a strip. */
static enum mr_status read_tension(struct params_reader *reader)
{
    struct estimate slope, joint, strip;
    const char *from = "joint pulled";
    if (take(reader, "tension", "joint_in", &joint) != MR_OK)
        return reader->error->status;
    if (has(reader, "tension", "slope_lb_in_in")) {
        if (take(reader, "tension", "slope_lb_in_in", &slope) != MR_OK)
            return reader->error->status;
    } else {
        double force[READINGS_MAX], stretch[READINGS_MAX];
        size_t forces, stretches;
        struct params_travel travel;
        if (take(reader, "tension", "strip_in", &strip) != MR_OK ||
            take_list(reader, "tension", "force_lb", 1.0, force, &forces) != MR_OK ||
            take_list(reader, "tension", "stretch_in", 1.0, stretch, &stretches) != MR_OK ||
            same_length(reader, "tension", forces, stretches) != MR_OK ||
            params_travel(stretch, force, forces, &travel, reader->error) != MR_OK)
            return reader->error->status;
        if (!travel.known)
            return refuse_travel(reader, "tension", &travel, forces, "lb");
        slope = params_friction(travel.k, strip); /* a quotient */
        from = from_travel(reader, from, &travel, forces);
    }
    params_add(reader, "KL", "lb/ft", from, params_joint_stiffness(slope, joint));
    return MR_OK;
}

static enum mr_status read_hinge(struct params_reader *reader)
{
    double angle[READINGS_MAX], moment[READINGS_MAX];
    size_t angles, moments;
    struct params_travel travel;
    struct estimate wider = {1.0, 0.0}, strip, joint;
    if (take_list(reader, "hinge", "angle_deg", RAD_PER_DEG, angle, &angles) != MR_OK ||
        take_list(reader, "hinge", "moment_ft_lb", 1.0, moment, &moments) != MR_OK ||
        same_length(reader, "hinge", angles, moments) != MR_OK)
        return reader->error->status;
    for (size_t i = 0; i < angles; i++) {
        if (!(angle[i] >= 0.0))
            return error_set(
                reader->error, MR_MALFORMED,
                "angle below 0: %s: hinge: %g degrees; give each way of turning on its own, from 0",
                reader->path, angle[i] / RAD_PER_DEG);
    }
    if (has(reader, "hinge", "strip_in")) {
        if (take(reader, "hinge", "strip_in", &strip) != MR_OK ||
            take(reader, "hinge", "joint_in", &joint) != MR_OK)
            return reader->error->status;
        wider = params_friction(joint, strip);
    }
    if (params_travel(angle, moment, angles, &travel, reader->error) != MR_OK)
        return reader->error->status;
    if (!travel.known)
        return refuse_travel(reader, "hinge", &travel, angles, "ft lb");
    struct estimate tad = {travel.free.value / RAD_PER_DEG, travel.free.error / RAD_PER_DEG};
    if (tad.value < -3.0 * tad.error)
        return error_set(reader->error, MR_MALFORMED,
                         "a moment without turning: %s: hinge: the readings' line meets no moment "
                         "at %.3g +- %.2g degrees; check "
                         "where angle and moment are 0",
                         reader->path, tad.value, tad.error);
    tad.value = fmax(0.0, tad.value); /* below 0 by less than its error */
    params_add(reader, "KT", "ft lb/rad",
               from_travel(reader, "slope of moment against angle", &travel, angles),
               params_hinge_stiffness(travel.k, wider));
    params_add(reader, "TAD_deg", "deg",
               from_travel(reader, "angle without moment", &travel, angles), tad);
    return MR_OK;
}

static enum mr_status read_pull(struct params_reader *reader)
{
    struct estimate pull, weight;
    if (take(reader, "pull", "pull_lb", &pull) != MR_OK ||
        take(reader, "pull", "weight_lb", &weight) != MR_OK)
        return reader->error->status;
    params_add(reader, "f", "1", "pulling", params_friction(pull, weight));
    return MR_OK;
}

static enum mr_status read_deflection(struct params_reader *reader)
{
    struct estimate load, deflection, mats = {1.0, 0.0};
    if (take(reader, "deflection", "load_lb", &load) != MR_OK ||
        take(reader, "deflection", "deflection_in", &deflection) != MR_OK ||
        (has(reader, "deflection", "mats") && take(reader, "deflection", "mats", &mats) != MR_OK))
        return reader->error->status;
    deflection.value /= IN_PER_FT;
    deflection.error /= IN_PER_FT;
    params_add(reader, "KV", "lb/ft", "static deflection",
               params_soil(load, deflection, mats.value));
    return MR_OK;
}

static const struct group {
    const char *name;
    enum mr_status (*read)(struct params_reader *reader);
    const char *names; /* that it may hold */
} groups[] = {
    {"inertia", read_inertia, " weight_lb spacing_ft cord_ft period_s "},
    {"tension", read_tension, " joint_in slope_lb_in_in strip_in force_lb stretch_in "},
    {"hinge", read_hinge, " angle_deg moment_ft_lb strip_in joint_in "},
    {"pull", read_pull, " pull_lb weight_lb "},
    {"deflection", read_deflection, " load_lb deflection_in mats "},
};
#define GROUPS (sizeof groups / sizeof groups[0])

/* A misspelt name would be left out in silence: refuse it. */
static enum mr_status check_names(struct params_reader *reader)
{
    const char *key, *name;
    json_t *value, *inner;
    json_object_foreach((json_t *)reader->root, key, value)
    {
        const struct group *group = NULL;
        for (size_t i = 0; i < GROUPS; i++) {
            if (strcmp(groups[i].name, key) == 0)
                group = &groups[i];
        }
        if (key[0] == '_')
            continue;
        if (group && !json_is_object(value))
            return error_set(reader->error, MR_MALFORMED,
                             "wrong type: %s: %s; give an object with%s", reader->path, key,
                             group->names);
        if (!group)
            return error_set(
                reader->error, MR_MALFORMED,
                "unknown test: %s: \"%s\"; tests are inertia, tension, hinge, pull, deflection",
                reader->path, key);
        json_object_foreach(value, name, inner)
        {
            char padded[64];
            snprintf(padded, sizeof padded, " %s ", name);
            if (name[0] != '_' && !strstr(group->names, padded))
                return error_set(reader->error, MR_MALFORMED,
                                 "unknown reading: %s: %s: \"%s\"; it has%s", reader->path, key,
                                 name, group->names);
        }
    }
    return MR_OK;
}

static enum mr_status read_all(struct params_reader *reader)
{
    if (check_names(reader) != MR_OK)
        return reader->error->status;
    for (size_t i = 0; i < GROUPS; i++) {
        if (json_object_get(reader->root, groups[i].name) && groups[i].read(reader) != MR_OK)
            return reader->error->status;
    }
    for (size_t i = 0; i < reader->count; i++) {
        const struct params_found *p = &reader->parameters[i];
        if (!isfinite(p->estimate.value) || !isfinite(p->estimate.error))
            return error_set(reader->error, MR_NUMERICS,
                             "beyond all numbers: %s: %s (%s); check the readings", reader->path,
                             p->key, p->from);
    }
    if (reader->count == 0)
        return error_set(reader->error, MR_MALFORMED, "no readings: %s; see matrig params --help",
                         reader->path);
    return MR_OK;
}

/* Scene keys with the errors in comment keys. */
static json_t *scene_of(const struct params_reader *reader)
{
    json_t *scene = json_object();
    for (size_t i = 0; i < reader->count; i++) {
        const struct params_found *p = &reader->parameters[i];
        char key[24], text[200];
        snprintf(key, sizeof key, "_%s", p->key);
        if (p->given)
            snprintf(text, sizeof text, "%s", p->from);
        else if (p->estimate.error > 0.0)
            snprintf(text, sizeof text, "from %s, standard error %.2g %s", p->from,
                     p->estimate.error, p->unit);
        else
            snprintf(text, sizeof text, "from %s, error unknown: no reading states one", p->from);
        json_object_set_new(scene, p->key, cli_json_number(p->estimate.value, 6));
        json_object_set_new(scene, key, json_string(text));
    }
    return scene;
}

static json_t *found_json(const struct params_found *p)
{
    bool known = p->estimate.error > 0.0; /* one that nobody stated is not 0 */
    json_t *json = json_pack("{s:o,s:o,s:s,s:s}", "value", cli_json_number(p->estimate.value, 12),
                             "error", known ? cli_json_number(p->estimate.error, 6) : json_null(),
                             "unit", p->unit, "from", p->from);
    if (!isnan(p->low)) {
        json_object_set_new(json, "low", cli_json_number(p->low, 6));
        json_object_set_new(json, "high", cli_json_number(p->high, 6));
    }
    return json;
}

static void print_found(const struct params_found *p)
{
    char error[32] = "error unknown", interval[60] = "";
    if (p->given)
        error[0] = '\0';
    else if (p->estimate.error > 0.0)
        snprintf(error, sizeof error, "+- %-10.2g", p->estimate.error);
    if (!isnan(p->low))
        snprintf(interval, sizeof interval, "; 95 %%: %.4g to %.4g", p->low, p->high);
    printf("%-14s %12.6g %-13s %-10s %s%s\n", p->key, p->estimate.value, error, p->unit, p->from,
           interval);
}

static enum mr_status write_scene(const struct params_request *r, json_t *scene,
                                  struct error *error)
{
    struct output output;
    if (!r->output_path || output_begin(&output, r->output_path, error) != MR_OK)
        return error->status;
    json_dumpf(scene, output.file, JSON_INDENT(2) | JSON_PRESERVE_ORDER);
    fputc('\n', output.file);
    return output_end(&output, error);
}

/* `push`: NULL: none. */
static int show(const struct params_reader *reader, const struct params_request *r,
                const struct params_push *push, const struct cli *cli)
{
    struct error error = {0};
    json_t *scene = scene_of(reader), *list = json_object(), *root;
    struct answer *answer = push ? answer_new(false) : NULL;
    for (size_t i = 0; i < reader->count; i++) {
        const struct params_found *p = &reader->parameters[i];
        json_object_set_new(list, p->key, found_json(p));
        if (!cli->json)
            print_found(p);
    }
    if (push)
        params_push_answer(push, answer);
    if (write_scene(r, scene, &error) == MR_OK && push && r->plot_path)
        params_push_plot(r, push, &error);
    int code = error.status != MR_OK ? cli_fail(&error) : 0;
    if (cli->json && code == 0) {
        root = json_pack("{s:O,s:O}", "parameters", list, "scene", scene);
        if (push)
            json_object_set_new(root, "push", answer_json(answer));
        code = cli_print_json(root, code);
    } else if (push && code == 0 && !answer_text(answer, stdout))
        code = cli_fail_output();
    answer_free(answer);
    json_decref(list);
    json_decref(scene);
    return code;
}

static json_t *load(const char *path, struct error *error)
{
    json_error_t where;
    FILE *file = fopen(path, "rb");
    if (!file) {
        error_set(error, MR_IO, "cannot open readings: %s; check the path", path);
        return NULL;
    }
    json_t *root = json_loadf(file, JSON_REJECT_DUPLICATES, &where);
    fclose(file);
    if (!root)
        error_set(error, MR_MALFORMED,
                  "no JSON object: %s: line %d column %d: %s; see matrig params --help", path,
                  where.line, where.column, where.text);
    else if (!json_is_object(root))
        error_set(error, MR_MALFORMED,
                  "no JSON object: %s: it begins with [; see matrig params --help", path);
    return root;
}

/* Before anything is read: files that would be written over. */
static enum mr_status check_outputs(const struct params_request *r, const char *path,
                                    struct error *error)
{
    if ((r->plot_path || r->mats > 0) && !r->push_path)
        return error_set(error, MR_USAGE,
                         "%s without a push test: add --push F.csv, or leave it out",
                         r->plot_path ? "--plot" : "--mats");
    if (!path && !r->push_path)
        return error_set(error, MR_USAGE,
                         "nothing to read: give READINGS, --push F.csv or both; see matrig params "
                         "--help");
    if (output_check(r->output_path, path, error) == MR_OK &&
        output_keep(r->output_path, r->force, error) == MR_OK &&
        output_not_input(r->output_path, r->push_path, error) == MR_OK)
        plot_check(r->plot_path, path, error);
    return error->status;
}

static int params_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[1];
    struct params_request r = {0};
    struct params_push push = {0};
    struct error error = {0};
    if (command_parse(&command_params, argc, argv, cli, &r, words, &error) != MR_OK ||
        check_outputs(&r, words[0], &error) != MR_OK)
        return cli_fail(&error);
    json_t *root = words[0] ? load(words[0], &error) : NULL;
    struct params_reader reader = {.path = words[0], .root = root, .error = &error};
    if (error.status == MR_OK && root)
        read_all(&reader);
    if (error.status == MR_OK && r.push_path)
        params_push_find(&r, &reader, &push);
    int code = error.status != MR_OK ? cli_fail(&error)
                                     : show(&reader, &r, r.push_path ? &push : NULL, cli);
    params_push_free(&push);
    json_decref(root);
    return code;
}

#define VALUES struct params_request
static const struct command_part parts[] = {
    HELP_ITEM(
        "READINGS",
        "JSON with any of these tests; a reading is a number, {\"value\": V, \"error\": E} or\n"
        "{\"readings\": [...], \"error\": E}, with standard errors\n"
        "inertia     weight_lb, spacing_ft and cord_ft of two cords, period_s of turning: W and I\n"
        "tension     joint_in, slope_lb_in_in; or joint_in, strip_in, lists force_lb, stretch_in: "
        "KL\n"
        "hinge       lists angle_deg, moment_ft_lb [, strip_in, joint_in]: KT and TAD_deg\n"
        "            (readings within the free travel are found and left out; three or more must "
        "lie beyond)\n"
        "pull        pull_lb, weight_lb: f\n"
        "deflection  load_lb, deflection_in [, mats]: KV"),
    OPTION_TEXT("-o", "F", output_path, "write the parameters as the beginning of a scene"),
    OPTION_FORCE(force),
    HELP_NOTE("\nPush tests, how a loaded mat gives way along the runway: gear_k_lb_ft, "
              "gear_unloading, gear_axle_law, f"),
    OPTION_TEXT("--push", "F.csv", push_path,
                "rows in the order read; the first line names the columns with their units:\n"
                "test,load (lb),force (lb),displacement (in). Also N, kg, mm; see "
                "docs/howto/push-test.md"),
    OPTION_WHOLE("--mats", "N", mats, 1, PUSH_MATS_MOST, 0,
                 "how many mats the load pressed, and that moved as one: k is of one of them"),
    OPTION_TEXT("--plot", "F", plot_path, "draw each test with both laws (.svg, .png, .pdf)"),
    OPTION_NUMBER("--axle-load", "LB", axle_load_lb, "lb", 1e-3, 1e9, 0.0,
                  "what one axle stands with on the strip; else the least load tested"),
    OPTION_NUMBER("--force-error", "LB", force_error_lb, "lb", 1e-6, 1e6, 0.5,
                  "standard error of a force; else {standard}"),
    OPTION_NUMBER("--dial-error", "IN", moved_error_in, "in", 1e-7, 10.0, 0.001,
                  "standard error of a displacement; else {standard}"),
    HELP_NOTE("Units are those of the scene keys (ft, lb, slug, s), also with --si."),
    HELP_EXAMPLE("matrig params readings.json -o scene.json"),
    HELP_EXAMPLE("matrig params --push push.csv --mats 2 --plot push.svg"),
};

const struct command command_params = {
    "params",
    params_command,
    "[READINGS] [--push F.csv --mats N] [-o F] ...",
    "readings of simple tests to scene parameters",
    COMMAND_PARTS(parts),
    {0, 1, "READINGS"},
};
