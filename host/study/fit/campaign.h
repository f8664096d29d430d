/* Landings of a campaign database, made ready to fit. */
#ifndef MATRIG_HOST_STUDY_FIT_CAMPAIGN_H
#define MATRIG_HOST_STUDY_FIT_CAMPAIGN_H

#include "host/study/fit/landings.h"
#include "host/store/store.h"

/* Adds landing `run`: way of the gear, survey before it, displacements with their errors. The
 * runway is that of the scene file. A landing that the one added before it was followed by (same
 * board, next number) begins with the gaps that one leaves; when it was surveyed anew, its survey
 * is also what the one before left. MR_TOO_FEW: its motion is not known, or no transducer is
 * valid. */
enum mr_status fit_campaign_add(struct store *store, int64_t run, const char *scene_path,
                                struct fit_landings *list, struct error *error);
/* Once all are added: a survey says the gaps' mean, which is then known but for the survey's
 * systematic error. Gives the number of segments surveyed before the first landing. */
size_t fit_campaign_set_gap(struct fit_landings *list);

#endif
