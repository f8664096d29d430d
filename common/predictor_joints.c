#include "common/predictor_parts.h"

/* gaps as laid: evenly up to this, none beyond the slack (report 2.6) */
#define LAID_GAP_IN     0.036f
#define SURVEY_ERROR_IN 0.005f
/* in that time a wheel comes half a mat further; 8 double the error */
#define FOLLOW_BLOCKS   4u
#define FOLLOW_VISITS   3u /* what a group costs then, in joints looked at */

/* Evenly spread over 0..1: fractions of the multiples of an irrational number, in 24 bits. */
static float spread(uint32_t i, uint32_t multiplier)
{
    return (float)(i * multiplier >> 8) * (1.0f / 16777216.0f);
}

/* Closing resistance of a joint over their mean. */
static float grit_share(unsigned joint)
{
    return 2.0f * spread(joint, 2654435769u); /* 2^32 (sqrt 5 - 1) / 2 */
}

/* --- openings --- */

void mr_predictor_lay(struct mr_predictor *p)
{
    float slack_ft = p->config.chain.slack_ft;
    for (unsigned j = 0; j <= MR_CHAIN_MATS; j++) {
        /* 2^32 (sqrt 2 - 1) */
        float gap_ft = LAID_GAP_IN / IN_PER_FT * spread(j + 1u, 1779033704u);
        p->gap_ft[j] = gap_ft < slack_ft ? gap_ft : slack_ft;
    }
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

/* Joints that have been pushed come to differ by `missing_ft` in sum: those of least resistance
 * close first, those of most are the open ones, for a few wide gaps are likelier there than many
 * narrow ones. */
static void reopen(float *gap_ft, unsigned first, unsigned count, float missing_ft, float slack_ft)
{
    bool taken[MR_MATS_PER_SEGMENT] = {false};
    for (unsigned pass = 0; pass < count && missing_ft != 0.0f; pass++) {
        unsigned pick = count;
        for (unsigned j = 0; j < count; j++) {
            bool better = pick == count || (missing_ft < 0.0f) == (grit_share(first + j + 1u) <
                                                                   grit_share(first + pick + 1u));
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

/* Joints of a segment, 0 beyond the runway. */
static unsigned joints_in(const struct mr_predictor *p, unsigned segment)
{
    unsigned first = segment * MR_MATS_PER_SEGMENT;
    unsigned left = first < joints_of(p) ? joints_of(p) - first : 0;
    return left < MR_MATS_PER_SEGMENT ? left : MR_MATS_PER_SEGMENT;
}

static float sum_ft(const struct mr_predictor *p, unsigned segment)
{
    float sum = 0.0f;
    for (unsigned j = 0; j < joints_in(p, segment); j++)
        sum += p->gap_ft[segment * MR_MATS_PER_SEGMENT + j];
    return sum;
}

/* Whether so many joints can have the sum, an error of the reading allowed. */
static bool can_be(const struct mr_predictor *p, unsigned segment, float sum_in)
{
    float most_in = IN_PER_FT * p->config.chain.slack_ft * (float)joints_in(p, segment);
    return joints_in(p, segment) > 0 &&
           between(sum_in, -4.0f * SURVEY_ERROR_IN, most_in + 4.0f * SURVEY_ERROR_IN);
}

void mr_predictor_survey(struct mr_predictor *p, const float *sum_in)
{
    float slack_ft = p->config.chain.slack_ft, error_ft = 2.0f * SURVEY_ERROR_IN / IN_PER_FT;
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        unsigned first = s * MR_MATS_PER_SEGMENT, count = joints_in(p, s);
        float have_ft = sum_ft(p, s), off_ft = sum_in[s] / IN_PER_FT - have_ft;
        p->surveyed_in[s] = can_be(p, s, sum_in[s]) ? sum_in[s] : MR_NAN;
        if (__builtin_isnan(p->surveyed_in[s]))
            continue;
        if (!(off_ft > error_ft || off_ft < -error_ft))
            continue;
        if (p->landings == 0 && sum_in[s] / IN_PER_FT > 0.5f * have_ft) {
            rescale(p->gap_ft + first, count, have_ft, sum_in[s] / IN_PER_FT, slack_ft);
            continue;
        }
        if (p->landings == 0) { /* somebody has landed before: as few are open as can be */
            for (unsigned j = 0; j < count; j++)
                p->gap_ft[first + j] = 0.0f;
            off_ft = sum_in[s] / IN_PER_FT;
        }
        reopen(p->gap_ft, first, count, off_ft, slack_ft);
    }
}

void mr_predictor_surveyed(struct mr_predictor *p, const float *sum_in)
{
    float error_in = 2.0f * SURVEY_ERROR_IN + 1e-3f;
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        float have_in = IN_PER_FT * sum_ft(p, s),
              most_in = IN_PER_FT * p->config.chain.slack_ft * (float)joints_in(p, s);
        float said_in = sum_in[s] < 0.0f ? 0.0f : sum_in[s] > most_in ? most_in : sum_in[s];
        bool holds = can_be(p, s, sum_in[s]) && between(have_in - said_in, -error_in, error_in);
        p->surveyed_in[s] = holds ? sum_in[s] : MR_NAN;
    }
}

/* What transducers and survey say without the model. */
void mr_predictor_find_kinematic(const struct mr_predictor *p, struct mr_closure_zone *zone,
                                 float *left_in)
{
    float slack_in[MR_SEGMENTS], moved_in[MR_TRANSDUCERS];
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        /* what it had moved before, the joints have taken already */
        moved_in[i] = p->last_in[i] - p->base_in[i];
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        slack_in[s] = joints_in(p, s) == MR_MATS_PER_SEGMENT ? IN_PER_FT * sum_ft(p, s) : MR_NAN;
    const struct mr_closure_input input = {.station_ft = p->config.station_ft,
                                           .displacement_in = moved_in,
                                           .slack_in = slack_in,
                                           .wheel_ft = p->wheel_ft,
                                           .speed_ft_s = p->speed_ft_s,
                                           .deceleration_ft_s2 = p->deceleration_ft_s2};
    mr_closure_find(&input, zone, left_in);
}

/* The joints as the transducers alone would have them. */
void mr_predictor_fold_kinematic(struct mr_predictor *p)
{
    struct mr_closure_zone zone;
    float left_in[MR_SEGMENTS];
    mr_predictor_find_kinematic(p, &zone, left_in);
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        float off_ft = left_in[s] / IN_PER_FT - sum_ft(p, s);
        if (off_ft < 0.0f)
            reopen(p->gap_ft, s * MR_MATS_PER_SEGMENT, joints_in(p, s), off_ft,
                   p->config.chain.slack_ft);
    }
}

/* The joints as the chain has them. */
void mr_predictor_fold_chain(struct mr_predictor *p)
{
    const struct mr_chain *chain = &p->chain;
    float slack_ft = p->config.chain.slack_ft;
    for (unsigned j = 1; j <= chain->count + 1u; j++) {
        unsigned first = (j - 1u) * chain->group, count = chain->group;
        float have_ft = 0.0f, to_ft = mr_chain_opening_ft(chain, j);
        if (first >= joints_of(p))
            break;
        if (first + count > joints_of(p))
            count = joints_of(p) - first;
        for (unsigned i = 0; i < count; i++)
            have_ft += p->gap_ft[first + i];
        if (__builtin_isnan(to_ft))
            continue; /* as it was */
        to_ft = to_ft < 0.0f                    ? 0.0f
              : to_ft > slack_ft * (float)count ? slack_ft * (float)count
                                                : to_ft;
        reopen(p->gap_ft, first, count, to_ft - have_ft, slack_ft);
    }
}

/* --- resistances --- */

/* What resists in a group of joints now, over the mean: the weakest closes first, so that of the
 * weakest which is still open, as far as the group has closed. */
static float open_share(const struct mr_predictor *p, unsigned j)
{
    unsigned group = p->chain.group, first = (j - 1u) * group, last = joints_of(p) - 1u;
    float reach_ft = p->chain.reach_ft[j] - 1e-7f, best = 0.0f, most = 0.0f, share[4], gap_ft[4];
    if (group == 1u)
        return grit_share(j);
    for (unsigned i = 0; i < group; i++) {
        share[i] = grit_share(first + i + 1u);
        gap_ft[i] = first + i <= last ? p->gap_ft[first + i] : 0.0f;
        most = share[i] > most ? share[i] : most;
    }
    for (unsigned i = 0; i < group; i++) {
        float stronger_ft = 0.0f;
        for (unsigned k = 0; k < group; k++)
            stronger_ft += share[k] > share[i] ? gap_ft[k] : 0.0f;
        if (stronger_ft < reach_ft && (best == 0.0f || share[i] < best))
            best = share[i];
    }
    return best > 0.0f ? best : most;
}

/* What must be overcome for a group to count as closed: four are when the last of them is; of two,
 * as the score has it, either stands for both. */
static float shut_share(const struct mr_predictor *p, unsigned j)
{
    unsigned group = p->chain.group;
    float most = 0.0f;
    for (unsigned i = 1; i <= (group == 4u ? 4u : 1u); i++) {
        float share = grit_share((j - 1u) * group + i);
        most = share > most ? share : most;
    }
    return most;
}

void mr_predictor_set_grits(struct mr_predictor *p)
{
    struct mr_chain *chain = &p->chain;
    float mean_lb = p->config.grit_lb * p->scale;
    for (unsigned j = 1; j <= chain->count + 1u; j++) {
        chain->grit_lb[j] = mean_lb * open_share(p, j);
        if (chain->group > 1u)
            p->shut_lb[j] = mean_lb * shut_share(p, j);
    }
}

/* Groups that move go from joint to joint. */
void mr_predictor_follow_grits(struct mr_predictor *p)
{
    struct mr_chain *chain = &p->chain;
    unsigned first = (chain->low - 1u) * MR_CHAIN_BAY + 1u, last = chain->high * MR_CHAIN_BAY + 1u;
    if (chain->group == 1u || chain->low > chain->high || p->block % FOLLOW_BLOCKS != 0)
        return;
    unsigned followed = 0;
    for (unsigned j = first; j <= last && j <= chain->count + 1u; j++) {
        if (chain->v_ft_s[j] == 0.0f && chain->v_ft_s[j - 1u] == 0.0f)
            continue;
        chain->grit_lb[j] = p->config.grit_lb * p->scale * open_share(p, j);
        followed++;
    }
    p->visits += FOLLOW_VISITS * followed;
    p->look_updates += FOLLOW_VISITS * followed / MR_PREDICTOR_VISITS_PER_UPDATE;
}
