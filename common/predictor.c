#include "common/predictor.h"

#include <string.h>

#include "common/wire.h"

#define IN_PER_FT 12.0f
#define G_FT_S2 32.174f
#define DESIGN_GAP_IN 0.036f        /* gaps as laid: evenly up to this, none beyond the slack (report 2.6) */
#define CLOSED_FT (0.002f / 12.0f)
#define SPRING_LB_FT 3000.0f
#define SPRING_MOST_LB 16.0f
#define SCALE_RATE 0.0f           /* per look and pound drawn */
#define SCALE_LEAST 0.3f
#define SCALE_MOST 2.5f
#define REACH_FT 20.0f              /* ahead of the wheel: what moves there tells of the resistance */
#define AHEAD_GROUPS 2.0f
#define SURVEY_ERROR_IN 0.005f

/* Evenly spread over 0..1: fractions of the multiples of an irrational number, in 24 bits. */
static float spread(uint32_t i, uint32_t multiplier)
{
    return (float)(i * multiplier >> 8) * (1.0f / 16777216.0f);
}

static float grit_share(unsigned joint)
{
    return 2.0f * spread(joint, 2654435769u); /* 2^32 (sqrt 5 - 1) / 2 */
}

static unsigned joints_of(const struct mr_predictor *p)
{
    return p->config.chain.mats + 1u;
}

static unsigned group_of(enum mr_predictor_level level)
{
    return level == MR_PREDICTOR_TWO ? 2u : level == MR_PREDICTOR_FOUR ? 4u : 1u;
}

static void set_grits(struct mr_predictor *p)
{
    struct mr_chain *chain = &p->chain;
    for (unsigned j = 1; j <= chain->count + 1u; j++)
        chain->grit_lb[j] = p->config.grit_lb * p->scale * grit_share((j - 1u) * chain->group + 1u);
}

static enum mr_status start_chain(struct mr_predictor *p)
{
    struct mr_chain_params params = p->config.chain;
    static const float none[MR_CHAIN_MATS + 1u]; /* resistances follow */
    enum mr_status status = mr_chain_start(&p->chain, &params, group_of(p->level), p->gap_ft, none);
    if (status == MR_OK)
        set_grits(p);
    return status;
}

enum mr_status mr_predictor_start(struct mr_predictor *p, const struct mr_predictor_config *config)
{
    memset(p, 0, sizeof *p);
    p->config = *config;
    p->scale = 1.0f;
    p->level = config->level;
    p->deceleration_ft_s2 = config->deceleration_ft_s2;
    p->wheel_ft = p->speed_ft_s = MR_NAN;
    for (unsigned j = 0; j <= MR_CHAIN_MATS; j++) {
        float gap_ft = DESIGN_GAP_IN / IN_PER_FT * spread(j + 1u, 1779033704u); /* 2^32 (sqrt 2 - 1) */
        p->gap_ft[j] = gap_ft < config->chain.slack_ft ? gap_ft : config->chain.slack_ft;
    }
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        p->surveyed_in[s] = MR_NAN;
    return start_chain(p);
}

/* Ten joints as laid come to sum to `sum_ft`: all by one factor, or nearer to the slack by one. */
static void rescale(float *gap_ft, unsigned count, float have_ft, float sum_ft, float slack_ft)
{
    float room_ft = slack_ft * (float)count - have_ft;
    if (sum_ft < have_ft) {
        for (unsigned j = 0; j < count; j++)
            gap_ft[j] *= sum_ft / have_ft;
        return;
    }
    float part = sum_ft - have_ft < room_ft ? (sum_ft - have_ft) / room_ft : 1.0f;
    for (unsigned j = 0; j < count && room_ft > 0.0f; j++)
        gap_ft[j] += part * (slack_ft - gap_ft[j]);
}

/* Joints that have been pushed come to differ by `missing_ft` in sum: those of least resistance close first, those of most
 * are the open ones, for a few wide gaps are likelier there than many narrow ones. */
static void reopen(float *gap_ft, unsigned first, unsigned count, float missing_ft, float slack_ft)
{
    bool taken[MR_MATS_PER_SEGMENT] = {false};
    for (unsigned pass = 0; pass < count && missing_ft != 0.0f; pass++) {
        unsigned pick = count;
        for (unsigned j = 0; j < count; j++) {
            bool better = pick == count || (missing_ft < 0.0f) == (grit_share(first + j + 1u) < grit_share(first + pick + 1u));
            if (!taken[j] && better)
                pick = j;
        }
        taken[pick] = true;
        float to_ft = gap_ft[first + pick] + missing_ft;
        to_ft = to_ft < 0.0f ? 0.0f : to_ft > slack_ft ? slack_ft : to_ft;
        missing_ft -= to_ft - gap_ft[first + pick];
        gap_ft[first + pick] = to_ft;
    }
}

void mr_predictor_survey(struct mr_predictor *p, const float *sum_in)
{
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        unsigned first = s * MR_MATS_PER_SEGMENT, count = MR_MATS_PER_SEGMENT;
        p->surveyed_in[s] = sum_in[s];
        if (__builtin_isnan(sum_in[s]) || first >= joints_of(p))
            continue;
        if (first + count > joints_of(p))
            count = joints_of(p) - first;
        float have_ft = 0.0f;
        for (unsigned j = 0; j < count; j++)
            have_ft += p->gap_ft[first + j];
        float off_ft = sum_in[s] / IN_PER_FT - have_ft, error_ft = 2.0f * SURVEY_ERROR_IN / IN_PER_FT;
        if (off_ft <= error_ft && off_ft >= -error_ft)
            continue;
        if (p->landings == 0)
            rescale(p->gap_ft + first, count, have_ft, sum_in[s] / IN_PER_FT, p->config.chain.slack_ft);
        else
            reopen(p->gap_ft, first, count, off_ft, p->config.chain.slack_ft);
    }
}

void mr_predictor_arm(struct mr_predictor *p)
{
    p->armed = true;
    p->rolled = p->fell_back = p->braking = false;
    p->level = p->config.level;
    p->block = p->changed_block = p->last_valid_block = 0;
    p->updates = p->look_updates = 0;
    p->drawn_lb = 0.0f;
    p->wheel_ft = p->speed_ft_s = MR_NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        p->last_in[i] = MR_NAN;
    (void)start_chain(p); /* of parameters that mr_predictor_start has accepted */
}

static unsigned mat_at(const struct mr_predictor *p, float station_ft)
{
    if (!(station_ft >= 0.0f))
        return 0;
    unsigned mat = (unsigned)(station_ft / p->config.chain.mat_length_ft + 1e-4f) + 1u;
    return mat <= p->config.chain.mats ? mat : 0;
}

/* The springs at the transducers. Returns what they draw ahead of the wheel, where the resistance tells. */
static float draw(struct mr_predictor *p, const struct mr_predictor_input *input)
{
    float drawn_lb = 0.0f;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        unsigned mat = mat_at(p, p->config.station_ft[i]);
        if (!mat)
            continue;
        float reading_in = input->displacement_in[i];
        float was_in = p->last_in[i];
        p->last_in[i] = was_in + (reading_in - was_in) * 0.02f;
        if (__builtin_isnan(was_in))
            p->last_in[i] = reading_in;
        if (__builtin_isnan(reading_in)) {
            mr_chain_push(&p->chain, mat, 0.0f);
            continue;
        }
        float off_ft = reading_in / IN_PER_FT - mr_chain_displacement_ft(&p->chain, mat);
        float force_lb = SPRING_LB_FT * off_ft;
        force_lb = force_lb > SPRING_MOST_LB ? SPRING_MOST_LB : force_lb < -SPRING_MOST_LB ? -SPRING_MOST_LB : force_lb;
        mr_chain_push(&p->chain, mat, force_lb);
        float ahead_ft = p->config.station_ft[i] - input->wheel_ft;
        if (ahead_ft > 0.0f) {
            p->last_valid_block = p->block;
            if (ahead_ft < REACH_FT && !__builtin_isnan(was_in))
                drawn_lb += force_lb * (reading_in - was_in);
        }
    }
    return drawn_lb;
}

static void roll(struct mr_predictor *p, const struct mr_predictor_input *input)
{
    float step_s = p->chain.step_s, speed_ft_s = input->speed_ft_s;
    unsigned steps = (unsigned)(1e-3f / step_s + 0.5f);
    float thrust_lb = 0.0f;
    if (input->on_runway && speed_ft_s > 0.0f)
        thrust_lb = p->config.thrust_lb_per_g * p->deceleration_ft_s2 / G_FT_S2;
    for (unsigned k = 0; k < steps; k++) {
        float at_ft = input->wheel_ft + speed_ft_s * step_s * ((float)k + 0.5f);
        mr_chain_step(&p->chain, mat_at(p, at_ft), thrust_lb);
    }
}

void mr_predictor_block(struct mr_predictor *p, const struct mr_predictor_input *input)
{
    p->block++;
    if (input->braking_known && input->deceleration_ft_s2 > 0.0f)
        p->deceleration_ft_s2 = input->deceleration_ft_s2;
    p->braking = p->braking || input->braking_known;
    p->wheel_ft = input->wheel_ft;
    p->speed_ft_s = input->speed_ft_s;
    if (__builtin_isnan(input->wheel_ft))
        return;
    float drawn_lb = draw(p, input);
    p->drawn_lb += drawn_lb * 0.02f;
    roll(p, input);
    (void)mr_chain_settle(&p->chain);
    p->updates += mr_chain_take_updates(&p->chain);
    if (p->block % MR_PREDICTOR_LOOK_BLOCKS != 0)
        return;
    float factor = 1.0f / (1.0f + SCALE_RATE * p->drawn_lb);
    p->scale *= factor;
    p->scale = p->scale < SCALE_LEAST ? SCALE_LEAST : p->scale > SCALE_MOST ? SCALE_MOST : p->scale;
    p->drawn_lb = 0.0f;
    set_grits(p);
}

/* Longest run of joints from `from` on, closed at both ends, in which no ten in a row have more than one open. */
static unsigned longest(const struct mr_chain *chain, unsigned from, unsigned *first_out)
{
    unsigned best = 0, first = 0, last_open = 0;
    bool any_open = false;
    float closed_ft = CLOSED_FT * (float)chain->group;
    for (unsigned j = from; j <= chain->count + 1u; j++) {
        if (mr_chain_opening_ft(chain, j) > closed_ft) {
            if (any_open && j - last_open < MR_PREDICTOR_TALLY_MATS / chain->group)
                first = 0; /* only what follows the last open joint may go on */
            if (!first) {
                for (unsigned k = any_open ? last_open + 1u : from; k < j && !first; k++)
                    first = mr_chain_opening_ft(chain, k) > closed_ft ? 0 : k;
            }
            last_open = j;
            any_open = true;
            continue;
        }
        if (!first)
            first = j;
        if (j - first > best) {
            best = j - first;
            *first_out = first;
        }
    }
    return best;
}

/* Length of the zone that begins at group `from` when `thrust_lb` pushes there and nothing has inertia: compression falls by each
 * group's friction, and joints close that it overcomes. */
static unsigned ploughed(const struct mr_chain *chain, unsigned from, float thrust_lb)
{
    unsigned best = 0, first = 0, last_open = 0, tally = MR_PREDICTOR_TALLY_MATS / chain->group;
    float press_lb = thrust_lb;
    for (unsigned j = from + 1u; j <= chain->count + 1u; j++) {
        press_lb -= chain->friction_lb;
        bool open = mr_chain_opening_ft(chain, j) > CLOSED_FT * (float)chain->group && !(press_lb > chain->grit_lb[j]);
        if (!open) {
            if (!first)
                first = j;
            best = j - first;
            continue;
        }
        if (first && last_open && j - last_open < tally)
            break;
        if (!first && j - from > tally)
            break; /* nothing begins at the wheel */
        last_open = j;
    }
    return best;
}

/* What the wheel will meet or push together on its way to where it stops at the present deceleration; before that is known, where
 * twice the assumed one would stop it: so far it comes nearly always. */
static void look_ahead(const struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    const struct mr_chain *chain = &p->chain;
    float group_ft = p->config.chain.mat_length_ft * (float)chain->group;
    float thrust_lb = p->config.thrust_lb_per_g * p->deceleration_ft_s2 / G_FT_S2;
    float stopping_ft_s2 = p->braking ? p->deceleration_ft_s2 : 2.0f * p->config.deceleration_ft_s2;
    float stop_ft = p->wheel_ft + 0.5f * p->speed_ft_s * p->speed_ft_s / stopping_ft_s2;
    zone->coming_ft = MR_NAN;
    for (float at_ft = p->wheel_ft > 0.0f ? p->wheel_ft : 0.0f; at_ft < stop_ft; at_ft += AHEAD_GROUPS * group_ft) {
        unsigned n = (unsigned)(at_ft / group_ft) + 1u;
        if (n >= chain->count)
            break;
        unsigned mats = ploughed(chain, n, thrust_lb) * chain->group;
        if (mats > zone->coming_mats) {
            zone->coming_mats = mats;
            zone->coming_ft = at_ft;
        }
    }
}

void mr_predictor_zone(struct mr_predictor *p, struct mr_predictor_zone *zone)
{
    float length_ft = p->config.chain.mat_length_ft;
    float wheel_ft = p->wheel_ft > 0.0f ? p->wheel_ft : 0.0f;
    unsigned from = (unsigned)(wheel_ft / (length_ft * (float)p->chain.group)) + 2u, first = 0;
    memset(zone, 0, sizeof *zone);
    zone->level = p->level;
    zone->grit_scale = p->scale;
    unsigned mats = longest(&p->chain, from, &first) * p->chain.group;
    zone->mats = mats;
    if (mats) {
        zone->start_ft = (float)((first - 1u) * p->chain.group) * length_ft;
        zone->end_ft = zone->start_ft + (float)mats * length_ft;
    }
    if (p->speed_ft_s > 0.0f)
        look_ahead(p, zone);
    if (zone->coming_mats >= MR_PREDICTOR_WARNING_MATS) {
        zone->verdict = MR_PREDICTOR_WARNING;
        zone->reason = MR_PREDICTOR_GROWING_ZONE;
    }
}

void mr_predictor_fold(struct mr_predictor *p)
{
    for (unsigned j = 1; j <= p->chain.count + 1u && p->chain.group == 1; j++) {
        float g_ft = mr_chain_opening_ft(&p->chain, j);
        g_ft = g_ft < 0.0f ? 0.0f : g_ft;
        p->gap_ft[j - 1u] = g_ft > p->config.chain.slack_ft ? p->config.chain.slack_ft : g_ft;
    }
    p->armed = false;
    p->landings++;
}
