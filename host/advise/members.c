#include "host/advise/members.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/parallel_for.h"
#include "host/base/statistics.h"
#include "host/sim/models/chains.h"
#include "host/base/xmalloc.h"

#define STREAM    1u
#define LOOK_S    0.05
#define SETTLE_S  1e-3
#define ONSET_S   0.06
#define AFTER_S   0.1  /* mats keep moving this long after the gear stops */
#define LONGEST_S 60.0 /* longer than any landing */
#define CLOSED_FT (0.001f / 12.0f)
#define TALLY     10  /* consecutive joints of a zone, one of which may be open */
#define LAID_MOST 1.2 /* gaps as laid: uniform up to this many slacks, then limited to one slack */

/* Prior as in host/landing_series: factors of the configured values, uniform or lognormal. */
static const struct {
    double low, high; /* bounds of the factor */
    double least;     /* spread (of the logarithm) that always remains */
} bounds[ADVISE_UNKNOWNS] = {
    [ADVISE_SHARE] = {0.5, 1.6, 0.05},     [ADVISE_FRICTION] = {0.5, 1.8, 0.04},
    [ADVISE_RESISTANCE] = {0.3, 2.5, 0.1}, [ADVISE_STIFFNESS] = {0.5, 1.6, 0.0},
    [ADVISE_DAMPING] = {0.3, 2.5, 0.0},
};

/* standard error of a transducer at rest, unless a larger error is given */
#define READING_IN   0.003
#define SHARE_ERROR  0.03 /* standard error of a measured share */
#define SHARE_SPREAD 0.18 /* standard error of an unmeasured share: uniform from 0.7 to 1.3 */
#define MODEL_SHARE  0.15 /* share of a movement that the chain model does not explain */
#define MODEL_IN     0.01
#define SUM_SHARE    0.25 /* MODEL_SHARE for the closing of ten joints */
#define SUM_IN       0.01
#define PASSES       2
#define KEPT         0.5  /* part of the spread that remains of what a landing would remove */
#define NEAR_FT      12.0 /* a transducer affects joints up to twice this distance */

/* ---- drawing ---- */

static double stated_value(const struct advise_runway *runway, enum advise_parameter unknown)
{
    switch (unknown) {
    case ADVISE_SHARE: return runway->share > 0.0 ? runway->share : 1.0;
    case ADVISE_FRICTION: return (double)runway->chain.friction_lb;
    case ADVISE_RESISTANCE: return runway->grit_lb;
    case ADVISE_STIFFNESS: return (double)runway->chain.kl_lb_ft;
    case ADVISE_DAMPING: return (double)runway->chain.cl_lb_s_ft;
    default: return 1.0;
    }
}

static void draw_unknowns(struct advise_member *member, const struct advise_runway *runway,
                          struct chance *chance)
{
    double *u = member->unknown;
    u[ADVISE_SHARE] = log(0.7 + 0.6 * chance_uniform(chance));
    if (runway->share > 0.0) /* scaled after the draw, so later draws do not change */
        u[ADVISE_SHARE] *= SHARE_ERROR / SHARE_SPREAD;
    u[ADVISE_FRICTION] = 0.1 * chance_normal(chance);
    u[ADVISE_RESISTANCE] = -0.6 + chance_uniform(chance);
    u[ADVISE_STIFFNESS] = -0.5 + 0.9 * chance_uniform(chance);
    u[ADVISE_DAMPING] = -0.9 + 1.6 * chance_uniform(chance);
    for (int k = 0; k < ADVISE_UNKNOWNS; k++)
        u[k] += log(stated_value(runway, (enum advise_parameter)k));
}

static void draw_gaps(struct advise_members *members, struct advise_member *member, unsigned first,
                      unsigned last)
{
    double slack_ft = (double)members->runway.chain.slack_ft;
    for (unsigned j = first; j <= last; j++)
        member->gap_ft[j] = (float)fmin(LAID_MOST * slack_ft * chance_uniform(&members->chance),
                                        slack_ft);
}

static bool is_plausible(const struct advise_runway *r)
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
        .count = (count + CHAINS_LANES - 1) / CHAINS_LANES * CHAINS_LANES,
        .threads = processors > 1 ? (unsigned)processors : 1u,
        .chance = chance_from(seed, STREAM),
    };
    if (!is_plausible(runway) || count < CHAINS_LANES || count > ADVISE_MOST)
        return MR_USAGE;
    members->member = xcalloc(members->count, sizeof *members->member);
    for (size_t m = 0; m < members->count; m++) {
        struct advise_member *member = &members->member[m];
        draw_unknowns(member, runway, &members->chance);
        draw_gaps(members, member, 0, runway->chain.mats);
        for (unsigned j = 0; j <= runway->chain.mats; j++)
            member->grit[j] = (float)(2.0 * chance_uniform(&members->chance));
    }
    return MR_OK;
}

void advise_members_free(struct advise_members *members)
{
    free(members->member);
    members->member = NULL;
}

void advise_relay(struct advise_members *members)
{
    for (size_t m = 0; m < members->count; m++)
        draw_gaps(members, &members->member[m], 0, members->runway.chain.mats);
    members->surveyed = false;
}

void advise_repair(struct advise_members *members, unsigned first, unsigned last)
{
    for (size_t m = 0; m < members->count; m++) {
        struct advise_member *member = &members->member[m];
        draw_gaps(members, member, first, last);
        for (unsigned j = first; j <= last; j++)
            member->grit[j] = (float)(2.0 * chance_uniform(&members->chance));
    }
}

/* Changes ten openings to a given sum: scales the openings down, or the remaining room to the
 * slack. */
static void scale_to_sum(float *gap_ft, double sum_ft, double slack_ft)
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

static unsigned segments_of(const struct advise_members *members)
{
    unsigned whole = members->runway.chain.mats / MR_MATS_PER_SEGMENT;
    return whole < MR_SEGMENTS ? whole : MR_SEGMENTS;
}

void advise_survey(struct advise_members *members, const double sum_in[MR_SEGMENTS],
                   double error_in)
{
    double slack_ft = (double)members->runway.chain.slack_ft;
    for (unsigned s = 0; s < segments_of(members); s++)
        members->surveyed = members->surveyed || isfinite(sum_in[s]);
    for (size_t m = 0; m < members->count; m++) {
        for (unsigned s = 0; s < segments_of(members); s++) {
            double off_in = error_in * chance_normal(&members->chance);
            if (isfinite(sum_in[s]))
                scale_to_sum(members->member[m].gap_ft + MR_MATS_PER_SEGMENT * s,
                             (sum_in[s] + off_in) / 12.0, slack_ft);
        }
    }
}

/* ---- simulation ---- */

struct advise_zone advise_longest(const float *opening_ft, unsigned joints, unsigned from)
{
    struct advise_zone best = {0, 0};
    for (unsigned first = from; first < joints; first++) {
        int last_open = (int)first - TALLY;
        if (opening_ft[first] > CLOSED_FT)
            continue;
        for (unsigned j = first + 1u; j < joints; j++) {
            if (opening_ft[j] > CLOSED_FT) {
                if ((int)j - last_open < TALLY)
                    break;
                last_open = (int)j;
            } else if (j - first > best.mats) {
                best = (struct advise_zone){first, j - first};
            }
        }
    }
    return best;
}

/* Gear of one lane. */
struct gear {
    double speed_ft_s, at_ft, thrust_lb_per_g;
};

double advise_factor(const struct advise_profile *profile, double t_s)
{
    if (!profile || !profile->count)
        return 1.0;
    size_t last = profile->count - 1;
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
    if (t_s >= ONSET_S && !braking->profile)
        return braking->mean_ft_s2;
    double part = fmin(t_s / ONSET_S, 1.0);
    return part * part * (3.0 - 2.0 * part) * braking->mean_ft_s2 *
           advise_factor(braking->profile, t_s);
}

/* Eight members and their landings. */
struct batch {
    const struct advise_members *members;
    struct advise_member *member;
    const struct advise_braking *braking;
    struct advise_course *met;
    bool keeps;
    struct gear gear[CHAINS_LANES];
    double step_s;
};

static struct chains *start(struct batch *b, float grit_lb[CHAINS_LANES][ADVISE_JOINTS])
{
    const struct mr_chain_params *told_of = &b->members->runway.chain;
    struct mr_chain_params params[CHAINS_LANES];
    const float *gap[CHAINS_LANES], *grit[CHAINS_LANES];
    enum mr_status status;
    double limit_s = (double)INFINITY;
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        const double *u = b->member[k].unknown;
        double mean_lb = exp(u[ADVISE_RESISTANCE]);
        params[k] = *told_of;
        params[k].friction_lb = (float)exp(u[ADVISE_FRICTION]);
        params[k].kl_lb_ft = (float)exp(u[ADVISE_STIFFNESS]);
        params[k].cl_lb_s_ft = (float)exp(u[ADVISE_DAMPING]);
        limit_s = fmin(limit_s, (double)mr_chain_step_limit_s(&params[k]));
        for (unsigned j = 0; j <= told_of->mats; j++)
            grit_lb[k][j] = (float)(mean_lb * (double)b->member[k].grit[j]);
        gap[k] = b->member[k].gap_ft;
        grit[k] = grit_lb[k];
    }
    /* a whole number of steps per block */
    b->step_s = SETTLE_S / ceil(SETTLE_S / (0.98 * (double)MR_CHAIN_STEP_MARGIN * limit_s));
    for (unsigned k = 0; k < CHAINS_LANES; k++)
        params[k].step_s = (float)b->step_s;
    return chains_new(params, gap, grit, &status);
}

static void roll(struct batch *b, unsigned k, double t_s, unsigned *mat, float *thrust_lb)
{
    const struct mr_chain_params *chain = &b->members->runway.chain;
    struct gear *gear = &b->gear[k];
    double length_ft = (double)chain->mat_length_ft, a = advise_braking_ft_s2(&b->braking[k], t_s);
    bool on = gear->at_ft >= 0.0 && gear->at_ft < length_ft * chain->mats && gear->speed_ft_s > 0.0;
    *mat = on ? (unsigned)(gear->at_ft / length_ft) + 1u : 1u;
    *thrust_lb = on ? (float)(gear->thrust_lb_per_g * a / ADVISE_G_FT_S2) : 0.0f;
    gear->at_ft += fmax(gear->speed_ft_s, 0.0) * b->step_s;
    gear->speed_ft_s -= a * b->step_s;
}

static void record_closure(struct batch *b, const struct chains *chains, unsigned k)
{
    const struct mr_chain_params *chain = &b->members->runway.chain;
    const struct gear *gear = &b->gear[k];
    double length_ft = (double)chain->mat_length_ft;
    float opening_ft[ADVISE_JOINTS];
    if (!(gear->speed_ft_s > ADVISE_SLOW_FT_S) || gear->at_ft < 0.0)
        return;
    for (unsigned j = 0; j <= chain->mats; j++)
        opening_ft[j] = chains_opening_ft(chains, k, j + 1u);
    struct advise_zone zone = advise_longest(opening_ft, chain->mats + 1u,
                                             (unsigned)ceil(gear->at_ft / length_ft));
    if (!zone.mats || zone.first * length_ft - gear->at_ft >= ADVISE_ZONE_FT)
        return;
    if (zone.mats > b->met[k].most_mats)
        b->met[k].most_mats = (uint16_t)zone.mats;
    if (zone.mats >= ADVISE_ZONE_MATS && isnan(b->met[k].zone_ft))
        b->met[k].zone_ft = (float)gear->at_ft;
}

static void conclude(struct batch *b, const struct chains *chains, unsigned k)
{
    const struct advise_runway *runway = &b->members->runway;
    struct advise_course *met = &b->met[k];
    double length_ft = (double)runway->chain.mat_length_ft,
           slack_ft = (double)runway->chain.slack_ft;
    met->stop_ft = (float)b->gear[k].at_ft;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++) {
        double at = (double)runway->station_ft[i] / length_ft;
        met->moved_in[i] = at >= 0.0 && at < runway->chain.mats
                             ? 12.0f * chains_displacement_ft(chains, k, (unsigned)at + 1u)
                             : NAN;
    }
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        met->sum_in[s] = s < segments_of(b->members) ? 0.0f : NAN;
    for (unsigned j = 0; j <= runway->chain.mats; j++) {
        double g = fmin(fmax((double)chains_opening_ft(chains, k, j + 1u), 0.0), slack_ft);
        if (j / MR_MATS_PER_SEGMENT < segments_of(b->members))
            met->sum_in[j / MR_MATS_PER_SEGMENT] += (float)(12.0 * g);
        if (b->keeps && !met->ran_away)
            b->member[k].gap_ft[j] = (float)g;
    }
}

static bool is_rolling(const struct batch *b)
{
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        if (b->gear[k].speed_ft_s > 0.0 &&
            b->gear[k].at_ft <
                (double)b->members->runway.chain.mat_length_ft * b->members->runway.chain.mats)
            return true;
    }
    return false;
}

static bool play_batch(struct batch *b)
{
    float(*grit_lb)[ADVISE_JOINTS] = xcalloc(CHAINS_LANES, sizeof *grit_lb);
    struct chains *chains = start(b, grit_lb);
    unsigned mat[CHAINS_LANES], away = 0;
    float thrust_lb[CHAINS_LANES];
    if (!chains) {
        free(grit_lb);
        return false;
    }
    const unsigned settle = (unsigned)(SETTLE_S / b->step_s + 0.5),
                   each_look = settle * (unsigned)(LOOK_S / SETTLE_S + 0.5);
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        b->gear[k] = (struct gear){.speed_ft_s = b->braking[k].speed_ft_s,
                                   .at_ft = b->braking[k].touchdown_ft,
                                   .thrust_lb_per_g = exp(b->member[k].unknown[ADVISE_SHARE]) *
                                                      b->members->runway.thrust_lb_per_g};
        b->met[k] = (struct advise_course){.zone_ft = NAN};
    }
    double rest_s = 0.0;
    for (unsigned step = 0; rest_s < AFTER_S && (double)step * b->step_s < LONGEST_S; step++) {
        for (unsigned k = 0; k < CHAINS_LANES; k++)
            roll(b, k, (double)step * b->step_s, &mat[k], &thrust_lb[k]);
        chains_step(chains, mat, thrust_lb);
        if (step % settle == settle - 1u) {
            away |= chains_settle(chains);
            rest_s = is_rolling(b) ? 0.0 : rest_s + SETTLE_S;
        }
        for (unsigned k = 0; step % each_look == 0 && k < CHAINS_LANES; k++)
            record_closure(b, chains, k);
    }
    for (unsigned k = 0; k < CHAINS_LANES; k++) {
        b->met[k].ran_away = away >> k & 1u;
        conclude(b, chains, k);
    }
    chains_free(chains);
    free(grit_lb);
    return true;
}

/* All batches of a landing. */
struct playing {
    struct advise_members *members;
    const struct advise_braking *braking;
    struct advise_course *met;
    bool keeps;
    _Atomic bool failed;
};

static void play_some(void *context, size_t from, size_t every)
{
    struct playing *p = context;
    size_t batches = p->members->count / CHAINS_LANES;
    for (size_t i = from; i < batches && !p->failed; i += every) {
        struct batch batch = {.members = p->members,
                              .member = p->members->member + CHAINS_LANES * i,
                              .braking = p->braking + CHAINS_LANES * i,
                              .met = p->met + CHAINS_LANES * i,
                              .keeps = p->keeps};
        if (!play_batch(&batch))
            p->failed = true;
    }
}

bool advise_play(struct advise_members *members, const struct advise_braking *braking, bool keeps,
                 struct advise_course *met)
{
    struct playing playing = {.members = members, .braking = braking, .met = met, .keeps = keeps};
    parallel_for(members->threads, play_some, &playing);
    return !playing.failed;
}

/* ---- smoother ---- */

/* Work space of one pass, for the `n` readings that exist. */
struct work {
    size_t n;
    size_t *datum;       /* [n] index of each reading */
    double *away;        /* [members][n] prediction minus mean */
    double *matrix;      /* [n][n], then its Cholesky factor */
    double *innovations; /* [members][n], then multiplied by the inverse */
    double *gain;        /* [n]: row of one state */
    double *shift;       /* [members] */
};

/* Covariance of the predictions, plus the variance of the errors. */
static void fill_matrix(struct work *w, const struct smoother *s)
{
    for (size_t i = 0; i < w->n; i++) {
        double mean = 0.0, error = s->error[w->datum[i]];
        for (size_t m = 0; m < s->members; m++)
            mean += s->predicted[m * s->data + w->datum[i]] / (double)s->members;
        for (size_t m = 0; m < s->members; m++)
            w->away[m * w->n + i] = s->predicted[m * s->data + w->datum[i]] - mean;
        w->matrix[i * w->n + i] = s->passes * error * error;
    }
    for (size_t m = 0; m < s->members; m++) {
        const double *y = w->away + m * w->n;
        for (size_t i = 0; i < w->n; i++) {
            for (size_t k = 0; k <= i; k++)
                w->matrix[i * w->n + k] += y[i] * y[k] / (double)(s->members - 1);
        }
    }
}

/* Cholesky factor in the lower half; the errors keep the matrix positive definite. */
static void factor(struct work *w)
{
    double *a = w->matrix;
    size_t n = w->n;
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
static void solve(const struct work *w, double *b)
{
    const double *a = w->matrix;
    size_t n = w->n;
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

/* Perturbed readings minus predictions. The mean perturbation is subtracted: it would shift the
 * whole ensemble at random. */
static void innovate(struct work *w, const struct smoother *s, struct chance *chance)
{
    for (size_t i = 0; i < w->n; i++) {
        size_t d = w->datum[i];
        double mean = 0.0, error = sqrt(s->passes) * s->error[d];
        for (size_t m = 0; m < s->members; m++) {
            double z = chance_normal(chance);
            mean += z / (double)s->members;
            w->innovations[m * w->n + i] = z;
        }
        for (size_t m = 0; m < s->members; m++) {
            double *at = &w->innovations[m * w->n + i];
            *at = s->read[d] + error * (*at - mean) - s->predicted[m * s->data + d];
        }
    }
}

/* Updates one state of all members. Row of the gain: covariance with the readings times the
 * inverse. The taper applies to the gain, so a near reading's share is not moved to a far one. */
static void move(struct work *w, const struct smoother *s, size_t state)
{
    double mean = 0.0;
    for (size_t m = 0; m < s->members; m++)
        mean += s->state[m * s->states + state] / (double)s->members;
    memset(w->gain, 0, w->n * sizeof *w->gain);
    for (size_t m = 0; m < s->members; m++) {
        double x = s->state[m * s->states + state] - mean;
        for (size_t i = 0; i < w->n; i++)
            w->gain[i] += x * w->away[m * w->n + i] / (double)(s->members - 1);
    }
    solve(w, w->gain);
    for (size_t i = 0; s->nearness && i < w->n; i++)
        w->gain[i] *= s->nearness(s->context, state, w->datum[i]);
    for (size_t m = 0; m < s->members; m++) {
        double shift = 0.0;
        for (size_t i = 0; i < w->n; i++)
            shift += w->gain[i] * w->innovations[m * w->n + i];
        w->shift[m] = shift;
    }
    for (size_t m = 0; m < s->members; m++)
        s->state[m * s->states + state] += w->shift[m];
}

void smoother_take(const struct smoother *s, struct chance *chance)
{
    struct work w = {
        .datum = xcalloc(s->data, sizeof *w.datum),
        .away = xcalloc(s->members * s->data, sizeof *w.away),
        .matrix = xcalloc(s->data * s->data, sizeof *w.matrix),
        .innovations = xcalloc(s->members * s->data, sizeof *w.innovations),
        .gain = xcalloc(s->data, sizeof *w.gain),
        .shift = xcalloc(s->members, sizeof *w.shift),
    };
    for (size_t d = 0; d < s->data; d++) {
        if (isfinite(s->read[d]))
            w.datum[w.n++] = d;
    }
    if (w.n) {
        fill_matrix(&w, s);
        factor(&w);
        innovate(&w, s, chance);
        for (size_t state = 0; state < s->states; state++)
            move(&w, s, state);
    }
    free(w.datum);
    free(w.away);
    free(w.matrix);
    free(w.innovations);
    free(w.gain);
    free(w.shift);
}

void smoother_spread(const double *state, size_t members, size_t states, size_t column,
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

void smoother_widen(double *state, size_t members, size_t states, size_t column, double was,
                    double kept, double least)
{
    double mean, now;
    smoother_spread(state, members, states, column, &mean, &now);
    double wanted = fmax(now + kept * fmax(was - now, 0.0), least);
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

#define STATES (ADVISE_UNKNOWNS + ADVISE_JOINTS)
#define DATA   (MR_TRANSDUCERS + MR_SEGMENTS)

static double nearness(const void *context, size_t state, size_t datum)
{
    const struct advise_runway *runway = context;
    if (state < ADVISE_UNKNOWNS)
        return 1.0;
    size_t joint = state - ADVISE_UNKNOWNS;
    if (datum >= MR_TRANSDUCERS) /* the closing of ten joints affects only these joints */
        return joint / MR_MATS_PER_SEGMENT == datum - MR_TRANSDUCERS ? 1.0 : 0.0;
    return smoother_taper((double)joint * (double)runway->chain.mat_length_ft -
                              (double)runway->station_ft[datum],
                          NEAR_FT);
}

struct assimilation {
    double *state, *predicted;
    double read[DATA], error[DATA];
    struct advise_braking *braking;
    struct advise_course *met;
};

static void assimilation_free(struct assimilation *l)
{
    free(l->state);
    free(l->predicted);
    free(l->braking);
    free(l->met);
}

static void assimilation_get(struct assimilation *l, const struct advise_members *members)
{
    *l = (struct assimilation){.state = xcalloc(members->count * STATES, sizeof *l->state),
                               .predicted = xcalloc(members->count * DATA, sizeof *l->predicted),
                               .braking = xcalloc(members->count, sizeof *l->braking),
                               .met = xcalloc(members->count, sizeof *l->met)};
}

static void to_state(const struct advise_members *members, struct assimilation *l)
{
    for (size_t m = 0; m < members->count; m++) {
        const struct advise_member *member = &members->member[m];
        double *state = l->state + m * STATES;
        memcpy(state, member->unknown, sizeof member->unknown);
        for (unsigned j = 0; j < ADVISE_JOINTS; j++)
            state[ADVISE_UNKNOWNS + j] = (double)member->gap_ft[j];
        for (unsigned d = 0; d < DATA; d++)
            l->predicted[m * DATA + d] = (double)(d < MR_TRANSDUCERS
                                                      ? l->met[m].moved_in[d]
                                                      : l->met[m].sum_in[d - MR_TRANSDUCERS]);
    }
}

/* Sets the readings and their standard errors. Each error combines the reading's own with the chain
 * model's, a share of the movement or closing. */
static void find_errors(const struct advise_members *members, const struct advise_observation *seen,
                        struct assimilation *l)
{
    for (unsigned d = 0; d < DATA; d++) {
        double mean = 0.0;
        for (size_t m = 0; m < members->count; m++)
            mean += l->predicted[m * DATA + d] / (double)members->count;
        if (d < MR_TRANSDUCERS) {
            double own = fmax(seen->moved_error_in, READING_IN);
            l->read[d] = isfinite(mean) ? seen->moved_in[d] : (double)NAN;
            l->error[d] = hypot(own,
                                MODEL_SHARE * fmax(fabs(seen->moved_in[d]), fabs(mean)) + MODEL_IN);
        } else {
            unsigned s = d - MR_TRANSDUCERS;
            double change = fabs(seen->before_in[s] - seen->after_in[s]);
            /* without a survey before, the closing is unknown; the remaining opening is known */
            l->read[d] = isfinite(mean) ? seen->after_in[s] : (double)NAN;
            l->error[d] = hypot(1.4142135623730951 * seen->survey_error_in,
                                SUM_SHARE * (isfinite(change) ? change : 0.1) + SUM_IN);
        }
    }
}

static void from_state(struct advise_members *members, const struct assimilation *l)
{
    const struct advise_runway *runway = &members->runway;
    for (size_t m = 0; m < members->count; m++) {
        struct advise_member *member = &members->member[m];
        const double *state = l->state + m * STATES;
        for (int k = 0; k < ADVISE_UNKNOWNS; k++) {
            double by = stated_value(runway, (enum advise_parameter)k);
            member->unknown[k] = fmin(fmax(state[k], log(bounds[k].low * by)),
                                      log(bounds[k].high * by));
        }
        for (unsigned j = 0; j <= runway->chain.mats; j++)
            member->gap_ft[j] = (float)fmin(fmax(state[ADVISE_UNKNOWNS + j], 0.0),
                                            (double)runway->chain.slack_ft);
    }
}

static bool has_diverged(const struct advise_members *members, const struct assimilation *l)
{
    for (size_t m = 0; m < members->count; m++) {
        if (l->met[m].ran_away)
            return true;
    }
    return false;
}

static bool pass(struct advise_members *members, const struct advise_observation *seen,
                 struct assimilation *l)
{
    if (!advise_play(members, l->braking, false, l->met) || has_diverged(members, l))
        return false;
    to_state(members, l);
    find_errors(members, seen, l);
    const struct smoother smoother = {.members = members->count,
                                      .states = STATES,
                                      .data = DATA,
                                      .state = l->state,
                                      .predicted = l->predicted,
                                      .read = l->read,
                                      .error = l->error,
                                      .passes = PASSES,
                                      .nearness = nearness,
                                      .context = &members->runway};
    smoother_take(&smoother, &members->chance);
    from_state(members, l);
    return true;
}

static void widen(struct advise_members *members, struct assimilation *l, const double *was)
{
    to_state(members, l);
    for (unsigned k = 0; k < ADVISE_UNKNOWNS; k++)
        smoother_widen(l->state, members->count, STATES, k, was[k], KEPT, bounds[k].least);
    from_state(members, l);
}

bool advise_learn(struct advise_members *members, const struct advise_observation *seen)
{
    struct assimilation assimilation;
    double was[ADVISE_UNKNOWNS], mean;
    bool good = true;
    assimilation_get(&assimilation, members);
    advise_survey(members, seen->before_in, seen->survey_error_in);
    for (size_t m = 0; m < members->count; m++)
        assimilation.braking[m] = seen->braking;
    to_state(members, &assimilation);
    for (unsigned k = 0; k < ADVISE_UNKNOWNS; k++)
        smoother_spread(assimilation.state, members->count, STATES, k, &mean, &was[k]);
    for (unsigned i = 0; good && i < PASSES; i++)
        good = pass(members, seen, &assimilation);
    if (good)
        widen(members, &assimilation, was);
    good = good && advise_play(members, assimilation.braking, true, assimilation.met) &&
           !has_diverged(members, &assimilation);
    members->learned += good;
    assimilation_free(&assimilation);
    return good;
}

void advise_widen(struct advise_members *members, double times)
{
    for (int k = 0; k < ADVISE_UNKNOWNS; k++) {
        double mean, spread;
        advise_parameter(members, (enum advise_parameter)k, &mean, &spread);
        for (size_t m = 0; m < members->count; m++) {
            double *u = &members->member[m].unknown[k],
                   by = stated_value(&members->runway, (enum advise_parameter)k);
            *u = log(mean) + times * (*u - log(mean));
            *u = fmin(fmax(*u, log(bounds[k].low * by)), log(bounds[k].high * by));
        }
    }
}

void advise_parameter(const struct advise_members *members, enum advise_parameter unknown,
                      double *mean, double *spread)
{
    double sum = 0.0, squares = 0.0;
    for (size_t m = 0; m < members->count; m++)
        sum += members->member[m].unknown[unknown] / (double)members->count;
    for (size_t m = 0; m < members->count; m++) {
        double off = members->member[m].unknown[unknown] - sum;
        squares += off * off;
    }
    *mean = exp(sum);
    *spread = sqrt(squares / (double)(members->count - 1));
}

/* ---- forecast ---- */

#define FORECAST_STREAM 2u
#define PRIOR_LANDINGS  4.0
#define LEAST_OF        64.0

void advise_plan_met(const double *log_ratio, size_t count, double *bias, double *spread)
{
    const double prior = PRIOR_LANDINGS, n = (double)count;
    double mean = 0.0, squares = 0.0;
    for (size_t i = 0; i < count; i++)
        mean += log_ratio[i] / n;
    for (size_t i = 0; i < count; i++)
        squares += (log_ratio[i] - mean) * (log_ratio[i] - mean);
    /* the prior is such that n = 0 gives ADVISE_PLAN_MET */
    double sum = ADVISE_PLAN_MET * ADVISE_PLAN_MET * (prior - 2.0) / (1.0 + 1.0 / prior) + squares +
                 prior * n / (prior + n) * mean * mean;
    *bias = n * mean / (prior + n);
    *spread = sqrt(sum / (prior + n - 2.0) * (1.0 + 1.0 / (prior + n)));
}

void advise_draw_braking(const struct advise_members *members, const struct advise_plan *plan,
                         double mean_ft_s2, struct advise_braking *braking)
{
    for (size_t m = 0; m < members->count; m++) {
        struct chance chance = chance_from(plan->seed, 1000u * FORECAST_STREAM + m);
        double met = fmin(fmax(plan->spread * chance_normal(&chance), -0.5), 0.4),
               speed = plan->speed_spread * chance_normal(&chance),
               at_ft = plan->touchdown_spread_ft * chance_normal(&chance);
        braking[m] = (struct advise_braking){
            .speed_ft_s = plan->speed_ft_s * fmax(1.0 + speed, 0.5),
            .touchdown_ft = fmax(plan->touchdown_ft + at_ft, 0.0),
            .mean_ft_s2 = mean_ft_s2 * exp(plan->bias) * (1.0 + met),
            .profile = &plan->profile,
        };
    }
}

double advise_log_odds(double share)
{
    double soft = (LEAST_OF * share + 0.5) / (LEAST_OF + 1.0);
    return log(soft / (1.0 - soft));
}

/* Calibrates the members' share: log odds times `times` plus `more`. Fitted on series 250 to 309
 * of make score-foresight, none of which is scored (tests/score/README.md, "Before touchdown"
 * and "Perturbed"). Without a survey, less is known than the members assume. */
double advise_calibrated(double share, bool surveyed)
{
    double times = surveyed ? 0.64 : 0.53, more = surveyed ? 0.49 : -0.28;
    return 1.0 / (1.0 + exp(-(more + times * advise_log_odds(share))));
}

struct advise_chance advise_chance_of(size_t events, size_t count, bool surveyed)
{
    struct wilson share = wilson_interval(events, count);
    return (struct advise_chance){.p = advise_calibrated((double)events / (double)count, surveyed),
                                  .low = advise_calibrated(share.low, surveyed),
                                  .high = advise_calibrated(share.high, surveyed)};
}

static int by_size(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

bool advise_row(struct advise_members *members, const struct advise_plan *plan, double mean_ft_s2,
                struct advise_braking *braking, struct advise_course *met, struct advise_row *row)
{
    const struct mr_chain_params *chain = &members->runway.chain;
    double end_ft = (double)chain->mat_length_ft * chain->mats;
    size_t played = 0, off = 0, come = 0, by[ADVISE_STATIONS] = {0};
    float *at_ft = xcalloc(members->count, sizeof *at_ft);
    advise_draw_braking(members, plan, mean_ft_s2, braking);
    if (!advise_play(members, braking, false, met)) {
        free(at_ft);
        return false;
    }
    for (size_t m = 0; m < members->count; m++) {
        if (met[m].ran_away)
            continue;
        played++;
        off += (double)met[m].stop_ft >= end_ft;
        if (isnan(met[m].zone_ft))
            continue;
        at_ft[come++] = met[m].zone_ft;
        for (unsigned s = 0; s < ADVISE_STATIONS; s++)
            by[s] += (double)met[m].zone_ft <= end_ft * (s + 1u) / ADVISE_STATIONS;
    }
    qsort(at_ft, come, sizeof *at_ft, by_size);
    *row = (struct advise_row){.speed_ft_s = plan->speed_ft_s,
                               .mean_ft_s2 = mean_ft_s2,
                               .half_ft = come ? (double)at_ft[come / 2] : (double)NAN};
    if (played) {
        row->share = (double)come / (double)played;
        row->zone = advise_chance_of(come, played, members->surveyed);
        row->off_runway = (double)off / (double)played;
        for (unsigned s = 0; s < ADVISE_STATIONS; s++)
            row->by_station[s] = advise_chance_of(by[s], played, members->surveyed);
    }
    free(at_ft);
    return played > 0;
}

double advise_least_ft_s2(const struct advise_members *members, const struct advise_plan *plan)
{
    const struct mr_chain_params *chain = &members->runway.chain;
    double left_ft = (double)chain->mat_length_ft * chain->mats - plan->touchdown_ft;
    return plan->speed_ft_s * plan->speed_ft_s / (2.0 * left_ft);
}

double advise_short_ft_s2(const struct advise_row *row, size_t rows, double limit)
{
    size_t first = rows; /* the first of the last consecutive rows below the limit */
    while (first > 0 && row[first - 1].zone.p < limit)
        first--;
    return first > 0 && first < rows ? row[first].mean_ft_s2 : (double)NAN;
}

/* Risk of a row and the limits of its interval, in decreasing order. */
enum risk_of { RISK_HIGH, RISK_P, RISK_LOW, RISKS };

static double risk(const struct advise_row *row, enum risk_of of)
{
    double zone = of == RISK_HIGH ? row->zone.high : of == RISK_P ? row->zone.p : row->zone.low;
    return fmax(zone, row->off_runway);
}

/* The first row at or above the limit; `rows`: none. */
static size_t first_beyond(const struct advise_row *row, size_t rows, double limit, enum risk_of of)
{
    size_t i = 0;
    while (i < rows && risk(&row[i], of) < limit)
        i++;
    return i;
}

static double reach(const double *x, const struct advise_row *row, size_t rows, double limit,
                    enum risk_of of)
{
    size_t i = first_beyond(row, rows, limit, of);
    if (i == 0 || i == rows)
        return (double)NAN;
    double from = risk(&row[i - 1], of), to = risk(&row[i], of);
    return x[i - 1] + (x[i] - x[i - 1]) * (limit - from) / (to - from);
}

struct advise_bound advise_bound(const double *x, const struct advise_row *row, size_t rows,
                                 double limit)
{
    bool beyond = rows && first_beyond(row, rows, limit, RISK_P) == rows;
    return (struct advise_bound){.at = beyond ? x[rows - 1] : reach(x, row, rows, limit, RISK_P),
                                 .low = reach(x, row, rows, limit, RISK_HIGH),
                                 .high = reach(x, row, rows, limit, RISK_LOW),
                                 .beyond = beyond};
}

size_t advise_bound_gap(const double *x, const struct advise_row *row, size_t rows, double limit,
                        double width)
{
    static const enum risk_of order[RISKS] = {RISK_P, RISK_HIGH, RISK_LOW};
    for (size_t k = 0; k < RISKS; k++) {
        size_t i = first_beyond(row, rows, limit, order[k]);
        if (i > 0 && i < rows && x[i] - x[i - 1] > width)
            return i - 1;
    }
    return rows;
}
