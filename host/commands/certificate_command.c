/* matrig certificate: what laboratories certified of the sensors of a board. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "host/base/answer.h"
#include "host/board/calibrationpast.h"
#include "host/board/certificates.h"
#include "host/board/configplace.h"
#include "host/calibrate/jump.h"
#include "host/calibrate/points.h"
#include "host/commands/commands.h"
#include "host/commands/said.h"
#include "host/link/link.h"
#include "host/store/store_readiness.h"

struct request {
    const struct cli *cli;
    const char *words[2]; /* DB, CHANNEL */
    const char *number, *laboratory, *calibrated, *due, *uncertainty, *coverage, *sensor, *model,
        *by, *note, *who, *reason, *required;
    int64_t withdraw; /* 0: not given */
    bool all;
};

static enum unit_kind kind_of(int64_t index)
{
    return index < (int64_t)MR_TRANSDUCERS ? UNIT_DISPLACEMENT : UNIT_TENSION;
}

/* ---- what is entered ---- */

static enum mr_status read_date(const char *text, const char *option, int64_t *day,
                                struct error *error)
{
    uint32_t days;
    if (!configplace_date_read(text, &days) || text[CONFIGPLACE_DATE - 1] != '\0')
        return error_set(error, MR_USAGE, "no date: '%s' for %s; write YYYY-MM-DD", text, option);
    *day = days;
    return MR_OK;
}

/* In in or lb, with a unit, or in percent of the reading. */
static enum mr_status read_uncertainty(const char *text, struct store_certificate *row,
                                       struct error *error)
{
    enum unit_kind kind = kind_of(row->index);
    const char *unit = kind == UNIT_DISPLACEMENT ? "in" : "lb";
    char bare[40];
    double value;
    struct quantity_wrong wrong = {"", ""};
    size_t length = strlen(text);
    bool relative = length > 1 && length < sizeof bare && text[length - 1] == '%';
    row->expanded = row->expanded_rel = (double)NAN;
    snprintf(bare, sizeof bare, "%.*s", (int)(length - relative), text);
    /* a percentage has no unit beside it */
    bool read = length < sizeof bare &&
                (relative
                     ? quantity_parse(bare, NULL, NULL, &value, &wrong)
                     : calibrate_value(bare, kind, unit_read(unit, strlen(unit)), &value, &wrong));
    if (read && value > 0.0 && value <= (relative ? 50.0 : 1000.0)) {
        *(relative ? &row->expanded_rel : &row->expanded) = relative ? value / 100.0 : value;
        return MR_OK;
    }
    if (wrong.what[0])
        return error_set(error, MR_USAGE, "%s: '%s' for --uncertainty; %s", wrong.what, text,
                         wrong.advice);
    return error_set(error, MR_USAGE,
                     "no uncertainty: '%s' for --uncertainty; a number in %s, with its unit, or in "
                     "percent of the reading (0.4%%)",
                     text, unit);
}

/* "2", "k=2", "95%" */
static enum mr_status read_coverage(const char *text, struct store_certificate *row,
                                    struct error *error)
{
    const char *from = strncmp(text, "k=", 2) == 0 ? text + 2 : text;
    char *end;
    double value = strtod(from, &end);
    bool percent = end != from && strcmp(end + strspn(end, " "), "%") == 0;
    row->coverage_percent = percent ? value : (double)NAN;
    row->coverage_factor = percent ? certificates_factor(value) : value;
    if (end != from &&
        (percent ? value >= 50.0 && value <= 99.99 : *end == '\0' && value >= 0.5 && value <= 5.0))
        return MR_OK;
    return error_set(error, MR_USAGE,
                     "no coverage: '%s' for --coverage; a factor from 0.5 to 5 (2), or a "
                     "probability from 50 to 99.99 %% (95%%)",
                     text);
}

static enum mr_status take_text(char *into, size_t size, const char *text, const char *option,
                                struct error *error)
{
    if (text && strlen(text) >= size)
        return error_set(error, MR_TOO_LONG, "text too long: %s '%s'; %zu characters at most",
                         option, text, size - 1);
    said_fill(into, size, text);
    return MR_OK;
}

static enum mr_status check_days(const struct request *r, const struct store_certificate *row,
                                 struct error *error)
{
    if (row->calibrated_day > certificates_newest_day((int64_t)time(NULL)))
        return error_set(error, MR_USAGE,
                         "calibrated on a day to come: '%s' for --calibrated; is this computer's "
                         "clock right?",
                         r->calibrated);
    if (row->due_day != STORE_NONE && row->due_day < row->calibrated_day)
        return error_set(error, MR_USAGE,
                         "due before it was calibrated: '%s' for --due; see --help", r->due);
    return MR_OK;
}

static enum mr_status read_row(const struct request *r, struct store_certificate *row,
                               struct error *error)
{
    struct mr_channel_config room;
    const struct {
        char *into;
        size_t size;
        const char *text, *option;
    } texts[] = {
        {row->number, sizeof row->number, r->number, "--number"},
        {row->laboratory, sizeof row->laboratory, r->laboratory, "--laboratory"},
        {row->sensor, sizeof room.serial + 1, r->sensor, "--sensor"},
        {row->model, sizeof row->model, r->model, "--model"},
        {row->done_by, sizeof row->done_by, r->by, "--by"},
        {row->note, sizeof row->note, r->note, "--note"},
        {row->who, sizeof row->who, said_by(r->who), "--who"},
    };
    enum mr_status status = read_date(r->calibrated, "--calibrated", &row->calibrated_day, error);
    row->due_day = STORE_NONE;
    if (status == MR_OK && strcmp(r->due, "never") != 0)
        status = read_date(r->due, "--due", &row->due_day, error);
    if (status == MR_OK)
        status = check_days(r, row, error);
    if (status == MR_OK)
        status = read_uncertainty(r->uncertainty, row, error);
    if (status == MR_OK)
        status = read_coverage(r->coverage, row, error);
    for (size_t i = 0; i < sizeof texts / sizeof texts[0] && status == MR_OK; i++)
        status = take_text(texts[i].into, texts[i].size, texts[i].text, texts[i].option, error);
    return status;
}

static enum mr_status enter(const struct request *r, struct store *store, const char *uid,
                            struct error *error)
{
    struct store_certificate row = {.made_us = (int64_t)link_now_us()};
    struct calibrationpast past;
    unsigned index;
    if (!uid[0])
        return error_set(error, MR_UNKNOWN,
                         "the campaign knows no board yet, so that no certificate can be kept for "
                         "one: %s; matrig ready DB comes first",
                         r->words[0]);
    if (!jump_channel_read(r->words[1], strlen(r->words[1]), &index))
        return error_set(error, MR_USAGE, "not a channel: '%s'; d1 to d%u, or t1 to t%u",
                         r->words[1], MR_TRANSDUCERS, MR_GAGES);
    row.index = index;
    said_fill(row.board_uid, sizeof row.board_uid, uid);
    enum mr_status status = read_row(r, &row, error);
    if (status == MR_OK && !r->sensor) { /* the one that is fitted */
        status = calibrationpast_read(store, uid, &past, error);
        if (status == MR_OK)
            snprintf(row.sensor, sizeof row.sensor, "%.*s", (int)sizeof past.channel[index].serial,
                     past.channel[index].serial);
    }
    return status == MR_OK ? store_certificate_add(store, &row, error) : status;
}

/* ---- what is told ---- */

static const char *state_text(const struct store_certificate *row, bool holds)
{
    return row->withdraws != STORE_NONE ? "withdrawal"
         : row->gone                    ? "taken back or replaced"
         : !holds                       ? "earlier"
                                        : NULL;
}

static void date_answer(struct answer *answer, const char *name, const char *label, int64_t day)
{
    char date[CONFIGPLACE_DATE] = "";
    if (day != STORE_NONE)
        configplace_date_text((uint32_t)day, date);
    answer_words_or_none(answer, name, label, date, "-");
}

static void uncertainty_answer(struct answer *answer, const struct store_certificate *row)
{
    char text[UNIT_TEXT] = "", coverage[40] = "-";
    enum unit_kind kind = kind_of(row->index);
    if (!isnan(row->expanded))
        unit_value_text(kind, answer_in_si(answer), row->expanded,
                        kind == UNIT_DISPLACEMENT ? 4 : 2, text);
    else if (!isnan(row->expanded_rel))
        snprintf(text, sizeof text, "%.3g %%", 100.0 * row->expanded_rel);
    if (!isnan(row->coverage_percent))
        snprintf(coverage, sizeof coverage, "%.4g %%, k %.3g", row->coverage_percent,
                 row->coverage_factor);
    else if (!isnan(row->coverage_factor))
        snprintf(coverage, sizeof coverage, "k %.3g", row->coverage_factor);
    answer_words_or_none(answer, NULL, "uncertainty", text, "-");
    answer_words(answer, NULL, "coverage", "%s", coverage);
    answer_value(answer, "expanded", NULL, kind, row->expanded, 6);
    answer_value(answer, "expanded_rel", NULL, UNIT_NUMBER, row->expanded_rel, 6);
    answer_value(answer, "coverage_factor", NULL, UNIT_NUMBER, row->coverage_factor, 6);
    answer_value(answer, "coverage_percent", NULL, UNIT_NUMBER, row->coverage_percent, 6);
}

static void row_answer(struct answer *answer, const struct store_certificate *row, bool holds)
{
    char channel[8], state[CERTIFICATES_TEXT];
    const char *gone = state_text(row, holds);
    jump_channel((unsigned)row->index, channel);
    if (!gone)
        certificates_text(row, certificates_state(row, NULL, (int64_t)time(NULL)), NULL, state);
    answer_row(answer);
    answer_count(answer, "id", "id", row->id);
    answer_words(answer, "channel", "channel", "%s", channel);
    answer_words(answer, "number", "number", "%s", row->number);
    answer_words_or_none(answer, "laboratory", "laboratory", row->laboratory, "-");
    answer_words_or_none(answer, "sensor", "sensor", row->sensor, "-");
    answer_words_or_none(answer, "model", row->model[0] ? "model" : NULL, row->model, NULL);
    date_answer(answer, "calibrated", "calibrated", row->calibrated_day);
    answer_words_or_none(answer, "by", "by", row->done_by, "-");
    date_answer(answer, "due", NULL, row->due_day);
    uncertainty_answer(answer, row);
    answer_words(answer, "state", "state", "%s", gone ? gone : state);
    answer_flag(answer, "holds", NULL, holds);
    answer_words_or_none(answer, "note", NULL, row->note, "-");
    answer_words_or_none(answer, "who", NULL, row->who, "-");
    answer_words_or_none(answer, "board", NULL, row->board_uid, "-");
    answer_count(answer, "withdraws", NULL,
                 row->withdraws == STORE_NONE ? ANSWER_UNKNOWN : row->withdraws);
    answer_count(answer, "made_us", NULL, row->made_us);
}

static enum mr_status list(const struct request *r, struct store *store, const char *uid,
                           struct answer *answer, struct error *error)
{
    struct store_certificate *rows = NULL;
    size_t count = 0, shown = 0;
    bool required = false;
    enum mr_status status = store_certificates(store, uid, &rows, &count, error);
    if (status == MR_OK)
        status = store_certificates_required(store, &required, error);
    answer_flag(answer, "required", NULL, required);
    answer_table(answer, "certificates", "");
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        bool holds = certificates_find(rows, count, (unsigned)rows[i].index) == &rows[i];
        if (!holds && !r->all)
            continue;
        row_answer(answer, &rows[i], holds);
        shown++;
    }
    answer_close(answer);
    if (status == MR_OK && required)
        answer_sentence(answer, NULL, "This campaign requires a certificate of each channel.");
    if (status == MR_OK && !shown)
        cli_note(r->cli,
                 "no certificate yet: %s; matrig certificate DB CHANNEL --number N ... "
                 "enters one",
                 r->words[0]);
    free(rows);
    return status;
}

/* ---- the command line ---- */

static enum mr_status check(const struct request *r, struct error *error)
{
    bool entered = r->number || r->laboratory || r->calibrated || r->due || r->uncertainty ||
                   r->coverage || r->sensor || r->model || r->by || r->note;
    if ((r->withdraw || r->required) && (entered || r->words[1]))
        return error_set(error, MR_USAGE,
                         "--withdraw and --required go without a channel: matrig certificate; see "
                         "matrig certificate --help");
    if (r->withdraw && r->required)
        return error_set(error, MR_USAGE,
                         "--withdraw or --required, one of them: matrig "
                         "certificate; see matrig certificate --help");
    if (r->withdraw && (!r->reason || !r->reason[0]))
        return error_set(error, MR_USAGE,
                         "why? matrig certificate DB --withdraw ID needs --reason "
                         "TEXT; who reads it later will ask");
    if (r->reason && !r->withdraw)
        return error_set(error, MR_USAGE,
                         "--reason goes with --withdraw: matrig certificate; see "
                         "matrig certificate --help");
    if (entered != (r->words[1] != NULL) ||
        (entered && (!r->number || !r->number[0] || !r->calibrated || !r->due || !r->uncertainty ||
                     !r->coverage)))
        return error_set(error, MR_USAGE,
                         "a certificate is CHANNEL, --number, --calibrated, --due, --uncertainty "
                         "and --coverage, all of them: matrig certificate; see matrig certificate "
                         "--help");
    return MR_OK;
}

static enum mr_status act(const struct request *r, struct store *store, const char *uid,
                          struct error *error)
{
    int64_t now_us = (int64_t)link_now_us();
    if (r->withdraw)
        return store_certificate_withdraw(store, r->withdraw, now_us, said_by(r->who), r->reason,
                                          error);
    if (r->required)
        return store_certificates_demand(store, strcmp(r->required, "yes") == 0, now_us,
                                         said_by(r->who), error);
    return r->words[1] ? enter(r, store, uid, error) : MR_OK;
}

static int certificate_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {.cli = cli};
    struct error error = {0};
    struct store *store = NULL;
    char uid[25] = "";
    struct answer *answer = answer_new(cli->si);
    enum mr_status status = command_parse(&command_certificate, argc, argv, cli, &r, r.words,
                                          &error);
    bool writes = r.words[1] || r.withdraw || r.required;
    if (status == MR_OK)
        status = check(&r, &error);
    if (status == MR_OK)
        status = store_open(r.words[0], writes ? STORE_OPEN : STORE_READ, &store, &error);
    if (status == MR_OK)
        status = store_board_newest(store, uid, &error);
    if (status == MR_OK)
        status = act(&r, store, uid, &error);
    if (status == MR_OK)
        status = list(&r, store, uid[0] ? uid : NULL, answer, &error);
    store_close(store);
    return answer_end(cli, answer, 0, &error);
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database; certificates are of the board that was logged or checked "
                    "last. Alone: those that hold"),
    HELP_ITEM("CHANNEL", "d1 to d8, t1 to t14: enter a certificate of its sensor. Nothing is "
                         "written over: a row with the number of an\n"
                         "earlier one stands in its place"),
    OPTION_TEXT("--number", "N", number, "of the certificate"),
    OPTION_TEXT("--laboratory", "L", laboratory, "who issued it"),
    OPTION_TEXT("--calibrated", "DATE", calibrated, "YYYY-MM-DD, as the certificate has it"),
    OPTION_TEXT("--due", "DATE", due,
                "the last day on which it holds, or never. From the next day on matrig ready says "
                "no-go; the time zone does\n"
                "not matter: while that day is over in some place and not in another, ready says "
                "so"),
    OPTION_TEXT("--uncertainty", "U", uncertainty,
                "expanded uncertainty of a value: in in or lb, with its unit (0.05mm), or of the "
                "reading (0.4%)"),
    OPTION_TEXT("--coverage", "K|P%", coverage,
                "its coverage factor (2), or the probability with which it holds (95%)"),
    OPTION_TEXT("--sensor", "S", sensor,
                "serial number of the sensor, as channel[].serial of the configuration; else the "
                "one that the campaign knows.\n"
                "Where the board says another, matrig ready says no-go"),
    OPTION_TEXT("--model", "M", model, "its maker and model"),
    OPTION_TEXT("--by", "P", by, "who calibrated"),
    OPTION_TEXT("--note", "T", note, "anything else"),
    OPTION_TEXT("--who", "W", who, "who enters it; else the user"),
    OPTION_FLAG("--all", all, "list the earlier, replaced and withdrawn ones, too"),
    OPTION_WHOLE("--withdraw", "ID", withdraw, 1, 1000000000, 0,
                 "take a certificate back, with --reason; it stays in the list of --all"),
    OPTION_TEXT("--reason", "T", reason, NULL),
    OPTION_CHOICE("--required", "yes|no", required, "answer", "yes|no",
                  "whether this campaign requires them: then matrig ready says no-go of a channel "
                  "without one; else it is a note"),
    HELP_EXAMPLE("matrig certificate campaign.db d3 --number 2026-4711 --laboratory 'Metrology "
                 "Lab' --calibrated 2026-03-02 --due 2027-03-01 --uncertainty 0.4% --coverage 2 "
                 "--sensor ET-17"),
};

const struct command command_certificate = {
    "certificate",
    certificate_command,
    "DB [--all] | DB CHANNEL --number N --calibrated DATE --due DATE --uncertainty U --coverage "
    "K|P% [--laboratory L] [--sensor S] [--model M] [--by P] [--note T] [--who W] |\n"
    "                         DB --withdraw ID --reason T | DB --required yes|no",
    "certificates of the sensors: enter them, list them, what is overdue",
    COMMAND_PARTS(parts),
    {1, 2, "DB [CHANNEL]"},
};
