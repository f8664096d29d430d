#include "host/exchange/mapping.h"

#include <ctype.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/channels.h"
#include "host/base/xmalloc.h"
#include "host/base/quantity.h"
#include "host/exchange/textfile.h"

#define SWITCH_MAX 64u

void series_add(struct series *series, double time_s, double value)
{
    xlist_grow(&series->time_s, series->count, sizeof *series->time_s);
    xlist_grow(&series->value, series->count, sizeof *series->value);
    series->time_s[series->count] = time_s;
    series->value[series->count++] = value;
}

double mapping_value(const struct mapping_channel *channel, double read)
{
    return read * channel->scale + channel->offset;
}

/* ---- signals of a frame ---- */

/* Bit n of the signal from its lowest: its place in the frame. Big-endian signals begin at their
 * highest bit and go on at bit 7 of the next byte. */
static unsigned place_of(const struct import_signal *signal, unsigned n)
{
    if (!signal->big_endian)
        return signal->start_bit + n;
    unsigned from_top = signal->bits - 1 - n;
    unsigned in_order = (signal->start_bit / 8) * 8 + (7 - signal->start_bit % 8) + from_top;
    return (in_order / 8) * 8 + (7 - in_order % 8);
}

bool signal_fits(const struct import_signal *signal, unsigned length)
{
    if (signal->bits == 0 || signal->bits > 64 || signal->start_bit > 63 ||
        (signal->is_float && signal->bits != 32 && signal->bits != 64))
        return false;
    return signal->big_endian
             ? (signal->start_bit / 8) * 8 + (7 - signal->start_bit % 8) + signal->bits <=
                   8 * length
             : signal->start_bit + signal->bits <= 8 * length;
}

bool signal_value(const struct import_signal *signal, const struct link_frame *frame, double *value)
{
    uint64_t raw = 0;
    if (frame->id != signal->id || !signal_fits(signal, frame->length))
        return false;
    for (unsigned n = 0; n < signal->bits; n++) {
        unsigned bit = place_of(signal, n);
        raw |= (uint64_t)(frame->data[bit / 8] >> (bit % 8) & 1u) << n;
    }
    if (signal->is_float && signal->bits == 32) {
        float single;
        uint32_t low = (uint32_t)raw;
        memcpy(&single, &low, sizeof single);
        *value = (double)single;
    } else if (signal->is_float) {
        memcpy(value, &raw, sizeof *value);
    } else if (signal->is_signed && raw >> (signal->bits - 1) & 1u) {
        if (signal->bits < 64)
            raw |= ~0ull << signal->bits;
        *value = (double)(int64_t)raw;
    } else {
        *value = (double)raw;
    }
    return isfinite(*value);
}

/* ---- names ---- */

static bool number_after(const char *text, size_t letters, unsigned most, unsigned *number)
{
    char *end;
    if (!isdigit((unsigned char)text[letters]))
        return false;
    unsigned long value = strtoul(text + letters, &end, 10);
    *number = (unsigned)value;
    return *end == '\0' && value >= 1 && value <= most;
}

bool mapping_channel_named(const char *text, struct mapping_channel *channel)
{
    if (strcmp(text, "gear") == 0) {
        channel->role = MAPPING_GEAR;
        return true;
    }
    channel->role = text[0] == 'd' ? MAPPING_DISPLACEMENT
                  : text[0] == 't' ? MAPPING_TENSION
                                   : MAPPING_SWITCH;
    if (text[0] == 'd' || text[0] == 't')
        return number_after(text, 1, text[0] == 'd' ? MR_TRANSDUCERS : MR_GAGES, &channel->number);
    return strncmp(text, "switch", 6) == 0 && number_after(text, 6, SWITCH_MAX, &channel->number);
}

double mapping_unit(enum mapping_role role, const char *unit)
{
    const char *own = role == MAPPING_TENSION ? "lb" : role == MAPPING_GEAR ? "ft" : "in";
    double factor = *unit ? quantity_convert(1.0, unit, own) : (double)NAN;
    return isnan(factor) ? 0.0 : factor;
}

/* ---- JSON ---- */

struct reader {
    const char *path;
    struct error *error;
};

static void wrong(const struct reader *r, const char *where, const char *key, const char *wanted)
{
    error_set(r->error, MR_MALFORMED, "%s%s%s: %s; %s", where, where[0] ? "." : "", key, r->path,
              wanted);
}

static void check_keys(const struct reader *r, const char *where, json_t *object,
                       const char *const *known)
{
    const char *key;
    json_t *value;
    json_object_foreach(object, key, value)
    {
        bool found = false;
        for (size_t i = 0; known[i]; i++)
            found |= strcmp(known[i], key) == 0;
        if (!found)
            wrong(r, where, key, "no such key; see matrig import --help");
    }
}

/* `unit`: of a number; text has its own. */
static double number_in(const struct reader *r, const char *where, json_t *object, const char *key,
                        const char *unit, double otherwise)
{
    json_t *value = json_object_get(object, key);
    struct quantity_wrong wrongly;
    double v;
    if (!value)
        return otherwise;
    if (!quantity_json(value, unit, &v, &wrongly)) {
        wrong(r, where, key, wrongly.advice);
        return otherwise;
    }
    if (!isfinite(v) || fabs(v) > 1e12) {
        wrong(r, where, key, "give a number");
        return otherwise;
    }
    return v;
}

static double number(const struct reader *r, const char *where, json_t *object, const char *key,
                     double otherwise)
{
    return number_in(r, where, object, key, quantity_unit_of_name(key), otherwise);
}

static unsigned whole(const struct reader *r, const char *where, json_t *object, const char *key,
                      unsigned most, unsigned otherwise)
{
    double v = number(r, where, object, key, (double)otherwise);
    if (v < 0.0 || v > (double)most || v != floor(v)) {
        wrong(r, where, key, "give a whole number that is not too large");
        return otherwise;
    }
    return (unsigned)v;
}

static void text(const struct reader *r, const char *where, json_t *object, const char *key,
                 char *to, size_t size)
{
    json_t *value = json_object_get(object, key);
    if (!value)
        return;
    if (!json_is_string(value) || json_string_length(value) >= size)
        wrong(r, where, key, "give a string that is not too long");
    else
        snprintf(to, size, "%s", json_string_value(value));
}

static char character(const struct reader *r, json_t *root, const char *key, char otherwise)
{
    char one[4] = {otherwise, '\0'};
    text(r, "", root, key, one, sizeof one);
    if (one[0] == '\0' && key[0] == 'c') /* no comments */
        return '\0';
    if (strlen(one) != 1 || one[0] == '"' || one[0] == '\n')
        wrong(r, "", key, "give one character");
    return one[0];
}

static bool yes(const struct reader *r, const char *where, json_t *object, const char *key)
{
    json_t *value = json_object_get(object, key);
    if (value && !json_is_boolean(value))
        wrong(r, where, key, "give true or false");
    return json_is_true(value);
}

/* By name, or counted from 1. */
static void column(const struct reader *r, const char *where, json_t *object,
                   char name[MAPPING_NAME], unsigned *place)
{
    json_t *value = json_object_get(object, "column");
    if (json_is_integer(value))
        *place = whole(r, where, object, "column", 10000, 0);
    else
        text(r, where, object, "column", name, MAPPING_NAME);
    if (!*place && !name[0])
        wrong(r, where, "column", "give the column's name, or its number from 1");
}

static void read_time(const struct reader *r, json_t *root, struct mapping *m)
{
    static const char *const known[] = {"column", "unit", "shift_s", NULL};
    json_t *time = json_object_get(root, "time");
    char unit[16] = "s";
    m->time_unit_s = 0.0;
    if (!json_is_object(time)) {
        if (!m->signals || time)
            wrong(r, "", "time", "give an object with the column and unit of time");
        m->time_unit_s = 1.0;
        return;
    }
    check_keys(r, "time", time, known);
    if (!m->signals)
        column(r, "time", time, m->time_column, &m->time_place);
    else if (json_object_get(time, "column"))
        wrong(r, "time", "column", "the times are those of the log: leave it out");
    text(r, "time", time, "unit", unit, sizeof unit);
    m->time_unit_s = *unit ? quantity_convert(1.0, unit, "s") : (double)NAN;
    if (isnan(m->time_unit_s))
        wrong(r, "time", "unit", "give s, ms, us or min");
    m->shift_s = number(r, "time", time, "shift_s", 0.0);
}

/* Where the numbers are: column or signal. */
static void read_source(const struct reader *r, const char *where, json_t *entry, struct mapping *m,
                        struct mapping_channel *c)
{
    char id[16] = "", order[8] = "little";
    if (!m->signals) {
        column(r, where, entry, c->column, &c->place);
        return;
    }
    char *end = NULL;
    text(r, where, entry, "id", id, sizeof id);
    unsigned long value = strtoul(id, &end, 16);
    bool wide = strlen(id) > 5; /* 0x321 or 0x00000321 */
    if (!id[0] || strncmp(id, "0x", 2) != 0 || *end || value > (wide ? 0x1fffffffUL : 0x7ffUL))
        wrong(r, where, "id", "give the identifier as 0x and 3 or 8 hexadecimal digits");
    c->signal.id = (uint32_t)value | (wide ? LINK_ID_EXTENDED : 0);
    c->signal.start_bit = whole(r, where, entry, "start_bit", 63, 0);
    c->signal.bits = whole(r, where, entry, "bits", 64, 0);
    c->signal.is_signed = yes(r, where, entry, "signed");
    c->signal.is_float = yes(r, where, entry, "float");
    text(r, where, entry, "byte_order", order, sizeof order);
    c->signal.big_endian = strcmp(order, "big") == 0;
    if (!c->signal.big_endian && strcmp(order, "little") != 0)
        wrong(r, where, "byte_order", "give little or big");
    if (!signal_fits(&c->signal, 8))
        wrong(r, where, "bits", "start_bit and bits must lie within 8 bytes");
}

static void read_unit(const struct reader *r, const char *where, json_t *entry,
                      struct mapping_channel *c)
{
    char unit[16] = "";
    double factor = 1.0;
    text(r, where, entry, "unit", unit, sizeof unit);
    if (c->role == MAPPING_DISPLACEMENT || c->role == MAPPING_TENSION || c->role == MAPPING_GEAR)
        factor = mapping_unit(c->role, unit);
    if (factor == 0.0)
        wrong(r, where, "unit",
              c->role == MAPPING_TENSION ? "give lb, N, kN or kip" : "give in, mm, cm, m or ft");
    c->scale = factor * number(r, where, entry, "scale", 1.0);
    c->offset = factor * number_in(r, where, entry, "offset", unit, 0.0);
    c->error = factor * number_in(r, where, entry, "error", unit, (double)NAN);
    if (c->scale == 0.0)
        wrong(r, where, "scale", "0 leaves nothing of the readings");
    if (c->error < 0.0)
        wrong(r, where, "error", "a standard error is not negative");
}

static void read_edge(const struct reader *r, const char *where, json_t *entry,
                      struct mapping_channel *c)
{
    char edge[16] = "rising";
    text(r, where, entry, "edge", edge, sizeof edge);
    c->falling = strcmp(edge, "falling") == 0;
    if (!c->falling && strcmp(edge, "rising") != 0)
        wrong(r, where, "edge", "give rising or falling");
    c->threshold = number(r, where, entry, "threshold", (double)NAN);
    if (isnan(c->threshold))
        wrong(r, where, "threshold", "give the value that the edge passes");
}

static void read_channel(const struct reader *r, json_t *entry, size_t index, struct mapping *m)
{
    static const char *const known[] = {"column", "channel",   "unit",       "scale",
                                        "offset", "threshold", "edge",       "station_ft",
                                        "error",  "id",        "start_bit",  "bits",
                                        "signed", "float",     "byte_order", NULL};
    struct mapping_channel *c = &m->channel[m->channels++];
    char where[32], name[16] = "";
    snprintf(where, sizeof where, "channels[%zu]", index);
    *c = (struct mapping_channel){.station_ft = (double)NAN, .error = (double)NAN};
    if (!json_is_object(entry)) {
        wrong(r, "", where, "give an object");
        return;
    }
    check_keys(r, where, entry, known);
    text(r, where, entry, "channel", name, sizeof name);
    if (!mapping_channel_named(name, c)) {
        wrong(r, where, "channel", "give d1 to d8, t1 to t14, gear or switch1 to switch64");
        return;
    }
    for (size_t i = 0; i + 1 < m->channels; i++) {
        if (m->channel[i].role == c->role && m->channel[i].number == c->number)
            wrong(r, where, "channel", "this one is there twice");
    }
    read_source(r, where, entry, m, c);
    read_unit(r, where, entry, c);
    if (c->role == MAPPING_SWITCH)
        read_edge(r, where, entry, c);
    c->station_ft = number(r, where, entry, "station_ft", (double)NAN);
}

static void read_align(const struct reader *r, json_t *root, struct mapping *m)
{
    static const char *const known[] = {"column", "threshold",  "edge", "switch",
                                        "id",     "start_bit",  "bits", "signed",
                                        "float",  "byte_order", NULL};
    json_t *align = json_object_get(root, "align");
    if (!align || m->channels == MAPPING_CHANNELS)
        return;
    if (!json_is_object(align)) {
        wrong(r, "", "align", "give an object with column, threshold and switch");
        return;
    }
    struct mapping_channel *c = &m->channel[m->channels++];
    *c = (struct mapping_channel){
        .role = MAPPING_ALIGN, .scale = 1.0, .station_ft = (double)NAN, .error = (double)NAN};
    check_keys(r, "align", align, known);
    read_source(r, "align", align, m, c);
    read_edge(r, "align", align, c);
    c->number = whole(r, "align", align, "switch", SWITCH_MAX, 0);
    if (c->number == 0)
        wrong(r, "align", "switch", "give the number of the switch whose edge it is, from 1");
}

static void read_missing(const struct reader *r, json_t *root, struct mapping *m)
{
    json_t *words = json_object_get(root, "missing");
    if (!words)
        return;
    if (!json_is_array(words) || json_array_size(words) > MAPPING_WORDS) {
        wrong(r, "", "missing", "give a list of up to 16 words");
        return;
    }
    for (size_t i = 0; i < json_array_size(words); i++) {
        const char *word = json_string_value(json_array_get(words, i));
        if (!word || strlen(word) >= sizeof m->missing[0])
            wrong(r, "", "missing", "its words are strings of at most 15 characters");
        else
            snprintf(m->missing[m->missing_count++], sizeof m->missing[0], "%s", word);
    }
}

static void read_root(const struct reader *r, json_t *root, struct mapping *m)
{
    static const char *const known[] = {
        "separator",       "decimal", "header_lines", "comment",  "missing",
        "last_line_open",  "time",    "align",        "channels", "touchdown_ft",
        "switch_error_ft", "gap_s",   "note",         NULL};
    json_t *channels = json_object_get(root, "channels");
    char note[400] = "";
    if (!json_is_object(root) || !json_is_array(channels) || json_array_size(channels) == 0 ||
        json_array_size(channels) >= MAPPING_CHANNELS) {
        wrong(r, "", "channels", "give a list of one to 99 objects");
        return;
    }
    check_keys(r, "", root, known);
    text(r, "", root, "note", note, sizeof note);
    json_t *first = json_array_get(channels, 0);
    m->signals = json_object_get(first, "id");
    m->decimal = character(r, root, "decimal", '.');
    m->separator = character(r, root, "separator", m->decimal == ',' ? ';' : ',');
    m->comment = character(r, root, "comment", '#');
    if ((m->decimal != '.' && m->decimal != ',') || m->decimal == m->separator)
        wrong(r, "", "decimal", "give . or , and another separator");
    m->header_lines = whole(r, "", root, "header_lines", 1000, 1);
    m->last_line_open = yes(r, "", root, "last_line_open");
    m->touchdown_ft = number(r, "", root, "touchdown_ft", (double)NAN);
    m->switch_error_ft = number(r, "", root, "switch_error_ft", (double)NAN);
    m->gap_s = number(r, "", root, "gap_s", (double)NAN);
    read_missing(r, root, m);
    read_time(r, root, m);
    for (size_t i = 0; i < json_array_size(channels) && r->error->status == MR_OK; i++)
        read_channel(r, json_array_get(channels, i), i, m);
    if (r->error->status == MR_OK)
        read_align(r, root, m);
}

enum mr_status mapping_parse(const char *json, size_t length, const char *path,
                             struct mapping *mapping, struct error *error)
{
    json_error_t where;
    const struct reader r = {path, error};
    *mapping = (struct mapping){0};
    json_t *root = json_loadb(json, length, JSON_REJECT_DUPLICATES, &where);
    if (!root)
        return error_set(error, MR_MALFORMED, "no JSON: %s line %d, column %d: %s", path,
                         where.line, where.column, where.text);
    read_root(&r, root, mapping);
    mapping->text = json_dumps(root, JSON_COMPACT | JSON_SORT_KEYS);
    json_decref(root);
    return error->status;
}

enum mr_status mapping_load(const char *path, struct mapping *mapping, struct error *error)
{
    struct textfile file;
    *mapping = (struct mapping){0};
    enum mr_status status = textfile_open(path, &file, error);
    if (status == MR_OK)
        status = mapping_parse(file.text, file.length, path, mapping, error);
    textfile_close(&file);
    return status;
}

void mapping_free(struct mapping *mapping)
{
    for (size_t i = 0; i < mapping->channels; i++) {
        free(mapping->channel[i].series.time_s);
        free(mapping->channel[i].series.value);
    }
    free(mapping->text);
    *mapping = (struct mapping){0};
}
