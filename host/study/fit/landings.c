#include "host/study/fit/landings.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"

#define IN_PER_FT      12.0
#define END_S          0.2
#define LEAST_WINDOW_S 0.01
#define VALID_SHARE    0.5
#define BEND_IN        0.05 /* u0 of asinh */

const struct fit_name fit_names[FIT_KEYS] = {
    [FIT_GAP] = {"gap", "mean gap of the joints", "in"},
    [FIT_GRIT] = {"grit", "mean closing resistance", "lb"},
    [FIT_FRICTION] = {"f", "friction", ""},
    [FIT_SHARE] = {"share", "share of the thrust", ""},
    [FIT_STIFFNESS] = {"KL", "stiffness of a joint", "lb/ft"},
};

/* Distances of the wheel from a transducer, ft, ahead positive: between each and the next is a
 * window. */
static const double edges_ft[] = {16.0, 8.0, 4.0, 2.0, 0.0, -4.0};
#define EDGES (sizeof edges_ft / sizeof edges_ft[0])
static const char *const between[EDGES - 1] = {"16 to 8 ft ahead", "8 to 4 ft ahead",
                                               "4 to 2 ft ahead", "2 to 0 ft ahead",
                                               "0 to 4 ft behind"};

void fit_landings_begin(struct fit_landings *list, const struct sim_scene *scene)
{
    *list = (struct fit_landings){.survey_error_in = 0.005};
    list->parameter[FIT_GAP] =
        (struct fit_parameter){true, IN_PER_FT * sim_scene_joint(&scene->gap0_ft, 1), 0.5};
    list->parameter[FIT_GRIT] = (struct fit_parameter){true, sim_scene_joint(&scene->grit_lb, 1),
                                                       0.5};
    list->parameter[FIT_FRICTION] = (struct fit_parameter){true, scene->friction, 0.2};
    list->parameter[FIT_SHARE] = (struct fit_parameter){true, 1.0 / 12.0, 0.15};
    list->parameter[FIT_STIFFNESS] = (struct fit_parameter){true, scene->kl_lb_ft, 0.5};
}

void fit_landings_free(struct fit_landings *list)
{
    for (size_t l = 0; l < list->count; l++)
        sim_scene_free(&list->landing[l].scene);
    free(list->landing);
    free(list->measured);
    *list = (struct fit_landings){0};
}

double fit_bent(double u_in)
{
    return BEND_IN * asinh(u_in / BEND_IN);
}

double fit_movement_in(double statistic)
{
    return BEND_IN * sinh(statistic / BEND_IN);
}

/* ---- what was measured ---- */

/* When the wheel comes to a station; INFINITY: never. Before the path begins: 0. */
static double passes_s(const struct sim_scene *scene, double x_ft)
{
    const struct sim_path_row *row = scene->path;
    if (row[0].x_ft >= x_ft)
        return 0.0;
    for (size_t i = 1; i < scene->path_count; i++) {
        if (row[i].x_ft >= x_ft)
            return row[i - 1].t_s + (row[i].t_s - row[i - 1].t_s) * (x_ft - row[i - 1].x_ft) /
                                        (row[i].x_ft - row[i - 1].x_ft);
    }
    return (double)INFINITY;
}

static double mean_over(const struct fit_series *series, double from_s, double to_s,
                        double *samples)
{
    double sum = 0.0, wanted = (to_s - from_s) / series->dt_s;
    *samples = 0.0;
    for (size_t i = 0; i < series->count; i++) {
        double t_s = series->t0_s + (double)i * series->dt_s;
        if (t_s < from_s || t_s >= to_s || isnan(series->value_in[i]))
            continue;
        sum += series->value_in[i];
        *samples += 1.0;
    }
    return *samples > 0.0 && *samples >= VALID_SHARE * wanted ? sum / *samples : (double)NAN;
}

static void add_window(struct fit_landing *landing, const struct fit_series *series, size_t channel,
                       double from_s, double to_s, const char *name, double *measured)
{
    struct fit_window window = {.channel = channel, .from_s = from_s, .to_s = to_s};
    double mean_in = to_s - from_s >= LEAST_WINDOW_S
                       ? mean_over(series, from_s, to_s, &window.samples)
                       : (double)NAN;
    if (isnan(mean_in) || landing->windows == FIT_WINDOWS_MAX)
        return;
    snprintf(window.name, sizeof window.name, "%s", name);
    measured[landing->windows] = fit_bent(mean_in);
    landing->window[landing->windows++] = window;
}

static void add_channel(struct fit_landing *landing, const struct fit_series *series,
                        double *measured)
{
    size_t channel = landing->channels++;
    double end_s = sim_scene_end_s(&landing->scene),
           stop_s = landing->scene.path[landing->scene.path_count - 1].t_s;
    landing->channel[channel].number = series->number;
    landing->channel[channel].station_ft = series->station_ft;
    landing->channel[channel].noise_in = series->noise_in;
    landing->channel[channel].baseline_in = series->baseline_in;
    landing->channel[channel].gain = series->gain;
    for (size_t e = 0; e + 1 < EDGES; e++) {
        double from_s = passes_s(&landing->scene, series->station_ft - edges_ft[e]);
        double to_s = fmin(passes_s(&landing->scene, series->station_ft - edges_ft[e + 1]), stop_s);
        add_window(landing, series, channel, from_s, to_s, between[e], measured);
    }
    add_window(landing, series, channel, end_s - END_S, end_s, "end", measured);
}

static void add_segments(struct fit_landing *landing, double *measured)
{
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        if ((isnan(landing->survey_in[s]) && !landing->follows) || isnan(landing->after_in[s]) ||
            landing->windows == FIT_WINDOWS_MAX)
            continue;
        struct fit_window window = {.channel = SIZE_MAX, .segment = s, .samples = 1.0};
        snprintf(window.name, sizeof window.name, "segment %zu after", s + 1);
        measured[landing->windows] = landing->after_in[s];
        landing->window[landing->windows++] = window;
    }
}

enum mr_status fit_landings_add(struct fit_landings *list, struct fit_landing *landing,
                                const struct fit_series *series, size_t count, struct error *error)
{
    double measured[FIT_WINDOWS_MAX];
    landing->channels = landing->windows = 0;
    for (size_t c = 0; c < count && c < MR_TRANSDUCERS; c++)
        add_channel(landing, &series[c], measured);
    if (landing->windows == 0)
        return error_set(error, MR_TOO_FEW,
                         "no transducer has enough valid samples: RUN %lld; fit other landings",
                         (long long)landing->run);
    add_segments(landing, measured);
    double *values = realloc(list->measured,
                             (list->statistics + landing->windows) * sizeof *values);
    if (values)
        list->measured = values;
    if (!values || !list_grow(&list->landing, list->count, sizeof *list->landing))
        return error_set(error, MR_FULL, "no memory: RUN %lld; fit fewer landings",
                         (long long)landing->run);
    landing->first = list->statistics;
    memcpy(values + list->statistics, measured, landing->windows * sizeof *values);
    list->statistics += landing->windows;
    list->landing[list->count++] = *landing;
    return MR_OK;
}

/* ---- parameters ---- */

size_t fit_landings_fitted(const struct fit_landings *list, enum fit_key key[FIT_KEYS])
{
    size_t count = 0;
    for (enum fit_key k = 0; k < FIT_KEYS; k++) {
        if (list->parameter[k].fitted)
            key[count++] = k;
    }
    return count;
}

void fit_landings_values(const struct fit_landings *list, const double *z, double value[FIT_KEYS])
{
    for (enum fit_key k = 0; k < FIT_KEYS; k++) {
        const struct fit_parameter *parameter = &list->parameter[k];
        value[k] = parameter->value * (parameter->fitted ? exp(parameter->spread * *z++) : 1.0);
    }
}
