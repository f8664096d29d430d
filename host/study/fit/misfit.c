#include "host/study/fit/misfit.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_sort.h>
#include <gsl/gsl_statistics.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
#include "host/study/fit/fit.h"

/* ---- replicas ---- */

#define REPLICAS 99u /* rank of the measured one among 100 */

/* What is left of a data set once it is fitted. False: that fit does not converge. */
static bool leave(const struct replicas *r, const struct fit_answer *answer,
                  const double *statistic, double *residual)
{
    struct solve solve = *r->solve;
    size_t q = r->model->parameters, p = r->model->statistics;
    double w[FIT_PARAMETERS_MAX] = {0.0};
    for (size_t i = 0; i < q; i++) {
        solve.score[i] = 0.0;
        for (size_t s = 0; s < p; s++)
            solve.score[i] += gsl_matrix_get(r->weight, s, i) * statistic[s];
    }
    if (isnan(solve_least(&solve, w)))
        return false;
    for (size_t i = 0; i < q; i++)
        w[i] = fmax(-SOLVE_STRAIGHT, fmin(SOLVE_STRAIGHT, w[i]));
    surface_at(r->surface, w, residual, NULL);
    for (size_t s = 0; s < p; s++)
        residual[s] = answer->scatter[s] > 0.0 ? (statistic[s] - residual[s]) / answer->scatter[s]
                                               : 0.0;
    return true;
}

static void keep(const struct replicas *r, const struct ensemble *ensemble,
                 struct fit_answer *answer)
{
    size_t p = r->model->statistics;
    answer->residual = xcalloc((1 + ensemble->draws) * p, sizeof *answer->residual);
    if (!leave(r, answer, r->measured, answer->residual))
        return;
    for (size_t i = 0; i < ensemble->draws; i++)
        answer->replicas += leave(r, answer, ensemble->statistic + i * p,
                                  answer->residual + (1 + answer->replicas) * p);
}

enum mr_status replicas_make(const struct replicas *r, struct fit_answer *answer,
                             struct error *error)
{
    struct fit_options options = *r->options;
    struct ensemble_place place = {.parameters = answer->parameters, .normal = true};
    struct ensemble ensemble;
    options.draws = options.replicas ? options.replicas : REPLICAS;
    memcpy(place.middle, answer->z, sizeof place.middle);
    if (!solve_cholesky(answer->parameters, answer->covariance, place.spread))
        return MR_OK;
    if (ensemble_make(r->model, &place, &options, answer->rounds, r->until_s, &ensemble, error) ==
        MR_OK) {
        answer->simulated += ensemble.draws + ensemble.failed;
        keep(r, &ensemble, answer);
    } else if (error->status == MR_TIMEOUT || error->status == MR_NUMERICS) {
        *error = (struct error){0};
    }
    ensemble_free(&ensemble);
    return error->status;
}

/* ---- misfit ---- */

/* Squared Mahalanobis distance of each row of residuals. */
static void add_residuals(const struct fit_answer *answer, size_t rows, double *square)
{
    size_t p = answer->statistics;
    gsl_matrix *z = gsl_matrix_alloc(rows, p), *covariance = gsl_matrix_alloc(p, p);
    for (size_t s = 0; s < p; s++) {
        const double *column = answer->residual + s;
        double mean = gsl_stats_mean(column, p, rows), sd = gsl_stats_sd(column, p, rows);
        for (size_t i = 0; i < rows; i++)
            gsl_matrix_set(z, i, s, sd > 0.0 ? (column[i * p] - mean) / sd : 0.0);
    }
    gsl_blas_dgemm(CblasTrans, CblasNoTrans, 1.0 / (double)(rows - 1), z, z, 0.0, covariance);
    surface_shrink(z, covariance);
    for (size_t s = 0; s < p; s++) /* also a statistic that never changes */
        *gsl_matrix_ptr(covariance, s, s) += 1e-6;
    gsl_linalg_cholesky_decomp1(covariance);
    for (size_t i = 0; i < rows; i++) {
        gsl_vector_view row = gsl_matrix_row(z, i);
        gsl_blas_dtrsv(CblasLower, CblasNoTrans, CblasNonUnit, covariance, &row.vector);
        gsl_blas_ddot(&row.vector, &row.vector, &square[i]);
    }
    gsl_matrix_free(z);
    gsl_matrix_free(covariance);
}

/* Logarithm of the spread between segments; false: too few were surveyed. */
static bool spread_of(const double *sum_in, double *spread)
{
    double read[MR_SEGMENTS];
    size_t count = 0;
    for (size_t s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(sum_in[s]))
            read[count++] = sum_in[s];
    }
    *spread = count > 4 ? log(fmax(gsl_stats_sd(read, 1, count), 1e-9)) : 0.0;
    return count > 4;
}

/* A runway that nothing has rolled over: the sums that were read, and those that gaps laid as the
 * fit draws them would give. Later surveys do not show how the gaps were laid. */
static void add_survey(const struct fit_landings *list, uint64_t seed, size_t rows, double *square)
{
    const struct fit_landing *first = &list->landing[0];
    double sum_in[MR_SEGMENTS], *spread = xcalloc(2 * rows, sizeof *spread),
                                *sorted = spread + rows;
    if (!first->later && spread_of(first->survey_in, &spread[0])) {
        gsl_rng *random = gsl_rng_alloc(gsl_rng_taus2);
        gsl_rng_set(random, (unsigned long)(seed * 2654435761u + 17u) & 0xffffffffu);
        for (size_t i = 1; i < rows; i++) {
            fit_landings_lay(list, first, random, sum_in);
            spread_of(sum_in, &spread[i]);
        }
        gsl_rng_free(random);
        for (size_t i = 0; i < rows; i++)
            sorted[i] = spread[i];
        gsl_sort(sorted, 1, rows);
        double middle = gsl_stats_median_from_sorted_data(sorted, 1, rows),
               unit = gsl_stats_quantile_from_sorted_data(sorted, 1, rows, 0.8413) - middle;
        for (size_t i = 0; i < rows && unit > 0.0; i++)
            square[i] += pow(fmax(spread[i] - middle, 0.0) / unit, 2.0);
    }
    free(spread);
}

struct misfit misfit_check(const struct fit_landings *list, const struct fit_answer *answer,
                           uint64_t seed)
{
    size_t rows = 1 + answer->replicas, out = 0;
    struct misfit misfit = {.replicas = answer->replicas};
    if (answer->replicas < MISFIT_LEAST)
        return misfit;
    double *square = xcalloc(rows, sizeof *square);
    add_residuals(answer, rows, square);
    add_survey(list, seed, rows, square);
    for (size_t i = 0; i < rows; i++)
        out += square[i] >= square[0];
    free(square);
    misfit.checked = true;
    misfit.share = (double)out / (double)rows;
    misfit.cannot = misfit.share <= MISFIT_FALSE;
    return misfit;
}
