/* What people said of the landings: series, notes, corrections, voided landings, waves and
 * breaks. */
#include <stdlib.h>

#include "host/analyse/journal.h"
#include "host/report/report.h"
#include "host/store/store_recalibrate.h"

static enum mr_status series_answer(struct store *store, const struct store_landing *landing,
                                    struct answer *answer, struct error *error)
{
    struct store_series series;
    char reason[STORE_JOURNAL_TEXT];
    bool is_void, recalibrated = false;
    enum mr_status status = store_series_of(store, landing, &series, error);
    if (status == MR_OK)
        status = store_is_void(store, landing->id, &is_void, reason, error);
    if (status == MR_OK)
        status = store_is_recalibrated(store, landing->id, &recalibrated, error);
    if (status != MR_OK || (!series.name[0] && !series.pattern[0] && !series.runway[0] &&
                            !series.modification[0] && !is_void && !recalibrated))
        return status;
    answer_row(answer);
    answer_count(answer, NULL, "RUN", landing->id);
    answer_count(answer, NULL, "landing", landing->board_landing);
    answer_words(answer, NULL, "series", "%s", series.name);
    answer_words(answer, NULL, "runway", "%s", series.runway);
    answer_words(answer, NULL, "pattern", "%s", series.pattern);
    answer_words(answer, NULL, "modification", "%s", series.modification);
    if (is_void)
        answer_words(answer, NULL, "counts", "void: %s", reason)->warn = true;
    else
        answer_words(answer, NULL, "counts",
                     recalibrated ? "yes; with a corrected calibration" : "yes");
    return status;
}

static enum mr_status observations_answer(struct store *store, const struct store_landing *landing,
                                          struct answer *answer, struct error *error)
{
    struct store_observation *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_observations(store, landing->id, &rows, &count, error);
    for (size_t i = 0; i < count; i++) {
        if (rows[i].withdrawn)
            continue;
        answer_row(answer);
        answer_count(answer, NULL, "RUN", landing->id);
        journal_observation_answer(&rows[i], answer);
    }
    free(rows);
    return status;
}

static enum mr_status changes_answer(struct store *store, const struct store_landing *landing,
                                     struct answer *answer, struct error *error)
{
    struct store_change *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_changes(store, landing->id, &rows, &count, error);
    for (size_t i = 0; i < count; i++) {
        answer_row(answer);
        answer_count(answer, NULL, "RUN", landing->id);
        journal_change_answer(&rows[i], answer);
    }
    free(rows);
    return status;
}

static const struct {
    const char *title;
    enum mr_status (*rows)(struct store *store, const struct store_landing *landing,
                           struct answer *answer, struct error *error);
} tables[] = {{"Series and validity", series_answer},
              {"Waves and breaks", observations_answer},
              {"Notes and corrections", changes_answer}};

/* Leaves one landing, where the page is of one; how many there are then. */
static size_t only(struct store_landing *landings, size_t count, int64_t run)
{
    for (size_t i = 0; i < count && run; i++) {
        if (landings[i].id == run) {
            landings[0] = landings[i];
            return 1;
        }
    }
    return run ? 0 : count;
}

enum mr_status campaign_journal(const struct report *report, FILE *out, struct error *error)
{
    struct store *store = report->store;
    struct store_landing *landings = NULL;
    size_t count = 0;
    struct answer *answer = answer_new(report->si);
    enum mr_status status = store_landings(store, &landings, &count, error);
    count = only(landings, count, report->run);
    for (size_t t = 0; t < sizeof tables / sizeof *tables; t++) {
        answer_table(answer, NULL, tables[t].title);
        for (size_t i = 0; i < count && status == MR_OK; i++)
            status = tables[t].rows(store, &landings[i], answer, error);
        answer_close(answer);
    }
    report_answer(answer, out);
    free(landings);
    return status;
}
