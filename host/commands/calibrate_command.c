/* The command matrig calibrate: calibrates a channel against known values, and recalibrates
 * recorded landings. */
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "common/channels.h"
#include "common/command.h"
#include "common/gain.h"
#include "host/base/answer.h"
#include "host/board/certificates.h"
#include "host/board/config_text.h"
#include "host/calibrate/fit.h"
#include "host/board/config_client.h"
#include "host/calibrate/jump.h"
#include "host/calibrate/points.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/commands/annotation.h"
#include "host/link/link.h"
#include "host/base/output.h"
#include "host/base/xmalloc.h"
#include "host/store/store_journal.h"
#include "host/store/store_readiness.h"

#define S_PER_DAY             86400
#define DEFAULT_VALID_DAYS    365.0
/* Largest deviation from the fit that is accepted without --accept, % of the span; working sensors
 * deviate less. */
#define DEVIATION_MAX_PERCENT 1.0

struct request {
    const struct cli *cli;
    const char *channel_text, *serial, *points, *config, *output, *sensor, *known_error_text,
        *recompute, *series, *reason, *who, *db, *certificate, *accept;
    bool table, zeros, force;
    double days, known_error, deviation_max_percent; /* days: NaN if not given */
    int64_t run;
    unsigned channel; /* index of the channel */
};

static enum unit_kind get_unit_kind(const struct request *r)
{
    return r->channel < MR_TRANSDUCERS ? UNIT_DISPLACEMENT : UNIT_TENSION;
}

/* Returns the unit of the calibration, to which known values are converted. */
static const char *find_unit_text(const struct request *r)
{
    return r->channel < MR_TRANSDUCERS ? "in" : "lb";
}

/* ---- the result ---- */

static int show_fit(const struct request *r, const struct calibrate_points *points,
                    const struct calibrate_fit *fit, const struct mr_channel_config *channel,
                    int code)
{
    const char *unit = find_unit_text(r), *end = r->channel < MR_TRANSDUCERS ? " in" : " lb";
    struct answer *answer = answer_new(r->cli->si);
    answer_add_text(answer, "channel", "channel", "%s", r->channel_text);
    answer_add_text(answer, NULL, "from", "%zu points between %g and %g %s", points->count,
                    fit->low, fit->high, unit);
    answer_add_text(answer, "values_read_in", "unit of the values", "%s",
                    points->unit ? points->unit->word : unit);
    answer_add_text(answer, "unit", NULL, "%s", unit);
    answer_add_text(answer, NULL, "gain", "%.7g %s per code +- %.4g %%", fit->unit_per_code, unit,
                    100.0 * fit->gain_error);
    answer_add_value(answer, "unit_per_code", NULL, UNIT_NUMBER, fit->unit_per_code, 9)->digits = 9;
    answer_add_value(answer, "gain_error", NULL, UNIT_NUMBER, fit->gain_error, 5);
    answer_add_value(answer, "zero_code", "zero code", UNIT_NUMBER, fit->zero_code, 3)->digits = 9;
    answer_append_remark(answer, " codes");
    answer_add_value(answer, "zero_error", "zero's error", UNIT_NUMBER, fit->zero_error, 5)
        ->suffix = end;
    answer_add_value(answer, "linearity_error",
                     channel->points ? "residual of the table" : "residual of the line",
                     UNIT_NUMBER, fit->linearity_error, 5)
        ->suffix = end;
    answer_add_count(answer, "table_points", NULL, channel->points);
    answer_open_table(answer, "points", "");
    for (size_t i = 0; i < points->count; i++) {
        answer_open_row(answer);
        answer_add_value(answer, "value", unit, UNIT_NUMBER, points->point[i].value, 4)->digits = 8;
        answer_add_value(answer, "code", "codes", UNIT_NUMBER, points->point[i].code, 3)->digits =
            9;
        answer_add_value(answer, "residual", "residual", UNIT_NUMBER, fit->residual[i], 5)
            ->shows_sign = true;
        if (i == fit->worst_point)
            answer_add_text(answer, NULL, " ", "worst");
    }
    answer_close_group(answer);
    answer_add_text_or_missing(answer, "accepted", r->accept ? "accepted" : NULL, r->accept, NULL);
    answer_add_text_or_missing(answer, "file", r->output ? "written to" : NULL, r->output, NULL);
    return answer_print(r->cli, answer, code);
}

#define ACCEPTED_DEVIATION_TEXT ": the deviation from the fit was accepted: "

/* Writes the reasons given by the user as comments at the start of the configuration file. Copies
 * the reasons of other channels too, because the file is the start of the calibration of the next
 * channel. */
static void write_accepted_deviations(const struct request *r, FILE *out)
{
    FILE *file = r->config ? fopen(r->config, "r") : NULL;
    char *line = NULL;
    size_t room = 0, word = strlen(r->channel_text);
    if (r->accept)
        fprintf(out, "# %s" ACCEPTED_DEVIATION_TEXT "%s\n", r->channel_text, r->accept);
    while (file && getline(&line, &room, file) > 0) {
        bool own = strncmp(line, "# ", 2) == 0 && strncmp(line + 2, r->channel_text, word) == 0 &&
                   line[2 + word] == ':';
        if (line[0] == '#' && strstr(line, ACCEPTED_DEVIATION_TEXT) && !own)
            fprintf(out, "%.*s\n", (int)strcspn(line, "\r\n"), line);
    }
    free(line);
    if (file)
        fclose(file);
}

static void write_config(const struct request *r, const struct mr_config *config)
{
    char *text = config_text_write(config), *all;
    size_t length;
    FILE *out = xopen_memstream(&all, &length);
    write_accepted_deviations(r, out);
    fputs(text, out);
    fclose(out);
    output_write_bytes(r->output, all, length, fatal);
    free(all);
    free(text);
}

static const char *get_source_name(const struct request *r)
{
    return r->points ? r->points : r->serial;
}

/* Refuses a code outside the range of the channel, which means that the columns are swapped or the
 * numbers are not codes. */
static void check_point_codes(const struct request *r, const struct calibrate_points *points,
                              const struct mr_channel_config *channel)
{
    const struct mr_gain_limits limits = mr_gain_limits(channel);
    for (size_t i = 0; i < points->count; i++) {
        double code = points->point[i].code;
        if (code < (double)limits.low_code || code > (double)limits.high_code)
            error_set(fatal, MR_LIMIT,
                      "code out of range: %g for %s, point %zu: %s; codes range from %.0f to %.0f, "
                      "so check whether the columns are swapped",
                      code, r->channel_text, i + 1, get_source_name(r), (double)limits.low_code,
                      (double)limits.high_code);
    }
}

/* Reports a jump of the gain. The jump is refused later, by config set without --force. */
static void check_gain(const struct request *r, const struct mr_config *config,
                       const struct mr_channel_config *old)
{
    struct mr_config_violation reason;
    char text[500];
    const struct mr_channel_config *channel = &config->channel[r->channel];
    if (mr_config_check(config, &reason) != MR_OK) {
        config_text_reason(config, &reason, text, sizeof text);
        error_set(fatal, MR_LIMIT, "a board would refuse this calibration: %s; %s",
                  get_source_name(r), text);
    }
    if (jump_find(old, channel, text))
        cli_note(r->cli, "%s: %s, compared with %s: check unit and points", r->channel_text, text,
                 old->calibrated_day ? "the last calibration" : "the configuration");
}

/* Checks how far the points are from the fit. If a deviation is too large (a value was mistyped, or
 * the sensor is faulty), shows the table and ends without writing, unless --accept is given. A
 * deviation that is permitted only by a larger --miss is recorded as a reason. */
static void check_fit(struct request *r, const struct calibrate_points *points,
                      const struct calibrate_fit *fit, const struct mr_channel_config *channel)
{
    char mend[200] = "no single point causes the deviation: measure all points again";
    double span = fit->high - fit->low, most = r->deviation_max_percent / 100.0 * span, rest;
    struct error error = {0};
    if (fit->max_deviation <= fmin(r->deviation_max_percent, DEVIATION_MAX_PERCENT) / 100.0 * span)
        r->accept = NULL;
    else if (fit->max_deviation <= most && !r->accept)
        r->accept =
            xasprintf("--miss %g: the points deviate from their fit by %.2g %% of their span",
                      r->deviation_max_percent, 100.0 * fit->max_deviation / span);
    if (fit->max_deviation <= most || r->accept)
        return;
    size_t i = calibrate_find_outlier(points->point, points->count, r->table, most, channel, &rest);
    if (i < points->count)
        snprintf(mend, sizeof mend,
                 "without point %zu (%.6g %s, %.6g codes) the other points fit within %.2g %s: "
                 "measure that point again",
                 i + 1, points->point[i].value, find_unit_text(r), points->point[i].code, rest,
                 find_unit_text(r));
    error_set(&error, MR_LIMIT,
              "the points deviate from their fit by %.3g %s, which is %.2g %% of their span "
              "(limit: %g %%): %s; %s, or accept the deviation with --accept REASON",
              fit->max_deviation, find_unit_text(r), 100.0 * fit->max_deviation / span,
              r->deviation_max_percent, get_source_name(r), mend);
    r->output = NULL;
    if (r->cli->json) /* do not print the error again: the JSON object contains it */
        exit(show_fit(r, points, fit, channel, cli_fail(&error)));
    int shown = show_fit(r, points, fit, channel, 0);
    exit(shown != 0 ? shown : cli_fail(&error));
}

/* ---- points from a board ---- */

/* Number of readings that are averaged for one point; the board sends one every 20 ms. */
#define BLOCKS_PER_POINT   40u
#define POINT_TIMEOUT_S    10.0 /* timeout for the readings of one point, s */
#define LIVE_DURATION_S    20
/* In codes. Noise is below 1 code, so a larger difference means that the value moved. */
#define MOVEMENT_MAX_CODES 6.0

struct reading_sum {
    const struct mr_channel_config *reference;
    unsigned channel, count, invalid_count;
    double sum, sum_of_squares, first_value;
};

static enum mr_status gather_readings(void *context, const struct dialogue_message *message,
                                      struct error *error)
{
    struct reading_sum *g = context;
    struct mr_block block;
    const struct mr_channel_config plain = {
        .kind = g->channel < MR_TRANSDUCERS ? MR_KIND_DISPLACEMENT : MR_KIND_TENSION,
        .unit_per_code = 1.0f};
    (void)error;
    if (message->id != MR_ID_BLOCK || g->count == BLOCKS_PER_POINT ||
        mr_block_decode(&block, message->payload, message->length) != MR_OK)
        return MR_OK;
    float ratio = mr_reference_ratio(g->reference, &block);
    struct mr_reading reading = mr_channel_read(&plain, &block, g->channel, ratio);
    if (isnan(reading.value)) {
        g->invalid_count++;
        return MR_OK;
    }
    double code = (double)reading.code * (double)ratio;
    g->first_value = g->count ? g->first_value : code;
    g->sum += code - g->first_value;
    g->sum_of_squares += (code - g->first_value) * (code - g->first_value);
    g->count++;
    return MR_OK;
}

static bool has_enough_readings(const void *context)
{
    const struct reading_sum *g = context;
    return g->count == BLOCKS_PER_POINT || g->invalid_count == BLOCKS_PER_POINT;
}

/* Measures the mean of the channel over about a second. */
static void measure_point(const struct request *r, struct dialogue *dialogue, struct reading_sum *g,
                          struct calibrate_point *point)
{
    *g = (struct reading_sum){.reference = g->reference, .channel = g->channel};
    config_client_set_live_duration(dialogue, LIVE_DURATION_S, fatal);
    dialogue_wait_until(dialogue, has_enough_readings, g, POINT_TIMEOUT_S, fatal);
    if (g->count < BLOCKS_PER_POINT)
        error_set(fatal, g->invalid_count ? MR_LIMIT : MR_TIMEOUT, "%s: %s; %s", r->channel_text,
                  g->invalid_count ? "the readings are not valid"
                                   : "no readings received within 10 s",
                  g->invalid_count ? "check the wiring of the sensor"
                                   : "check that the board is connected");
    double n = g->count;
    point->code = g->first_value + g->sum / n;
    point->spread = sqrt(fmax(g->sum_of_squares - g->sum * g->sum / n, 0.0) / (n - 1.0));
}

/* Reads a line from the keyboard. Until the line is complete, receives messages of the board, which
 * would otherwise accumulate. Returns false at the end of input. */
static bool read_typed_line(struct dialogue *dialogue, char *line, size_t size)
{
    size_t length = 0;
    for (;;) {
        struct pollfd ready = {.fd = STDIN_FILENO, .events = POLLIN};
        char byte;
        if (poll(&ready, 1, 0) == 1) {
            if (read(STDIN_FILENO, &byte, 1) != 1)
                return false;
            if (byte == '\n' || byte == '\r') {
                line[length] = '\0';
                return true;
            }
            if (length + 1 < size)
                line[length++] = byte;
            continue;
        }
        (void)dialogue_receive(dialogue, DIALOGUE_RECEIVE_MAX_S, fatal);
    }
}

/* Guides the user through the calibration points. For each point the user sets a known value and
 * types it, and the board measures the code. */
static void guide_calibration(const struct request *r, struct dialogue *dialogue,
                              const struct mr_config *config, struct calibrate_points *points)
{
    struct reading_sum g = {.reference = &config->channel[MR_REFERENCE], .channel = r->channel};
    char line[100];
    const char *unit = find_unit_text(r);
    points->unit = unit_word_find(unit, 2);
    dialogue_subscribe(dialogue, gather_readings, &g);
    cli_note(r->cli,
             "%s: set a known value, wait until the sensor rests, type the value (%s) and press "
             "Enter; u removes the last point; an empty line or q ends the input",
             r->channel_text, unit);
    while (points->count < CALIBRATE_POINTS_MAX) {
        if (!r->cli->quiet)
            fprintf(stderr, "point %zu, %s: ", points->count + 1, unit);
        if (!read_typed_line(dialogue, line, sizeof line) || line[0] == '\0' ||
            strcmp(line, "q") == 0)
            break;
        if (strcmp(line, "u") == 0) {
            points->count -= points->count > 0;
            continue;
        }
        struct calibrate_point point;
        struct quantity_error wrong;
        if (!calibrate_value_parse(line, get_unit_kind(r), points->unit, &point.value, &wrong)) {
            cli_note(r->cli, "not a value: '%s': %s; %s", line, wrong.what, wrong.advice);
            continue;
        }
        measure_point(r, dialogue, &g, &point);
        bool moves = point.spread > MOVEMENT_MAX_CODES;
        cli_note(r->cli, "%.3f codes, noise %.2f%s", point.code, point.spread,
                 moves ? ": point refused, because the reading changes; wait until the sensor "
                         "rests and type the value again"
                       : "");
        if (!moves)
            points->point[points->count++] = point;
    }
    struct error late = {0};
    (void)config_client_set_live_duration(dialogue, 0, &late);
}

/* Reads the active configuration of the board, and then the calibration points. */
static void read_board_config(const struct request *r, struct mr_config *config,
                              struct calibrate_points *points)
{
    static struct config_client talk;
    struct dialogue *dialogue = dialogue_open_for_command(NULL, r->serial);
    uint32_t crc;
    config_client_begin_and_get(&talk, dialogue, config, &crc, fatal);
    if (!mr_channel_is_sensor(&config->channel[r->channel]))
        error_set(
            fatal, MR_USAGE,
            "the configuration marks %s as not fitted: %s; set its kind with matrig board config",
            r->channel_text, r->serial);
    guide_calibration(r, dialogue, config, points);
    dialogue_close(dialogue);
}

static int run_calibration(struct request *r)
{
    static struct mr_config config;
    static struct calibrate_points points;
    struct calibrate_fit fit;
    if (r->points)
        calibrate_points_read(r->points, get_unit_kind(r), &points, fatal);
    if (r->config)
        config_text_load(r->config, &config, fatal);
    else
        read_board_config(r, &config, &points);
    struct mr_channel_config *channel = &config.channel[r->channel];
    const struct mr_channel_config old = *channel;
    if (!mr_channel_is_sensor(channel))
        error_set(fatal, MR_USAGE,
                  "the configuration marks %s as not fitted: %s; set its kind first",
                  r->channel_text, r->config);
    check_point_codes(r, &points, channel);
    calibrate_fit(points.point, points.count, r->known_error, r->table, channel, &fit, fatal);
    time_t today = time(NULL) / S_PER_DAY;
    channel->calibrated_day = (uint32_t)today;
    channel->expires_day = (uint32_t)(today + (time_t)r->days);
    if (r->sensor) {
        memset(channel->serial, 0, sizeof channel->serial);
        memcpy(channel->serial, r->sensor, strlen(r->sensor));
    }
    check_gain(r, &config, &old);
    check_fit(r, &points, &fit, channel);
    if (r->output)
        write_config(r, &config);
    return show_fit(r, &points, &fit, channel, 0);
}

/* ---- certificates ---- */

/* Asks for a certificate of the channel and stores it for the board that was logged or checked
 * last. */
static void enter_certificate(const struct request *r)
{
    struct store_certificate row = {.made_us = (int64_t)link_now_us(), .index = r->channel};
    certificates_parse(r->certificate, &row, fatal);
    struct store *store = program_open_campaign(r->db, STORE_OPEN);
    store_newest_board_get(store, row.board_uid, fatal);
    if (!row.board_uid[0])
        error_set(fatal, MR_UNKNOWN, "the campaign has no board yet: %s; run matrig ready DB first",
                  r->db);
    snprintf(row.sensor, sizeof row.sensor, "%s", r->sensor ? r->sensor : "");
    store_certificate_add(store, &row, fatal);
    cli_note(r->cli, "%s: certificate %s of sensor %s entered", r->channel_text, row.number,
             text_or_dash(row.sensor));
}

/* ---- recorded landings ---- */

/* Recalibrates those channels of the landing that the configuration also has. Returns their
 * number. */
static unsigned recompute_landing(const struct request *r, struct store *store,
                                  const struct store_landing *landing,
                                  const struct mr_config *config,
                                  const struct store_recalibration *how)
{
    struct mr_channel_config old[MR_CHANNELS];
    size_t found;
    unsigned values = 0;
    store_channels_get(store, landing->id, old, &found, fatal);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        const struct mr_channel_config *new = &config->channel[c];
        unsigned changed = 0;
        if (!mr_channel_is_sensor(&old[c]))
            continue;
        if (new->kind != old[c].kind || new->number != old[c].number)
            error_set(fatal, MR_LIMIT,
                      "input %u has a different channel in %s than in RUN %lld; use a "
                      "configuration with the channels of that landing",
                      c + 1, r->recompute, (long long)landing->id);
        char name[8], what[JUMP_TEXT_SIZE];
        if (jump_find(&old[c], new, what)) { /* store a jump of the gain with the reason for it */
            jump_channel_name(c, name);
            cli_note(r->cli, "RUN %lld, %s: %s", (long long)landing->id, name, what);
        }
        store_recalibrate(store, landing->id, c, &old[c], new, how, &changed, fatal);
        values += changed;
    }
    return values;
}

static int recompute_landings(struct request *r)
{
    static struct mr_config config;
    struct store_landing *rows = NULL;
    size_t count = 0, landings = 0;
    json_t *list = json_array();
    const struct store_recalibration how = {(int64_t)link_now_us(), annotation_author(r->who),
                                            r->reason, r->zeros};
    config_text_load(r->recompute, &config, fatal);
    /* recalibrate all landings in one transaction */
    struct store *store = program_open_campaign(r->channel_text, STORE_OPEN);
    store_find_run(store, &r->run, fatal);
    store_begin(store, fatal);
    store_landings_get(store, &rows, &count, fatal);
    for (size_t i = 0; i < count; i++) {
        struct store_series series;
        store_landing_series_get(store, &rows[i], &series, fatal);
        if ((r->run && rows[i].id != r->run) || (r->series && strcmp(series.name, r->series) != 0))
            continue;
        unsigned values = recompute_landing(r, store, &rows[i], &config, &how);
        landings++;
        json_array_append_new(
            list, json_pack("{sIsi}", "run", (json_int_t)rows[i].id, "values", (int)values));
    }
    if (landings == 0)
        error_set(fatal, MR_UNKNOWN, "no such landings: %s; matrig show DB lists the landings",
                  r->channel_text);
    store_commit(store, fatal);
    free(rows);
    if (r->cli->json)
        return cli_print_json(json_pack("{so}", "landings", list), 0);
    json_t *item;
    size_t at;
    json_array_foreach(list, at, item)
        printf("RUN %lld: %d values of the calibration changed; the old values are kept\n",
               (long long)json_integer_value(json_object_get(item, "run")),
               (int)json_integer_value(json_object_get(item, "values")));
    json_decref(list);
    return 0;
}

/* ---- the command line ---- */

static unsigned parse_channel(const char *text)
{
    char *end;
    bool transducer = text[0] == 'd';
    unsigned long number = strtoul(text[0] ? text + 1 : text, &end, 10);
    unsigned most = transducer ? MR_TRANSDUCERS : MR_GAGES;
    if ((!transducer && text[0] != 't') || text[1] < '1' || text[1] > '9' || *end != '\0' ||
        number > most)
        error_set(fatal, MR_USAGE, "not a channel: '%s'; give d1 to d%u, or t1 to t%u", text,
                  MR_TRANSDUCERS, MR_GAGES);
    return (unsigned)number - 1 + (transducer ? 0 : MR_TRANSDUCERS);
}

/* Reads the error of the known values: "0.05mm", or a number in inches or pounds. */
static void parse_known_error(struct request *r)
{
    struct quantity_error wrong = {"", ""};
    double most = get_unit_kind(r) == UNIT_DISPLACEMENT ? 0.5 : 20.0;
    if (calibrate_value_parse(r->known_error_text, get_unit_kind(r),
                              unit_word_find(find_unit_text(r), 2), &r->known_error, &wrong) &&
        r->known_error >= 0.0 && r->known_error <= most)
        return;
    if (wrong.what[0])
        error_set(fatal, MR_USAGE, "%s: '%s' for --known; %s", wrong.what, r->known_error_text,
                  wrong.advice);
    error_set(fatal, MR_USAGE,
              "not a standard error from 0 to %g %s: '%s' for --known; give a number in %s, or "
              "with its unit",
              most, find_unit_text(r), r->known_error_text, find_unit_text(r));
}

static void check_request(struct request *r)
{
    struct mr_channel_config room;
    if (r->recompute) {
        if (r->db || r->certificate || r->serial || r->points || r->config || r->output ||
            r->sensor || !isnan(r->days) || r->known_error_text || r->table || r->accept)
            error_set(fatal, MR_USAGE,
                      "--recompute takes only --series, --run, --zeros, --reason and --who; see "
                      "matrig calibrate --help");
        if (!r->reason || !r->reason[0])
            error_set(fatal, MR_USAGE,
                      "no reason: matrig calibrate DB --recompute needs --reason TEXT");
        return;
    }
    if (r->series || r->run || r->zeros || r->reason || r->who)
        error_set(fatal, MR_USAGE,
                  "--series, --run, --zeros, --reason and --who need --recompute; see matrig "
                  "calibrate --help");
    if ((r->certificate != NULL) != (r->db != NULL))
        error_set(fatal, MR_USAGE,
                  "--certificate and --db DB only work together; see matrig calibrate --help");
    bool measures = r->serial || r->points || !r->certificate;
    if (measures && (r->serial != NULL) == (r->points != NULL))
        error_set(fatal, MR_USAGE,
                  "matrig calibrate needs either --serial LINK or --points F; see matrig calibrate "
                  "--help");
    if ((r->config != NULL) != (r->points != NULL))
        error_set(fatal, MR_USAGE,
                  "--config F needs --points; with --serial, leave --config out, because the board "
                  "sends its configuration");
    if (r->accept && (!r->output || !r->accept[0] || r->accept[strcspn(r->accept, "\r\n")]))
        error_set(
            fatal, MR_USAGE,
            "--accept needs a reason of one line and -o F; the reason is stored in that file");
    if (r->sensor && strlen(r->sensor) > sizeof room.serial)
        error_set(fatal, MR_USAGE, "serial number too long: '%s'; give at most %zu characters",
                  r->sensor, sizeof room.serial);
    r->channel = parse_channel(r->channel_text);
    if (r->certificate)
        certificates_parse(r->certificate, &(struct store_certificate){.index = r->channel}, fatal);
    if (isnan(r->days))
        r->days = DEFAULT_VALID_DAYS;
    if (r->known_error_text)
        parse_known_error(r);
}

static int calibrate_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {.cli = cli};
    command_parse(&command_calibrate, argc, argv, cli, &r, &r.channel_text, fatal);
    check_request(&r);
    /* check now, because the measurement may take half an hour */
    output_check_new(r.output, r.force, fatal);
    output_check(r.output, r.points, fatal);
    if (r.recompute)
        return recompute_landings(&r);
    int code = r.serial || r.points ? run_calibration(&r) : 0;
    if (r.certificate)
        enter_certificate(&r);
    return code;
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("CHANNEL", "d1 to d8, t1 to t14"),
    OPTION_TEXT("--serial", "LINK", serial,
                "calibrate on the board, which must be idle; the program asks for one known value "
                "after another"),
    OPTION_TEXT(
        "--points", "F", points,
        "calibrate from a file of VALUE,CODE rows and a configuration file (from matrig board "
        "config get). The first line of F names the columns and the unit of the values: mm,codes "
        "or load (lb),codes. A value may have its own unit: 12.7 mm,372.4"),
    OPTION_TEXT("-o", "F.cfg", output,
                "write the configuration with the new calibration, for matrig board config set"),
    OPTION_TEXT("--sensor", "S", sensor, "serial number of the sensor"),
    OPTION_NUMBER("--days", "N", days, "days", 1.0, 3650.0, (double)NAN,
                  "number of days after which the calibration expires; default: 365"),
    OPTION_TEXT("--known", "E", known_error_text,
                "standard error that all known values have in common, in inches or pounds, or with "
                "a unit (0.05mm)"),
    OPTION_FLAG("--table", table, "store a table of 2 to 8 points; default: a straight line"),
    OPTION_NUMBER("--miss", "P", deviation_max_percent, "%", 0.01, 50.0, DEVIATION_MAX_PERCENT,
                  "largest allowed deviation of a point from the fit, in % of the span of the "
                  "known values; default: {standard}. If a point deviates more, no file is "
                  "written, and the output names the point that is probably wrong"),
    OPTION_TEXT(
        "--accept", "T", accept,
        "accept a larger deviation; T is the reason, which is stored in the configuration file"),
    OPTION_TEXT("--db", "DB", db, "campaign that stores the certificate"),
    OPTION_TEXT(
        "--certificate", "C", certificate,
        "store the sensor's calibration certificate in the campaign of --db:\n  'number=2026-4711, "
        "laboratory=L, calibrated=2026-03-02, due=2027-03-01, uncertainty=0.4%, coverage=2'\nState "
        "the expanded uncertainty: in inches or pounds, with a unit (0.05mm), or as a "
        "share of the "
        "reading (0.4%). due=never is allowed. The newest certificate applies; after its due date "
        "matrig ready reports no-go. matrig ready also compares --sensor S with the configuration"),
    OPTION_TEXT(
        "--recompute", "C", recompute,
        "apply the calibration of configuration C to all recorded landings of DB, to a series or "
        "to one landing. Readings are recomputed from the stored converter codes; the old "
        "calibration is "
        "kept. --zeros also applies the zeros of the gages in C; default: the measured zeros are "
        "kept"),
    OPTION_FORCE(force),
    HELP_NOTE("Results are in inches and pounds, even with --si."),
    HELP_EXAMPLE("matrig calibrate d3 --serial serial:/dev/ttyUSB0 -o rig.cfg --sensor ET-17"),
    OPTION_TEXT("--config", "F", config, NULL),
    OPTION_TEXT("--series", "NAME", series, NULL),
    OPTION_RUN("--run", "RUN", run, NULL),
    OPTION_TEXT("--reason", "T", reason, NULL),
    OPTION_TEXT("--who", "W", who, NULL),
    OPTION_FLAG("--zeros", zeros, NULL),
};

const struct command command_calibrate = {
    "calibrate",
    calibrate_command,
    "CHANNEL (--serial LINK | --points F --config F) [-o F] [--force] [--sensor S] [--days N] "
    "[--known E] [--table] [--miss P] [--accept T]\nCHANNEL --certificate C --db DB [--sensor "
    "S]\nDB --recompute CONFIG [--series NAME | --run RUN] [--zeros] --reason T [--who W]",
    "calibrate a channel against known values; apply a corrected calibration to recorded landings",
    COMMAND_PARTS(parts),
    {1, 1, "CHANNEL or DB"},
};
