#include <stdlib.h>

#include "host/board/configtext.h"
#include "host/report/report.h"

/* The configuration that the landing was armed with, when its text is there and can be read. */
static enum mr_status load_config(struct store *store, struct report_landing *landing,
                                  struct error *error)
{
    int64_t crc = landing->summary.measured.landing.config_crc;
    struct error ignored = {0}; /* of a text that another matrig wrote: what it says is not known */
    char *text = NULL;
    if (crc == STORE_NONE)
        return MR_OK;
    enum mr_status status = store_configuration_get(store, (uint32_t)crc, &text, error);
    if (status == MR_OK && text) {
        landing->config = malloc(sizeof *landing->config);
        if (landing->config &&
            configtext_read(text, "configuration", landing->config, &ignored) != MR_OK) {
            free(landing->config);
            landing->config = NULL;
        }
    }
    free(text);
    return status;
}

static enum mr_status load_landing(struct store *store, const struct store_landing *row,
                                   struct report_landing *landing, struct error *error)
{
    enum mr_status status = summary_load(store, row->id, &landing->summary, error);
    if (status == MR_OK)
        status = zones_load_survey(store, row->id, &landing->survey, error);
    if (status == MR_OK)
        status = store_series_of(store, row, &landing->series, error);
    if (status == MR_OK)
        status = store_motions(store, row->id, &landing->motion, &landing->motions, error);
    if (status == MR_OK)
        status = store_predictions(store, row->id, &landing->prediction, &landing->predictions,
                                   error);
    if (status == MR_OK)
        status = store_simulations(store, row->id, &landing->simulation, &landing->simulations,
                                   error);
    if (status == MR_OK)
        status = store_simulation_head(store, row->id, &landing->head, error);
    return status == MR_OK ? load_config(store, landing, error) : status;
}

enum mr_status report_load(struct report *report, bool voided, struct error *error)
{
    struct store_landing *rows = NULL, one;
    size_t count = 0;
    enum mr_status status = MR_OK;
    if (report->run)
        status = store_landing_get(report->store, report->run, &one, error);
    if (status == MR_OK)
        status = store_landings(report->store, &rows, &count, error);
    if (status == MR_OK && !(report->landing = calloc(count ? count : 1, sizeof *report->landing)))
        status = error_set(error, MR_FULL, "no memory: %zu landings; close other programs", count);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        bool is_void = false;
        if (report->run && rows[i].id != report->run)
            continue;
        status = store_is_void(report->store, rows[i].id, &is_void, NULL, error);
        if (is_void && !voided)
            report->voided++;
        else if (status == MR_OK)
            status = load_landing(report->store, &rows[i], &report->landing[report->landings++],
                                  error);
    }
    free(rows);
    return status == MR_OK
             ? store_slow_rows(report->store, NULL, &report->slow, &report->slow_rows, error)
             : status;
}

void report_free(struct report *report)
{
    for (size_t i = 0; i < report->landings; i++) {
        struct report_landing *landing = &report->landing[i];
        summary_free(&landing->summary);
        free(landing->motion);
        free(landing->prediction);
        free(landing->config);
        store_simulations_free(landing->simulation, landing->simulations);
        free(landing->head.segments_in);
    }
    free(report->landing);
    free(report->slow);
}
