#include "host/advise/smoother.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"

/* What one pass works with: the readings that there are, `n` of them. */
struct work {
    size_t n;
    size_t *datum;       /* [n] their places */
    double *away;        /* [members][n] predicted less their mean */
    double *matrix;      /* [n][n], then its Cholesky factor */
    double *innovations; /* [members][n]; then the matrix's inverse times them */
    double *gain;        /* [n], a row: of one state */
    double *shift;       /* [members] */
};

static void get_memory(struct work *w, const struct smoother *s)
{
    size_t wide = s->data ? s->data : 1;
    *w = (struct work){
        .datum = xcalloc(wide, sizeof *w->datum),
        .away = xcalloc(s->members * wide, sizeof *w->away),
        .matrix = xcalloc(wide * wide, sizeof *w->matrix),
        .innovations = xcalloc(s->members * wide, sizeof *w->innovations),
        .gain = xcalloc(wide, sizeof *w->gain),
        .shift = xcalloc(s->members, sizeof *w->shift),
    };
}

static void free_memory(struct work *w)
{
    free(w->datum);
    free(w->away);
    free(w->matrix);
    free(w->innovations);
    free(w->gain);
    free(w->shift);
}

/* Covariance of what is predicted, the errors' variance added. */
static void fill_matrix(struct work *w, const struct smoother *s)
{
    for (size_t i = 0; i < w->n; i++) {
        double mean = 0.0, error = s->error[w->datum[i]];
        for (size_t m = 0; m < s->members; m++)
            mean += s->predicted[m * s->data + w->datum[i]] / (double)s->members;
        for (size_t m = 0; m < s->members; m++)
            w->away[m * w->n + i] = s->predicted[m * s->data + w->datum[i]] - mean;
        w->matrix[i * w->n + i] = s->passes * error * error;
    }
    for (size_t m = 0; m < s->members; m++) {
        const double *y = w->away + m * w->n;
        for (size_t i = 0; i < w->n; i++) {
            for (size_t k = 0; k <= i; k++)
                w->matrix[i * w->n + k] += y[i] * y[k] / (double)(s->members - 1);
        }
    }
}

/* The lower half becomes Cholesky's factor; the errors keep it positive. */
static void factor(struct work *w)
{
    double *a = w->matrix;
    size_t n = w->n;
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j <= i; j++) {
            double sum = a[i * n + j];
            for (size_t k = 0; k < j; k++)
                sum -= a[i * n + k] * a[j * n + k];
            a[i * n + j] = i == j ? sqrt(sum) : sum / a[j * n + j];
        }
    }
}

/* b becomes the inverse of the matrix times b. */
static void solve(const struct work *w, double *b)
{
    const double *a = w->matrix;
    size_t n = w->n;
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++)
            b[i] -= a[i * n + k] * b[k];
        b[i] /= a[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++)
            b[i] -= a[k * n + i] * b[k];
        b[i] /= a[i * n + i];
    }
}

/* Perturbed readings less what is predicted. The perturbations' mean is taken off: it would move
 * the whole ensemble by chance. */
static void innovate(struct work *w, const struct smoother *s, struct chance *chance)
{
    for (size_t i = 0; i < w->n; i++) {
        size_t d = w->datum[i];
        double mean = 0.0, error = sqrt(s->passes) * s->error[d];
        for (size_t m = 0; m < s->members; m++) {
            double z = chance_normal(chance);
            mean += z / (double)s->members;
            w->innovations[m * w->n + i] = z;
        }
        for (size_t m = 0; m < s->members; m++) {
            double *at = &w->innovations[m * w->n + i];
            *at = s->read[d] + error * (*at - mean) - s->predicted[m * s->data + d];
        }
    }
}

/* Moves one state of all members. The gain's row is (covariance with the readings) times the
 * inverse; the taper is of the gain, so a near reading's share does not go to a far one. */
static void move(struct work *w, const struct smoother *s, size_t state)
{
    double mean = 0.0;
    for (size_t m = 0; m < s->members; m++)
        mean += s->state[m * s->states + state] / (double)s->members;
    memset(w->gain, 0, w->n * sizeof *w->gain);
    for (size_t m = 0; m < s->members; m++) {
        double x = s->state[m * s->states + state] - mean;
        for (size_t i = 0; i < w->n; i++)
            w->gain[i] += x * w->away[m * w->n + i] / (double)(s->members - 1);
    }
    solve(w, w->gain);
    for (size_t i = 0; s->nearness && i < w->n; i++)
        w->gain[i] *= s->nearness(s->context, state, w->datum[i]);
    for (size_t m = 0; m < s->members; m++) {
        double shift = 0.0;
        for (size_t i = 0; i < w->n; i++)
            shift += w->gain[i] * w->innovations[m * w->n + i];
        w->shift[m] = shift;
    }
    for (size_t m = 0; m < s->members; m++)
        s->state[m * s->states + state] += w->shift[m];
}

bool smoother_take(const struct smoother *s, struct chance *chance)
{
    struct work w = {0};
    if (s->members < 2)
        return false;
    get_memory(&w, s);
    for (size_t d = 0; d < s->data; d++) {
        if (isfinite(s->read[d]))
            w.datum[w.n++] = d;
    }
    if (w.n) {
        fill_matrix(&w, s);
        factor(&w);
        innovate(&w, s, chance);
        for (size_t state = 0; state < s->states; state++)
            move(&w, s, state);
    }
    free_memory(&w);
    return true;
}

void smoother_spread(const double *state, size_t members, size_t states, size_t column,
                     double *mean, double *deviation)
{
    double sum = 0.0, squares = 0.0;
    for (size_t m = 0; m < members; m++)
        sum += state[m * states + column];
    *mean = sum / (double)members;
    for (size_t m = 0; m < members; m++) {
        double x = state[m * states + column] - *mean;
        squares += x * x;
    }
    *deviation = members > 1 ? sqrt(squares / (double)(members - 1)) : 0.0;
}

void smoother_widen(double *state, size_t members, size_t states, size_t column, double was,
                    double kept, double least)
{
    double mean, now;
    smoother_spread(state, members, states, column, &mean, &now);
    double wanted = fmax(now + kept * fmax(was - now, 0.0), least);
    for (size_t m = 0; now > 0.0 && m < members; m++) {
        double *x = &state[m * states + column];
        *x = mean + (*x - mean) * wanted / now;
    }
}

double smoother_taper(double distance, double half)
{
    double r = fabs(distance) / half;
    if (r < 1.0)
        return (((-0.25 * r + 0.5) * r + 0.625) * r - 5.0 / 3.0) * r * r + 1.0;
    if (r < 2.0)
        return ((((r / 12.0 - 0.5) * r + 0.625) * r + 5.0 / 3.0) * r - 5.0) * r + 4.0 -
               2.0 / (3.0 * r);
    return 0.0;
}
