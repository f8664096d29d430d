#include <math.h>
#include <sha2.h>
#include <stdlib.h>
#include <string.h>

#include "host/board/config_text.h"
#include "host/report/report.h"
#include "host/store/store_recalibrate.h"

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
            config_text_read(text, "configuration", landing->config, &ignored) != MR_OK) {
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

static enum mr_status hash_record(void *context, const uint8_t *record, size_t length)
{
    SHA2_CTX *hash = context;
    SHA256Update(hash, record, length);
    return MR_OK;
}

/* What a person said the aircraft weighed. */
static enum mr_status load_weight(struct store *store, int64_t run, double *weight_lb,
                                  struct error *error)
{
    char text[STORE_JOURNAL_TEXT];
    enum mr_status status = store_change_get(store, run, "weight_lb", text, NULL, error);
    *weight_lb = status == MR_OK && text[0] ? strtod(text, NULL) : (double)NAN;
    return status;
}

/* What the facts have from the store. */
static enum mr_status load_facts(struct report *report, const struct report_landing *landing,
                                 struct report_facts *facts, struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    const struct record_given given = {measured, &landing->summary.zones};
    SHA2_CTX hash;
    memset(facts, 0, sizeof *facts);
    report_facts_take(landing, facts, error);
    enum mr_status status = error->status;
    if (status == MR_OK)
        status = load_weight(report->store, measured->landing.id, &facts->weight_lb, error);
    if (status == MR_OK)
        status = store_is_recalibrated(report->store, measured->landing.id, &facts->recalibrated,
                                       error);
    SHA256Init(&hash);
    if (status == MR_OK && measured->source == MEASURED_SERIAL)
        status = store_blocks_each(report->store, measured->landing.id, hash_record, &hash, error);
    if (measured->source == MEASURED_SERIAL)
        SHA256End(&hash, facts->records);
    return status == MR_OK ? record_judge(report->store, &report->record, &given, error) : status;
}

/* What came of its warnings. */
static void take_record(struct report *report, struct report_facts *facts)
{
    const struct record_row *row = record_find(&report->record, facts->landing.id);
    if (!row)
        return;
    facts->record = *row;
    snprintf(facts->why, sizeof facts->why, "%s", row->why ? row->why : "");
    facts->wrong |=
        (row->outcome.waves ? REPORT_WAVE : 0u) | (row->outcome.breaks ? REPORT_BREAK : 0u) |
        (row->verdict == RECORD_MISS || row->verdict == RECORD_LATE ? REPORT_MISSED : 0u) |
        (row->verdict == RECORD_FALSE ? REPORT_FALSE : 0u);
}

enum mr_status report_landing_load(struct report *report, size_t at, struct report_landing *landing,
                                   struct error *error)
{
    struct report_facts *facts = &report->facts[at];
    memset(landing, 0, sizeof *landing);
    enum mr_status status = load_landing(report->store, &report->row[at], landing, error);
    if (status == MR_OK)
        status = load_facts(report, landing, facts, error);
    if (status != MR_OK)
        return status;
    take_record(report, facts);
    bool told = report->calibrations == NULL;
    for (size_t i = 0; i < at && !told; i++)
        told = strcmp(report->facts[i].calibration, facts->calibration) == 0;
    if (!told)
        provenance_calibration(landing, report->calibrations);
    if (report->json)
        json_array_append_new(report->json, summary_json(&landing->summary, report->si));
    return MR_OK;
}

enum mr_status report_begin(struct report *report, bool voided, struct error *error)
{
    struct store_landing one;
    size_t count = 0;
    enum mr_status status = MR_OK;
    if (report->run)
        status = store_landing_get(report->store, report->run, &one, error);
    if (status == MR_OK)
        status = store_landings(report->store, &report->row, &count, error);
    if (status == MR_OK)
        status = record_begin(report->store, &report->record, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        bool is_void = false;
        if (report->run && report->row[i].id != report->run)
            continue;
        status = store_is_void(report->store, report->row[i].id, &is_void, NULL, error);
        if (is_void && !voided)
            report->voided++;
        else
            report->row[report->landings++] = report->row[i];
    }
    report->facts = calloc(report->landings ? report->landings : 1, sizeof *report->facts);
    if (status == MR_OK && !report->facts)
        status = error_set(error, MR_FULL, "no memory: %zu landings; close other programs", count);
    return status == MR_OK
             ? store_slow_rows(report->store, NULL, &report->slow, &report->slow_rows, error)
             : status;
}

void report_landing_free(struct report_landing *landing)
{
    summary_free(&landing->summary);
    free(landing->motion);
    free(landing->prediction);
    free(landing->config);
    store_simulations_free(landing->simulation, landing->simulations);
    free(landing->head.segments_in);
    memset(landing, 0, sizeof *landing);
}

void report_free(struct report *report)
{
    record_free(&report->record);
    free(report->row);
    free(report->facts);
    free(report->slow);
    report->row = NULL;
    report->facts = NULL;
    report->slow = NULL;
}
