#include "host/advise/members.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/parallel_for.h"
#include "host/base/statistics.h"
#include "host/sim/models/chains.h"
#include "host/base/xmalloc.h"

#define MEMBERS_RNG_STREAM 1u
#define ZONE_CHECK_S       0.05
#define REST_CHECK_STEP_S  1e-3
#define BRAKE_ONSET_S      0.06
#define SIMULATED_AFTER_STOP_S \
    0.1 /* simulated time after the gear stops, in which the mats come to rest */
#define MAX_DURATION_S      60.0 /* longer than any landing */
#define CLOSED_FT           (0.001f / 12.0f)
/* At most one in this many consecutive joints of a zone may be open. */
#define ZONE_RUN_JOINTS     10
/* Gaps as laid are drawn uniformly from 0 to this many slacks, then limited to one slack. */
#define LAID_GAP_MAX_SLACKS 1.2

/* Prior distributions, as in host/landing_series. The values are factors on the configured
 * values. */
static const struct {
    double low, high;  /* limits of the factor */
    double min_spread; /* smallest standard deviation of the logarithm */
} factor_bounds[ADVISE_UNKNOWN_COUNT] = {
    [ADVISE_UNKNOWN_THRUST_SHARE] = {0.5, 1.6, 0.05}, [ADVISE_UNKNOWN_FRICTION] = {0.5, 1.8, 0.04},
    [ADVISE_UNKNOWN_RESISTANCE] = {0.3, 2.5, 0.1},    [ADVISE_UNKNOWN_STIFFNESS] = {0.5, 1.6, 0.0},
    [ADVISE_UNKNOWN_DAMPING] = {0.3, 2.5, 0.0},
};

/* Smallest standard error of the movement of a transducer at rest. */
#define READING_ERROR_MIN_IN       0.003
/* Standard error of the logarithm of a measured share of the thrust */
#define MEASURED_SHARE_LOG_ERROR   0.03
/* Standard error of the logarithm of a share that is not measured, which is uniform from 0.7 to
 * 1.3. */
#define UNMEASURED_SHARE_LOG_ERROR 0.18
#define MOVEMENT_MODEL_ERROR_FRACTION \
    0.15 /* error of the chain model, as a fraction of the movement of a transducer */
#define MOVEMENT_MODEL_ERROR_IN      0.01
/* Error of the chain model, as a fraction of the closing of ten joints */
#define SEGMENT_MODEL_ERROR_FRACTION 0.25
#define SEGMENT_MODEL_ERROR_IN       0.01
#define SMOOTHER_PASSES              2
/* Fraction of the spread lost in an update that is restored after a landing */
#define RESTORED_SPREAD_FRACTION     0.5
/* a transducer updates joints up to twice this distance away */
#define TAPER_HALF_WIDTH_FT          12.0

/* ---- drawing ---- */

static double get_configured_value(const struct advise_runway *runway, enum advise_unknown unknown)
{
    switch (unknown) {
    case ADVISE_UNKNOWN_THRUST_SHARE:
        return runway->thrust_share > 0.0 ? runway->thrust_share : 1.0;
    case ADVISE_UNKNOWN_FRICTION: return (double)runway->chain.friction_lb;
    case ADVISE_UNKNOWN_RESISTANCE: return runway->grit_lb;
    case ADVISE_UNKNOWN_STIFFNESS: return (double)runway->chain.kl_lb_ft;
    case ADVISE_UNKNOWN_DAMPING: return (double)runway->chain.cl_lb_s_ft;
    default: return 1.0;
    }
}

static void draw_unknowns(struct advise_member *member, const struct advise_runway *runway,
                          struct rng *rng)
{
    double *u = member->unknown;
    u[ADVISE_UNKNOWN_THRUST_SHARE] = log(0.7 + 0.6 * rng_uniform(rng));
    /* Scaled only after the draw: random numbers drawn later stay the same. */
    if (runway->thrust_share > 0.0)
        u[ADVISE_UNKNOWN_THRUST_SHARE] *= MEASURED_SHARE_LOG_ERROR / UNMEASURED_SHARE_LOG_ERROR;
    u[ADVISE_UNKNOWN_FRICTION] = 0.1 * rng_normal(rng);
    u[ADVISE_UNKNOWN_RESISTANCE] = -0.6 + rng_uniform(rng);
    u[ADVISE_UNKNOWN_STIFFNESS] = -0.5 + 0.9 * rng_uniform(rng);
    u[ADVISE_UNKNOWN_DAMPING] = -0.9 + 1.6 * rng_uniform(rng);
    for (int k = 0; k < ADVISE_UNKNOWN_COUNT; k++)
        u[k] += log(get_configured_value(runway, (enum advise_unknown)k));
}

static void draw_joint_gaps(struct advise_members *members, struct advise_member *member,
                            unsigned first, unsigned last)
{
    double slack_ft = (double)members->runway.chain.slack_ft;
    for (unsigned j = first; j <= last; j++)
        member->gap_ft[j] = (float)fmin(LAID_GAP_MAX_SLACKS * slack_ft * rng_uniform(&members->rng),
                                        slack_ft);
}

static bool is_plausible_runway(const struct advise_runway *r)
{
    const struct mr_chain_params *c = &r->chain;
    return c->mats >= 2 && c->mats <= MR_CHAIN_MATS && c->mat_length_ft > 0.0f &&
           c->mass_slug > 0.0f && c->friction_lb > 0.0f && c->kl_lb_ft > 0.0f &&
           c->cl_lb_s_ft > 0.0f && c->slack_ft > 0.0f && r->grit_lb > 0.0 &&
           r->thrust_lb_per_g > 0.0 && isfinite(r->thrust_lb_per_g);
}

enum mr_status advise_members_draw(struct advise_members *members,
                                   const struct advise_runway *runway, size_t count, uint64_t seed)
{
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    *members = (struct advise_members){
        .runway = *runway,
        .member_count = (count + CHAINS_LANES - 1) / CHAINS_LANES * CHAINS_LANES,
        .thread_count = processors > 1 ? (unsigned)processors : 1u,
        .rng = rng_init(seed, MEMBERS_RNG_STREAM),
    };
    if (!is_plausible_runway(runway) || count < CHAINS_LANES || count > ADVISE_MEMBERS_MAX)
        return MR_USAGE;
    members->member = xcalloc(members->member_count, sizeof *members->member);
    for (size_t m = 0; m < members->member_count; m++) {
        struct advise_member *member = &members->member[m];
        draw_unknowns(member, runway, &members->rng);
        draw_joint_gaps(members, member, 0, runway->chain.mats);
        for (unsigned j = 0; j <= runway->chain.mats; j++)
            member->grit_ratio[j] = (float)(2.0 * rng_uniform(&members->rng));
    }
    return MR_OK;
}

void advise_members_free(struct advise_members *members)
{
    free(members->member);
    members->member = NULL;
}

void advise_redraw_all_joints(struct advise_members *members)
{
    for (size_t m = 0; m < members->member_count; m++)
        draw_joint_gaps(members, &members->member[m], 0, members->runway.chain.mats);
    members->is_surveyed = false;
}

void advise_redraw_joints(struct advise_members *members, unsigned first, unsigned last)
{
    for (size_t m = 0; m < members->member_count; m++) {
        struct advise_member *member = &members->member[m];
        draw_joint_gaps(members, member, first, last);
        for (unsigned j = first; j <= last; j++)
            member->grit_ratio[j] = (float)(2.0 * rng_uniform(&members->rng));
    }
}

/* Changes ten openings so that they have a given sum. To reduce the sum, scales the openings; to
 * increase it, scales the differences between slack and openings. */
static void scale_gaps_to_sum(float *gap_ft, double sum_ft, double slack_ft)
{
    double most_ft = MR_MATS_PER_SEGMENT * slack_ft, had_ft = 0.0;
    double sum = fmin(fmax(sum_ft, 0.0), most_ft);
    for (unsigned j = 0; j < MR_MATS_PER_SEGMENT; j++)
        had_ft += (double)gap_ft[j];
    for (unsigned j = 0; j < MR_MATS_PER_SEGMENT; j++) {
        double g = (double)gap_ft[j];
        if (had_ft >= sum)
            g *= had_ft > 0.0 ? sum / had_ft : 0.0;
        else
            g = slack_ft - (slack_ft - g) * (most_ft - sum) / (most_ft - had_ft);
        gap_ft[j] = (float)g;
    }
}

static unsigned get_segment_count(const struct advise_members *members)
{
    unsigned whole = members->runway.chain.mats / MR_MATS_PER_SEGMENT;
    return whole < MR_SEGMENTS ? whole : MR_SEGMENTS;
}

void advise_apply_survey(struct advise_members *members, const double sum_in[MR_SEGMENTS],
                         double error_in)
{
    double slack_ft = (double)members->runway.chain.slack_ft;
    for (unsigned s = 0; s < get_segment_count(members); s++)
        members->is_surveyed = members->is_surveyed || isfinite(sum_in[s]);
    for (size_t m = 0; m < members->member_count; m++) {
        for (unsigned s = 0; s < get_segment_count(members); s++) {
            double off_in = error_in * rng_normal(&members->rng);
            if (isfinite(sum_in[s]))
                scale_gaps_to_sum(members->member[m].gap_ft + MR_MATS_PER_SEGMENT * s,
                                  (sum_in[s] + off_in) / 12.0, slack_ft);
        }
    }
}

/* ---- simulation ---- */

struct advise_zone advise_find_longest_zone(const float *opening_ft, unsigned joints, unsigned from)
{
    struct advise_zone best = {0, 0};
    for (unsigned first = from; first < joints; first++) {
        int last_open = (int)first - ZONE_RUN_JOINTS;
        if (opening_ft[first] > CLOSED_FT)
            continue;
        for (unsigned j = first + 1u; j < joints; j++) {
            if (opening_ft[j] > CLOSED_FT) {
                if ((int)j - last_open < ZONE_RUN_JOINTS)
                    break;
                last_open = (int)j;
            } else if (j - first > best.mat_count) {
                best = (struct advise_zone){first, j - first};
            }
        }
    }
    return best;
}

/* The gear in the simulation of one member. */
struct gear {
    double speed_ft_s, position_ft, thrust_lb_per_g;
};

double advise_braking_factor(const struct advise_profile *profile, double t_s)
{
    if (!profile || !profile->point_count)
        return 1.0;
    size_t last = profile->point_count - 1;
    if (t_s <= profile->t_s[0])
        return profile->factor[0];
    for (size_t i = 0; i < last; i++) {
        double from_s = profile->t_s[i], to_s = profile->t_s[i + 1];
        if (t_s < to_s)
            return profile->factor[i] +
                   (profile->factor[i + 1] - profile->factor[i]) * (t_s - from_s) / (to_s - from_s);
    }
    return profile->factor[last];
}

double advise_braking_ft_s2(const struct advise_braking *braking, double t_s)
{
    if (t_s >= BRAKE_ONSET_S && !braking->profile)
        return braking->mean_braking_ft_s2;
    double part = fmin(t_s / BRAKE_ONSET_S, 1.0);
    return part * part * (3.0 - 2.0 * part) * braking->mean_braking_ft_s2 *
           advise_braking_factor(braking->profile, t_s);
}

/* Eight members (simulated runways) that are computed together, and the landing of each. */
struct batch {
    const struct advise_members *members;
    struct advise_member *member;
    const struct advise_braking *braking;
    struct advise_outcome *outcome;
    bool updates_joint_state;
    struct gear gear[CHAINS_LANES];
    double time_step_s;
};

static struct chains *start_batch_chains(struct batch *b,
                                         float grit_lb[CHAINS_LANES][ADVISE_JOINTS])
{
    const struct mr_chain_params *chain = &b->members->runway.chain;
    struct mr_chain_params params[CHAINS_LANES];
    const float *gap[CHAINS_LANES], *grit[CHAINS_LANES];
    enum mr_status status;
    double limit_s = (double)INFINITY;
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        const double *u = b->member[k].unknown;
        double mean_lb = exp(u[ADVISE_UNKNOWN_RESISTANCE]);
        params[k] = *chain;
        params[k].friction_lb = (float)exp(u[ADVISE_UNKNOWN_FRICTION]);
        params[k].kl_lb_ft = (float)exp(u[ADVISE_UNKNOWN_STIFFNESS]);
        params[k].cl_lb_s_ft = (float)exp(u[ADVISE_UNKNOWN_DAMPING]);
        limit_s = fmin(limit_s, (double)mr_chain_step_limit_s(&params[k]));
        for (unsigned j = 0; j <= chain->mats; j++)
            grit_lb[k][j] = (float)(mean_lb * (double)b->member[k].grit_ratio[j]);
        gap[k] = b->member[k].gap_ft;
        grit[k] = grit_lb[k];
    }
    /* chosen so that REST_CHECK_STEP_S is a whole number of steps */
    b->time_step_s = REST_CHECK_STEP_S /
                     ceil(REST_CHECK_STEP_S / (0.98 * (double)MR_CHAIN_STEP_MARGIN * limit_s));
    for (unsigned k = 0; k < CHAINS_LANES; k++)
        params[k].step_s = (float)b->time_step_s;
    return chains_make(params, gap, grit, &status);
}

static void advance_gear(struct batch *b, unsigned k, double t_s, unsigned *mat, float *thrust_lb)
{
    const struct mr_chain_params *chain = &b->members->runway.chain;
    struct gear *gear = &b->gear[k];
    double length_ft = (double)chain->mat_length_ft, a = advise_braking_ft_s2(&b->braking[k], t_s);
    bool on = gear->position_ft >= 0.0 && gear->position_ft < length_ft * chain->mats &&
              gear->speed_ft_s > 0.0;
    *mat = on ? (unsigned)(gear->position_ft / length_ft) + 1u : 1u;
    *thrust_lb = on ? (float)(gear->thrust_lb_per_g * a / ADVISE_G_FT_S2) : 0.0f;
    gear->position_ft += fmax(gear->speed_ft_s, 0.0) * b->time_step_s;
    gear->speed_ft_s -= a * b->time_step_s;
}

static void update_longest_zone(struct batch *b, const struct chains *chains, unsigned k)
{
    const struct mr_chain_params *chain = &b->members->runway.chain;
    const struct gear *gear = &b->gear[k];
    double length_ft = (double)chain->mat_length_ft;
    float opening_ft[ADVISE_JOINTS];
    if (!(gear->speed_ft_s > ADVISE_SLOW_SPEED_FT_S) || gear->position_ft < 0.0)
        return;
    for (unsigned j = 0; j <= chain->mats; j++)
        opening_ft[j] = chains_opening_ft(chains, k, j + 1u);
    struct advise_zone zone = advise_find_longest_zone(
        opening_ft, chain->mats + 1u, (unsigned)ceil(gear->position_ft / length_ft));
    if (!zone.mat_count ||
        zone.first_mat * length_ft - gear->position_ft >= ADVISE_ZONE_REACHED_DISTANCE_FT)
        return;
    if (zone.mat_count > b->outcome[k].longest_zone_mats)
        b->outcome[k].longest_zone_mats = (uint16_t)zone.mat_count;
    if (zone.mat_count >= ADVISE_ZONE_MATS && isnan(b->outcome[k].zone_station_ft))
        b->outcome[k].zone_station_ft = (float)gear->position_ft;
}

static void set_batch_outcome(struct batch *b, const struct chains *chains, unsigned k)
{
    const struct advise_runway *runway = &b->members->runway;
    struct advise_outcome *outcome = &b->outcome[k];
    double length_ft = (double)runway->chain.mat_length_ft,
           slack_ft = (double)runway->chain.slack_ft;
    outcome->stop_station_ft = (float)b->gear[k].position_ft;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        double at = (double)runway->transducer_station_ft[i] / length_ft;
        outcome->movement_in[i] = at >= 0.0 && at < runway->chain.mats
                                    ? 12.0f * chains_displacement_ft(chains, k, (unsigned)at + 1u)
                                    : NAN;
    }
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        outcome->segment_sum_in[s] = s < get_segment_count(b->members) ? 0.0f : NAN;
    for (unsigned j = 0; j <= runway->chain.mats; j++) {
        double g = fmin(fmax((double)chains_opening_ft(chains, k, j + 1u), 0.0), slack_ft);
        if (j / MR_MATS_PER_SEGMENT < get_segment_count(b->members))
            outcome->segment_sum_in[j / MR_MATS_PER_SEGMENT] += (float)(12.0 * g);
        if (b->updates_joint_state && !outcome->has_diverged)
            b->member[k].gap_ft[j] = (float)g;
    }
}

static bool is_any_gear_rolling(const struct batch *b)
{
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        if (b->gear[k].speed_ft_s > 0.0 &&
            b->gear[k].position_ft <
                (double)b->members->runway.chain.mat_length_ft * b->members->runway.chain.mats)
            return true;
    }
    return false;
}

static bool simulate_batch(struct batch *b)
{
    float(*grit_lb)[ADVISE_JOINTS] = xcalloc(CHAINS_LANES, sizeof *grit_lb);
    struct chains *chains = start_batch_chains(b, grit_lb);
    unsigned mat[CHAINS_LANES], away = 0;
    float thrust_lb[CHAINS_LANES];
    if (!chains) {
        free(grit_lb);
        return false;
    }
    const unsigned settle = (unsigned)(REST_CHECK_STEP_S / b->time_step_s + 0.5),
                   each_look = settle * (unsigned)(ZONE_CHECK_S / REST_CHECK_STEP_S + 0.5);
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        b->gear[k] = (struct gear){
            .speed_ft_s = b->braking[k].speed_ft_s,
            .position_ft = b->braking[k].touchdown_ft,
            .thrust_lb_per_g = exp(b->member[k].unknown[ADVISE_UNKNOWN_THRUST_SHARE]) *
                               b->members->runway.thrust_lb_per_g};
        b->outcome[k] = (struct advise_outcome){.zone_station_ft = NAN};
    }
    double rest_s = 0.0;
    for (unsigned step = 0;
         rest_s < SIMULATED_AFTER_STOP_S && (double)step * b->time_step_s < MAX_DURATION_S;
         step++) {
        for (unsigned k = 0; k < CHAINS_LANES; k++)
            advance_gear(b, k, (double)step * b->time_step_s, &mat[k], &thrust_lb[k]);
        chains_step(chains, mat, thrust_lb);
        if (step % settle == settle - 1u) {
            away |= chains_end_block(chains);
            rest_s = is_any_gear_rolling(b) ? 0.0 : rest_s + REST_CHECK_STEP_S;
        }
        for (unsigned k = 0; step % each_look == 0 && k < CHAINS_LANES; k++)
            update_longest_zone(b, chains, k);
    }
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        b->outcome[k].has_diverged = away >> k & 1u;
        set_batch_outcome(b, chains, k);
    }
    chains_free(chains);
    free(grit_lb);
    return true;
}

/* The simulation of a landing on all members. */
struct simulation {
    struct advise_members *members;
    const struct advise_braking *braking;
    struct advise_outcome *outcome;
    bool updates_joint_state;
    _Atomic bool failed;
};

static void simulate_batches(void *context, size_t from, size_t every)
{
    struct simulation *p = context;
    size_t batches = p->members->member_count / CHAINS_LANES;
    for (size_t i = from; i < batches && !p->failed; i += every) {
        struct batch batch = {.members = p->members,
                              .member = p->members->member + CHAINS_LANES * i,
                              .braking = p->braking + CHAINS_LANES * i,
                              .outcome = p->outcome + CHAINS_LANES * i,
                              .updates_joint_state = p->updates_joint_state};
        if (!simulate_batch(&batch))
            p->failed = true;
    }
}

bool advise_simulate(struct advise_members *members, const struct advise_braking *braking,
                     bool updates_joint_state, struct advise_outcome *outcome)
{
    struct simulation playing = {.members = members,
                                 .braking = braking,
                                 .outcome = outcome,
                                 .updates_joint_state = updates_joint_state};
    parallel_for(members->thread_count, simulate_batches, &playing);
    return !playing.failed;
}

/* ---- smoother ---- */

/* Work space of one pass, for `n` valid readings. */
struct update_work {
    size_t reading_count;
    size_t *reading;    /* [n]: indexes of the valid readings */
    double *deviation;  /* [members][n]: prediction minus mean of the predictions */
    double *covariance; /* [n][n]: covariance of the readings, then its Cholesky factor */
    /* [members][n]: innovations; solve_with_factor then multiplies them by the inverse of
     * `covariance` */
    double *innovations;
    double *gain;         /* [n]: gain of the state that is being updated */
    double *state_change; /* [members]: change of the state */
};

/* Fills the matrix with the covariance of the predictions plus the variance of the errors. */
static void fill_covariance(struct update_work *w, const struct smoother *s)
{
    for (size_t i = 0; i < w->reading_count; i++) {
        double mean = 0.0, error = s->reading_error[w->reading[i]];
        for (size_t m = 0; m < s->member_count; m++)
            mean += s->predicted[m * s->reading_count + w->reading[i]] / (double)s->member_count;
        for (size_t m = 0; m < s->member_count; m++)
            w->deviation[m * w->reading_count + i] =
                s->predicted[m * s->reading_count + w->reading[i]] - mean;
        w->covariance[i * w->reading_count + i] = s->reading_error_factor * error * error;
    }
    for (size_t m = 0; m < s->member_count; m++) {
        const double *y = w->deviation + m * w->reading_count;
        for (size_t i = 0; i < w->reading_count; i++) {
            for (size_t k = 0; k <= i; k++)
                w->covariance[i * w->reading_count + k] += y[i] * y[k] /
                                                           (double)(s->member_count - 1);
        }
    }
}

/* Replaces the lower half of the matrix by its Cholesky factor. The errors keep the matrix positive
 * definite. */
static void factor_covariance(struct update_work *w)
{
    double *a = w->covariance;
    size_t n = w->reading_count;
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j <= i; j++) {
            double sum = a[i * n + j];
            for (size_t k = 0; k < j; k++)
                sum -= a[i * n + k] * a[j * n + k];
            a[i * n + j] = i == j ? sqrt(sum) : sum / a[j * n + j];
        }
    }
}

/* Replaces b by the inverse of the matrix times b. */
static void solve_with_factor(const struct update_work *w, double *b)
{
    const double *a = w->covariance;
    size_t n = w->reading_count;
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++)
            b[i] -= a[i * n + k] * b[k];
        b[i] /= a[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++)
            b[i] -= a[k * n + i] * b[k];
        b[i] /= a[i * n + i];
    }
}

/* Sets the innovations: perturbed readings minus predictions. The mean of the perturbations is
 * subtracted, because a nonzero mean would shift the whole ensemble at random. */
static void set_innovations(struct update_work *w, const struct smoother *s, struct rng *rng)
{
    for (size_t i = 0; i < w->reading_count; i++) {
        size_t d = w->reading[i];
        double mean = 0.0, error = sqrt(s->reading_error_factor) * s->reading_error[d];
        for (size_t m = 0; m < s->member_count; m++) {
            double z = rng_normal(rng);
            mean += z / (double)s->member_count;
            w->innovations[m * w->reading_count + i] = z;
        }
        for (size_t m = 0; m < s->member_count; m++) {
            double *at = &w->innovations[m * w->reading_count + i];
            *at = s->reading[d] + error * (*at - mean) - s->predicted[m * s->reading_count + d];
        }
    }
}

/* Updates one state of all members. The gain is the covariance of the state with the readings,
 * times the inverse matrix. The taper is applied to the gain. Applied to the covariance instead, it
 * would transfer weight from near readings to distant ones. */
static void update_state(struct update_work *w, const struct smoother *s, size_t state)
{
    double mean = 0.0;
    for (size_t m = 0; m < s->member_count; m++)
        mean += s->state[m * s->state_count + state] / (double)s->member_count;
    memset(w->gain, 0, w->reading_count * sizeof *w->gain);
    for (size_t m = 0; m < s->member_count; m++) {
        double x = s->state[m * s->state_count + state] - mean;
        for (size_t i = 0; i < w->reading_count; i++)
            w->gain[i] += x * w->deviation[m * w->reading_count + i] /
                          (double)(s->member_count - 1);
    }
    solve_with_factor(w, w->gain);
    for (size_t i = 0; s->taper_weight && i < w->reading_count; i++)
        w->gain[i] *= s->taper_weight(s->context, state, w->reading[i]);
    for (size_t m = 0; m < s->member_count; m++) {
        double shift = 0.0;
        for (size_t i = 0; i < w->reading_count; i++)
            shift += w->gain[i] * w->innovations[m * w->reading_count + i];
        w->state_change[m] = shift;
    }
    for (size_t m = 0; m < s->member_count; m++)
        s->state[m * s->state_count + state] += w->state_change[m];
}

void smoother_update(const struct smoother *s, struct rng *rng)
{
    struct update_work w = {
        .reading = xcalloc(s->reading_count, sizeof *w.reading),
        .deviation = xcalloc(s->member_count * s->reading_count, sizeof *w.deviation),
        .covariance = xcalloc(s->reading_count * s->reading_count, sizeof *w.covariance),
        .innovations = xcalloc(s->member_count * s->reading_count, sizeof *w.innovations),
        .gain = xcalloc(s->reading_count, sizeof *w.gain),
        .state_change = xcalloc(s->member_count, sizeof *w.state_change),
    };
    for (size_t d = 0; d < s->reading_count; d++) {
        if (isfinite(s->reading[d]))
            w.reading[w.reading_count++] = d;
    }
    if (w.reading_count) {
        fill_covariance(&w, s);
        factor_covariance(&w);
        set_innovations(&w, s, rng);
        for (size_t state = 0; state < s->state_count; state++)
            update_state(&w, s, state);
    }
    free(w.reading);
    free(w.deviation);
    free(w.covariance);
    free(w.innovations);
    free(w.gain);
    free(w.state_change);
}

void smoother_moments(const double *state, size_t members, size_t states, size_t column,
                      double *mean, double *deviation)
{
    double sum = 0.0, squares = 0.0;
    for (size_t m = 0; m < members; m++)
        sum += state[m * states + column];
    *mean = sum / (double)members;
    for (size_t m = 0; m < members; m++) {
        double x = state[m * states + column] - *mean;
        squares += x * x;
    }
    *deviation = members > 1 ? sqrt(squares / (double)(members - 1)) : 0.0;
}

void smoother_restore_spread(double *state, size_t members, size_t states, size_t column,
                             double old_deviation, double restored_fraction, double min_deviation)
{
    double mean, now;
    smoother_moments(state, members, states, column, &mean, &now);
    double wanted = fmax(now + restored_fraction * fmax(old_deviation - now, 0.0), min_deviation);
    for (size_t m = 0; now > 0.0 && m < members; m++) {
        double *x = &state[m * states + column];
        *x = mean + (*x - mean) * wanted / now;
    }
}

double smoother_taper(double distance, double half)
{
    double r = fabs(distance) / half;
    if (r < 1.0)
        return (((-0.25 * r + 0.5) * r + 0.625) * r - 5.0 / 3.0) * r * r + 1.0;
    if (r < 2.0)
        return ((((r / 12.0 - 0.5) * r + 0.625) * r + 5.0 / 3.0) * r - 5.0) * r + 4.0 -
               2.0 / (3.0 * r);
    return 0.0;
}

/* ---- assimilation ---- */

#define STATE_COUNT   (ADVISE_UNKNOWN_COUNT + ADVISE_JOINTS)
#define READING_COUNT (MR_TRANSDUCERS + MR_SEGMENTS)

static double taper_weight(const void *context, size_t state, size_t datum)
{
    const struct advise_runway *runway = context;
    if (state < ADVISE_UNKNOWN_COUNT)
        return 1.0;
    size_t joint = state - ADVISE_UNKNOWN_COUNT;
    /* A datum after the transducers is the closing of a segment, which depends only on its ten
     * joints. */
    if (datum >= MR_TRANSDUCERS)
        return joint / MR_MATS_PER_SEGMENT == datum - MR_TRANSDUCERS ? 1.0 : 0.0;
    return smoother_taper((double)joint * (double)runway->chain.mat_length_ft -
                              (double)runway->transducer_station_ft[datum],
                          TAPER_HALF_WIDTH_FT);
}

struct assimilation {
    double *state, *predicted;
    double reading[READING_COUNT], reading_error[READING_COUNT];
    struct advise_braking *braking;
    struct advise_outcome *outcome;
};

static void assimilation_free(struct assimilation *l)
{
    free(l->state);
    free(l->predicted);
    free(l->braking);
    free(l->outcome);
}

static void assimilation_alloc(struct assimilation *l, const struct advise_members *members)
{
    *l = (struct assimilation){
        .state = xcalloc(members->member_count * STATE_COUNT, sizeof *l->state),
        .predicted = xcalloc(members->member_count * READING_COUNT, sizeof *l->predicted),
        .braking = xcalloc(members->member_count, sizeof *l->braking),
        .outcome = xcalloc(members->member_count, sizeof *l->outcome)};
}

static void members_to_state(const struct advise_members *members, struct assimilation *l)
{
    for (size_t m = 0; m < members->member_count; m++) {
        const struct advise_member *member = &members->member[m];
        double *state = l->state + m * STATE_COUNT;
        memcpy(state, member->unknown, sizeof member->unknown);
        for (unsigned j = 0; j < ADVISE_JOINTS; j++)
            state[ADVISE_UNKNOWN_COUNT + j] = (double)member->gap_ft[j];
        for (unsigned d = 0; d < READING_COUNT; d++)
            l->predicted[m * READING_COUNT + d] =
                (double)(d < MR_TRANSDUCERS ? l->outcome[m].movement_in[d]
                                            : l->outcome[m].segment_sum_in[d - MR_TRANSDUCERS]);
    }
}

/* Sets the readings and their standard errors. Each error combines the error of the reading with
 * that of the chain model, which is a fraction of the movement or of the closing. */
static void set_assimilated_readings(const struct advise_members *members,
                                     const struct advise_observation *observation,
                                     struct assimilation *l)
{
    for (unsigned d = 0; d < READING_COUNT; d++) {
        double mean = 0.0;
        for (size_t m = 0; m < members->member_count; m++)
            mean += l->predicted[m * READING_COUNT + d] / (double)members->member_count;
        if (d < MR_TRANSDUCERS) {
            double own = fmax(observation->movement_error_in, READING_ERROR_MIN_IN);
            l->reading[d] = isfinite(mean) ? observation->movement_in[d] : (double)NAN;
            l->reading_error[d] =
                hypot(own, MOVEMENT_MODEL_ERROR_FRACTION *
                                   fmax(fabs(observation->movement_in[d]), fabs(mean)) +
                               MOVEMENT_MODEL_ERROR_IN);
        } else {
            unsigned s = d - MR_TRANSDUCERS;
            double change =
                fabs(observation->survey_before_in[s] - observation->survey_after_in[s]);
            /* Without a survey before the landing, only the opening that remains is known, not the
             * closing. */
            l->reading[d] = isfinite(mean) ? observation->survey_after_in[s] : (double)NAN;
            l->reading_error[d] =
                hypot(1.4142135623730951 * observation->survey_error_in,
                      SEGMENT_MODEL_ERROR_FRACTION * (isfinite(change) ? change : 0.1) +
                          SEGMENT_MODEL_ERROR_IN);
        }
    }
}

static void members_from_state(struct advise_members *members, const struct assimilation *l)
{
    const struct advise_runway *runway = &members->runway;
    for (size_t m = 0; m < members->member_count; m++) {
        struct advise_member *member = &members->member[m];
        const double *state = l->state + m * STATE_COUNT;
        for (int k = 0; k < ADVISE_UNKNOWN_COUNT; k++) {
            double by = get_configured_value(runway, (enum advise_unknown)k);
            member->unknown[k] = fmin(fmax(state[k], log(factor_bounds[k].low * by)),
                                      log(factor_bounds[k].high * by));
        }
        for (unsigned j = 0; j <= runway->chain.mats; j++)
            member->gap_ft[j] = (float)fmin(fmax(state[ADVISE_UNKNOWN_COUNT + j], 0.0),
                                            (double)runway->chain.slack_ft);
    }
}

static bool has_any_member_diverged(const struct advise_members *members,
                                    const struct assimilation *l)
{
    for (size_t m = 0; m < members->member_count; m++) {
        if (l->outcome[m].has_diverged)
            return true;
    }
    return false;
}

static bool run_smoother_pass(struct advise_members *members,
                              const struct advise_observation *observation, struct assimilation *l)
{
    if (!advise_simulate(members, l->braking, false, l->outcome) ||
        has_any_member_diverged(members, l))
        return false;
    members_to_state(members, l);
    set_assimilated_readings(members, observation, l);
    const struct smoother smoother = {.member_count = members->member_count,
                                      .state_count = STATE_COUNT,
                                      .reading_count = READING_COUNT,
                                      .state = l->state,
                                      .predicted = l->predicted,
                                      .reading = l->reading,
                                      .reading_error = l->reading_error,
                                      .reading_error_factor = SMOOTHER_PASSES,
                                      .taper_weight = taper_weight,
                                      .context = &members->runway};
    smoother_update(&smoother, &members->rng);
    members_from_state(members, l);
    return true;
}

static void restore_spread(struct advise_members *members, struct assimilation *l,
                           const double *was)
{
    members_to_state(members, l);
    for (unsigned k = 0; k < ADVISE_UNKNOWN_COUNT; k++)
        smoother_restore_spread(l->state, members->member_count, STATE_COUNT, k, was[k],
                                RESTORED_SPREAD_FRACTION, factor_bounds[k].min_spread);
    members_from_state(members, l);
}

bool advise_update(struct advise_members *members, const struct advise_observation *observation)
{
    struct assimilation assimilation;
    double was[ADVISE_UNKNOWN_COUNT], mean;
    bool good = true;
    assimilation_alloc(&assimilation, members);
    advise_apply_survey(members, observation->survey_before_in, observation->survey_error_in);
    for (size_t m = 0; m < members->member_count; m++)
        assimilation.braking[m] = observation->braking;
    members_to_state(members, &assimilation);
    for (unsigned k = 0; k < ADVISE_UNKNOWN_COUNT; k++)
        smoother_moments(assimilation.state, members->member_count, STATE_COUNT, k, &mean, &was[k]);
    for (unsigned i = 0; good && i < SMOOTHER_PASSES; i++)
        good = run_smoother_pass(members, observation, &assimilation);
    if (good)
        restore_spread(members, &assimilation, was);
    good = good && advise_simulate(members, assimilation.braking, true, assimilation.outcome) &&
           !has_any_member_diverged(members, &assimilation);
    members->update_count += good;
    assimilation_free(&assimilation);
    return good;
}

void advise_widen_spread(struct advise_members *members, double factor)
{
    for (int k = 0; k < ADVISE_UNKNOWN_COUNT; k++) {
        double mean, spread;
        advise_parameter_moments(members, (enum advise_unknown)k, &mean, &spread);
        for (size_t m = 0; m < members->member_count; m++) {
            double *u = &members->member[m].unknown[k],
                   by = get_configured_value(&members->runway, (enum advise_unknown)k);
            *u = log(mean) + factor * (*u - log(mean));
            *u = fmin(fmax(*u, log(factor_bounds[k].low * by)), log(factor_bounds[k].high * by));
        }
    }
}

void advise_parameter_moments(const struct advise_members *members, enum advise_unknown unknown,
                              double *mean, double *spread)
{
    double sum = 0.0, squares = 0.0;
    for (size_t m = 0; m < members->member_count; m++)
        sum += members->member[m].unknown[unknown] / (double)members->member_count;
    for (size_t m = 0; m < members->member_count; m++) {
        double off = members->member[m].unknown[unknown] - sum;
        squares += off * off;
    }
    *mean = exp(sum);
    *spread = sqrt(squares / (double)(members->member_count - 1));
}

/* ---- forecast ---- */

#define FORECAST_RNG_STREAM 2u
#define PLAN_PRIOR_LANDINGS 4.0
#define CALIBRATION_MEMBERS 64.0

void advise_predict_plan_deviation(const double *log_ratio, size_t count, double *bias,
                                   double *spread)
{
    const double prior = PLAN_PRIOR_LANDINGS, n = (double)count;
    double mean = 0.0, squares = 0.0;
    for (size_t i = 0; i < count; i++)
        mean += log_ratio[i] / n;
    for (size_t i = 0; i < count; i++)
        squares += (log_ratio[i] - mean) * (log_ratio[i] - mean);
    /* Without landings (n = 0), the resulting spread is ADVISE_PLAN_DEFAULT_SPREAD. */
    double sum = ADVISE_PLAN_DEFAULT_SPREAD * ADVISE_PLAN_DEFAULT_SPREAD * (prior - 2.0) /
                     (1.0 + 1.0 / prior) +
                 squares + prior * n / (prior + n) * mean * mean;
    *bias = n * mean / (prior + n);
    *spread = sqrt(sum / (prior + n - 2.0) * (1.0 + 1.0 / (prior + n)));
}

void advise_draw_braking(const struct advise_members *members, const struct advise_plan *plan,
                         double mean_ft_s2, struct advise_braking *braking)
{
    for (size_t m = 0; m < members->member_count; m++) {
        struct rng rng = rng_init(plan->seed, 1000u * FORECAST_RNG_STREAM + m);
        double deviation = fmin(fmax(plan->braking_spread * rng_normal(&rng), -0.5), 0.4),
               speed = plan->speed_spread * rng_normal(&rng),
               at_ft = plan->touchdown_spread_ft * rng_normal(&rng);
        braking[m] = (struct advise_braking){
            .speed_ft_s = plan->speed_ft_s * fmax(1.0 + speed, 0.5),
            .touchdown_ft = fmax(plan->touchdown_ft + at_ft, 0.0),
            .mean_braking_ft_s2 = mean_ft_s2 * exp(plan->braking_log_bias) * (1.0 + deviation),
            .profile = &plan->profile,
        };
    }
}

double advise_convert_to_log_odds(double share)
{
    double soft = (CALIBRATION_MEMBERS * share + 0.5) / (CALIBRATION_MEMBERS + 1.0);
    return log(soft / (1.0 - soft));
}

/* Logistic calibration: the log odds of the probability are `times` x (log odds of the share) +
 * `more`. Both constants were fitted to series 250 to 309 of make score-foresight, which are not
 * used for scoring (tests/score/README.md, "Before touchdown" and "Perturbed"). The slope `times`
 * is lower without a survey, because then the members of the ensemble differ too little. */
double advise_calibrate_share(double share, bool surveyed)
{
    double times = surveyed ? 0.64 : 0.53, more = surveyed ? 0.49 : -0.28;
    return 1.0 / (1.0 + exp(-(more + times * advise_convert_to_log_odds(share))));
}

struct advise_probability advise_compute_probability(size_t events, size_t count, bool surveyed)
{
    struct proportion_interval share = compute_proportion_interval(events, count);
    return (struct advise_probability){
        .probability = advise_calibrate_share((double)events / (double)count, surveyed),
        .low = advise_calibrate_share(share.low, surveyed),
        .high = advise_calibrate_share(share.high, surveyed)};
}

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

bool advise_compute_row(struct advise_members *members, const struct advise_plan *plan,
                        double mean_ft_s2, struct advise_braking *braking,
                        struct advise_outcome *outcome, struct advise_row *row)
{
    const struct mr_chain_params *chain = &members->runway.chain;
    double end_ft = (double)chain->mat_length_ft * chain->mats;
    size_t played = 0, off = 0, come = 0, by[ADVISE_RUNWAY_PARTS] = {0};
    float *at_ft = xcalloc(members->member_count, sizeof *at_ft);
    advise_draw_braking(members, plan, mean_ft_s2, braking);
    if (!advise_simulate(members, braking, false, outcome)) {
        free(at_ft);
        return false;
    }
    for (size_t m = 0; m < members->member_count; m++) {
        if (outcome[m].has_diverged)
            continue;
        played++;
        off += (double)outcome[m].stop_station_ft >= end_ft;
        if (isnan(outcome[m].zone_station_ft))
            continue;
        at_ft[come++] = outcome[m].zone_station_ft;
        for (unsigned s = 0; s < ADVISE_RUNWAY_PARTS; s++)
            by[s] += (double)outcome[m].zone_station_ft <= end_ft * (s + 1u) / ADVISE_RUNWAY_PARTS;
    }
    qsort(at_ft, come, sizeof *at_ft, compare_floats);
    *row = (struct advise_row){.speed_ft_s = plan->speed_ft_s,
                               .mean_braking_ft_s2 = mean_ft_s2,
                               .median_zone_station_ft = come ? (double)at_ft[come / 2]
                                                              : (double)NAN};
    if (played) {
        row->zone_share = (double)come / (double)played;
        row->zone_probability = advise_compute_probability(come, played, members->is_surveyed);
        row->off_runway_share = (double)off / (double)played;
        for (unsigned s = 0; s < ADVISE_RUNWAY_PARTS; s++)
            row->zone_probability_by_part[s] = advise_compute_probability(by[s], played,
                                                                          members->is_surveyed);
    }
    free(at_ft);
    return played > 0;
}

double advise_compute_min_braking_ft_s2(const struct advise_members *members,
                                        const struct advise_plan *plan)
{
    const struct mr_chain_params *chain = &members->runway.chain;
    double left_ft = (double)chain->mat_length_ft * chain->mats - plan->touchdown_ft;
    return plan->speed_ft_s * plan->speed_ft_s / (2.0 * left_ft);
}

double advise_find_stop_short_ft_s2(const struct advise_row *row, size_t rows, double limit)
{
    size_t first = rows; /* all rows from this index on are below the limit */
    while (first > 0 && row[first - 1].zone_probability.probability < limit)
        first--;
    return first > 0 && first < rows ? row[first].mean_braking_ft_s2 : (double)NAN;
}

/* Selects the probability of a zone or an end of its interval. The highest probability is first. */
enum risk_level { RISK_INTERVAL_HIGH, RISK_ESTIMATE, RISK_INTERVAL_LOW, RISK_LEVEL_COUNT };

static double get_row_risk(const struct advise_row *row, enum risk_level of)
{
    double zone = of == RISK_INTERVAL_HIGH ? row->zone_probability.high
                : of == RISK_ESTIMATE      ? row->zone_probability.probability
                                           : row->zone_probability.low;
    return fmax(zone, row->off_runway_share);
}

/* Returns the index of the first row at or above the limit, or `rows` if there is none. */
static size_t find_first_row_above(const struct advise_row *row, size_t rows, double limit,
                                   enum risk_level of)
{
    size_t i = 0;
    while (i < rows && get_row_risk(&row[i], of) < limit)
        i++;
    return i;
}

static double interpolate_limit_crossing(const double *x, const struct advise_row *row, size_t rows,
                                         double limit, enum risk_level of)
{
    size_t i = find_first_row_above(row, rows, limit, of);
    if (i == 0 || i == rows)
        return (double)NAN;
    double from = get_row_risk(&row[i - 1], of), to = get_row_risk(&row[i], of);
    return x[i - 1] + (x[i] - x[i - 1]) * (limit - from) / (to - from);
}

struct advise_limit_crossing advise_find_limit_crossing(const double *x,
                                                        const struct advise_row *row, size_t rows,
                                                        double limit)
{
    bool beyond = rows && find_first_row_above(row, rows, limit, RISK_ESTIMATE) == rows;
    return (struct advise_limit_crossing){
        .value = beyond ? x[rows - 1]
                        : interpolate_limit_crossing(x, row, rows, limit, RISK_ESTIMATE),
        .low = interpolate_limit_crossing(x, row, rows, limit, RISK_INTERVAL_HIGH),
        .high = interpolate_limit_crossing(x, row, rows, limit, RISK_INTERVAL_LOW),
        .is_unbounded = beyond};
}

size_t advise_find_wide_row_step(const double *x, const struct advise_row *row, size_t rows,
                                 double limit, double width)
{
    static const enum risk_level order[RISK_LEVEL_COUNT] = {RISK_ESTIMATE, RISK_INTERVAL_HIGH,
                                                            RISK_INTERVAL_LOW};
    for (size_t k = 0; k < RISK_LEVEL_COUNT; k++) {
        size_t i = find_first_row_above(row, rows, limit, order[k]);
        if (i > 0 && i < rows && x[i] - x[i - 1] > width)
            return i - 1;
    }
    return rows;
}
