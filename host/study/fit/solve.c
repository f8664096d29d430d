#include "host/study/fit/solve.h"

#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <math.h>
#include <string.h>

#define STEPS_MAX 300
#define TOLERANCE 1e-7

typedef double square[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];

bool solve_cholesky(size_t n, square matrix, square factor)
{
    memset(factor, 0, sizeof(square));
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k <= i; k++) {
            double rest = matrix[i][k];
            for (size_t j = 0; j < k; j++)
                rest -= factor[i][j] * factor[k][j];
            if (i == k && !(rest > 0.0))
                return false;
            factor[i][k] = i == k ? sqrt(rest) : rest / factor[k][k];
        }
    }
    return true;
}

/* Inverse of a lower triangle. */
static void invert_lower(size_t n, square lower, square inverse)
{
    memset(inverse, 0, sizeof(square));
    for (size_t c = 0; c < n; c++) {
        for (size_t r = c; r < n; r++) {
            double rest = r == c ? 1.0 : 0.0;
            for (size_t j = c; j < r; j++)
                rest -= lower[r][j] * inverse[j][c];
            inverse[r][c] = rest / lower[r][r];
        }
    }
}

bool solve_begin(struct solve *solve, const struct surface *surface,
                 const struct ensemble_place *place)
{
    size_t q = surface->parameters;
    square covariance, lower;
    double middle[FIT_PARAMETERS_MAX] = {0.0};
    *solve = (struct solve){.surface = surface, .place = place};
    double share = 1.0 + surface_leverage(surface, middle);
    for (size_t i = 0; i < q; i++) {
        for (size_t k = 0; k < q; k++)
            covariance[i][k] = share * gsl_matrix_get(surface->covariance, i, k);
    }
    if (!solve_cholesky(q, covariance, lower))
        return false;
    invert_lower(q, lower, solve->root);
    return true;
}

/* The surface, straight beyond where it was simulated: value and slopes at the nearest place
 * inside, and on along them. Those slopes change with what is inside still; as they are linear in
 * w, that is the slope at w itself. */
static void expected(const struct solve *solve, const double *w, double *score, double *slope)
{
    size_t q = solve->surface->parameters;
    double inside[FIT_PARAMETERS_MAX] = {0.0}, there[FIT_PARAMETERS_MAX],
           beyond[FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX];
    for (size_t i = 0; i < q; i++)
        inside[i] = fmax(-SOLVE_STRAIGHT, fmin(SOLVE_STRAIGHT, w[i]));
    surface_at(solve->surface, inside, score, slope);
    if (memcmp(inside, w, q * sizeof *w) == 0)
        return;
    surface_at(solve->surface, w, there, beyond);
    for (size_t s = 0; s < q; s++) {
        for (size_t i = 0; i < q; i++)
            score[s] += slope[s * q + i] * (w[i] - inside[i]);
        for (size_t i = 0; i < q; i++)
            slope[s * q + i] = fabs(w[i]) < SOLVE_STRAIGHT ? beyond[s * q + i] : slope[s * q + i];
    }
}

void solve_residual(const struct solve *solve, const double *w, double *residual, double *slope)
{
    size_t q = solve->surface->parameters;
    double score[FIT_PARAMETERS_MAX], change[FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX],
        z[FIT_PARAMETERS_MAX];
    expected(solve, w, score, change);
    ensemble_at(solve->place, w, z);
    for (size_t r = 0; r < q; r++) {
        residual[r] = 0.0;
        for (size_t s = 0; s <= r; s++)
            residual[r] += solve->root[r][s] * (score[s] - solve->score[s]);
        residual[q + r] = z[r] - solve->prior[r];
        for (size_t i = 0; i < q; i++) {
            double sum = 0.0;
            for (size_t s = 0; s <= r; s++)
                sum += solve->root[r][s] * change[s * q + i];
            slope[r * q + i] = sum;
            slope[(q + r) * q + i] = solve->place->spread[r][i];
        }
    }
}

static int residual_of(const gsl_vector *w, void *context, gsl_vector *f)
{
    double slope[2 * FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX];
    solve_residual(context, w->data, f->data, slope);
    return GSL_SUCCESS;
}

static int slope_of(const gsl_vector *w, void *context, gsl_matrix *jacobian)
{
    double residual[2 * FIT_PARAMETERS_MAX], slope[2 * FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX];
    solve_residual(context, w->data, residual, slope);
    gsl_matrix_const_view view = gsl_matrix_const_view_array(slope, jacobian->size1,
                                                             jacobian->size2);
    gsl_matrix_memcpy(jacobian, &view.matrix);
    return GSL_SUCCESS;
}

double solve_least(const struct solve *solve, double *w)
{
    size_t q = solve->surface->parameters;
    gsl_multifit_nlinear_parameters how = gsl_multifit_nlinear_default_parameters();
    gsl_multifit_nlinear_workspace *work = gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust,
                                                                      &how, 2 * q, q);
    if (!work)
        return (double)NAN;
    struct solve copy = *solve;
    gsl_multifit_nlinear_fdf fdf = {
        .f = residual_of, .df = slope_of, .n = 2 * q, .p = q, .params = &copy};
    gsl_vector_const_view start = gsl_vector_const_view_array(w, q);
    int info = 0;
    int status = gsl_multifit_nlinear_init(&start.vector, &fdf, work);
    if (status == GSL_SUCCESS)
        status = gsl_multifit_nlinear_driver(STEPS_MAX, TOLERANCE, TOLERANCE, TOLERANCE, NULL, NULL,
                                             &info, work);
    double squares = 0.0;
    /* No further progress at machine precision is where it was to go. */
    if (status == GSL_SUCCESS || status == GSL_ENOPROG) {
        const gsl_vector *least = gsl_multifit_nlinear_position(work),
                         *f = gsl_multifit_nlinear_residual(work);
        for (size_t i = 0; i < q; i++)
            w[i] = gsl_vector_get(least, i);
        for (size_t i = 0; i < f->size; i++)
            squares += gsl_vector_get(f, i) * gsl_vector_get(f, i);
    } else {
        squares = (double)NAN;
    }
    gsl_multifit_nlinear_free(work);
    return squares;
}

void solve_information(const struct solve *solve, const double *w, square information)
{
    size_t q = solve->surface->parameters;
    double residual[2 * FIT_PARAMETERS_MAX], slope[2 * FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX];
    square lower, inverse, by_z;
    solve_residual(solve, w, residual, slope);
    memcpy(lower, solve->place->spread, sizeof lower);
    invert_lower(q, lower, inverse);
    for (size_t r = 0; r < q; r++) {
        for (size_t i = 0; i < q; i++) {
            by_z[r][i] = 0.0;
            for (size_t k = 0; k < q; k++)
                by_z[r][i] += slope[r * q + k] * inverse[k][i];
        }
    }
    for (size_t i = 0; i < q; i++) {
        for (size_t k = 0; k < q; k++) {
            information[i][k] = 0.0;
            for (size_t r = 0; r < q; r++)
                information[i][k] += by_z[r][i] * by_z[r][k];
        }
    }
}

void solve_covariance(size_t parameters, square information, square covariance)
{
    square sum, lower, inverse;
    for (size_t i = 0; i < parameters; i++) {
        for (size_t k = 0; k < parameters; k++)
            sum[i][k] = information[i][k] + (i == k ? 1.0 : 0.0);
    }
    memset(covariance, 0, sizeof(square));
    if (!solve_cholesky(parameters, sum, lower))
        return;
    invert_lower(parameters, lower, inverse);
    for (size_t i = 0; i < parameters; i++) {
        for (size_t k = 0; k < parameters; k++) {
            for (size_t j = 0; j < parameters; j++)
                covariance[i][k] += inverse[j][i] * inverse[j][k];
        }
    }
}
