#include "host/study/fit/fit.h"

#include <gsl/gsl_blas.h>
#include <gsl/gsl_cdf.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_randist.h>
#include <gsl/gsl_rng.h>
#include <gsl/gsl_statistics.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/study/fit/replicas.h"
#include "host/base/monotonic_clock.h"

#define DRAWS  300u
#define WIDEN  1.3  /* the next design, in standard errors of the present estimate */
#define STANDS 1.2  /* an estimate within this of its design's middle (in w) stands */
#define REFITS 640u /* of the bootstrap, about */
#define SPARE  0.9  /* of the time that is left, planned for */
#define MOST_W (1.2 * ENSEMBLE_REACH)

struct fitting {
    const struct fit_model *model;
    const double *measured;
    struct fit_options options;
    double until_s;
    struct ensemble_place place; /* of the next ensemble */
    gsl_matrix *weight;          /* statistics x parameters: scores */
    /* Cholesky factor of the statistics' correlation, with their standard deviations in `scale` */
    gsl_matrix *metric;
    double *scale;
    struct fit_answer *answer;
};

/* The correlation's Cholesky factor and the standard deviations; a statistic that never changes
 * gets none. */
static enum mr_status set_metric(struct fitting *fitting, struct surface *surface,
                                 struct error *error)
{
    size_t p = surface->statistics;
    surface_shrink(surface->departure, surface->covariance);
    gsl_matrix_memcpy(fitting->metric, surface->covariance);
    for (size_t i = 0; i < p; i++) {
        double variance = gsl_matrix_get(surface->covariance, i, i);
        fitting->scale[i] = variance > 0.0 ? sqrt(variance) : (double)INFINITY;
    }
    for (size_t i = 0; i < p; i++) {
        for (size_t k = 0; k < p; k++) {
            double correlation = i == k ? 1.0
                                        : gsl_matrix_get(surface->covariance, i, k) /
                                              fitting->scale[i] / fitting->scale[k];
            gsl_matrix_set(fitting->metric, i, k, correlation);
        }
    }
    if (gsl_linalg_cholesky_decomp1(fitting->metric) != 0)
        return error_set(error, MR_NUMERICS,
                         "the statistics' covariance is singular: %zu statistics; use more draws",
                         p);
    return MR_OK;
}

/* Scores: slopes of the statistics, through the metric's inverse. */
static void set_weight(struct fitting *fitting, const struct surface *surface)
{
    size_t p = surface->statistics, q = surface->parameters;
    for (size_t i = 0; i < q; i++) {
        gsl_vector_view column = gsl_matrix_column(fitting->weight, i);
        for (size_t s = 0; s < p; s++)
            gsl_vector_set(&column.vector, s,
                           gsl_matrix_get(surface->factor, 1 + i, s) / fitting->scale[s]);
        gsl_linalg_cholesky_svx(fitting->metric, &column.vector);
        for (size_t s = 0; s < p; s++)
            gsl_vector_set(&column.vector, s,
                           gsl_vector_get(&column.vector, s) / fitting->scale[s]);
    }
}

static void set_score(const struct fitting *fitting, double *score)
{
    for (size_t i = 0; i < fitting->model->parameters; i++) {
        score[i] = 0.0;
        for (size_t s = 0; s < fitting->model->statistics; s++)
            score[i] += gsl_matrix_get(fitting->weight, s, i) * fitting->measured[s];
    }
}

/* The next design: about w, as wide as the estimate is uncertain. */
static void move(struct fitting *fitting, const double *w,
                 double covariance[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX])
{
    struct ensemble_place next = {.parameters = fitting->place.parameters};
    double inside[FIT_PARAMETERS_MAX], lower[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];
    for (size_t i = 0; i < next.parameters; i++)
        inside[i] = fmax(-MOST_W, fmin(MOST_W, w[i]));
    ensemble_at(&fitting->place, inside, next.middle);
    if (!solve_cholesky(next.parameters, covariance, lower))
        return;
    for (size_t i = 0; i < next.parameters; i++) {
        for (size_t k = 0; k <= i; k++)
            next.spread[i][k] = WIDEN * lower[i][k];
    }
    fitting->place = next;
}

/* Estimate of one ensemble's scores; solve->surface is the caller's to free. */
static enum mr_status estimate(struct fitting *fitting, const struct ensemble *ensemble,
                               struct surface *scores, struct solve *solve, double *w,
                               struct error *error)
{
    struct ensemble combined;
    if (surface_combine(ensemble, fitting->weight, &combined, error) == MR_OK)
        surface_make(&combined, scores, error);
    ensemble_free(&combined);
    if (error->status != MR_OK)
        return error->status;
    if (!solve_begin(solve, scores, &fitting->place))
        return error_set(error, MR_NUMERICS,
                         "a parameter changes nothing that was measured: scores are singular; fit "
                         "fewer parameters");
    set_score(fitting, solve->score);
    memset(w, 0, fitting->model->parameters * sizeof *w);
    if (isnan(solve_least(solve, w)))
        return error_set(
            error, MR_NUMERICS,
            "the fit does not converge: %zu parameters; narrow the priors, or fit fewer",
            fitting->model->parameters);
    return MR_OK;
}

static double farthest(const double *w, size_t count)
{
    double most = 0.0;
    for (size_t i = 0; i < count; i++)
        most = fmax(most, fabs(w[i]));
    return most;
}

static enum mr_status draw_ensemble(struct fitting *fitting, struct ensemble *ensemble,
                                    struct error *error)
{
    struct fit_answer *answer = fitting->answer;
    enum mr_status status = ensemble_make(fitting->model, &fitting->place, &fitting->options,
                                          answer->rounds, fitting->until_s, ensemble, error);
    if (status == MR_OK) {
        answer->rounds++;
        answer->simulated += ensemble->draws + ensemble->failed;
        answer->failed += ensemble->failed;
    }
    return status;
}

static enum mr_status choose_scores(struct fitting *fitting, const struct ensemble *ensemble,
                                    struct error *error)
{
    struct surface surface;
    if (surface_make(ensemble, &surface, error) == MR_OK &&
        set_metric(fitting, &surface, error) == MR_OK)
        set_weight(fitting, &surface);
    surface_free(&surface);
    return error->status;
}

/* One round of finding the place: estimate, new scores, new design. Scores chosen and used with the
 * same ensemble look better than they are, the more so the more statistics there are: only the
 * first round has no others. */
static enum mr_status find_place(struct fitting *fitting, double *moved, struct error *error)
{
    struct ensemble ensemble;
    struct surface scores = {0};
    struct solve solve;
    double w[FIT_PARAMETERS_MAX], information[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX],
        covariance[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];
    bool first = fitting->answer->rounds == 0;
    if (draw_ensemble(fitting, &ensemble, error) == MR_OK &&
        (!first || choose_scores(fitting, &ensemble, error) == MR_OK) &&
        estimate(fitting, &ensemble, &scores, &solve, w, error) == MR_OK &&
        (first || choose_scores(fitting, &ensemble, error) == MR_OK)) {
        solve_information(&solve, w, information);
        solve_covariance(fitting->model->parameters, information, covariance);
        *moved = farthest(w, fitting->model->parameters);
        move(fitting, w, covariance);
    }
    surface_free(&scores);
    ensemble_free(&ensemble);
    return error->status;
}

/* Does the fit again with each departure of the ensemble in place of the measured one, and priors
 * drawn alike. Rows of parameters: refitted less true. Gives how many rows there are. */
static size_t refit(const struct fitting *fitting, const struct solve *solve, const double *w,
                    double *error_z)
{
    const struct surface *surface = solve->surface;
    size_t q = surface->parameters, count = 0,
           times = (REFITS + surface->draws - 1) / surface->draws;
    double score[FIT_PARAMETERS_MAX], slope[FIT_PARAMETERS_MAX * FIT_PARAMETERS_MAX],
        z[FIT_PARAMETERS_MAX], again_z[FIT_PARAMETERS_MAX];
    double scale = sqrt(1.0 + surface_leverage(surface, w));
    gsl_rng *random = gsl_rng_alloc(gsl_rng_taus2);
    if (!random)
        return 0;
    gsl_rng_set(random, (unsigned long)(fitting->options.seed + 1));
    surface_at(surface, w, score, slope);
    ensemble_at(solve->place, w, z);
    for (size_t i = 0; i < times * surface->draws; i++) {
        struct solve again = *solve;
        double again_w[FIT_PARAMETERS_MAX];
        for (size_t k = 0; k < q; k++) {
            again.score[k] = score[k] +
                             scale * gsl_matrix_get(surface->departure, i % surface->draws, k);
            again.prior[k] = z[k] + gsl_ran_gaussian_ziggurat(random, 1.0);
        }
        memcpy(again_w, w, q * sizeof *w);
        if (isnan(solve_least(&again, again_w)))
            continue;
        ensemble_at(solve->place, again_w, again_z);
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
    struct fit_answer *answer = fitting->answer;
    size_t q = answer->parameters, rows = (REFITS + solve->surface->draws) * q;
    double *error_z = calloc(rows, sizeof *error_z);
    double within = gsl_cdf_tdist_Pinv(0.975,
                                       (double)(solve->surface->draws - solve->surface->terms));
    size_t count = error_z ? refit(fitting, solve, w, error_z) : 0;
    if (count < FIT_DRAWS_LEAST)
        error_set(error, MR_NUMERICS,
                  "no intervals: %zu of the bootstrap's refits converged; narrow the priors, or "
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

/* What is expected of each statistic at the estimate, and its scatter. */
static void set_expected(const struct surface *surface, const double *w, struct fit_answer *answer)
{
    surface_at(surface, w, answer->expected, NULL);
    for (size_t s = 0; s < answer->statistics; s++)
        answer->scatter[s] = sqrt(gsl_matrix_get(surface->covariance, s, s));
}

/* The last ensemble: its scores were chosen by others. */
static enum mr_status conclude(struct fitting *fitting, struct error *error)
{
    struct fit_answer *answer = fitting->answer;
    struct ensemble ensemble;
    struct surface scores = {0}, all = {0};
    struct solve solve;
    double w[FIT_PARAMETERS_MAX];
    if (draw_ensemble(fitting, &ensemble, error) == MR_OK &&
        estimate(fitting, &ensemble, &scores, &solve, w, error) == MR_OK) {
        ensemble_at(&fitting->place, w, answer->z);
        solve_information(&solve, w, answer->information);
        solve_covariance(answer->parameters, answer->information, answer->covariance);
        const struct replicas replicas = {.model = fitting->model,
                                          .measured = fitting->measured,
                                          .options = &fitting->options,
                                          .until_s = fitting->until_s,
                                          .weight = fitting->weight,
                                          .solve = &solve,
                                          .surface = &all};
        if (surface_make(&ensemble, &all, error) == MR_OK) {
            set_expected(&all, w, answer);
            if (set_intervals(fitting, &solve, w, error) == MR_OK)
                replicas_make(&replicas, answer, error);
        }
    }
    surface_free(&scores);
    surface_free(&all);
    ensemble_free(&ensemble);
    return error->status;
}

/* Whether one more ensemble before the last can be afforded; the last one gets as many draws as
 * there is time for. */
static bool time_for_more(struct fitting *fitting, double each_s)
{
    if (isinf(fitting->until_s) || fitting->answer->rounds == 0)
        return true;
    double left_s = SPARE * (fitting->until_s - monotonic_s());
    if (left_s >= 2.0 * each_s)
        return true;
    fitting->answer->stopped = true;
    double draws = floor((double)fitting->options.draws * left_s / each_s);
    size_t least = 2 * surface_terms(fitting->model->parameters) + 1;
    least = least > FIT_DRAWS_LEAST ? least : FIT_DRAWS_LEAST;
    if (draws < (double)fitting->options.draws)
        fitting->options.draws = draws > (double)least ? (size_t)draws : least;
    return false;
}

static enum mr_status run_rounds(struct fitting *fitting, struct error *error)
{
    struct fit_answer *answer = fitting->answer;
    double moved = (double)INFINITY, each_s = 0.0;
    while (answer->rounds + 1 < FIT_ROUNDS_MAX && (moved > STANDS || answer->rounds < 2) &&
           time_for_more(fitting, each_s)) {
        double begin_s = monotonic_s();
        if (find_place(fitting, &moved, error) != MR_OK)
            return error->status;
        each_s = monotonic_s() - begin_s;
    }
    answer->stopped = answer->stopped || moved > STANDS;
    return conclude(fitting, error);
}

static enum mr_status check(const struct fit_model *model, const struct fit_options *options,
                            struct error *error)
{
    size_t least = 2 * surface_terms(model->parameters) + 1;
    if (model->parameters == 0 || model->parameters > FIT_PARAMETERS_MAX)
        return error_set(error, MR_USAGE, "%zu parameters: fit; give 1 to %u", model->parameters,
                         FIT_PARAMETERS_MAX);
    if (model->statistics < model->parameters || model->statistics > FIT_STATISTICS_MAX)
        return error_set(
            error, MR_TOO_FEW, "%zu measured statistics for %zu parameters: fit; give %zu to %u",
            model->statistics, model->parameters, model->parameters, FIT_STATISTICS_MAX);
    if (options->draws < FIT_DRAWS_LEAST || options->draws < least)
        return error_set(error, MR_USAGE,
                         "too few draws: %zu for %zu parameters; give %zu at least", options->draws,
                         model->parameters,
                         least > FIT_DRAWS_LEAST ? least : (size_t)FIT_DRAWS_LEAST);
    return MR_OK;
}

enum mr_status fit_run(const struct fit_model *model, const double *measured,
                       const struct fit_options *options, struct fit_answer *answer,
                       struct error *error)
{
    size_t q = model->parameters, p = model->statistics;
    struct fitting fitting = {
        .model = model, .measured = measured, .options = *options, .answer = answer};
    *answer = (struct fit_answer){.parameters = q, .statistics = p};
    if (fitting.options.draws == 0)
        fitting.options.draws = DRAWS;
    if (check(model, &fitting.options, error) != MR_OK)
        return error->status;
    gsl_error_handler_t *before = gsl_set_error_handler_off();
    fitting.until_s = options->max_s > 0.0 ? monotonic_s() + options->max_s : (double)INFINITY;
    fitting.place.parameters = q;
    for (size_t i = 0; i < q; i++)
        fitting.place.spread[i][i] = 1.0;
    fitting.weight = gsl_matrix_alloc(p, q);
    fitting.metric = gsl_matrix_alloc(p, p);
    fitting.scale = calloc(p, sizeof *fitting.scale);
    answer->expected = calloc(p, sizeof *answer->expected);
    answer->scatter = calloc(p, sizeof *answer->scatter);
    if (!fitting.weight || !fitting.metric || !fitting.scale || !answer->expected ||
        !answer->scatter)
        error_set(error, MR_FULL, "no memory: %zu statistics; use fewer landings", p);
    else
        run_rounds(&fitting, error);
    gsl_matrix_free(fitting.weight);
    gsl_matrix_free(fitting.metric);
    free(fitting.scale);
    gsl_set_error_handler(before);
    return error->status;
}

void fit_free(struct fit_answer *answer)
{
    free(answer->expected);
    free(answer->scatter);
    free(answer->residual);
    *answer = (struct fit_answer){0};
}
