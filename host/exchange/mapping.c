#include "host/exchange/mapping.h"

#include <ctype.h>
#include <jansson.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/channels.h"
#include "host/base/output.h"
#include "host/base/xmalloc.h"
#include "host/base/quantity.h"

#define SWITCH_NUMBER_MAX 64u

void series_add_sample(struct series *series, double time_s, double value)
{
    xlist_grow(&series->time_s, series->count, sizeof *series->time_s);
    xlist_grow(&series->value, series->count, sizeof *series->value);
    series->time_s[series->count] = time_s;
    series->value[series->count++] = value;
}

double mapping_convert_value(const struct mapping_channel *channel, double read)
{
    return read * channel->scale + channel->offset;
}

/* ---- signals of a frame ---- */

/* Returns the position in the frame of bit n of a signal, counted from its lowest bit. Big-endian
 * signals start at their highest bit and continue at bit 7 of the next byte. */
static unsigned find_bit_position(const struct import_signal *signal, unsigned n)
{
    if (!signal->is_big_endian)
        return signal->start_bit + n;
    unsigned from_top = signal->bit_count - 1 - n;
    unsigned in_order = (signal->start_bit / 8) * 8 + (7 - signal->start_bit % 8) + from_top;
    return (in_order / 8) * 8 + (7 - in_order % 8);
}

bool signal_fits_frame(const struct import_signal *signal, unsigned length)
{
    if (signal->bit_count == 0 || signal->bit_count > 64 || signal->start_bit > 63 ||
        (signal->is_float && signal->bit_count != 32 && signal->bit_count != 64))
        return false;
    return signal->is_big_endian
             ? (signal->start_bit / 8) * 8 + (7 - signal->start_bit % 8) + signal->bit_count <=
                   8 * length
             : signal->start_bit + signal->bit_count <= 8 * length;
}

bool signal_extract_value(const struct import_signal *signal, const struct link_frame *frame,
                          double *value)
{
    uint64_t raw = 0;
    if (frame->id != signal->id || !signal_fits_frame(signal, frame->length))
        return false;
    for (unsigned n = 0; n < signal->bit_count; n++) {
        unsigned bit = find_bit_position(signal, n);
        raw |= (uint64_t)(frame->data[bit / 8] >> (bit % 8) & 1u) << n;
    }
    if (signal->is_float && signal->bit_count == 32) {
        float single;
        uint32_t low = (uint32_t)raw;
        memcpy(&single, &low, sizeof single);
        *value = (double)single;
    } else if (signal->is_float) {
        memcpy(value, &raw, sizeof *value);
    } else if (signal->is_signed && raw >> (signal->bit_count - 1) & 1u) {
        if (signal->bit_count < 64)
            raw |= ~0ull << signal->bit_count;
        *value = (double)(int64_t)raw;
    } else {
        *value = (double)raw;
    }
    return isfinite(*value);
}

/* ---- names ---- */

static bool parse_number_suffix(const char *text, size_t letters, unsigned most, unsigned *number)
{
    char *end;
    if (!isdigit((unsigned char)text[letters]))
        return false;
    unsigned long value = strtoul(text + letters, &end, 10);
    *number = (unsigned)value;
    return *end == '\0' && value >= 1 && value <= most;
}

/* Parses a channel name ("d3", "t14", "gear", "switch7"). Returns false for other names. */
static bool parse_channel_name(const char *text, struct mapping_channel *channel)
{
    if (strcmp(text, "gear") == 0) {
        channel->role = MAPPING_GEAR;
        return true;
    }
    channel->role = text[0] == 'd' ? MAPPING_DISPLACEMENT
                  : text[0] == 't' ? MAPPING_TENSION
                                   : MAPPING_SWITCH;
    if (text[0] == 'd' || text[0] == 't')
        return parse_number_suffix(text, 1, text[0] == 'd' ? MR_TRANSDUCERS : MR_GAGES,
                                   &channel->number);
    return strncmp(text, "switch", 6) == 0 &&
           parse_number_suffix(text, 6, SWITCH_NUMBER_MAX, &channel->number);
}

/* Returns the factor from `unit` to the unit of the role; 0: not a unit of this kind. */
static double get_role_unit_factor(enum mapping_role role, const char *unit)
{
    const char *own = role == MAPPING_TENSION ? "lb" : role == MAPPING_GEAR ? "ft" : "in";
    double factor = *unit ? quantity_convert(1.0, unit, own) : (double)NAN;
    return isnan(factor) ? 0.0 : factor;
}

/* ---- JSON ---- */

struct mapping_reader {
    const char *path;
    struct error *error;
};

static void refuse_value(const struct mapping_reader *r, const char *where, const char *key,
                         const char *wanted)
{
    error_set(r->error, MR_MALFORMED, "%s%s%s: %s; %s", where, where[0] ? "." : "", key, r->path,
              wanted);
}

/* Like json_unpack, but refuses unknown keys. Absent keys keep their value. */
static void unpack_object(const struct mapping_reader *r, const char *where, json_t *object,
                          const char *format, ...)
{
    json_error_t error;
    va_list arguments;
    va_start(arguments, format);
    if (json_vunpack_ex(object, &error, JSON_STRICT, format, arguments) != 0)
        error_set(r->error, MR_MALFORMED, "%s: %s in %s; see matrig import --help", where,
                  error.text, r->path);
    va_end(arguments);
}

/* Reads a number. `unit`: unit of a number without one; a text has its own unit. */
static double read_number(const struct mapping_reader *r, const char *where, const char *key,
                          json_t *value, const char *unit, double otherwise)
{
    struct quantity_error wrongly;
    double v = otherwise;
    if (value && !quantity_read_json(value, unit, &v, &wrongly))
        refuse_value(r, where, key, wrongly.advice);
    else if (value && (!isfinite(v) || fabs(v) > 1e12))
        refuse_value(r, where, key, "give a number");
    return v;
}

static char read_character(const struct mapping_reader *r, const char *key, const char *text)
{
    bool none = strcmp(key, "comment") == 0 && !text[0];
    if (!none && (strlen(text) != 1 || text[0] == '"' || text[0] == '\n'))
        refuse_value(r, "", key, "give one character");
    return text[0];
}

/* Reads a column, given by its name or by its number from 1. */
static void read_column(const struct mapping_reader *r, const char *where, json_t *value,
                        char name[MAPPING_NAME_SIZE], unsigned *place)
{
    const char *text = json_string_value(value);
    json_int_t counted = json_integer_value(value);
    if (text && text[0] && strlen(text) < MAPPING_NAME_SIZE)
        strcpy(name, text);
    else if (counted >= 1 && counted <= 10000)
        *place = (unsigned)counted;
    else
        refuse_value(r, where, "column", "give the column's name, or its number from 1");
}

static void read_time(const struct mapping_reader *r, json_t *time, struct mapping *m)
{
    const char *unit = "s";
    json_t *column = NULL, *shift = NULL;
    if (time || !m->reads_signals)
        unpack_object(r, "time", time, "{s?o, s?s, s?o}", "column", &column, "unit", &unit,
                      "shift_s", &shift);
    if (!m->reads_signals)
        read_column(r, "time", column, m->time_column, &m->time_column_index);
    else if (column)
        refuse_value(r, "time", "column", "leave this key out, because the log contains the times");
    m->time_unit_s = *unit ? quantity_convert(1.0, unit, "s") : (double)NAN;
    if (isnan(m->time_unit_s))
        refuse_value(r, "time", "unit", "give s, ms, us or min");
    m->time_shift_s = read_number(r, "time", "shift_s", shift, "s", 0.0);
}

static void read_id(const struct mapping_reader *r, const char *where, const char *id,
                    struct import_signal *signal)
{
    char *end = NULL;
    unsigned long value = strtoul(id, &end, 16);
    /* 8 digits, as in 0x00000321, mark an extended identifier; 0x321 is a standard one */
    bool wide = strlen(id) > 5;
    if (strncmp(id, "0x", 2) != 0 || *end || value > (wide ? 0x1fffffffUL : 0x7ffUL))
        refuse_value(r, where, "id", "give the identifier as 0x and 3 or 8 hexadecimal digits");
    signal->id = (uint32_t)value | (wide ? LINK_ID_EXTENDED : 0);
}

static void check_channel(const struct mapping_reader *r, const char *where,
                          const struct mapping *m)
{
    const struct mapping_channel *c = &m->channel[m->channel_count - 1];
    for (size_t i = 0; i + 1 < m->channel_count; i++) {
        if (m->channel[i].role == c->role && m->channel[i].number == c->number)
            refuse_value(r, where, "channel", "give this channel only once");
    }
    if (c->scale == 0.0)
        refuse_value(r, where, "scale",
                     "give a different scale, because a scale of 0 makes all readings 0");
    if (c->standard_error < 0.0)
        refuse_value(r, where, "error", "give a standard error of 0 or more");
    if (m->reads_signals && !signal_fits_frame(&c->signal, 8))
        refuse_value(r, where, "bits", "give start_bit and bits within 8 bytes");
    if ((c->role == MAPPING_ALIGN || c->role == MAPPING_SWITCH) && isnan(c->threshold))
        refuse_value(r, where, "threshold", "give the value that the signal crosses at the edge");
}

/* Reads an entry of `channels`, or `align`. */
static void read_channel(const struct mapping_reader *r, const char *where, json_t *object,
                         bool align, struct mapping *m)
{
    const char *name = "", *unit = "", *edge = "rising", *id = "", *order = "little";
    json_t *column = NULL, *scale = NULL, *offset = NULL, *error = NULL, *threshold = NULL,
           *station = NULL;
    int start_bit = 0, bits = 0, is_signed = 0, is_float = 0, at_switch = 0;
    struct mapping_channel *c = &m->channel[m->channel_count++];
    *c = (struct mapping_channel){.role = MAPPING_ALIGN};
    unpack_object(
        r, where, object,
        "{s?s, s?o, s?s, s?o, s?o, s?o, s?o, s?s, s?o, s?i, s?s, s?i, s?i, s?b, s?b, s?s}",
        "channel", &name, "column", &column, "unit", &unit, "scale", &scale, "offset", &offset,
        "error", &error, "threshold", &threshold, "edge", &edge, "station_ft", &station, "switch",
        &at_switch, "id", &id, "start_bit", &start_bit, "bits", &bits, "signed", &is_signed,
        "float", &is_float, "byte_order", &order);
    if (align && (at_switch < 1 || at_switch > (int)SWITCH_NUMBER_MAX))
        refuse_value(r, where, "switch", "give the number of the switch with this edge, from 1");
    c->number = (unsigned)at_switch;
    if (!align && !parse_channel_name(name, c))
        refuse_value(r, where, "channel", "give d1 to d8, t1 to t14, gear or switch1 to switch64");
    if (m->reads_signals)
        read_id(r, where, id, &c->signal);
    else
        read_column(r, where, column, c->column_name, &c->column_index);
    c->signal.start_bit = (unsigned)start_bit;
    c->signal.bit_count = (unsigned)bits;
    c->signal.is_signed = is_signed;
    c->signal.is_float = is_float;
    c->signal.is_big_endian = strcmp(order, "big") == 0;
    if (!c->signal.is_big_endian && strcmp(order, "little") != 0)
        refuse_value(r, where, "byte_order", "give little or big");
    double factor = c->role == MAPPING_SWITCH || align ? 1.0 : get_role_unit_factor(c->role, unit);
    if (factor == 0.0)
        refuse_value(r, where, "unit",
                     c->role == MAPPING_TENSION ? "give lb, N, kN or kip"
                                                : "give in, mm, cm, m or ft");
    c->scale = factor * read_number(r, where, "scale", scale, "", 1.0);
    c->offset = factor * read_number(r, where, "offset", offset, unit, 0.0);
    c->standard_error = factor * read_number(r, where, "error", error, unit, (double)NAN);
    c->threshold = read_number(r, where, "threshold", threshold, "", (double)NAN);
    c->is_falling_edge = strcmp(edge, "falling") == 0;
    if (!c->is_falling_edge && strcmp(edge, "rising") != 0)
        refuse_value(r, where, "edge", "give rising or falling");
    c->station_ft = read_number(r, where, "station_ft", station, "ft", (double)NAN);
    check_channel(r, where, m);
}

static void read_missing_words(const struct mapping_reader *r, json_t *words, struct mapping *m)
{
    if (words && (!json_is_array(words) || json_array_size(words) > MAPPING_MISSING_MAX))
        refuse_value(r, "", "missing", "give a list of up to 16 words");
    for (size_t i = 0; i < json_array_size(words) && i < MAPPING_MISSING_MAX; i++) {
        const char *word = json_string_value(json_array_get(words, i));
        if (!word || strlen(word) >= sizeof m->missing_words[0])
            refuse_value(r, "", "missing", "give strings of at most 15 characters");
        else
            strcpy(m->missing_words[m->missing_word_count++], word);
    }
}

static void read_root(const struct mapping_reader *r, json_t *root, struct mapping *m)
{
    const char *separator = "", *decimal = ".", *comment = "#", *note;
    json_t *missing = NULL, *time = NULL, *align = NULL, *channels = NULL, *touchdown = NULL,
           *switch_error = NULL, *gap = NULL;
    int header_lines = 1, last_line_open = 0;
    unpack_object(r, "the mapping", root,
                  "{s?s, s?s, s?i, s?s, s?o, s?b, s?o, s?o, so, s?o, s?o, s?o, s?s}", "separator",
                  &separator, "decimal", &decimal, "header_lines", &header_lines, "comment",
                  &comment, "missing", &missing, "last_line_open", &last_line_open, "time", &time,
                  "align", &align, "channels", &channels, "touchdown_ft", &touchdown,
                  "switch_error_ft", &switch_error, "gap_s", &gap, "note", &note);
    if (json_array_size(channels) == 0 || json_array_size(channels) >= MAPPING_CHANNELS_MAX) {
        refuse_value(r, "", "channels", "give a list of one to 99 objects");
        return;
    }
    m->reads_signals = json_object_get(json_array_get(channels, 0), "id");
    m->decimal_mark = read_character(r, "decimal", decimal);
    m->separator = read_character(r, "separator",
                                  separator[0]             ? separator
                                  : m->decimal_mark == ',' ? ";"
                                                           : ",");
    m->comment_char = read_character(r, "comment", comment);
    if ((m->decimal_mark != '.' && m->decimal_mark != ',') || m->decimal_mark == m->separator)
        refuse_value(r, "", "decimal", "give '.' or ',', but not the separator");
    if (header_lines < 0 || header_lines > 1000)
        refuse_value(r, "", "header_lines", "give 0 to 1000");
    m->header_lines = (unsigned)header_lines;
    m->may_lack_newline = last_line_open;
    m->touchdown_ft = read_number(r, "", "touchdown_ft", touchdown, "ft", (double)NAN);
    m->switch_error_ft = read_number(r, "", "switch_error_ft", switch_error, "ft", (double)NAN);
    m->gap_min_s = read_number(r, "", "gap_s", gap, "s", (double)NAN);
    read_missing_words(r, missing, m);
    read_time(r, time, m);
    for (size_t i = 0; i < json_array_size(channels) && r->error->status == MR_OK; i++) {
        char where[32];
        snprintf(where, sizeof where, "channels[%zu]", i);
        read_channel(r, where, json_array_get(channels, i), false, m);
    }
    if (align && r->error->status == MR_OK)
        read_channel(r, "align", align, true, m);
}

enum mr_status mapping_parse(const char *json, size_t length, const char *path,
                             struct mapping *mapping, struct error *error)
{
    json_error_t where;
    const struct mapping_reader r = {path, error};
    *mapping = (struct mapping){0};
    size_t mark = utf8_bom_length(json, length);
    json_t *root = json_loadb(json + mark, length - mark, JSON_REJECT_DUPLICATES, &where);
    if (!root)
        return error_set(error, MR_MALFORMED, "not valid JSON: %s line %d, column %d: %s", path,
                         where.line, where.column, where.text);
    read_root(&r, root, mapping);
    mapping->json_text = json_dumps(root, JSON_COMPACT | JSON_SORT_KEYS);
    json_decref(root);
    return error->status;
}

void mapping_free(struct mapping *mapping)
{
    for (size_t i = 0; i < mapping->channel_count; i++) {
        free(mapping->channel[i].series.time_s);
        free(mapping->channel[i].series.value);
    }
    free(mapping->json_text);
    *mapping = (struct mapping){0};
}
