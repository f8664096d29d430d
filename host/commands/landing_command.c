/* The command matrig landing: enters series of landings, and notes, corrections and observations of
 * landings, and shows their history. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/journal.h"
#include "host/analyse/measured_load.h"
#include "host/analyse/rig.h"
#include "host/commands/commands.h"
#include "host/commands/annotation.h"
#include "host/commands/program.h"
#include "host/link/link.h"
#include "host/base/spell_suggest.h"
#include "host/base/quantity.h"
#include "host/base/command.h"
#include "host/store/store_journal.h"
#include "host/survey/survey.h"

/* Fields that a user can correct: texts, or numbers within limits. An aircraft model weighs 500 lb
 * in the pilot study, 1300 lb in the standard series, and up to 2250 lb as a C-5 at this scale. */
static const struct field {
    const char *name;
    bool is_number;
    double low, high;
} fields[] = {
    {"touchdown_ft", true, 0.0, RIG_RUNWAY_FT},
    {"weight_lb", true, 200.0, 4000.0},
    {"pattern", false, 0, 0},
    {"modification", false, 0, 0},
    {"runway", false, 0, 0},
    {"series", false, 0, 0},
};
#define FIELD_COUNT (sizeof fields / sizeof fields[0])

struct request {
    const struct cli *cli;
    const char *words[2];
    int64_t run; /* 0: all landings */
    const char *who, *note, *correct, *reason, *observe, *side, *form, *series, *runway, *pattern,
        *modification, *withdraw_series;
    double station_ft, height_in, at_s; /* NaN: not given */
    int64_t panels, withdraw;           /* panels: 0: not given; withdraw: 0: not given */
    bool make_void, unvoid;
};

/* ---- series ---- */

static void list_series(struct store *store, struct answer *answer)
{
    struct store_series *rows = NULL;
    struct store_landing *landings = NULL;
    size_t count = 0, landed = 0;
    store_all_series_get(store, &rows, &count, fatal);
    store_landings_get(store, &landings, &landed, fatal);
    answer_open_table(answer, "series", "");
    for (size_t i = 0; i < count; i++) {
        char when[40];
        int64_t its = 0;
        for (size_t k = 0; k < landed; k++) {
            struct store_series of;
            store_landing_series_get(store, &landings[k], &of, fatal);
            its += of.id == rows[i].id;
        }
        survey_format_time(rows[i].made_us, when, sizeof when);
        answer_open_row(answer);
        answer_add_text(answer, "name", "series", "%s", rows[i].name);
        answer_add_text(answer, "begun", "begun", "%s", when);
        answer_add_text_or_missing(answer, "runway", "runway", rows[i].runway, "-");
        answer_add_text_or_missing(answer, "pattern", "pattern", rows[i].pattern, "-");
        answer_add_text_or_missing(answer, "modification", "modification", rows[i].modification,
                                   "-");
        answer_add_count(answer, "landings", "landings", its);
        if (rows[i].notes[0])
            answer_add_text(answer, NULL, "notes", "%s", rows[i].notes);
        answer_add_text_or_missing(answer, "who", NULL, rows[i].who, "-");
    }
    answer_close_group(answer);
    free(rows);
    free(landings);
}

static void begin_series(const struct request *r, struct store *store)
{
    struct store_series series = {.made_us = (int64_t)link_now_us()};
    struct store_series *rows = NULL;
    size_t count = 0;
    if (!r->series[0] || strlen(r->series) >= sizeof series.name)
        error_set(fatal, MR_USAGE, "not a name for a series: '%s'; give 1 to %zu characters",
                  r->series, sizeof series.name - 1);
    annotation_copy(series.name, sizeof series.name, r->series);
    annotation_copy(series.who, sizeof series.who, annotation_author(r->who));
    annotation_copy(series.runway, sizeof series.runway, r->runway);
    annotation_copy(series.pattern, sizeof series.pattern, r->pattern);
    annotation_copy(series.modification, sizeof series.modification, r->modification);
    annotation_copy(series.notes, sizeof series.notes, r->note);
    store_all_series_get(store, &rows, &count, fatal);
    for (size_t i = 0; i < count; i++) {
        if (strcmp(rows[i].name, series.name) == 0)
            error_set(fatal, MR_USAGE, "series '%s' exists already: %s; give a different name",
                      series.name, r->words[0]);
    }
    free(rows);
    store_series_add(store, &series, fatal);
}

/* Withdraws a series. Its landings then belong to the previous series; landings that a correction
 * assigned to it belong to no series. */
static void withdraw_series(const struct request *r, struct store *store)
{
    struct store_withdrawal row = {.kind = "series", .made_us = (int64_t)link_now_us()};
    struct store_series *rows = NULL;
    size_t count = 0;
    store_all_series_get(store, &rows, &count, fatal);
    for (size_t i = 0; i < count; i++)
        row.item = strcmp(rows[i].name, r->withdraw_series) == 0 ? rows[i].id : row.item;
    free(rows);
    if (!row.item)
        error_set(fatal, MR_UNKNOWN, "no series '%s': %s; matrig landing DB lists them",
                  r->withdraw_series, r->words[0]);
    if (strlen(r->reason) >= sizeof row.reason)
        error_set(fatal, MR_TOO_LONG,
                  "the text of --reason is too long; give at most %d characters",
                  STORE_JOURNAL_TEXT_SIZE - 1);
    annotation_copy(row.name, sizeof row.name, r->withdraw_series);
    annotation_copy(row.who, sizeof row.who, annotation_author(r->who));
    annotation_copy(row.reason, sizeof row.reason, r->reason);
    store_withdrawal_add(store, &row, fatal);
}

static void list_withdrawn(struct store *store, struct answer *answer)
{
    struct store_withdrawal *rows = NULL;
    size_t count = 0;
    store_withdrawals_get(store, &rows, &count, fatal);
    answer_open_table(answer, "withdrawn", "");
    for (size_t i = 0; i < count; i++) {
        char when[40];
        survey_format_time(rows[i].made_us, when, sizeof when);
        answer_open_row(answer);
        answer_add_text(answer, "kind", "withdrawn", "%s", rows[i].kind);
        answer_add_text(answer, "name", "name", "%s", rows[i].name);
        answer_add_text(answer, "made", "entered", "%s", when);
        answer_add_text_or_missing(answer, "who", "by", rows[i].who, "-");
        answer_add_text(answer, "reason", "reason", "%s", rows[i].reason);
    }
    answer_close_group(answer);
    free(rows);
}

/* ---- adding ---- */

static void store_change(const struct request *r, struct store *store, const char *field,
                         const char *value)
{
    struct store_change row = {.run = r->run, .made_us = (int64_t)link_now_us()};
    if (strlen(value) >= sizeof row.value || (r->reason && strlen(r->reason) >= sizeof row.reason))
        error_set(fatal, MR_TOO_LONG, "text too long: %s of RUN %lld; give at most %d characters",
                  field, (long long)r->run, STORE_JOURNAL_TEXT_SIZE - 1);
    annotation_copy(row.who, sizeof row.who, annotation_author(r->who));
    annotation_copy(row.field, sizeof row.field, field);
    annotation_copy(row.value, sizeof row.value, value);
    annotation_copy(row.reason, sizeof row.reason, r->reason);
    store_change_add(store, &row, fatal);
}

static void set_unknown_field_error(const char *argument)
{
    char word[40], text[SPELL_SUGGEST_TEXT_SIZE];
    struct spell_suggest near;
    snprintf(word, sizeof word, "%.*s", (int)strcspn(argument, "="), argument);
    spell_suggest_begin(&near, word);
    for (size_t i = 0; i < FIELD_COUNT; i++)
        spell_suggest_add(&near, fields[i].name);
    spell_suggest_text(&near, text);
    error_set(fatal, MR_USAGE,
              "cannot correct '%s'%s%s give FIELD=VALUE, where FIELD is touchdown_ft, weight_lb, "
              "pattern, modification, runway or series",
              argument, text, text[0] ? "" : ";");
}

/* Converts the number to the unit of the field. A number without a unit is stored as typed; a
 * converted number is stored with enough digits to be exact. */
static void parse_corrected_number(const struct field *field, const char *text, char kept[40])
{
    double number, alone;
    struct quantity_error wrong;
    const char *unit = quantity_unit_from_name(field->name);
    quantity_read(text, field->name, unit, NULL, &number, fatal);
    if (!(number >= field->low && number <= field->high))
        error_set(fatal, MR_USAGE, "out of range: %s for %s; allowed: %g to %g %s", text,
                  field->name, field->low, field->high, unit);
    if (strlen(text) < 40 && quantity_parse(text, "", NULL, &alone, &wrong))
        snprintf(kept, 40, "%s", text);
    for (int digits = 15; digits <= 17 && *kept == '\0'; digits++) {
        snprintf(kept, 40, "%.*g", digits, number);
        if (digits < 17 && strtod(kept, NULL) != number)
            kept[0] = '\0';
    }
}

static void store_correction(const struct request *r, struct store *store)
{
    char number[40] = "";
    const char *value = strchr(r->correct, '=');
    size_t length = value ? (size_t)(value - r->correct) : 0;
    const struct field *field = NULL;
    for (size_t i = 0; i < FIELD_COUNT; i++) {
        if (strlen(fields[i].name) == length && strncmp(fields[i].name, r->correct, length) == 0)
            field = &fields[i];
    }
    if (!field || !value[1]) {
        set_unknown_field_error(r->correct);
        return;
    }
    if (field->is_number)
        parse_corrected_number(field, value + 1, number);
    if (strcmp(field->name, "series") == 0) {
        struct store_series *rows;
        size_t count;
        bool there = false;
        store_all_series_get(store, &rows, &count, fatal);
        for (size_t i = 0; i < count; i++)
            there |= strcmp(rows[i].name, value + 1) == 0;
        free(rows);
        if (!there)
            error_set(fatal, MR_UNKNOWN, "no series '%s': %s; matrig landing DB lists them",
                      value + 1, r->words[0]);
    }
    store_change(r, store, field->name, field->is_number ? number : value + 1);
}

/* Refuses a wave after the end of the record, because the time is mistyped (300 s for 3.00 s) or
 * the landing is the wrong one. */
static void check_time(const struct request *r, struct store *store)
{
    struct measured_landing measured;
    if (isnan(r->at_s))
        return;
    measured_load_gear(store, r->run, &measured, fatal);
    double end_s = measured.is_t0_touchdown && !measured_ends_while_moving(&measured)
                     ? measured_time_s(&measured, measured.samples - 1)
                     : HUGE_VAL;
    measured_free(&measured);
    if (r->at_s > end_s)
        error_set(fatal, MR_USAGE,
                  "out of range: %g s for --at; the record of RUN %lld ends %.1f s after touchdown",
                  r->at_s, (long long)r->run, end_s);
}

static void store_observation(const struct request *r, struct store *store)
{
    struct store_observation row = {.run = r->run,
                                    .made_us = (int64_t)link_now_us(),
                                    .station_ft = r->station_ft,
                                    .height_in = r->height_in,
                                    .time_s = r->at_s,
                                    .panels = r->panels ? r->panels : STORE_NONE};
    if (isnan(r->station_ft) && !r->note)
        error_set(fatal, MR_USAGE,
                  "no position: --observe needs --station or --note; see matrig landing --help");
    if (r->note && strlen(r->note) >= sizeof row.note)
        error_set(fatal, MR_TOO_LONG,
                  "text too long: the note of RUN %lld; give at most %d characters",
                  (long long)r->run, STORE_JOURNAL_TEXT_SIZE - 1);
    check_time(r, store);
    annotation_copy(row.kind, sizeof row.kind, r->observe);
    annotation_copy(row.who, sizeof row.who, annotation_author(r->who));
    annotation_copy(row.side, sizeof row.side, r->side);
    annotation_copy(row.form, sizeof row.form, r->form);
    annotation_copy(row.note, sizeof row.note, r->note);
    store_observation_add(store, &row, fatal);
}

static void add_observation(const struct request *r, struct store *store)
{
    struct store_landing landing;
    bool is_void;
    store_landing_get(store, r->run, &landing, fatal);
    if (r->make_void || r->unvoid) {
        store_is_void(store, r->run, &is_void, NULL, fatal);
        if (is_void == r->make_void)
            error_set(fatal, MR_NOT_NOW, "RUN %lld is already %s: %s; nothing was changed",
                      (long long)r->run, is_void ? "void" : "not void", r->words[0]);
        store_change(r, store, "void", r->make_void ? "yes" : "no");
    } else if (r->correct)
        store_correction(r, store);
    else if (r->observe)
        store_observation(r, store);
    else if (r->withdraw)
        store_observation_withdraw(store, r->run, r->withdraw, (int64_t)link_now_us(),
                                   annotation_author(r->who), r->reason ? r->reason : "", fatal);
    else
        store_change(r, store, "note", r->note);
}

/* ---- showing ---- */

static void add_journal(const struct store_landing *landing, const struct journal *j,
                        struct answer *answer)
{
    char heading[6 * STORE_JOURNAL_TEXT_SIZE];
    snprintf(heading, sizeof heading,
             "RUN %lld: landing %lld, %s%s, series %s, runway %s, pattern %s, modification %s",
             (long long)landing->id, (long long)landing->board_landing,
             mr_landing_state_text((unsigned)landing->state), j->is_void ? ", VOID" : "",
             text_or_dash(j->series.name), text_or_dash(j->series.runway),
             text_or_dash(j->series.pattern), text_or_dash(j->series.modification));
    answer_open_group(answer, NULL, heading);
    answer_add_count(answer, "run", NULL, landing->id);
    answer_add_count(answer, "landing", NULL, landing->board_landing);
    answer_add_flag(answer, "void", NULL, j->is_void);
    answer_add_text_or_missing(answer, "series", NULL, j->series.name, NULL);
    answer_add_text_or_missing(answer, "runway", NULL, j->series.runway, NULL);
    answer_add_text_or_missing(answer, "pattern", NULL, j->series.pattern, NULL);
    answer_add_text_or_missing(answer, "modification", NULL, j->series.modification, NULL);
    journal_add_tables(j, answer);
    answer_close_group(answer);
}

static void show_landing(const struct request *r, struct store *store, struct answer *answer)
{
    struct store_landing *rows = NULL, landing;
    struct journal j;
    size_t count = 0;
    store_landings_get(store, &rows, &count, fatal);
    if (count == 0 && !r->run)
        cli_note(r->cli, "no landing yet: %s; record landings with matrig log --db %s", r->words[0],
                 r->words[0]);
    if (r->run)
        store_landing_get(store, r->run, &landing, fatal);
    for (size_t i = 0; i < count; i++) {
        if (r->run && rows[i].id != r->run)
            continue;
        journal_load(store, &rows[i], &j, fatal);
        add_journal(&rows[i], &j, answer);
        journal_free(&j);
    }
    free(rows);
}

static void check_request(struct request *r)
{
    int acts = r->make_void + r->unvoid + (r->correct != NULL) + (r->observe != NULL) +
               (r->withdraw != 0) + (r->note && !r->observe);
    bool details = !isnan(r->station_ft) || r->panels || !isnan(r->height_in) || r->side ||
                   !isnan(r->at_s) || r->form;
    if (r->words[1])
        parse_run(r->words[1], &r->run, fatal);
    if ((r->runway || r->pattern || r->modification) && !r->series)
        error_set(fatal, MR_USAGE,
                  "no series: --runway, --pattern and --modification need --series NAME; see "
                  "matrig landing --help");
    if (r->series && (r->run || acts > (r->note != NULL)))
        error_set(fatal, MR_USAGE,
                  "--series begins a new series, without a RUN or an action: matrig landing DB "
                  "--series NAME; see matrig landing --help");
    if (r->withdraw_series && (r->series || r->run || acts))
        error_set(fatal, MR_USAGE,
                  "--withdraw-series works without a RUN or another action: matrig landing DB "
                  "--withdraw-series NAME --reason T");
    if (r->series)
        return;
    if (acts && !r->run)
        error_set(fatal, MR_USAGE,
                  "no landing: give matrig landing DB RUN; see matrig landing --help");
    if (acts > 1)
        error_set(fatal, MR_USAGE,
                  "more than one action: give one of --note, --correct, --observe, --withdraw, "
                  "--void or --unvoid; see matrig landing --help");
    if ((r->make_void || r->unvoid || r->correct || r->withdraw || r->withdraw_series) &&
        !(r->reason && r->reason[0]))
        error_set(fatal, MR_USAGE,
                  "no reason: --correct, --withdraw, --void and --unvoid need --reason TEXT");
    if (r->note && !r->note[0])
        error_set(fatal, MR_USAGE, "the text of --note is empty; give a text");
    if (details && !r->observe)
        error_set(fatal, MR_USAGE,
                  "--station, --panels, --height, --side, --at and --form need --observe; see "
                  "matrig landing --help");
}

static int landing_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {.cli = cli};
    struct answer *answer = answer_new(cli->si);
    command_parse(&command_landing, argc, argv, cli, &r, r.words, fatal);
    check_request(&r);
    bool acts = r.note || r.correct || r.observe || r.withdraw || r.make_void || r.unvoid;
    struct store *store = r.series
                            ? program_open_or_create_campaign(cli, r.words[0])
                            : program_open_campaign(
                                  r.words[0], acts || r.withdraw_series ? STORE_OPEN : STORE_READ);
    store_find_run(store, &r.run, fatal);
    if (r.series)
        begin_series(&r, store);
    else if (r.withdraw_series)
        withdraw_series(&r, store);
    else if (acts)
        add_observation(&r, store);
    answer_open_list(answer, "landings", "");
    show_landing(&r, store, answer);
    answer_close_group(answer);
    if (!r.run)
        list_series(store, answer);
    if (!r.run)
        list_withdrawn(store, answer);
    return answer_print(cli, answer, 0);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB [RUN]",
              "campaign database and landing; without RUN, all landings are listed. No data is "
              "deleted: author, time, old value and reason of a change are kept and shown"),
    OPTION_TEXT("--note", "T", note, "add a note"),
    OPTION_TEXT("--correct", "F=V", correct,
                "correct touchdown_ft (touchdown station), weight_lb (aircraft weight), pattern, "
                "modification, runway or series; needs --reason"),
    OPTION_FLAG("--void", make_void,
                "exclude the landing from report and compare, unless they run with --void. "
                "--unvoid includes the landing again. Both need --reason"),
    OPTION_CHOICE("--observe", "K", observe, "observation", "wave|break|other",
                  "record a wave, break or other observation, with --station FT, --panels N, "
                  "--height IN, --side left|right|centre|across, --form T (two-panel, end "
                  "connector, ...), --at S (after touchdown), --note T"),
    OPTION_INTEGER("--withdraw", "N", withdraw, 1.0, 1e9, 0.0,
                   "withdraw observation N; needs --reason"),
    OPTION_TEXT("--series", "NAME", series,
                "begin a series: all later landings belong to it. With --runway T, --pattern T, "
                "--modification T, --note T. matrig landing DB lists the series"),
    OPTION_TEXT("--withdraw-series", "NAME", withdraw_series,
                "withdraw a series begun by mistake: its landings move to the preceding series; "
                "needs --reason"),
    OPTION_TEXT("--who", "W", who, "author; default: the user"),
    HELP_EXAMPLE("matrig landing campaign.db 5 --observe wave --station 88 --panels 2 --height 0.6 "
                 "--side left --form two-panel"),
    OPTION_TEXT("--reason", "T", reason, NULL),
    OPTION_NUMBER_SI("--station", "FT", station_ft, "ft", "m", 0.0, RIG_RUNWAY_FT, (double)NAN,
                     NULL),
    OPTION_INTEGER("--panels", "N", panels, 1.0, 60.0, 0.0, NULL),
    OPTION_NUMBER_SI("--height", "IN", height_in, "in", "mm", 0.0, 7.0, (double)NAN, NULL),
    OPTION_CHOICE("--side", "S", side, "side", "left|right|centre|across", NULL),
    OPTION_NUMBER("--at", "S", at_s, "s", -1.0, 60.0, (double)NAN, NULL),
    OPTION_TEXT("--form", "T", form, NULL),
    OPTION_FLAG("--unvoid", unvoid, NULL),
    OPTION_TEXT("--runway", "T", runway, NULL),
    OPTION_TEXT("--pattern", "T", pattern, NULL),
    OPTION_TEXT("--modification", "T", modification, NULL),
};

const struct command command_landing = {
    "landing",
    landing_command,
    "DB [RUN] [--note T | --correct FIELD=VALUE | --observe wave|break|other ... | --withdraw N | "
    "--void | --unvoid] [--reason T] [--who W]\nDB --series NAME [--runway T] [--pattern T] "
    "[--modification T] [--note T] [--who W]\nDB --withdraw-series NAME --reason T [--who W]",
    "add notes, corrections and observations to landings; begin series of landings",
    COMMAND_PARTS(parts),
    {1, 2, "DB [RUN]"},
};
