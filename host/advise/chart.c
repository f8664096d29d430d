#include "host/advise/chart.h"

#include <math.h>

_Static_assert(MR_RISK_ROWS >= ADVISE_ROWS, "a board takes all rows");

static float odds(double p)
{
    return (float)log(p / (1.0 - p));
}

enum mr_status advise_chart(const struct advise *advise, unsigned landings,
                            struct mr_risk_plan *plan, struct error *error)
{
    const struct advise_profile *profile = &advise->plan.profile;
    mr_risk_plan_clear(plan);
    plan->landings = (float)landings;
    plan->speed_ft_s = (float)advise->plan.speed_ft_s;
    for (size_t i = 0; i < advise->rows; i++) {
        plan->row_ft_s2[i] = (float)advise->row[i].mean_ft_s2;
        plan->row_odds[i] = odds(advise->row[i].zone.p);
        plan->row_ft[i] = (float)advise->row[i].half_ft;
    }
    plan->knot_s[0] = 0.0f;
    plan->knot_ft_s2[0] = (float)advise->plan.mean_ft_s2;
    for (size_t i = 0; i < profile->count; i++) {
        plan->knot_s[i] = (float)profile->t_s[i];
        plan->knot_ft_s2[i] = (float)(profile->factor[i] * advise->plan.mean_ft_s2);
    }
    return mr_risk_plan_check(plan) == MR_OK
             ? MR_OK
             : error_set(error, MR_USAGE,
                         "a plan that a board does not understand: matrig advise; it takes speeds "
                         "of 1 to 300 ft/s, and braking that ends at 0.1 ft/s2 or more");
}
