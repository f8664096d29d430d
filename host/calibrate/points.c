#include "host/calibrate/points.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "common/decimal.h"
#include "host/base/csv.h"
#include "host/base/output.h"
#include "host/base/quantity.h"

#define BLANKS         " \t\r\n"
#define LINE_MAX_BYTES 300

struct reader {
    const char *path;
    unsigned line;
    enum unit_kind kind;
    bool is_header_read; /* the header line was read */
    struct calibrate_points *points;
    struct error *error;
};

static const char *get_kind_text(enum unit_kind kind)
{
    return kind == UNIT_DISPLACEMENT ? "use in, mm, cm, m or ft for a transducer"
                                     : "use lb, N, kN or kg for a gage";
}

static enum mr_status refuse_points(const struct reader *r, enum mr_status status, const char *what,
                                    const char *advice)
{
    return error_set(r->error, status, "%s: %s, line %u; %s", what, r->path, r->line, advice);
}

static size_t trim_blanks(const char **text, size_t length)
{
    while (length && strchr(BLANKS, **text))
        ++*text, length--;
    while (length && strchr(BLANKS, (*text)[length - 1]))
        length--;
    return length;
}

static bool is_one_of(const char *text, size_t length, const char *const *words, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        if (strlen(words[i]) == length && strncasecmp(words[i], text, length) == 0)
            return true;
    }
    return false;
}

struct calibrate_column calibrate_column_parse(const char *name)
{
    static const char *const codes[] = {"codes", "code", "counts", "adc"};
    static const char *const values[] = {"value", "load",  "force",   "displacement",
                                         "dial",  "known", "tension", "test"};
    struct calibrate_column column = {0};
    size_t length = trim_blanks(&name, strlen(name)), open = 0;
    while (open < length && name[open] != '(' && name[open] != '[')
        open++;
    const char *unit = name;
    size_t unit_length = length;
    bool bracketed = open < length && name[length - 1] == (name[open] == '(' ? ')' : ']');
    if (bracketed) {
        unit = name + open + 1;
        unit_length = length - open - 2;
        length = trim_blanks(&name, open);
        if (!is_one_of(name, length, values, sizeof values / sizeof values[0]))
            return column;
    }
    unit_length = trim_blanks(&unit, unit_length);
    column.unit = unit_word_find(unit, unit_length);
    column.is_codes = !bracketed && is_one_of(name, length, codes, sizeof codes / sizeof codes[0]);
    column.is_known = column.unit || column.is_codes ||
                      (!bracketed &&
                       is_one_of(name, length, values, sizeof values / sizeof values[0]));
    return column;
}

static enum mr_status read_header(struct reader *r, const char *left, const char *right)
{
    const char *example = r->kind == UNIT_DISPLACEMENT ? "name the columns: mm,codes"
                                                       : "name the columns: N,codes";
    struct calibrate_column first = calibrate_column_parse(left),
                            second = calibrate_column_parse(right),
                            value = first.is_codes ? second : first;
    if (!first.is_known || !second.is_known || first.is_codes == second.is_codes)
        return refuse_points(r, MR_MALFORMED, "the first line has no column names", example);
    if (value.unit && value.unit->kind != r->kind)
        return refuse_points(r, MR_MALFORMED,
                             "the unit of the values does not belong to this channel",
                             get_kind_text(r->kind));
    r->points->unit = value.unit;
    r->points->are_codes_first = first.is_codes;
    r->is_header_read = true;
    return MR_OK;
}

bool calibrate_value_parse(const char *text, enum unit_kind kind, const struct unit_word *plain,
                           double *value, struct quantity_error *wrong)
{
    return quantity_parse(text, unit_get(kind, false)->text, plain ? plain->word : "", value,
                          wrong);
}

static bool read_code(const char *text, double *code)
{
    const char *end;
    *code = mr_decimal_parse(text, &end);
    return end != text && isfinite(*code) && end[strspn(end, BLANKS)] == '\0';
}

static enum mr_status read_point(struct reader *r, const char *left, const char *right)
{
    struct calibrate_points *points = r->points;
    struct calibrate_point point = {.spread = (double)NAN};
    const char *value = points->are_codes_first ? right : left,
               *code = points->are_codes_first ? left : right;
    struct quantity_error wrong = {"", ""};
    if (strchr(left, ',') || strchr(right, ','))
        return refuse_points(r, MR_MALFORMED, "a comma in a number",
                             "write numbers with a decimal point");
    bool coded = read_code(code, &point.code);
    if (!coded || (!calibrate_value_parse(value, r->kind, points->unit, &point.value, &wrong) &&
                   !wrong.what[0]))
        return refuse_points(r, MR_MALFORMED, "the line does not have one value and one code",
                             points->are_codes_first ? "write CODE,VALUE as in the first line"
                                                     : "write VALUE,CODE");
    if (wrong.what[0])
        return refuse_points(r, MR_MALFORMED, wrong.what,
                             strstr(wrong.what, "instead of") ? get_kind_text(r->kind)
                                                              : wrong.advice);
    if (points->count == CALIBRATE_POINTS_MAX)
        return error_set(r->error, MR_TOO_LONG, "more than %u points: %s; leave some out",
                         CALIBRATE_POINTS_MAX, r->path);
    points->point[points->count++] = point;
    return MR_OK;
}

static enum mr_status read_line(struct reader *r, char *line)
{
    line += r->line == 1 ? utf8_bom_length(line, strlen(line)) : 0;
    line += strspn(line, BLANKS);
    if (line[0] == '\0' || line[0] == '#')
        return MR_OK;
    char *separator = strpbrk(line, r->is_header_read ? "," : ",;\t"), *cell[3];
    if (separator && *separator != ',')
        return refuse_points(
            r, MR_MALFORMED,
            *separator == ';' ? "columns separated by semicolons" : "columns separated by tabs",
            "save the file with commas between columns and decimal points in the numbers");
    if (line[strspn(line, BLANKS ",")] == '\0') /* an empty row of a spreadsheet is skipped */
        return MR_OK;
    size_t cells = csv_split(line, ',', cell, 3);
    if (cells < 2)
        return refuse_points(r, MR_MALFORMED, "the line does not have one value and one code",
                             "write VALUE,CODE");
    if (cells > 2 && cell[2][strspn(cell[2], BLANKS ",")] != '\0')
        return refuse_points(r, MR_MALFORMED, "more than two columns",
                             "write VALUE,CODE with decimal points in the numbers");
    return r->is_header_read ? read_point(r, cell[0], cell[1]) : read_header(r, cell[0], cell[1]);
}

enum mr_status calibrate_points_read(const char *path, enum unit_kind kind,
                                     struct calibrate_points *points, struct error *error)
{
    char line[LINE_MAX_BYTES];
    enum mr_status status = MR_OK;
    *points = (struct calibrate_points){.count = 0};
    struct reader r = {.path = path, .kind = kind, .points = points, .error = error};
    if (output_check_file_format(path, "file of points", error) != MR_OK)
        return error->status;
    FILE *file = fopen(path, "r");
    if (!file)
        return error_set(error, MR_IO, "cannot read (%s): %s; check the path and the permissions",
                         strerror(errno), path);
    while (status == MR_OK && fgets(line, sizeof line, file)) {
        r.line++;
        status = strlen(line) == sizeof line - 1
                   ? refuse_points(&r, MR_MALFORMED, "line too long", "write VALUE,CODE")
                   : read_line(&r, line);
    }
    if (status == MR_OK && ferror(file))
        status = error_set(error, MR_IO, "cannot read (%s): %s; check the path and the permissions",
                           strerror(errno), path);
    fclose(file);
    return status;
}
