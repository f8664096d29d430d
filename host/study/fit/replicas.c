#include "host/study/fit/replicas.h"

#include <math.h>
#include <string.h>

#include "host/base/xmalloc.h"

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
