#include "host/board/config_text.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "common/channels.h"
#include "common/decimal.h"
#include "common/gain.h"
#include "common/wire.h"
#include "host/base/output.h"
#include "host/base/xmalloc.h"
#include "host/calibrate/jump.h"

#define S_PER_DAY 86400
#define BLANKS    " \t\r"

/* ---- one field ---- */

static const struct mr_config_field *get_field_info(struct config_field_ref at)
{
    return &mr_config_groups[at.group].fields[at.field];
}

/* The bytes of the field in `config`. The caller may write to them if its `config` is not const. */
static void *get_field_bytes(const struct mr_config *config, struct config_field_ref at)
{
    const struct mr_config_group *group = &mr_config_groups[at.group];
    return (uint8_t *)(uintptr_t)config + group->offset + at.index * group->size +
           group->fields[at.field].offset;
}

/* Advances `*at` to the next field of the table; returns false at the end. Start with {0}. */
static bool advance_field(struct config_field_ref *at)
{
    if (++at->field < mr_config_groups[at->group].field_count)
        return true;
    at->field = 0;
    if (++at->index < mr_config_groups[at->group].count)
        return true;
    at->index = 0;
    return ++at->group < MR_CONFIG_GROUP_COUNT;
}

static void format_field_name(struct config_field_ref at, char out[CONFIG_FIELD_NAME_SIZE])
{
    const struct mr_config_group *group = &mr_config_groups[at.group];
    if (group->count == 1)
        snprintf(out, CONFIG_FIELD_NAME_SIZE, "%s.%s", group->name, get_field_info(at)->name);
    else
        snprintf(out, CONFIG_FIELD_NAME_SIZE, "%s[%u].%s", group->name, at.index + 1,
                 get_field_info(at)->name);
}

static bool is_date_field(const struct mr_config_field *field)
{
    size_t length = strlen(field->name);
    return length > 4 && strcmp(field->name + length - 4, "_day") == 0;
}

bool config_date_parse(const char *text, uint32_t *days)
{
    struct tm tm = {.tm_year = 0};
    char back[CONFIG_DATE_SIZE];
    const char *end = strptime(text, "%Y-%m-%d", &tm);
    if (!end || end - text != CONFIG_DATE_SIZE - 1)
        return false;
    int64_t day = (int64_t)timegm(&tm) / S_PER_DAY;
    *days = (uint32_t)day;
    if (day <= 0 || day > UINT32_MAX)
        return false;
    config_date_text(*days, back);
    return strncmp(text, back, sizeof back - 1) == 0;
}

void config_date_text(uint32_t days, char out[CONFIG_DATE_SIZE])
{
    time_t seconds = (time_t)days * S_PER_DAY;
    struct tm tm;
    gmtime_r(&seconds, &tm);
    if (strftime(out, CONFIG_DATE_SIZE, "%Y-%m-%d", &tm) == 0)
        out[0] = '\0';
}

static uint32_t get_integer(const struct mr_config_field *field, const void *bytes)
{
    uint8_t small;
    uint16_t half;
    uint32_t word;
    switch (field->type) {
    case MR_CONFIG_TYPE_u8: memcpy(&small, bytes, sizeof small); return small;
    case MR_CONFIG_TYPE_u16: memcpy(&half, bytes, sizeof half); return half;
    default: memcpy(&word, bytes, sizeof word); return word;
    }
}

static void write_date(uint32_t days, char *out, size_t size)
{
    char date[CONFIG_DATE_SIZE];
    config_date_text(days, date);
    snprintf(out, size, "%s", days ? date : "never");
}

static void write_text(const char *text, unsigned count, char *out, size_t size)
{
    size_t used = 0;
    out[used++] = '"';
    for (unsigned i = 0; i < count && text[i] && used + 4 < size; i++) {
        if (text[i] == '"' || text[i] == '\\')
            out[used++] = '\\';
        out[used++] = text[i];
    }
    out[used++] = '"';
    out[used] = '\0';
}

/* Writes floats with nine digits, which represent a float exactly. */
static void write_reals(const float *values, unsigned count, char *out, size_t size)
{
    size_t used = 0;
    for (unsigned i = 0; i < count && used < size; i++) {
        if (isnan(values[i]))
            used += (size_t)snprintf(out + used, size - used, "%smissing", i ? " " : "");
        else
            used += (size_t)snprintf(out + used, size - used, "%s%.9g", i ? " " : "",
                                     (double)values[i]);
    }
}

static void format_field_value(const struct mr_config_field *field, const void *bytes,
                               char out[CONFIG_FIELD_VALUE_SIZE])
{
    if (field->type == MR_CONFIG_TYPE_TEXT)
        write_text(bytes, field->count, out, CONFIG_FIELD_VALUE_SIZE);
    else if (field->type == MR_CONFIG_TYPE_REAL || field->type == MR_CONFIG_TYPE_OPTIONAL)
        write_reals(bytes, field->count, out, CONFIG_FIELD_VALUE_SIZE);
    else if (is_date_field(field))
        write_date(get_integer(field, bytes), out, CONFIG_FIELD_VALUE_SIZE);
    else
        snprintf(out, CONFIG_FIELD_VALUE_SIZE, "%u", get_integer(field, bytes));
}

/* Writes the limits of a field, for example "1 to 512". */
static void write_field_limits(const struct mr_config_field *field, char *out, size_t size)
{
    if (field->type == MR_CONFIG_TYPE_TEXT) {
        snprintf(out, size, "at most %u printable characters in double quotes", field->count);
    } else if (field->type == MR_CONFIG_TYPE_REAL || field->type == MR_CONFIG_TYPE_OPTIONAL) {
        char many[40] = "";
        if (field->count > 1)
            snprintf(many, sizeof many, "%u numbers, each ", field->count);
        snprintf(out, size, "%s%.7g to %.7g%s", many, (double)field->real_min,
                 (double)field->real_max,
                 field->type == MR_CONFIG_TYPE_OPTIONAL ? ", or missing" : "");
    } else if (is_date_field(field)) {
        char last[20];
        write_date(field->int_max, last, sizeof last);
        snprintf(out, size, "YYYY-MM-DD up to %s, or never", last);
    } else {
        snprintf(out, size, "%u to %u", field->int_min, field->int_max);
    }
}

/* ---- why a configuration is refused ---- */

static void write_element_name(struct config_field_ref at, unsigned element,
                               char out[CONFIG_FIELD_NAME_SIZE + 40])
{
    char name[CONFIG_FIELD_NAME_SIZE];
    format_field_name(at, name);
    if (get_field_info(at)->count > 1 && get_field_info(at)->type != MR_CONFIG_TYPE_TEXT)
        snprintf(out, CONFIG_FIELD_NAME_SIZE + 40, "value %u of %s", element + 1, name);
    else
        snprintf(out, CONFIG_FIELD_NAME_SIZE + 40, "%s", name);
}

static const char *get_rule_text(unsigned rule)
{
    switch (rule) {
/* clang-format off */
#define RULE_CASE(NAME, number, text) case number: return text;
        /* clang-format on */
        MR_CONFIG_RULE_TABLE(RULE_CASE)
#undef RULE_CASE
    default: return "unknown rule";
    }
}

static bool is_reason_field_known(const struct mr_config_violation *r)
{
    return r->group < MR_CONFIG_GROUP_COUNT && r->index < mr_config_groups[r->group].count &&
           r->field < mr_config_groups[r->group].field_count;
}

/* Finds the field with which the refused field conflicts. */
static bool find_conflicting_field(const struct mr_config_violation *r,
                                   struct config_field_ref *other)
{
    *other = (struct config_field_ref){r->group, r->index, r->field};
    if (r->rule == MR_RULE_NOT_ABOVE)
        other->field = r->other;
    else if (r->rule == MR_RULE_STEPS_TOO_CLOSE || r->rule == MR_RULE_NUMBER_IN_USE)
        other->index = r->other;
    else if (r->rule == MR_RULE_NOT_RISING && get_field_info(*other)->count == 1)
        other->index = r->other;
    else
        return false;
    return other->index < mr_config_groups[other->group].count &&
           other->field < mr_config_groups[other->group].field_count;
}

static const char *const allowed_kinds_text =
    "set the kind of channel[1] to [8] to 1 (displacement), of [9] to [22] to 2 (tension), of [23] "
    "to 3 (staircase; 0 if no switch is fitted), of [24] to 4 (reference), or to 0 if the channel "
    "is not fitted";

/* Explains why a gain is impossible, with the numbers and the probable mistake. */
static void write_gain_advice(const struct mr_channel_config *channel, unsigned rule, char *out,
                              size_t size)
{
    const char *unit = channel->kind == MR_KIND_DISPLACEMENT ? "in" : "lb";
    const struct mr_gain_limits limits = mr_gain_limits(channel);
    char mistake[80];
    jump_write_mistake_hint(channel, mistake, sizeof mistake);
    if (rule == MR_RULE_RANGE_TOO_NARROW)
        snprintf(
            out, size,
            "the range low to high, %g to %g %s, covers %.0f codes, but must cover at least %.0f%s",
            (double)channel->low, (double)channel->high, unit,
            (double)mr_channel_range_codes(channel), (double)MR_RANGE_MIN_CODES, mistake);
    else if (rule == MR_RULE_RANGE_UNREACHABLE)
        snprintf(out, size,
                 "only %.0f %% of the range low to high, %g to %g %s, is within the converter "
                 "range, but at least %.0f %% must be%s",
                 100.0 * (double)mr_channel_range_share(channel), (double)channel->low,
                 (double)channel->high, unit, 100.0 * (double)MR_RANGE_MIN_SHARE, mistake);
    else
        snprintf(out, size, "the gain of a %s must be %.3g to %.3g %s per code%s",
                 channel->kind == MR_KIND_DISPLACEMENT ? "transducer" : "gage",
                 (double)limits.min_gain, (double)limits.max_gain, unit, mistake);
}

static void write_advice(const struct mr_config *config, const struct mr_config_violation *r,
                         char *out, size_t size)
{
    struct config_field_ref at = {r->group, r->index, r->field};
    char limits[200];
    write_field_limits(get_field_info(at), limits, sizeof limits);
    switch (r->rule) {
    case MR_RULE_TOO_SMALL:
        if (r->group == MR_GROUP_gate && r->field == MR_FIELD_gate_step_codes) {
            snprintf(out, size,
                     "give a step of %u codes or more, or 0 for a switch that is not fitted",
                     MR_CONFIG_STEP_MIN_CODES);
            break;
        }
        snprintf(out, size, "give %s", limits);
        break;
    case MR_RULE_TOO_LARGE:
    case MR_RULE_NOT_A_NUMBER:
    case MR_RULE_NOT_TEXT: snprintf(out, size, "give %s", limits); break;
    case MR_RULE_STEPS_TOO_CLOSE:
        snprintf(out, size, "give steps that differ by %u codes or more",
                 MR_CONFIG_STEP_DISTANCE_MIN_CODES);
        break;
    case MR_RULE_WRONG_INPUT: snprintf(out, size, "%s", allowed_kinds_text); break;
    case MR_RULE_SUM_TOO_LARGE:
        snprintf(out, size,
                 "the sum of zero_code of channel[23] and all steps must be at most 4095");
        break;
    case MR_RULE_NO_BAND:
        snprintf(
            out, size,
            "set pretension_lb of that band above 0, or give the gage a different band (0: none)");
        break;
    case MR_RULE_UNSTABLE:
        snprintf(out, size,
                 "use a shorter step_ms, or check the units of predict.mat_weight_lb and "
                 "predict.joint_stiffness_lb_ft");
        break;
    case MR_RULE_CODE_TOO_COARSE:
    case MR_RULE_CODE_TOO_FINE:
    case MR_RULE_RANGE_TOO_NARROW:
    case MR_RULE_RANGE_UNREACHABLE:
        write_gain_advice(&config->channel[r->index], r->rule, out, size);
        break;
    case MR_RULE_REVISION:
        snprintf(out, size, "read the configuration again and edit that version");
        break;
    default: snprintf(out, size, "correct it"); break;
    }
}

void config_text_reason(const struct mr_config *config, const struct mr_config_violation *r,
                        char *out, size_t size)
{
    struct config_field_ref at = {r->group, r->index, r->field}, other;
    char name[CONFIG_FIELD_NAME_SIZE + 40], value[CONFIG_FIELD_VALUE_SIZE], advice[300];
    if (!is_reason_field_known(r)) {
        snprintf(out, size,
                 "group %u, index %u, field %u: %s; the configuration is from a different version",
                 r->group, r->index, r->field, get_rule_text(r->rule));
        return;
    }
    write_element_name(at, r->element, name);
    format_field_value(get_field_info(at), get_field_bytes(config, at), value);
    write_advice(config, r, advice, sizeof advice);
    if (find_conflicting_field(r, &other)) {
        char other_name[CONFIG_FIELD_NAME_SIZE], other_value[CONFIG_FIELD_VALUE_SIZE];
        format_field_name(other, other_name);
        format_field_value(get_field_info(other), get_field_bytes(config, other), other_value);
        snprintf(out, size, "%s is %s, %s is %s: %s; %s", name, value, other_name, other_value,
                 r->rule == MR_RULE_NUMBER_IN_USE ? "two channels of one kind have the same number"
                 : r->rule == MR_RULE_STEPS_TOO_CLOSE
                     ? "the board cannot distinguish these switches"
                     : "the first value must be larger",
                 advice);
    } else {
        snprintf(out, size, "%s is %s: %s; %s", name, value, get_rule_text(r->rule), advice);
    }
}

/* ---- the text ---- */

#define FILE_BYTES_MAX (1024 * 1024)

struct field_text {
    const char *unit, *text;
};

/* clang-format off */
#define GROUP(name, count) static const struct field_text name##_texts[] = {
#define INTEGER(group, type, field, least, most, unit, text) {unit, text},
#define REAL(group, field, least, most, unit, text) {unit, text},
#define REALS(group, field, count, least, most, unit, text) {unit, text},
#define TEXT(group, field, size, text) {"", text},
#define END_GROUP(name) };
/* clang-format on */
#include "common/config.def"

static const struct field_text *const field_texts[] = {
#define GROUP(name, count) name##_texts,
#include "common/config.def"
};

static void write_legend(FILE *file, unsigned group)
{
    fprintf(file, "\n# %s\n", mr_config_groups[group].name);
    for (unsigned f = 0; f < mr_config_groups[group].field_count; f++) {
        const struct field_text *w = &field_texts[group][f];
        const struct mr_config_field *field = &mr_config_groups[group].fields[f];
        bool day = is_date_field(field);
        /* The text has dates as YYYY-MM-DD, the configuration as numbers of days since
         * 1970-01-01. */
        if (day)
            fprintf(file, "#     %-18s YYYY-MM-DD or never: %.*s\n", field->name,
                    (int)strcspn(w->text, ",;"), w->text);
        else
            fprintf(file, "#     %-18s %s%s%s\n", field->name, w->unit, w->unit[0] ? ": " : "",
                    w->text);
    }
}

char *config_text_write(const struct mr_config *config)
{
    char *text = NULL;
    size_t size;
    FILE *file = xopen_memstream(&text, &size);
    struct config_field_ref at = {0};
    fputs("# matrig configuration. One field per line, each exactly once. To check the file: "
          "matrig board config check FILE\n",
          file);
    do {
        char name[CONFIG_FIELD_NAME_SIZE], value[CONFIG_FIELD_VALUE_SIZE];
        const char *unit = field_texts[at.group][at.field].unit;
        if (at.index == 0 && at.field == 0)
            write_legend(file, at.group);
        if (at.field == 0)
            fputc('\n', file);
        format_field_name(at, name);
        format_field_value(get_field_info(at), get_field_bytes(config, at), value);
        fprintf(file, "%s = %s%s%s\n", name, value,
                unit[0] && !is_date_field(get_field_info(at)) ? "  # " : "",
                is_date_field(get_field_info(at)) ? "" : unit);
    } while (advance_field(&at));
    if (fclose(file) != 0)
        abort();
    return text;
}

/* ---- reading ---- */

struct reader {
    const char *name; /* file name */
    unsigned line;
    struct mr_config *config;
    /* line number of each field, in the order of the table; 0: not read yet */
    unsigned *field_line_numbers;
    struct error *error;
};

static size_t get_field_index(struct config_field_ref at)
{
    size_t number = 0;
    for (unsigned g = 0; g < at.group; g++)
        number += (size_t)mr_config_groups[g].count * mr_config_groups[g].field_count;
    return number + (size_t)at.index * mr_config_groups[at.group].field_count + at.field;
}

static enum mr_status refuse_text(const struct reader *r, enum mr_status status, const char *what,
                                  const char *advice)
{
    return error_set(r->error, status, "%s: %s:%u; %s", what, r->name, r->line, advice);
}

static void skip_blanks(const char **p)
{
    while (**p == ' ' || **p == '\t' || **p == '\r')
        ++*p;
}

static bool is_line_end(const char *p)
{
    skip_blanks(&p);
    return !*p || *p == '#';
}

/* Reads `group[index].field` and the `=` after it. */
static enum mr_status read_name(const struct reader *r, const char **p, struct config_field_ref *at)
{
    char group[32] = "", field[48] = "", what[160];
    unsigned index = 0;
    int used = 0;
    const char *rest = *p;
    bool bracket =
        sscanf(rest, "%31[a-z_][%9u].%47[a-z_0-9]%n", group, &index, field, &used) == 3 && used;
    if (!bracket && (sscanf(rest, "%31[a-z_].%47[a-z_0-9]%n", group, field, &used) != 2 || !used)) {
        snprintf(what, sizeof what, "not a field: `%.60s`", rest);
        return refuse_text(r, MR_MALFORMED, what,
                           "write group[index].field = value, or begin the line with #");
    }
    *at = (struct config_field_ref){0};
    while (at->group < MR_CONFIG_GROUP_COUNT &&
           strcmp(mr_config_groups[at->group].name, group) != 0)
        at->group++;
    if (at->group == MR_CONFIG_GROUP_COUNT) {
        snprintf(what, sizeof what, "no such group: `%s`", group);
        return refuse_text(r, MR_UNKNOWN, what,
                           "use the group site, channel, gate, band or predict");
    }
    const struct mr_config_group *found = &mr_config_groups[at->group];
    if (bracket ? index < 1 || index > found->count : found->count != 1) {
        char advice[100];
        snprintf(advice, sizeof advice, "use %s[1] to %s[%u]", group, group, found->count);
        snprintf(what, sizeof what, bracket ? "no such %s: %u" : "%s has no number in brackets",
                 group, index);
        return refuse_text(r, MR_UNKNOWN, what, advice);
    }
    at->index = bracket ? index - 1 : 0;
    while (at->field < found->field_count && strcmp(found->fields[at->field].name, field) != 0)
        at->field++;
    if (at->field == found->field_count) {
        snprintf(what, sizeof what, "%s has no field `%s`", group, field);
        return refuse_text(r, MR_UNKNOWN, what, "use a field from the comment above the group");
    }
    *p = rest + used;
    skip_blanks(p);
    if (**p != '=') {
        snprintf(what, sizeof what, "no `=` follows the field: `%.60s`", rest);
        return refuse_text(r, MR_MALFORMED, what, "write group[index].field = value");
    }
    ++*p;
    skip_blanks(p);
    return MR_OK;
}

static bool read_text(const struct mr_config_field *field, const char *p, char *out)
{
    unsigned length = 0;
    memset(out, 0, field->count);
    if (*p++ != '"')
        return false;
    for (; *p && *p != '"'; p++) {
        if (*p == '\\' && (p[1] == '"' || p[1] == '\\'))
            p++;
        if (length == field->count || *p < ' ' || *p > '~')
            return false;
        out[length++] = *p;
    }
    return *p == '"' && is_line_end(p + 1);
}

static bool read_reals(const struct mr_config_field *field, const char *p, void *bytes)
{
    float values[256];
    for (unsigned i = 0; i < field->count; i++) {
        const char *end = p;
        skip_blanks(&p);
        if (strncmp(p, "missing", 7) == 0) {
            values[i] = MR_NAN;
            end = p + 7;
        } else {
            (void)mr_decimal_parse(p, &end);
            values[i] = strtof(p, NULL);
        }
        if (end == p || (*end && !strchr(BLANKS "#", *end)))
            return false;
        p = end;
    }
    memcpy(bytes, values, field->count * sizeof values[0]);
    return is_line_end(p);
}

static bool read_date(const char *p, uint64_t *days)
{
    uint32_t day;
    *days = 0;
    if (strncmp(p, "never", 5) == 0)
        return is_line_end(p + 5);
    if (!config_date_parse(p, &day))
        return false;
    *days = day;
    return is_line_end(p + CONFIG_DATE_SIZE - 1);
}

static bool read_integer(const struct mr_config_field *field, const char *p, void *bytes)
{
    uint64_t value = 0;
    char *end;
    errno = 0;
    if (is_date_field(field)) {
        if (!read_date(p, &value))
            return false;
    } else {
        value = strtoull(p, &end, 10);
        if (!isdigit((unsigned char)*p) || errno || !is_line_end(end))
            return false;
    }
    if (value < field->int_min || value > field->int_max)
        return false;
    uint8_t small = (uint8_t)value;
    uint16_t half = (uint16_t)value;
    uint32_t word = (uint32_t)value;
    if (field->type == MR_CONFIG_TYPE_u8)
        memcpy(bytes, &small, sizeof small);
    else if (field->type == MR_CONFIG_TYPE_u16)
        memcpy(bytes, &half, sizeof half);
    else
        memcpy(bytes, &word, sizeof word);
    return true;
}

/* Reads the value of a field. Limits of reals are not checked here but by mr_config_check. */
static bool read_value(const struct mr_config_field *field, const char *p, void *bytes)
{
    if (field->type == MR_CONFIG_TYPE_TEXT)
        return read_text(field, p, bytes);
    if (field->type == MR_CONFIG_TYPE_REAL || field->type == MR_CONFIG_TYPE_OPTIONAL)
        return read_reals(field, p, bytes);
    return read_integer(field, p, bytes);
}

static enum mr_status read_line(struct reader *r, const char *p)
{
    struct config_field_ref at;
    char name[CONFIG_FIELD_NAME_SIZE], what[240], advice[300];
    skip_blanks(&p);
    if (!*p || *p == '#')
        return MR_OK;
    enum mr_status status = read_name(r, &p, &at);
    if (status != MR_OK)
        return status;
    format_field_name(at, name);
    unsigned *line = &r->field_line_numbers[get_field_index(at)];
    if (*line) {
        snprintf(what, sizeof what, "%s is given twice", name);
        snprintf(advice, sizeof advice, "line %u also sets this field; delete one of the two lines",
                 *line);
        return refuse_text(r, MR_MALFORMED, what, advice);
    }
    *line = r->line;
    if (!read_value(get_field_info(at), p, get_field_bytes(r->config, at))) {
        char limits[200];
        int length = (int)strcspn(p, "#\r");
        while (length > 0 && p[length - 1] == ' ')
            length--;
        write_field_limits(get_field_info(at), limits, sizeof limits);
        snprintf(what, sizeof what, "%s cannot be `%.*s`", name, length, p);
        snprintf(advice, sizeof advice, "give %s", limits);
        return refuse_text(r, MR_MALFORMED, what, advice);
    }
    return MR_OK;
}

/* True for the fields of brake and wheel, which older configurations lack: these parts are then not
 * fitted. */
static bool is_field_optional(struct config_field_ref at)
{
    return at.group == MR_GROUP_site && at.field >= MR_FIELD_site_brake_edge;
}

static enum mr_status check_fields(struct reader *r)
{
    struct mr_config_violation reason;
    struct config_field_ref at = {0};
    size_t number = 0;
    do {
        if (!r->field_line_numbers[number++] && !is_field_optional(at)) {
            char name[CONFIG_FIELD_NAME_SIZE];
            format_field_name(at, name);
            return error_set(
                r->error, MR_MALFORMED,
                "field %s is missing: %s; give every field that matrig board config get writes",
                name, r->name);
        }
    } while (advance_field(&at));
    if (mr_config_check(r->config, &reason) == MR_OK)
        return MR_OK;
    char text[500];
    config_text_reason(r->config, &reason, text, sizeof text);
    char *advice = strstr(text, "; ");
    r->line = r->field_line_numbers[get_field_index(
        (struct config_field_ref){reason.group, reason.index, reason.field})];
    if (advice)
        *advice = '\0';
    return refuse_text(r, MR_LIMIT, text, advice ? advice + 2 : "correct it");
}

enum mr_status config_text_read(const char *text, const char *name, struct mr_config *config,
                                struct error *error)
{
    struct config_field_ref end = {.group = MR_CONFIG_GROUP_COUNT - 1,
                                   .index = mr_config_groups[MR_CONFIG_GROUP_COUNT - 1].count};
    static struct mr_config read;
    struct reader reader = {.name = name, .config = &read, .error = error};
    enum mr_status status = MR_OK;
    memset(&read, 0, sizeof read);
    reader.field_line_numbers = xcalloc(get_field_index(end), sizeof *reader.field_line_numbers);
    while (status == MR_OK && *text) {
        size_t length = strcspn(text, "\n");
        char *line = strndup(text, length);
        if (!line)
            abort();
        reader.line++;
        status = read_line(&reader, line);
        free(line);
        text += length + (text[length] != '\0');
    }
    if (status == MR_OK)
        status = check_fields(&reader);
    if (status == MR_OK)
        *config = read;
    free(reader.field_line_numbers);
    return status;
}

enum mr_status config_text_load(const char *path, struct mr_config *config, struct error *error)
{
    FILE *file = fopen(path, "rb");
    char *text = xcalloc(1, FILE_BYTES_MAX + 1);
    size_t length = file ? fread(text, 1, FILE_BYTES_MAX, file) : 0;
    bool failed = !file || ferror(file);
    int why = errno;
    if (file)
        fclose(file);
    enum mr_status status = MR_OK;
    if (failed)
        status =
            error_set(error, MR_IO,
                      "cannot be read (%s): %s; matrig board config get -o FILE writes such a file",
                      strerror(why), path);
    else if (strlen(text) != length || length == FILE_BYTES_MAX)
        status = error_set(error, MR_MALFORMED,
                           "not a text file: %s; give a file that matrig board config get wrote",
                           path);
    else
        status = config_text_read(text + utf8_bom_length(text, length), path, config, error);
    free(text);
    return status;
}

unsigned config_text_compare(const struct mr_config *old, const struct mr_config *new,
                             void (*each)(void *context, const char *field, const char *old,
                                          const char *new),
                             void *context)
{
    struct config_field_ref at = {0};
    unsigned differ = 0;
    do {
        char name[CONFIG_FIELD_NAME_SIZE], was[CONFIG_FIELD_VALUE_SIZE],
            is[CONFIG_FIELD_VALUE_SIZE];
        format_field_value(get_field_info(at), get_field_bytes(old, at), was);
        format_field_value(get_field_info(at), get_field_bytes(new, at), is);
        if (strcmp(was, is) == 0)
            continue;
        format_field_name(at, name);
        differ++;
        each(context, name, was, is);
    } while (advance_field(&at));
    return differ;
}

uint32_t config_text_undated_channels(const struct mr_config *config)
{
    uint32_t undated = 0;
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++)
        if (mr_channel_is_sensor(&config->channel[i]) && !config->channel[i].calibrated_day)
            undated |= 1u << i;
    return undated;
}
