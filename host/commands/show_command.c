/* The command matrig show: prints the contents of a campaign, and the summary of a recorded
 * landing. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/journal.h"
#include "host/analyse/measured_load.h"
#include "host/analyse/outcome.h"
#include "host/analyse/summary.h"
#include "host/base/command.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/store/store_journal.h"
#include "host/survey/survey.h"

/* ---- all landings ---- */

#define NOTE_CHARACTERS_MAX 60 /* maximum characters of a note in the printed table */

/* Facts for one row of the list of landings. Samples are loaded only if it is doubtful whether the
 * gear stopped, so that thousands of landings can be listed without delay. */
struct preview {
    struct measured_landing measured; /* loaded by measured_load_gear */
    struct zones zones;
    /* numbers of lost, dropped and missing data of each link */
    struct summary_link link[LINK_KINDS];
    struct journal journal;
    size_t observations; /* number of observed waves and breaks that are not withdrawn */
    bool imported;
    uint16_t can_base;    /* CAN base of the landing's board */
    int64_t repeated_run; /* RUN of an earlier record of the same landing; 0: none */
};

static void load_links(struct store *store, int64_t run, struct preview *preview)
{
    struct store_gap *gap = NULL;
    size_t gaps = 0;
    store_gaps_get(store, run, &gap, &gaps, fatal);
    summary_count_gaps(gap, gaps, preview->link);
    free(gap);
}

static void preview_load(struct store *store, int64_t run, struct preview *preview)
{
    const struct store_landing *landing = &preview->measured.landing;
    struct store_import import = {0};
    memset(preview, 0, sizeof *preview);
    measured_load_gear(store, run, &preview->measured, fatal);
    zones_load(store, &preview->measured, &preview->zones, fatal);
    load_links(store, run, preview);
    journal_load(store, landing, &preview->journal, fatal);
    for (size_t i = 0; i < preview->journal.observation_count; i++)
        preview->observations += !preview->journal.observation[i].withdrawn;
    store_can_base_get(store, run, &preview->can_base, fatal);
    store_import_get(store, landing->session, &import, &preview->imported, fatal);
    store_find_duplicate(store, run, &preview->repeated_run, fatal);
}

static void preview_free(struct preview *preview)
{
    measured_free(&preview->measured);
    zones_free(&preview->zones);
    journal_free(&preview->journal);
}

/* ---- a row ---- */

/* Writes the state of the landing and its calibration marks. An unknown calibration is mentioned in
 * the notes instead, because it applies to most imported landings. */
static void state_text(const struct preview *preview, char *out, size_t size)
{
    const struct measured_landing *measured = &preview->measured;
    snprintf(out, size, "%lld, %s%s%s%s%s", (long long)preview->measured.landing.board_landing,
             mr_landing_state_text((unsigned)preview->measured.landing.state),
             preview->journal.is_void ? ", VOID" : "", preview->imported ? ", imported" : "",
             measured->has_calibration_dates ? measured_quality_text(measured)
             : measured->is_start_missing    ? ", torn"
                                             : "",
             measured_is_emulated(&measured->landing) ? ", emulated" : "");
}

static void add_motion(const struct measured_landing *measured, struct answer *answer)
{
    const struct mr_gates_summary *fit = &measured->summary;
    const struct mr_estimate none = {(double)NAN, (double)NAN};
    bool fitted = measured->fit_status == MR_OK,
         speed_known = fitted || measured->fit_status == MR_TRUNCATED;
    struct mr_estimate speed = speed_known ? fit->touchdown_speed_ft_s : none,
                       stop = fitted ? fit->stop_station_ft : none;
    answer_add_estimate(answer, "touchdown_speed", "touchdown", UNIT_SPEED, speed.value,
                        speed.error, 3)
        ->digits = 9;
    answer_add_estimate(answer, "stop_station", "stop", UNIT_STATION, stop.value, stop.error, 3)
        ->digits = 9;
}

static void add_warning(const struct preview *preview, struct answer *answer)
{
    const struct zone_warning *w = &preview->zones.warning;
    const struct unit *station = unit_get(UNIT_STATION, answer_is_si(answer));
    char doubt[ZONES_REASON_SIZE], label[20];
    bool watched = preview->measured.source != MEASURED_IMPORT;
    bool all_heard = watched && !zones_format_missed_warning_reason(&preview->zones.received,
                                                                    (double)INFINITY, doubt);
    snprintf(label, sizeof label, "warned of|%s", station->text);
    if (w->has_warning)
        answer_add_text(answer, NULL, label, "%.1f to %.1f", station->factor * w->longest_start_ft,
                        station->factor * w->longest_end_ft)
            ->is_warning = true;
    else
        answer_add_text(answer, NULL, label, "%s",
                        !watched    ? "no board"
                        : all_heard ? "none"
                                    : "not known");
    answer_add_flag(answer, "warned", NULL, w->has_warning);
    answer_add_flag(answer, "all_heard", NULL, all_heard);
    answer_add_value(answer, "warning_t", NULL, UNIT_TIME, w->has_warning ? w->t_s : (double)NAN, 3)
        ->digits = 9;
    answer_add_value(answer, "warning_start", NULL, UNIT_STATION,
                     w->has_warning ? w->longest_start_ft : (double)NAN, 1)
        ->digits = 9;
    answer_add_value(answer, "warning_end", NULL, UNIT_STATION,
                     w->has_warning ? w->longest_end_ft : (double)NAN, 1)
        ->digits = 9;
}

static void add_lost_data(const struct preview *preview, struct answer *answer)
{
    const struct summary_link *can = &preview->link[LINK_CAN],
                              *serial = &preview->link[LINK_SERIAL];
    answer_add_text(answer, NULL, "frames|lost", "%lld%s",
                    (long long)(can->lost_frames + serial->lost_frames),
                    can->was_silent || serial->was_silent ? ", more" : "");
    answer_add_count(answer, "lost", NULL, can->lost_frames + serial->lost_frames);
    answer_add_count(answer, "dropped", NULL, can->dropped_frames + serial->dropped_frames);
    answer_add_flag(answer, "silent", NULL, can->was_silent || serial->was_silent);
}

static void append_text(char *out, size_t size, const char *text)
{
    size_t used = strlen(out);
    snprintf(out + used, size - used, "%s%s", used ? "; " : "", text);
}

/* Adds the newest note, the numbers of notes and observations, and warnings. */
static void add_notes(const struct preview *preview, struct answer *answer)
{
    char text[NOTE_CHARACTERS_MAX + 140] = "", part[NOTE_CHARACTERS_MAX + 40];
    const char *newest = NULL;
    size_t notes = 0;
    for (size_t i = 0; i < preview->journal.change_count; i++) {
        if (strcmp(preview->journal.change[i].field, "note") != 0)
            continue;
        newest = preview->journal.change[i].value;
        notes++;
    }
    if (!preview->measured.has_calibration_dates)
        append_text(text, sizeof text, "calibration unknown");
    if (preview->repeated_run) {
        snprintf(part, sizeof part, "the same landing as RUN %lld",
                 (long long)preview->repeated_run);
        append_text(text, sizeof text, part);
    }
    if (newest) {
        size_t length = strlen(newest),
               shown = length > NOTE_CHARACTERS_MAX ? NOTE_CHARACTERS_MAX - 3 : length;
        while (length > NOTE_CHARACTERS_MAX && ((unsigned char)newest[shown] & 0xc0u) == 0x80u)
            shown--; /* do not cut a multi-byte character */
        snprintf(part, sizeof part, "%.*s%s", (int)shown, newest,
                 length > NOTE_CHARACTERS_MAX ? "..." : "");
        append_text(text, sizeof text, part);
    }
    if (notes > 1) {
        snprintf(part, sizeof part, "%zu notes", notes);
        append_text(text, sizeof text, part);
    }
    if (preview->observations) {
        snprintf(part, sizeof part, "%zu seen", preview->observations);
        append_text(text, sizeof text, part);
    }
    answer_add_text(answer, NULL, "notes", "%s", text);
    answer_open_list(answer, "notes", NULL);
    for (size_t i = 0; i < preview->journal.change_count; i++) {
        if (strcmp(preview->journal.change[i].field, "note") == 0)
            answer_add_text(answer, NULL, NULL, "%s", preview->journal.change[i].value);
    }
    answer_close_group(answer);
    answer_add_count(answer, "seen", NULL, (int64_t)preview->observations);
    answer_add_count(answer, "same_as", NULL,
                     preview->repeated_run ? preview->repeated_run : ANSWER_COUNT_UNKNOWN);
}

/* Adds a row of the list. `bases`: include the CAN base of the board. */
static void add_preview(const struct preview *preview, bool bases, struct answer *answer)
{
    const struct store_landing *landing = &preview->measured.landing;
    char when[40], state[80];
    survey_format_time(landing->armed_us, when, sizeof when);
    state_text(preview, state, sizeof state);
    answer_add_count(answer, "run", "RUN", landing->id);
    bool dated = landing->armed_us >= SURVEY_EARLIEST_DATE_US;
    /* without "UTC", which is in the column head */
    answer_add_text(answer, NULL, "armed|UTC", "%.*s", dated ? 16 : 40, when);
    answer_add_text_or_missing(answer, "armed", NULL, dated ? when : NULL, NULL);
    answer_add_count(answer, "armed_us", NULL, landing->armed_us);
    answer_add_text_or_missing(answer, "series", "series", preview->journal.series.name, "-");
    answer_add_text(answer, NULL, "landing", "%s", state);
    answer_add_count(answer, "landing", NULL, landing->board_landing);
    answer_add_text(answer, "state", NULL, "%s", mr_landing_state_text((unsigned)landing->state));
    answer_add_text(answer, "board", NULL, "%s", landing->board_uid);
    if (bases)
        answer_add_text(answer, NULL, "board at|CAN base", "0x%03x", preview->can_base);
    answer_add_count(answer, "can_base", NULL, preview->can_base);
    answer_add_flag(answer, "void", NULL, preview->journal.is_void);
    answer_add_flag(answer, "imported", NULL, preview->imported);
    answer_add_flag(answer, "emulated", NULL, measured_is_emulated(landing));
    answer_add_flag(answer, "torn", NULL, preview->measured.is_start_missing);
    summary_add_calibration(&preview->measured, answer);
    add_motion(&preview->measured, answer);
    add_warning(preview, answer);
    add_lost_data(preview, answer);
    add_notes(preview, answer);
}

static void add_landings(struct store *store, const struct store_landing *row, size_t count,
                         struct answer *answer)
{
    static struct preview preview; /* static because it is too large for the stack */
    uint16_t base = 0;
    for (size_t i = 0; i < count && !base; i++)
        store_can_base_get(store, row[i].id, &base, fatal);
    answer_open_table(answer, "landings", "");
    for (size_t i = 0; i < count; i++) {
        preview_load(store, row[i].id, &preview);
        answer_open_row(answer);
        add_preview(&preview, base != 0, answer);
        preview_free(&preview);
    }
    answer_close_group(answer);
}

/* Prints the numbers of series and surveys, and suggests the next step if something is missing. */
static void add_contents(const char *db, size_t landings, size_t series, size_t surveys,
                         struct answer *answer)
{
    answer_add_text(answer, "db", NULL, "%s", db);
    answer_add_count(answer, "series", NULL, (int64_t)series);
    answer_add_count(answer, "surveys", NULL, (int64_t)surveys);
    if (landings == 0)
        answer_add_sentence(answer, NULL,
                            "no landing yet: %s; record landings with matrig log --db %s", db, db);
    if (landings == 0 && series == 0)
        answer_add_sentence(answer, NULL,
                            "no series yet; begin one with matrig landing %s --series NAME", db);
    if (landings == 0 && surveys == 0)
        answer_add_sentence(answer, NULL, "no survey yet; begin one with matrig survey %s", db);
    if (series + surveys > 0)
        answer_add_sentence(answer, NULL,
                            "%zu series (matrig landing %s), %zu survey%s (matrig survey "
                            "%s --show)",
                            series, db, surveys, surveys == 1 ? "" : "s", db);
}

/* Largest number of landings for which the list includes the record of warnings and advice:
 * computing it requires all readings of each landing. The report always includes it. */
#define RECORDS_MAX 30

static void add_result(struct store *store, size_t landings, struct answer *answer)
{
    struct outcome_record record;
    if (landings == 0)
        return;
    if (landings > RECORDS_MAX) {
        answer_add_missing_value(answer, "record", NULL, NULL);
        answer_add_sentence(answer, NULL,
                            "the outcomes of the warnings are not shown for more than %d landings; "
                            "see matrig report",
                            RECORDS_MAX);
        return;
    }
    outcome_record_load(store, &record, fatal);
    outcome_record_to_answer(&record, true, answer);
    outcome_record_free(&record);
}

static void list_landings(struct store *store, const char *db, struct answer *answer)
{
    struct store_landing *row = NULL;
    struct store_series *series = NULL;
    struct store_gage_survey *survey = NULL;
    size_t count = 0, series_count = 0, surveys = 0;
    store_landings_get(store, &row, &count, fatal);
    store_all_series_get(store, &series, &series_count, fatal);
    store_gage_surveys_get(store, &survey, &surveys, fatal);
    add_landings(store, row, count, answer);
    add_contents(db, count, series_count, surveys, answer);
    add_result(store, count, answer);
    free(row);
    free(series);
    free(survey);
}

/* ---- one landing ---- */

static void add_journal(struct store *store, const struct store_landing *landing,
                        struct answer *answer)
{
    struct journal journal;
    journal_load(store, landing, &journal, fatal);
    answer_add_text_or_missing(answer, "series", journal.series.name[0] ? "series" : NULL,
                               journal.series.name, NULL);
    answer_add_flag(answer, "void", NULL, journal.is_void);
    if (journal.is_void)
        answer_add_sentence(answer, NULL, "the landing is void");
    journal_add_tables(&journal, answer);
    journal_free(&journal);
}

static void show_landing(struct store *store, int64_t run, struct answer *answer)
{
    static struct summary summary;
    summary_load(store, run, &summary, fatal);
    summary_load_outcome(store, &summary, fatal);
    summary_to_answer(&summary, answer);
    add_journal(store, &summary.measured.landing, answer);
    summary_free(&summary);
}

static int show_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2];
    struct answer *answer = answer_new(cli->si);
    int64_t run = 0;
    command_parse(&command_show, argc, argv, cli, NULL, words, fatal);
    if (words[1])
        parse_run(words[1], &run, fatal);
    struct store *store = program_open_campaign(words[0], STORE_READ);
    store_find_run(store, &run, fatal);
    if (run)
        show_landing(store, run, answer);
    else
        list_landings(store, words[0], answer);
    return answer_print(cli, answer, 0);
}

static const struct command_part parts[] = {
    HELP_ITEM(
        "DB",
        "campaign database. Without RUN, one row per landing: time of arming, series, touchdown "
        "speed, stop station (+- one standard error), zone warned of (in --json: warning_start_ft "
        "and warning_end_ft), frames lost, observations. Landings that the campaign contains twice "
        "are marked. The last lines count zones reached, correct warnings and false warnings"),
    HELP_ITEM("RUN", "print the summary of landing RUN again, with later notes and observations"),
    HELP_EXAMPLE("matrig show campaign.db; matrig show campaign.db 5"),
};

const struct command command_show = {
    "show",
    show_command,
    "DB [RUN]",
    "list the landings of a campaign; print a landing's summary again",
    COMMAND_PARTS(parts),
    {1, 2, "DB [RUN]"},
};
