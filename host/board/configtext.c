#include "host/board/configtext.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "common/wire.h"
#include "host/board/configplace.h"

#define FILE_MAX (1024 * 1024)

struct words {
    const char *unit, *text;
};

/* clang-format off */
#define GROUP(name, count) static const struct words name##_words[] = {
#define INTEGER(group, type, field, least, most, unit, text) {unit, text},
#define REAL(group, field, least, most, unit, text) {unit, text},
#define REALS(group, field, count, least, most, unit, text) {unit, text},
#define TEXT(group, field, size, text) {"", text},
#define END(name) };
/* clang-format on */
#include "common/config.def"

static const struct words *const words[] = {
#define GROUP(name, count) name##_words,
#include "common/config.def"
};

static void write_legend(FILE *file, unsigned group)
{
    fprintf(file, "\n# %s\n", mr_config_groups[group].name);
    for (unsigned f = 0; f < mr_config_groups[group].field_count; f++) {
        const struct words *w = &words[group][f];
        const struct mr_config_field *field = &mr_config_groups[group].fields[f];
        bool day = configplace_is_day(field);
        if (day) /* as it is written here, not as it is stored */
            fprintf(file, "#     %-18s YYYY-MM-DD or never: %.*s\n", field->name,
                    (int)strcspn(w->text, ",;"), w->text);
        else
            fprintf(file, "#     %-18s %s%s%s\n", field->name, w->unit, w->unit[0] ? ": " : "",
                    w->text);
    }
}

char *configtext_write(const struct mr_config *config)
{
    char *text = NULL;
    size_t size;
    FILE *file = open_memstream(&text, &size);
    struct configplace at = {0};
    if (!file)
        abort();
    fputs("# matrig configuration. One field a line, each exactly once; matrig board config check "
          "FILE reads it.\n",
          file);
    do {
        char name[CONFIGPLACE_NAME], value[CONFIGPLACE_VALUE];
        const char *unit = words[at.group][at.field].unit;
        if (at.index == 0 && at.field == 0)
            write_legend(file, at.group);
        if (at.field == 0)
            fputc('\n', file);
        configplace_name(at, name);
        configplace_value(configplace_field(at), configplace_bytes(config, at), value);
        fprintf(file, "%s = %s%s%s\n", name, value,
                unit[0] && !configplace_is_day(configplace_field(at)) ? "  # " : "",
                configplace_is_day(configplace_field(at)) ? "" : unit);
    } while (configplace_next(&at));
    if (fclose(file) != 0)
        abort();
    return text;
}

/* --- reading --- */

struct reader {
    const char *name; /* of the file */
    unsigned line;
    struct mr_config *config;
    unsigned *line_of; /* each place, in the order of the table; 0: not read yet */
    struct error *error;
};

static size_t number_of(struct configplace at)
{
    size_t number = 0;
    for (unsigned g = 0; g < at.group; g++)
        number += (size_t)mr_config_groups[g].count * mr_config_groups[g].field_count;
    return number + (size_t)at.index * mr_config_groups[at.group].field_count + at.field;
}

static enum mr_status complain(const struct reader *r, enum mr_status status, const char *what,
                               const char *advice)
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
static enum mr_status read_name(const struct reader *r, const char **p, struct configplace *at)
{
    char group[32] = "", field[48] = "", what[160];
    unsigned index = 0;
    int used = 0;
    const char *rest = *p;
    bool bracket =
        sscanf(rest, "%31[a-z_][%9u].%47[a-z_0-9]%n", group, &index, field, &used) == 3 && used;
    if (!bracket && (sscanf(rest, "%31[a-z_].%47[a-z_0-9]%n", group, field, &used) != 2 || !used)) {
        snprintf(what, sizeof what, "no field: `%.60s`", rest);
        return complain(r, MR_MALFORMED, what,
                        "a line is group[index].field = value, or begins with #");
    }
    *at = (struct configplace){0};
    while (at->group < MR_CONFIG_GROUPS && strcmp(mr_config_groups[at->group].name, group) != 0)
        at->group++;
    if (at->group == MR_CONFIG_GROUPS) {
        snprintf(what, sizeof what, "no such group: `%s`", group);
        return complain(r, MR_UNKNOWN, what, "there are site, channel, gate, band and predict");
    }
    const struct mr_config_group *found = &mr_config_groups[at->group];
    if (bracket ? index < 1 || index > found->count : found->count != 1) {
        char advice[100];
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
    uint32_t day;
    *days = 0;
    if (strncmp(p, "never", 5) == 0)
        return ends(p + 5);
    if (!configplace_date_read(p, &day))
        return false;
    *days = day;
    return ends(p + CONFIGPLACE_DATE - 1);
}

static bool read_integer(const struct mr_config_field *field, const char *p, void *bytes)
{
    uint64_t value = 0;
    if (configplace_is_day(field)) {
        if (!read_day(p, &value))
            return false;
    } else {
        char *end;
        errno = 0;
        value = strtoull(p, &end, 10);
        if (!isdigit((unsigned char)*p) || errno || !ends(end) ||
            strchr("0123456789.", *end ? *end : ' '))
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
    struct configplace at;
    char name[CONFIGPLACE_NAME], what[240], advice[300];
    skip_blanks(&p);
    if (!*p || *p == '#')
        return MR_OK;
    enum mr_status status = read_name(r, &p, &at);
    if (status != MR_OK)
        return status;
    configplace_name(at, name);
    unsigned *line = &r->line_of[number_of(at)];
    if (*line) {
        snprintf(what, sizeof what, "%s is given twice", name);
        snprintf(advice, sizeof advice, "it is in line %u too; leave one", *line);
        return complain(r, MR_MALFORMED, what, advice);
    }
    *line = r->line;
    if (!read_value(configplace_field(at), p, configplace_bytes(r->config, at))) {
        char limits[200];
        configplace_limits(configplace_field(at), limits, sizeof limits);
        snprintf(what, sizeof what, "%s cannot be `%.*s`", name, (int)strcspn(p, "#\r"), p);
        snprintf(advice, sizeof advice, "it is %s", limits);
        return complain(r, MR_MALFORMED, what, advice);
    }
    return MR_OK;
}

static enum mr_status check(struct reader *r)
{
    struct mr_config_reason reason;
    struct configplace at = {0};
    size_t number = 0;
    do {
        if (!r->line_of[number++]) {
            char name[CONFIGPLACE_NAME];
            configplace_name(at, name);
            return error_set(r->error, MR_MALFORMED,
                             "%s is not there: %s; every field is needed: matrig board config get "
                             "writes them all",
                             name, r->name);
        }
    } while (configplace_next(&at));
    if (mr_config_check(r->config, &reason) == MR_OK)
        return MR_OK;
    char text[500];
    configtext_reason(r->config, &reason, text, sizeof text);
    char *advice = strstr(text, "; ");
    r->line = r->line_of[number_of((struct configplace){reason.group, reason.index, reason.field})];
    if (advice)
        *advice = '\0';
    return complain(r, MR_LIMIT, text, advice ? advice + 2 : "mend it");
}

enum mr_status configtext_read(const char *text, const char *name, struct mr_config *config,
                               struct error *error)
{
    struct configplace end = {.group = MR_CONFIG_GROUPS - 1,
                              .index = mr_config_groups[MR_CONFIG_GROUPS - 1].count};
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
        status = error_set(error, MR_IO,
                           "cannot be read (%s): %s; matrig board config get -o FILE makes one",
                           strerror(why), path);
    else if (strlen(text) != length || length == FILE_MAX)
        status = error_set(error, MR_MALFORMED,
                           "no text: %s; is it the file that matrig board config get wrote?", path);
    else
        status = configtext_read(text, path, config, error);
    free(text);
    return status;
}

unsigned configtext_compare(const struct mr_config *old, const struct mr_config *new,
                            void (*each)(void *context, const char *field, const char *old,
                                         const char *new),
                            void *context)
{
    struct configplace at = {0};
    unsigned differ = 0;
    do {
        char name[CONFIGPLACE_NAME], was[CONFIGPLACE_VALUE], is[CONFIGPLACE_VALUE];
        configplace_value(configplace_field(at), configplace_bytes(old, at), was);
        configplace_value(configplace_field(at), configplace_bytes(new, at), is);
        if (strcmp(was, is) == 0)
            continue;
        configplace_name(at, name);
        differ++;
        each(context, name, was, is);
    } while (configplace_next(&at));
    return differ;
}
