#include "host/study/fit/surface.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

size_t surface_terms(size_t parameters)
{
    return 1 + parameters + parameters * (parameters + 1) / 2;
}

static void set_terms(size_t q, const double *w, double *term)
{
    size_t n = 0;
    term[n++] = 1.0;
    for (size_t i = 0; i < q; i++)
        term[n++] = w[i];
    for (size_t i = 0; i < q; i++) {
        for (size_t k = i; k < q; k++)
            term[n++] = w[i] * w[k];
    }
}

void surface_at(const struct surface *surface, const double *w, double *statistic, double *slope)
{
    size_t q = surface->parameters, p = surface->statistics;
    double term[SURFACE_TERMS_MAX];
    set_terms(q, w, term);
    for (size_t s = 0; s < p; s++)
        statistic[s] = 0.0;
    for (size_t n = 0; n < surface->terms; n++) {
        const double *factor = gsl_matrix_const_ptr(surface->factor, n, 0);
        for (size_t s = 0; s < p; s++)
            statistic[s] += term[n] * factor[s];
    }
    for (size_t i = 0; slope && i < q; i++) {
        const double *factor = gsl_matrix_const_ptr(surface->factor, 1 + i, 0);
        for (size_t s = 0; s < p; s++)
            slope[s * q + i] = factor[s];
    }
    size_t n = 1 + q;
    for (size_t i = 0; slope && i < q; i++) {
        for (size_t k = i; k < q; k++, n++) {
            const double *factor = gsl_matrix_const_ptr(surface->factor, n, 0);
            for (size_t s = 0; s < p; s++) {
                slope[s * q + i] += factor[s] * w[k];
                slope[s * q + k] += factor[s] * w[i];
            }
        }
    }
}

double surface_leverage(const struct surface *surface, const double *w)
{
    double term[SURFACE_TERMS_MAX], sum = 0.0;
    set_terms(surface->parameters, w, term);
    for (size_t i = 0; i < surface->terms; i++) {
        for (size_t k = 0; k < surface->terms; k++)
            sum += term[i] * gsl_matrix_get(surface->spread, i, k) * term[k];
    }
    return sum;
}

/* (X'X)^-1 into spread, X'X by its Cholesky factor. False: the design leaves a term
 * undetermined. */
static bool invert_normal(const gsl_matrix *design, gsl_matrix *spread)
{
    gsl_blas_dsyrk(CblasLower, CblasTrans, 1.0, design, 0.0, spread);
    for (size_t i = 0; i < spread->size1; i++) {
        for (size_t k = i + 1; k < spread->size1; k++)
            gsl_matrix_set(spread, i, k, gsl_matrix_get(spread, k, i));
    }
    return gsl_linalg_cholesky_decomp1(spread) == 0 && gsl_linalg_cholesky_invert(spread) == 0;
}

static void set_departures(const struct ensemble *ensemble, const gsl_matrix *design,
                           struct surface *surface)
{
    size_t q = surface->parameters, p = surface->statistics;
    gsl_matrix_const_view data = gsl_matrix_const_view_array(ensemble->statistic, surface->draws,
                                                             p);
    gsl_matrix_memcpy(surface->departure, &data.matrix);
    gsl_blas_dgemm(CblasNoTrans, CblasNoTrans, -1.0, design, surface->factor, 1.0,
                   surface->departure);
    gsl_blas_dsyrk(CblasLower, CblasTrans, 1.0 / (double)(surface->draws - surface->terms),
                   surface->departure, 0.0, surface->covariance);
    for (size_t i = 0; i < p; i++) {
        for (size_t k = i + 1; k < p; k++)
            gsl_matrix_set(surface->covariance, i, k, gsl_matrix_get(surface->covariance, k, i));
    }
    for (size_t i = 0; i < surface->draws; i++) {
        double leverage = fmin(surface_leverage(surface, ensemble->w + i * q), 0.999);
        gsl_vector_view row = gsl_matrix_row(surface->departure, i);
        gsl_vector_scale(&row.vector, 1.0 / sqrt(1.0 - leverage));
    }
}

enum mr_status surface_make(const struct ensemble *ensemble, struct surface *surface,
                            struct error *error)
{
    size_t q = ensemble->parameters, p = ensemble->statistics, n = ensemble->draws,
           k = surface_terms(q);
    *surface = (struct surface){.parameters = q, .statistics = p, .terms = k, .draws = n};
    if (n <= 2 * k)
        return error_set(
            error, MR_TOO_FEW,
            "too few simulated data sets: %zu for a surface of %zu terms; use more than %zu draws",
            n, k, 2 * k);
    surface->factor = gsl_matrix_alloc(k, p);
    surface->departure = gsl_matrix_alloc(n, p);
    surface->covariance = gsl_matrix_alloc(p, p);
    surface->spread = gsl_matrix_alloc(k, k);
    gsl_matrix *design = gsl_matrix_alloc(n, k), *moment = gsl_matrix_alloc(k, p);
    if (!surface->factor || !surface->departure || !surface->covariance || !surface->spread ||
        !design || !moment) {
        error_set(error, MR_FULL, "no memory: surface of %zu statistics; use fewer landings", p);
    } else {
        gsl_matrix_const_view data = gsl_matrix_const_view_array(ensemble->statistic, n, p);
        for (size_t i = 0; i < n; i++)
            set_terms(q, ensemble->w + i * q, gsl_matrix_ptr(design, i, 0));
        if (!invert_normal(design, surface->spread)) {
            error_set(error, MR_NUMERICS,
                      "the surface is not determined: %zu draws; use more draws", n);
        } else {
            gsl_blas_dgemm(CblasTrans, CblasNoTrans, 1.0, design, &data.matrix, 0.0, moment);
            gsl_blas_dgemm(CblasNoTrans, CblasNoTrans, 1.0, surface->spread, moment, 0.0,
                           surface->factor);
            set_departures(ensemble, design, surface);
        }
    }
    gsl_matrix_free(design);
    gsl_matrix_free(moment);
    return error->status;
}

void surface_free(struct surface *surface)
{
    gsl_matrix_free(surface->factor);
    gsl_matrix_free(surface->departure);
    gsl_matrix_free(surface->covariance);
    gsl_matrix_free(surface->spread);
    *surface = (struct surface){0};
}

double surface_shrink(const gsl_matrix *departure, gsl_matrix *covariance)
{
    size_t n = departure->size1, p = departure->size2;
    double scatter = 0.0, squares = 0.0;
    for (size_t i = 0; i < p; i++) {
        for (size_t k = 0; k < i; k++) {
            double si = gsl_matrix_get(covariance, i, i), sk = gsl_matrix_get(covariance, k, k),
                   sum = 0.0, square = 0.0;
            if (!(si > 0.0) || !(sk > 0.0))
                continue;
            for (size_t d = 0; d < n; d++) {
                double product = gsl_matrix_get(departure, d, i) * gsl_matrix_get(departure, d, k) /
                                 sqrt(si * sk);
                sum += product;
                square += product * product;
            }
            double mean = sum / (double)n;
            scatter += (square / (double)n - mean * mean) / (double)(n - 1);
            squares += mean * mean;
        }
    }
    double weight = squares > 0.0 ? fmin(1.0, fmax(0.0, scatter / squares)) : 1.0;
    for (size_t i = 0; i < p; i++) {
        for (size_t k = 0; k < p; k++) {
            if (i != k)
                gsl_matrix_set(covariance, i, k, (1.0 - weight) * gsl_matrix_get(covariance, i, k));
        }
    }
    return weight;
}

enum mr_status surface_combine(const struct ensemble *ensemble, const gsl_matrix *weight,
                               struct ensemble *combined, struct error *error)
{
    size_t q = ensemble->parameters, n = ensemble->draws, to = weight->size2;
    *combined = (struct ensemble){
        .draws = n, .parameters = q, .statistics = to, .failed = ensemble->failed};
    combined->w = calloc(n * q, sizeof(double));
    combined->statistic = calloc(n * to, sizeof(double));
    if (!combined->w || !combined->statistic)
        return error_set(error, MR_FULL, "no memory: scores of %zu data sets; use fewer draws", n);
    memcpy(combined->w, ensemble->w, n * q * sizeof(double));
    gsl_matrix_const_view from = gsl_matrix_const_view_array(ensemble->statistic, n,
                                                             ensemble->statistics);
    gsl_matrix_view to_view = gsl_matrix_view_array(combined->statistic, n, to);
    gsl_blas_dgemm(CblasNoTrans, CblasNoTrans, 1.0, &from.matrix, weight, 0.0, &to_view.matrix);
    return MR_OK;
}
