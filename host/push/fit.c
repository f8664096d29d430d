#include "host/push/fit.h"
#include "host/base/output.h"
#include "host/base/xmalloc.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "host/calibrate/points.h"

/* ---- readings ---- */

#define BLANKS         " \t\r\n"
#define LINE_MAX_BYTES 400
#define CELLS_MAX      12
#define CELL_SHOWN_MAX 40
#define HEADER_EXAMPLE "`test,load (lb),force (lb),displacement (in)`"

enum column_role { ROLE_TEST, ROLE_LOAD, ROLE_FORCE, ROLE_DISPLACEMENT, ROLE_COUNT };

static const struct {
    const char *name, *word, *alternative; /* words that identify the column in the header line */
    enum unit_kind kind;
    const char *units;
    double max; /* largest plausible value, in or lb */
} roles[ROLE_COUNT] = {
    [ROLE_TEST] = {"test", "test", "place", UNIT_NUMBER, "", 0.0},
    [ROLE_LOAD] = {"load", "load", "load", UNIT_TENSION, "lb, N, kN or kg", PUSH_FORCE_MAX_LB},
    [ROLE_FORCE] = {"force", "force", "force", UNIT_TENSION, "lb, N, kN or kg", PUSH_FORCE_MAX_LB},
    [ROLE_DISPLACEMENT] = {"displacement", "displacement", "dial", UNIT_DISPLACEMENT,
                           "in, mm, cm, m or ft", PUSH_DISPLACEMENT_MAX_IN},
};

struct readings_file {
    const char *path;
    unsigned line;
    int column[ROLE_COUNT]; /* index of each column; -1: there is no such column */
    const struct unit_word *unit[ROLE_COUNT];
    size_t cell_count;
    char test[PUSH_NAME_SIZE];
    double load_lb; /* load of the previous row; NaN: none yet */
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

/* Splits a line into cells without surrounding blanks, in place. */
static size_t split_cells(char *line, char *cell[CELLS_MAX])
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

static enum mr_status parse_unit(struct readings_file *t, enum column_role role, const char *name)
{
    struct calibrate_column column = calibrate_column_parse(name);
    if (!column.is_known || column.is_codes)
        return error_set(t->error, MR_MALFORMED,
                         "unknown unit in a column name: %s, line %u: '%.*s'; name the column %s "
                         "with its unit, as in %s",
                         t->path, t->line, CELL_SHOWN_MAX, name, roles[role].name, HEADER_EXAMPLE);
    if (!column.unit || column.unit->kind != roles[role].kind)
        return error_set(t->error, MR_MALFORMED,
                         "%s: %s, line %u: '%.*s'; give the %s in %s, as in %s",
                         column.unit ? "a unit of the wrong kind" : "no unit", t->path, t->line,
                         CELL_SHOWN_MAX, name, roles[role].name, roles[role].units, HEADER_EXAMPLE);
    t->unit[role] = column.unit;
    return MR_OK;
}

static enum mr_status parse_header(struct readings_file *t, char *cell[CELLS_MAX])
{
    for (size_t i = 0; i < t->cell_count; i++) {
        int found = -1;
        for (int role = 0; role < ROLE_COUNT; role++) {
            if (!has_word(cell[i], roles[role].word) && !has_word(cell[i], roles[role].alternative))
                continue;
            if (found >= 0 || t->column[role] >= 0)
                return error_set(
                    t->error, MR_MALFORMED,
                    "two columns for the %s: %s, line %u: '%.*s'; name each column once, as in %s",
                    roles[role].name, t->path, t->line, CELL_SHOWN_MAX, cell[i], HEADER_EXAMPLE);
            found = role;
        }
        if (found < 0)
            return error_set(t->error, MR_MALFORMED,
                             "unknown column: %s, line %u: '%.*s'; columns are test, load, force "
                             "and displacement, as in %s",
                             t->path, t->line, CELL_SHOWN_MAX, cell[i], HEADER_EXAMPLE);
        t->column[found] = (int)i;
        if (found != ROLE_TEST && parse_unit(t, (enum column_role)found, cell[i]) != MR_OK)
            return t->error->status;
    }
    for (int role = ROLE_LOAD; role < ROLE_COUNT; role++) {
        if (t->column[role] < 0)
            return error_set(
                t->error, MR_MALFORMED,
                "no column for the %s: %s, line %u; name the columns with their units, as in %s",
                roles[role].name, t->path, t->line, HEADER_EXAMPLE);
    }
    return MR_OK;
}

static enum mr_status parse_value(struct readings_file *t, enum column_role role, const char *text,
                                  double *value)
{
    struct quantity_error wrong;
    if (calibrate_value_parse(text, roles[role].kind, t->unit[role], value, &wrong)) {
        if (fabs(*value) <= roles[role].max && (role != ROLE_LOAD || *value > 0.0))
            return MR_OK;
        return error_set(
            t->error, MR_MALFORMED,
            "reading out of range: %s, line %u: %s %.*s; give at most %g %s, and a load "
            "above 0",
            t->path, t->line, roles[role].name, CELL_SHOWN_MAX, text, roles[role].max,
            role == ROLE_DISPLACEMENT ? "in" : "lb");
    }
    if (strstr(wrong.what, "instead of"))
        return error_set(t->error, MR_MALFORMED, "%s: %s, line %u: %s '%.*s'; give the value in %s",
                         wrong.what, t->path, t->line, roles[role].name, CELL_SHOWN_MAX, text,
                         roles[role].units);
    return error_set(t->error, MR_MALFORMED,
                     "%s: %s, line %u: %s '%.*s'; give a number, with a unit (%s) or without",
                     text[0] ? "no number" : "reading missing", t->path, t->line, roles[role].name,
                     CELL_SHOWN_MAX, text, roles[role].units);
}

/* Finds the series of a row: the last series or a new one. */
static enum mr_status find_or_add_series(struct readings_file *t, struct push_series **series)
{
    struct push_readings *all = t->readings;
    *series = all->count > 0 ? &all->series[all->count - 1] : NULL;
    if (*series && strcmp((*series)->name, t->test) == 0 && (*series)->load_lb == t->load_lb) {
        if ((*series)->count == PUSH_READINGS_MAX)
            return error_set(
                t->error, MR_TOO_LONG,
                "more than %u readings in one test: %s, line %u; give each test a name "
                "in the column 'test', or remove readings",
                PUSH_READINGS_MAX, t->path, t->line);
        return MR_OK;
    }
    if (all->count == PUSH_SERIES_MAX)
        return error_set(t->error, MR_TOO_LONG,
                         "more than %u tests: %s, line %u; split the file, or keep the rows of "
                         "each test together",
                         PUSH_SERIES_MAX, t->path, t->line);
    xlist_grow(&all->series, all->count, sizeof *all->series);
    *series = &all->series[all->count++];
    **series = (struct push_series){.path = t->path, .load_lb = t->load_lb};
    snprintf((*series)->name, sizeof(*series)->name, "%s", t->test);
    return MR_OK;
}

static enum mr_status parse_row(struct readings_file *t, char *cell[CELLS_MAX])
{
    struct push_series *series;
    double force_lb, displacement_in;
    const char *load = cell[t->column[ROLE_LOAD]];
    if (t->column[ROLE_TEST] >= 0 && cell[t->column[ROLE_TEST]][0]) {
        const char *test = cell[t->column[ROLE_TEST]];
        if (strlen(test) >= PUSH_NAME_SIZE)
            return error_set(
                t->error, MR_TOO_LONG,
                "name too long: %s, line %u: '%.*s'; use a test name of at most %u letters",
                t->path, t->line, CELL_SHOWN_MAX, test, PUSH_NAME_SIZE - 1);
        snprintf(t->test, sizeof t->test, "%s", test);
    }
    if ((load[0] || isnan(t->load_lb)) && parse_value(t, ROLE_LOAD, load, &t->load_lb) != MR_OK)
        return t->error->status;
    if (parse_value(t, ROLE_FORCE, cell[t->column[ROLE_FORCE]], &force_lb) != MR_OK ||
        parse_value(t, ROLE_DISPLACEMENT, cell[t->column[ROLE_DISPLACEMENT]], &displacement_in) !=
            MR_OK ||
        find_or_add_series(t, &series) != MR_OK)
        return t->error->status;
    series->force_lb[series->count] = force_lb;
    series->displacement_in[series->count++] = displacement_in;
    return MR_OK;
}

static enum mr_status parse_line(struct readings_file *t, char *line)
{
    char *cell[CELLS_MAX];
    line += t->line == 1 ? utf8_bom_length(line, strlen(line)) : 0;
    line += strspn(line, BLANKS);
    if (line[0] == '\0' || line[0] == '#')
        return MR_OK;
    size_t cells = split_cells(line, cell);
    if (t->cell_count == 0) {
        t->cell_count = cells;
        return parse_header(t, cell);
    }
    if (cells != t->cell_count)
        return error_set(t->error, MR_MALFORMED,
                         "the line has %zu values for %zu columns: %s, line %u; give one value for "
                         "each column, with a decimal point and commas between values",
                         cells, t->cell_count, t->path, t->line);
    return parse_row(t, cell);
}

enum mr_status push_readings_load(const char *path, struct push_readings *readings,
                                  struct error *error)
{
    char line[LINE_MAX_BYTES];
    struct readings_file t = {.path = path,
                              .column = {-1, -1, -1, -1},
                              .load_lb = (double)NAN,
                              .readings = readings,
                              .error = error};
    *readings = (struct push_readings){0};
    FILE *file = fopen(path, "r");
    if (!file)
        return error_set(error, MR_IO, "cannot read (%s): %s; check the path and the permissions",
                         strerror(errno), path);
    enum mr_status status = MR_OK;
    while (status == MR_OK && fgets(line, sizeof line, file)) {
        t.line++;
        status = strlen(line) == sizeof line - 1
                   ? error_set(error, MR_MALFORMED,
                               "line too long: %s, line %u; write the header %s, then one line per "
                               "reading",
                               path, t.line, HEADER_EXAMPLE)
                   : parse_line(&t, line);
    }
    if (status == MR_OK && ferror(file))
        status = error_set(error, MR_IO, "cannot read (%s): %s; check the path and the permissions",
                           strerror(errno), path);
    fclose(file);
    if (status == MR_OK && readings->count == 0)
        status = error_set(error, MR_MALFORMED,
                           "no readings: %s; write the header %s, then one line per reading", path,
                           HEADER_EXAMPLE);
    if (status != MR_OK)
        push_readings_free(readings);
    for (size_t i = 0; i < readings->count; i++) {
        if (!readings->series[i].name[0])
            snprintf(readings->series[i].name, PUSH_NAME_SIZE, "%zu", i + 1);
    }
    return status;
}

void push_readings_free(struct push_readings *readings)
{
    free(readings->series);
    *readings = (struct push_readings){0};
}

/* ---- path ---- */

/* The sequence of forces in a test: where it turns, and the coefficients of each displacement: u_i
 * = u0 + sum over m of (a loading[i][m] + b unloading[i][m]) F_m. */
struct push_path {
    size_t count;
    /* index of the reading before the force first decreases; without a decrease, of the last
     * reading */
    size_t peak_reading;
    /* index of the last reading with the same force as `peak_reading`, within the gage's error */
    size_t plateau;
    size_t
        unloading_reading_count; /* number of readings after the magnitude of the force decreased */
    double loading[PUSH_READINGS_MAX][PUSH_READINGS_MAX];
    double unloading[PUSH_READINGS_MAX][PUSH_READINGS_MAX];
};

/* The force changes direction if two readings differ by more than this number of standard errors of
 * the gage: 3 sqrt 2, which two readings of equal forces exceed once in 40,000. */
#define TURN_MIN_STANDARD_ERRORS 4.2

/* Finds, for each reading, the direction in which the force changed before it: 1 or -1. */
static void find_force_directions(struct push_path *path, const struct push_series *series,
                                  double turn_lb, int *direction)
{
    const double *force = series->force_lb;
    size_t n = series->count, first = 0, extreme = 0;
    bool turned = false;
    while (first + 1 < n && fabs(force[first] - force[0]) <= turn_lb)
        first++;
    int way = force[first] < force[0] ? -1 : 1;
    for (size_t i = 0; i < n; i++) {
        double ahead = (force[i] - force[extreme]) * way;
        direction[i] = way;
        if (ahead >= 0.0)
            extreme = i;
        if (ahead >= -turn_lb)
            continue;
        if (!turned) {
            path->peak_reading = extreme;
            path->plateau = i - 1;
        }
        turned = true;
        way = -way;
        for (size_t k = extreme + 1; k <= i; k++)
            direction[k] = way;
        extreme = i;
    }
    if (!turned) {
        path->peak_reading = extreme;
        path->plateau = n - 1;
    }
}

/* Adds the change of force from the previous reading to F_i. */
static void add_path_step(struct push_path *path, const struct push_series *series, double turn_lb,
                          int direction, size_t i)
{
    double to = series->force_lb[i], from = i > 0 ? series->force_lb[i - 1] : 0.0;
    bool through_0 = from * to < 0.0 && fabs(from) > turn_lb && fabs(to) > turn_lb;
    double side = fabs(to) > fabs(from) ? to : from;
    bool grows = i == 0 || direction * side >= 0.0;
    if (i > 0) {
        memcpy(path->loading[i], path->loading[i - 1], sizeof path->loading[i]);
        memcpy(path->unloading[i], path->unloading[i - 1], sizeof path->unloading[i]);
        (through_0 || !grows ? path->unloading : path->loading)[i][i - 1] -= 1.0;
    }
    (through_0 || grows ? path->loading : path->unloading)[i][i] += 1.0;
    path->unloading_reading_count += !grows || through_0;
}

/* Computes the path. The force changes direction if it goes back by more than the error of its
 * gage; smaller steps back are ignored. Returns false if no force of the series exceeds the gage's
 * error. */
static bool compute_path(struct push_path *path, const struct push_series *series,
                         double force_error_lb)
{
    int direction[PUSH_READINGS_MAX];
    double turn_lb = TURN_MIN_STANDARD_ERRORS * force_error_lb, most_lb = 0.0;
    *path = (struct push_path){.count = series->count};
    for (size_t i = 0; i < series->count; i++)
        most_lb = fmax(most_lb, fabs(series->force_lb[i]));
    if (series->count == 0 || !(most_lb > turn_lb))
        return false;
    find_force_directions(path, series, turn_lb, direction);
    for (size_t i = 0; i < series->count; i++)
        add_path_step(path, series, turn_lb, direction[i], i);
    return true;
}

/* ---- fit ---- */

#define Z_95                  1.96
#define ITERATIONS_MAX        40
#define CHI_SQUARE_TOLERANCE  1e-7 /* change of chi-square at which the iteration ends */
/* prior standard error of a free offset, as a multiple of the range of the readings */
#define OFFSET_PRIOR_RANGES   100.0
#define GRID_K_POINTS         41
/* an interval of K with a ratio of its ends below this may lie between two grid points */
#define NARROW_INTERVAL_RATIO 1.3
#define GRID_RHO_POINTS       11
/* largest number of readings before `peak_reading` that are tried as sliding */
#define SLIDE_READINGS_MAX    20u
#define SLIDE_CHI_SQUARE_MAX  25.0 /* largest chi-square per reading of the forces during a slide */

/* A range of readings during which the mat slid. A candidate is accepted if its chi-square is below
 * `threshold`. */
struct slide {
    size_t from, to;
    double a, b, chi_square, threshold;
};

/* Prepared data of a test, from which chi2 for any (a, b) needs one matrix decomposition. */
struct fit_work {
    const struct push_series *series;
    struct push_errors gage_errors;
    struct push_path path;
    size_t slide_first,
        slide_last; /* range of readings during which the mat slid; from > to: none */
    double offset_prior_variance, slide_gain;
    /* `loading` and `unloading` multiplied by the measured forces */
    double loading_lb[PUSH_READINGS_MAX], unloading_lb[PUSH_READINGS_MAX];
    /* products: loading loading', loading unloading' and unloading unloading' */
    double loading_product[PUSH_READINGS_MAX][PUSH_READINGS_MAX];
    double mixed_product[PUSH_READINGS_MAX][PUSH_READINGS_MAX],
        unloading_product[PUSH_READINGS_MAX][PUSH_READINGS_MAX];
    double covariance[PUSH_READINGS_MAX][PUSH_READINGS_MAX], residual[PUSH_READINGS_MAX];
};

static void prepare_fit(struct fit_work *w)
{
    const struct push_series *series = w->series;
    const struct push_path *path = &w->path;
    size_t n = path->count;
    double low = series->displacement_in[0], high = low;
    for (size_t i = 0; i < n; i++) {
        low = fmin(low, series->displacement_in[i]);
        high = fmax(high, series->displacement_in[i]);
        w->loading_lb[i] = w->unloading_lb[i] = 0.0;
        for (size_t m = 0; m < n; m++) {
            w->loading_lb[i] += path->loading[i][m] * series->force_lb[m];
            w->unloading_lb[i] += path->unloading[i][m] * series->force_lb[m];
        }
        for (size_t k = 0; k <= i; k++) {
            double gg = 0.0, gf = 0.0, ff = 0.0;
            for (size_t m = 0; m < n; m++) {
                gg += path->loading[i][m] * path->loading[k][m];
                gf += path->loading[i][m] * path->unloading[k][m] +
                      path->unloading[i][m] * path->loading[k][m];
                ff += path->unloading[i][m] * path->unloading[k][m];
            }
            w->loading_product[i][k] = gg;
            w->mixed_product[i][k] = gf;
            w->unloading_product[i][k] = ff;
        }
    }
    double free_in = OFFSET_PRIOR_RANGES * (high - low + 10.0 * w->gage_errors.displacement_in);
    w->offset_prior_variance = free_in * free_in;
}

/* Decomposes V = L L' in place, lower half. The diagonal makes V positive definite. */
static void cholesky_decompose(struct fit_work *w, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k <= i; k++) {
            double sum = w->covariance[i][k];
            for (size_t m = 0; m < k; m++)
                sum -= w->covariance[i][m] * w->covariance[k][m];
            w->covariance[i][k] = i == k ? sqrt(fmax(sum, 1e-300)) : sum / w->covariance[k][k];
        }
    }
}

static bool has_slid(const struct fit_work *w)
{
    return w->slide_first <= w->slide_last;
}

/* True if two readings share a free offset in addition to u0. Each sliding reading has an offset of
 * its own; all later readings share that of the last one. */
static bool is_offset_shared(const struct fit_work *w, size_t i, size_t k)
{
    return has_slid(w) && k >= w->slide_first &&
           (i == k || (i >= w->slide_last && k >= w->slide_last));
}

static double compute_chi_square(struct fit_work *w, double a, double b)
{
    size_t n = w->path.count;
    double force2 = w->gage_errors.force_lb * w->gage_errors.force_lb,
           moved2 = w->gage_errors.displacement_in * w->gage_errors.displacement_in, sum = 0.0;
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k <= i; k++) {
            w->covariance[i][k] = force2 * (a * a * w->loading_product[i][k] +
                                            a * b * w->mixed_product[i][k] +
                                            b * b * w->unloading_product[i][k]) +
                                  w->offset_prior_variance + (i == k ? moved2 : 0.0);
            if (is_offset_shared(w, i, k))
                w->covariance[i][k] += w->offset_prior_variance;
        }
        w->residual[i] = w->series->displacement_in[i] - w->series->displacement_in[0] -
                         a * w->loading_lb[i] - b * w->unloading_lb[i];
    }
    cholesky_decompose(w, n);
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++)
            w->residual[i] -= w->covariance[i][k] * w->residual[k];
        w->residual[i] /= w->covariance[i][i];
        sum += w->residual[i] * w->residual[i];
    }
    return sum;
}

/* Computes the chi2 of the forces during a slide, which must all equal the same limit. */
static double compute_slide_chi_square(const struct fit_work *w, double *limit_lb)
{
    double sum = 0.0, squares = 0.0, count = (double)(w->slide_last + 1 - w->slide_first);
    for (size_t i = w->slide_first; i <= w->slide_last; i++)
        sum += w->series->force_lb[i];
    *limit_lb = sum / count;
    for (size_t i = w->slide_first; i <= w->slide_last; i++)
        squares += pow((w->series->force_lb[i] - *limit_lb) / w->gage_errors.force_lb, 2.0);
    return squares;
}

/* Computes chi2 with one parameter fixed. `which` 0: a is fixed and b free; 1: rho is fixed and a
 * free. */
static double compute_chi_square_with_fixed(struct fit_work *w, int which, double fixed,
                                            double free)
{
    return which == 0 ? compute_chi_square(w, fixed, free)
                      : compute_chi_square(w, free, fixed * free);
}

/* Finds the least chi2 over the free parameter, by Newton's method on a curve close to a parabola.
 * *at: the start, then the minimum. */
static double minimize_over_free_parameter(struct fit_work *w, int which, double fixed, double *at,
                                           double scale)
{
    double best = compute_chi_square_with_fixed(w, which, fixed, *at);
    if (w->path.unloading_reading_count == 0 && which == 0)
        return best;
    for (int step = 0; step < ITERATIONS_MAX; step++) {
        double up = compute_chi_square_with_fixed(w, which, fixed, *at + scale),
               down = compute_chi_square_with_fixed(w, which, fixed, *at - scale);
        double slope = (up - down) / (2.0 * scale), bend = (up - 2.0 * best + down) / scale / scale;
        double move = bend > 0.0 ? -slope / bend : -copysign(scale, slope), next = (double)NAN;
        for (int halved = 0; halved < 20; halved++, move *= 0.5) {
            next = compute_chi_square_with_fixed(w, which, fixed, *at + move);
            if (next <= best)
                break;
        }
        if (!(next <= best))
            break;
        double gain = best - next;
        *at += move;
        best = next;
        if (gain < CHI_SQUARE_TOLERANCE)
            break;
    }
    return best;
}

/* Fits a and b together. Returns chi2. */
static double fit_compliances(struct fit_work *w, double *a, double *b, double scale)
{
    double best = HUGE_VAL;
    for (int step = 0; step < ITERATIONS_MAX; step++) {
        double rho = *a > 0.0 ? *b / *a : 1.0;
        /* two alternating steps (b with a fixed, then a with rho fixed) converge faster than either
         * alone */
        if (w->path.unloading_reading_count > 0)
            minimize_over_free_parameter(w, 0, *a, b, scale);
        rho = *a != 0.0 ? *b / *a : rho;
        double now = minimize_over_free_parameter(w, 1, rho, a, scale);
        *b = rho * *a;
        if (best - now < CHI_SQUARE_TOLERANCE)
            return fmin(best, now);
        best = now;
    }
    return best;
}

/* Finds the distance from `at` at which chi2, minimised over the other parameter, has risen by q^2;
 * INFINITY: it has not within `most`. */
static double find_interval_distance(struct fit_work *w, int which, double at, double other,
                                     double best, double q, double step, double most, double scale)
{
    double near = 0.0, near_root = 0.0, far = step, root = 0.0;
    for (int tries = 0; tries < ITERATIONS_MAX; tries++) {
        double from = other;
        root =
            sqrt(fmax(0.0, minimize_over_free_parameter(w, which, at + far, &from, scale) - best));
        if (root >= q || fabs(far) >= most)
            break;
        near = far;
        near_root = root;
        far *= root > 0.2 * q ? 1.05 * q / root : 2.0;
        if (fabs(far) > most)
            far = copysign(most, far);
    }
    if (root < q)
        return (double)INFINITY;
    for (int tries = 0; tries < ITERATIONS_MAX && fabs(root - q) > 1e-4; tries++) {
        double guess = near + (far - near) * (q - near_root) / (root - near_root), from = other;
        double at_guess = sqrt(
            fmax(0.0, minimize_over_free_parameter(w, which, at + guess, &from, scale) - best));
        if (at_guess < q) {
            near = guess;
            near_root = at_guess;
        } else {
            far = guess;
            root = at_guess;
        }
        if (fabs(at_guess - q) < 1e-4)
            return fabs(guess);
    }
    return fabs(far);
}

/* Tries a slide of readings `from` to `to`, and stores it if its chi2 is the best so far. */
static void try_slide(struct fit_work *w, bool elastic, size_t from, size_t to, double scale,
                      struct slide *best)
{
    double way = (w->series->displacement_in[to] - w->series->displacement_in[from - 1]) *
                 w->series->force_lb[to];
    double limit_lb, a = best->a, b = best->b;
    w->slide_first = from;
    w->slide_last = to;
    double now = compute_slide_chi_square(w, &limit_lb);
    if (now > SLIDE_CHI_SQUARE_MAX * (double)(to + 1 - from) || !(way > 0.0))
        return;
    now += elastic ? fit_compliances(w, &a, &b, scale) : compute_chi_square(w, 0.0, 0.0);
    if (now < best->threshold)
        *best = (struct slide){from, to, a, b, now, now};
}

/* Finds the readings during which the mat slid: a range that ends at `peak_reading`, or none if no
 * range reduces chi2 enough. `elastic`: a and b are fitted, from their present values; otherwise
 * both are 0. Returns chi2 including that of the forces. */
static double find_slide(struct fit_work *w, bool elastic, double *a, double *b, double scale)
{
    struct slide best = {w->path.count, 0, *a, *b, 0.0, 0.0};
    w->slide_first = best.from;
    w->slide_last = best.to;
    best.chi_square = elastic ? fit_compliances(w, &best.a, &best.b, scale)
                              : compute_chi_square(w, 0.0, 0.0);
    best.threshold = best.chi_square - w->slide_gain;
    size_t first = w->path.peak_reading > SLIDE_READINGS_MAX
                     ? w->path.peak_reading - SLIDE_READINGS_MAX
                     : 1;
    for (size_t to = w->path.peak_reading; to <= w->path.plateau; to++) {
        for (size_t from = to; from >= first && from >= 1; from--)
            try_slide(w, elastic, from, to, scale, &best);
    }
    w->slide_first = best.from;
    w->slide_last = best.to;
    *a = best.a;
    *b = best.b;
    return best.chi_square;
}

/* Computes the log odds as a sum over a grid, for readings with little information. */
static double compute_grid_log_odds(struct fit_work *w, const struct push_fit *fit, double force,
                                    double expected_lb_in, double stretch2)
{
    double logs[GRID_K_POINTS * GRID_RHO_POINTS], sum = 0.0, most = -HUGE_VAL;
    size_t count = 0;
    for (int i = 0; i < GRID_K_POINTS; i++) {
        double k = expected_lb_in *
                   pow(10.0, PUSH_PRIOR_DECADES * (2.0 * i / (GRID_K_POINTS - 1.0) - 1.0));
        for (int j = 0; j < (w->path.unloading_reading_count > 0 ? GRID_RHO_POINTS : 1); j++) {
            double now = force + compute_chi_square(w, 1.0 / k, j / (GRID_RHO_POINTS - 1.0) / k);
            logs[count] = -0.5 * (now - fit->rigid_chi_square) / stretch2;
            most = fmax(most, logs[count++]);
        }
    }
    for (size_t i = 0; i < count; i++)
        sum += exp(logs[i] - most) / (double)count;
    return most + log(sum);
}

/* Computes the log odds from the parabola at the best fit, for readings with much information: the
 * likelihood at the best fit times the share of the prior under the parabola. */
static double compute_peak_log_odds(const struct push_fit *fit, double stretch2)
{
    double width = 2.0 * PUSH_PRIOR_DECADES * log(10.0);
    double of_k = log(fit->k_lb_in.high / fit->k_lb_in.low) / (2.0 * Z_95);
    double of_rho = fit->unloading_count > 0
                      ? (fit->unloading_ratio.high - fit->unloading_ratio.low) / (2.0 * Z_95)
                      : 1.0;
    return -0.5 * (fit->chi_square - fit->rigid_chi_square) / stretch2 +
           log(fmin(1.0, sqrt(2.0 * M_PI) * of_k / width)) +
           log(fmin(1.0, fit->unloading_count > 0 ? sqrt(2.0 * M_PI) * of_rho : 1.0));
}

/* Returns the logarithm of the odds of the elastic law against the rigid one (marginal
 * likelihoods). */
static double compute_log_odds(struct fit_work *w, const struct push_fit *fit, double force,
                               double expected_lb_in, double stretch2)
{
    const struct push_interval *k = &fit->k_lb_in;
    double decades = fabs(log10(k->value / expected_lb_in));
    bool is_determined = isfinite(k->high) && decades < PUSH_PRIOR_DECADES;
    if (is_determined && k->high < NARROW_INTERVAL_RATIO * k->low)
        return compute_peak_log_odds(fit, stretch2);
    double grid = compute_grid_log_odds(w, fit, force, expected_lb_in, stretch2);
    return is_determined ? fmax(grid, compute_peak_log_odds(fit, stretch2)) : grid;
}

static void find_intervals(struct fit_work *w, double a, double b, double best, double force,
                           double q, double scale, struct push_fit *fit)
{
    double least_chi = best - force, rho = b / a, step = q * scale;
    double up = find_interval_distance(w, 0, a, b, least_chi, q, step, HUGE_VAL, scale);
    double down = a > 0.0 ? find_interval_distance(w, 0, a, b, least_chi, q, -step, a, scale)
                          : (double)INFINITY;
    bool is_determined = down < a;
    fit->k_lb_in = (struct push_interval){is_determined ? 1.0 / a : (double)NAN, 1.0 / (a + up),
                                          is_determined ? 1.0 / (a - down) : (double)INFINITY};
    fit->unloading_ratio = (struct push_interval){(double)NAN, -(double)INFINITY, (double)INFINITY};
    if (!is_determined || w->path.unloading_reading_count == 0)
        return;
    fit->unloading_ratio.value = rho;
    fit->unloading_ratio.high = rho + find_interval_distance(w, 1, rho, a, least_chi, q, 0.05,
                                                             100.0, scale);
    fit->unloading_ratio.low = rho - find_interval_distance(w, 1, rho, a, least_chi, q, -0.05,
                                                            100.0, scale);
}

static void fit_series(struct fit_work *w, double expected_lb_in, double stretch,
                       struct push_fit *fit)
{
    size_t n = w->path.count, top = w->path.peak_reading;
    double most_lb = 0.0, a, b, none = 0.0;
    for (size_t i = 0; i < n; i++)
        most_lb = fmax(most_lb, fabs(w->series->force_lb[i]));
    /* smallest compliance that can be detected at the largest force */
    double scale = 0.3 * w->gage_errors.displacement_in / most_lb;
    a = fmax(scale,
             fabs(w->series->displacement_in[top] - w->series->displacement_in[0]) / most_lb);
    b = w->path.unloading_reading_count > 0 ? a : 0.0;
    prepare_fit(w);
    w->slide_gain = PUSH_SLIDE_GAIN_MIN * stretch * stretch;
    *fit = (struct push_fit){.slide_force_lb = (double)NAN, .max_force_lb = most_lb};
    fit->unloading_count = w->path.unloading_reading_count;
    fit->rigid_chi_square = find_slide(w, false, &none, &none, scale);
    fit->chi_square = find_slide(w, true, &a, &b, scale);
    fit->first_sliding_reading = w->slide_first;
    double force = has_slid(w) ? compute_slide_chi_square(w, &fit->slide_force_lb) : 0.0;
    fit->slid_count = has_slid(w) ? w->slide_last + 1 - w->slide_first : 0;
    size_t parameters = 2u + (w->path.unloading_reading_count > 0 ? 1u : 0u) +
                        (has_slid(w) ? 1u : 0u);
    fit->degrees_of_freedom = n > parameters ? n - parameters : 0;
    find_intervals(w, a, b, fit->chi_square, force, Z_95 * stretch, scale, fit);
    fit->log_odds = compute_log_odds(w, fit, force, expected_lb_in, stretch * stretch);
    double sum = 0.0;
    size_t before = has_slid(w) ? w->slide_first : n;
    for (size_t i = 0; i < before; i++)
        sum += w->series->displacement_in[i] - a * w->loading_lb[i] - b * w->unloading_lb[i];
    fit->dial_zero_in = sum / (double)before;
}

enum mr_status push_fit(const struct push_series *series, struct push_errors gages,
                        double expected_lb_in, double stretch, struct push_fit *fit,
                        struct error *error)
{
    if (series->count < PUSH_READINGS_MIN)
        return error_set(error, MR_TOO_FEW,
                         "too few readings: %s: test %s under %.4g lb has %zu; read at %u forces "
                         "or more, while loading and unloading",
                         series->path, series->name, series->load_lb, series->count,
                         PUSH_READINGS_MIN);
    struct fit_work *w = xcalloc(1, sizeof *w);
    w->series = series;
    w->gage_errors = gages;
    if (!compute_path(&w->path, series, gages.force_lb))
        error_set(
            error, MR_TOO_FEW,
            "all forces are below their error: %s: test %s under %.4g lb: the error of the gage is "
            "%.3g lb; push harder, or give the correct error of the gage (--force-error)",
            series->path, series->name, series->load_lb, gages.force_lb);
    else
        fit_series(w, expected_lb_in, stretch, fit);
    free(w);
    return error->status;
}

void push_fit_curve(const struct push_series *series, struct push_errors gages,
                    const struct push_fit *fit, double *displacement_in)
{
    struct push_path *path = xmalloc(sizeof *path);
    bool is_determined = !isnan(fit->k_lb_in.value);
    double a = 1.0 / (is_determined ? fit->k_lb_in.value : fit->k_lb_in.low), shift_in = 0.0,
           b = isnan(fit->unloading_ratio.value) ? a : fit->unloading_ratio.value * a;
    bool made = compute_path(path, series, gages.force_lb);
    for (size_t i = 0; i < series->count; i++) {
        double sum = 0.0;
        for (size_t m = 0; made && m <= i; m++)
            sum += (a * path->loading[i][m] + b * path->unloading[i][m]) * series->force_lb[m];
        if (made && fit->slid_count > 0 && i >= fit->first_sliding_reading &&
            i < fit->first_sliding_reading + fit->slid_count)
            shift_in = series->displacement_in[i] - fit->dial_zero_in - sum;
        displacement_in[i] = made ? fit->dial_zero_in + sum + shift_in : (double)NAN;
    }
    free(path);
}
