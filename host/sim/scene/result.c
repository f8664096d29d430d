#include "host/sim/scene/result.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"

const char *sim_status_name(enum sim_status status)
{
    static const char *const names[] = {"ok",          "unstable",     "folded", "step_underflow",
                                        "interrupted", "unpredictable"};
    return names[status];
}

void sim_result_set_status(struct sim_result *result, enum sim_status status, int mat, double t_s)
{
    result->status = status;
    result->mat = mat;
    result->t_s = t_s;
}

int sim_time_digits(double start_s, int digits)
{
    for (; start_s >= 1.0 && digits < 15; start_s /= 10.0)
        digits++;
    return digits;
}

void sim_result_add_omitted_effect(struct sim_result *result, const char *what)
{
    for (size_t i = 0; i + 1 < SIM_LEFT_OUT_MAX; i++) {
        /* a solver that ran this scene before may already have added it */
        if (result->omitted_effects[i] == what)
            return;
        if (!result->omitted_effects[i]) {
            result->omitted_effects[i] = what;
            return;
        }
    }
}

void sim_result_add_note(struct sim_result *result, const char *format, ...)
{
    char note[sizeof result->notes[0]];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(note, sizeof note, format, arguments);
    va_end(arguments);
    for (size_t i = 0; i + 1 < SIM_NOTES_MAX; i++) {
        if (result->notes[i][0] == '\0')
            memcpy(result->notes[i], note, sizeof note);
        if (strcmp(result->notes[i], note) == 0)
            return;
    }
}

void sim_result_free(struct sim_result *result)
{
    for (size_t i = 0; i < result->output_count; i++)
        free(result->outputs[i].u_ft);
    free(result->outputs);
    free(result->u_ft);
    free(result->gap_ft);
    free(result->max_compression_lb);
    free(result->max_tension_lb);
    free(result->max_rise_ft);
    free(result->mods);
    free(result->sample_u_ft);
    free(result->sample_y_ft);
    *result = (struct sim_result){0};
}

/* ---- record of outputs ---- */

#define EVENLY_SPACED_TIMES 64

static int compare_times(const void *a, const void *b)
{
    const struct sim_snapshot *x = a, *y = b;
    return x->t_s < y->t_s ? -1 : x->t_s > y->t_s;
}

static void set_next_time(struct sim_record *record)
{
    record->next_record_s = (double)INFINITY;
    if (record->next_snapshot < record->snapshot_count)
        record->next_record_s = record->snapshots[record->next_snapshot].t_s;
    if (record->next_sample < record->sample_count)
        record->next_record_s = fmin(record->next_record_s,
                                     (double)record->next_sample * record->sample_dt_s);
}

void sim_record_make(struct sim_record *record, const struct sim_scene *scene,
                     const struct sim_options *options)
{
    size_t row = (size_t)scene->mats + 1;
    size_t outputs = scene->t_out_s.count > 0 ? scene->t_out_s.count : 1;
    double end_s = sim_scene_end_s(scene);
    *record = (struct sim_record){.mats = scene->mats,
                                  .end_s = end_s,
                                  .snapshot_count = EVENLY_SPACED_TIMES + outputs,
                                  .lift_node = 1};
    if (options->sample_dt_s > 0.0) {
        record->sample_dt_s = options->sample_dt_s;
        record->sample_count = (size_t)floor(end_s / options->sample_dt_s * (1.0 + 1e-12)) + 1;
        record->station_count = options->station_count;
    }
    record->snapshots = xcalloc(record->snapshot_count, sizeof *record->snapshots);
    record->storage = xcalloc(record->snapshot_count * row, sizeof *record->storage);
    record->station_mat = xcalloc(record->station_count + 1, sizeof *record->station_mat);
    size_t samples = record->sample_count * record->station_count + 1;
    record->sample_u_ft = xcalloc(samples, sizeof *record->sample_u_ft);
    if (scene->model != SIM_MODEL_CHAIN)
        record->sample_y_ft = xcalloc(samples, sizeof *record->sample_y_ft);
    for (size_t s = 0; s < record->station_count; s++) {
        int mat = (int)floor(options->station_ft[s] / scene->length_ft + 1e-9) + 1;
        record->station_mat[s] = mat > scene->mats ? scene->mats : mat;
    }
    for (size_t i = 0; i < EVENLY_SPACED_TIMES; i++)
        record->snapshots[i] = (struct sim_snapshot){
            .t_s = end_s * (double)(i + 1) / EVENLY_SPACED_TIMES, .output_index = -1};
    for (size_t i = 0; i < outputs; i++)
        record->snapshots[EVENLY_SPACED_TIMES + i] = (struct sim_snapshot){
            .t_s = scene->t_out_s.count > 0 ? scene->t_out_s.values[i] : end_s,
            .output_index = (int)i};
    qsort(record->snapshots, record->snapshot_count, sizeof *record->snapshots, compare_times);
    for (size_t i = 0; i < record->snapshot_count; i++)
        record->snapshots[i].u_ft = record->storage + i * row;
    set_next_time(record);
}

void sim_record_add(struct sim_record *record, double t_s, const double *u_ft, const double *v_ft_s)
{
    while (record->next_record_s <= t_s) {
        if (record->next_snapshot < record->snapshot_count &&
            record->snapshots[record->next_snapshot].t_s <= record->next_record_s) {
            struct sim_snapshot *snapshot = &record->snapshots[record->next_snapshot++];
            snapshot->lift_ft = record->lift_ft;
            snapshot->lift_node = record->lift_node;
            for (int n = 1; n <= record->mats; n++)
                snapshot->u_ft[n] = u_ft[n] - v_ft_s[n] * (t_s - snapshot->t_s);
        } else {
            double back_s = t_s - record->next_record_s;
            size_t begin = record->next_sample++ * record->station_count;
            double *row = record->sample_u_ft + begin;
            for (size_t s = 0; record->sample_y_ft && s < record->station_count; s++)
                record->sample_y_ft[begin + s] = record->height_ft[record->station_mat[s]];
            for (size_t s = 0; s < record->station_count; s++)
                row[s] = u_ft[record->station_mat[s]] - v_ft_s[record->station_mat[s]] * back_s;
        }
        set_next_time(record);
    }
}

struct sim_difference sim_record_difference(const struct sim_record *a, const struct sim_record *b)
{
    struct sim_difference most = {0.0, 1, 0.0};
    for (size_t i = 0; i < a->snapshot_count; i++) {
        for (int n = 1; n <= a->mats; n++) {
            double difference = fabs(a->snapshots[i].u_ft[n] - b->snapshots[i].u_ft[n]);
            if (difference > most.u_ft)
                most = (struct sim_difference){difference, n, a->snapshots[i].t_s};
        }
    }
    for (size_t i = 0; i < a->sample_count * a->station_count; i++) {
        double difference = fabs(a->sample_u_ft[i] - b->sample_u_ft[i]);
        if (difference > most.u_ft)
            most = (struct sim_difference){difference, a->station_mat[i % a->station_count],
                                           (double)(i / a->station_count) * a->sample_dt_s};
    }
    return most;
}

double sim_record_lift_difference(const struct sim_record *a, const struct sim_record *b)
{
    double most = 0.0;
    for (size_t i = 0; i < a->snapshot_count; i++)
        most = fmax(most, fabs(a->snapshots[i].lift_ft - b->snapshots[i].lift_ft));
    return most;
}

struct sim_difference sim_record_peak(const struct sim_record *record)
{
    struct sim_difference most = {0.0, 1, 0.0};
    for (size_t i = 0; i < record->snapshot_count; i++) {
        for (int n = 1; n <= record->mats; n++) {
            double u_ft = fabs(record->snapshots[i].u_ft[n]);
            if (u_ft > most.u_ft)
                most = (struct sim_difference){u_ft, n, record->snapshots[i].t_s};
        }
    }
    return most;
}

void sim_record_move_to_result(struct sim_record *record, struct sim_result *result)
{
    size_t row = (size_t)record->mats + 1;
    size_t outputs = 0;
    for (size_t i = 0; i < record->next_snapshot; i++)
        outputs += record->snapshots[i].output_index >= 0;
    result->outputs = xcalloc(outputs + 1, sizeof *result->outputs);
    result->output_count = outputs;
    /* the outputs of an interrupted run are complete only up to a certain time */
    bool complete = record->next_snapshot == record->snapshot_count;
    size_t delivered = 0;
    for (size_t i = 0; i < record->next_snapshot; i++) {
        const struct sim_snapshot *snapshot = &record->snapshots[i];
        if (snapshot->output_index < 0)
            continue;
        double *copy = xmemdup(snapshot->u_ft, row * sizeof *copy);
        result->outputs[complete ? (size_t)snapshot->output_index : delivered++] =
            (struct sim_output){snapshot->t_s, copy, snapshot->lift_ft, snapshot->lift_node};
    }
    if (record->sample_dt_s > 0.0) {
        result->sample_u_ft = record->sample_u_ft;
        result->sample_y_ft = record->sample_y_ft;
        record->sample_y_ft = NULL;
        result->sample_count = record->next_sample;
        result->station_count = record->station_count;
        result->sample_dt_s = record->sample_dt_s;
        record->sample_u_ft = NULL;
    }
}

void sim_record_move_chain_to_result(struct sim_record *record, const double *u_ft,
                                     const double *push_lb, const double *pull_lb,
                                     struct sim_result *result)
{
    size_t mats = (size_t)record->mats;
    struct sim_difference peak = sim_record_peak(record);
    result->peak_u_ft = peak.u_ft;
    result->peak_mat = peak.mat;
    result->u_ft = xmemdup(u_ft, (mats + 1) * sizeof *u_ft);
    result->gap_ft = xcalloc(mats + 2, sizeof *result->gap_ft);
    result->max_compression_lb = xmemdup(push_lb, (mats + 2) * sizeof *push_lb);
    result->max_tension_lb = xmemdup(pull_lb, (mats + 2) * sizeof *pull_lb);
    sim_record_move_to_result(record, result);
}

void sim_record_free(struct sim_record *record)
{
    free(record->snapshots);
    free(record->storage);
    free(record->station_mat);
    free(record->sample_u_ft);
    free(record->sample_y_ft);
    record->snapshots = NULL;
    record->storage = NULL;
    record->station_mat = NULL;
    record->sample_u_ft = record->sample_y_ft = NULL;
}
