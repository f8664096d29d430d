#include "host/calibrate/points.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/decimal.h"
#include "host/base/quantity.h"
#include "host/calibrate/column.h"

#define BLANKS          " \t\r\n"
#define LINE_MAX_BYTES  300
#define BYTE_ORDER_MARK "\xef\xbb\xbf" /* some programs begin a text with these bytes */

struct reader {
    const char *path;
    unsigned line;
    enum unit_kind kind;
    bool named; /* the first line was there */
    struct calibrate_points *points;
    struct error *error;
};

static const char *kind_text(enum unit_kind kind)
{
    return kind == UNIT_DISPLACEMENT ? "a transducer is calibrated in in, mm, cm, m or ft"
                                     : "a gage is calibrated in lb, N, kN or kg";
}

static enum mr_status complain(const struct reader *r, enum mr_status status, const char *what,
                               const char *advice)
{
    return error_set(r->error, status, "%s: %s, line %u; %s", what, r->path, r->line, advice);
}

/* The names of the columns, when it is them: neither begins with a number. */
static bool is_names(const char *line, const char *comma)
{
    const char *end;
    (void)mr_decimal_read(line, &end);
    if (end != line)
        return false;
    (void)mr_decimal_read(comma + 1, &end);
    return end == comma + 1;
}

/* --unit overrules nothing that stands here: a name that is not understood may say another unit. */
static enum mr_status refuse_odd(const struct reader *r, const struct column *column)
{
    char what[COLUMN_ODD + 60], advice[160];
    snprintf(what, sizeof what, "what says '%s' in a column's name?", column->odd);
    snprintf(advice, sizeof advice,
             "name it VALUE or by its unit alone (%s), codes CODE, as in `%s,codes`",
             r->kind == UNIT_DISPLACEMENT ? "in, mm, cm, m, ft" : "lb, N, kN, kg",
             r->kind == UNIT_DISPLACEMENT ? "mm" : "N");
    return complain(r, MR_MALFORMED, what, advice);
}

static enum mr_status check_columns(const struct reader *r, const struct column *value,
                                    const struct column *code)
{
    const struct column *odd = value->odd[0] ? value : code;
    if (value->volts || code->volts)
        return complain(r, MR_MALFORMED, "a column in volts",
                        "codes of the converter are wanted, as matrig shows them");
    if (odd->odd[0])
        return refuse_odd(r, odd);
    if (value->codes)
        return complain(r, MR_MALFORMED, "two columns of codes",
                        "one names the unit of the values, as in `mm,codes`");
    if (value->units || code->units || code->unit)
        return complain(r, MR_MALFORMED, "more than one unit",
                        "name the unit of the values once, as in `mm,codes`");
    return MR_OK;
}

static enum mr_status read_names(struct reader *r, const char *line, const char *comma)
{
    struct column first, second;
    if (strchr(comma + 1, ','))
        return complain(r, MR_MALFORMED, "more than two columns", "write VALUE,CODE");
    column_read(line, (size_t)(comma - line), &first);
    column_read(comma + 1, strlen(comma + 1), &second);
    bool turned = first.codes || (first.unit == NULL && second.unit != NULL);
    const struct column *value = turned ? &second : &first, *code = turned ? &first : &second;
    enum mr_status status = check_columns(r, value, code);
    if (status != MR_OK)
        return status;
    if (value->unit && value->unit->kind != r->kind) {
        char what[80];
        snprintf(what, sizeof what, "values in %s", value->unit->word);
        return complain(r, MR_MALFORMED, what, kind_text(r->kind));
    }
    if (value->unit && r->points->unit && value->unit != r->points->unit)
        return error_set(r->error, MR_USAGE,
                         "the first line says %s, --unit %s: %s; which one is right?",
                         value->unit->word, r->points->unit->word, r->path);
    if (value->unit)
        r->points->unit = value->unit;
    r->points->codes_first = turned;
    r->named = true;
    return MR_OK;
}

bool calibrate_value(const char *text, enum unit_kind kind, const struct unit_word *plain,
                     double *value, struct quantity_wrong *wrong)
{
    return quantity_parse(text, unit_of(kind, false)->text, plain ? plain->word : "", value, wrong);
}

static bool read_code(const char *text, double *code)
{
    const char *end;
    *code = mr_decimal_read(text, &end);
    return end != text && isfinite(*code) && end[strspn(end, BLANKS)] == '\0';
}

/* Without a unit a value waits for the end of the file: then what is wrong with the lines has been
 * told. */
static enum mr_status read_point(struct reader *r, char *line, char *comma, bool *unitless)
{
    struct calibrate_points *points = r->points;
    struct calibrate_point point = {.spread = (double)NAN};
    const struct unit_word *own = unit_read(unit_of(r->kind, false)->text, 2);
    double alone;
    *comma = '\0';
    const char *value = points->codes_first ? comma + 1 : line,
               *code = points->codes_first ? line : comma + 1;
    struct quantity_wrong wrong = {"", ""};
    bool coded = read_code(code, &point.code);
    bool valued = calibrate_value(value, r->kind, points->unit ? points->unit : own, &point.value,
                                  &wrong);
    if (coded && !valued && strstr(wrong.what, "unit"))
        return complain(r, MR_MALFORMED, wrong.what, wrong.advice);
    if (coded && !valued && strstr(wrong.what, "instead of"))
        return complain(r, MR_MALFORMED, wrong.what, kind_text(r->kind));
    if (!coded || !valued)
        return complain(r, MR_MALFORMED, "not a value and a code",
                        points->codes_first ? "write CODE,VALUE, as the first line says"
                                            : "write VALUE,CODE");
    *unitless |= !points->unit && read_code(value, &alone);
    if (points->count == CALIBRATE_POINTS_MAX)
        return error_set(r->error, MR_TOO_LONG, "more than %u points: %s; leave some out",
                         CALIBRATE_POINTS_MAX, r->path);
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

enum mr_status calibrate_points_read(const char *path, enum unit_kind kind,
                                     const struct unit_word *given, struct calibrate_points *points,
                                     struct error *error)
{
    char line[LINE_MAX_BYTES];
    bool unitless = false;
    enum mr_status status = MR_OK;
    *points = (struct calibrate_points){.unit = given};
    struct reader r = {.path = path, .kind = kind, .points = points, .error = error};
    FILE *file = fopen(path, "r");
    if (!file)
        return error_set(error, MR_IO, "cannot read (%s): %s; check path and rights",
                         strerror(errno), path);
    while (status == MR_OK && fgets(line, sizeof line, file)) {
        r.line++;
        status = strlen(line) == sizeof line - 1
                   ? complain(&r, MR_MALFORMED, "a line too long", "write VALUE,CODE")
                   : read_line(&r, line, &unitless);
    }
    fclose(file);
    if (status == MR_OK && unitless)
        return error_set(error, MR_USAGE,
                         "in which unit are the values? %s does not say; name it in a first line, "
                         "as in `%s,codes`, or with --unit",
                         path, kind == UNIT_DISPLACEMENT ? "mm" : "N");
    return status;
}
