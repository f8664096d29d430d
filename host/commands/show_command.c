/* matrig show: what a campaign holds, and a landing's summary again. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/preview.h"
#include "host/analyse/journal.h"
#include "host/analyse/record.h"
#include "host/base/command.h"
#include "host/base/xmalloc.h"
#include "host/commands/commands.h"
#include "host/store/store_journal.h"

/* ---- all of them ---- */

/* Of the landings so far: by what one that comes twice is recognised. */
struct known {
    struct store_landing landing;
    struct store_edge *edge;
    size_t edges;
};

static int64_t find_same(const struct known *known, size_t count, const struct preview *glance)
{
    for (size_t i = 0; i < count; i++) {
        if (store_same_landing(&glance->measured.landing, glance->edge, glance->edges,
                               &known[i].landing, known[i].edge, known[i].edges))
            return known[i].landing.id;
    }
    return 0;
}

/* Takes over the edges. */
static void remember(struct known *known, size_t *count, struct preview *glance)
{
    if (glance->is_void)
        return;
    known[(*count)++] = (struct known){glance->measured.landing, glance->edge, glance->edges};
    glance->edge = NULL;
}

static enum mr_status landings_answer(struct store *store, const struct store_landing *row,
                                      size_t count, struct answer *answer, struct error *error)
{
    static struct preview glance; /* some ten kilobytes */
    uint16_t base;
    bool bases = false;
    struct known *known = xcalloc(count ? count : 1, sizeof *known);
    size_t remembered = 0;
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < count && status == MR_OK && !bases; i++) {
        status = store_frames_base(store, row[i].id, &base, error);
        bases = base != 0;
    }
    answer_table(answer, "landings", "");
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        status = preview_load(store, row[i].id, &glance, error);
        if (status == MR_OK) {
            answer_row(answer);
            preview_answer(&glance, find_same(known, remembered, &glance), bases, answer);
            remember(known, &remembered, &glance);
        }
        preview_free(&glance);
    }
    answer_close(answer);
    for (size_t i = 0; i < remembered; i++)
        free(known[i].edge);
    free(known);
    return status;
}

/* What is there besides, in a line; and what is next where nothing is. */
static void holds_answer(const char *db, size_t landings, size_t series, size_t surveys,
                         struct answer *answer)
{
    answer_words(answer, "db", NULL, "%s", db);
    answer_count(answer, "series", NULL, (int64_t)series);
    answer_count(answer, "surveys", NULL, (int64_t)surveys);
    if (landings == 0)
        answer_sentence(answer, NULL, "no landing yet: %s; matrig log --db %s collects them", db,
                        db);
    if (landings == 0 && series == 0)
        answer_sentence(answer, NULL, "no series yet: matrig landing %s --series NAME begins one",
                        db);
    if (landings == 0 && surveys == 0)
        answer_sentence(answer, NULL, "no survey yet: matrig survey %s begins one", db);
    if (series + surveys > 0)
        answer_sentence(answer, NULL,
                        "%zu series (matrig landing %s), %zu surveys (matrig survey "
                        "%s --list)",
                        series, db, surveys, db);
}

/* What came of warnings and advice takes the readings of each landing: of more than these the
 * report alone adds them up. */
#define RECORD_MOST 30

static enum mr_status came_of_it_answer(struct store *store, size_t landings, struct answer *answer,
                                        struct error *error)
{
    struct record record;
    if (landings == 0)
        return MR_OK;
    if (landings > RECORD_MOST) {
        answer_none(answer, "record", NULL, NULL);
        answer_sentence(answer, NULL,
                        "more than %d landings: matrig report adds up their warnings and what came "
                        "of them",
                        RECORD_MOST);
        return MR_OK;
    }
    enum mr_status status = record_load(store, &record, error);
    if (status == MR_OK)
        record_answer(&record, true, answer);
    record_free(&record);
    return status;
}

static enum mr_status list(struct store *store, const char *db, struct answer *answer,
                           struct error *error)
{
    struct store_landing *row = NULL;
    struct store_series *series = NULL;
    struct store_gage_survey *survey = NULL;
    size_t count = 0, series_count = 0, surveys = 0;
    enum mr_status status = store_landings(store, &row, &count, error);
    if (status == MR_OK)
        status = store_series_all(store, &series, &series_count, error);
    if (status == MR_OK)
        status = store_gage_surveys(store, &survey, &surveys, error);
    if (status == MR_OK)
        status = landings_answer(store, row, count, answer, error);
    if (status == MR_OK) {
        holds_answer(db, count, series_count, surveys, answer);
        status = came_of_it_answer(store, count, answer, error);
    }
    free(row);
    free(series);
    free(survey);
    return status;
}

/* ---- one ---- */

static enum mr_status said_answer(struct store *store, const struct store_landing *landing,
                                  struct answer *answer, struct error *error)
{
    struct store_series series = {0};
    struct store_observation *observation = NULL;
    struct store_change *change = NULL;
    size_t observations = 0, changes = 0;
    bool is_void = false;
    int64_t twin = 0;
    enum mr_status status = store_series_of(store, landing, &series, error);
    if (status == MR_OK)
        status = store_observations(store, landing->id, &observation, &observations, error);
    if (status == MR_OK)
        status = store_changes(store, landing->id, &change, &changes, error);
    if (status == MR_OK)
        status = store_is_void(store, landing->id, &is_void, NULL, error);
    if (status == MR_OK)
        status = store_find_twin(store, landing->id, &twin, error);
    answer_words_or_none(answer, "series", series.name[0] ? "series" : NULL, series.name, NULL);
    answer_flag(answer, "void", NULL, is_void);
    answer_count(answer, "same_as", NULL, twin ? twin : ANSWER_UNKNOWN);
    if (is_void)
        answer_sentence(answer, NULL, "the landing is void");
    if (twin)
        answer_sentence(answer, NULL, "the same landing as RUN %lld", (long long)twin);
    journal_tables_answer(observation, observations, change, changes, answer);
    free(observation);
    free(change);
    return status;
}

static enum mr_status show(struct store *store, int64_t run, struct answer *answer,
                           struct error *error)
{
    static struct summary summary;
    enum mr_status status = summary_load(store, run, &summary, error);
    if (status == MR_OK) {
        summary_answer(&summary, answer);
        status = said_answer(store, &summary.measured.landing, answer, error);
    }
    summary_free(&summary);
    return status;
}

static int show_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2];
    struct error error = {0};
    struct store *store = NULL;
    struct answer *answer = answer_new(cli->si);
    int64_t run = 0;
    enum mr_status status = command_parse(&command_show, argc, argv, cli, NULL, words, &error);
    if (status == MR_OK && words[1])
        status = run_parse(words[1], &run, &error);
    if (status == MR_OK)
        status = store_open(words[0], STORE_READ, &store, &error);
    if (status == MR_OK && run)
        status = show(store, run, answer, &error);
    else if (status == MR_OK)
        status = list(store, words[0], answer, &error);
    store_close(store);
    return answer_end(cli, answer, 0, &error);
}

static const struct command_part parts[] = {
    HELP_ITEM(
        "DB",
        "campaign database: a row for each landing, in the numbers of its summary: when "
        "it was armed, series, speed at\n"
        "touchdown and where the gear stopped (+- is one standard error), first "
        "warning, frames lost, what was said of it.\n"
        "One that was logged or imported twice is told: the same landing as RUN N. Last, what "
        "came of the warnings, by survey and\n"
        "transducers"),
    HELP_ITEM("RUN", "the summary of a landing as matrig log printed it, and what was said of it "
                     "since"),
    HELP_EXAMPLE("matrig show campaign.db; matrig show campaign.db 5"),
};

const struct command command_show = {
    "show",
    show_command,
    "DB [RUN]",
    "what a campaign holds: its landings, and a landing's summary again",
    COMMAND_PARTS(parts),
    {1, 2, "DB [RUN]"},
};
