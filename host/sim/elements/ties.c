#include "host/sim/elements/ties.h"

#include <math.h>
#include <stdlib.h>

enum mr_status ties_make(struct ties **made, const struct sim_scene *scene, struct error *error)
{
    size_t mats = (size_t)scene->mats + 1;
    *made = NULL;
    if (!scene->beside || !(scene->ties.k_lb_ft > 0.0))
        return MR_OK;
    struct ties *ties = calloc(1, sizeof *ties + 2 * mats * sizeof *ties->lb);
    if (!ties)
        return error_set(error, MR_FULL, "out of memory: the ties of %d mats; use a smaller N",
                         scene->mats);
    double *storage = (double *)(ties + 1);
    *ties = (struct ties){.mats = scene->mats,
                          .k_lb_ft = scene->ties.k_lb_ft,
                          .most_lb = scene->ties.most_lb,
                          .scene = scene,
                          .rest_ft = storage,
                          .lb = storage + mats};
    *made = ties;
    return MR_OK;
}

void ties_reset(struct ties *ties)
{
    const struct sim_list *stretch = &ties->scene->ties.stretch_ft;
    for (int n = 1; n <= ties->mats; n++) {
        double e_ft = stretch->count > 0 ? stretch->values[stretch->count > 1 ? n - 1 : 0] : 0.0;
        e_ft = fmin(fabs(e_ft), ties->most_lb / ties->k_lb_ft) * (e_ft < 0.0 ? -1.0 : 1.0);
        ties->rest_ft[n] = -e_ft;
        ties->lb[n] = ties->k_lb_ft * e_ft;
    }
}

void ties_free(struct ties *ties)
{
    free(ties);
}

static double apart_ft(struct ties_view strip, struct ties_view beside, int n)
{
    return strip.u_ft[n * strip.stride + strip.offset] -
           beside.u_ft[n * beside.stride + beside.offset];
}

void ties_pull(struct ties *ties, struct ties_view strip, struct ties_view beside, int first,
               int last)
{
    for (int n = first; n <= last; n++) {
        double apart = apart_ft(strip, beside, n);
        double q = ties->k_lb_ft * (apart - ties->rest_ft[n]);
        if (fabs(q) > ties->most_lb) {
            q = copysign(ties->most_lb, q);
            ties->rest_ft[n] = apart - q / ties->k_lb_ft;
        }
        ties->lb[n] = q;
    }
}

double ties_row_lb_ft(const struct ties *ties)
{
    return ties ? 2.0 * ties->k_lb_ft : 0.0;
}

void ties_describe(const struct sim_scene *scene, struct sim_result *result)
{
    if (!scene->beside)
        return;
    if (!(scene->ties.k_lb_ft > 0.0))
        sim_result_note(result, "two strips that nothing holds together (shear_lb_ft 0)");
    else if (isinf(scene->ties.most_lb))
        sim_result_note(result, "two strips, held together by %g lb/ft at each mat",
                        scene->ties.k_lb_ft);
    else
        sim_result_note(result,
                        "two strips, held together by %g lb/ft and at most %g lb at each mat",
                        scene->ties.k_lb_ft, scene->ties.most_lb);
}

double ties_energy_lb_ft(const struct ties *ties)
{
    double sum = 0.0;
    for (int n = 1; n <= ties->mats; n++)
        sum += ties->lb[n] * ties->lb[n];
    return sum / (2.0 * ties->k_lb_ft);
}

double *ties_stretch_ft(const struct ties *ties, struct ties_view strip, struct ties_view beside)
{
    double *stretch = calloc((size_t)ties->mats + 1, sizeof *stretch);
    for (int n = 1; stretch && n <= ties->mats; n++) {
        double e_ft = apart_ft(strip, beside, n) - ties->rest_ft[n];
        stretch[n] = copysign(fmin(fabs(e_ft), ties->most_lb / ties->k_lb_ft), e_ft);
    }
    return stretch;
}
