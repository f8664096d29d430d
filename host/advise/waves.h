/* Bow waves of a landing that is planned: some members on host/sim's planar landing, where mats
 * heave and turn, on ground that is uneven under the joints by up to what the board's configuration
 * assumes, drawn by member. A row's probability is the share of these members with a wave, and its
 * interval Wilson's of so few. It is not calibrated: no series of waves was set aside for that. */
#ifndef MATRIG_HOST_ADVISE_WAVES_H
#define MATRIG_HOST_ADVISE_WAVES_H

#include "host/advise/forecast.h"
#include "host/base/error.h"

#define ADVISE_WAVES      16u /* members, when nobody says */
#define ADVISE_WAVES_MOST 256u

/* Fills row[].wave of every second row and of the plan's, by the first `count` members (1 on, at
 * most as many as there are); *played: runs of the planar engine. Members that it has no answer for
 * are left out. MR_FULL: no memory; MR_NUMERICS: it has an answer for none. */
enum mr_status advise_waves(const struct advise_members *members, const struct advise_plan *plan,
                            size_t count, struct advise_row *row, size_t rows, size_t plan_row,
                            size_t *played, struct error *error);

/* One run: a wave came of it. MR_NUMERICS: it has no answer. */
enum mr_status advise_wave(const struct advise_members *members, size_t member,
                           const struct advise_braking *braking, uint64_t seed, bool *wave,
                           struct error *error);

#endif
