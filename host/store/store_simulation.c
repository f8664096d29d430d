/* Comparisons of landings with the simulation. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_sql.h"
#include "host/base/xmalloc.h"

static enum mr_status put_channel(struct store *store, int64_t simulation,
                                  const struct store_simulation *from, struct error *error)
{
    const size_t bytes = from->length * sizeof *from->series_in;
    const struct store_simulation_channel row = {
        .number = from->number,
        .station_ft = from->station_ft,
        .peak_measured_in = from->peak_measured_in,
        .peak_measured_error_in = from->peak_measured_error_in,
        .peak_simulated_in = from->peak_simulated_in,
        .peak_simulated_error_in = from->peak_simulated_error_in,
        .rms_in = from->rms_in,
        .end_measured_in = from->end_measured_in,
        .end_simulated_in = from->end_simulated_in,
        .t0_s = from->t0_s,
        .dt_s = from->dt_s,
        .series_in = {from->series_in, bytes},
        .spread_in = {from->spread_in, from->spread_in ? bytes : 0},
    };
    return STORE_PUT(store, error, simulation_channel, &row, simulation);
}

enum mr_status store_simulation_put(struct store *store, int64_t run, const char *scene_json,
                                    int64_t made_us, const struct store_simulation_head *head,
                                    const struct store_simulation *rows, size_t count,
                                    struct error *error)
{
    const struct store_simulation_row row = {
        .scene = scene_json,
        .made_us = made_us,
        .run_ms = head->run_ms,
        .error_in = head->error_in,
        .seeds = head->seeds,
        .edges = head->edges,
        .offset_s = head->offset_s,
        .scatter_s = head->scatter_s,
        .segments_dt_s = head->segments_dt_s,
        .segments_in = {head->segments_in,
                        head->segment_rows * MR_SEGMENTS * sizeof *head->segments_in},
    };
    enum mr_status status = STORE_PUT(store, error, simulation_row, &row, run);
    int64_t id = sqlite3_last_insert_rowid(store->database);
    for (size_t i = 0; i < count && status == MR_OK; i++)
        status = put_channel(store, id, &rows[i], error);
    return status;
}

/* A copy of a blob of floats; NULL: it is absent. */
static float *floats(const struct store_bytes *bytes, size_t *length)
{
    float *values = bytes->length ? malloc(bytes->length) : NULL;
    *length = values ? bytes->length / sizeof *values : 0;
    if (values)
        memcpy(values, bytes->data, bytes->length);
    return values;
}

static struct store_simulation simulation_of(const struct store_simulation_channel *row)
{
    struct store_simulation made = {
        .number = row->number,
        .station_ft = row->station_ft,
        .peak_measured_in = row->peak_measured_in,
        .peak_measured_error_in = row->peak_measured_error_in,
        .peak_simulated_in = row->peak_simulated_in,
        .peak_simulated_error_in = row->peak_simulated_error_in,
        .rms_in = row->rms_in,
        .end_measured_in = row->end_measured_in,
        .end_simulated_in = row->end_simulated_in,
        .t0_s = row->t0_s,
        .dt_s = row->dt_s,
    };
    size_t spreads = 0;
    made.series_in = floats(&row->series_in, &made.length);
    made.spread_in = floats(&row->spread_in, &spreads);
    if (spreads != made.length) {
        free(made.spread_in);
        made.spread_in = NULL;
    }
    return made;
}

enum mr_status store_simulations(struct store *store, int64_t run, struct store_simulation **rows,
                                 size_t *count, struct error *error)
{
    sqlite3_stmt *s;
    struct store_simulation_channel row;
    *rows = NULL;
    *count = 0;
    enum mr_status status = STORE_QUERY(store, error, SIMULATIONS, &s, BIND(run));
    while (status == MR_OK && (status = STORE_NEXT(store, error, SIMULATIONS, s, &row)) == MR_OK) {
        if (!list_grow(rows, *count, sizeof **rows)) {
            sqlite3_reset(s);
            status = error_set(error, MR_FULL, "no memory: reading %s; close other programs",
                               store->path);
            break;
        }
        (*rows)[(*count)++] = simulation_of(&row);
    }
    if (status == MR_TOO_FEW)
        return MR_OK;
    store_simulations_free(*rows, *count);
    *rows = NULL;
    *count = 0;
    return status;
}

void store_simulations_free(struct store_simulation *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        free(rows[i].series_in);
        free(rows[i].spread_in);
    }
    free(rows);
}

enum mr_status store_simulation_head(struct store *store, int64_t run,
                                     struct store_simulation_head *head, struct error *error)
{
    sqlite3_stmt *s;
    struct store_simulation_row row;
    size_t values;
    *head = (struct store_simulation_head){
        .seeds = STORE_NONE, .edges = STORE_NONE, .run_ms = (double)NAN, .error_in = (double)NAN};
    enum mr_status status = STORE_QUERY(store, error, SIMULATION_HEAD, &s, BIND(run));
    if (status == MR_OK)
        status = STORE_NEXT(store, error, SIMULATION_HEAD, s, &row);
    if (status != MR_OK)
        return status == MR_TOO_FEW ? MR_OK : status;
    *head = (struct store_simulation_head){
        .run_ms = row.run_ms,
        .error_in = row.error_in,
        .seeds = row.seeds,
        .edges = row.edges,
        .offset_s = row.offset_s,
        .scatter_s = row.scatter_s,
        .segments_dt_s = row.segments_dt_s,
    };
    head->segments_in = floats(&row.segments_in, &values);
    head->segment_rows = values / MR_SEGMENTS;
    snprintf(head->file, sizeof head->file, "%s", row.file);
    sqlite3_reset(s);
    return MR_OK;
}
