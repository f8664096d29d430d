/* matrig calibrate: a channel against known values; and a corrected calibration for landings that are recorded. */
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "common/gain.h"
#include "host/board/configtext.h"
#include "host/board/readytalk.h"
#include "host/calibrate/fit.h"
#include "host/calibrate/jump.h"
#include "host/calibrate/points.h"
#include "host/cli.h"
#include "host/output.h"
#include "host/run.h"
#include "host/store/store_journal.h"
#include "host/store/store_recalibrate.h"

#define POINT_BLOCKS 40u  /* of the board's live readings, 20 ms apart */
#define POINT_S 10.0      /* for them to come */
#define LIVE_S 20
#define MEET_S 20.0
#define MOVES_CODES 6.0   /* a block's noise is below 1 code; more is movement */
#define DAY_S 86400
#define VALID_DAYS 365.0

struct request {
    const struct cli *cli;
    const char *word, *serial, *points, *config, *output, *sensor, *days_text, *known_text, *recompute, *series, *run_text, *reason, *who,
        *unit_text, *changed;
    const struct unit_word *unit; /* of values that name none; NULL: not given */
    bool table, zeros;
    double days, known;
    int64_t run;
    unsigned channel; /* index */
};

/* ---- the board ---- */

static enum unit_kind unit_kind(const struct request *r)
{
    return r->channel < MR_TRANSDUCERS ? UNIT_DISPLACEMENT : UNIT_TENSION;
}

/* Of the result; values are converted to it. */
static const char *unit_text(const struct request *r)
{
    return r->channel < MR_TRANSDUCERS ? "in" : "lb";
}

struct gathering {
    unsigned channel, count, bad;
    double sum, squares, first;
};

static double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void gather(void *context, const struct mr_block *block)
{
    struct gathering *g = context;
    const struct mr_channel_config plain = {.kind = g->channel < MR_TRANSDUCERS ? MR_KIND_DISPLACEMENT : MR_KIND_TENSION, .unit_per_code = 1.0f};
    float ratio = mr_channels_ratio(block);
    struct mr_reading reading = mr_channel_read(&plain, block, g->channel, ratio);
    if (g->count == POINT_BLOCKS)
        return;
    if (isnan(reading.value)) {
        g->bad++;
        return;
    }
    double code = (double)reading.code * (double)ratio;
    g->first = g->count ? g->first : code;
    g->sum += code - g->first;
    g->squares += (code - g->first) * (code - g->first);
    g->count++;
}

/* The channel's mean over a second or so. */
static enum mr_status measure(struct readytalk *talk, struct gathering *g, const char *name, struct calibrate_point *point, struct error *error)
{
    double until_s = now_s() + POINT_S;
    *g = (struct gathering){.channel = g->channel};
    enum mr_status status = readytalk_live(talk, LIVE_S, error);
    if (status != MR_OK && error->status == MR_OK)
        return error_set(error, status, "the board does not read live (%s): %s; it must be idle", mr_status_text(status),
                         link_spec(talk->link[LINK_SERIAL]));
    while (status == MR_OK && g->count < POINT_BLOCKS && g->bad < POINT_BLOCKS && now_s() < until_s)
        status = readytalk_listen(talk, error);
    if (status == MR_OK && g->count < POINT_BLOCKS)
        return error_set(error, g->bad ? MR_LIMIT : MR_TIMEOUT, "%s: %s; %s", name,
                         g->bad ? "its readings are not valid" : "no readings came within 10 s", g->bad ? "look at its leads" : "is the board connected?");
    double n = g->count;
    point->code = g->first + g->sum / n;
    point->spread = sqrt(fmax(g->squares - g->sum * g->sum / n, 0.0) / (n - 1.0));
    return status;
}

/* A line from the keyboard while the board is listened to, so that nothing piles up. False: the end. */
static bool typed_line(struct readytalk *talk, char *line, size_t size, struct error *error)
{
    size_t length = 0;
    while (error->status == MR_OK) {
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
        readytalk_listen(talk, error);
    }
    return false;
}

static enum mr_status guide(const struct request *r, struct readytalk *talk, struct calibrate_points *points, struct error *error)
{
    struct gathering g = {.channel = r->channel};
    char line[100];
    const struct unit_word *plain = r->unit ? r->unit : unit_read(unit_text(r), 2);
    const char *unit = plain->word;
    points->unit = plain;
    talk->context = &g;
    talk->reading = gather;
    talk->until_ms = UINT64_MAX;
    cli_note(r->cli, "%s: set a known value, let it rest, type it (%s) and Enter; u takes the last one back; an empty line or q ends", r->word, unit);
    while (points->count < CALIBRATE_POINTS_MAX) {
        if (!r->cli->quiet)
            fprintf(stderr, "point %zu, %s: ", points->count + 1, unit);
        if (!typed_line(talk, line, sizeof line, error) || line[0] == '\0' || strcmp(line, "q") == 0)
            break;
        if (strcmp(line, "u") == 0) {
            points->count -= points->count > 0;
            continue;
        }
        struct calibrate_point point;
        if (!calibrate_value(line, unit_kind(r), plain, &point.value)) {
            cli_note(r->cli, "not a value: '%s'", line);
            continue;
        }
        if (measure(talk, &g, r->word, &point, error) != MR_OK)
            break;
        bool moves = point.spread > MOVES_CODES;
        cli_note(r->cli, "%.3f codes, noise %.2f%s", point.code, point.spread, moves ? ": it moves, not taken; let it rest and type it again" : "");
        if (!moves)
            points->point[points->count++] = point;
    }
    struct error late = {0};
    if (error->status == MR_OK)
        (void)readytalk_live(talk, 0, &late);
    return error->status;
}

static enum mr_status ask_board(const struct request *r, struct mr_config *config, struct calibrate_points *points, struct error *error)
{
    struct link *link = NULL;
    struct readytalk *talk = calloc(1, sizeof *talk);
    struct ready_facts *facts = calloc(1, sizeof *facts);
    if (!talk || !facts)
        abort();
    enum mr_status status = link_open(r->serial, LINK_SERIAL, &link, error);
    if (status == MR_OK) {
        readytalk_begin(talk, link, NULL, facts, MEET_S);
        status = readytalk_meet(talk, error);
    }
    if (status == MR_OK && !facts->hello)
        status = error_set(error, MR_TIMEOUT, "no board said hello: %s; is it running and connected?", r->serial);
    if (status == MR_OK && !facts->config_known)
        status = error_set(error, MR_TIMEOUT, "the board did not tell its configuration: %s; it must be idle, try again", r->serial);
    if (status == MR_OK)
        *config = facts->config;
    if (status == MR_OK && !mr_channel_measures(&config->channel[r->channel]))
        status = error_set(error, MR_USAGE, "%s is not fitted: the configuration of %s; see matrig board config", r->word, r->serial);
    if (status == MR_OK)
        status = guide(r, talk, points, error);
    link_close(link);
    free(talk);
    free(facts);
    return status;
}

/* ---- the result ---- */

static void tell(const struct request *r, const struct calibrate_points *points, const struct calibrate_fit *fit, const struct mr_channel_config *channel)
{
    const char *unit = unit_text(r);
    printf("%s: %.7g %s per code, zero at %.3f codes, from %zu points between %g and %g %s\n", r->word, fit->unit_per_code, unit,
           fit->zero_code, points->count, fit->low, fit->high, unit);
    if (points->unit && strcmp(points->unit->word, unit) != 0)
        printf("values were read in %s\n", points->unit->word);
    printf("%10s %12s %12s\n", unit, "codes", "residual");
    for (size_t i = 0; i < points->count; i++)
        printf("%10.4f %12.3f %+12.5f%s\n", points->point[i].value, points->point[i].code, fit->residual[i],
               i == fit->worst_point ? "  worst" : "");
    printf("standard errors: gain %.4g %%, zero %.4g %s, what the %s leaves %.4g %s\n", 100.0 * fit->gain_error, fit->zero_error, unit,
           channel->points ? "table" : "straight line", fit->linearity_error, unit);
}

static json_t *result_json(const struct request *r, const struct calibrate_points *points, const struct calibrate_fit *fit,
                           const struct mr_channel_config *channel)
{
    json_t *list = json_array();
    for (size_t i = 0; i < points->count; i++)
        json_array_append_new(list, json_pack("{sososo}", "value", cli_json_number(points->point[i].value, 8), "code",
                                              cli_json_number(points->point[i].code, 9), "residual", cli_json_number(fit->residual[i], 5)));
    return json_pack("{sssssssosososososisoss?}", "channel", r->word, "unit", unit_text(r), "values_read_in",
                     points->unit ? points->unit->word : unit_text(r), "unit_per_code",
                     cli_json_number(fit->unit_per_code, 9), "zero_code", cli_json_number(fit->zero_code, 9), "gain_error",
                     cli_json_number(fit->gain_error, 5), "zero_error", cli_json_number(fit->zero_error, 5), "linearity_error",
                     cli_json_number(fit->linearity_error, 5), "table_points", channel->points, "points", list, "file", r->output);
}

/* What was said of a change stands before the configuration: the file tells why its gain is another. */
static void write_changed(const struct request *r, const struct jump *jump, const struct mr_channel_config *channel, FILE *out)
{
    char day[20], what[160];
    time_t now = time(NULL);
    struct tm utc;
    gmtime_r(&now, &utc);
    strftime(day, sizeof day, "%Y-%m-%d", &utc);
    jump_text(jump, channel, what, sizeof what);
    fprintf(out, "# %s %s: %s%sthis was said: ", day, r->word, what, what[0] ? "; " : "");
    for (const char *p = r->changed; *p; p++)
        fputc((unsigned char)*p < ' ' ? ' ' : *p, out);
    fputc('\n', out);
}

static enum mr_status write_config(const struct request *r, const struct mr_config *config, const struct jump *jump, struct error *error)
{
    FILE *out = output_open(r->output, error);
    if (!out)
        return error->status;
    char *text = configtext_write(config);
    if (r->changed)
        write_changed(r, jump, &config->channel[r->channel], out);
    fputs(text, out);
    free(text);
    return output_close(out, r->output, error);
}

static const char *source(const struct request *r)
{
    return r->points ? r->points : r->serial;
}

/* A code that the channel cannot read is none: swapped columns, another program's numbers. */
static enum mr_status check_codes(const struct request *r, const struct calibrate_points *points, const struct mr_channel_config *channel,
                                  struct error *error)
{
    const struct mr_gain_limits limits = mr_gain_limits(channel);
    for (size_t i = 0; i < points->count; i++) {
        double code = points->point[i].code;
        if (code < (double)limits.low_code || code > (double)limits.high_code)
            return error_set(error, MR_LIMIT, "%g is no code that %s reads, point %zu: %s; from %.0f to %.0f: are the columns swapped?", code,
                             r->word, i + 1, source(r), (double)limits.low_code, (double)limits.high_code);
    }
    return MR_OK;
}

/* Is it possible, and does it follow from the last calibration? */
static enum mr_status check_gain(const struct request *r, const struct mr_config *config, const struct mr_channel_config *old,
                                 struct jump *jump, struct error *error)
{
    struct mr_config_reason reason;
    char text[500];
    const struct mr_channel_config *channel = &config->channel[r->channel];
    (void)jump_find(old, channel, jump);
    if (mr_config_check(config, &reason) != MR_OK) {
        configtext_reason(config, &reason, text, sizeof text);
        return error_set(error, MR_LIMIT, "no board would take that: %s; %s", source(r), text);
    }
    if (!jump->gain && !jump->zero)
        return MR_OK;
    jump_text(jump, channel, text, sizeof text);
    if (!jump->gain || r->changed) {
        cli_note(r->cli, "%s: %s, compared with %s", r->word, text, old->calibrated_day ? "the last calibration" : "the configuration");
        return MR_OK;
    }
    return error_set(error, MR_LIMIT, "%s: %s, compared with %s: %s; look at unit and points; %s--changed NOTE says what is another now", r->word,
                     text, old->calibrated_day ? "the last calibration" : "the configuration", source(r),
                     jump->another || !old->serial[0] ? "" : "of another sensor: --sensor S; ");
}

static enum mr_status calibrate(const struct request *r, struct error *error)
{
    static struct mr_config config;
    static struct calibrate_points points;
    struct calibrate_fit fit;
    struct jump jump;
    enum mr_status status = r->config ? configtext_load(r->config, &config, error) : MR_OK;
    if (status == MR_OK)
        status = r->points ? calibrate_points_read(r->points, unit_kind(r), r->unit, &points, error) : ask_board(r, &config, &points, error);
    struct mr_channel_config *channel = &config.channel[r->channel];
    const struct mr_channel_config old = *channel;
    if (status == MR_OK && !mr_channel_measures(channel))
        status = error_set(error, MR_USAGE, "%s is not fitted: %s; set its kind first", r->word, r->config);
    if (status == MR_OK)
        status = check_codes(r, &points, channel, error);
    if (status == MR_OK)
        status = calibrate_fit(points.point, points.count, r->known, r->table, channel, &fit, error);
    if (status != MR_OK)
        return status;
    time_t today = time(NULL) / DAY_S;
    channel->calibrated_day = (uint32_t)today;
    channel->expires_day = (uint32_t)(today + (time_t)r->days);
    if (r->sensor) {
        memset(channel->serial, 0, sizeof channel->serial);
        memcpy(channel->serial, r->sensor, strlen(r->sensor));
    }
    status = check_gain(r, &config, &old, &jump, error);
    if (status == MR_OK && r->output)
        status = write_config(r, &config, &jump, error);
    if (status != MR_OK)
        return status;
    if (r->cli->json)
        cli_print_json(result_json(r, &points, &fit, channel), 0);
    else
        tell(r, &points, &fit, channel);
    return MR_OK;
}

/* ---- recorded landings ---- */

/* All measuring channels of one landing that the configuration has as well. */
static enum mr_status recompute_landing(const struct request *r, struct store *store, const struct store_landing *landing,
                                        const struct mr_config *config, const struct store_recalibration *how, unsigned *values,
                                        struct error *error)
{
    struct mr_channel_config old[MR_CHANNELS];
    size_t found;
    *values = 0;
    enum mr_status status = store_channels(store, landing->id, old, &found, error);
    for (unsigned c = 0; c < MR_CHANNELS && status == MR_OK; c++) {
        const struct mr_channel_config *new = &config->channel[c];
        unsigned changed = 0;
        if (!mr_channel_measures(&old[c]))
            continue;
        if (new->kind != old[c].kind || new->number != old[c].number)
            return error_set(error, MR_LIMIT, "input %u is another channel in %s than in RUN %lld; correct the configuration of that landing", c + 1,
                             r->recompute, (long long)landing->id);
        status = store_recalibrate(store, landing->id, c, &old[c], new, how, &changed, error);
        *values += changed;
    }
    return status;
}

static enum mr_status recompute(const struct request *r, struct error *error)
{
    static struct mr_config config;
    struct store *store = NULL;
    struct store_landing *rows = NULL;
    size_t count = 0, landings = 0;
    json_t *list = json_array();
    const struct store_recalibration how = {(int64_t)link_now_us(), r->who ? r->who : getenv("USER"), r->reason, r->zeros};
    enum mr_status status = configtext_load(r->recompute, &config, error);
    if (status == MR_OK)
        status = store_open(r->word, STORE_OPEN, &store, error);
    if (status == MR_OK)
        status = store_begin(store, error);
    if (status == MR_OK)
        status = store_landings(store, &rows, &count, error);
    for (size_t i = 0; i < count && status == MR_OK; i++) {
        struct store_series series;
        unsigned values = 0;
        status = store_series_of(store, &rows[i], &series, error);
        if (status != MR_OK || (r->run && rows[i].id != r->run) || (r->series && strcmp(series.name, r->series) != 0))
            continue;
        status = recompute_landing(r, store, &rows[i], &config, &how, &values, error);
        landings++;
        json_array_append_new(list, json_pack("{sIsi}", "run", (json_int_t)rows[i].id, "values", (int)values));
        if (status == MR_OK && !r->cli->json)
            printf("RUN %lld: %u values of its calibration are different now; the old ones are kept\n", (long long)rows[i].id, values);
    }
    if (status == MR_OK && landings == 0)
        status = error_set(error, MR_UNKNOWN, "no such landings: %s; matrig landing DB lists them", r->word);
    if (status == MR_OK)
        status = store_commit(store, error);
    store_close(store); /* takes back what was not committed: all landings or none */
    free(rows);
    if (status == MR_OK && r->cli->json)
        cli_print_json(json_pack("{sO}", "landings", list), 0);
    json_decref(list);
    return status;
}

/* ---- the command line ---- */

static enum mr_status parse_channel(const char *text, unsigned *channel, struct error *error)
{
    char *end;
    bool transducer = text[0] == 'd';
    unsigned long number = strtoul(text[0] ? text + 1 : text, &end, 10);
    unsigned most = transducer ? MR_TRANSDUCERS : MR_GAGES;
    if ((!transducer && text[0] != 't') || text[1] < '1' || text[1] > '9' || *end != '\0' || number > most)
        return error_set(error, MR_USAGE, "not a channel: '%s'; d1 to d%u, or t1 to t%u", text, MR_TRANSDUCERS, MR_GAGES);
    *channel = (unsigned)number - 1 + (transducer ? 0 : MR_TRANSDUCERS);
    return MR_OK;
}

/* In in or lb, or with its unit: 0.05mm. */
static enum mr_status read_known(struct request *r, struct error *error)
{
    if (calibrate_value(r->known_text, unit_kind(r), unit_read(unit_text(r), 2), &r->known) && r->known >= 0.0 && r->known <= 100.0)
        return MR_OK;
    return error_set(error, MR_USAGE, "no error from 0 to 100 %s: '%s' for --known; a number in %s, or with its unit", unit_text(r), r->known_text,
                     unit_text(r));
}

static enum mr_status check(struct request *r, struct error *error)
{
    enum mr_status status = MR_OK;
    struct mr_channel_config room;
    r->days = VALID_DAYS;
    if (r->recompute) {
        if (r->unit_text || r->changed || r->serial || r->points || r->config || r->output || r->sensor || r->days_text || r->known_text || r->table)
            return error_set(error, MR_USAGE, "--recompute goes with --series, --run, --zeros, --reason and --who alone; see matrig calibrate --help");
        if (!r->reason || !r->reason[0])
            return error_set(error, MR_USAGE, "why? matrig calibrate DB --recompute needs --reason TEXT; who reads it later will ask");
        return r->run_text ? run_parse(r->run_text, &r->run, error) : MR_OK;
    }
    if (r->series || r->run_text || r->zeros || r->reason || r->who)
        return error_set(error, MR_USAGE, "--series, --run, --zeros, --reason and --who go with --recompute; see matrig calibrate --help");
    if ((r->serial != NULL) == (r->points != NULL))
        return error_set(error, MR_USAGE, "--serial LINK or --points F, one of them: matrig calibrate; see matrig calibrate --help");
    if ((r->config != NULL) != (r->points != NULL))
        return error_set(error, MR_USAGE, "--config F goes with --points; with --serial the board tells its own: matrig calibrate");
    if (r->sensor && strlen(r->sensor) > sizeof room.serial)
        return error_set(error, MR_USAGE, "serial number too long: '%s'; %zu characters at most", r->sensor, sizeof room.serial);
    status = parse_channel(r->word, &r->channel, error);
    if (status == MR_OK && r->unit_text)
        r->unit = unit_read(r->unit_text, strlen(r->unit_text));
    if (status == MR_OK && r->unit_text && (!r->unit || r->unit->kind != unit_kind(r)))
        return error_set(error, MR_USAGE, "no unit of %s: '%s' for --unit; in, mm, cm, m, ft of a transducer, lb, N, kN, kg of a gage", r->word,
                         r->unit_text);
    if (status == MR_OK && r->changed && !r->changed[strspn(r->changed, " \t")])
        return error_set(error, MR_USAGE, "what was changed? --changed needs a NOTE; who reads it later will ask");
    if (status == MR_OK && r->days_text)
        status = cli_number(r->days_text, "--days", 1.0, 3650.0, &r->days, error);
    return status == MR_OK && r->known_text ? read_known(r, error) : status;
}

int calibrate_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {.cli = cli};
    const struct cli_option options[] = {
        {"--serial", &r.serial, NULL},   {"--points", &r.points, NULL},     {"--config", &r.config, NULL}, {"-o", &r.output, NULL},
        {"--sensor", &r.sensor, NULL},   {"--days", &r.days_text, NULL},    {"--known", &r.known_text, NULL},
        {"--unit", &r.unit_text, NULL},  {"--changed", &r.changed, NULL},
        {"--recompute", &r.recompute, NULL}, {"--series", &r.series, NULL}, {"--run", &r.run_text, NULL},
        {"--reason", &r.reason, NULL},   {"--who", &r.who, NULL},           {"--table", NULL, &r.table},   {"--zeros", NULL, &r.zeros}};
    struct error error = {0};
    enum mr_status status = cli_parse(argc, argv, options, sizeof options / sizeof options[0], &r.word, 1, 1, "CHANNEL or DB", &error);
    if (status == MR_OK)
        status = check(&r, &error);
    if (status == MR_OK)
        status = r.recompute ? recompute(&r, &error) : calibrate(&r, &error);
    return status == MR_OK ? 0 : cli_fail(&error);
}
