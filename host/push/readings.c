#include "host/push/readings.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "host/base/xmalloc.h"
#include "host/calibrate/points.h"

#define BLANKS          " \t\r\n"
#define LINE_MAX_BYTES  400
#define CELLS_MAX       12
#define CELL_SHOWN      40
#define BYTE_ORDER_MARK "\xef\xbb\xbf" /* some programs begin a text with these bytes */
#define EXAMPLE         "`test,load (lb),force (lb),displacement (in)`"

enum role { TEST, LOAD, FORCE, MOVED, ROLES };

static const struct {
    const char *name, *word, *other; /* words that a column's name has */
    enum unit_kind kind;
    const char *units;
} roles[ROLES] = {
    [TEST] = {"test", "test", "place", UNIT_NUMBER, ""},
    [LOAD] = {"load", "load", "load", UNIT_TENSION, "lb, N, kN or kg"},
    [FORCE] = {"force", "force", "force", UNIT_TENSION, "lb, N, kN or kg"},
    [MOVED] = {"displacement", "displacement", "dial", UNIT_DISPLACEMENT, "in, mm, cm, m or ft"},
};

struct table {
    const char *path;
    unsigned line;
    int cell_of[ROLES]; /* -1: there is no such column */
    const struct unit_word *unit[ROLES];
    size_t cells;
    char test[PUSH_NAME];
    double load_lb; /* NaN: none yet */
    struct push_readings *readings;
    struct error *error;
};

static bool has_word(const char *text, const char *word)
{
    size_t length = strlen(word);
    for (const char *at = text; *at; at++) {
        bool begins = at == text || !isalpha((unsigned char)at[-1]);
        if (begins && strncasecmp(at, word, length) == 0 && !isalpha((unsigned char)at[length]))
            return true;
    }
    return false;
}

/* Cells without blanks around them, in place. */
static size_t split(char *line, char *cell[CELLS_MAX])
{
    size_t count = 0;
    for (char *at = line; at && count < CELLS_MAX; count++) {
        char *comma = strchr(at, ',');
        if (comma)
            *comma = '\0';
        at += strspn(at, BLANKS);
        cell[count] = at;
        for (char *end = at + strlen(at); end > at && isspace((unsigned char)end[-1]);)
            *--end = '\0';
        at = comma ? comma + 1 : NULL;
    }
    return count;
}

static enum mr_status take_unit(struct table *t, enum role role, const char *name)
{
    struct calibrate_column column = calibrate_column(name);
    if (!column.known || column.codes)
        return error_set(t->error, MR_MALFORMED,
                         "column's name not understood: %s, line %u: '%.*s'; name it %s with its "
                         "unit, as in %s",
                         t->path, t->line, CELL_SHOWN, name, roles[role].name, EXAMPLE);
    if (!column.unit || column.unit->kind != roles[role].kind)
        return error_set(t->error, MR_MALFORMED,
                         "%s: %s, line %u: '%.*s'; the %s is in %s, as in %s",
                         column.unit ? "a unit of another kind" : "no unit", t->path, t->line,
                         CELL_SHOWN, name, roles[role].name, roles[role].units, EXAMPLE);
    t->unit[role] = column.unit;
    return MR_OK;
}

static enum mr_status take_names(struct table *t, char *cell[CELLS_MAX])
{
    for (size_t i = 0; i < t->cells; i++) {
        int found = -1;
        for (int role = 0; role < ROLES; role++) {
            if (!has_word(cell[i], roles[role].word) && !has_word(cell[i], roles[role].other))
                continue;
            if (found >= 0 || t->cell_of[role] >= 0)
                return error_set(t->error, MR_MALFORMED,
                                 "which column is the %s? %s, line %u: '%.*s'; name each once, as "
                                 "in %s",
                                 roles[role].name, t->path, t->line, CELL_SHOWN, cell[i], EXAMPLE);
            found = role;
        }
        if (found < 0)
            return error_set(t->error, MR_MALFORMED,
                             "unknown column: %s, line %u: '%.*s'; columns are test, load, force "
                             "and displacement, as in %s",
                             t->path, t->line, CELL_SHOWN, cell[i], EXAMPLE);
        t->cell_of[found] = (int)i;
        if (found != TEST && take_unit(t, (enum role)found, cell[i]) != MR_OK)
            return t->error->status;
    }
    for (int role = LOAD; role < ROLES; role++) {
        if (t->cell_of[role] < 0)
            return error_set(t->error, MR_MALFORMED,
                             "no column of the %s: %s, line %u; name the columns with their "
                             "units, as in %s",
                             roles[role].name, t->path, t->line, EXAMPLE);
    }
    return MR_OK;
}

static enum mr_status take_value(struct table *t, enum role role, const char *text, double *value)
{
    struct quantity_wrong wrong;
    if (calibrate_value(text, roles[role].kind, t->unit[role], value, &wrong))
        return MR_OK;
    if (strstr(wrong.what, "instead of"))
        return error_set(t->error, MR_MALFORMED, "%s: %s, line %u: %s '%.*s'; give it in %s",
                         wrong.what, t->path, t->line, roles[role].name, CELL_SHOWN, text,
                         roles[role].units);
    return error_set(t->error, MR_MALFORMED,
                     "%s: %s, line %u: %s '%.*s'; give a number, with a unit of its own (%s) "
                     "or without",
                     text[0] ? "no number" : "reading missing", t->path, t->line, roles[role].name,
                     CELL_SHOWN, text, roles[role].units);
}

/* The series that the row belongs to: the last one, or a new one. */
static enum mr_status series_of(struct table *t, struct push_series **series)
{
    struct push_readings *all = t->readings;
    *series = all->count > 0 ? &all->series[all->count - 1] : NULL;
    if (*series && strcmp((*series)->name, t->test) == 0 && (*series)->load_lb == t->load_lb) {
        if ((*series)->count == PUSH_READINGS_MAX)
            return error_set(t->error, MR_TOO_LONG,
                             "more than %u readings of a test: %s, line %u; name each test in the "
                             "column test, or leave readings out",
                             PUSH_READINGS_MAX, t->path, t->line);
        return MR_OK;
    }
    if (all->count == PUSH_SERIES_MAX)
        return error_set(t->error, MR_TOO_LONG,
                         "more than %u tests: %s, line %u; divide the file, or let the rows of a "
                         "test stand together",
                         PUSH_SERIES_MAX, t->path, t->line);
    xlist_grow(&all->series, all->count, sizeof *all->series);
    *series = &all->series[all->count++];
    **series = (struct push_series){.path = t->path, .load_lb = t->load_lb};
    snprintf((*series)->name, sizeof(*series)->name, "%s", t->test);
    return MR_OK;
}

static enum mr_status take_row(struct table *t, char *cell[CELLS_MAX])
{
    struct push_series *series;
    double force_lb, moved_in;
    const char *load = cell[t->cell_of[LOAD]];
    if (t->cell_of[TEST] >= 0 && cell[t->cell_of[TEST]][0]) {
        const char *test = cell[t->cell_of[TEST]];
        if (strlen(test) >= PUSH_NAME)
            return error_set(t->error, MR_TOO_LONG,
                             "name too long: %s, line %u: '%.*s'; name the test by at most %u "
                             "letters",
                             t->path, t->line, CELL_SHOWN, test, PUSH_NAME - 1);
        snprintf(t->test, sizeof t->test, "%s", test);
    }
    if ((load[0] || isnan(t->load_lb)) && take_value(t, LOAD, load, &t->load_lb) != MR_OK)
        return t->error->status;
    if (!(t->load_lb > 0.0 && t->load_lb <= PUSH_MOST_LB))
        return error_set(t->error, MR_MALFORMED,
                         "reading out of range: %s, line %u: load %.*s; give what stands on the "
                         "mat, above 0 and at most %g lb",
                         t->path, t->line, CELL_SHOWN, load, PUSH_MOST_LB);
    if (take_value(t, FORCE, cell[t->cell_of[FORCE]], &force_lb) != MR_OK ||
        take_value(t, MOVED, cell[t->cell_of[MOVED]], &moved_in) != MR_OK ||
        series_of(t, &series) != MR_OK)
        return t->error->status;
    if (fabs(force_lb) > PUSH_MOST_LB || fabs(moved_in) > PUSH_MOST_IN)
        return error_set(t->error, MR_MALFORMED,
                         "reading out of range: %s, line %u: %g lb, %g in; give at most %g lb and "
                         "%g in",
                         t->path, t->line, force_lb, moved_in, PUSH_MOST_LB, PUSH_MOST_IN);
    series->force_lb[series->count] = force_lb;
    series->moved_in[series->count++] = moved_in;
    return MR_OK;
}

static enum mr_status take_line(struct table *t, char *line)
{
    char *cell[CELLS_MAX];
    if (t->line == 1 && strncmp(line, BYTE_ORDER_MARK, 3) == 0)
        line += 3;
    line += strspn(line, BLANKS);
    if (line[0] == '\0' || line[0] == '#')
        return MR_OK;
    size_t cells = split(line, cell);
    if (t->cells == 0) {
        t->cells = cells;
        return take_names(t, cell);
    }
    if (cells != t->cells)
        return error_set(t->error, MR_MALFORMED,
                         "%zu values for %zu columns: %s, line %u; give one for each, with a point "
                         "in decimals and commas between values",
                         cells, t->cells, t->path, t->line);
    return take_row(t, cell);
}

enum mr_status push_readings_load(const char *path, struct push_readings *readings,
                                  struct error *error)
{
    char line[LINE_MAX_BYTES];
    struct table t = {.path = path,
                      .cell_of = {-1, -1, -1, -1},
                      .load_lb = (double)NAN,
                      .readings = readings,
                      .error = error};
    *readings = (struct push_readings){0};
    FILE *file = fopen(path, "r");
    if (!file)
        return error_set(error, MR_IO, "cannot read (%s): %s; check path and rights",
                         strerror(errno), path);
    enum mr_status status = MR_OK;
    while (status == MR_OK && fgets(line, sizeof line, file)) {
        t.line++;
        status = strlen(line) == sizeof line - 1
                   ? error_set(error, MR_MALFORMED,
                               "a line too long: %s, line %u; write %s and a row for each reading",
                               path, t.line, EXAMPLE)
                   : take_line(&t, line);
    }
    if (status == MR_OK && ferror(file))
        status = error_set(error, MR_IO, "cannot read (%s): %s; check path and rights",
                           strerror(errno), path);
    fclose(file);
    if (status == MR_OK && readings->count == 0)
        status = error_set(error, MR_MALFORMED,
                           "no readings: %s; the first line names the columns, as in %s, then a "
                           "row for each reading",
                           path, EXAMPLE);
    if (status != MR_OK)
        push_readings_free(readings);
    for (size_t i = 0; i < readings->count; i++) {
        if (!readings->series[i].name[0])
            snprintf(readings->series[i].name, PUSH_NAME, "%zu", i + 1);
    }
    return status;
}

void push_readings_free(struct push_readings *readings)
{
    free(readings->series);
    *readings = (struct push_readings){0};
}
