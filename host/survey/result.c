#include "host/survey/result.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

void survey_readings_init(struct survey_readings *readings)
{
    double *value = (double *)(void *)readings;
    for (size_t i = 0; i < offsetof(struct survey_readings, error_in) / sizeof *value; i++)
        value[i] = (double)NAN;
    readings->error_in = SURVEY_ERROR_IN;
}

double *survey_reading_at(struct survey_readings *r, const struct survey_item *item)
{
    unsigned l = item->line - 1, p = item->place;
    switch (item->kind) {
    case SURVEY_GAP: return &r->gap_in[l][p];
    case SURVEY_STATION: return &r->station_in[l][p];
    case SURVEY_ACROSS: return &r->across_in[l][p];
    default: return &r->diagonal_in[l][p];
    }
}

/* The normal equations of a line are tridiagonal: a span ties neighbours, a station the two points
 * around it. */
struct normal {
    double diagonal[SURVEY_POINTS], beside[SURVEY_POINTS - 1], right[SURVEY_POINTS];
};

/* Adds the observation a u(k) + b u(k+1) = value. */
static void observe(struct normal *n, unsigned k, double a, double b, double value, double error)
{
    double w = 1.0 / (error * error);
    n->diagonal[k] += w * a * a;
    n->right[k] += w * a * value;
    if (k + 1 < SURVEY_POINTS) {
        n->diagonal[k + 1] += w * b * b;
        n->beside[k] += w * a * b;
        n->right[k + 1] += w * b * value;
    }
}

/* Solution by elimination from both ends; where they meet at k, what is left of the diagonal is the
 * reciprocal variance there. */
static void solve(const struct normal *n, struct survey_estimate out[SURVEY_POINTS])
{
    double down[SURVEY_POINTS], up[SURVEY_POINTS], down_right[SURVEY_POINTS],
        up_right[SURVEY_POINTS];
    unsigned last = SURVEY_POINTS - 1;
    down[0] = n->diagonal[0];
    down_right[0] = n->right[0];
    for (unsigned k = 1; k <= last; k++) {
        double factor = n->beside[k - 1] / down[k - 1];
        down[k] = n->diagonal[k] - factor * n->beside[k - 1];
        down_right[k] = n->right[k] - factor * down_right[k - 1];
    }
    up[last] = n->diagonal[last];
    up_right[last] = n->right[last];
    for (unsigned k = last; k-- > 0;) {
        double factor = n->beside[k] / up[k + 1];
        up[k] = n->diagonal[k] - factor * n->beside[k];
        up_right[k] = n->right[k] - factor * up_right[k + 1];
    }
    for (unsigned k = 0; k <= last; k++) {
        double pivot = down[k] + up[k] - n->diagonal[k];
        out[k].value_in = (down_right[k] + up_right[k] - n->right[k]) / pivot;
        out[k].error_in = sqrt(1.0 / pivot);
    }
}

/* `anchor`: u of the first point when the line has no stations. False: nothing was read of it. */
static bool move_line(const struct survey_change *c, unsigned line,
                      const struct survey_estimate *anchor,
                      struct survey_estimate moved[SURVEY_POINTS])
{
    struct normal n = {{0}, {0}, {0}};
    /* evenly spread over what the joints can do */
    const double unknown_in = SURVEY_SPAN_CHANGE_IN / sqrt(3.0);
    unsigned gaps = 0, stations = 0;
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        double change_in = c->change.gap_in[line][k];
        gaps += isnan(change_in) ? 0u : 1u;
        observe(&n, k, -1.0, 1.0, isnan(change_in) ? 0.0 : change_in,
                isnan(change_in) ? unknown_in : c->change.error_in);
    }
    for (unsigned s = 0; s < SURVEY_STATIONS; s++) {
        double change_in = c->change.station_in[line][s];
        double at = SURVEY_STATION_FT * s / SURVEY_SPAN_FT;
        unsigned k = (unsigned)fmin(floor(at + 1e-6), SURVEY_POINTS - 1.0);
        if (isnan(change_in))
            continue;
        stations++;
        observe(&n, k, 1.0 - (at - k), at - k, change_in, c->station_error_in);
    }
    if (stations == 0)
        observe(&n, 0, 1.0, 0.0, anchor->value_in, fmax(anchor->error_in, 1e-6));
    solve(&n, moved);
    return gaps + stations > 0;
}

static struct survey_estimate bow_of(const struct survey_change *c, unsigned point)
{
    struct survey_estimate bow = {(double)NAN, (double)NAN};
    const struct survey_estimate left = c->moved[0][point],
                                 right = c->moved[SURVEY_LINES - 1][point];
    for (unsigned line = 1; line + 1 < SURVEY_LINES; line++) {
        double part = (survey_line_in(line + 1) - survey_line_in(1)) /
                      (survey_line_in(SURVEY_LINES) - survey_line_in(1));
        const struct survey_estimate here = c->moved[line][point];
        double away_in = here.value_in - (1.0 - part) * left.value_in - part * right.value_in;
        if (isnan(away_in) || fabs(away_in) <= fabs(bow.value_in)) /* false for the first */
            continue;
        bow.value_in = away_in;
        bow.error_in = sqrt(here.error_in * here.error_in + pow((1.0 - part) * left.error_in, 2) +
                            pow(part * right.error_in, 2));
    }
    return bow;
}

static void subtract(const struct survey_readings *now, const struct survey_readings *before,
                     struct survey_change *c)
{
    const double *a = (const double *)(const void *)now, *b = (const double *)(const void *)before;
    double *d = (double *)(void *)&c->change;
    for (size_t i = 0; i < offsetof(struct survey_readings, error_in) / sizeof *d; i++) {
        d[i] = a[i] - b[i];
        c->compared += isnan(d[i]) ? 0u : 1u;
    }
    c->change.error_in = sqrt(now->error_in * now->error_in + before->error_in * before->error_in);
    c->station_error_in = sqrt(2.0) * SURVEY_STATION_ERROR_IN;
}

void survey_change(const struct survey_readings *now, const struct survey_readings *before,
                   struct survey_change *change)
{
    const struct survey_estimate held = {0.0, 0.0};
    memset(change, 0, sizeof *change);
    subtract(now, before, change);
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        const struct survey_estimate *anchor = line && !isnan(change->moved[0][0].value_in)
                                                 ? &change->moved[0][0]
                                                 : &held;
        if (move_line(change, line, anchor, change->moved[line]))
            continue;
        for (unsigned k = 0; k < SURVEY_POINTS; k++)
            change->moved[line][k] = (struct survey_estimate){(double)NAN, (double)NAN};
    }
    for (unsigned k = 0; k < SURVEY_POINTS; k++)
        change->bow[k] = bow_of(change, k);
}

void survey_slack(const struct survey_readings *now, double closed_in, struct survey_slack *slack)
{
    memset(slack, 0, sizeof *slack);
    for (unsigned k = 0; k < SURVEY_SPANS; k++) {
        double sum = 0.0, squares = 0.0;
        unsigned lines = 0;
        for (unsigned line = 0; line < SURVEY_LINES; line++) {
            double value_in = fmax(now->gap_in[line][k] - closed_in, 0.0);
            if (isnan(now->gap_in[line][k]))
                continue;
            lines++;
            sum += value_in;
            squares += value_in * value_in;
        }
        double mean = lines ? sum / lines : (double)NAN;
        /* of the readings, and of the lines' being different */
        double scatter = lines > 1
                           ? fmax(squares - lines * mean * mean, 0.0) / (lines - 1.0) / lines
                           : 0.0;
        slack->lines[k] = lines;
        slack->surveyed += lines > 0;
        slack->segment[k].value_in = mean;
        slack->segment[k].error_in = lines ? fmax(sqrt(scatter), now->error_in / sqrt(lines))
                                           : (double)NAN;
    }
}
