#include "host/board/configtext.h"

#include <ctype.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "common/wire.h"
#include "host/board/configplace.h"
#include "host/board/configunits.h"

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
    struct read_place {
        unsigned line; /* 0: not read yet */
        enum configunits_of of;
    } * place; /* each, in the order of the table */
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

/* All with a unit, or none: but 0 is 0 in each. */
static bool read_reals(const struct mr_config_field *field, const char *unit, const char *p,
                       void *bytes, enum configunits_of *of, struct quantity_wrong *wrong)
{
    float values[256];
    bool bare = false;
    *of = CONFIGUNITS_NONE;
    for (unsigned i = 0; i < field->count; i++) {
        enum configunits_of one;
        if (!configunits_read(&p, unit, field->count > 1, &values[i], &one, wrong))
            return false;
        bare |= one == CONFIGUNITS_NONE && values[i] != 0.0f && values[i] == values[i];
        if (one != CONFIGUNITS_NONE && *of != CONFIGUNITS_NONE && one != *of)
            bare = true;
        *of = one == CONFIGUNITS_NONE ? *of : one;
    }
    memcpy(bytes, values, field->count * sizeof values[0]);
    if (bare && *of != CONFIGUNITS_NONE)
        *wrong = (struct quantity_wrong){"some without a unit", "write one behind each, or none"};
    return ends(p) && !(bare && *of != CONFIGUNITS_NONE);
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

/* A whole number; with a unit when it comes to one: "0.5 s" of a field in ms. */
static bool read_count(const char *unit, const char *p, uint64_t *value,
                       struct quantity_wrong *wrong)
{
    char *end, text[60];
    double number;
    errno = 0;
    *value = strtoull(p, &end, 10);
    if (isdigit((unsigned char)*p) && !errno && ends(end))
        return true;
    size_t length = strcspn(p, "#");
    if (!quantity_kind_of(unit) || length >= sizeof text)
        return false;
    memcpy(text, p, length);
    text[length] = '\0';
    if (!quantity_parse(text, unit, "", &number, wrong) || !(number >= 0.0 && number < 1e9))
        return false;
    *value = (uint64_t)number;
    return (double)*value == number;
}

static bool read_integer(const struct mr_config_field *field, const char *unit, const char *p,
                         void *bytes, struct quantity_wrong *wrong)
{
    uint64_t value = 0;
    if (configplace_is_day(field)) {
        if (!read_day(p, &value))
            return false;
    } else if (!read_count(unit, p, &value, wrong)) {
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
static bool read_value(const struct mr_config_field *field, const char *unit, const char *p,
                       void *bytes, enum configunits_of *of, struct quantity_wrong *wrong)
{
    if (field->type == MR_CONFIG_TYPE_TEXT)
        return read_text(field, p, bytes);
    if (field->type == MR_CONFIG_TYPE_REAL || field->type == MR_CONFIG_TYPE_OPTIONAL)
        return read_reals(field, unit, p, bytes, of, wrong);
    return read_integer(field, unit, p, bytes, wrong);
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
    struct read_place *place = &r->place[number_of(at)];
    if (place->line) {
        snprintf(what, sizeof what, "%s is given twice", name);
        snprintf(advice, sizeof advice, "it is in line %u too; leave one", place->line);
        return complain(r, MR_MALFORMED, what, advice);
    }
    place->line = r->line;
    struct quantity_wrong wrong = {"", ""};
    if (!read_value(configplace_field(at), words[at.group][at.field].unit, p,
                    configplace_bytes(r->config, at), &place->of, &wrong)) {
        char limits[200];
        int length = (int)strcspn(p, "#\r");
        while (length > 0 && p[length - 1] == ' ')
            length--;
        configplace_limits(configplace_field(at), limits, sizeof limits);
        snprintf(what, sizeof what, "%s cannot be `%.*s`%s%s", name, length, p,
                 wrong.what[0] ? ", " : "", wrong.what);
        snprintf(advice, sizeof advice, "%s%s", wrong.what[0] ? "" : "it is ",
                 wrong.what[0] ? wrong.advice : limits);
        return complain(r, MR_MALFORMED, what, advice);
    }
    return MR_OK;
}

/* A length is no tension: a channel's fields are in the unit of what it measures. */
static enum mr_status check_units(struct reader *r)
{
    struct configplace at = {0};
    size_t number = 0;
    do {
        const struct read_place *place = &r->place[number++];
        bool length = place->of == CONFIGUNITS_LENGTH, force = place->of == CONFIGUNITS_FORCE;
        unsigned kind = length || force ? r->config->channel[at.index].kind : MR_KIND_NONE;
        if (kind == MR_KIND_NONE || (length && kind == MR_KIND_DISPLACEMENT) ||
            (force && kind == MR_KIND_TENSION))
            continue;
        char name[CONFIGPLACE_NAME], what[160], advice[200], own[40];
        bool gage = kind == MR_KIND_TENSION, none = !gage && kind != MR_KIND_DISPLACEMENT;
        configunits_own(words[at.group][at.field].unit,
                        gage ? CONFIGUNITS_FORCE : CONFIGUNITS_LENGTH, own);
        const struct quantity_kind *wanted = quantity_kind_of(own);
        configplace_name(at, name);
        r->line = place->line;
        snprintf(what, sizeof what, "%s is given with a unit of %s", name,
                 length ? "a length" : "a force");
        snprintf(advice, sizeof advice, "the channel is %s: write %s",
                 gage   ? "a gage"
                 : none ? "no transducer and no gage"
                        : "a transducer",
                 none ? "digits alone" : wanted->units);
        return complain(r, MR_MALFORMED, what, advice);
    } while (configplace_next(&at));
    return MR_OK;
}

/* Texts of before it, which campaigns hold too, do not name it: they are of boards at base 0. */
static bool may_be_absent(struct configplace at)
{
    return at.group == MR_GROUP_site && at.field == MR_FIELD_site_can_base;
}

static enum mr_status check(struct reader *r)
{
    struct mr_config_reason reason;
    struct configplace at = {0};
    size_t number = 0;
    do {
        if (!r->place[number++].line && !may_be_absent(at)) {
            char name[CONFIGPLACE_NAME];
            configplace_name(at, name);
            return error_set(r->error, MR_MALFORMED,
                             "%s is not there: %s; every field is needed: matrig board config get "
                             "writes them all",
                             name, r->name);
        }
    } while (configplace_next(&at));
    if (check_units(r) != MR_OK)
        return r->error->status;
    if (mr_config_check(r->config, &reason) == MR_OK)
        return MR_OK;
    char text[500];
    configtext_reason(r->config, &reason, text, sizeof text);
    char *advice = strstr(text, "; ");
    r->line =
        r->place[number_of((struct configplace){reason.group, reason.index, reason.field})].line;
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
    reader.place = calloc(number_of(end), sizeof *reader.place);
    if (!reader.place)
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
    free(reader.place);
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
