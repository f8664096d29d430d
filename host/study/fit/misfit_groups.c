/* Figures of a misfit that weigh many residuals together. */
#include <gsl/gsl_blas.h>
#include <gsl/gsl_linalg.h>
#include <gsl/gsl_statistics.h>
#include <math.h>
#include <string.h>

#include "host/study/fit/misfit_parts.h"
#include "host/study/fit/surface.h"

#define SIXTHS 6

static double station_of(const struct checking *c, size_t s)
{
    return is_sum(c, s) ? ((double)c->window[s]->segment + 0.5) * (double)MR_SEGMENT_LENGTH_FT
                        : c->landing[s]->channel[c->window[s]->channel].station_ft;
}

/* The statistic of a member that is farthest out in the measured row. */
static size_t oddest(const struct checking *c)
{
    size_t at = SIZE_MAX;
    double most = 0.0;
    for (size_t s = 0; s < c->statistics; s++) {
        if (fabs(c->weight[s] * z_of(c, 0, s)) > most) {
            most = fabs(c->weight[s] * z_of(c, 0, s));
            at = s;
        }
    }
    return at;
}

/* Takes sum of weight * z as one more member, when it varies. */
static void take_member(struct checking *c)
{
    if (c->members == GROUP_MAX)
        return;
    double *column = c->group + c->members * c->rows;
    for (size_t i = 0; i < c->rows; i++) {
        column[i] = 0.0;
        for (size_t s = 0; s < c->statistics; s++)
            column[i] += c->weight[s] != 0.0 ? c->weight[s] * z_of(c, i, s) : 0.0;
    }
    double mean = gsl_stats_mean(column, 1, c->rows), sd = gsl_stats_sd(column, 1, c->rows);
    if (!(sd > 1e-9))
        return;
    for (size_t i = 0; i < c->rows; i++)
        column[i] = (column[i] - mean) / sd;
    c->member_at[c->members++] = oddest(c);
}

/* Logarithm of Mahalanobis' distance of each row, by the rows' own covariance. */
static bool weigh_group(struct checking *c, enum misfit_figure figure, struct misfit_found *found)
{
    size_t q = c->members, n = c->rows;
    if (q == 0)
        return true;
    gsl_matrix *row = gsl_matrix_alloc(n, q), *covariance = gsl_matrix_alloc(q, q);
    gsl_vector *solved = gsl_vector_alloc(q);
    bool good = row && covariance && solved;
    for (size_t i = 0; i < n && good; i++) {
        for (size_t k = 0; k < q; k++)
            gsl_matrix_set(row, i, k, c->group[k * n + i]);
    }
    for (size_t k = 0; k < q && good; k++) {
        for (size_t m = 0; m < q; m++)
            gsl_matrix_set(covariance, k, m,
                           gsl_stats_covariance(c->group + k * n, 1, c->group + m * n, 1, n));
    }
    if (good) {
        surface_shrink(row, covariance);
        for (size_t k = 0; k < q; k++)
            *gsl_matrix_ptr(covariance, k, k) *= 1.0 + 1e-6;
    }
    if (good && gsl_linalg_cholesky_decomp1(covariance) == 0) {
        double most = 0.0;
        for (size_t i = 0; i < n; i++) {
            double sum = 0.0;
            gsl_vector_view one = gsl_matrix_row(row, i);
            gsl_linalg_cholesky_solve(covariance, &one.vector, solved);
            for (size_t k = 0; k < q; k++)
                sum += gsl_vector_get(solved, k) * gsl_vector_get(&one.vector, k);
            c->figure[figure * n + i] = 0.5 * log(fmax(sum, 1e-12) / (double)q);
        }
        for (size_t k = 0; k < q; k++) {
            if (fabs(c->group[k * n]) > most) {
                most = fabs(c->group[k * n]);
                found->where = c->member_at[k];
            }
        }
        found->known = true;
    }
    gsl_matrix_free(row);
    gsl_matrix_free(covariance);
    gsl_vector_free(solved);
    c->members = 0;
    return good;
}

bool misfit_alike(const struct checking *c, size_t s, size_t other)
{
    return !is_sum(c, s) && !is_sum(c, other) && c->landing[s] == c->landing[other] &&
           strcmp(c->window[s]->name, c->window[other]->name) == 0;
}

static bool first_of_kind(const struct checking *c, size_t s)
{
    for (size_t k = 0; k < s; k++) {
        if (misfit_alike(c, s, k))
            return false;
    }
    return !is_sum(c, s);
}

typedef double weight_fn(const struct checking *c, size_t statistic);

/* Members: of each landing and place of the wheel, what `weight` makes of the stations, less its
 * mean; a constant stays. */
static void take_kinds(struct checking *c, weight_fn *weight)
{
    for (size_t first = 0; first < c->statistics; first++) {
        double sum = 0.0, least = (double)INFINITY, most = -(double)INFINITY;
        size_t count = 0;
        if (!first_of_kind(c, first))
            continue;
        for (size_t s = 0; s < c->statistics; s++) {
            c->weight[s] = misfit_alike(c, first, s) ? weight(c, s) : 0.0;
            if (!misfit_alike(c, first, s))
                continue;
            sum += c->weight[s];
            least = fmin(least, c->weight[s]);
            most = fmax(most, c->weight[s]);
            count++;
        }
        for (size_t s = 0; s < c->statistics && most > least; s++)
            c->weight[s] -= misfit_alike(c, first, s) ? sum / (double)count : 0.0;
        if (most > least || weight(c, first) > 0.0)
            take_member(c);
    }
}

static double one(const struct checking *c, size_t s)
{
    (void)c, (void)s;
    return 1.0;
}

static double middle_ft(const struct checking *c)
{
    const struct sim_scene *scene = &c->list->landing[0].scene;
    return 0.5 * scene->mats * scene->length_ft;
}

static double half(const struct checking *c, size_t s)
{
    return station_of(c, s) > middle_ft(c) ? 1.0 : 0.0;
}

static double slope(const struct checking *c, size_t s)
{
    return station_of(c, s) / middle_ft(c);
}

static double bend(const struct checking *c, size_t s)
{
    double x = station_of(c, s) / middle_ft(c) - 1.0;
    return x * x;
}

/* Over the landing's time, from -1 to 1; all of its transducers' statistics at once. */
static void take_times(struct checking *c, int power)
{
    for (size_t l = 0; l < c->list->count; l++) {
        const struct fit_landing *landing = &c->list->landing[l];
        double end_s = sim_scene_end_s(&landing->scene), sum = 0.0;
        size_t count = 0;
        for (size_t s = 0; s < c->statistics; s++) {
            double t = (c->window[s]->from_s + c->window[s]->to_s) / end_s - 1.0;
            bool its = c->landing[s] == landing && !is_sum(c, s);
            c->weight[s] = its ? pow(t, power) : 0.0;
            sum += c->weight[s];
            count += its;
        }
        for (size_t s = 0; s < c->statistics; s++)
            c->weight[s] -= c->landing[s] == landing && !is_sum(c, s) ? sum / (double)count : 0.0;
        take_member(c);
    }
}

static void take_landings(struct checking *c)
{
    for (size_t l = 0; l < c->list->count && c->list->count > 1; l++) {
        size_t its = 0, others = 0;
        for (size_t s = 0; s < c->statistics; s++) {
            its += !is_sum(c, s) && c->landing[s] == &c->list->landing[l];
            others += !is_sum(c, s) && c->landing[s] != &c->list->landing[l];
        }
        for (size_t s = 0; s < c->statistics; s++)
            c->weight[s] = is_sum(c, s)                          ? 0.0
                         : c->landing[s] == &c->list->landing[l] ? 1.0 / (double)its
                                                                 : -1.0 / (double)others;
        if (its > 0 && others > 0)
            take_member(c);
    }
}

static void take_zones(struct checking *c)
{
    for (size_t k = 0; k < SIXTHS; k++) {
        for (size_t s = 0; s < c->statistics; s++) {
            double sixth = station_of(c, s) / middle_ft(c) * 0.5 * SIXTHS;
            c->weight[s] = is_sum(c, s) && sixth >= (double)k && sixth < (double)(k + 1) ? 1.0
                                                                                         : 0.0;
        }
        take_member(c);
    }
}

bool misfit_groups(struct checking *c, struct misfit *misfit)
{
    take_kinds(c, one);
    bool good = weigh_group(c, MISFIT_LEVEL, &misfit->found[MISFIT_LEVEL]);
    take_kinds(c, half);
    good = good && weigh_group(c, MISFIT_HALVES, &misfit->found[MISFIT_HALVES]);
    take_kinds(c, slope);
    take_kinds(c, bend);
    good = good && weigh_group(c, MISFIT_STATION, &misfit->found[MISFIT_STATION]);
    take_times(c, 1);
    take_times(c, 2);
    good = good && weigh_group(c, MISFIT_TIME, &misfit->found[MISFIT_TIME]);
    take_landings(c);
    good = good && weigh_group(c, MISFIT_LANDING, &misfit->found[MISFIT_LANDING]);
    take_zones(c);
    return good && weigh_group(c, MISFIT_ZONES, &misfit->found[MISFIT_ZONES]);
}

void misfit_odd(const struct fit_landings *list, struct misfit_odd *odd,
                struct fit_options *options)
{
    for (size_t n = 0; n < FIT_ODD_END - 1; n++) {
        odd->list[n] = *list; /* shares all that the list owns */
        odd->list[n].odd = (enum fit_odd)(FIT_AS_IS + 1 + n);
        odd->model[n] = fit_landings_model(&odd->list[n]);
    }
    options->odd = odd->model;
    options->odds = FIT_ODD_END - 1;
}

/* The combination of residuals that tells a shift from their scatter best: the shift through the
 * inverse of the rows' covariance. */
bool misfit_odds(struct checking *c, struct misfit *misfit)
{
    size_t p = c->statistics, n = c->rows;
    if (c->answer->odds == 0)
        return true;
    gsl_matrix *covariance = gsl_matrix_alloc(p, p);
    gsl_vector *best = gsl_vector_alloc(p);
    gsl_matrix_view z = gsl_matrix_view_array(c->z, n, p);
    bool good = covariance && best;
    if (good) {
        gsl_blas_dgemm(CblasTrans, CblasNoTrans, 1.0 / (double)(n - 1), &z.matrix, &z.matrix, 0.0,
                       covariance);
        surface_shrink(&z.matrix, covariance);
        for (size_t s = 0; s < p; s++)
            *gsl_matrix_ptr(covariance, s, s) += 1e-3;
        gsl_linalg_cholesky_decomp1(covariance);
    }
    for (size_t k = 0; k < c->answer->odds && good; k++) {
        enum misfit_figure figure = (enum misfit_figure)(MISFIT_ODD_BEYOND + k);
        double squares = 0.0;
        for (size_t s = 0; s < p; s++) {
            gsl_vector_set(best, s,
                           c->spread[s] > 0.0 ? c->answer->odd[k * p + s] / c->spread[s] : 0.0);
            c->weight[s] = gsl_vector_get(best, s);
        }
        gsl_linalg_cholesky_svx(covariance, best);
        for (size_t s = 0; s < p; s++)
            squares += gsl_vector_get(best, s) * c->weight[s];
        for (size_t i = 0; i < n && squares > 0.0; i++) {
            double sum = 0.0;
            for (size_t s = 0; s < p; s++)
                sum += gsl_vector_get(best, s) * z_of(c, i, s);
            c->figure[figure * n + i] = sum / squares; /* 1: as much of it as was simulated */
        }
        misfit->found[figure].known = squares > 0.0;
    }
    gsl_matrix_free(covariance);
    gsl_vector_free(best);
    return good;
}
