/* Landings of a campaign database, made ready to fit. */
#ifndef MATRIG_HOST_STUDY_FIT_CAMPAIGN_H
#define MATRIG_HOST_STUDY_FIT_CAMPAIGN_H

#include "host/store/store.h"
#include "host/study/fit/landings.h"

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

/* Surveyed: the sums of the gaps of each segment before and after a landing. What was read at gage
 * points between two landings (`matrig survey`, with the error of its readings) holds; a segment
 * that was not read then is as the board had it when the landing was armed. */

struct fit_surveyed {
    double sum_in[MR_SEGMENTS]; /* NaN: not surveyed */
    double error_in;            /* of a sum that was read at gage points; 0: none was */
    size_t segments, gages;     /* how many are known, and how many of them from gage points */
};

/* Before landing `run`, or after it until the next one is armed. `board`: the landing whose board's
 * own survey counts too, or STORE_NONE. */
enum mr_status fit_surveyed(struct store *store, int64_t run, bool after, int64_t board,
                            struct fit_surveyed *surveyed, struct error *error);

#endif
