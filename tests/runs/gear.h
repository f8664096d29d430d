/* Gear: where the lead wheel of the main bogie is during a synthetic landing, as exactly as double
 * precision allows.
 *
 * It rides the approach track at constant speed, touches down, and from then on is braked:
 *   a(t) = rise(t / 50 ms) * (1 + ripple(t))
 *          * (first + (last - first) * rise((t - bend_from) / (bend_to - bend_from)))
 * with t from touchdown, rise() a quintic from 0 to 1 with two flat derivatives at both ends, and a
 * ripple of three sines of about 1 % together, so that no polynomial of low order is the exact
 * answer. At rest it stays where it is.
 *
 * Speed and distance are integrals by Gauss-Legendre quadrature, tabulated every millisecond and
 * continued from there, so a crossing time solved with them is good to far less than a nanosecond.
 * Of libm it uses floor only, so the bits are the same on every machine. Units ft and s. */
#ifndef MATRIG_TESTS_RUNS_GEAR_H
#define MATRIG_TESTS_RUNS_GEAR_H

#include <stdbool.h>

#define SYN_RIPPLES    3
#define SYN_GEAR_NODES 12000 /* milliseconds of braking at most */

struct syn_gear {
    /* in: */
    double touchdown_ft;
    double touchdown_s;
    double speed_ft_s;
    double first_ft_s2; /* deceleration after touchdown */
    double last_ft_s2;  /* after bend_to_s */
    double bend_from_s; /* from touchdown; used when first and last differ */
    double bend_to_s;
    double ripple[SYN_RIPPLES]; /* fraction of the deceleration */
    double ripple_hz[SYN_RIPPLES];
    double ripple_turn[SYN_RIPPLES]; /* phase at touchdown, turns */
    /* out, by syn_gear_brake: */
    double stop_s; /* on the clock of touchdown_s */
    double stop_ft;
    int nodes;
    double node_v_ft_s[SYN_GEAR_NODES + 1];
    double node_x_ft[SYN_GEAR_NODES + 1];
};

struct syn_gear_motion {
    double x_ft;
    double v_ft_s;
    double a_ft_s2; /* deceleration; 0 before touchdown and at rest */
};

/* Work out the braking. false: it does not come to rest within SYN_GEAR_NODES ms. */
bool syn_gear_brake(struct syn_gear *gear);

struct syn_gear_motion syn_gear_at(const struct syn_gear *gear, double t_s);

/* When the wheel is at a station. false: it stops before. */
bool syn_gear_crosses(const struct syn_gear *gear, double station_ft, double *t_s);

#endif
