/* The advice as a board takes it before a landing: chart and plan of common/risk.h. */
#ifndef MATRIG_HOST_ADVISE_CHART_H
#define MATRIG_HOST_ADVISE_CHART_H

#include "common/risk.h"
#include "host/advise/advise.h"

/* `landings`: that the board's runway has had; the plan has MR_RISK_KNOTS points at most. MR_USAGE:
 * it is more than a board understands. */
enum mr_status advise_chart(const struct advise *advise, unsigned landings,
                            struct mr_risk_plan *plan, struct error *error);

#endif
