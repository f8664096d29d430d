#include "common/predictor_parts.h"

#include <string.h>

#define BLOCK_S     1e-3f
#define HMIL_PER_FT 1.2e6f

/* Correction. Found on seeds of `make score` that the tables are not made of. */
#define SPRING_LB_FT    3000.0f
#define SPRING_MOST_LB  16.0f
#define DRAWN_AHEAD_FT  60.0f /* stations so far ahead of the wheel are drawn, */
/* and so far behind it: the mat practically ceases to move as the gear passes (2.7.2) */
#define DRAWN_BEHIND_FT 5.0f
/* ahead of the wheel: what moves there tells of the resistance */
#define TELLING_FT      40.0f
#define SCALE_PER_LB_IN 0.02f
#define SCALE_LEAST     0.3f
#define SCALE_MOST      2.5f
#define SLOW            0.02f /* 1 over 50 blocks */

/* Doubt. */
#define DRIFT_IN        0.02f
#define MOST_IN         (IN_PER_FT * MR_CHAIN_RUNAWAY_FT) /* no reading */
#define DISAGREE_IN     0.25f
#define DISAGREE_BLOCKS 300u

#define MOST_FT       10000.0f /* no place of a wheel */
#define MOST_FT_S     300.0f
#define MOST_FT_S2    64.0f /* twice what locked wheels have */
#define MOVED_IN      0.05f /* without switches: something rolls */
/* a deceleration that differs by less does not begin a search anew */
#define SAME_BRAKING  0.01f
#define CALM_LOOKS    10u
#define MOST_FAILURES 3u

static unsigned group_of(enum mr_predictor_level level)
{
    return level == MR_PREDICTOR_TWO ? 2u : level == MR_PREDICTOR_FOUR ? 4u : 1u;
}

static unsigned mat_at(const struct mr_predictor *p, float station_ft)
{
    if (!(station_ft >= 0.0f && station_ft < 1e6f))
        return 0;
    unsigned mat = (unsigned)(station_ft / p->config.chain.mat_length_ft + 1e-4f) + 1u;
    return mat <= p->config.chain.mats ? mat : 0;
}

/* --- the chain --- */

static enum mr_status start_chain(struct mr_predictor *p)
{
    const struct mr_chain_params params = p->config.chain;
    /* resistances follow */
    enum mr_status status = mr_chain_start(&p->chain, &params, group_of(p->level), p->gap_ft, NULL);
    p->due_s = 0.0f;
    if (status == MR_OK)
        mr_predictor_set_grits(p);
    return status;
}

/* Model's displacement at a transducer, inches since arming. */
static float modelled_in(const struct mr_predictor *p, unsigned i, unsigned mat)
{
    return p->base_in[i] + IN_PER_FT * mr_chain_displacement_ft(&p->chain, mat);
}

/* Groups joints are looked at from, and places the wheel is imagined at: up to where it stops at
 * the present deceleration; before that is known, where twice the assumed one would stop it: so far
 * it comes nearly always. */
static void begin_scan(struct mr_predictor *p)
{
    const struct mr_chain *chain = &p->chain;
    float group_ft = p->config.chain.mat_length_ft * (float)chain->group,
          end_ft = group_ft * (float)chain->count;
    float wheel_ft = p->wheel_ft > 0.0f ? p->wheel_ft : 0.0f;
    struct mr_zonescan_order order = {.from = (uint16_t)(chain->count + 2u),
                                      .place = 1,
                                      .push_lb = thrust_lb(p),
                                      .grit_lb = chain->group > 1u ? p->shut_lb : chain->grit_lb};
    if (wheel_ft < end_ft) {
        order.place = (uint16_t)((unsigned)(wheel_ft / group_ft) + 1u);
        order.from = (uint16_t)(order.place + 1u);
    }
    if (p->speed_ft_s > 0.0f && wheel_ft < end_ft) {
        float stopping_ft_s2 = p->braking ? p->deceleration_ft_s2
                                          : 2.0f * p->config.deceleration_ft_s2;
        float stop_ft = p->wheel_ft + 0.5f * p->speed_ft_s * p->speed_ft_s / stopping_ft_s2;
        /* an endless stop: the runway's end */
        float last_ft = stop_ft < end_ft ? (stop_ft > 0.0f ? stop_ft : 0.0f) : end_ft;
        order.last_place = (uint16_t)((unsigned)(last_ft / group_ft) + 1u);
    }
    p->scanned_ft_s2 = p->deceleration_ft_s2;
    mr_zonescan_begin(&p->scan, chain, &order);
}

static void take_found(struct mr_predictor *p)
{
    p->found = p->scan.found;
    p->found_group = (uint8_t)p->chain.group;
    p->scan_begun_anew = false;
    begin_scan(p);
}

/* Between landings: all at once. */
static void scan_all(struct mr_predictor *p)
{
    begin_scan(p);
    while (!mr_zonescan_go(&p->scan, &p->chain, MR_CHAIN_PLACES)) {
    }
    take_found(p);
}

/* This block's share of the search. */
static void scan_on(struct mr_predictor *p)
{
    float off_ft_s2 = p->deceleration_ft_s2 - p->scanned_ft_s2,
          same_ft_s2 = SAME_BRAKING * p->scanned_ft_s2;
    if ((off_ft_s2 > same_ft_s2 || off_ft_s2 < -same_ft_s2) && !p->scan_begun_anew) {
        begin_scan(p);
        p->scan_begun_anew = true;
    }
    uint32_t before = p->scan.visits;
    bool complete = mr_zonescan_go(&p->scan, &p->chain, MR_PREDICTOR_VISITS_PER_BLOCK);
    uint32_t visits = p->scan.visits - before;
    p->visits += visits;
    p->look_search += (visits + MR_PREDICTOR_VISITS_PER_UPDATE - 1u) /
                      MR_PREDICTOR_VISITS_PER_UPDATE;
    p->look_updates += (visits + MR_PREDICTOR_VISITS_PER_UPDATE - 1u) /
                       MR_PREDICTOR_VISITS_PER_UPDATE;
    if (complete)
        take_found(p);
}

/* Go on at another level from where the mats are now. */
static void change_level(struct mr_predictor *p, enum mr_predictor_level level)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        unsigned mat = mat_at(p, p->config.station_ft[i]);
        if (mat)
            p->base_in[i] = modelled_in(p, i, mat);
    }
    mr_predictor_fold_chain(p);
    p->level = level;
    p->calm_looks = 0;
    p->degraded = level > p->config.level;
    (void)start_chain(p); /* of parameters that mr_predictor_start has accepted */
    begin_scan(p);
}

/* A guard has tripped: begin again from what is measured, and after too many times go without a
 * model. */
static void fall_back(struct mr_predictor *p)
{
    p->fell_back = true;
    p->failures++;
    mr_predictor_fold_kinematic(p);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        p->base_in[i] = __builtin_isnan(p->last_in[i]) ? 0.0f : p->last_in[i];
    if (p->failures > MOST_FAILURES)
        p->level = MR_PREDICTOR_KINEMATIC;
    (void)start_chain(p);
    begin_scan(p);
}

/* Whether these can be feet, pounds and seconds of a model runway: figures far from it are of
 * another unit, mostly. */
static bool sensible(const struct mr_predictor_config *config)
{
    const struct mr_chain_params *chain = &config->chain;
    float length_ft = chain->mat_length_ft, weight_lb = config->mat_weight_lb;
    return between(length_ft, 0.1f, 2.0f) && between(weight_lb, 0.01f, 100.0f) &&
           between(chain->mass_slug * G_FT_S2 / weight_lb, 0.9f, 1.1f) &&
           between(chain->friction_lb / weight_lb, 0.0f, 1.5f) &&
           between(chain->slack_ft / length_ft, 0.0f, 0.05f) &&
           between(config->bump_ft / length_ft, 1e-5f, 0.1f) &&
           (chain->slack_ft == 0.0f ||
            between(chain->kl_lb_ft * chain->slack_ft, 100.0f, 20000.0f)) &&
           between(config->thrust_lb_per_g / weight_lb, 10.0f, 5000.0f) &&
           between(config->grit_lb, 0.0f, 2000.0f) &&
           between(config->deceleration_ft_s2, 0.1f, MOST_FT_S2) &&
           config->level <= MR_PREDICTOR_PLOUGH;
}

enum mr_status mr_predictor_start(struct mr_predictor *p, const struct mr_predictor_config *config)
{
    memset(p, 0, sizeof *p);
    p->config = *config;
    p->scale = 1.0f;
    p->level = config->level;
    p->deceleration_ft_s2 = config->deceleration_ft_s2;
    p->wheel_ft = p->speed_ft_s = MR_NAN;
    mr_predictor_lay(p);
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        p->surveyed_in[s] = MR_NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        p->last_in[i] = p->slow_in[i] = MR_NAN;
    if (!sensible(config))
        return MR_USAGE;
    enum mr_status status = start_chain(p);
    if (status == MR_OK)
        scan_all(p);
    return status;
}

void mr_predictor_save(const struct mr_predictor *p, struct mr_predictor_state *state)
{
    memset(state, 0, sizeof *state);
    state->mats = p->config.chain.mats;
    state->landings = (uint16_t)(p->landings < UINT16_MAX ? p->landings : UINT16_MAX);
    state->scale = p->scale;
    for (unsigned j = 0; j < joints_of(p); j++)
        state->gap_hmil[j] = (uint16_t)(p->gap_ft[j] * HMIL_PER_FT + 0.5f);
}

enum mr_status mr_predictor_load(struct mr_predictor *p, const struct mr_predictor_state *state)
{
    uint16_t most_hmil = (uint16_t)(p->config.chain.slack_ft * HMIL_PER_FT + 1.5f);
    if (state->mats != p->config.chain.mats ||
        !(state->scale >= SCALE_LEAST && state->scale <= SCALE_MOST))
        return MR_MALFORMED;
    for (unsigned j = 0; j < joints_of(p); j++) {
        if (state->gap_hmil[j] > most_hmil)
            return MR_MALFORMED;
    }
    p->landings = state->landings;
    p->scale = state->scale;
    for (unsigned j = 0; j < joints_of(p); j++)
        p->gap_ft[j] = (float)state->gap_hmil[j] / HMIL_PER_FT;
    enum mr_status status = start_chain(p);
    if (status == MR_OK)
        scan_all(p);
    return status;
}

static void forget_looks(struct mr_predictor *p)
{
    p->look_updates = p->look_search = p->second_updates = 0;
    memset(p->looks, 0, sizeof p->looks);
}

void mr_predictor_arm(struct mr_predictor *p)
{
    p->armed = true;
    p->braking = p->degraded = p->fell_back = false;
    p->moved = 0;
    p->level = p->config.level;
    p->block = p->corrected_block = p->updates = p->visits = p->most_updates = 0;
    forget_looks(p);
    p->calm_looks = p->failures = p->ploughed_mat = 0;
    p->work_lb_in = 0.0f;
    /* the last landing's tells nothing of this one's */
    p->deceleration_ft_s2 = p->config.deceleration_ft_s2;
    p->wheel_ft = p->speed_ft_s = MR_NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        p->last_in[i] = p->slow_in[i] = MR_NAN;
        p->base_in[i] = 0.0f;
        p->doubt[i] = MR_PREDICTOR_TRUSTED;
        p->doubtful_blocks[i] = 0;
    }
    (void)start_chain(p); /* of parameters that mr_predictor_start has accepted */
    scan_all(p);
}

/* --- a block --- */

/* Whether to leave a reading out, from now on in this landing. `off_in`: it minus the model. */
static bool doubted(struct mr_predictor *p, unsigned i, float reading_in, float off_in)
{
    float ahead_ft = p->config.station_ft[i] - p->wheel_ft;
    if (ahead_ft > DRAWN_AHEAD_FT && (reading_in > DRIFT_IN || reading_in < -DRIFT_IN))
        p->doubt[i] = MR_PREDICTOR_DRIFTS;
    /* which is not drawn */
    bool near = ahead_ft < TELLING_FT && ahead_ft > -DRAWN_BEHIND_FT &&
                p->level != MR_PREDICTOR_PLOUGH;
    if (!near || (off_in < DISAGREE_IN && off_in > -DISAGREE_IN))
        p->doubtful_blocks[i] = 0;
    else if (++p->doubtful_blocks[i] >= DISAGREE_BLOCKS)
        p->doubt[i] = MR_PREDICTOR_DISAGREES;
    return p->doubt[i] != MR_PREDICTOR_TRUSTED;
}

/* One transducer: its spring's force, and what it tells of the resistance. */
static float draw(struct mr_predictor *p, unsigned i, unsigned mat, float reading_in)
{
    float ahead_ft = p->config.station_ft[i] - p->wheel_ft;
    float off_in = reading_in - modelled_in(p, i, mat);
    if (doubted(p, i, reading_in, off_in)) {
        p->last_in[i] = MR_NAN;
        return 0.0f;
    }
    p->last_in[i] = reading_in;
    if (reading_in > MOVED_IN || reading_in < -MOVED_IN)
        p->moved |= 1u << i;
    if (__builtin_isnan(p->slow_in[i]))
        p->slow_in[i] = reading_in;
    float moved_in = (reading_in - p->slow_in[i]) * SLOW;
    p->slow_in[i] += moved_in;
    if (!(ahead_ft < DRAWN_AHEAD_FT && ahead_ft > -DRAWN_BEHIND_FT))
        return 0.0f;
    float force_lb = SPRING_LB_FT / IN_PER_FT * off_in;
    force_lb = force_lb > SPRING_MOST_LB  ? SPRING_MOST_LB
             : force_lb < -SPRING_MOST_LB ? -SPRING_MOST_LB
                                          : force_lb;
    p->corrected_block = p->block;
    if (ahead_ft > 0.0f && ahead_ft < TELLING_FT)
        p->work_lb_in += force_lb * moved_in;
    return force_lb;
}

static void draw_all(struct mr_predictor *p, const struct mr_predictor_input *input)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        unsigned mat = mat_at(p, p->config.station_ft[i]);
        float reading_in = input->displacement_in[i];
        if (!mat)
            continue;
        if (!(reading_in < MOST_IN && reading_in > -MOST_IN))
            reading_in = MR_NAN;
        bool missing = __builtin_isnan(reading_in) || p->doubt[i] == MR_PREDICTOR_DRIFTS ||
                       p->doubt[i] == MR_PREDICTOR_DISAGREES;
        if (missing)
            p->last_in[i] = MR_NAN;
        if (__builtin_isnan(reading_in) && p->doubt[i] == MR_PREDICTOR_TRUSTED)
            p->doubt[i] = MR_PREDICTOR_MISSING;
        else if (p->doubt[i] == MR_PREDICTOR_MISSING && !missing)
            p->doubt[i] = MR_PREDICTOR_TRUSTED;
        mr_chain_push(&p->chain, mat, missing ? 0.0f : draw(p, i, mat, reading_in));
    }
}

/* The plough: the wheel on mat n closes joints ahead, nearest first, as far as what is left of the
 * thrust overcomes their resistance; each mat that it moves takes its friction off. Mats behind
 * follow when the slack is used up. */
static void plough(struct mr_predictor *p, unsigned n)
{
    struct mr_chain *chain = &p->chain;
    float press_lb = thrust_lb(p), shift_ft = 0.0f;
    unsigned last = n;
    for (unsigned j = n + 1u; j <= chain->count; j++) {
        press_lb -= chain->friction_lb;
        if (!(press_lb > 0.0f))
            break;
        if (press_lb > chain->grit_lb[j] && mr_chain_opening_ft(chain, j) > 0.0f)
            last = j;
    }
    for (unsigned j = last; j > n; j--) {
        /* from the far end: each mat moves by all that closes beyond it */
        float left_lb = thrust_lb(p) - (float)(j - n) * chain->friction_lb;
        /* mat j has moved on already */
        float open_ft = chain->gap_ft[j] + chain->u_ft[j] - shift_ft - chain->u_ft[j - 1u];
        if (left_lb > chain->grit_lb[j] && open_ft > 0.0f)
            shift_ft += open_ft;
        else if (open_ft > 0.0f)
            open_ft = 0.0f;
        chain->u_ft[j - 1u] += shift_ft;
    }
    p->updates += 2u * (last - n) + 1u;
    p->look_updates += 2u * (last - n) + 1u;
    for (unsigned j = n; j > 1u; j--) {
        float over_ft = mr_chain_opening_ft(chain, j) - chain->slack_ft;
        if (!(over_ft > 0.0f))
            break;
        chain->u_ft[j - 1u] += over_ft;
        p->look_updates++;
    }
}

static void roll(struct mr_predictor *p, const struct mr_predictor_input *input)
{
    float push_lb = input->on_runway && input->speed_ft_s > 0.0f ? thrust_lb(p) : 0.0f;
    if (p->level == MR_PREDICTOR_PLOUGH) {
        unsigned mat = mat_at(p, input->wheel_ft);
        if (mat && push_lb > 0.0f && mat != p->ploughed_mat)
            plough(p, mat);
        p->ploughed_mat = mat;
        return;
    }
    float step_s = p->chain.step_s, at_ft = input->wheel_ft;
    for (p->due_s += BLOCK_S; p->due_s > 0.999f * step_s; p->due_s -= step_s) {
        at_ft += input->speed_ft_s * step_s;
        mr_chain_step(&p->chain,
                      push_lb > 0.0f ? mat_at(p, at_ft - 0.5f * input->speed_ft_s * step_s) : 0,
                      push_lb);
    }
    if (!mr_chain_settle(&p->chain))
        fall_back(p);
    mr_predictor_follow_grits(p);
    uint32_t updates = mr_chain_take_updates(&p->chain);
    p->updates += updates;
    p->look_updates += updates;
}

/* Mat updates of the next better level for one of this one: twice the mats and twice the steps. */
static uint32_t dearer(const struct mr_predictor *p)
{
    return p->level == MR_PREDICTOR_PLOUGH ? 1u : 4u;
}

/* Beyond the budget: over the last second, or by half of it again since the last look. */
static bool beyond_budget(const struct mr_predictor *p, uint32_t budget)
{
    uint64_t second = (uint64_t)p->second_updates + p->look_updates;
    return p->look_updates > budget + budget / 2u ||
           second > (uint64_t)budget * MR_PREDICTOR_LOOKS_PER_S;
}

static void mind_budget(struct mr_predictor *p, bool look)
{
    uint32_t per_block = p->config.updates_per_block,
             most = UINT32_MAX / 2u / MR_PREDICTOR_LOOK_BLOCKS;
    uint32_t budget = (per_block < most ? per_block : most) * MR_PREDICTOR_LOOK_BLOCKS;
    if (p->level > MR_PREDICTOR_PLOUGH)
        return;
    if (p->level < MR_PREDICTOR_PLOUGH && beyond_budget(p, budget)) {
        change_level(p, p->level + 1);
        forget_looks(p); /* what a cheaper level takes the place of leaves the second sooner */
    }
    if (!look)
        return;
    bool fits = (p->look_updates - p->look_search) * dearer(p) + p->look_search < budget;
    p->calm_looks = fits ? p->calm_looks + 1u : 0;
    uint32_t *oldest =
        &p->looks[p->block / MR_PREDICTOR_LOOK_BLOCKS % (MR_PREDICTOR_LOOKS_PER_S - 1u)];
    p->second_updates += p->look_updates - *oldest;
    *oldest = p->look_updates;
    p->look_updates = p->look_search = 0;
    if (p->calm_looks >= CALM_LOOKS && p->level > p->config.level)
        change_level(p, p->level - 1);
}

void mr_predictor_hurry(struct mr_predictor *p)
{
    if (!p->armed || p->level >= MR_PREDICTOR_PLOUGH)
        return;
    change_level(p, p->level + 1);
    p->look_updates = 0;
}

/* What the springs have done since the last look tells of the resistance against closing. */
static void learn(struct mr_predictor *p)
{
    /* beyond a half either way is no matter of one look */
    float factor = 1.0f + SCALE_PER_LB_IN * p->work_lb_in;
    p->scale /= factor < 0.5f ? 0.5f : factor > 2.0f ? 2.0f : factor;
    p->scale = p->scale < SCALE_LEAST ? SCALE_LEAST : p->scale > SCALE_MOST ? SCALE_MOST : p->scale;
    p->work_lb_in = 0.0f;
    mr_predictor_set_grits(p);
    p->look_updates += p->chain.count / MR_PREDICTOR_VISITS_PER_UPDATE;
}

void mr_predictor_block(struct mr_predictor *p, const struct mr_predictor_input *input)
{
    if (!p->armed)
        return;
    p->block++;
    bool known = between(input->wheel_ft, -MOST_FT, MOST_FT) &&
                 between(input->speed_ft_s, -1.0f, MOST_FT_S);
    p->wheel_ft = known ? input->wheel_ft : MR_NAN;
    /* at rest it may be rounded below */
    p->speed_ft_s = !known ? MR_NAN : input->speed_ft_s > 0.0f ? input->speed_ft_s : 0.0f;
    if (known && input->braking_known && input->deceleration_ft_s2 > 0.0f &&
        input->deceleration_ft_s2 <= MOST_FT_S2) {
        p->deceleration_ft_s2 = input->deceleration_ft_s2;
        p->braking = true;
    }
    draw_all(p, input);
    if (p->level == MR_PREDICTOR_KINEMATIC || !known)
        return;
    uint32_t before = p->look_updates;
    bool look = p->block % MR_PREDICTOR_LOOK_BLOCKS == 0;
    roll(p, input);
    scan_on(p);
    if (look)
        learn(p);
    if (p->look_updates - before > p->most_updates)
        p->most_updates = p->look_updates - before;
    mind_budget(p, look);
}

void mr_predictor_fold(struct mr_predictor *p)
{
    if (!p->armed)
        return;
    if (p->level == MR_PREDICTOR_KINEMATIC || (__builtin_isnan(p->wheel_ft) && p->moved))
        mr_predictor_fold_kinematic(p);
    else
        mr_predictor_fold_chain(p);
    p->armed = false;
    p->landings++;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        p->surveyed_in[s] = MR_NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        p->base_in[i] = 0.0f;
    p->level = p->config.level;
    (void)start_chain(p);
    scan_all(p);
}
