#include "host/study/fit/verdict.h"

#include <gsl/gsl_eigen.h>
#include <math.h>
#include <string.h>

typedef double square[FIT_PARAMETERS_MAX][FIT_PARAMETERS_MAX];

/* Information about the parameters in `kept` when the others are known as well as their priors say:
 * the Schur complement of information + 1 of those. */
static void marginal(size_t q, square information, const bool *left_out, square out)
{
    memcpy(out, information, sizeof(square));
    for (size_t s = 0; s < q; s++) {
        if (!left_out[s])
            continue;
        double row[FIT_PARAMETERS_MAX], pivot = out[s][s] + 1.0;
        memcpy(row, out[s], sizeof row);
        for (size_t i = 0; i < q; i++) {
            for (size_t k = 0; k < q; k++)
                out[i][k] = i == s || k == s ? 0.0 : out[i][k] - row[i] * row[k] / pivot;
        }
    }
}

/* Misfit of the data at z(w) + shift, above the misfit at w, the priors left out; what is not moved
 * stays. */
static double rise(const struct solve *solve, const double *w, const double *direction,
                   double shift)
{
    size_t q = solve->surface->parameters;
    double residual[2 * FIT_PARAMETERS_MAX + 1],
        slope[(2 * FIT_PARAMETERS_MAX + 1) * FIT_PARAMETERS_MAX], moved[FIT_PARAMETERS_MAX] = {0.0};
    double squares = 0.0;
    /* spread (w' - w) = shift direction, by forward substitution */
    for (size_t i = 0; i < q; i++) {
        double rest = shift * direction[i];
        for (size_t k = 0; k < i; k++)
            rest -= solve->place->spread[i][k] * (moved[k] - w[k]);
        moved[i] = w[i] + rest / solve->place->spread[i][i];
    }
    solve_residual(solve, moved, residual, slope);
    for (size_t i = 0; i < q; i++)
        squares += residual[i] * residual[i];
    solve_residual(solve, w, residual, slope);
    for (size_t i = 0; i < q; i++)
        squares -= residual[i] * residual[i];
    return squares;
}

static void take_direction(const struct solve *solve, const double *w, const gsl_vector *vector,
                           double information, const size_t *kept, size_t count,
                           struct fit_answer *answer)
{
    struct fit_confounded *found = &answer->confounded[answer->confounded_count];
    *found = (struct fit_confounded){.information = information};
    size_t first = FIT_PARAMETERS_MAX;
    for (size_t i = 0; i < count; i++) {
        double component = gsl_vector_get(vector, i);
        found->direction[kept[i]] = component;
        found->members += component * component >= VERDICT_MEMBER;
        if (component * component >= VERDICT_MEMBER && kept[i] < first)
            first = kept[i];
    }
    /* the first member upwards */
    double sign = first < FIT_PARAMETERS_MAX && found->direction[first] < 0.0 ? -1.0 : 1.0;
    for (size_t i = 0; i < FIT_PARAMETERS_MAX; i++)
        found->direction[i] *= sign;
    found->rise = fmin(rise(solve, w, found->direction, 1.0),
                       rise(solve, w, found->direction, -1.0));
    if (found->members > 1 && found->rise < VERDICT_LIMIT)
        answer->confounded_count++;
}

void verdict_make(const struct solve *solve, const double *w, struct fit_answer *answer)
{
    size_t q = answer->parameters, kept[FIT_PARAMETERS_MAX], count = 0;
    square information;
    answer->confounded_count = 0;
    for (size_t i = 0; i < q; i++) {
        answer->silent[i] = answer->information[i][i] < 1.0;
        if (!answer->silent[i])
            kept[count++] = i;
    }
    if (count < 2)
        return;
    marginal(q, answer->information, answer->silent, information);
    gsl_matrix *matrix = gsl_matrix_alloc(count, count), *vectors = gsl_matrix_alloc(count, count);
    gsl_vector *values = gsl_vector_alloc(count);
    gsl_eigen_symmv_workspace *work = gsl_eigen_symmv_alloc(count);
    if (matrix && vectors && values && work) {
        for (size_t i = 0; i < count; i++) {
            for (size_t k = 0; k < count; k++)
                gsl_matrix_set(matrix, i, k, information[kept[i]][kept[k]]);
        }
        gsl_eigen_symmv(matrix, values, vectors, work);
        gsl_eigen_symmv_sort(values, vectors, GSL_EIGEN_SORT_VAL_ASC);
        for (size_t d = 0; d < count && gsl_vector_get(values, d) < 1.0; d++) {
            gsl_vector_view column = gsl_matrix_column(vectors, d);
            take_direction(solve, w, &column.vector, gsl_vector_get(values, d), kept, count,
                           answer);
        }
    }
    gsl_matrix_free(matrix);
    gsl_matrix_free(vectors);
    gsl_vector_free(values);
    if (work)
        gsl_eigen_symmv_free(work);
}
