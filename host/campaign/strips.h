/* Strips: the runway as two strips side by side, under the left and the right line of wheels.
 * README.md, "Two strips". */
#ifndef MATRIG_HOST_CAMPAIGN_STRIPS_H
#define MATRIG_HOST_CAMPAIGN_STRIPS_H

#include "host/campaign/keys.h"

/* The key `strips`, an object that has been read from the file if it was a name. `count`: 1 or 2
 * whatever it says; 0: as it says. */
void strips_read(const struct keys *keys, const json_t *section, int count,
                 struct campaign *campaign);

/* Width of a strip, 0 the left one, over that of the strip that a campaign's scene stands for; 1
 * where there is one strip. */
double strips_share(const struct campaign *campaign, int strip);

/* What a landing has put on either strip alone, so far. */
struct strips_own {
    json_t *left, *right;
};

/* True, with the error set: a landing's key applies what the ties are, or a second strip. */
bool strips_refuse(const struct keys *r, const char *where, const char *key, const json_t *applied);
/* Take a landing's keys apply_left and apply_right into account; what it applies to both or removes
 * is of no strip alone any more. */
void strips_modify(const struct keys *keys, const char *where, const json_t *landing,
                   const struct strips_own *own);

/* Make the scene of a landing from keys `now` of both strips; the right one is beside the left. */
void strips_scene(const struct keys *keys, const char *where, const struct campaign *campaign,
                  const json_t *now, const struct strips_own *own, struct sim_scene *scene);

#endif
