#include "host/compare/limits.h"

#include <errno.h>
#include <inttypes.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/quantity.h"
#include "host/base/units.h"

#define FILE_BYTES_MAX 1000000L

enum sense { MOST, LEAST };
#define NO_UNIT UNIT_KINDS
#define SECONDS (UNIT_KINDS + 1)

struct quantity {
    const char *key, *words;
    int unit; /* enum unit_kind, NO_UNIT, SECONDS */
    enum sense sense;
    double (*channel)(const struct compare_channel *);
    double (*overlap)(const struct compare_overlap *);
    double (*pooled)(const struct compare_pooled *);
};

static double channel_bias(const struct compare_channel *c)
{
    return c->f.bias;
}
static double channel_rms(const struct compare_channel *c)
{
    return c->f.rms;
}
static double channel_chi(const struct compare_channel *c)
{
    return c->f.chi;
}
static double channel_inside(const struct compare_channel *c)
{
    return c->f.inside;
}
static double channel_peak(const struct compare_channel *c)
{
    return c->f.peak_measured.value - c->f.peak_simulated.value;
}
static double channel_end(const struct compare_channel *c)
{
    return c->end_measured.value - c->end_simulated.value;
}
static double channel_arrival(const struct compare_channel *c)
{
    return c->f.arrival_measured.t_s - c->f.arrival_simulated.t_s;
}
static double channel_ahead(const struct compare_channel *c)
{
    return c->ahead_measured_ft - c->ahead_simulated_ft;
}
static double channel_correlation(const struct compare_channel *c)
{
    return c->f.correlation;
}
static double channel_lag(const struct compare_channel *c)
{
    return c->f.lag_s;
}
static double channel_bias_en(const struct compare_channel *c)
{
    return c->bias_en;
}
static double channel_peak_en(const struct compare_channel *c)
{
    return c->peak_en;
}
static double channel_end_en(const struct compare_channel *c)
{
    return c->end_en;
}
static double channel_arrival_en(const struct compare_channel *c)
{
    return c->arrival_en;
}
static double overlap_share(const struct compare_overlap *o)
{
    return o->known ? o->share : (double)NAN;
}
static double overlap_start(const struct compare_overlap *o)
{
    return o->start_ft;
}
static double overlap_end(const struct compare_overlap *o)
{
    return o->end_ft;
}
static double pooled_within(const struct compare_pooled *p)
{
    return p->within;
}
static double pooled_bias(const struct compare_pooled *p)
{
    return p->bias_in;
}
static double pooled_rms(const struct compare_pooled *p)
{
    return p->rms_in;
}
static double pooled_moved(const struct compare_pooled *p)
{
    return p->moved_in;
}

static const struct quantity channel_quantities[] = {
    {"bias", "bias", UNIT_DISPLACEMENT, MOST, channel_bias, NULL, NULL},
    {"rms", "rms difference", UNIT_DISPLACEMENT, MOST, channel_rms, NULL, NULL},
    {"peak", "difference of peaks", UNIT_DISPLACEMENT, MOST, channel_peak, NULL, NULL},
    {"end", "difference at the end", UNIT_DISPLACEMENT, MOST, channel_end, NULL, NULL},
    {"arrival", "difference of arrival", SECONDS, MOST, channel_arrival, NULL, NULL},
    {"ahead", "difference of the wheel's distance at arrival", UNIT_STATION, MOST, channel_ahead,
     NULL, NULL},
    {"lag", "lag", SECONDS, MOST, channel_lag, NULL, NULL},
    {"chi", "chi", NO_UNIT, MOST, channel_chi, NULL, NULL},
    {"bias_en", "En of the bias", NO_UNIT, MOST, channel_bias_en, NULL, NULL},
    {"peak_en", "En of the peak", NO_UNIT, MOST, channel_peak_en, NULL, NULL},
    {"end_en", "En at the end", NO_UNIT, MOST, channel_end_en, NULL, NULL},
    {"arrival_en", "En of arrival", NO_UNIT, MOST, channel_arrival_en, NULL, NULL},
    {"correlation", "correlation", NO_UNIT, LEAST, channel_correlation, NULL, NULL},
    {"inside", "share of samples inside two standard errors", NO_UNIT, LEAST, channel_inside, NULL,
     NULL},
};
static const struct quantity zone_quantities[] = {
    {"overlap", "overlap of zones", NO_UNIT, LEAST, NULL, overlap_share, NULL},
    {"start", "difference of the zones' starts", UNIT_STATION, MOST, NULL, overlap_start, NULL},
    {"end", "difference of the zones' ends", UNIT_STATION, MOST, NULL, overlap_end, NULL},
};
static const struct quantity series_quantities[] = {
    {"within", "share of landings within limits", NO_UNIT, LEAST, NULL, NULL, pooled_within},
    {"bias", "pooled bias", UNIT_DISPLACEMENT, MOST, NULL, NULL, pooled_bias},
    {"rms", "pooled rms difference", UNIT_DISPLACEMENT, MOST, NULL, NULL, pooled_rms},
    {"moved", "rms difference of movements between surveys", UNIT_DISPLACEMENT, MOST, NULL, NULL,
     pooled_moved},
};
#define COUNT(array) (sizeof(array) / sizeof((array)[0]))
static const struct {
    const struct quantity *quantity;
    size_t count;
} scopes[COMPARE_SCOPES] = {
    [COMPARE_CHANNELS] = {channel_quantities, COUNT(channel_quantities)},
    [COMPARE_ZONES_SIMULATED] = {zone_quantities, COUNT(zone_quantities)},
    [COMPARE_ZONES_BOARD] = {zone_quantities, COUNT(zone_quantities)},
    [COMPARE_SERIES] = {series_quantities, COUNT(series_quantities)},
};

/* ---- reading ---- */

struct reader {
    const char *path, *text;
    struct compare_limits *limits;
    struct error *error;
};

/* Line in which a key stands for the first time. */
static int line_of(const struct reader *r, const char *key)
{
    char quoted[80];
    snprintf(quoted, sizeof quoted, "\"%.70s\"", key);
    const char *found = strstr(r->text, quoted);
    int line = 1;
    for (const char *c = r->text; found && c < found; c++)
        line += *c == '\n';
    return line;
}

static enum mr_status wrong(const struct reader *r, const char *key, const char *what,
                            const char *wanted)
{
    return error_set(r->error, MR_MALFORMED, "%s: %s line %d: \"%s\"; give %s", what, r->path,
                     line_of(r, key), key, wanted);
}

/* "rms_in": which quantity, and what a number in that unit is in the report's. */
static const struct quantity *find_quantity(enum compare_scope scope, const char *key,
                                            double *factor)
{
    for (size_t i = 0; i < scopes[scope].count; i++) {
        const struct quantity *q = &scopes[scope].quantity[i];
        for (int si = 0; si < 2; si++) {
            char name[60];
            const char *suffix = q->unit == SECONDS ? "s"
                               : q->unit == NO_UNIT ? ""
                                                    : unit_of((enum unit_kind)q->unit, si)->suffix;
            snprintf(name, sizeof name, "%s%s%s", q->key, suffix[0] ? "_" : "", suffix);
            *factor = q->unit < NO_UNIT ? unit_of((enum unit_kind)q->unit, si)->factor : 1.0;
            if (strcmp(name, key) == 0)
                return q;
        }
    }
    return NULL;
}

static void names_of(enum compare_scope scope, char *out, size_t size)
{
    size_t used = 0;
    for (size_t i = 0; i < scopes[scope].count && used < size; i++) {
        const struct quantity *q = &scopes[scope].quantity[i];
        const char *suffix = q->unit == SECONDS           ? "_s"
                           : q->unit == UNIT_STATION      ? "_ft"
                           : q->unit == UNIT_DISPLACEMENT ? "_in"
                                                          : "";
        used += (size_t)snprintf(out + used, size - used, "%s%s%s", i ? ", " : "", q->key, suffix);
    }
}

static enum mr_status read_limits(const struct reader *r, enum compare_scope scope, int64_t channel,
                                  const char *where, const json_t *object)
{
    const char *key;
    json_t *value;
    char names[300];
    if (!json_is_object(object))
        return wrong(r, where, "no object", "limits in braces, {...}");
    json_object_foreach((json_t *)object, key, value)
    {
        double factor;
        if (key[0] == '_')
            continue;
        const struct quantity *q = find_quantity(scope, key, &factor);
        names_of(scope, names, sizeof names);
        if (!q)
            return wrong(r, key, "unknown limit", names);
        double number;
        struct quantity_wrong no_number;
        if (!quantity_json(value, quantity_unit_of_name(key), &number, &no_number)) {
            char wanted[160];
            snprintf(wanted, sizeof wanted, "a number%s, or text with a unit of it (%s)",
                     q->sense == MOST ? ", 0 or more" : "", no_number.what);
            return wrong(r, key, "no limit", wanted);
        }
        if (!isfinite(number) || (q->sense == MOST && number < 0.0))
            return wrong(r, key, "no limit", q->sense == MOST ? "a number, 0 or more" : "a number");
        if (r->limits->count == COMPARE_LIMITS_MAX)
            return wrong(r, key, "too many limits", "160 at most");
        r->limits->limit[r->limits->count++] = (struct compare_limit){
            scope, channel, (size_t)(q - scopes[scope].quantity), number / factor};
    }
    return MR_OK;
}

static enum mr_status read_channels(const struct reader *r, const json_t *object)
{
    const char *key;
    json_t *value;
    if (!json_is_object(object))
        return wrong(r, "channels", "no object", "{\"all\": {...}, \"3\": {...}}");
    json_object_foreach((json_t *)object, key, value)
    {
        char *end;
        long number = strtol(key, &end, 10);
        if (key[0] == '_')
            continue;
        bool all = strcmp(key, "all") == 0;
        if (!all && (*end || end == key || number < 1 || number > (long)MR_TRANSDUCERS))
            return wrong(r, key, "no such transducer", "\"all\", or a number from \"1\" to \"8\"");
        if (read_limits(r, COMPARE_CHANNELS, all ? 0 : number, key, value) != MR_OK)
            return r->error->status;
    }
    return MR_OK;
}

static enum mr_status read_zones(const struct reader *r, const json_t *object)
{
    const char *key;
    json_t *value;
    if (!json_is_object(object))
        return wrong(r, "zones", "no object", "{\"simulated\": {...}, \"board\": {...}}");
    json_object_foreach((json_t *)object, key, value)
    {
        bool simulated = strcmp(key, "simulated") == 0;
        if (key[0] == '_')
            continue;
        if (!simulated && strcmp(key, "board") != 0)
            return wrong(r, key, "unknown zones",
                         "simulated or board: which of them is held against the measured");
        if (read_limits(r, simulated ? COMPARE_ZONES_SIMULATED : COMPARE_ZONES_BOARD, 0, key,
                        value) != MR_OK)
            return r->error->status;
    }
    return MR_OK;
}

static enum mr_status read_file(const struct reader *r, const json_t *root)
{
    const char *key;
    json_t *value;
    if (!json_is_object(root))
        return error_set(
            r->error, MR_MALFORMED,
            "no limits: %s; write an object, {\"channels\": {\"all\": {\"rms_in\": 0.05}}}",
            r->path);
    json_object_foreach((json_t *)root, key, value)
    {
        if (key[0] == '_')
            continue;
        if (strcmp(key, "channels") == 0)
            read_channels(r, value);
        else if (strcmp(key, "zones") == 0)
            read_zones(r, value);
        else if (strcmp(key, "series") == 0)
            read_limits(r, COMPARE_SERIES, 0, key, value);
        else if (strcmp(key, "missing_channels") != 0)
            wrong(r, key, "unknown key",
                  "channels, zones, missing_channels, series, or _ before a comment");
        else if (!json_is_integer(value) || json_integer_value(value) < 0)
            wrong(r, key, "no number of channels", "0 or more");
        else
            r->limits->missing_channels = (size_t)json_integer_value(value);
        if (r->error->status != MR_OK)
            return r->error->status;
    }
    return MR_OK;
}

static char *read_text(const char *path, struct error *error)
{
    FILE *file = fopen(path, "rb");
    char *text = NULL;
    if (!file) {
        error_set(error, MR_IO, "cannot read limits: %s (%s); name a JSON file", path,
                  strerror(errno));
        return NULL;
    }
    text = calloc(1, FILE_BYTES_MAX + 2);
    size_t length = text ? fread(text, 1, FILE_BYTES_MAX + 1, file) : 0;
    if (!text)
        error_set(error, MR_FULL, "no memory: %s; close other programs", path);
    else if (ferror(file))
        error_set(error, MR_IO, "cannot read limits: %s; name a JSON file", path);
    else if (length > FILE_BYTES_MAX)
        error_set(error, MR_MALFORMED,
                  "too long: %s has more than %ld bytes; name a file of limits", path,
                  FILE_BYTES_MAX);
    fclose(file);
    if (error->status == MR_OK)
        return text;
    free(text);
    return NULL;
}

enum mr_status compare_limits_load(struct compare_limits *limits, const char *path,
                                   struct error *error)
{
    json_error_t where;
    char *text = read_text(path, error);
    if (!text)
        return error->status;
    json_t *root = json_loads(text, JSON_REJECT_DUPLICATES, &where);
    const struct reader reader = {path, text, limits, error};
    if (!root)
        error_set(error, MR_MALFORMED, "no JSON: %s line %d: %s; correct it there", path,
                  where.line, where.text);
    else if (read_file(&reader, root) == MR_OK && !compare_limits_any(limits))
        error_set(error, MR_MALFORMED,
                  "no limits: %s has none, so nothing could fail; give one, {\"channels\": "
                  "{\"all\": {\"rms_in\": 0.05}}}",
                  path);
    json_decref(root);
    free(text);
    return error->status;
}

void compare_limits_add_rms(struct compare_limits *limits, double rms_in)
{
    double factor;
    const struct quantity *q = find_quantity(COMPARE_CHANNELS, "rms_in", &factor);
    if (limits->count < COMPARE_LIMITS_MAX)
        limits->limit[limits->count++] =
            (struct compare_limit){COMPARE_CHANNELS, 0, (size_t)(q - channel_quantities), rms_in};
}

bool compare_limits_any(const struct compare_limits *limits)
{
    return limits->count > 0;
}

/* ---- the verdict ---- */

/* `where`: "transducer 3 of RUN 5". */
static void judge(const struct compare_limit *limit, double value, const char *where, bool si,
                  struct compare_verdict *verdict)
{
    const struct quantity *q = &scopes[limit->scope].quantity[limit->quantity];
    double factor = q->unit < NO_UNIT ? unit_of((enum unit_kind)q->unit, si)->factor : 1.0;
    const char *unit = q->unit == SECONDS ? " s"
                     : q->unit == NO_UNIT ? ""
                                          : unit_of((enum unit_kind)q->unit, si)->text;
    const char *blank = unit[0] && unit[0] != ' ' ? " " : "";
    double is = q->sense == MOST ? fabs(value) : value,
           beyond = q->sense == MOST ? is - limit->value : limit->value - is;
    verdict->checked++;
    if (beyond <= 0.0)
        return;
    double size = isnan(beyond) ? (double)INFINITY : beyond / fmax(fabs(limit->value), 1e-12);
    if (verdict->failed++ > 0 && !(size > verdict->worst))
        return;
    verdict->worst = size;
    if (isnan(beyond))
        snprintf(verdict->text, sizeof verdict->text, "%s is not known: %s; its limit is %.4f%s%s",
                 q->words, where, limit->value * factor, blank, unit);
    else
        snprintf(verdict->text, sizeof verdict->text, "%s %.4f%s%s %s %.4f%s%s: %s, by %.4f%s%s",
                 q->words, is * factor, blank, unit,
                 q->sense == MOST ? "exceeds" : "falls short of", limit->value * factor, blank,
                 unit, where, beyond * factor, blank, unit);
}

static bool taken_by_one(const struct compare_limits *limits, const struct compare_limit *all,
                         int64_t channel)
{
    for (size_t i = 0; i < limits->count && all->channel == 0; i++) {
        const struct compare_limit *one = &limits->limit[i];
        if (one->scope == COMPARE_CHANNELS && one->quantity == all->quantity &&
            one->channel == channel)
            return true;
    }
    return false;
}

static void check_channels(const struct compare_limits *limits, const struct compare_limit *limit,
                           const struct compare_figures *figures, bool si,
                           struct compare_verdict *verdict)
{
    char where[100];
    bool there = limit->channel == 0;
    for (size_t c = 0; c < figures->channels; c++) {
        const struct compare_channel *channel = &figures->channel[c];
        if (limit->channel != 0 && limit->channel != channel->number)
            continue;
        there = true;
        snprintf(where, sizeof where, "transducer %" PRId64 " of RUN %" PRId64, channel->number,
                 figures->run);
        if (channel->compared && !taken_by_one(limits, limit, channel->number))
            judge(limit, scopes[COMPARE_CHANNELS].quantity[limit->quantity].channel(channel), where,
                  si, verdict);
    }
    snprintf(where, sizeof where, "transducer %" PRId64 " of RUN %" PRId64 " is not fitted",
             limit->channel, figures->run);
    if (!there)
        judge(limit, (double)NAN, where, si, verdict);
}

static void check_missing(const struct compare_limits *limits,
                          const struct compare_figures *figures, struct compare_verdict *verdict)
{
    size_t missing = 0;
    const struct compare_channel *first = NULL;
    for (size_t c = 0; c < figures->channels; c++) {
        missing += !figures->channel[c].compared;
        first = !first && !figures->channel[c].compared ? &figures->channel[c] : first;
    }
    verdict->checked++;
    if (missing <= limits->missing_channels)
        return;
    verdict->failed++;
    verdict->worst = (double)INFINITY;
    snprintf(verdict->text, sizeof verdict->text,
             "%zu channels not compared, %zu allowed: transducer %" PRId64 " of RUN %" PRId64
             ": %s",
             missing, limits->missing_channels, first->number, figures->run, first->why);
}

static void check_zones(const struct compare_limit *limit, const struct compare_figures *figures,
                        bool si, struct compare_verdict *verdict)
{
    char where[100];
    bool board = limit->scope == COMPARE_ZONES_BOARD;
    const struct quantity *q = &zone_quantities[limit->quantity];
    for (size_t i = 0; i < figures->zones.count; i++) {
        const struct compare_zone_moment *moment = &figures->zones.moment[i];
        const struct compare_overlap *overlap = board ? &moment->board : &moment->simulated;
        double value = q->overlap(overlap);
        snprintf(where, sizeof where, "%s, %s, RUN %" PRId64,
                 board ? "the board's" : "the simulated", moment->what, figures->run);
        if (!(isnan(value) && overlap->known))
            judge(limit, value, where, si, verdict);
    }
}

void compare_limits_check(const struct compare_limits *limits,
                          const struct compare_figures *figures, bool si,
                          struct compare_verdict *verdict)
{
    bool channels = false;
    for (size_t i = 0; i < limits->count; i++) {
        const struct compare_limit *limit = &limits->limit[i];
        channels = channels || limit->scope == COMPARE_CHANNELS;
        if (limit->scope == COMPARE_CHANNELS)
            check_channels(limits, limit, figures, si, verdict);
        else if (limit->scope != COMPARE_SERIES)
            check_zones(limit, figures, si, verdict);
    }
    if (channels)
        check_missing(limits, figures, verdict);
}

void compare_limits_check_series(const struct compare_limits *limits,
                                 const struct compare_pooled *pooled, bool si,
                                 struct compare_verdict *verdict)
{
    for (size_t i = 0; i < limits->count; i++) {
        const struct compare_limit *limit = &limits->limit[i];
        if (limit->scope == COMPARE_SERIES)
            judge(limit, series_quantities[limit->quantity].pooled(pooled), "the series", si,
                  verdict);
    }
}
