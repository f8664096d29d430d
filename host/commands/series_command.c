/* matrig series: what the landings belong to. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/commands/commands.h"
#include "host/commands/said.h"
#include "host/link/link.h"
#include "host/store/store_journal.h"
#include "host/survey/survey_answer.h"

static enum mr_status list_series(struct store *store, const struct cli *cli, struct answer *answer,
                                  struct error *error)
{
    struct store_series *rows = NULL;
    struct store_landing *landings = NULL;
    size_t count = 0, landed = 0;
    enum mr_status status = store_series_all(store, &rows, &count, error);
    if (status == MR_OK)
        status = store_landings(store, &landings, &landed, error);
    if (status == MR_OK && count == 0)
        cli_note(cli, "no series yet: %s; matrig series DB NAME begins one", store_path(store));
    answer_table(answer, "series", "");
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        char when[40];
        int64_t its = 0;
        for (size_t k = 0; k < landed && status == MR_OK; k++) {
            struct store_series of;
            status = store_series_of(store, &landings[k], &of, error);
            its += of.id == rows[i].id;
        }
        survey_time_text(rows[i].made_us, when, sizeof when);
        answer_row(answer);
        answer_words(answer, "name", "series", "%s", rows[i].name);
        answer_words(answer, "begun", "begun", "%s", when);
        answer_words_or_none(answer, "runway", "runway", rows[i].runway, "-");
        answer_words_or_none(answer, "pattern", "pattern", rows[i].pattern, "-");
        answer_words_or_none(answer, "modification", "modification", rows[i].modification, "-");
        answer_count(answer, "landings", "landings", its);
        if (rows[i].notes[0])
            answer_words(answer, NULL, "notes", "%s", rows[i].notes);
        answer_words_or_none(answer, "who", NULL, rows[i].who, "-");
    }
    answer_close(answer);
    free(rows);
    free(landings);
    return status;
}

static enum mr_status begin_series(const char *db, struct store *store,
                                   const struct store_series *series, struct error *error)
{
    struct store_series *rows = NULL;
    size_t count = 0;
    enum mr_status status = store_series_all(store, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        if (strcmp(rows[i].name, series->name) == 0)
            status = error_set(error, MR_USAGE,
                               "there is a series '%s' already: %s; give another name",
                               series->name, db);
    }
    free(rows);
    return status == MR_OK ? store_series_add(store, series, error) : status;
}

struct request {
    const char *runway, *pattern, *modification, *notes, *who;
};

static int series_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2];
    struct request r = {0};
    struct error error = {0};
    struct store *store = NULL;
    struct store_series series = {.made_us = (int64_t)link_now_us()};
    struct answer *answer = answer_new(cli->si);
    enum mr_status status = command_parse(&command_series, argc, argv, cli, &r, words, &error);
    if (status == MR_OK && !words[1] && (r.runway || r.pattern || r.modification || r.notes))
        status = error_set(&error, MR_USAGE,
                           "which series? matrig series DB NAME; see matrig series --help");
    if (status == MR_OK && words[1] && (!words[1][0] || strlen(words[1]) >= sizeof series.name))
        status = error_set(&error, MR_USAGE, "not a name: '%s'; 1 to %zu characters", words[1],
                           sizeof series.name - 1);
    if (status == MR_OK)
        status = store_open(words[0], words[1] ? STORE_CREATE : STORE_READ, &store, &error);
    said_fill(series.name, sizeof series.name, words[1]);
    said_fill(series.who, sizeof series.who, said_by(r.who));
    said_fill(series.runway, sizeof series.runway, r.runway);
    said_fill(series.pattern, sizeof series.pattern, r.pattern);
    said_fill(series.modification, sizeof series.modification, r.modification);
    said_fill(series.notes, sizeof series.notes, r.notes);
    if (status == MR_OK && words[1])
        status = begin_series(words[0], store, &series, &error);
    if (status == MR_OK)
        status = list_series(store, cli, answer, &error);
    store_close(store);
    return answer_end(cli, answer, 0, &error);
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database"),
    HELP_ITEM("NAME",
              "begin a series of this name: landings that are armed from now on belong to it"),
    HELP_EXAMPLE("matrig series campaign.db standard-2 --pattern standard --runway 'relaid, bands "
                 "tensioned'"),
    OPTION_TEXT("--runway", "T", runway, NULL),
    OPTION_TEXT("--pattern", "T", pattern, NULL),
    OPTION_TEXT("--modification", "T", modification, NULL),
    OPTION_TEXT("--notes", "T", notes, NULL),
    OPTION_TEXT("--who", "W", who, NULL),
};

const struct command command_series = {
    "series",
    series_command,
    "DB [NAME [--runway T] [--pattern T] [--modification T] [--notes T] [--who W]]",
    "series of landings: begin one, or list them",
    COMMAND_PARTS(parts),
    {1, 2, "DB [NAME]"},
};
