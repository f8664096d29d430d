/* The command matrig params: computes scene parameters from the measurements of section 3.4. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/analyse/inspection.h"
#include "host/analyse/params.h"
#include "host/base/answer.h"
#include "host/base/output.h"
#include "host/base/plot.h"
#include "host/base/quantity.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/landing_series/series.h"
#include "host/push/ground.h"

#define READINGS_MAX   1000
#define IN_PER_FT      12.0
#define RAD_PER_DEG    (M_PI / 180.0)
#define PARAMETERS_MAX 16

struct parameter {
    const char *key; /* key of the parameter in a scene */
    const char *unit;
    char source[PUSH_REASON_SIZE];
    struct estimate estimate;
    double low, high; /* 95 % interval; NaN: 1.96 standard errors on either side */
    bool is_given;    /* the value was given without a measurement, so it has no error */
    json_t *profile;  /* list of values along the runway, in the form of a scene; NULL: one value */
};

struct params_request {
    const char *output_path, *push_path, *plot_path;
    int64_t mats;
    double axle_load_lb, force_error_lb, displacement_error_in;
    bool force;
};

struct reader {
    const char *path;
    const char *test; /* name of the test, such as "inertia" */
    const json_t *readings;
    struct parameter parameters[PARAMETERS_MAX];
    size_t count;
};

struct push_tests {
    struct push_readings readings;
    struct push_setting setting;
    struct push_ground ground;
};

/* Adds a parameter and returns it. The callers add at most PARAMETERS_MAX. */
static struct parameter *add_parameter(struct reader *r, const char *key, const char *unit,
                                       const char *from, struct estimate estimate)
{
    struct parameter *found = &r->parameters[r->count];
    *found = (struct parameter){key, unit, "", estimate, (double)NAN, (double)NAN, false, NULL};
    snprintf(found->source, sizeof found->source, "%s", from);
    for (size_t i = 0; i < r->count; i++)
        if (strcmp(r->parameters[i].key, key) == 0)
            error_set(fatal, MR_MALFORMED, "two tests give %s: %s: %s, %s; leave one out", key,
                      r->path, r->parameters[i].source, from);
    if (!isfinite(estimate.value) || !isfinite(estimate.error))
        error_set(fatal, MR_NUMERICS,
                  "the readings give no finite result: %s: %s (%s); check the readings", r->path,
                  key, from);
    else
        r->count++;
    return found;
}

static const struct parameter *find_parameter(const struct reader *r, const char *key)
{
    for (size_t i = 0; i < r->count; i++) {
        if (strcmp(r->parameters[i].key, key) == 0)
            return &r->parameters[i];
    }
    return NULL;
}

/* ---- push tests ---- */

#define Z_95                1.96
/* Lower limit of the scene key gear_unloading, which must be above 0. */
#define UNLOADING_RATIO_MIN 0.01
#define AXLE_EXPONENT_MAX   2.0

/* Adds a parameter of the push test. Value and interval are clamped to the limits of the scene
 * key. */
static void add_push_parameter(struct reader *r, const char *key, const char *unit,
                               const struct push_parameter *told, double least, double most)
{
    const struct push_interval *of = &told->interval;
    if (isnan(of->value) || find_parameter(r, key))
        return;
    struct parameter *found = add_parameter(
        r, key, unit, told->reason,
        (struct estimate){fmin(most, fmax(least, of->value)), (of->high - of->low) / (2.0 * Z_95)});
    found->low = fmin(most, fmax(least, of->low));
    found->high = fmin(most, fmax(least, of->high));
}

static void read_push(const struct params_request *request, struct reader *r,
                      struct push_tests *push)
{
    const struct parameter *weight = find_parameter(r, "W");
    const struct push_ground *ground = &push->ground;
    if (request->mats == 0)
        error_set(fatal, MR_USAGE,
                  "number of mats unknown: %s does not state how many mats the load presses; give "
                  "--mats 1 or --mats 2 (k is the stiffness of one mat)",
                  request->push_path);
    push_readings_load(request->push_path, &push->readings, fatal);
    push->setting = (struct push_setting){
        .gage_errors = {request->force_error_lb, request->displacement_error_in},
        .mat_count = (unsigned)request->mats,
        .mat_weight_lb = weight ? weight->estimate.value : 0.0,
        .axle_load_lb = request->axle_load_lb,
    };
    push_ground_estimate(&push->readings, &push->setting, &push->ground, fatal);
    add_push_parameter(r, "f", "1", &ground->friction, 0.0, HUGE_VAL);
    if (ground->law != PUSH_ELASTIC || isnan(ground->k_lb_ft.interval.value))
        return; /* other keys exist only for an elastic law */
    add_push_parameter(r, "gear_k_lb_ft", "lb/ft", &ground->k_lb_ft, 0.0, HUGE_VAL);
    add_push_parameter(r, "gear_unloading", "1", &ground->unloading_ratio, UNLOADING_RATIO_MIN,
                       1.0);
    add_push_parameter(r, "gear_axle_law", "1", &ground->axle_law, 0.0, AXLE_EXPONENT_MAX);
    add_parameter(r, "wheel_load", "lb",
                  request->axle_load_lb > 0.0 ? "--axle-load" : "smallest load tested, per axle",
                  (struct estimate){ground->axle_load_lb, 0.0})
        ->is_given = true;
}

/* Plots the rigid law: vertical at displacement 0; if the mat slid, then along the limit of the
 * force. */
static void plot_rigid_law(struct plot *plot, const struct push_series *series,
                           const struct push_fit *fit)
{
    double top_lb = 0.0, right_in = fit->dial_zero_in;
    bool known = fit->slid_count > 0;
    for (size_t i = 0; i < series->count; i++) {
        top_lb = fmax(top_lb, series->force_lb[i]);
        right_in = fmax(right_in, series->displacement_in[i]);
    }
    if (known)
        top_lb = fabs(fit->slide_force_lb);
    plot_add_series(
        plot, &(struct plot_series){.kind = PLOT_LINE,
                                    .key = known ? "rigid up to the limit of Coulomb friction"
                                                 : "Coulomb, rigid",
                                    .colour = 5,
                                    .is_dashed = true,
                                    .x = (double[]){fit->dial_zero_in, fit->dial_zero_in, right_in},
                                    .y = (double[]){0.0, top_lb, top_lb},
                                    .count = known ? 3 : 2});
}

static void plot_push(const struct params_request *request, const struct push_tests *push)
{
    const struct push_readings *readings = &push->readings;
    double law_in[PUSH_READINGS_MAX];
    unsigned rows = (unsigned)(readings->count + 1) / 2;
    struct plot *plot = plot_new(request->push_path, 1000, 60 + 380 * rows, 2);
    for (size_t i = 0; i < readings->count; i++) {
        const struct push_series *series = &readings->series[i];
        const struct push_fit *fit = &push->ground.fit[i];
        char title[PUSH_NAME_SIZE + 40];
        snprintf(title, sizeof title, "test %s, %.4g lb", series->name, series->load_lb);
        plot_begin_panel(plot, title, (struct plot_axis){.label = "displacement (in)"},
                         (struct plot_axis){.label = "force (lb)"});
        plot_add_series(plot, &(struct plot_series){.kind = PLOT_LINE_POINTS,
                                                    .key = "read",
                                                    .colour = PLOT_GREY,
                                                    .x = series->displacement_in,
                                                    .y = series->force_lb,
                                                    .count = series->count});
        push_fit_curve(series, push->setting.gage_errors, fit, law_in);
        plot_add_series(plot, &(struct plot_series){.kind = PLOT_LINE,
                                                    .key = isnan(fit->k_lb_in.value)
                                                             ? "elastic, smallest stiffness"
                                                             : "elastic ground",
                                                    .colour = 1,
                                                    .x = law_in,
                                                    .y = series->force_lb,
                                                    .count = series->count});
        plot_rigid_law(plot, series, fit);
    }
    plot_write(plot, request->plot_path, fatal);
}

/* ---- readings ---- */

/* Reads a number. A plain number is in the unit at the end of `name`; a text has its own unit.
 * Returns NaN if `value` is neither. */
static double read_number(const char *name, const json_t *value)
{
    double number;
    struct quantity_error wrong;
    return quantity_read_json(value, quantity_unit_from_name(name), &number, &wrong) ? number
                                                                                     : (double)NAN;
}

static bool has_key(const struct reader *r, const char *name)
{
    return json_object_get(r->readings, name) != NULL;
}

/* Reads a measurement: an exact number, {"value", "error"}, or {"readings": [...], "error"}. */
static struct estimate read_estimate(struct reader *r, const char *name)
{
    const json_t *value = json_object_get(r->readings, name),
                 *list = json_object_get(value, "readings"),
                 *error = json_object_get(value, "error");
    double each = error ? read_number(name, error) : 0.0, readings[READINGS_MAX];
    size_t count = list ? json_array_size(list) : 1;
    bool good = count > 0 && count <= READINGS_MAX && each >= 0.0;
    for (size_t i = 0; i < count && good; i++) {
        readings[i] = read_number(name, list                    ? json_array_get(list, i)
                                        : json_is_object(value) ? json_object_get(value, "value")
                                                                : value);
        good = readings[i] > 0.0;
    }
    if (good)
        return params_compute_mean(readings, count, each);
    if (!value)
        error_set(fatal, MR_MALFORMED, "reading missing: %s: %s; give %s", r->path, r->test, name);
    else
        error_set(
            fatal, MR_MALFORMED,
            "not a reading: %s: %s.%s; give a number above 0, or text with a unit, {\"value\": V, "
            "\"error\": E} or {\"readings\": [at most %d numbers], \"error\": E}, with E 0 or more",
            r->path, r->test, name, READINGS_MAX);
    return (struct estimate){1.0, 0.0};
}

/* Reads two lists whose values form pairs; the values of the first are multiplied by `factor`.
 * Returns the number of pairs. */
static size_t read_pairs(struct reader *r, const char *x_name, double factor, const char *y_name,
                         double x[READINGS_MAX], double y[READINGS_MAX])
{
    const json_t *lists[] = {json_object_get(r->readings, x_name),
                             json_object_get(r->readings, y_name)};
    size_t count = json_array_size(lists[0]);
    bool good = count <= READINGS_MAX && json_array_size(lists[1]) == count;
    for (size_t i = 0; i < count && good; i++) {
        x[i] = factor * read_number(x_name, json_array_get(lists[0], i));
        y[i] = read_number(y_name, json_array_get(lists[1], i));
        good = !isnan(x[i]) && !isnan(y[i]);
    }
    if (!good || count == 0)
        error_set(fatal, MR_MALFORMED,
                  "readings do not form pairs: %s: %s has lists of %zu and %zu values; give %s and "
                  "%s as lists of equal length with at most %d numbers",
                  r->path, r->test, count, json_array_size(lists[1]), x_name, y_name, READINGS_MAX);
    return count;
}

/* Reads two lists of pairs and fits a spring law to them. */
static struct params_spring_fit read_spring(struct reader *r, const char *x_name, double factor,
                                            const char *y_name, const char *y_unit)
{
    double x[READINGS_MAX], y[READINGS_MAX];
    struct params_spring_fit spring = {.stiffness = {1.0, 0.0}};
    size_t count = read_pairs(r, x_name, factor, y_name, x, y);
    params_fit_spring(x, y, count, &spring, fatal);
    if (spring.free_travel_readings)
        error_set(fatal, MR_MALFORMED,
                  "readings within the free travel: %s: %s: %zu of %zu readings are below the "
                  "start of the fitted line; leave out readings with free movement",
                  r->path, r->test, spring.free_travel_readings, count);
    else if (!spring.is_known)
        error_set(fatal, MR_TOO_FEW,
                  "no stiffness: %s: %s: %zu readings with a scatter of %.2g %s about the fitted "
                  "line do not rise; check the signs, and add readings beyond the free travel",
                  r->path, r->test, count, spring.scatter, y_unit);
    return spring;
}

static void read_inertia(struct reader *r)
{
    struct estimate weight = read_estimate(r, "weight_lb"),
                    spacing = read_estimate(r, "spacing_ft"), cord = read_estimate(r, "cord_ft"),
                    period = read_estimate(r, "period_s");
    add_parameter(r, "W", "lb", "weighing", weight);
    add_parameter(r, "I", "slug ft2", "period of oscillation on two cords",
                  params_compute_inertia(weight, spacing, cord, period));
}

/* Reads the slope of force over strain, or forces and stretches of a strip. */
static void read_tension(struct reader *r)
{
    struct estimate joint = read_estimate(r, "joint_in"), slope;
    if (has_key(r, "slope_lb_in_in")) {
        slope = read_estimate(r, "slope_lb_in_in");
    } else {
        struct estimate strip = read_estimate(r, "strip_in");
        struct params_spring_fit spring = read_spring(r, "stretch_in", 1.0, "force_lb", "lb");
        /* params_compute_friction is used here for its quotient */
        slope = params_compute_friction(spring.stiffness, strip);
    }
    add_parameter(r, "KL", "lb/ft", "joint pulled", params_compute_joint_stiffness(slope, joint));
}

static void read_hinge(struct reader *r)
{
    struct estimate wider = {1.0, 0.0};
    size_t i;
    json_t *angle;
    json_array_foreach(json_object_get(r->readings, "angle_deg"), i, angle)
    {
        if (read_number("angle_deg", angle) < 0.0)
            error_set(fatal, MR_MALFORMED,
                      "negative angle: %s: hinge: %g degrees; give each direction of rotation as a "
                      "separate test, from 0",
                      r->path, read_number("angle_deg", angle));
    }
    if (has_key(r, "strip_in"))
        wider = params_compute_friction(read_estimate(r, "joint_in"), read_estimate(r, "strip_in"));
    struct params_spring_fit spring = read_spring(r, "angle_deg", RAD_PER_DEG, "moment_ft_lb",
                                                  "ft lb");
    struct estimate tad = {spring.free_travel.value / RAD_PER_DEG,
                           spring.free_travel.error / RAD_PER_DEG};
    if (tad.value < -3.0 * tad.error)
        error_set(fatal, MR_MALFORMED,
                  "moment without rotation: %s: hinge: the fitted line has zero moment at %.3g +- "
                  "%.2g degrees; check the zeros of angle and moment",
                  r->path, tad.value, tad.error);
    /* errors of the measurement can make a small value negative */
    tad.value = fmax(0.0, tad.value);
    add_parameter(r, "KT", "ft lb/rad", "slope of moment against angle",
                  params_compute_hinge_stiffness(spring.stiffness, wider));
    add_parameter(r, "TAD_deg", "deg", "angle without moment", tad);
}

static void read_pull(struct reader *r)
{
    add_parameter(
        r, "f", "1", "pulling",
        params_compute_friction(read_estimate(r, "pull_lb"), read_estimate(r, "weight_lb")));
}

/* Reads a length in inches and returns it in feet. */
static struct estimate read_inches_as_ft(struct reader *r, const char *name)
{
    struct estimate e = read_estimate(r, name);
    return (struct estimate){e.value / IN_PER_FT, e.error / IN_PER_FT};
}

static void read_deflection(struct reader *r)
{
    struct estimate load = read_estimate(r, "load_lb"), mats = has_key(r, "mats")
                                                                 ? read_estimate(r, "mats")
                                                                 : (struct estimate){1.0, 0.0};
    add_parameter(
        r, "KV", "lb/ft", "static deflection",
        params_compute_soil_stiffness(load, read_inches_as_ft(r, "deflection_in"), mats.value));
}

static void read_plate(struct reader *r)
{
    double settlement_ft[READINGS_MAX], load_lb[READINGS_MAX];
    size_t count = read_pairs(r, "settlement_in", 1.0 / IN_PER_FT, "load_lb", settlement_ft,
                              load_lb);
    struct estimate kv = {1.0, 0.0};
    params_compute_plate_soil_stiffness(load_lb, settlement_ft, count,
                                        read_inches_as_ft(r, "plate_in"),
                                        params_compute_mat_area(read_estimate(r, "mat_length_ft"),
                                                                read_estimate(r, "mat_width_ft")),
                                        &kv, fatal);
    add_parameter(r, "KV", "lb/ft", "plate bearing test", kv);
}

/* Reads the subgrade stiffness at each node. A node gets the value of the nearest plate test in the
 * acceptance records, or of the newest if several are equally near. Node n is at n - 1 mat lengths.
 * Each end of a mat carries half of the mat. */
static void read_subgrade(struct reader *r)
{
    char path[PATH_MAX];
    const char *records = json_string_value(json_object_get(r->readings, "records"));
    const struct estimate length_ft = read_estimate(r, "mat_length_ft"),
                          mat_ft2 = params_compute_mat_area(length_ft,
                                                            read_estimate(r, "mat_width_ft"));
    const int mats = (int)read_estimate(r, "mats").value;
    struct estimate mean = {0.0, 0.0}, k = {0.0, 0.0}, kv;
    struct inspections all;
    json_t *along = json_array();
    series_make_sibling_path(r->path, records ? records : "", path);
    inspection_load(program_open_campaign(path, STORE_READ), &all, fatal);
    for (int node = 0; node <= mats; node++) {
        double nearest_ft = HUGE_VAL;
        int64_t newest = 0;
        for (size_t i = 0; i < all.count; i++) {
            const struct inspection *entry = &all.entry[i];
            struct estimate bearing = inspection_get_number(entry->values, "bearing_lb_in3");
            double off_ft = fabs(entry->row.place - node * length_ft.value);
            if (!inspection_is_valid(entry, NULL, 0) || !(bearing.value > 0.0) ||
                off_ft > nearest_ft || (off_ft == nearest_ft && entry->origin < newest))
                continue;
            nearest_ft = off_ft;
            newest = entry->origin;
            /* half of the result of the plate test, converted to lb/ft3 */
            k = (struct estimate){864.0 * bearing.value, 864.0 * bearing.error};
        }
        if (isinf(nearest_ft))
            error_set(fatal, MR_MALFORMED,
                      "no plate test: %s: subgrade: %s; set records to a campaign with subgrade "
                      "records that have bearing_lb_in3",
                      r->path, path);
        kv = params_compute_mat_area(
            k, mat_ft2); /* params_compute_mat_area is used here for its product */
        json_array_append_new(along, cli_json_number(kv.value, 6));
        mean = (struct estimate){mean.value + kv.value / (mats + 1), fmax(mean.error, kv.error)};
    }
    inspection_free(&all);
    add_parameter(r, "KV", "lb/ft", "plate tests by station: mean and largest error", mean)
        ->profile = along;
}

static const struct laboratory_test {
    const char *name;
    void (*read)(struct reader *r);
    const char *reading_names; /* names that the test may have */
} tests[] = {
    {"inertia", read_inertia, " weight_lb spacing_ft cord_ft period_s "},
    {"tension", read_tension, " joint_in slope_lb_in_in strip_in force_lb stretch_in "},
    {"hinge", read_hinge, " angle_deg moment_ft_lb strip_in joint_in "},
    {"pull", read_pull, " pull_lb weight_lb "},
    {"deflection", read_deflection, " load_lb deflection_in mats "},
    {"plate", read_plate, " load_lb settlement_in plate_in mat_length_ft mat_width_ft "},
    {"subgrade", read_subgrade, " records mats mat_length_ft mat_width_ft "},
};

/* Reads one test. Refuses unknown names, so that a misspelt measurement is not ignored. */
static void read_test(struct reader *r, const char *name, const json_t *readings)
{
    const struct laboratory_test *test = NULL;
    const char *key;
    json_t *value;
    for (size_t i = 0; i < sizeof tests / sizeof tests[0]; i++)
        test = strcmp(tests[i].name, name) == 0 ? &tests[i] : test;
    if (!test || !json_is_object(readings))
        error_set(fatal, MR_MALFORMED,
                  "unknown test: %s: \"%s\"; give objects named inertia, tension, hinge, pull, "
                  "deflection, plate or subgrade",
                  r->path, name);
    json_object_foreach((json_t *)(uintptr_t)readings, key, value)
    {
        char padded[64];
        snprintf(padded, sizeof padded, " %s ", key);
        if (key[0] != '_' && !strstr(test->reading_names, padded))
            error_set(fatal, MR_MALFORMED, "unknown reading: %s: %s: \"%s\"; this test has%s",
                      r->path, name, key, test->reading_names);
    }
    r->test = name;
    r->readings = readings;
    test->read(r);
}

static void read_file(struct reader *r)
{
    json_error_t where;
    const char *name;
    json_t *readings, *root = json_load_file(r->path, JSON_REJECT_DUPLICATES, &where);
    if (!root && json_error_code(&where) == json_error_cannot_open_file)
        error_set(fatal, MR_IO, "cannot open readings: %s; check the path", r->path);
    else if (!root)
        error_set(fatal, MR_MALFORMED,
                  "not a JSON object: %s: line %d column %d: %s; see matrig params --help", r->path,
                  where.line, where.column, where.text);
    json_object_foreach(root, name, readings)
    {
        if (name[0] != '_')
            read_test(r, name, readings);
    }
    if (r->count == 0)
        error_set(fatal, MR_MALFORMED,
                  "no readings: %s: the file has none of the tests (inertia, tension, ...); see "
                  "matrig params --help",
                  r->path);
    json_decref(root);
}

/* ---- results ---- */

/* Makes the scene keys. The errors are added as comments (keys that begin with _). */
static json_t *make_scene(const struct reader *r)
{
    json_t *scene = json_object();
    for (size_t i = 0; i < r->count; i++) {
        const struct parameter *p = &r->parameters[i];
        char key[24], text[PUSH_REASON_SIZE + 80];
        snprintf(key, sizeof key, "_%s", p->key);
        if (p->is_given)
            snprintf(text, sizeof text, "%s", p->source);
        else if (p->estimate.error > 0.0)
            snprintf(text, sizeof text, "from %s, standard error %.2g %s", p->source,
                     p->estimate.error, p->unit);
        else
            snprintf(text, sizeof text, "from %s; the readings do not determine the standard error",
                     p->source);
        json_object_set_new(scene, p->key,
                            p->profile ? p->profile : cli_json_number(p->estimate.value, 6));
        json_object_set_new(scene, key, json_string(text));
    }
    return scene;
}

static void add_parameter_row(struct answer *answer, const struct parameter *p)
{
    bool known = p->estimate.error > 0.0; /* an error of 0 means that none was given */
    char error[32] = "error unknown", interval[60] = "";
    if (p->is_given)
        error[0] = '\0';
    else if (known)
        snprintf(error, sizeof error, "+- %-10.2g", p->estimate.error);
    if (!isnan(p->low))
        snprintf(interval, sizeof interval, "; 95 %%: %.4g to %.4g", p->low, p->high);
    answer_add_text(answer, NULL, p->key, "%12.6g %-13s %-10s %s%s", p->estimate.value, error,
                    p->unit, p->source, interval);
    json_t *json = json_pack("{s:o,s:o,s:s,s:s}", "value", cli_json_number(p->estimate.value, 12),
                             "error", known ? cli_json_number(p->estimate.error, 6) : json_null(),
                             "unit", p->unit, "from", p->source);
    if (!isnan(p->low)) {
        json_object_set_new(json, "low", cli_json_number(p->low, 6));
        json_object_set_new(json, "high", cli_json_number(p->high, 6));
    }
    answer_add_json(answer, p->key, json);
}

static struct answer *make_answer(const struct reader *r, json_t *scene,
                                  const struct push_tests *push)
{
    struct answer *answer = answer_new(false);
    answer_open_group(answer, "parameters", "");
    for (size_t i = 0; i < r->count; i++)
        add_parameter_row(answer, &r->parameters[i]);
    answer_close_group(answer);
    answer_add_json(answer, "scene", json_incref(scene));
    if (push) {
        answer_open_group(answer, "push", "");
        push_add_law(answer, &push->ground, &push->setting);
        push_add_tests(answer, &push->readings, &push->ground);
        answer_close_group(answer);
    }
    return answer;
}

/* Refuses output files that already exist, before any input is read. */
static void check_outputs(const struct params_request *r, const char *path)
{
    if ((r->plot_path || r->mats > 0) && !r->push_path)
        error_set(fatal, MR_USAGE,
                  "%s without a push test: add --push F.csv, or leave the option out",
                  r->plot_path ? "--plot" : "--mats");
    if (!path && !r->push_path)
        error_set(fatal, MR_USAGE,
                  "no readings: give READINGS, --push F.csv or both; see matrig params --help");
    output_check(r->output_path, path, fatal);
    output_check_new(r->output_path, r->force, fatal);
    output_check_not_input(r->output_path, r->push_path, fatal);
    plot_check(r->plot_path, path, fatal);
}

static int params_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[1];
    struct params_request r = {0};
    struct push_tests push = {0};
    command_parse(&command_params, argc, argv, cli, &r, words, fatal);
    check_outputs(&r, words[0]);
    struct reader reader = {.path = words[0]};
    if (words[0])
        read_file(&reader);
    if (r.push_path)
        read_push(&r, &reader, &push);
    json_t *scene = make_scene(&reader);
    if (r.output_path)
        output_write_json(r.output_path, scene, 17, fatal);
    if (r.plot_path)
        plot_push(&r, &push);
    struct answer *answer = make_answer(&reader, scene, r.push_path ? &push : NULL);
    json_decref(scene);
    push_readings_free(&push.readings);
    push_ground_free(&push.ground);
    return answer_print(cli, answer, 0);
}

#define OPTION_VALUES struct params_request
static const struct command_part parts[] = {
    HELP_ITEM("READINGS",
              "JSON with any of these tests. A reading is a number, {\"value\": V, \"error\": E} "
              "or {\"readings\": [...], \"error\": E}, where E is a standard error.\n  inertia     "
              "weight_lb, spacing_ft and cord_ft of two cords, period_s of the oscillation: gives "
              "W and I\n  tension     joint_in, slope_lb_in_in; or joint_in, strip_in, lists "
              "force_lb, stretch_in: gives KL\n  hinge       lists angle_deg, moment_ft_lb [, "
              "strip_in, joint_in]: gives KT and TAD_deg\n              (leave out readings within "
              "the free travel: they are refused)\n  pull        pull_lb, weight_lb: gives f\n  "
              "deflection  load_lb of one axle, deflection_in [, mats]: gives KV\n  plate       "
              "lists load_lb, "
              "settlement_in; plate_in (diameter), mat_length_ft, mat_width_ft: gives KV\n  "
              "subgrade    records (a campaign with plate tests by station, see matrig record), "
              "mats, mat_length_ft,\n              mat_width_ft: gives KV along the runway"),
    OPTION_TEXT("-o", "F.json", output_path, "write the parameters as the start of a scene"),
    OPTION_FORCE(force),
    HELP_NOTE("\n"
              "Push tests (displacement of a loaded mat along the runway) give gear_k_lb_ft, "
              "gear_unloading, gear_axle_law, f:"),
    OPTION_TEXT("--push", "F.csv", push_path,
                "readings in order; the first line names the columns with their units (also N, kg, "
                "mm): test,load (lb),force (lb),displacement (in). See docs/howto/push-test.md"),
    OPTION_INTEGER("--mats", "N", mats, 1, PUSH_MATS_MAX, 0,
                   "number of mats under the load that moved together; k is given per mat"),
    OPTION_TEXT("--plot", "F", plot_path,
                "plot each test with the elastic and the rigid fit (.svg, .png, .pdf)"),
    OPTION_NUMBER("--axle-load", "LB", axle_load_lb, "lb", 1e-3, 1e9, 0.0,
                  "load of one axle on the strip; default: the smallest load tested"),
    OPTION_NUMBER("--force-error", "LB", force_error_lb, "lb", 1e-6, 1e6, 0.5,
                  "standard error of a force; default: {standard}"),
    OPTION_NUMBER("--dial-error", "IN", displacement_error_in, "in", 1e-7, 10.0, 0.001,
                  "standard error of a displacement; default: {standard}"),
    HELP_NOTE("Units are those of the scene keys (ft, lb, slug, s), even with --si."),
    HELP_EXAMPLE("matrig params readings.json -o scene.json"),
    HELP_EXAMPLE("matrig params --push push.csv --mats 2 --plot push.svg"),
};

const struct command command_params = {
    "params",
    params_command,
    "[READINGS] [--push F.csv --mats N] [-o F] ...",
    "compute scene parameters from simple laboratory tests",
    COMMAND_PARTS(parts),
    {0, 1, "READINGS"},
};
