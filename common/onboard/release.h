/* What the board does by the risk (common/risk.h): from where on the lamp warns, and when it asks
 * for the brake to be released. Braking is the safe state: each doubt refuses.
 *
 * Asked for when the risk of a zone or that of a bow wave has stayed at the limit or beyond for the
 * time configured, and
 *  - a gear rolls on the runway, and nobody pushes it
 *  - motion and braking rest on switches: three beyond touchdown, and the next is not overdue
 *  - the clock is the crystal: else no speed is known
 *  - transducers speak, and the model has not fallen back
 *  - as it is braked while released it stops with the configured length of runway left; or, where
 *    the circuit can ease the brake to what it is told, that takes clearly less than the braking of
 *    now. Then the brake is eased to the least that stops there, told anew with each look. Pulses
 *    are no substitute: what they leave of the braking raises waves (tests/score/README.md).
 * Once asked for it stays so until one of these is no longer so (but the risk), or the longest time
 * is over; then not again in this landing. What refuses is told, and asked again at each look.
 *
 * Pure: the board runs it, and the host runs it again. Feet, seconds; time in blocks of 1 ms. */
#ifndef MATRIG_COMMON_ONBOARD_RELEASE_H
#define MATRIG_COMMON_ONBOARD_RELEASE_H

#include "common/config.h"
#include "common/onboard/landing.h"
#include "common/risk.h"

/* Of the configuration, group risk, and of the clock; numbers, as they are told. */
struct release_settings {
    float lamp_limit;    /* NaN: the lamp follows the verdict */
    float release_limit; /* NaN: no brake release is wired */
    float hold_blocks, most_blocks;
    float coasting_ft_s2, spare_ft;
    float crystal; /* 1: the clock is the crystal */
    float eases;   /* 1: the circuit eases the brake to what it is told */
};
/* Chart and plan (common/risk.h), then these: the list that the message risk_item tells. */
#define RELEASE_SETTINGS 8u
#define RELEASE_ITEMS    (MR_RISK_ITEMS + RELEASE_SETTINGS)

void release_settings_of(const struct mr_config *config, bool crystal,
                         struct release_settings *settings);
float release_setting(const struct release_settings *settings, unsigned n);
/* False: there is no such. */
bool release_setting_set(struct release_settings *settings, unsigned n, float value);

struct release {
    struct release_settings settings;
    uint8_t state, reason;  /* enum mr_release_state, mr_release_reason */
    uint32_t changed_block; /* of the last change */
    float ease_ft_s2;       /* asked for; NaN: not, or to be released altogether */
    float braked_ft_s2;     /* when it was asked for */
    bool beyond;
    uint32_t beyond_block; /* since when */
    uint32_t asked_blocks; /* so long it was asked for in this landing */
};

/* A landing is armed. */
void release_arm(struct release *release, const struct release_settings *settings, uint32_t index);
/* Over, or disarmed: not asked for any more. True: it was, and that is to be told. */
bool release_end(struct release *release, uint32_t index);
/* One look. True: state or reason have changed. */
bool release_look(struct release *release, const struct mr_predictor *predictor,
                  const struct mr_predictor_zone *zone, const struct mr_risk_said *said,
                  const struct landing *landing, uint32_t index);
static inline bool release_asked(const struct release *release)
{
    return release->state == MR_RELEASE_ASKED;
}
/* Does the lamp warn? Where no limit is set, or no risk is known, it follows the verdict. */
bool release_lamp(const struct release_settings *settings, const struct mr_predictor_zone *zone,
                  const struct mr_risk_said *said);

#endif
