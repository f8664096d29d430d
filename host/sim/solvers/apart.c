#include "host/sim/solvers/apart.h"

#include <math.h>

#include "host/sim/solvers/planar.h"

struct apart apart_of(const struct pass_outcome *a, const struct pass_outcome *b)
{
    return (struct apart){sim_record_difference(&a->record, &b->record),
                          fmax(sim_record_lift_difference(&a->record, &b->record),
                               fabs(a->max_lift_ft - b->max_lift_ft))};
}

bool apart_agree(const struct sim_scene *scene, const struct pass_outcome *a,
                 const struct pass_outcome *b, struct apart apart)
{
    double threshold = planar_bow_threshold_ft(scene);
    double peak = fmin(sim_record_peak(&a->record).u_ft, sim_record_peak(&b->record).u_ft);
    double lift = fmin(a->max_lift_ft, b->max_lift_ft);
    return apart.u.u_ft <= PLANAR_DISAGREEMENT * peak + 1e-9 * scene->length_ft &&
           apart.lift_ft <= PLANAR_DISAGREEMENT * lift + 0.01 * threshold &&
           (a->max_lift_ft > threshold) == (b->max_lift_ft > threshold);
}
