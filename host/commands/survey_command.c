/* The command matrig survey: enters and analyses caliper readings of the gage points, and loads the
 * joint openings into a board. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "common/command.h"
#include "host/base/answer.h"
#include "host/board/dialogue.h"
#include "host/commands/annotation.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/link/link.h"
#include "host/base/output.h"
#include "host/survey/survey.h"
#include "host/base/units.h"

#define LINE_MAX_BYTES 256

/* ---- results of a survey ---- */

static void add_survey_heading(const struct survey *survey, struct answer *answer)
{
    const struct store_gage_survey *row = &survey->row;
    bool ended = row->ended_us != STORE_NONE;
    char when[40];
    survey_format_time(row->made_us, when, sizeof when);
    answer_add_count(answer, "survey", "survey", row->id)->suffix = ended ? ", ended"
                                                                          : ", in progress";
    answer_add_flag(answer, "ended", NULL, ended);
    answer_add_text(answer, NULL, "begun", "%s%s%s", when, row->who[0] ? " by " : "", row->who);
    if (row->after_run == STORE_NONE)
        answer_add_missing_value(answer, "after_run", NULL, NULL);
    else
        answer_add_count(answer, "after_run", "after RUN", row->after_run);
    answer_add_text(answer, NULL, "read", "%zu of %zu, %zu confirmed",
                    survey_progress_count_read(&survey->progress), survey->progress.plan.count,
                    survey->confirmed_readings);
    answer_add_count(answer, "read", NULL, (int64_t)survey_progress_count_read(&survey->progress));
    answer_add_count(answer, "of", NULL, (int64_t)survey->progress.plan.count);
    answer_add_count(answer, "confirmed", NULL, (int64_t)survey->confirmed_readings);
    answer_add_text(answer, "note", row->note[0] ? "note" : NULL, "%s", row->note);
}

static const char *const reading_line_names[SURVEY_DIAGONALS] = {
    "line 1", "line 2", "line 3", "line 4", "line 5", "line 6", "line 7"};

/* Adds the changes between gage points along the runway. The printed table has only places with
 * readings; for the JSON, add_matrices adds all places. */
static void add_spans(const struct survey *survey, const struct survey_results *found,
                      struct answer *answer)
{
    bool changed = found->previous_survey != 0;
    answer_open_table(
        answer, NULL,
        changed ? "change of the length of ten mats since the previous survey, and the present "
                  "opening of their joints"
                : "length of ten mats between gage points, and the opening of their joints");
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        bool any = false;
        for (unsigned line = 0; line < SURVEY_LINES; line++)
            any |= !isnan(survey->readings.gap_in[line][k]);
        if (!any)
            continue;
        answer_open_row(answer);
        answer_add_value(answer, NULL, "at", UNIT_STATION, SURVEY_SPAN_LENGTH_FT * k, 1);
        for (unsigned line = 0; line < SURVEY_LINES; line++) {
            double gap_in = (changed ? found->since_previous.change.gap_in
                                     : survey->readings.gap_in)[line][k];
            answer_add_value(answer, NULL, reading_line_names[line], UNIT_DISPLACEMENT, gap_in, 4)
                ->shows_sign = changed;
        }
        answer_add_estimate(answer, NULL, "opening", UNIT_DISPLACEMENT,
                            found->slack.segment[k].value_in, found->slack.segment[k].error_in, 4);
    }
    answer_close_group(answer);
    if (changed)
        answer_add_value(answer, NULL, "error of each change", UNIT_DISPLACEMENT,
                         found->since_previous.change.error_in, 4);
}

/* Adds the changes across the runway and along the diagonals. Tables without readings are
 * omitted. */
static void add_across_and_diagonals(const struct survey_readings *change, struct answer *answer)
{
    const struct {
        const char *title;
        double step_ft; /* distance between places; 0: places are numbered */
        unsigned lines, places;
        const double *value_in;
    } tables[] = {{"sideways movement at the stations since the previous survey",
                   SURVEY_STATION_SPACING_FT, SURVEY_LINES, SURVEY_STATIONS, change->across_in[0]},
                  {"change of the length of ten mats along the 45 degree lines", 0.0,
                   SURVEY_DIAGONALS, SURVEY_DIAGONAL_SPANS, change->diagonal_in[0]}};
    for (size_t t = 0; t < sizeof tables / sizeof tables[0]; t++) {
        answer_open_table(answer, NULL, tables[t].title);
        for (unsigned k = 0; k < tables[t].places; k++) {
            bool any = false;
            for (unsigned line = 0; line < tables[t].lines; line++)
                any |= !isnan(tables[t].value_in[line * tables[t].places + k]);
            if (!any)
                continue;
            answer_open_row(answer);
            if (tables[t].step_ft > 0.0)
                answer_add_value(answer, NULL, "at", UNIT_STATION, tables[t].step_ft * k, 1);
            else
                answer_add_count(answer, NULL, "ten mats", k + 1);
            for (unsigned line = 0; line < tables[t].lines; line++)
                answer_add_value(answer, NULL, reading_line_names[line], UNIT_DISPLACEMENT,
                                 tables[t].value_in[line * tables[t].places + k], 4)
                    ->shows_sign = true;
        }
        answer_close_group(answer);
    }
}

/* Adds the movement every 10 ft, at the nearest gage point. */
static void add_movement(const struct survey_results *found, struct answer *answer)
{
    answer_open_table(
        answer, NULL,
        "movement downfield since the previous survey, and bow since the first survey");
    for (unsigned s = 0; s < SURVEY_STATIONS && found->since_previous.compared_reading_count > 0;
         s++) {
        unsigned k = (unsigned)lround(SURVEY_STATION_SPACING_FT * s / SURVEY_SPAN_LENGTH_FT);
        answer_open_row(answer);
        answer_add_value(answer, NULL, "at", UNIT_STATION, SURVEY_SPAN_LENGTH_FT * k, 1);
        for (unsigned line = 0; line < SURVEY_LINES; line++) {
            const struct survey_estimate *u = &found->since_previous.movement[line][k];
            answer_add_estimate(answer, NULL, reading_line_names[line], UNIT_DISPLACEMENT,
                                u->value_in, u->error_in, 3)
                ->shows_sign = true;
        }
        answer_add_value(answer, NULL, "bow", UNIT_DISPLACEMENT, found->since_first.bow[k].value_in,
                         3)
            ->shows_sign = true;
    }
    answer_close_group(answer);
}

static json_t *estimates_to_json(const struct survey_estimate *e, size_t count, double factor)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, json_pack("[o,o]", cli_json_number(e[i].value_in * factor, 6),
                                              cli_json_number(e[i].error_in * factor, 4)));
    return list;
}

static json_t *numbers_to_json(const double *value, size_t count, double factor)
{
    json_t *list = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(list, cli_json_number(value[i] * factor, 7));
    return list;
}

static json_t *readings_to_json(const struct survey_readings *r, double factor)
{
    json_t *gaps = json_array(), *stations = json_array(), *across = json_array(),
           *diagonals = json_array();
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        json_array_append_new(gaps, numbers_to_json(r->gap_in[line], SURVEY_SPANS, factor));
        json_array_append_new(stations,
                              numbers_to_json(r->station_in[line], SURVEY_STATIONS, factor));
        json_array_append_new(across, numbers_to_json(r->across_in[line], SURVEY_STATIONS, factor));
    }
    for (unsigned line = 0; line < SURVEY_DIAGONALS; line++)
        json_array_append_new(diagonals,
                              numbers_to_json(r->diagonal_in[line], SURVEY_DIAGONAL_SPANS, factor));
    return json_pack("{sososososo}", "gap", gaps, "station", stations, "across", across, "diagonal",
                     diagonals, "error", cli_json_number(r->error_in * factor, 4));
}

static json_t *change_to_json(const struct survey_change *change, double factor)
{
    json_t *lines = json_array();
    for (unsigned line = 0; line < SURVEY_LINES; line++)
        json_array_append_new(lines,
                              estimates_to_json(change->movement[line], SURVEY_POINTS, factor));
    return lines;
}

static void add_worst_bow(const struct survey_results *found, struct answer *answer)
{
    const bool si = answer_is_si(answer);
    const struct unit *length = unit_get(UNIT_DISPLACEMENT, si),
                      *station = unit_get(UNIT_STATION, si);
    double worst = found->worst_bow_in * length->factor,
           error = found->worst_bow_error_in * length->factor;
    double at = found->worst_bow_station_ft * station->factor,
           limit = SURVEY_BOW_LIMIT_IN * length->factor;
    const char *verdict = survey_describe_bow(found);
    if (!found->first_survey)
        answer_add_sentence(answer, NULL, "first survey: later surveys are compared with this one");
    else if (isnan(worst))
        answer_add_sentence(answer, NULL,
                            "in-plane bow: unknown; read lines 1 and 4, and line 2 or 3");
    else
        answer_add_sentence(answer, NULL,
                            "largest in-plane bow since survey %lld: %+.3f +- %.3f %s, at %.1f %s: "
                            "%s the limit of %.3f %s",
                            (long long)found->first_survey, worst, error, length->text, at,
                            station->text, verdict, limit, length->text);
    if (!found->previous_survey)
        return;
    answer_open_group(answer, "worst_bow", NULL);
    answer_add_value(answer, "value", NULL, UNIT_NUMBER, worst, 3);
    answer_add_value(answer, "error", NULL, UNIT_NUMBER, error, 3)->digits = 4;
    answer_add_value(answer, "station", NULL, UNIT_NUMBER, at, 1);
    answer_add_value(answer, "limit", NULL, UNIT_NUMBER, limit, 3);
    answer_add_text(answer, "verdict", NULL, "%s", verdict);
    answer_close_group(answer);
}

/* Adds the values of all places, including those without a reading, to the JSON only. */
static void add_matrices(const struct survey *survey, const struct survey_results *found,
                         struct answer *answer, double factor)
{
    answer_add_json(answer, "readings", readings_to_json(&survey->readings, factor));
    answer_add_json(answer, "slack", estimates_to_json(found->slack.segment, SURVEY_SPANS, factor));
    if (!found->previous_survey)
        return;
    answer_add_json(answer, "change", readings_to_json(&found->since_previous.change, factor));
    answer_add_json(answer, "moved", change_to_json(&found->since_previous, factor));
    answer_add_json(answer, "bow",
                    estimates_to_json(found->since_first.bow, SURVEY_POINTS, factor));
}

static void add_survey(const struct survey *survey, const struct survey_results *found,
                       struct answer *answer)
{
    const struct unit *length = unit_get(UNIT_DISPLACEMENT, answer_is_si(answer));
    add_survey_heading(survey, answer);
    answer_add_text(answer, "length_unit", NULL, "%s", length->text);
    if (found->previous_survey)
        answer_add_count(answer, "since", "compared with survey", found->previous_survey);
    add_spans(survey, found, answer);
    if (found->previous_survey) {
        add_movement(found, answer);
        add_across_and_diagonals(&found->since_previous.change, answer);
    }
    add_matrices(survey, found, answer, length->factor);
    add_worst_bow(found, answer);
}

/* ---- the command ---- */

struct request {
    const struct cli *cli;
    const char *db, *edges_text, *note, *from, *sheet, *load, *reason;
    bool starts_new_survey, end, show, can, doubtful, force;
    enum survey_edges edges;
    double closed_in, error_in;
    int64_t number, withdraw; /* number: 0: the newest survey; withdraw: 0: none */
};

/* ---- typed readings ---- */

struct entry_session {
    const struct request *request;
    struct store *store;
    struct survey *survey;
    const char *source;
    bool has_quit;
};

static double convert_for_display(const struct request *request, double value_in)
{
    return value_in * unit_get(UNIT_DISPLACEMENT, request->cli->si)->factor;
}

static void print_prompt(const struct entry_session *session)
{
    const struct survey_progress *progress = &session->survey->progress;
    bool si = session->request->cli->si;
    char text[120];
    if (session->request->cli->quiet || progress->current_item == progress->plan.count)
        return;
    survey_item_format(&progress->plan.item[progress->current_item], si, text, sizeof text);
    fprintf(stderr, "%zu/%zu  %s", survey_progress_count_read(progress), progress->plan.count,
            text);
    if (!isnan(progress->value_in[progress->current_item]))
        fprintf(stderr, ", read: %.*f", si ? 2 : 3,
                convert_for_display(session->request, progress->value_in[progress->current_item]));
    if (!isnan(progress->previous_in[progress->current_item]))
        fprintf(
            stderr, ", last %.*f", si ? 2 : 3,
            convert_for_display(session->request, progress->previous_in[progress->current_item]));
    fprintf(stderr, ", %s: ", unit_get(UNIT_DISPLACEMENT, si)->text);
}

static void store_reading(struct entry_session *session, size_t item,
                          enum survey_entry_outcome outcome, const char *note)
{
    const struct survey_progress *progress = &session->survey->progress;
    const struct survey_item *place = &progress->plan.item[item];
    struct store_gage_reading reading = {.line = place->line,
                                         .place = place->index,
                                         .value_in = progress->value_in[item],
                                         .skipped = progress->is_skipped[item],
                                         .confirmed = outcome == SURVEY_OUTCOME_CONFIRMED,
                                         .taken_us = (int64_t)link_now_us()};
    snprintf(reading.kind, sizeof reading.kind, "%s", survey_item_kind_text[place->kind]);
    snprintf(reading.source, sizeof reading.source, "%s", session->source);
    snprintf(reading.note, sizeof reading.note, "%s", note ? note : "");
    store_gage_reading_add(session->store, session->survey->row.id, &reading, fatal);
}

static void report_outcome(const struct entry_session *session, enum survey_entry_outcome outcome,
                           size_t item, const struct survey_entry *entry)
{
    const struct survey_progress *progress = &session->survey->progress;
    const struct request *r = session->request;
    const struct unit *unit = unit_get(UNIT_DISPLACEMENT, r->cli->si);
    if (r->cli->quiet)
        return;
    if (outcome == SURVEY_OUTCOME_DOUBTFUL) {
        double away_in = entry->value_in - survey_progress_expected_in(progress, item);
        fprintf(stderr,
                "%s  %.3f %s differs by %+.3f from %s; at most %.3f is expected. Type the same "
                "value again to confirm it, or type a new reading.\n",
                cli_is_stderr_terminal() ? "\a" : "", convert_for_display(r, entry->value_in),
                unit->text, convert_for_display(r, away_in),
                isnan(progress->previous_in[item]) ? "the design distance" : "the last reading",
                convert_for_display(r, survey_item_limit_in(&progress->plan.item[item])));
    } else if (outcome == SURVEY_OUTCOME_REFUSED) {
        const char *bell = cli_is_stderr_terminal() ? "\a" : "";
        if (entry->error.what[0])
            fprintf(stderr, "%s  not a reading: %s; %s\n", bell, entry->error.what,
                    entry->error.advice);
        else
            fprintf(stderr, "%s  %s\n", bell,
                    entry->kind == SURVEY_ENTRY_INVALID
                        ? "not a reading; type a number and Enter, or ? for help"
                        : "not here");
    } else if (outcome == SURVEY_OUTCOME_UNDONE || outcome == SURVEY_OUTCOME_SKIPPED ||
               outcome == SURVEY_OUTCOME_NOTED) {
        char text[120];
        survey_item_format(&progress->plan.item[item], r->cli->si, text, sizeof text);
        fprintf(stderr, "  %s: %s\n",
                outcome == SURVEY_OUTCOME_UNDONE    ? "undone"
                : outcome == SURVEY_OUTCOME_SKIPPED ? "skipped"
                                                    : "noted",
                text);
    }
}

/* Processes one line that the user typed. */
static void handle_line(struct entry_session *session, const char *line)
{
    struct survey_entry entry;
    size_t item = 0;
    survey_entry_parse(line, session->request->cli->si, &entry);
    session->has_quit |= entry.kind == SURVEY_ENTRY_QUIT;
    if (entry.kind == SURVEY_ENTRY_EMPTY || entry.kind == SURVEY_ENTRY_QUIT)
        return;
    if (entry.kind == SURVEY_ENTRY_HELP) {
        fputs(
            "  a number  the reading (mm, in or ft may follow it)   s  skip   u  undo the last   b "
            " back\n  n TEXT    note on the last reading               q  quit; continue later\n",
            stderr);
        return;
    }
    enum survey_entry_outcome outcome = survey_progress_apply(&session->survey->progress, &entry,
                                                              &item);
    if (outcome == SURVEY_OUTCOME_STORED || outcome == SURVEY_OUTCOME_CONFIRMED ||
        outcome == SURVEY_OUTCOME_UNDONE || outcome == SURVEY_OUTCOME_SKIPPED ||
        outcome == SURVEY_OUTCOME_NOTED)
        store_reading(session, item, outcome, entry.note);
    report_outcome(session, outcome, item, &entry);
}

/* A line that is being typed. Bytes are collected until Enter; a line that is too long is
 * ignored. */
struct input_line {
    char text[LINE_MAX_BYTES];
    size_t length;
    bool is_too_long;
};

static void handle_typed_bytes(struct entry_session *session, struct input_line *line,
                               const char *bytes, size_t count)
{
    for (size_t i = 0; i < count && !session->has_quit; i++) {
        bool end = bytes[i] == '\n' || bytes[i] == '\r';
        if (!end && line->length + 1 < sizeof line->text && bytes[i] != '\0') {
            line->text[line->length++] = bytes[i];
            continue;
        }
        line->is_too_long |= !end;
        if (!end)
            continue;
        line->text[line->length] = '\0';
        handle_line(session, line->is_too_long ? "too long" : line->text);
        bool empty = line->length == 0;
        line->length = 0;
        line->is_too_long = false;
        if (session->survey->progress.current_item == session->survey->progress.plan.count)
            session->has_quit = true;
        if (!session->has_quit && !empty)
            print_prompt(session);
    }
}

/* Reads lines until all readings are entered, the user types q, or the input ends. */
static void enter_readings(struct entry_session *session)
{
    struct input_line keys = {.length = 0};
    char bytes[4096];
    ssize_t count = 1;
    session->has_quit = session->survey->progress.current_item ==
                        session->survey->progress.plan.count;
    if (!session->has_quit)
        print_prompt(session);
    while (!session->has_quit && count > 0) {
        count = read(STDIN_FILENO, bytes, sizeof bytes);
        if (count < 0 && errno == EINTR)
            continue;
        handle_typed_bytes(session, &keys, count > 0 ? bytes : "\n", count > 0 ? (size_t)count : 1);
    }
    if (!session->request->cli->quiet)
        fputc('\n', stderr);
}

/* ---- a sheet ---- */

/* Reads all readings from a sheet. Without --doubtful, refuses readings that a user at the keyboard
 * would have to confirm. */
static void read_sheet(struct entry_session *session)
{
    static struct survey_sheet sheet;
    struct survey_progress *progress = &session->survey->progress;
    const struct request *request = session->request;
    size_t doubted = 0, item;
    survey_sheet_read(request->from, &progress->plan, &sheet, fatal);
    store_begin(session->store, fatal);
    for (size_t i = 0; i < progress->plan.count; i++) {
        struct survey_entry entry = {.kind = SURVEY_ENTRY_NUMBER, .value_in = sheet.value_in[i]};
        if (isnan(sheet.value_in[i]))
            continue;
        progress->current_item = i;
        progress->has_doubtful_value = false;
        enum survey_entry_outcome outcome = survey_progress_apply(progress, &entry, &item);
        if (outcome == SURVEY_OUTCOME_DOUBTFUL && request->doubtful) {
            outcome = survey_progress_apply(progress, &entry, &item);
        } else if (outcome == SURVEY_OUTCOME_DOUBTFUL) {
            char text[120];
            survey_item_format(&progress->plan.item[i], request->cli->si, text, sizeof text);
            cli_note(
                request->cli, "reading not accepted, because it differs by %+.3f %s from %s: %s",
                convert_for_display(request,
                                    entry.value_in - survey_progress_expected_in(progress, i)),
                unit_get(UNIT_DISPLACEMENT, request->cli->si)->text,
                isnan(progress->previous_in[i]) ? "the design distance" : "the last reading", text);
            doubted++;
            continue;
        }
        store_reading(session, i, outcome, sheet.note[i]);
    }
    store_commit(session->store, fatal);
    survey_progress_move_to_next(progress, 0);
    if (doubted)
        error_set(
            fatal, MR_LIMIT,
            "%zu reading%s not accepted: %s; measure again, or accept all readings with --doubtful",
            doubted, doubted == 1 ? "" : "s", request->from);
}

/* ---- one run of the command ---- */

/* readings that differ by less are identical; a caliper resolves 0.0005 in */
#define EQUAL_READING_TOLERANCE_IN 1e-6
/* two different surveys never have this many identical readings */
#define EQUAL_READINGS_MIN         10u

/* Refuses a sheet with the readings of the newest survey, because the result would be a runway that
 * has not moved. */
static void refuse_identical_sheet(const struct request *request, struct store *store,
                                   const struct survey_sheet *sheet)
{
    static struct survey newest;
    struct error none = {0};
    size_t read = 0, same = 0;
    if (request->doubtful || survey_load(store, 0, &newest, &none) != MR_OK ||
        strcmp(newest.row.edges, survey_edges_text[request->edges]) != 0)
        return;
    for (size_t i = 0; i < newest.progress.plan.count; i++) {
        read += isnan(sheet->value_in[i]) ? 0u : 1u;
        same += fabs(sheet->value_in[i] - newest.progress.value_in[i]) < EQUAL_READING_TOLERANCE_IN
                  ? 1u
                  : 0u;
    }
    if (same == read && read >= EQUAL_READINGS_MIN)
        error_set(fatal, MR_LIMIT,
                  "all %zu readings are equal to those of survey %lld: %s; give the sheet of the "
                  "new survey, or accept all readings with --doubtful",
                  read, (long long)newest.row.id, request->from);
}

/* Checks the sheet before a survey or a campaign is created, so that an unreadable sheet does not
 * create one. `store`: NULL if the campaign does not exist. */
static void check_sheet(const struct request *request, struct store *store)
{
    static struct survey_progress progress;
    static struct survey_sheet sheet;
    if (!request->from)
        return;
    survey_progress_init(&progress, request->edges);
    survey_sheet_read(request->from, &progress.plan, &sheet, fatal);
    if (store)
        refuse_identical_sheet(request, store, &sheet);
}

static void begin_survey(const struct request *request, struct store *store, struct survey *survey)
{
    bool found = false;
    if (!request->starts_new_survey)
        survey_load_unfinished(store, survey, &found, fatal);
    if (found) {
        cli_note(request->cli,
                 "continuing survey %lld, %zu of %zu points read (--new begins a new survey)",
                 (long long)survey->row.id, survey_progress_count_read(&survey->progress),
                 survey->progress.plan.count);
        return;
    }
    check_sheet(request, store);
    struct store_gage_survey row = {.made_us = (int64_t)link_now_us(),
                                    .error_in = request->error_in,
                                    .closed_in = request->closed_in};
    snprintf(row.edges, sizeof row.edges, "%s", survey_edges_text[request->edges]);
    annotation_copy(row.who, sizeof row.who, annotation_author(NULL));
    snprintf(row.note, sizeof row.note, "%s", request->note ? request->note : "");
    store_gage_survey_add(store, &row, fatal);
    survey_load(store, row.id, survey, fatal);
}

/* Withdraws a survey. The readings stay in the campaign, but all commands ignore them. */
static int withdraw_survey(const struct request *request, struct store *store)
{
    static struct survey survey;
    struct store_withdrawal row = {
        .kind = "survey", .item = request->withdraw, .made_us = (int64_t)link_now_us()};
    int64_t runway_loaded_us = 0;
    survey_load(store, row.item, &survey, fatal);
    snprintf(row.name, sizeof row.name, "%lld", (long long)row.item);
    annotation_copy(row.who, sizeof row.who, annotation_author(NULL));
    annotation_copy(row.reason, sizeof row.reason, request->reason);
    store_withdrawal_add(store, &row, fatal);
    store_gage_load_time_get(store, row.item, &runway_loaded_us, fatal);
    cli_note(request->cli, "survey %lld was withdrawn, with %zu readings%s", (long long)row.item,
             survey_progress_count_read(&survey.progress),
             runway_loaded_us
                 ? "; the board still uses it: load a different survey, or reset the board"
                 : "");
    return request->cli->json
             ? cli_print_json(json_pack("{sI}", "withdrawn", (json_int_t)row.item), 0)
             : 0;
}

/* Refuses to finish an empty survey, which would hide the previous survey. */
static void check_completeness(const struct request *request, struct store *store,
                               struct survey *survey)
{
    bool found = false;
    survey_load_unfinished(store, survey, &found, fatal);
    if (!found)
        error_set(fatal, MR_NOT_NOW, "no unfinished survey: %s; --show prints the newest survey",
                  request->db);
    if (survey_progress_count_read(&survey->progress) == 0)
        error_set(fatal, MR_NOT_NOW,
                  "no readings: survey %lld of %s; enter readings, or withdraw the survey: "
                  "--withdraw %lld --reason T",
                  (long long)survey->row.id, request->db, (long long)survey->row.id);
}

static void run_survey(const struct request *request, struct store *store, struct survey *survey)
{
    struct entry_session session = {.request = request,
                                    .store = store,
                                    .survey = survey,
                                    .source = request->from ? request->from : "keyboard"};
    store_set_durable(store, fatal);
    if (request->end)
        check_completeness(request, store, survey);
    else
        begin_survey(request, store, survey);
    int64_t id = survey->row.id;
    if (request->from)
        read_sheet(&session);
    else if (!request->end)
        enter_readings(&session);
    if (request->end || survey->progress.current_item == survey->progress.plan.count)
        store_gage_survey_end(store, id, (int64_t)link_now_us(), fatal);
    survey_load(store, id, survey, fatal);
}

/* ---- loading ---- */

struct load_result {
    unsigned sent_segment_count; /* number of segments sent to the board */
    /* number of these segments for which the board reports a different value */
    unsigned different_segment_count;
    unsigned
        /* number of segments that were set in the board by an earlier survey only */
        older_segment_count;
};

/* time without an answer after which the command is sent again, s */
#define ANSWER_TIMEOUT_S      2.0
#define TRIES_MAX             3
#define OPENING_RESOLUTION_IN 1e-4 /* resolution of openings in the command and in the answer */

struct board_load {
    struct dialogue *dialogue;
    bool received[SURVEY_SPANS];
    unsigned received_count;
    double slack_in[SURVEY_SPANS];
};

static enum mr_status handle_slack(void *context, const struct dialogue_message *message,
                                   struct error *error)
{
    struct board_load *l = context;
    struct mr_slack slack;
    (void)error;
    if (message->id == MR_ID_SLACK &&
        mr_slack_get(&slack, message->payload, message->length) == MR_OK &&
        slack.segment < SURVEY_SPANS) {
        l->received_count += !l->received[slack.segment];
        l->received[slack.segment] = true;
        l->slack_in[slack.segment] = (double)slack.slack_in;
    }
    return MR_OK;
}

static bool has_all_segments(const void *context)
{
    return ((const struct board_load *)context)->received_count == SURVEY_SPANS;
}

static void send_command(struct board_load *l, unsigned code, unsigned segment, int32_t argument)
{
    dialogue_execute(l->dialogue,
                     &(struct dialogue_command){.code = (uint8_t)code,
                                                .index = (uint8_t)segment,
                                                .argument = argument,
                                                .answer_timeout_s = ANSWER_TIMEOUT_S,
                                                .tries_max = TRIES_MAX},
                     "a landing is armed or in progress; disarm the board, or wait", fatal);
}

static void read_stored_slacks(struct board_load *l)
{
    memset(l->received, 0, sizeof l->received);
    l->received_count = 0;
    for (int tries = 0; tries < TRIES_MAX; tries++) {
        send_command(l, MR_COMMAND_STATE, 0, 0);
        if (dialogue_wait_until(l->dialogue, has_all_segments, l, ANSWER_TIMEOUT_S, fatal) == MR_OK)
            return;
    }
    error_set(fatal, MR_TIMEOUT,
              "the board reported only %u of %u segments of its runway: %s; load the survey again",
              l->received_count, SURVEY_SPANS, dialogue_spec(l->dialogue));
}

static void compare_slacks(const struct board_load *l, const struct survey_slack *slack,
                           struct load_result *loaded)
{
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        double wanted_in = slack->segment[k].value_in;
        if (isnan(wanted_in))
            loaded->older_segment_count += isnan(l->slack_in[k]) ? 0u : 1u;
        else
            loaded->different_segment_count +=
                fabs(l->slack_in[k] - wanted_in) <= 0.51 * OPENING_RESOLUTION_IN ? 0u : 1u;
    }
}

/* Loads the joint openings of a survey into a board (command `survey`, common/command.h), and reads
 * them back from the board. */
static void load_board(const struct request *request, struct store *store,
                       const struct survey *survey, const struct survey_results *found,
                       struct load_result *loaded)
{
    struct board_load loading = {.received = {false}};
    bool can = request->can || link_is_can(request->load);
    *loaded = (struct load_result){.sent_segment_count = 0};
    if (found->slack.surveyed_segment_count == 0)
        error_set(fatal, MR_TOO_FEW,
                  "survey %lld of %s has no reading of a gage line; read a gage line first",
                  (long long)survey->row.id, request->db);
    loading.dialogue = dialogue_open_for_command(can ? request->load : NULL,
                                                 can ? NULL : request->load);
    dialogue_subscribe(loading.dialogue, handle_slack, &loading);
    dialogue_wait_for_hello(loading.dialogue, NULL, NULL, fatal);
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        double slack_in = found->slack.segment[k].value_in;
        if (isnan(slack_in))
            continue;
        send_command(&loading, MR_COMMAND_SURVEY, k,
                     (int32_t)lround(slack_in / OPENING_RESOLUTION_IN));
        loaded->sent_segment_count++;
    }
    read_stored_slacks(&loading);
    compare_slacks(&loading, &found->slack, loaded);
    dialogue_close(loading.dialogue);
    store_gage_load_add(store, survey->row.id, (int64_t)link_now_us(), request->load,
                        loaded->sent_segment_count, fatal);
}

static int report_load(const struct request *request, const struct survey *survey,
                       const struct load_result *loaded)
{
    struct answer *answer = answer_new(request->cli->si);
    answer_add_count(answer, "survey", "survey", survey->row.id);
    answer_add_count(answer, "sent", "loaded", loaded->sent_segment_count)->suffix = " segments";
    answer_add_count(answer, "read_back", "read back", SURVEY_SPANS)->suffix = " segments";
    answer_add_count(answer, "different", "different", loaded->different_segment_count);
    answer_add_count(answer, "of_an_earlier_survey",
                     loaded->older_segment_count ? "not in this survey" : NULL,
                     loaded->older_segment_count)
        ->suffix = " segments, for which the board keeps its earlier values";
    if (!loaded->older_segment_count && loaded->sent_segment_count < SURVEY_SPANS)
        answer_add_count(answer, NULL, "not surveyed", SURVEY_SPANS - loaded->sent_segment_count);
    return answer_print(request->cli, answer,
                        loaded->different_segment_count ? mr_status_exit_code(MR_LIMIT) : 0);
}

static size_t write_sheet(const struct request *request, struct store *store, struct survey *survey)
{
    bool found = request->number != 0;
    if (found)
        survey_load(store, request->number, survey, fatal);
    else
        survey_load_unfinished(store, survey, &found, fatal);
    if (!found) {
        /* a new survey, in which the readings of the newest survey are the previous readings */
        static struct survey newest;
        struct error none = {0};
        survey_progress_init(&survey->progress, request->edges);
        if (survey_load(store, 0, &newest, &none) == MR_OK) {
            for (size_t i = 0; i < newest.progress.plan.count; i++) {
                int at = survey_plan_find(&survey->progress.plan, &newest.progress.plan.item[i]);
                if (at >= 0)
                    survey->progress.previous_in[at] = isnan(newest.progress.value_in[i])
                                                         ? newest.progress.previous_in[i]
                                                         : newest.progress.value_in[i];
            }
        }
    }
    struct output output;
    const char *sheet = strcmp(request->sheet, "-") == 0 ? NULL : request->sheet;
    output_check_new(sheet, request->force, fatal);
    output_begin(&output, sheet, fatal);
    survey_sheet_write(output.file, &survey->progress, request->cli->si);
    output_end(&output, fatal);
    return survey->progress.plan.count;
}

static int run_request(const struct request *request)
{
    static struct survey survey;
    static struct survey_results found;
    struct load_result loaded = {.sent_segment_count = 0};
    /* the first --sheet may create the campaign */
    bool fresh = request->sheet && access(request->db, F_OK) != 0;
    bool reading = !fresh && (request->show || request->sheet);
    bool begins = !reading && !request->load && !request->end && !request->withdraw;
    struct store *store = begins
                            ? program_open_or_create_campaign(request->cli, request->db)
                            : program_open_campaign(request->db, reading ? STORE_READ : STORE_OPEN);
    if (request->withdraw)
        return withdraw_survey(request, store);
    if (request->sheet) {
        size_t places = write_sheet(request, store, &survey);
        return request->cli->json
                 ? cli_print_json(
                       json_pack("{sssI}", "file", request->sheet, "places", (json_int_t)places), 0)
                 : 0;
    }
    if (request->show || request->load)
        survey_load(store, request->number, &survey, fatal);
    else
        run_survey(request, store, &survey);
    survey_evaluate(store, &survey, &found, fatal);
    if (request->load) {
        load_board(request, store, &survey, &found, &loaded);
        return report_load(request, &survey, &loaded);
    }
    struct answer *answer = answer_new(request->cli->si);
    add_survey(&survey, &found, answer);
    return answer_print(request->cli, answer, 0);
}

static void check_request(struct request *r)
{
    if (r->edges_text)
        (void)survey_edges_parse(r->edges_text, &r->edges);
    if (r->sheet && r->cli->json && strcmp(r->sheet, "-") == 0)
        error_set(fatal, MR_USAGE,
                  "no output file: matrig --json survey --sheet needs a file, because standard "
                  "output carries the JSON");
    int modes = r->show + (r->sheet != NULL) + (r->load != NULL) + (r->from != NULL) + r->end +
                (r->withdraw != 0);
    if (modes > 1)
        error_set(fatal, MR_USAGE,
                  "matrig survey accepts only one of --show, --sheet, --load, --from, --end and "
                  "--withdraw; leave the others out");
    if (r->number && !r->show && !r->load && !r->sheet)
        error_set(fatal, MR_USAGE,
                  "--survey needs --show, --sheet or --load; see matrig survey --help");
    if ((r->withdraw != 0) != (r->reason && r->reason[0]) ||
        (r->reason && strlen(r->reason) >= STORE_JOURNAL_TEXT_SIZE))
        error_set(fatal, MR_USAGE,
                  "--withdraw N and --reason T only work together, with a reason of at most %d "
                  "characters; see matrig survey --help",
                  STORE_JOURNAL_TEXT_SIZE - 1);
    if (r->doubtful && !r->from)
        error_set(fatal, MR_USAGE, "--doubtful needs --from; see matrig survey --help");
    if (r->can && !r->load)
        error_set(fatal, MR_USAGE, "--can needs --load; see matrig survey --help");
}

static int survey_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {.cli = cli};
    command_parse(&command_survey, argc, argv, cli, &r, &r.db, fatal);
    check_request(&r);
    if (access(r.db, F_OK) != 0)
        check_sheet(&r, NULL);
    return run_request(&r);
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database; created if missing. An unfinished survey is continued"),
    HELP_ITEM("(no option)",
              "enter readings at the keyboard, or with a caliper that acts as a keyboard: a number "
              "and Enter. Commands: s skip, u undo, b back, n TEXT note, q quit, ? help"),
    OPTION_CHOICE("--edges", "E", edges_text, "edges", "left|both|none|diagonal",
                  "edges at which stations are read; default: left. diagonal is for mats laid at "
                  "45 degrees: you read stations and transverse distances on all four lines along "
                  "the runway, and distances along seven lines at 45 degrees"),
    OPTION_FLAG("--new", starts_new_survey,
                "start a new survey even if the last one is unfinished"),
    OPTION_NUMBER_SI("--closed", "IN", closed_in, "in", "mm", 32.5, 34.5, SURVEY_POINT_SPACING_IN,
                     "distance between gage points with all ten joints closed; a reading is this "
                     "distance plus the opening\nof the joints; default: {standard}"),
    OPTION_NUMBER_SI("--error", "IN", error_in, "in", "mm", 1e-4, 0.2, SURVEY_READING_ERROR_IN,
                     "standard error of a reading; default: {standard}"),
    OPTION_TEXT("--from", "CSV", from,
                "read a sheet. Readings that need confirmation are refused (exit 1) unless "
                "--doubtful is given"),
    OPTION_TEXT("--sheet", "F.csv", sheet,
                "write an empty sheet to F (- is standard output): all readings in walking order, "
                "with the previous values"),
    OPTION_FLAG("--end", end, "end an incomplete survey"),
    OPTION_INTEGER("--withdraw", "N", withdraw, 1.0, 1e9, 0.0,
                   "withdraw survey N, which is kept but no longer used; needs --reason. matrig "
                   "landing DB lists withdrawn surveys"),
    OPTION_FLAG(
        "--show", show,
        "show results of survey N: opening and closing of joints per ten mats, movement, bow "
        "(default: the newest)"),
    OPTION_TEXT("--load", "LINK", load,
                "send the openings to the board and read them back, over serial or CAN (a can: "
                "link, or --can). Exit 1 when the board reports different values"),
    OPTION_FORCE(force),
    HELP_NOTE("If a gap reading differs from the previous survey by more than 0.36 in (the play of "
              "ten joints), or a station reading by more than 1 in, it must be entered twice. The "
              "first survey is compared with nominal values."),
    HELP_EXAMPLE("matrig survey campaign.db; matrig survey campaign.db --load serial:/dev/ttyUSB0"),
    OPTION_TEXT("--note", "T", note, NULL),
    OPTION_INTEGER("--survey", "N", number, 1.0, 1e9, 0.0, NULL),
    OPTION_TEXT("--reason", "T", reason, NULL),
    OPTION_FLAG("--can", can, NULL),
    OPTION_FLAG("--doubtful", doubtful, NULL),
};

const struct command command_survey = {
    "survey",
    survey_command,
    "DB [--edges left|both|none|diagonal] [--new] [--closed IN] [--error IN] [--note T] [--from "
    "CSV [--doubtful] | --sheet F [--force]]\nDB --end | --show | --load LINK [--can] [--survey "
    "N]\nDB --withdraw N --reason T",
    "survey the mat's gage points with a caliper: gaps, movement, in-plane bow; send the joint "
    "openings to the board",
    COMMAND_PARTS(parts),
    {1, 1, "DB"},
};
