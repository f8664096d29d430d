#include "host/study/fit/replicas.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/steady.h"

#define REPLICAS  99u /* rank of the measured one among 100 */
#define ODD_PAIRS 32u

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

/* Puts a data set and what is left of it into row `row`. */
static bool put(const struct replicas *r, struct fit_answer *answer, const double *statistic,
                size_t row)
{
    size_t p = r->model->statistics;
    memcpy(answer->replica + row * p, statistic, p * sizeof *statistic);
    return leave(r, answer, statistic, answer->residual + row * p);
}

/* Mean of what an odd model leaves less what the right one leaves of the same draws: what both have
 * of their joints drops out, so a few draws say it. */
static bool add_odd(const struct replicas *r, const struct fit_model *odd,
                    const struct ensemble_place *place, const struct ensemble *ensemble,
                    struct fit_answer *answer, double *room)
{
    size_t p = r->model->statistics, q = r->model->parameters, pairs = 0,
           of = ensemble->draws < ODD_PAIRS ? ensemble->draws : ODD_PAIRS;
    double z[FIT_SOME * FIT_PARAMETERS_MAX], *mean = answer->odd + answer->odds * p;
    double *left = room + FIT_SOME * p, *right = left + p;
    for (size_t i = 0; i < of; i += FIT_SOME) {
        size_t count = of - i < FIT_SOME ? of - i : FIT_SOME;
        bool good[FIT_SOME];
        if (steady_s() > r->until_s)
            return false;
        for (size_t k = 0; k < count; k++)
            ensemble_at(place, ensemble->w + (i + k) * q, z + k * q);
        odd->simulate_some(odd->context, count, z, ensemble->draw + i, room, good);
        for (size_t k = 0; k < count; k++) {
            if (!good[k] || !leave(r, answer, room + k * p, left) ||
                !leave(r, answer, ensemble->statistic + (i + k) * p, right))
                continue;
            pairs++;
            for (size_t s = 0; s < p; s++)
                mean[s] += left[s] - right[s];
        }
    }
    for (size_t s = 0; s < p; s++)
        mean[s] /= (double)(pairs > 0 ? pairs : 1);
    answer->odds++;
    return true;
}

static enum mr_status add_odds(const struct replicas *r, const struct ensemble_place *place,
                               const struct ensemble *ensemble, struct fit_answer *answer,
                               struct error *error)
{
    size_t p = r->model->statistics;
    double *room = calloc((FIT_SOME + 2) * p, sizeof *room);
    answer->odd = calloc(r->options->odds * p + 1, sizeof *answer->odd);
    bool good = room && answer->odd;
    if (!good)
        error_set(error, MR_FULL, "no memory: %zu statistics; use fewer landings", p);
    for (size_t n = 0; n < r->options->odds && good; n++)
        good = add_odd(r, &r->options->odd[n], place, ensemble, answer, room);
    free(room);
    return error->status;
}

static enum mr_status keep(const struct replicas *r, const struct ensemble_place *place,
                           const struct ensemble *ensemble, struct fit_answer *answer,
                           struct error *error)
{
    size_t p = r->model->statistics;
    answer->residual = calloc((1 + ensemble->draws) * p, sizeof *answer->residual);
    answer->replica = calloc((1 + ensemble->draws) * p, sizeof *answer->replica);
    if (!answer->residual || !answer->replica)
        return error_set(error, MR_FULL,
                         "no memory: %zu replicas of %zu statistics; use fewer landings",
                         ensemble->draws, p);
    if (!put(r, answer, r->measured, 0))
        return MR_OK;
    for (size_t i = 0; i < ensemble->draws; i++)
        answer->replicas += put(r, answer, ensemble->statistic + i * p, 1 + answer->replicas);
    return add_odds(r, place, ensemble, answer, error);
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
        keep(r, &place, &ensemble, answer, error);
    } else if (error->status == MR_TIMEOUT || error->status == MR_NUMERICS) {
        *error = (struct error){0};
    }
    ensemble_free(&ensemble);
    return error->status;
}
