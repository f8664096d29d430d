/* Figures of a misfit that are one number of a row's residuals, or of its survey. */
#include <gsl/gsl_rng.h>
#include <math.h>

#include "host/study/fit/misfit_parts.h"

#define CLOSED 3.0 /* errors of a sum: less is closed */

/* Mean square, largest and kurtosis of some statistics in a row; how many there are. */
static size_t moments(const struct checking *c, size_t row, bool sums, double *square,
                      double *fourth, double *largest, size_t *at)
{
    size_t count = 0;
    *square = *fourth = *largest = 0.0;
    for (size_t s = 0; s < c->statistics; s++) {
        double z = z_of(c, row, s);
        if (is_sum(c, s) != sums)
            continue;
        count++;
        *square += z * z;
        *fourth += z * z * z * z;
        if (fabs(z) > *largest) {
            *largest = fabs(z);
            *at = s;
        }
    }
    *square /= (double)(count > 0 ? count : 1);
    *fourth /= (double)(count > 0 ? count : 1);
    return count;
}

static void set_moments(struct checking *c, struct misfit *misfit)
{
    size_t n = c->rows;
    for (size_t i = n; i-- > 0;) { /* the measured row last: `where` is its */
        double square, fourth, largest;
        size_t at = SIZE_MAX, count = moments(c, i, false, &square, &fourth, &largest, &at);
        c->figure[MISFIT_SCATTER * n + i] = 0.5 * log(fmax(square, 1e-12));
        c->figure[MISFIT_LARGEST * n + i] = log(fmax(largest, 1e-12));
        c->figure[MISFIT_KURTOSIS * n + i] =
            log(fmax(fourth / fmax(square * square, 1e-24), 1e-12));
        misfit->found[MISFIT_LARGEST].where = misfit->found[MISFIT_KURTOSIS].where = at;
        misfit->found[MISFIT_SCATTER].known = misfit->found[MISFIT_LARGEST].known =
            misfit->found[MISFIT_KURTOSIS].known = count > 3;
        count = moments(c, i, true, &square, &fourth, &largest, &at);
        c->figure[MISFIT_SUMS * n + i] = 0.5 * log(fmax(square, 1e-12));
        c->figure[MISFIT_SUMS_LARGEST * n + i] = log(fmax(largest, 1e-12));
        misfit->found[MISFIT_SUMS_LARGEST].where = at;
        misfit->found[MISFIT_SUMS].known = misfit->found[MISFIT_SUMS_LARGEST].known = count > 3;
    }
}

/* Correlation of neighbours, by Fisher's transformation: a statistic and the next of the same kind,
 * stations being in order. */
static void set_neighbours(struct checking *c, struct misfit *misfit)
{
    size_t n = c->rows, pairs[2] = {0, 0};
    for (size_t i = 0; i < n; i++)
        c->figure[MISFIT_NEIGHBOURS * n + i] = c->figure[MISFIT_SUMS_ALONG * n + i] = 0.0;
    for (size_t s = 0; s < c->statistics; s++) {
        size_t next = s + 1;
        while (next < c->statistics &&
               !(is_sum(c, s) ? is_sum(c, next) && c->landing[s] == c->landing[next]
                              : misfit_alike(c, s, next)))
            next++;
        if (next == c->statistics)
            continue;
        enum misfit_figure figure = is_sum(c, s) ? MISFIT_SUMS_ALONG : MISFIT_NEIGHBOURS;
        pairs[is_sum(c, s)]++;
        for (size_t i = 0; i < n; i++)
            c->figure[figure * n + i] += z_of(c, i, s) * z_of(c, i, next);
    }
    for (size_t i = 0; i < n; i++) {
        for (int sums = 0; sums < 2; sums++) {
            double square, fourth, largest,
                *value = &c->figure[(sums ? MISFIT_SUMS_ALONG : MISFIT_NEIGHBOURS) * n + i];
            size_t at, count = moments(c, i, sums, &square, &fourth, &largest, &at);
            if (count > 0 && square > 0.0)
                *value = atanh(fmax(-0.99, fmin(0.99, *value / (square * (double)count))));
        }
    }
    misfit->found[MISFIT_NEIGHBOURS].known = pairs[0] > 2;
    misfit->found[MISFIT_SUMS_ALONG].known = pairs[1] > 2;
}

static double error_after_in(const struct checking *c, size_t s)
{
    return c->landing[s]->after_error_in > 0.0 ? c->landing[s]->after_error_in
                                               : c->list->survey_error_in;
}

static void set_closed(struct checking *c, struct misfit *misfit)
{
    size_t n = c->rows, sums = 0;
    for (size_t s = 0; s < c->statistics; s++)
        sums += is_sum(c, s);
    for (size_t i = 0; i < n; i++) {
        c->figure[MISFIT_CLOSED * n + i] = 0.0;
        for (size_t s = 0; s < c->statistics; s++)
            c->figure[MISFIT_CLOSED * n + i] += is_sum(c, s) &&
                                                c->answer->replica[i * c->statistics + s] <
                                                    CLOSED * error_after_in(c, s);
    }
    misfit->found[MISFIT_CLOSED].known = sums > 3;
}

/* ---- the survey before ---- */

/* Spread between segments, and mean product of neighbours over mean square. */
static size_t laid(const double *sum_in, double *spread, double *along)
{
    double mean = 0.0, square = 0.0, product = 0.0;
    size_t count = 0, pairs = 0;
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        if (isnan(sum_in[s]))
            continue;
        mean += sum_in[s];
        count++;
    }
    mean /= (double)(count > 0 ? count : 1);
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        if (isnan(sum_in[s]))
            continue;
        square += (sum_in[s] - mean) * (sum_in[s] - mean);
        if (s + 1 == MR_SEGMENTS || isnan(sum_in[s + 1]))
            continue;
        product += (sum_in[s] - mean) * (sum_in[s + 1] - mean);
        pairs++;
    }
    *spread = count > 1 ? 0.5 * log(fmax(square / (double)(count - 1), 1e-18)) : 0.0;
    *along = square > 0.0 && pairs > 0 ? product / square : 0.0;
    return pairs;
}

/* A runway that nothing has rolled over: what was read, and what would be if gaps were laid as the
 * fit draws them. Later ones are not as they were laid. */
static void set_laid(struct checking *c, uint64_t seed, struct misfit *misfit)
{
    const struct fit_landing *first = &c->list->landing[0];
    gsl_rng *random = first->later ? NULL : gsl_rng_alloc(gsl_rng_taus2);
    double sum_in[MR_SEGMENTS], *spread = c->figure + MISFIT_LAID * c->rows,
                                *along = c->figure + MISFIT_LAID_ALONG * c->rows;
    if (!random)
        return;
    gsl_rng_set(random, (unsigned long)(seed * 2654435761u + 17u) & 0xffffffffu);
    bool known = laid(first->survey_in, &spread[0], &along[0]) > 3;
    for (size_t i = 1; i < c->rows && known; i++) {
        fit_landings_lay(c->list, first, random, sum_in);
        laid(sum_in, &spread[i], &along[i]);
    }
    misfit->found[MISFIT_LAID].known = misfit->found[MISFIT_LAID_ALONG].known = known;
    gsl_rng_free(random);
}

void misfit_singles(struct checking *c, uint64_t seed, struct misfit *misfit)
{
    set_moments(c, misfit);
    set_neighbours(c, misfit);
    set_closed(c, misfit);
    set_laid(c, seed, misfit);
}
