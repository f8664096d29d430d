/* A band of report appendix C, element by element, for tests of common/bands.c; shares nothing with
 * it.
 *
 * Rivets at equal distances tie the band to mats; between them segments of stiffness AE/L, at the
 * ends a spring K and an anchor that does not move. At each rivet  T_ahead - T_behind + f = 0
 * (before C.6), f the force of the mats on the band, forward positive: the gear's share, and
 * friction of the mats as a spring that slides at F' (the residual friction of figure C.2). A
 * segment cannot push. Solved for rest at every 2 ms. Damage: a segment that grows longer at once
 * (splice or anchor slips), a rivet that lets go.
 *
 * A header because each test program is one file; include it once. Lengths in feet, stretches in
 * inches, forces in pounds. */
#ifndef MATRIG_TESTS_COMMON_BAND_CHAIN_H
#define MATRIG_TESTS_COMMON_BAND_CHAIN_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "common/splitmix.h"

#define CHAIN_RIVETS    64
#define CHAIN_AE_LB     (0.375 * 0.020 * 29e6) /* 3/8 by 0.020 in of steel */
#define CHAIN_LENGTH_FT 120.0

struct chain {
    int rivets;
    double spacing_ft, spring_lb_in;
    double pretension_lb;
    double tight_lb[CHAIN_RIVETS + 1]; /* of a segment beyond the pretension, as it was attached */
    double friction_lb, hold_lb_in;    /* F' and its stiffness before it slides */
    double slip_in[CHAIN_RIVETS + 1];  /* of a segment */
    bool out[CHAIN_RIVETS];            /* rivets that let go */

    double u_in[CHAIN_RIVETS];
    double anchor_in[CHAIN_RIVETS]; /* where friction would be nothing */
    double tension_lb[CHAIN_RIVETS + 1];
    double push_lb[CHAIN_RIVETS]; /* of the mats on the band, friction included, newest */
};

static inline double chain_rivet_ft(const struct chain *c, int j)
{
    return c->spacing_ft * (j + 1);
}

static inline double chain_stiffness(const struct chain *c, int segment)
{
    double last_ft = CHAIN_LENGTH_FT - chain_rivet_ft(c, c->rivets - 1);
    double flexibility = (segment == c->rivets ? last_ft : c->spacing_ft) * 12.0 / CHAIN_AE_LB;
    if (segment == 0 || segment == c->rivets)
        flexibility += 1.0 / c->spring_lb_in;
    return 1.0 / flexibility;
}

/* The gear's share of each rivet: a triangle from 4 ft behind the wheel to 12 ft ahead of it,
 * `force_lb` in all. */
static inline void chain_share(const struct chain *c, double wheel_ft, double force_lb,
                               double *share_lb)
{
    double sum = 0.0;
    for (int j = 0; j < c->rivets; j++) {
        double reach = 1.0 - fabs(chain_rivet_ft(c, j) - wheel_ft - 4.0) / 8.0;
        share_lb[j] = reach > 0.0 && !c->out[j] ? reach : 0.0;
        sum += share_lb[j];
    }
    for (int j = 0; j < c->rivets; j++)
        share_lb[j] *= sum > 0.0 ? force_lb / sum : 0.0;
}

/* Tension of a segment, its slope by stretch, and the energy stored in it. */
static inline double chain_segment(const struct chain *c, const double *u_in, int s, double *slope,
                                   double *energy)
{
    double k = chain_stiffness(c, s), behind = s ? u_in[s - 1] : 0.0,
           ahead = s < c->rivets ? u_in[s] : 0.0;
    double lb = c->pretension_lb + c->tight_lb[s] + k * (ahead - behind - c->slip_in[s]);
    *slope = lb > 0.0 ? k : 0.0;
    *energy = lb > 0.0 ? 0.5 * lb * lb / k : 0.0;
    return lb > 0.0 ? lb : 0.0;
}

/* Friction at a rivet, against u; the same two. */
static inline double chain_hold(const struct chain *c, const double *u_in, int j, double *slope,
                                double *energy)
{
    double d = u_in[j] - c->anchor_in[j], elastic_in = c->friction_lb / c->hold_lb_in;
    *slope = *energy = 0.0;
    if (c->out[j])
        return 0.0;
    if (fabs(d) > elastic_in) {
        *energy = c->friction_lb * (fabs(d) - 0.5 * elastic_in);
        return d > 0.0 ? c->friction_lb : -c->friction_lb;
    }
    *slope = c->hold_lb_in;
    *energy = 0.5 * c->hold_lb_in * d * d;
    return c->hold_lb_in * d;
}

static inline double chain_energy(const struct chain *c, const double *u_in, const double *share_lb)
{
    double sum = 0.0, slope, energy;
    for (int s = 0; s <= c->rivets; s++) {
        (void)chain_segment(c, u_in, s, &slope, &energy);
        sum += energy;
    }
    for (int j = 0; j < c->rivets; j++) {
        (void)chain_hold(c, u_in, j, &slope, &energy);
        sum += energy - share_lb[j] * u_in[j];
    }
    return sum;
}

/* Newton's direction from the tridiagonal system; returns the largest force out of balance. */
static inline double chain_direction(const struct chain *c, const double *share_lb, double *step_in)
{
    double tension[CHAIN_RIVETS + 1], slope[CHAIN_RIVETS + 1], diagonal[CHAIN_RIVETS], energy,
        worst = 0.0;
    for (int s = 0; s <= c->rivets; s++)
        tension[s] = chain_segment(c, c->u_in, s, &slope[s], &energy);
    for (int j = 0; j < c->rivets; j++) {
        double hold;
        step_in[j] = tension[j + 1] - tension[j] + share_lb[j] -
                     chain_hold(c, c->u_in, j, &hold, &energy);
        worst = fmax(worst, fabs(step_in[j]));
        diagonal[j] = slope[j] + slope[j + 1] + hold + 1.0;
        if (j) {
            double factor = -slope[j] / diagonal[j - 1];
            diagonal[j] += factor * slope[j];
            step_in[j] -= factor * step_in[j - 1];
        }
    }
    for (int j = c->rivets - 1; j >= 0; j--)
        step_in[j] = (step_in[j] + (j + 1 < c->rivets ? slope[j + 1] * step_in[j + 1] : 0.0)) /
                     diagonal[j];
    return worst;
}

/* Rest under the gear's force: the least of the energy, which is convex, by Newton with halved
 * steps. */
static inline void chain_settle(struct chain *c, double wheel_ft, double force_lb)
{
    double share_lb[CHAIN_RIVETS], step_in[CHAIN_RIVETS], trial_in[CHAIN_RIVETS], slope, energy;
    chain_share(c, wheel_ft, force_lb, share_lb);
    double now = chain_energy(c, c->u_in, share_lb);
    for (int i = 0; i < 200 && chain_direction(c, share_lb, step_in) > 1e-4; i++) {
        double length = 1.0, then;
        for (;; length *= 0.5) {
            for (int j = 0; j < c->rivets; j++)
                trial_in[j] = c->u_in[j] + length * step_in[j];
            then = chain_energy(c, trial_in, share_lb);
            if (then <= now || length < 1e-6)
                break;
        }
        memcpy(c->u_in, trial_in, sizeof c->u_in);
        now = then;
    }
    for (int s = 0; s <= c->rivets; s++)
        c->tension_lb[s] = chain_segment(c, c->u_in, s, &slope, &energy);
    for (int j = 0; j < c->rivets; j++) {
        double hold_lb = chain_hold(c, c->u_in, j, &slope, &energy);
        c->push_lb[j] = c->tension_lb[j] - c->tension_lb[j + 1];
        if (slope == 0.0) /* it slides, or hangs on nothing */
            c->anchor_in[j] = c->u_in[j] - hold_lb / c->hold_lb_in;
    }
}

/* Tension that a gage at a station shows. */
static inline double chain_at(const struct chain *c, double station_ft)
{
    int segment = (int)(station_ft / c->spacing_ft);
    return c->tension_lb[segment < c->rivets ? segment : c->rivets];
}

static inline double chain_uniform(uint64_t *state, double least, double most)
{
    return least + (most - least) * mr_splitmix64_uniform(state);
}

static inline double chain_normal(uint64_t *state)
{
    double sum = 0.0;
    for (int i = 0; i < 12; i++)
        sum += chain_uniform(state, 0.0, 1.0);
    return sum - 6.0;
}

#endif
