/* Giving a board chart and plan for the landing to come (common/risk.h). */
#ifndef MATRIG_HOST_BOARD_CHARTTALK_H
#define MATRIG_HOST_BOARD_CHARTTALK_H

#include "common/risk.h"
#include "host/board/dialogue.h"

/* After the board has said hello. MR_NOT_NOW: it is armed, or has no predictor; MR_VERSION: its
 * runway has had another number of landings. */
enum mr_status charttalk_give(struct dialogue *dialogue, const struct mr_risk_plan *plan,
                              struct error *error);

#endif
