#include "host/calibrate/points.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define BLANKS " \t\r\n"
#define LINE_MAX_BYTES 300
#define BYTE_ORDER_MARK "\xef\xbb\xbf" /* some programs begin a text with these bytes */

static const char *const code_words[] = {"code", "codes", "count", "counts", "adc", "raw", "lsb"};
static const char *const volt_words[] = {"v", "mv", "volt", "volts", "millivolt", "millivolts"};

/* What the first line says of one column. */
struct column {
    bool codes, volts;
    const struct unit_word *unit; /* NULL: none */
    bool units;                   /* more than one */
};

struct reader {
    const char *path;
    unsigned line;
    enum unit_kind kind;
    bool named;  /* the first line was there */
    struct calibrate_points *points;
    struct error *error;
};

static bool is_one_of(const char *word, size_t length, const char *const *list, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (strlen(list[i]) == length && strncasecmp(list[i], word, length) == 0)
            return true;
    }
    return false;
}

/* Letters, and bytes of letters beyond ASCII: the m of a micrometre is no metre. */
static bool in_word(char c)
{
    return isalpha((unsigned char)c) || (unsigned char)c >= 0x80;
}

static struct column read_column(const char *text, size_t length)
{
    struct column column = {0};
    bool preposition = false;
    for (size_t i = 0; i < length;) {
        size_t begin = i;
        while (i < length && in_word(text[i]))
            i++;
        if (i == begin) {
            i++;
            continue;
        }
        const struct unit_word *unit = unit_read(text + begin, i - begin);
        column.codes |= is_one_of(text + begin, i - begin, code_words, sizeof code_words / sizeof code_words[0]);
        column.volts |= is_one_of(text + begin, i - begin, volt_words, sizeof volt_words / sizeof volt_words[0]);
        if (!unit)
            continue;
        column.units |= column.unit && column.unit != unit && !preposition;
        column.unit = unit;
        preposition = i - begin == 2 && strncasecmp(text + begin, "in", 2) == 0; /* "value in mm" */
    }
    if (column.codes)
        column.unit = NULL; /* "reading in codes" */
    return column;
}

static const char *kind_text(enum unit_kind kind)
{
    return kind == UNIT_DISPLACEMENT ? "a transducer is calibrated in in, mm, cm, m or ft" : "a gage is calibrated in lb, N, kN or kg";
}

static enum mr_status complain(const struct reader *r, enum mr_status status, const char *what, const char *advice)
{
    return error_set(r->error, status, "%s: %s, line %u; %s", what, r->path, r->line, advice);
}

/* The names of the columns, when it is them: neither begins with a number. */
static bool is_names(const char *line, const char *comma)
{
    char *end;
    (void)strtod(line, &end);
    if (end != line)
        return false;
    (void)strtod(comma + 1, &end);
    return end == comma + 1;
}

static enum mr_status read_names(struct reader *r, const char *line, const char *comma)
{
    struct column first = read_column(line, (size_t)(comma - line)), second = read_column(comma + 1, strlen(comma + 1));
    bool turned = first.codes || (first.unit == NULL && second.unit != NULL);
    const struct column *value = turned ? &second : &first, *code = turned ? &first : &second;
    if (strchr(comma + 1, ','))
        return complain(r, MR_MALFORMED, "more than two columns", "write VALUE,CODE");
    if (first.volts || second.volts)
        return complain(r, MR_MALFORMED, "a column in volts", "codes of the converter are wanted, as matrig shows them");
    if ((first.codes && second.codes) || value->codes)
        return complain(r, MR_MALFORMED, "two columns of codes", "one names the unit of the values, as in `mm,codes`");
    if (value->units || code->unit)
        return complain(r, MR_MALFORMED, "more than one unit", "name the unit of the values once, as in `mm,codes`");
    if (value->unit && value->unit->kind != r->kind) {
        char what[80];
        snprintf(what, sizeof what, "values in %s", value->unit->word);
        return complain(r, MR_MALFORMED, what, kind_text(r->kind));
    }
    if (value->unit && r->points->unit && value->unit != r->points->unit)
        return error_set(r->error, MR_USAGE, "the first line says %s, --unit %s: %s; which one is right?", value->unit->word,
                         r->points->unit->word, r->path);
    if (value->unit)
        r->points->unit = value->unit;
    r->points->codes_first = turned;
    r->named = true;
    return MR_OK;
}

bool calibrate_value(const char *text, enum unit_kind kind, const struct unit_word *plain, double *value)
{
    char *end;
    *value = strtod(text, &end);
    if (end == text || !isfinite(*value))
        return false;
    end += strspn(end, BLANKS);
    size_t length = strcspn(end, BLANKS);
    const struct unit_word *unit = length ? unit_read(end, length) : plain;
    if (!unit || unit->kind != kind || end[length + strspn(end + length, BLANKS)] != '\0')
        return false;
    *value *= unit->factor;
    return true;
}

static bool read_code(const char *text, double *code)
{
    char *end;
    *code = strtod(text, &end);
    return end != text && isfinite(*code) && end[strspn(end, BLANKS)] == '\0';
}

/* Without a unit a value waits for the end of the file: then what is wrong with the lines has been told. */
static enum mr_status read_point(struct reader *r, char *line, char *comma, bool *unitless)
{
    static const struct unit_word as_is[] = {[UNIT_DISPLACEMENT] = {"", UNIT_DISPLACEMENT, 1.0}, [UNIT_TENSION] = {"", UNIT_TENSION, 1.0}};
    struct calibrate_points *points = r->points;
    struct calibrate_point point = {.spread = (double)NAN};
    double alone;
    *comma = '\0';
    const char *value = points->codes_first ? comma + 1 : line, *code = points->codes_first ? line : comma + 1;
    if (!read_code(code, &point.code) || !calibrate_value(value, r->kind, points->unit ? points->unit : &as_is[r->kind], &point.value))
        return complain(r, MR_MALFORMED, "not a value and a code",
                        points->codes_first ? "write CODE,VALUE, as the first line says" : "write VALUE,CODE");
    *unitless |= !points->unit && read_code(value, &alone);
    if (points->count == CALIBRATE_POINTS_MAX)
        return error_set(r->error, MR_TOO_LONG, "more than %u points: %s; leave some out", CALIBRATE_POINTS_MAX, r->path);
    points->point[points->count++] = point;
    return MR_OK;
}

static enum mr_status read_line(struct reader *r, char *line, bool *unitless)
{
    if (r->line == 1 && strncmp(line, BYTE_ORDER_MARK, 3) == 0)
        line += 3;
    line += strspn(line, BLANKS);
    if (line[0] == '\0' || line[0] == '#')
        return MR_OK;
    char *comma = strchr(line, ',');
    if (!comma)
        return complain(r, MR_MALFORMED, "not a value and a code", "write VALUE,CODE");
    if (!r->named && r->points->count == 0 && is_names(line, comma))
        return read_names(r, line, comma);
    return read_point(r, line, comma, unitless);
}

enum mr_status calibrate_points_read(const char *path, enum unit_kind kind, const struct unit_word *given, struct calibrate_points *points,
                                     struct error *error)
{
    char line[LINE_MAX_BYTES];
    bool unitless = false;
    enum mr_status status = MR_OK;
    *points = (struct calibrate_points){.unit = given};
    struct reader r = {.path = path, .kind = kind, .points = points, .error = error};
    FILE *file = fopen(path, "r");
    if (!file)
        return error_set(error, MR_IO, "cannot read (%s): %s; check path and rights", strerror(errno), path);
    while (status == MR_OK && fgets(line, sizeof line, file)) {
        r.line++;
        status = strlen(line) == sizeof line - 1 ? complain(&r, MR_MALFORMED, "a line too long", "write VALUE,CODE") : read_line(&r, line, &unitless);
    }
    fclose(file);
    if (status == MR_OK && unitless)
        return error_set(error, MR_USAGE, "in which unit are the values? %s does not say; name it in a first line, as in `%s,codes`, or with --unit",
                         path, kind == UNIT_DISPLACEMENT ? "mm" : "N");
    return status;
}
