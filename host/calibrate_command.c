/* matrig calibrate: a channel against known values; and a corrected calibration for landings that are recorded. */
#include <errno.h>
#include <math.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "host/board/configtext.h"
#include "host/board/readytalk.h"
#include "host/calibrate/fit.h"
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
    const char *word, *serial, *points, *config, *output, *sensor, *days_text, *known_text, *recompute, *series, *run_text, *reason, *who;
    bool table, zeros;
    double days, known;
    int64_t run;
    unsigned channel; /* index */
};

/* ---- points ---- */

struct points {
    struct calibrate_point point[CALIBRATE_POINTS_MAX];
    size_t count;
};

/* "value,code" rows; a first row of names is passed over. */
static enum mr_status read_points(const char *path, struct points *points, struct error *error)
{
    char line[300];
    enum mr_status status = MR_OK;
    FILE *file = fopen(path, "r");
    if (!file)
        return error_set(error, MR_IO, "cannot read (%s): %s; check path and rights", strerror(errno), path);
    for (unsigned number = 1; status == MR_OK && fgets(line, sizeof line, file); number++) {
        char *value_end, *code_end;
        double value = strtod(line, &value_end), code = *value_end == ',' ? strtod(value_end + 1, &code_end) : (double)NAN;
        bool good = value_end != line && *value_end == ',' && code_end != value_end + 1 && code_end[strspn(code_end, " \t\r\n")] == '\0' &&
                    isfinite(value) && isfinite(code);
        if (line[strspn(line, " \t\r\n")] == '\0' || (number == 1 && value_end == line))
            continue;
        if (!good)
            status = error_set(error, MR_MALFORMED, "not a value and a code: %s, line %u; write VALUE,CODE", path, number);
        else if (points->count == CALIBRATE_POINTS_MAX)
            status = error_set(error, MR_TOO_LONG, "more than %u points: %s; leave some out", CALIBRATE_POINTS_MAX, path);
        else
            points->point[points->count++] = (struct calibrate_point){value, code, (double)NAN};
    }
    fclose(file);
    return status;
}

/* ---- the board ---- */

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

static enum mr_status guide(const struct request *r, struct readytalk *talk, struct points *points, struct error *error)
{
    struct gathering g = {.channel = r->channel};
    char line[100];
    const char *unit = r->channel < MR_TRANSDUCERS ? "in" : "lb";
    talk->context = &g;
    talk->reading = gather;
    talk->until_ms = UINT64_MAX;
    cli_note(r->cli, "%s: set a known value, let it rest, type it (%s) and Enter; u takes the last one back; an empty line or q ends", r->word, unit);
    while (points->count < CALIBRATE_POINTS_MAX) {
        char *end;
        if (!r->cli->quiet)
            fprintf(stderr, "point %zu, %s: ", points->count + 1, unit);
        if (!typed_line(talk, line, sizeof line, error) || line[0] == '\0' || strcmp(line, "q") == 0)
            break;
        if (strcmp(line, "u") == 0) {
            points->count -= points->count > 0;
            continue;
        }
        struct calibrate_point point = {.value = strtod(line, &end)};
        if (end == line || *end != '\0' || !isfinite(point.value)) {
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

static enum mr_status ask_board(const struct request *r, struct mr_config *config, struct points *points, struct error *error)
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

static void tell(const struct request *r, const struct points *points, const struct calibrate_fit *fit, const struct mr_channel_config *channel)
{
    const char *unit = r->channel < MR_TRANSDUCERS ? "in" : "lb";
    printf("%s: %.7g %s per code, zero at %.3f codes, from %zu points between %g and %g %s\n", r->word, fit->unit_per_code, unit,
           fit->zero_code, points->count, fit->low, fit->high, unit);
    printf("%10s %12s %12s\n", unit, "codes", "residual");
    for (size_t i = 0; i < points->count; i++)
        printf("%10.4f %12.3f %+12.5f%s\n", points->point[i].value, points->point[i].code, fit->residual[i],
               i == fit->worst_point ? "  worst" : "");
    printf("standard errors: gain %.4g %%, zero %.4g %s, what the %s leaves %.4g %s\n", 100.0 * fit->gain_error, fit->zero_error, unit,
           channel->points ? "table" : "straight line", fit->linearity_error, unit);
}

static json_t *result_json(const struct request *r, const struct points *points, const struct calibrate_fit *fit,
                           const struct mr_channel_config *channel)
{
    json_t *list = json_array();
    for (size_t i = 0; i < points->count; i++)
        json_array_append_new(list, json_pack("{sososo}", "value", cli_json_number(points->point[i].value, 8), "code",
                                              cli_json_number(points->point[i].code, 9), "residual", cli_json_number(fit->residual[i], 5)));
    return json_pack("{sssssosososososisoss?}", "channel", r->word, "unit", r->channel < MR_TRANSDUCERS ? "in" : "lb", "unit_per_code",
                     cli_json_number(fit->unit_per_code, 9), "zero_code", cli_json_number(fit->zero_code, 9), "gain_error",
                     cli_json_number(fit->gain_error, 5), "zero_error", cli_json_number(fit->zero_error, 5), "linearity_error",
                     cli_json_number(fit->linearity_error, 5), "table_points", channel->points, "points", list, "file", r->output);
}

static enum mr_status write_config(const struct request *r, const struct mr_config *config, struct error *error)
{
    struct mr_config_reason reason;
    char why[400];
    if (mr_config_check(config, &reason) != MR_OK) {
        configtext_reason(config, &reason, why, sizeof why);
        return error_set(error, MR_LIMIT, "no board would take that: %s; look at the points", why);
    }
    FILE *out = output_open(r->output, error);
    if (!out)
        return error->status;
    char *text = configtext_write(config);
    fputs(text, out);
    free(text);
    return output_close(out, r->output, error);
}

static enum mr_status calibrate(const struct request *r, struct error *error)
{
    static struct mr_config config;
    struct points points = {.count = 0};
    struct calibrate_fit fit;
    enum mr_status status = r->config ? configtext_load(r->config, &config, error) : MR_OK;
    if (status == MR_OK)
        status = r->points ? read_points(r->points, &points, error) : ask_board(r, &config, &points, error);
    struct mr_channel_config *channel = &config.channel[r->channel];
    if (status == MR_OK && !mr_channel_measures(channel))
        status = error_set(error, MR_USAGE, "%s is not fitted: %s; set its kind first", r->word, r->config);
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
    if (r->output)
        status = write_config(r, &config, error);
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

static enum mr_status check(struct request *r, struct error *error)
{
    enum mr_status status = MR_OK;
    struct mr_channel_config room;
    r->days = VALID_DAYS;
    if (r->recompute) {
        if (r->serial || r->points || r->config || r->output || r->sensor || r->days_text || r->known_text || r->table)
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
    if (status == MR_OK && r->days_text)
        status = cli_number(r->days_text, "--days", 1.0, 3650.0, &r->days, error);
    return status == MR_OK && r->known_text ? cli_number(r->known_text, "--known", 0.0, 100.0, &r->known, error) : status;
}

int calibrate_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {.cli = cli};
    const struct cli_option options[] = {
        {"--serial", &r.serial, NULL},   {"--points", &r.points, NULL},     {"--config", &r.config, NULL}, {"-o", &r.output, NULL},
        {"--sensor", &r.sensor, NULL},   {"--days", &r.days_text, NULL},    {"--known", &r.known_text, NULL},
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
