#include "common/onboard/release.h"

#include "common/wire.h"

#define LEAST_FT_S  2.0f
#define EASED_SHARE 0.9f /* of the braking of now: less is worth easing to */
#define LEAST_GATES 3u   /* beyond touchdown: speed and braking rest on them */
#define OVERDUE     1.3f /* of the gates' spacing, since the last one */

/* To act on a probability p pays when p times what a miss costs is more than 1 - p times what a
 * needless act does. */
static float limit_of(float cost_ratio)
{
    return 1.0f / (1.0f + cost_ratio);
}

void release_settings_of(const struct mr_config *config, bool crystal,
                         struct release_settings *settings)
{
    const struct mr_risk_config *risk = &config->risk[0];
    *settings = (struct release_settings){
        .lamp_limit = limit_of(risk->lamp_cost_ratio),
        .release_limit = risk->release ? limit_of(risk->release_cost_ratio) : MR_NAN,
        .hold_blocks = (float)risk->release_hold_ms,
        .most_blocks = (float)risk->release_most_ms,
        .coasting_ft_s2 = risk->coasting_ft_s2,
        .spare_ft = risk->spare_ft,
        .crystal = crystal ? 1.0f : 0.0f,
        .eases = risk->release == 2u ? 1.0f : 0.0f};
}

static float *setting(struct release_settings *s, unsigned n)
{
    float *const all[RELEASE_SETTINGS] = {&s->lamp_limit,  &s->release_limit,  &s->hold_blocks,
                                          &s->most_blocks, &s->coasting_ft_s2, &s->spare_ft,
                                          &s->crystal,     &s->eases};
    return n < RELEASE_SETTINGS ? all[n] : NULL;
}

float release_setting(const struct release_settings *settings, unsigned n)
{
    struct release_settings copy = *settings;
    const float *at = setting(&copy, n);
    return at ? *at : MR_NAN;
}

bool release_setting_set(struct release_settings *settings, unsigned n, float value)
{
    float *at = setting(settings, n);
    if (at)
        *at = value;
    return at != NULL;
}

void release_arm(struct release *release, const struct release_settings *settings, uint32_t index)
{
    *release =
        (struct release){.settings = *settings, .changed_block = index, .ease_ft_s2 = MR_NAN};
}

/* That it waits is no news. */
static bool change(struct release *release, enum mr_release_state state,
                   enum mr_release_reason reason, uint32_t index)
{
    if (release->state == state && (release->reason == reason || state == MR_RELEASE_READY)) {
        release->reason = (uint8_t)reason;
        return false;
    }
    release->state = (uint8_t)state;
    release->reason = (uint8_t)reason;
    release->changed_block = index;
    return true;
}

bool release_end(struct release *release, uint32_t index)
{
    release->beyond = false;
    release->ease_ft_s2 = MR_NAN;
    return release_asked(release) && change(release, MR_RELEASE_OVER, MR_RELEASE_NO_ROLL, index);
}

/* The least deceleration that stops it with enough runway left. */
static float least_ft_s2(const struct release_settings *s, const struct mr_predictor *p)
{
    float runway_ft = p->config.chain.mat_length_ft * (float)p->config.chain.mats,
          left_ft = runway_ft - s->spare_ft - p->wheel_ft;
    return left_ft > 0.0f ? 0.5f * p->speed_ft_s * p->speed_ft_s / left_ft : 1e6f;
}

/* Motion rests on the gates of this passage, and none is overdue: where switches are lost, what is
 * known of it is carried on from a time that is past. */
static bool on_switches(const struct landing *landing, const struct mr_predictor *p)
{
    const struct mr_passage *passage = &landing->passage;
    unsigned gates = passage->gates;
    double spacing_ft = 1e6;
    if (passage->state != MR_PASSAGE_ROLLING || gates < landing->gates_on_track + LEAST_GATES)
        return false;
    for (unsigned i = 1; i < gates; i++) {
        double apart_ft = passage->gate[i].station_ft - passage->gate[i - 1u].station_ft;
        spacing_ft = apart_ft < spacing_ft ? apart_ft : spacing_ft;
    }
    return p->wheel_ft <= (float)passage->gate[gates - 1u].station_ft + OVERDUE * (float)spacing_ft;
}

/* What speaks against releasing the brake now; MR_RELEASE_BY_RISK: nothing does. */
static enum mr_release_reason obstacle(const struct release *release, const struct mr_predictor *p,
                                       const struct mr_predictor_zone *zone,
                                       const struct landing *landing, uint32_t index)
{
    const struct release_settings *s = &release->settings;
    if (!(s->crystal > 0.5f))
        return MR_RELEASE_NO_CLOCK;
    if (landing->state != LANDING_LANDING || !landing_may_warn(landing, index))
        return MR_RELEASE_NO_ROLL;
    if (!p->braking || __builtin_isnan(p->wheel_ft) || __builtin_isnan(p->speed_ft_s) ||
        !on_switches(landing, p))
        return MR_RELEASE_NO_MOTION;
    if (!(p->speed_ft_s > LEAST_FT_S))
        return MR_RELEASE_NO_ROLL;
    if (zone->basis & (MR_PREDICTOR_BLIND | MR_PREDICTOR_FELL_BACK) ||
        zone->level == MR_PREDICTOR_KINEMATIC)
        return MR_RELEASE_NO_MODEL;
    float most_ft_s2 = s->coasting_ft_s2;
    if (s->eases > 0.5f) {
        float braked_ft_s2 = release_asked(release) ? release->braked_ft_s2 : p->deceleration_ft_s2;
        if (EASED_SHARE * braked_ft_s2 > most_ft_s2)
            most_ft_s2 = EASED_SHARE * braked_ft_s2;
    }
    return least_ft_s2(s, p) <= most_ft_s2 ? MR_RELEASE_BY_RISK : MR_RELEASE_NO_RUNWAY;
}

static void ease(struct release *release, const struct mr_predictor *p)
{
    float least = least_ft_s2(&release->settings, p);
    release->ease_ft_s2 = release_asked(release) && least > release->settings.coasting_ft_s2
                            ? least
                            : MR_NAN;
}

bool release_look(struct release *release, const struct mr_predictor *p,
                  const struct mr_predictor_zone *zone, const struct mr_risk_said *said,
                  const struct landing *landing, uint32_t index)
{
    const struct release_settings *s = &release->settings;
    if (__builtin_isnan(s->release_limit) || release->state == MR_RELEASE_OVER)
        return false;
    enum mr_release_reason reason = obstacle(release, p, zone, landing, index);
    if (release_asked(release)) {
        release->asked_blocks = index - release->changed_block;
        if (reason == MR_RELEASE_BY_RISK && (float)release->asked_blocks >= s->most_blocks)
            reason = MR_RELEASE_TIME_UP;
        bool over = reason != MR_RELEASE_BY_RISK && change(release, MR_RELEASE_OVER, reason, index);
        ease(release, p);
        return over;
    }
    bool beyond = said->risk >= s->release_limit;
    if (beyond && !release->beyond)
        release->beyond_block = index;
    release->beyond = beyond;
    if (!beyond)
        return change(release, MR_RELEASE_READY, MR_RELEASE_NO_REASON, index);
    if ((float)(index - release->beyond_block) < s->hold_blocks)
        return change(release, MR_RELEASE_READY, MR_RELEASE_WAITS, index);
    if (reason != MR_RELEASE_BY_RISK)
        return change(release, MR_RELEASE_REFUSED, reason, index);
    release->braked_ft_s2 = p->deceleration_ft_s2;
    bool changed = change(release, MR_RELEASE_ASKED, reason, index);
    ease(release, p);
    return changed;
}

bool release_lamp(const struct release_settings *settings, const struct mr_predictor_zone *zone,
                  const struct mr_risk_said *said)
{
    if (__builtin_isnan(settings->lamp_limit) || __builtin_isnan(said->risk))
        return zone->verdict == MR_PREDICTOR_WARNING;
    return said->risk >= settings->lamp_limit;
}
