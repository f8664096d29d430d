#include "host/study/fit/fit.h"
#include "host/base/xmalloc.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_multifit_nlinear.h>
#include <gsl/gsl_qrng.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <gsl/gsl_statistics.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/parallel_for.h"

/* ---- ensemble ---- */

#define MAX_FAILED_SHARE 0.1

struct sampling {
    const struct fit_model *model;
    const struct ensemble_region *region;
    const struct fit_options *options;
    struct ensemble *ensemble;
    unsigned round;
    bool *is_valid;
    atomic_size_t done_count;
};

/* Computes the parameters z from the position w in the region `region`. */
static void compute_parameters(const struct ensemble_region *region, const double *w, double *z)
{
    for (size_t i = 0; i < region->parameter_count; i++) {
        z[i] = region->middle[i];
        for (size_t k = 0; k <= i; k++)
            z[i] += region->spread[i][k] * w[k];
    }
}

/* Returns the number of a draw, which differs for every seed, round and index in the ensemble. */
static uint64_t draw_seed(const struct sampling *work, size_t i)
{
    uint64_t x = work->options->seed * 0x9E3779B97F4A7C15u + ((uint64_t)work->round << 40) + i + 1;
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
    x = (x ^ x >> 27) * 0x94D049BB133111EBu;
    return x ^ x >> 31;
}

static void simulate_rows(const struct sampling *work, size_t from, size_t count)
{
    const struct fit_model *model = work->model;
    struct ensemble *ensemble = work->ensemble;
    double z[FIT_BATCH_MAX * FIT_PARAMETERS_MAX];
    uint64_t draw[FIT_BATCH_MAX];
    for (size_t k = 0; k < count; k++) {
        compute_parameters(work->region, ensemble->w + (from + k) * ensemble->parameter_count,
                           z + k * ensemble->parameter_count);
        draw[k] = ensemble->draw_numbers[from + k] = draw_seed(work, from + k);
    }
    model->simulate(model->context, count, z, draw,
                    ensemble->statistic + from * ensemble->statistic_count, work->is_valid + from);
}

static void simulate_draws(void *context, size_t from, size_t every)
{
    struct sampling *work = context;
    const struct fit_options *options = work->options;
    size_t draws = work->ensemble->draw_count;
    for (size_t i = FIT_BATCH_MAX * from; i < draws; i += FIT_BATCH_MAX * every) {
        size_t count = draws - i < FIT_BATCH_MAX ? draws - i : FIT_BATCH_MAX;
        simulate_rows(work, i, count);
        size_t done = atomic_fetch_add(&work->done_count, count) + count;
        if (from == 0 && options->progress)
            options->progress(options->progress_context, work->round, done, draws);
    }
}

/* Allocates a matrix. Like xmalloc, ends the process if there is no memory. */
static gsl_matrix *new_matrix(size_t rows, size_t columns)
{
    gsl_matrix *matrix = gsl_matrix_alloc(rows, columns);
    if (!matrix)
        xmalloc(SIZE_MAX / 2);
    return matrix;
}

/* Draws Sobol points, which are evenly distributed. In each round they are shifted by a random
 * vector, modulo 1, so that rounds differ. */
static void draw_sobol_points(const struct sampling *work)
{
    struct ensemble *ensemble = work->ensemble;
    gsl_qrng *sequence = gsl_qrng_alloc(gsl_qrng_sobol, (unsigned)ensemble->parameter_count);
    for (size_t i = 0; i < ensemble->draw_count; i++) {
        double *w = ensemble->w + i * ensemble->parameter_count;
        gsl_qrng_get(sequence, w);
        for (size_t k = 0; k < ensemble->parameter_count; k++) {
            double shift = (double)(draw_seed(work, ((size_t)1 << 32) + k) >> 11) * 0x1p-53;
            double even = fmod(w[k] + shift, 1.0);
            w[k] = work->region->is_normal
                     ? gsl_cdf_ugaussian_Pinv(fmin(fmax(even, 1e-4), 1.0 - 1e-4))
                     : ENSEMBLE_HALF_WIDTH * (2.0 * even - 1.0);
        }
    }
    gsl_qrng_free(sequence);
}

/* Removes draws that failed or are not finite. */
static void remove_failed(struct ensemble *ensemble, const bool *good)
{
    size_t kept = 0, q = ensemble->parameter_count, p = ensemble->statistic_count;
    for (size_t i = 0; i < ensemble->draw_count; i++) {
        bool keep = good[i];
        for (size_t s = 0; s < p; s++)
            keep = keep && isfinite(ensemble->statistic[i * p + s]);
        if (!keep)
            continue;
        memmove(ensemble->w + kept * q, ensemble->w + i * q, q * sizeof(double));
        ensemble->draw_numbers[kept] = ensemble->draw_numbers[i];
        memmove(ensemble->statistic + kept * p, ensemble->statistic + i * p, p * sizeof(double));
        kept++;
    }
    ensemble->failed_draw_count = ensemble->draw_count - kept;
    ensemble->draw_count = kept;
}

enum mr_status ensemble_simulate(const struct fit_model *model,
                                 const struct ensemble_region *region,
                                 const struct fit_options *options, unsigned round,
                                 struct ensemble *ensemble, struct error *error)
{
    *ensemble = (struct ensemble){.draw_count = options->draw_count,
                                  .parameter_count = model->parameter_count,
                                  .statistic_count = model->statistic_count};
    ensemble->w = xcalloc(ensemble->draw_count * ensemble->parameter_count, sizeof(double));
    ensemble->statistic = xcalloc(ensemble->draw_count * ensemble->statistic_count, sizeof(double));
    ensemble->draw_numbers = xcalloc(ensemble->draw_count, sizeof *ensemble->draw_numbers);
    bool *good = xcalloc(ensemble->draw_count, sizeof *good);
    struct sampling work = {.model = model,
                            .region = region,
                            .options = options,
                            .ensemble = ensemble,
                            .round = round,
                            .is_valid = good};
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    draw_sobol_points(&work);
    parallel_for(options->thread_count ? options->thread_count
                 : processors > 1      ? (unsigned)processors
                                       : 1u,
                 simulate_draws, &work);
    remove_failed(ensemble, good);
    if ((double)ensemble->failed_draw_count > MAX_FAILED_SHARE * (double)options->draw_count)
        error_set(error, MR_NUMERICS,
                  "%zu of %zu simulations failed in round %u; narrow the priors, or check the "
                  "scene with matrig sim",
                  ensemble->failed_draw_count, options->draw_count, round + 1);
    free(good);
    return error->status;
}

void ensemble_free(struct ensemble *ensemble)
{
    free(ensemble->w);
    free(ensemble->statistic);
    free(ensemble->draw_numbers);
    *ensemble = (struct ensemble){0};
}

/* ---- surface ---- */

static size_t surface_term_count(size_t parameters)
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

void surface_evaluate(const struct surface *surface, const double *w, double *statistic,
                      double *slope)
{
    size_t q = surface->parameter_count, p = surface->statistic_count;
    double term[SURFACE_TERMS_MAX];
    set_terms(q, w, term);
    for (size_t s = 0; s < p; s++)
        statistic[s] = 0.0;
    for (size_t n = 0; n < surface->term_count; n++) {
        const double *factor = gsl_matrix_const_ptr(surface->coefficients, n, 0);
        for (size_t s = 0; s < p; s++)
            statistic[s] += term[n] * factor[s];
    }
    for (size_t i = 0; slope && i < q; i++) {
        const double *factor = gsl_matrix_const_ptr(surface->coefficients, 1 + i, 0);
        for (size_t s = 0; s < p; s++)
            slope[s * q + i] = factor[s];
    }
    size_t n = 1 + q;
    for (size_t i = 0; slope && i < q; i++) {
        for (size_t k = i; k < q; k++, n++) {
            const double *factor = gsl_matrix_const_ptr(surface->coefficients, n, 0);
            for (size_t s = 0; s < p; s++) {
                slope[s * q + i] += factor[s] * w[k];
                slope[s * q + k] += factor[s] * w[i];
            }
        }
    }
}

/* Returns the ratio of the variance of the surface's prediction at w to the variance of a data
 * set. */
static double surface_leverage(const struct surface *surface, const double *w)
{
    double term[SURFACE_TERMS_MAX], sum = 0.0;
    set_terms(surface->parameter_count, w, term);
    for (size_t i = 0; i < surface->term_count; i++) {
        for (size_t k = 0; k < surface->term_count; k++)
            sum += term[i] * gsl_matrix_get(surface->inverse_normal, i, k) * term[k];
    }
    return sum;
}

/* Computes spread = (X'X)^-1 from the Cholesky factor of X'X. Returns false if the design does not
 * determine all terms. */
static bool invert_normal(const gsl_matrix *design, gsl_matrix *spread)
{
    gsl_blas_dsyrk(CblasLower, CblasTrans, 1.0, design, 0.0, spread);
    for (size_t i = 0; i < spread->size1; i++) {
        for (size_t k = i + 1; k < spread->size1; k++)
            gsl_matrix_set(spread, i, k, gsl_matrix_get(spread, k, i));
    }
    return gsl_linalg_cholesky_decomp1(spread) == 0 && gsl_linalg_cholesky_invert(spread) == 0;
}

static void set_scaled_residuals(const struct ensemble *ensemble, const gsl_matrix *design,
                                 struct surface *surface)
{
    size_t q = surface->parameter_count, p = surface->statistic_count;
    gsl_matrix_const_view data = gsl_matrix_const_view_array(ensemble->statistic,
                                                             surface->draw_count, p);
    gsl_matrix_memcpy(surface->scaled_residuals, &data.matrix);
    gsl_blas_dgemm(CblasNoTrans, CblasNoTrans, -1.0, design, surface->coefficients, 1.0,
                   surface->scaled_residuals);
    gsl_blas_dsyrk(CblasLower, CblasTrans,
                   1.0 / (double)(surface->draw_count - surface->term_count),
                   surface->scaled_residuals, 0.0, surface->covariance);
    for (size_t i = 0; i < p; i++) {
        for (size_t k = i + 1; k < p; k++)
            gsl_matrix_set(surface->covariance, i, k, gsl_matrix_get(surface->covariance, k, i));
    }
    for (size_t i = 0; i < surface->draw_count; i++) {
        double leverage = fmin(surface_leverage(surface, ensemble->w + i * q), 0.999);
        gsl_vector_view row = gsl_matrix_row(surface->scaled_residuals, i);
        gsl_vector_scale(&row.vector, 1.0 / sqrt(1.0 - leverage));
    }
}

enum mr_status surface_make(const struct ensemble *ensemble, struct surface *surface,
                            struct error *error)
{
    size_t q = ensemble->parameter_count, p = ensemble->statistic_count, n = ensemble->draw_count,
           k = surface_term_count(q);
    *surface = (struct surface){
        .parameter_count = q, .statistic_count = p, .term_count = k, .draw_count = n};
    if (n <= 2 * k)
        return error_set(error, MR_TOO_FEW,
                         "too few simulated data sets: %zu for a response surface with %zu terms; "
                         "give more than %zu draws (--draws)",
                         n, k, 2 * k);
    surface->coefficients = new_matrix(k, p);
    surface->scaled_residuals = new_matrix(n, p);
    surface->covariance = new_matrix(p, p);
    surface->inverse_normal = new_matrix(k, k);
    gsl_matrix *design = new_matrix(n, k), *moment = new_matrix(k, p);
    gsl_matrix_const_view data = gsl_matrix_const_view_array(ensemble->statistic, n, p);
    for (size_t i = 0; i < n; i++)
        set_terms(q, ensemble->w + i * q, gsl_matrix_ptr(design, i, 0));
    if (!invert_normal(design, surface->inverse_normal)) {
        error_set(error, MR_NUMERICS,
                  "too few draws to determine the response surface: %zu; give more draws (--draws)",
                  n);
    } else {
        gsl_blas_dgemm(CblasTrans, CblasNoTrans, 1.0, design, &data.matrix, 0.0, moment);
        gsl_blas_dgemm(CblasNoTrans, CblasNoTrans, 1.0, surface->inverse_normal, moment, 0.0,
                       surface->coefficients);
        set_scaled_residuals(ensemble, design, surface);
    }
    gsl_matrix_free(design);
    gsl_matrix_free(moment);
    return error->status;
}

void surface_free(struct surface *surface)
{
    gsl_matrix_free(surface->coefficients);
    gsl_matrix_free(surface->scaled_residuals);
    gsl_matrix_free(surface->covariance);
    gsl_matrix_free(surface->inverse_normal);
    *surface = (struct surface){0};
}

double surface_shrink(const gsl_matrix *departure, gsl_matrix *covariance)
{
    size_t n = departure->size1, p = departure->size2;
    double scatter = 0.0, squares = 0.0;
    for (size_t i = 0; i < p; i++) {
        for (size_t k = 0; k < i; k++) {
            double si = gsl_matrix_get(covariance, i, i), sk = gsl_matrix_get(covariance, k, k),
                   sum = 0.0, parameter_matrix = 0.0;
            if (!(si > 0.0) || !(sk > 0.0))
                continue;
            for (size_t d = 0; d < n; d++) {
                double product = gsl_matrix_get(departure, d, i) * gsl_matrix_get(departure, d, k) /
                                 sqrt(si * sk);
                sum += product;
                parameter_matrix += product * product;
            }
            double mean = sum / (double)n;
            scatter += (parameter_matrix / (double)n - mean * mean) / (double)(n - 1);
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

void surface_combine(const struct ensemble *ensemble, const gsl_matrix *weight,
                     struct ensemble *combined)
{
    size_t q = ensemble->parameter_count, n = ensemble->draw_count, to = weight->size2;
    *combined = (struct ensemble){.draw_count = n,
                                  .parameter_count = q,
                                  .statistic_count = to,
                                  .failed_draw_count = ensemble->failed_draw_count};
    combined->w = xcalloc(n * q, sizeof(double));
    combined->statistic = xcalloc(n * to, sizeof(double));
    memcpy(combined->w, ensemble->w, n * q * sizeof(double));
    gsl_matrix_const_view from = gsl_matrix_const_view_array(ensemble->statistic, n,
                                                             ensemble->statistic_count);
    gsl_matrix_view to_view = gsl_matrix_view_array(combined->statistic, n, to);
    gsl_blas_dgemm(CblasNoTrans, CblasNoTrans, 1.0, &from.matrix, weight, 0.0, &to_view.matrix);
}

/* ---- solve ---- */

#define SOLVER_STEPS_MAX 300
#define SOLVER_TOLERANCE 1e-7

typedef double parameter_matrix[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];

bool solve_cholesky(size_t n, parameter_matrix matrix, parameter_matrix factor)
{
    memset(factor, 0, sizeof(parameter_matrix));
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

/* Inverts a lower triangular matrix. */
static void invert_lower(size_t n, parameter_matrix lower, parameter_matrix inverse)
{
    memset(inverse, 0, sizeof(parameter_matrix));
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
                 const struct ensemble_region *region)
{
    size_t q = surface->parameter_count;
    parameter_matrix covariance, lower;
    double middle[FIT_PARAMETERS_MAX] = {0.0};
    *solve = (struct solve){.surface = surface, .region = region};
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

/* Computes value and slopes of the surface at w. Outside the simulated range the surface is
 * continued linearly from the nearest point inside. The slopes with respect to parameters inside
 * the range are evaluated at w. */
static void compute_expected_score(const struct solve *solve, const double *w, double *score,
                                   double *slope)
{
    size_t q = solve->surface->parameter_count;
    double inside[FIT_PARAMETERS_MAX] = {0.0}, there[FIT_PARAMETERS_MAX],
           beyond[FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX];
    for (size_t i = 0; i < q; i++)
        inside[i] = fmax(-SOLVE_LINEAR_FROM, fmin(SOLVE_LINEAR_FROM, w[i]));
    surface_evaluate(solve->surface, inside, score, slope);
    if (memcmp(inside, w, q * sizeof *w) == 0)
        return;
    surface_evaluate(solve->surface, w, there, beyond);
    for (size_t s = 0; s < q; s++) {
        for (size_t i = 0; i < q; i++)
            score[s] += slope[s * q + i] * (w[i] - inside[i]);
        for (size_t i = 0; i < q; i++)
            slope[s * q + i] = fabs(w[i]) < SOLVE_LINEAR_FROM ? beyond[s * q + i]
                                                              : slope[s * q + i];
    }
}

void solve_residual(const struct solve *solve, const double *w, double *residual, double *slope)
{
    size_t q = solve->surface->parameter_count;
    double score[FIT_PARAMETERS_MAX], change[FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX],
        z[FIT_PARAMETERS_MAX];
    compute_expected_score(solve, w, score, change);
    compute_parameters(solve->region, w, z);
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
            slope[(q + r) * q + i] = solve->region->spread[r][i];
        }
    }
}

static int residual_callback(const gsl_vector *w, void *context, gsl_vector *f)
{
    double slope[2 * FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX];
    solve_residual(context, w->data, f->data, slope);
    return GSL_SUCCESS;
}

static int slope_callback(const gsl_vector *w, void *context, gsl_matrix *jacobian)
{
    double residual[2 * FIT_PARAMETERS_MAX], slope[2 * FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX];
    solve_residual(context, w->data, residual, slope);
    gsl_matrix_const_view view = gsl_matrix_const_view_array(slope, jacobian->size1,
                                                             jacobian->size2);
    gsl_matrix_memcpy(jacobian, &view.matrix);
    return GSL_SUCCESS;
}

double solve_least_squares(const struct solve *solve, double *w)
{
    size_t q = solve->surface->parameter_count;
    gsl_multifit_nlinear_parameters how = gsl_multifit_nlinear_default_parameters();
    gsl_multifit_nlinear_workspace *work = gsl_multifit_nlinear_alloc(gsl_multifit_nlinear_trust,
                                                                      &how, 2 * q, q);
    if (!work)
        return (double)NAN;
    struct solve copy = *solve;
    gsl_multifit_nlinear_fdf fdf = {
        .f = residual_callback, .df = slope_callback, .n = 2 * q, .p = q, .params = &copy};
    gsl_vector_const_view start = gsl_vector_const_view_array(w, q);
    int info = 0;
    int status = gsl_multifit_nlinear_init(&start.vector, &fdf, work);
    if (status == GSL_SUCCESS)
        status = gsl_multifit_nlinear_driver(SOLVER_STEPS_MAX, SOLVER_TOLERANCE, SOLVER_TOLERANCE,
                                             SOLVER_TOLERANCE, NULL, NULL, &info, work);
    double squares = 0.0;
    /* GSL_ENOPROG means that the step is below machine precision, which also happens at the
     * minimum. */
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

void solve_information(const struct solve *solve, const double *w, parameter_matrix information)
{
    size_t q = solve->surface->parameter_count;
    double residual[2 * FIT_PARAMETERS_MAX], slope[2 * FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX];
    parameter_matrix lower, inverse, by_z;
    solve_residual(solve, w, residual, slope);
    memcpy(lower, solve->region->spread, sizeof lower);
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

/* Computes covariance = (information + priors)^-1. */
static void solve_covariance(size_t parameters, parameter_matrix information,
                             parameter_matrix covariance)
{
    parameter_matrix sum, lower, inverse;
    for (size_t i = 0; i < parameters; i++) {
        for (size_t k = 0; k < parameters; k++)
            sum[i][k] = information[i][k] + (i == k ? 1.0 : 0.0);
    }
    memset(covariance, 0, sizeof(parameter_matrix));
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

/* ---- fit ---- */

#define DEFAULT_DRAWS      300u
#define DEFAULT_REPLICAS   99u /* 100 data sets together with the measured one */
/* Standard deviation of the next ensemble's parameters, in standard errors of the estimate. */
#define ENSEMBLE_WIDTH     1.3
/* The search ends when the estimate is within this distance of the middle of its ensemble. Unit:
 * standard deviation of the ensemble's parameters (w in fit.h). */
#define CONVERGED_STEP_MAX 1.2
#define BOOTSTRAP_REFITS   640u /* approximate number of bootstrap refits */
#define W_MAX              (1.2 * ENSEMBLE_HALF_WIDTH)

struct fitting {
    const struct fit_model *model;
    const double *measured;
    struct fit_options options;
    struct ensemble_region region; /* the region of the next ensemble */
    gsl_matrix *score_weights;     /* statistics x parameters: weights of the scores */
    /* Cholesky factor of the correlation matrix of the statistics, whose standard deviations are in
     * `statistic_scales` */
    gsl_matrix *correlation_factor;
    double *statistic_scales;
    struct fit_result *result;
};

/* Sets `metric` and `scale`. A statistic that never varies gets an infinite scale and therefore no
 * weight. */
static enum mr_status set_correlation_factor(struct fitting *fitting, struct surface *surface,
                                             struct error *error)
{
    size_t p = surface->statistic_count;
    surface_shrink(surface->scaled_residuals, surface->covariance);
    gsl_matrix_memcpy(fitting->correlation_factor, surface->covariance);
    for (size_t i = 0; i < p; i++) {
        double variance = gsl_matrix_get(surface->covariance, i, i);
        fitting->statistic_scales[i] = variance > 0.0 ? sqrt(variance) : (double)INFINITY;
    }
    for (size_t i = 0; i < p; i++) {
        for (size_t k = 0; k < p; k++) {
            double correlation = i == k ? 1.0
                                        : gsl_matrix_get(surface->covariance, i, k) /
                                              fitting->statistic_scales[i] /
                                              fitting->statistic_scales[k];
            gsl_matrix_set(fitting->correlation_factor, i, k, correlation);
        }
    }
    if (gsl_linalg_cholesky_decomp1(fitting->correlation_factor) != 0)
        return error_set(
            error, MR_NUMERICS,
            "the covariance of the %zu statistics is singular; give more draws (--draws)", p);
    return MR_OK;
}

/* Sets the weights with which statistics are combined to scores: the slopes of the statistics times
 * the inverse of the metric. */
static void set_score_weights(struct fitting *fitting, const struct surface *surface)
{
    size_t p = surface->statistic_count, q = surface->parameter_count;
    for (size_t i = 0; i < q; i++) {
        gsl_vector_view column = gsl_matrix_column(fitting->score_weights, i);
        for (size_t s = 0; s < p; s++)
            gsl_vector_set(&column.vector, s,
                           gsl_matrix_get(surface->coefficients, 1 + i, s) /
                               fitting->statistic_scales[s]);
        gsl_linalg_cholesky_svx(fitting->correlation_factor, &column.vector);
        for (size_t s = 0; s < p; s++)
            gsl_vector_set(&column.vector, s,
                           gsl_vector_get(&column.vector, s) / fitting->statistic_scales[s]);
    }
}

static void compute_score(const struct fitting *fitting, const double *statistic, double *score)
{
    for (size_t i = 0; i < fitting->model->parameter_count; i++) {
        score[i] = 0.0;
        for (size_t s = 0; s < fitting->model->statistic_count; s++)
            score[i] += gsl_matrix_get(fitting->score_weights, s, i) * statistic[s];
    }
}

/* Sets the region of the next ensemble. The region is centred at w, and its width is proportional
 * to the uncertainty of the estimate. */
static void set_next_region(struct fitting *fitting, const double *w,
                            double covariance[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX])
{
    struct ensemble_region next = {.parameter_count = fitting->region.parameter_count};
    double inside[FIT_PARAMETERS_MAX], lower[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];
    for (size_t i = 0; i < next.parameter_count; i++)
        inside[i] = fmax(-W_MAX, fmin(W_MAX, w[i]));
    compute_parameters(&fitting->region, inside, next.middle);
    if (!solve_cholesky(next.parameter_count, covariance, lower))
        return;
    for (size_t i = 0; i < next.parameter_count; i++) {
        for (size_t k = 0; k <= i; k++)
            next.spread[i][k] = ENSEMBLE_WIDTH * lower[i][k];
    }
    fitting->region = next;
}

/* Estimates w from the scores of one ensemble. The caller frees solve->surface. */
static enum mr_status estimate_w(struct fitting *fitting, const struct ensemble *ensemble,
                                 struct surface *scores, struct solve *solve, double *w,
                                 struct error *error)
{
    struct ensemble combined;
    surface_combine(ensemble, fitting->score_weights, &combined);
    surface_make(&combined, scores, error);
    ensemble_free(&combined);
    if (error->status != MR_OK)
        return error->status;
    if (!solve_begin(solve, scores, &fitting->region))
        return error_set(error, MR_NUMERICS,
                         "a parameter has no effect on the measurements, so the scores are "
                         "singular; fit fewer parameters");
    compute_score(fitting, fitting->measured, solve->score);
    memset(w, 0, fitting->model->parameter_count * sizeof *w);
    if (isnan(solve_least_squares(solve, w)))
        return error_set(error, MR_NUMERICS,
                         "the fit of %zu parameters does not converge; narrow the priors, or fit "
                         "fewer parameters",
                         fitting->model->parameter_count);
    return MR_OK;
}

static double max_coordinate(const double *w, size_t count)
{
    double most = 0.0;
    for (size_t i = 0; i < count; i++)
        most = fmax(most, fabs(w[i]));
    return most;
}

static enum mr_status draw_ensemble(struct fitting *fitting, struct ensemble *ensemble,
                                    struct error *error)
{
    struct fit_result *answer = fitting->result;
    enum mr_status status = ensemble_simulate(fitting->model, &fitting->region, &fitting->options,
                                              answer->round_count, ensemble, error);
    if (status == MR_OK) {
        answer->round_count++;
        answer->simulated_draw_count += ensemble->draw_count + ensemble->failed_draw_count;
        answer->failed_draw_count += ensemble->failed_draw_count;
    }
    return status;
}

static enum mr_status choose_scores(struct fitting *fitting, const struct ensemble *ensemble,
                                    struct error *error)
{
    struct surface surface;
    if (surface_make(ensemble, &surface, error) == MR_OK &&
        set_correlation_factor(fitting, &surface, error) == MR_OK)
        set_score_weights(fitting, &surface);
    surface_free(&surface);
    return error->status;
}

/* Does one round of the search: estimate, new scores, new region. Scores seem better than they are
 * when they are used with the ensemble from which they were chosen. Therefore every round except
 * the first uses the scores that the previous round chose. */
static enum mr_status run_round(struct fitting *fitting, double *moved, struct error *error)
{
    struct ensemble ensemble;
    struct surface scores = {0};
    struct solve solve;
    double w[FIT_PARAMETERS_MAX], information[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX],
        covariance[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];
    bool first = fitting->result->round_count == 0;
    if (draw_ensemble(fitting, &ensemble, error) == MR_OK &&
        (!first || choose_scores(fitting, &ensemble, error) == MR_OK) &&
        estimate_w(fitting, &ensemble, &scores, &solve, w, error) == MR_OK &&
        (first || choose_scores(fitting, &ensemble, error) == MR_OK)) {
        solve_information(&solve, w, information);
        solve_covariance(fitting->model->parameter_count, information, covariance);
        *moved = max_coordinate(w, fitting->model->parameter_count);
        set_next_region(fitting, w, covariance);
    }
    surface_free(&scores);
    ensemble_free(&ensemble);
    return error->status;
}

/* Estimates the bias by bootstrap: repeats the fit with each departure (residual about the surface)
 * of the ensemble in place of the measured one, and with randomly drawn priors. Writes one row of
 * parameters per refit, refitted minus true value. Returns the number of rows. */
static size_t bootstrap_refits(const struct fitting *fitting, const struct solve *solve,
                               const double *w, double *error_z)
{
    const struct surface *surface = solve->surface;
    size_t q = surface->parameter_count, count = 0,
           times = (BOOTSTRAP_REFITS + surface->draw_count - 1) / surface->draw_count;
    double score[FIT_PARAMETERS_MAX], slope[FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX],
        z[FIT_PARAMETERS_MAX], again_z[FIT_PARAMETERS_MAX];
    double scale = sqrt(1.0 + surface_leverage(surface, w));
    gsl_rng *random = gsl_rng_alloc(gsl_rng_taus2);
    gsl_rng_set(random, (unsigned long)(fitting->options.seed + 1));
    surface_evaluate(surface, w, score, slope);
    compute_parameters(solve->region, w, z);
    for (size_t i = 0; i < times * surface->draw_count; i++) {
        struct solve again = *solve;
        double again_w[FIT_PARAMETERS_MAX];
        for (size_t k = 0; k < q; k++) {
            again.score[k] = score[k] + scale * gsl_matrix_get(surface->scaled_residuals,
                                                               i % surface->draw_count, k);
            again.prior[k] = z[k] + gsl_ran_gaussian_ziggurat(random, 1.0);
        }
        memcpy(again_w, w, q * sizeof *w);
        if (isnan(solve_least_squares(&again, again_w)))
            continue;
        compute_parameters(solve->region, again_w, again_z);
        for (size_t k = 0; k < q; k++)
            error_z[count * q + k] = again_z[k] - z[k];
        count++;
    }
    gsl_rng_free(random);
    return count;
}

static enum mr_status set_intervals(const struct fitting *fitting, const struct solve *solve,
                                    const double *w, struct error *error)
{
    struct fit_result *answer = fitting->result;
    size_t q = answer->parameter_count, rows = (BOOTSTRAP_REFITS + solve->surface->draw_count) * q;
    double *error_z = xcalloc(rows, sizeof *error_z);
    double within = gsl_cdf_tdist_Pinv(
        0.975, (double)(solve->surface->draw_count - solve->surface->term_count));
    size_t count = bootstrap_refits(fitting, solve, w, error_z);
    if (count < ENSEMBLE_DRAWS_MIN)
        error_set(error, MR_NUMERICS,
                  "no intervals: only %zu refits of the bootstrap converged; narrow the priors, or "
                  "fit fewer parameters",
                  count);
    for (size_t i = 0; i < q && error->status == MR_OK; i++) {
        answer->bias[i] = gsl_stats_mean(error_z + i, q, count);
        for (size_t k = 0; k < q; k++)
            answer->covariance[i][k] = gsl_stats_covariance(error_z + i, q, error_z + k, q, count);
        double half = within * sqrt(answer->covariance[i][i]);
        answer->low[i] = answer->z[i] - half;
        answer->high[i] = answer->z[i] + half;
    }
    free(error_z);
    return error->status;
}

/* Sets the expected value and the scatter of each statistic at the estimate. */
static void set_expected_statistics(const struct surface *surface, const double *w,
                                    struct fit_result *answer)
{
    surface_evaluate(surface, w, answer->expected, NULL);
    for (size_t s = 0; s < answer->statistic_count; s++)
        answer->scatter[s] = sqrt(gsl_matrix_get(surface->covariance, s, s));
}

/* Fits one data set and computes its residual. Returns false if the fit does not converge. */
static bool fit_one_data_set(const struct fitting *fitting, const struct solve *fitted,
                             const struct surface *all, const double *statistic, double *residual)
{
    const struct fit_result *answer = fitting->result;
    struct solve solve = *fitted;
    double w[FIT_PARAMETERS_MAX] = {0.0};
    compute_score(fitting, statistic, solve.score);
    if (isnan(solve_least_squares(&solve, w)))
        return false;
    for (size_t i = 0; i < answer->parameter_count; i++)
        w[i] = fmax(-SOLVE_LINEAR_FROM, fmin(SOLVE_LINEAR_FROM, w[i]));
    surface_evaluate(all, w, residual, NULL);
    for (size_t s = 0; s < answer->statistic_count; s++)
        residual[s] = answer->scatter[s] > 0.0 ? (statistic[s] - residual[s]) / answer->scatter[s]
                                               : 0.0;
    return true;
}

/* Makes replicas: data sets that are simulated with the fitted model. Their parameters are drawn
 * from the posterior (normal in z, with the estimate and its covariance); everything else is drawn
 * as in any ensemble. Each replica is then fitted in the same way as the measured data set, so that
 * the fit reduces the residuals of both equally. If the model is right, the measured data set
 * behaves like another replica, and its rank among the replicas is uniformly distributed. If
 * simulations fail at values that the posterior includes, there are no replicas; this is not an
 * error. */
static void make_replicas(const struct fitting *fitting, const struct solve *solve,
                          const struct surface *all)
{
    struct fit_result *answer = fitting->result;
    struct fit_options options = fitting->options;
    struct ensemble_region region = {.parameter_count = answer->parameter_count, .is_normal = true};
    struct ensemble ensemble;
    struct error failed = {0};
    size_t p = answer->statistic_count;
    options.draw_count = options.replica_count ? options.replica_count : DEFAULT_REPLICAS;
    memcpy(region.middle, answer->z, sizeof region.middle);
    if (!solve_cholesky(answer->parameter_count, answer->covariance, region.spread))
        return;
    if (ensemble_simulate(fitting->model, &region, &options, answer->round_count, &ensemble,
                          &failed) == MR_OK) {
        answer->simulated_draw_count += ensemble.draw_count + ensemble.failed_draw_count;
        answer->residual = xcalloc((1 + ensemble.draw_count) * p, sizeof *answer->residual);
        bool good = fit_one_data_set(fitting, solve, all, fitting->measured, answer->residual);
        for (size_t i = 0; good && i < ensemble.draw_count; i++)
            answer->replica_count +=
                fit_one_data_set(fitting, solve, all, ensemble.statistic + i * p,
                                 answer->residual + (1 + answer->replica_count) * p);
    }
    ensemble_free(&ensemble);
}

/* Computes the results from the last ensemble, with the scores that earlier ensembles
 * determined. */
static enum mr_status finish_fit(struct fitting *fitting, struct error *error)
{
    struct fit_result *answer = fitting->result;
    struct ensemble ensemble;
    struct surface scores = {0}, all = {0};
    struct solve solve;
    double w[FIT_PARAMETERS_MAX];
    if (draw_ensemble(fitting, &ensemble, error) == MR_OK &&
        estimate_w(fitting, &ensemble, &scores, &solve, w, error) == MR_OK) {
        compute_parameters(&fitting->region, w, answer->z);
        solve_information(&solve, w, answer->information);
        solve_covariance(answer->parameter_count, answer->information, answer->covariance);
        if (surface_make(&ensemble, &all, error) == MR_OK) {
            set_expected_statistics(&all, w, answer);
            if (set_intervals(fitting, &solve, w, error) == MR_OK)
                make_replicas(fitting, &solve, &all);
        }
    }
    surface_free(&scores);
    surface_free(&all);
    ensemble_free(&ensemble);
    return error->status;
}

static enum mr_status run_rounds(struct fitting *fitting, struct error *error)
{
    struct fit_result *answer = fitting->result;
    double moved = (double)INFINITY;
    while (answer->round_count + 1 < FIT_ROUNDS_MAX &&
           (moved > CONVERGED_STEP_MAX || answer->round_count < 2)) {
        if (run_round(fitting, &moved, error) != MR_OK)
            return error->status;
    }
    answer->has_not_converged = moved > CONVERGED_STEP_MAX;
    return finish_fit(fitting, error);
}

static enum mr_status check_request(const struct fit_model *model,
                                    const struct fit_options *options, struct error *error)
{
    size_t least = 2 * surface_term_count(model->parameter_count) + 1;
    if (model->parameter_count == 0 || model->parameter_count > FIT_PARAMETERS_MAX)
        return error_set(error, MR_USAGE, "wrong number of parameters: %zu; give 1 to %u",
                         model->parameter_count, FIT_PARAMETERS_MAX);
    if (model->statistic_count < model->parameter_count ||
        model->statistic_count > FIT_STATISTICS_MAX)
        return error_set(error, MR_TOO_FEW,
                         "the landings give %zu statistics for %zu parameters, but the fit needs "
                         "%zu to %u; fit more or fewer parameters",
                         model->statistic_count, model->parameter_count, model->parameter_count,
                         FIT_STATISTICS_MAX);
    if (options->draw_count < ENSEMBLE_DRAWS_MIN || options->draw_count < least)
        return error_set(error, MR_USAGE,
                         "too few draws: %zu for %zu parameters; give at least %zu",
                         options->draw_count, model->parameter_count,
                         least > ENSEMBLE_DRAWS_MIN ? least : (size_t)ENSEMBLE_DRAWS_MIN);
    return MR_OK;
}

enum mr_status fit_run(const struct fit_model *model, const double *measured,
                       const struct fit_options *options, struct fit_result *answer,
                       struct error *error)
{
    size_t q = model->parameter_count, p = model->statistic_count;
    struct fitting fitting = {
        .model = model, .measured = measured, .options = *options, .result = answer};
    *answer = (struct fit_result){.parameter_count = q, .statistic_count = p};
    if (fitting.options.draw_count == 0)
        fitting.options.draw_count = DEFAULT_DRAWS;
    if (check_request(model, &fitting.options, error) != MR_OK)
        return error->status;
    gsl_error_handler_t *before = gsl_set_error_handler_off();
    fitting.region.parameter_count = q;
    for (size_t i = 0; i < q; i++)
        fitting.region.spread[i][i] = 1.0;
    fitting.score_weights = new_matrix(p, q);
    fitting.correlation_factor = new_matrix(p, p);
    fitting.statistic_scales = xcalloc(p, sizeof *fitting.statistic_scales);
    answer->expected = xcalloc(p, sizeof *answer->expected);
    answer->scatter = xcalloc(p, sizeof *answer->scatter);
    run_rounds(&fitting, error);
    gsl_matrix_free(fitting.score_weights);
    gsl_matrix_free(fitting.correlation_factor);
    free(fitting.statistic_scales);
    gsl_set_error_handler(before);
    return error->status;
}

void fit_free(struct fit_result *answer)
{
    free(answer->expected);
    free(answer->scatter);
    free(answer->residual);
    *answer = (struct fit_result){0};
}
