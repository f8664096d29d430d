#include "host/board/configtext.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/wire.h"

#define NAME_MAX_LENGTH 80u
#define FILE_MAX (1024 * 1024)

struct words {
    const char *unit, *text;
};

#define GROUP(name, count) static const struct words name##_words[] = {
#define INTEGER(group, type, field, least, most, unit, text) {unit, text},
#define REAL(group, field, least, most, unit, text) {unit, text},
#define OPTIONAL REAL
#define REALS(group, field, count, least, most, unit, text) {unit, text},
#define TEXT(group, field, size, text) {"", text},
#define END(name) };
#include "common/config.def"
#undef GROUP
#undef INTEGER
#undef REAL
#undef OPTIONAL
#undef REALS
#undef TEXT
#undef END

static const struct words *const words[] = {
#define GROUP(name, count) name##_words,
#define INTEGER(group, type, field, least, most, unit, text)
#define REAL(group, field, least, most, unit, text)
#define OPTIONAL REAL
#define REALS(group, field, count, least, most, unit, text)
#define TEXT(group, field, size, text)
#define END(name)
#include "common/config.def"
#undef GROUP
#undef INTEGER
#undef REAL
#undef OPTIONAL
#undef REALS
#undef TEXT
#undef END
};

/* One field of one member. */
struct place {
    unsigned group, index, field;
};

static const struct mr_config_field *field_of(struct place at)
{
    return &mr_config_groups[at.group].fields[at.field];
}

static void *bytes_of(const struct mr_config *config, struct place at)
{
    const struct mr_config_group *group = &mr_config_groups[at.group];
    return (uint8_t *)(uintptr_t)config + group->offset + at.index * group->size + group->fields[at.field].offset;
}

/* The next one in the order of the table; false: that was the last. Begin with {0}. */
static bool next_place(struct place *at)
{
    if (++at->field < mr_config_groups[at->group].field_count)
        return true;
    at->field = 0;
    if (++at->index < mr_config_groups[at->group].count)
        return true;
    at->index = 0;
    return ++at->group < MR_CONFIG_GROUPS;
}

static void name_of(struct place at, char out[NAME_MAX_LENGTH])
{
    const struct mr_config_group *group = &mr_config_groups[at.group];
    if (group->count == 1)
        snprintf(out, NAME_MAX_LENGTH, "%s.%s", group->name, field_of(at)->name);
    else
        snprintf(out, NAME_MAX_LENGTH, "%s[%u].%s", group->name, at.index + 1, field_of(at)->name);
}

static bool is_day(const struct mr_config_field *field)
{
    size_t length = strlen(field->name);
    return length > 4 && strcmp(field->name + length - 4, "_day") == 0;
}

/* Days since 1970-01-01 of the Gregorian calendar and back: years begin in March, 400 of them have 146097 days. */
static int64_t day_of(int64_t year, unsigned month, unsigned day)
{
    int64_t y = year - (month <= 2);
    unsigned from_march = (month + 9) % 12;
    return 365 * y + y / 4 - y / 100 + y / 400 + (int64_t)((153 * from_march + 2) / 5 + day - 1) - 719468;
}

static void date_of(uint32_t days, unsigned *year, unsigned *month, unsigned *day)
{
    *year = 1970 + days / 366;
    while (day_of(*year + 1, 1, 1) <= (int64_t)days)
        ++*year;
    *month = 12;
    while (day_of(*year, *month, 1) > (int64_t)days)
        --*month;
    *day = (unsigned)((int64_t)days - day_of(*year, *month, 1)) + 1;
}

static uint32_t integer_at(const struct mr_config_field *field, const void *bytes)
{
    uint8_t small;
    uint16_t half;
    uint32_t word;
    switch (field->type) {
    case MR_CONFIG_TYPE_u8:
        memcpy(&small, bytes, sizeof small);
        return small;
    case MR_CONFIG_TYPE_u16:
        memcpy(&half, bytes, sizeof half);
        return half;
    default:
        memcpy(&word, bytes, sizeof word);
        return word;
    }
}

static void write_day(uint32_t days, char *out, size_t size)
{
    unsigned year, month, day;
    date_of(days, &year, &month, &day);
    if (days)
        snprintf(out, size, "%04u-%02u-%02u", year, month, day);
    else
        snprintf(out, size, "never");
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

/* Nine digits name a single exactly. */
static void write_reals(const float *values, unsigned count, char *out, size_t size)
{
    size_t used = 0;
    for (unsigned i = 0; i < count && used < size; i++) {
        if (isnan(values[i]))
            used += (size_t)snprintf(out + used, size - used, "%smissing", i ? " " : "");
        else
            used += (size_t)snprintf(out + used, size - used, "%s%.9g", i ? " " : "", (double)values[i]);
    }
}

static void write_value(const struct mr_config_field *field, const void *bytes, char out[CONFIGTEXT_VALUE])
{
    if (field->type == MR_CONFIG_TYPE_TEXT)
        write_text(bytes, field->count, out, CONFIGTEXT_VALUE);
    else if (field->type == MR_CONFIG_TYPE_REAL || field->type == MR_CONFIG_TYPE_OPTIONAL)
        write_reals(bytes, field->count, out, CONFIGTEXT_VALUE);
    else if (is_day(field))
        write_day(integer_at(field, bytes), out, CONFIGTEXT_VALUE);
    else
        snprintf(out, CONFIGTEXT_VALUE, "%u", integer_at(field, bytes));
}

static void write_legend(FILE *file, unsigned group)
{
    fprintf(file, "\n# %s\n", mr_config_groups[group].name);
    for (unsigned f = 0; f < mr_config_groups[group].field_count; f++) {
        const struct words *w = &words[group][f];
        const struct mr_config_field *field = &mr_config_groups[group].fields[f];
        bool day = is_day(field);
        if (day) /* as it is written here, not as it is stored */
            fprintf(file, "#     %-18s YYYY-MM-DD or never: %.*s\n", field->name, (int)strcspn(w->text, ",;"), w->text);
        else
            fprintf(file, "#     %-18s %s%s%s\n", field->name, w->unit, w->unit[0] ? ": " : "", w->text);
    }
}

char *configtext_write(const struct mr_config *config)
{
    char *text = NULL;
    size_t size;
    FILE *file = open_memstream(&text, &size);
    struct place at = {0};
    if (!file)
        abort();
    fputs("# matrig configuration. One field a line, each exactly once; matrig board config check FILE reads it.\n", file);
    do {
        char name[NAME_MAX_LENGTH], value[CONFIGTEXT_VALUE];
        const char *unit = words[at.group][at.field].unit;
        if (at.index == 0 && at.field == 0)
            write_legend(file, at.group);
        if (at.field == 0)
            fputc('\n', file);
        name_of(at, name);
        write_value(field_of(at), bytes_of(config, at), value);
        fprintf(file, "%s = %s%s%s\n", name, value, unit[0] && !is_day(field_of(at)) ? "  # " : "",
                is_day(field_of(at)) ? "" : unit);
    } while (next_place(&at));
    if (fclose(file) != 0)
        abort();
    return text;
}

/* --- what is wrong, in words --- */

static void write_limits(const struct mr_config_field *field, char *out, size_t size)
{
    if (field->type == MR_CONFIG_TYPE_TEXT) {
        snprintf(out, size, "at most %u printable characters in double quotes", field->count);
    } else if (field->type == MR_CONFIG_TYPE_REAL || field->type == MR_CONFIG_TYPE_OPTIONAL) {
        char many[40] = "";
        if (field->count > 1)
            snprintf(many, sizeof many, "%u numbers, each ", field->count);
        snprintf(out, size, "%sfrom %.7g to %.7g%s", many, (double)field->low, (double)field->high,
                 field->type == MR_CONFIG_TYPE_OPTIONAL ? ", or missing" : "");
    } else if (is_day(field)) {
        char last[20];
        write_day(field->most, last, sizeof last);
        snprintf(out, size, "YYYY-MM-DD up to %s, or never", last);
    } else {
        snprintf(out, size, "from %u to %u", field->least, field->most);
    }
}

static void name_element(struct place at, unsigned element, char out[NAME_MAX_LENGTH + 40])
{
    char name[NAME_MAX_LENGTH];
    name_of(at, name);
    if (field_of(at)->count > 1 && field_of(at)->type != MR_CONFIG_TYPE_TEXT)
        snprintf(out, NAME_MAX_LENGTH + 40, "value %u of %s", element + 1, name);
    else
        snprintf(out, NAME_MAX_LENGTH + 40, "%s", name);
}

static const char *rule_text(unsigned rule)
{
    switch (rule) {
#define RULE_CASE(NAME, number, text) case number: return text;
        MR_CONFIG_RULE_TABLE(RULE_CASE)
#undef RULE_CASE
    default: return "unknown rule";
    }
}

static bool is_known(const struct mr_config_reason *r)
{
    return r->group < MR_CONFIG_GROUPS && r->index < mr_config_groups[r->group].count &&
           r->field < mr_config_groups[r->group].field_count;
}

/* The other place that a reason speaks of, and its value. */
static bool find_other(const struct mr_config_reason *r, struct place *other)
{
    *other = (struct place){r->group, r->index, r->field};
    if (r->rule == MR_RULE_NOT_ABOVE)
        other->field = r->other;
    else if (r->rule == MR_RULE_ALIKE || r->rule == MR_RULE_TAKEN)
        other->index = r->other;
    else if (r->rule == MR_RULE_NOT_RISING && field_of(*other)->count == 1)
        other->index = r->other;
    else
        return false;
    return other->index < mr_config_groups[other->group].count && other->field < mr_config_groups[other->group].field_count;
}

static const char *const right_kinds = "channel[1] to [8] are displacement (1), [9] to [22] tension (2), [23] the staircase (3; 0 where no "
                                       "switch is fitted), [24] the reference (4); 0: not fitted";

static void write_advice(const struct mr_config_reason *r, char *out, size_t size)
{
    struct place at = {r->group, r->index, r->field};
    char limits[200];
    write_limits(field_of(at), limits, sizeof limits);
    switch (r->rule) {
    case MR_RULE_TOO_SMALL:
        if (r->group == MR_GROUP_gate && r->field == MR_FIELD_gate_step_codes) {
            snprintf(out, size, "a step is at least %u codes, or 0: not fitted", MR_CONFIG_STEP_CODES);
            break;
        }
        snprintf(out, size, "it is %s", limits);
        break;
    case MR_RULE_TOO_LARGE:
    case MR_RULE_NOT_A_NUMBER:
    case MR_RULE_NOT_TEXT:
        snprintf(out, size, "it is %s", limits);
        break;
    case MR_RULE_ALIKE:
        snprintf(out, size, "steps must be %u codes or more apart", MR_CONFIG_STEP_CODES);
        break;
    case MR_RULE_PLACE:
        snprintf(out, size, "%s", right_kinds);
        break;
    case MR_RULE_SUM:
        snprintf(out, size, "zero_code of channel[23] and all steps together are at most 4095");
        break;
    case MR_RULE_NO_BAND:
        snprintf(out, size, "give that band a pretension_lb, or the gage another band or 0");
        break;
    case MR_RULE_UNSTABLE:
        snprintf(out, size, "a shorter step_ms, or look at the units of predict.mat_weight_lb and predict.joint_stiffness_lb_ft");
        break;
    case MR_RULE_REVISION:
        snprintf(out, size, "read the configuration again and change that one");
        break;
    default:
        snprintf(out, size, "mend it");
        break;
    }
}

void configtext_reason(const struct mr_config *config, const struct mr_config_reason *r, char *out, size_t size)
{
    struct place at = {r->group, r->index, r->field}, other;
    char name[NAME_MAX_LENGTH + 40], value[CONFIGTEXT_VALUE], advice[300];
    if (!is_known(r)) {
        snprintf(out, size, "group %u, index %u, field %u: %s; of another version", r->group, r->index, r->field, rule_text(r->rule));
        return;
    }
    name_element(at, r->element, name);
    write_value(field_of(at), bytes_of(config, at), value);
    write_advice(r, advice, sizeof advice);
    if (find_other(r, &other)) {
        char other_name[NAME_MAX_LENGTH], other_value[CONFIGTEXT_VALUE];
        name_of(other, other_name);
        write_value(field_of(other), bytes_of(config, other), other_value);
        snprintf(out, size, "%s is %s, %s is %s: %s; %s", name, value, other_name, other_value,
                 r->rule == MR_RULE_TAKEN ? "numbers of one kind must differ"
                 : r->rule == MR_RULE_ALIKE ? "they cannot be told apart" : "it must be more", advice);
    } else {
        snprintf(out, size, "%s is %s: %s; %s", name, value, rule_text(r->rule), advice);
    }
}

/* --- reading --- */

struct reader {
    const char *name; /* of the file */
    unsigned line;
    struct mr_config *config;
    unsigned *line_of; /* each place, in the order of the table; 0: not read yet */
    struct error *error;
};

static size_t number_of(struct place at)
{
    size_t number = 0;
    for (unsigned g = 0; g < at.group; g++)
        number += (size_t)mr_config_groups[g].count * mr_config_groups[g].field_count;
    return number + (size_t)at.index * mr_config_groups[at.group].field_count + at.field;
}

static enum mr_status complain(const struct reader *r, enum mr_status status, const char *what, const char *advice)
{
    return error_set(r->error, status, "%s: %s:%u; %s", what, r->name, r->line, advice);
}

static void skip_blanks(const char **p)
{
    while (**p == ' ' || **p == '\t' || **p == '\r')
        ++*p;
}

static bool ends(const char *p)
{
    skip_blanks(&p);
    return !*p || *p == '#';
}

/* `group[index].field`, then `=`. */
static enum mr_status read_name(const struct reader *r, const char **p, struct place *at)
{
    char group[32] = "", field[48] = "", what[160];
    unsigned index = 0;
    int used = 0;
    const char *rest = *p;
    bool bracket = sscanf(rest, "%31[a-z_][%9u].%47[a-z_0-9]%n", group, &index, field, &used) == 3 && used;
    if (!bracket && (sscanf(rest, "%31[a-z_].%47[a-z_0-9]%n", group, field, &used) != 2 || !used)) {
        snprintf(what, sizeof what, "no field: `%.60s`", rest);
        return complain(r, MR_MALFORMED, what, "a line is group[index].field = value, or begins with #");
    }
    *at = (struct place){0};
    while (at->group < MR_CONFIG_GROUPS && strcmp(mr_config_groups[at->group].name, group) != 0)
        at->group++;
    if (at->group == MR_CONFIG_GROUPS) {
        snprintf(what, sizeof what, "no such group: `%s`", group);
        return complain(r, MR_UNKNOWN, what, "there are site, channel, gate, band and predict");
    }
    const struct mr_config_group *found = &mr_config_groups[at->group];
    if (bracket ? index < 1 || index > found->count : found->count != 1) {
        char advice[80];
        snprintf(advice, sizeof advice, "%s[1] to %s[%u] are there", group, group, found->count);
        snprintf(what, sizeof what, bracket ? "no such %s: %u" : "which %s?", group, index);
        return complain(r, MR_UNKNOWN, what, advice);
    }
    at->index = bracket ? index - 1 : 0;
    while (at->field < found->field_count && strcmp(found->fields[at->field].name, field) != 0)
        at->field++;
    if (at->field == found->field_count) {
        snprintf(what, sizeof what, "%s has no field `%s`", group, field);
        return complain(r, MR_UNKNOWN, what, "the comment before each group lists its fields");
    }
    *p = rest + used;
    skip_blanks(p);
    if (**p != '=') {
        snprintf(what, sizeof what, "no value: `%.60s`", rest);
        return complain(r, MR_MALFORMED, what, "a line is group[index].field = value");
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
    return *p == '"' && ends(p + 1);
}

static bool read_real(const char **p, float *value)
{
    char *end;
    skip_blanks(p);
    if (strncmp(*p, "missing", 7) == 0) {
        *value = MR_NAN;
        *p += 7;
    } else {
        const char *digits = *p + (**p == '-' || **p == '+');
        if (!isdigit((unsigned char)*digits) && *digits != '.') /* no nan, no inf */
            return false;
        if (digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X'))
            return false;
        *value = strtof(*p, &end);
        if (end == *p)
            return false;
        *p = end;
    }
    return !**p || strchr(" \t\r#", **p);
}

static bool read_reals(const struct mr_config_field *field, const char *p, void *bytes)
{
    float values[256];
    for (unsigned i = 0; i < field->count; i++) {
        if (!read_real(&p, &values[i]))
            return false;
    }
    memcpy(bytes, values, field->count * sizeof values[0]);
    return ends(p);
}

static bool read_day(const char *p, uint64_t *days)
{
    unsigned year, month, day, y, m, d;
    int used = 0;
    *days = 0;
    if (strncmp(p, "never", 5) == 0)
        return ends(p + 5);
    if (sscanf(p, "%4u-%2u-%2u%n", &year, &month, &day, &used) != 3 || used != 10 || month < 1 || month > 12 || year < 1970)
        return false;
    *days = (uint64_t)day_of(year, month, day);
    date_of((uint32_t)*days, &y, &m, &d);
    return *days > 0 && y == year && m == month && d == day && ends(p + used);
}

static bool read_integer(const struct mr_config_field *field, const char *p, void *bytes)
{
    uint64_t value = 0;
    if (is_day(field)) {
        if (!read_day(p, &value))
            return false;
    } else {
        char *end;
        errno = 0;
        value = strtoull(p, &end, 10);
        if (!isdigit((unsigned char)*p) || errno || !ends(end) || strchr("0123456789.", *end ? *end : ' '))
            return false;
    }
    if (value < field->least || value > field->most)
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

/* Limits of reals are mr_config_check's. */
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
    struct place at;
    char name[NAME_MAX_LENGTH], what[240], advice[300];
    skip_blanks(&p);
    if (!*p || *p == '#')
        return MR_OK;
    enum mr_status status = read_name(r, &p, &at);
    if (status != MR_OK)
        return status;
    name_of(at, name);
    unsigned *line = &r->line_of[number_of(at)];
    if (*line) {
        snprintf(what, sizeof what, "%s is given twice", name);
        snprintf(advice, sizeof advice, "it is in line %u too; leave one", *line);
        return complain(r, MR_MALFORMED, what, advice);
    }
    *line = r->line;
    if (!read_value(field_of(at), p, bytes_of(r->config, at))) {
        char limits[200];
        write_limits(field_of(at), limits, sizeof limits);
        snprintf(what, sizeof what, "%s cannot be `%.*s`", name, (int)strcspn(p, "#\r"), p);
        snprintf(advice, sizeof advice, "it is %s", limits);
        return complain(r, MR_MALFORMED, what, advice);
    }
    return MR_OK;
}

static enum mr_status check(struct reader *r)
{
    struct mr_config_reason reason;
    struct place at = {0};
    size_t number = 0;
    do {
        if (!r->line_of[number++]) {
            char name[NAME_MAX_LENGTH];
            name_of(at, name);
            return error_set(r->error, MR_MALFORMED, "%s is not there: %s; every field is needed: matrig board config get writes them all",
                             name, r->name);
        }
    } while (next_place(&at));
    if (mr_config_check(r->config, &reason) == MR_OK)
        return MR_OK;
    char text[500];
    configtext_reason(r->config, &reason, text, sizeof text);
    char *advice = strstr(text, "; ");
    r->line = r->line_of[number_of((struct place){reason.group, reason.index, reason.field})];
    if (advice)
        *advice = '\0';
    return complain(r, MR_LIMIT, text, advice ? advice + 2 : "mend it");
}

enum mr_status configtext_read(const char *text, const char *name, struct mr_config *config, struct error *error)
{
    struct place end = {.group = MR_CONFIG_GROUPS - 1, .index = mr_config_groups[MR_CONFIG_GROUPS - 1].count};
    static struct mr_config read;
    struct reader reader = {.name = name, .config = &read, .error = error};
    enum mr_status status = MR_OK;
    memset(&read, 0, sizeof read);
    reader.line_of = calloc(number_of(end), sizeof *reader.line_of);
    if (!reader.line_of)
        abort();
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
        status = check(&reader);
    if (status == MR_OK)
        *config = read;
    free(reader.line_of);
    return status;
}

enum mr_status configtext_load(const char *path, struct mr_config *config, struct error *error)
{
    FILE *file = fopen(path, "rb");
    char *text = calloc(1, FILE_MAX + 1);
    if (!text)
        abort();
    size_t length = file ? fread(text, 1, FILE_MAX, file) : 0;
    bool failed = !file || ferror(file);
    int why = errno;
    if (file)
        fclose(file);
    enum mr_status status = MR_OK;
    if (failed)
        status = error_set(error, MR_IO, "cannot be read (%s): %s; matrig board config get -o FILE makes one", strerror(why), path);
    else if (strlen(text) != length || length == FILE_MAX)
        status = error_set(error, MR_MALFORMED, "no text: %s; is it the file that matrig board config get wrote?", path);
    else
        status = configtext_read(text, path, config, error);
    free(text);
    return status;
}

unsigned configtext_compare(const struct mr_config *old, const struct mr_config *new,
                            void (*each)(void *context, const char *field, const char *old, const char *new), void *context)
{
    struct place at = {0};
    unsigned differ = 0;
    do {
        char name[NAME_MAX_LENGTH], was[CONFIGTEXT_VALUE], is[CONFIGTEXT_VALUE];
        write_value(field_of(at), bytes_of(old, at), was);
        write_value(field_of(at), bytes_of(new, at), is);
        if (strcmp(was, is) == 0)
            continue;
        name_of(at, name);
        differ++;
        each(context, name, was, is);
    } while (next_place(&at));
    return differ;
}
