/* Motion of the gear; see gear.h. */
#include "tests/runs/gear.h"

#include <math.h>

#define ONSET_S     0.050
#define NODE_S      0.001
#define SPLIT_STEPS 80

/* Gauss-Legendre, four points on [0, 1]: exact to degree 7, and the ripple turns little in a
 * millisecond. */
#define POINTS 4
static const double gauss_at[POINTS] = {0.069431844202973712, 0.330009478207571868,
                                        0.669990521792428132, 0.930568155797026288};
static const double gauss_weight[POINTS] = {0.173927422568726929, 0.326072577431273071,
                                            0.326072577431273071, 0.173927422568726929};

/* 10 x^3 - 15 x^4 + 6 x^5 */
static double rise(double x)
{
    if (x <= 0.0)
        return 0.0;
    if (x >= 1.0)
        return 1.0;
    return x * x * x * (10.0 + x * (-15.0 + 6.0 * x));
}

/* Sine of a phase in turns, by its series on a quarter turn: libm's differs between machines in the
 * last bit. */
static double sine_of_turns(double turns)
{
    const double tau = 6.283185307179586477;
    double part = turns - floor(turns + 0.5); /* -1/2 .. 1/2 */
    double x, square, term, sum;

    if (part > 0.25)
        part = 0.5 - part;
    else if (part < -0.25)
        part = -0.5 - part;
    x = tau * part;
    square = x * x;
    term = sum = x;
    for (int k = 1; k <= 11; k++) {
        term *= -square / (2.0 * k * (2.0 * k + 1.0));
        sum += term;
    }
    return sum;
}

static double deceleration(const struct syn_gear *gear, double braked_s)
{
    double ripple = 1.0;
    double nominal = gear->first_ft_s2;

    for (int i = 0; i < SYN_RIPPLES; i++)
        ripple += gear->ripple[i] *
                  sine_of_turns(gear->ripple_turn[i] + gear->ripple_hz[i] * braked_s);
    if (gear->bend_to_s > gear->bend_from_s)
        nominal += (gear->last_ft_s2 - gear->first_ft_s2) *
                   rise((braked_s - gear->bend_from_s) / (gear->bend_to_s - gear->bend_from_s));
    return rise(braked_s / ONSET_S) * nominal * ripple;
}

/* From a node over `over_s` (at most a few ms): dv = -integral a, dx = v over - integral (over - t)
 * a. */
static void coast(const struct syn_gear *gear, int node, double over_s, double *v_ft_s,
                  double *x_ft)
{
    double lost = 0.0;
    double moment = 0.0;

    for (int i = 0; i < POINTS; i++) {
        double a = deceleration(gear, node * NODE_S + gauss_at[i] * over_s);

        lost += gauss_weight[i] * a;
        moment += gauss_weight[i] * (1.0 - gauss_at[i]) * a;
    }
    *v_ft_s = gear->node_v_ft_s[node] - lost * over_s;
    *x_ft = gear->node_x_ft[node] + gear->node_v_ft_s[node] * over_s - moment * over_s * over_s;
}

bool syn_gear_brake(struct syn_gear *gear)
{
    int node = 0;
    double low = 0.0, high = NODE_S;

    gear->node_v_ft_s[0] = gear->speed_ft_s;
    gear->node_x_ft[0] = gear->touchdown_ft;
    while (node < SYN_GEAR_NODES) {
        double v, x;

        coast(gear, node, NODE_S, &v, &x);
        if (v <= 0.0)
            break;
        node++;
        gear->node_v_ft_s[node] = v;
        gear->node_x_ft[node] = x;
    }
    if (node == SYN_GEAR_NODES)
        return false;
    gear->nodes = node;
    for (int i = 0; i < SPLIT_STEPS; i++) {
        double middle = 0.5 * (low + high);
        double v, x;

        coast(gear, node, middle, &v, &x);
        if (v > 0.0)
            low = middle;
        else
            high = middle;
        gear->stop_ft = x;
    }
    gear->stop_s = gear->touchdown_s + node * NODE_S + low;
    return true;
}

struct syn_gear_motion syn_gear_at(const struct syn_gear *gear, double t_s)
{
    struct syn_gear_motion motion = {0.0, 0.0, 0.0};
    double braked_s = t_s - gear->touchdown_s;

    if (braked_s <= 0.0) {
        motion.x_ft = gear->touchdown_ft + gear->speed_ft_s * braked_s;
        motion.v_ft_s = gear->speed_ft_s;
    } else if (t_s >= gear->stop_s) {
        motion.x_ft = gear->stop_ft;
    } else {
        int node = (int)floor(braked_s / NODE_S);

        if (node > gear->nodes)
            node = gear->nodes;
        coast(gear, node, braked_s - node * NODE_S, &motion.v_ft_s, &motion.x_ft);
        motion.a_ft_s2 = deceleration(gear, braked_s);
    }
    return motion;
}

bool syn_gear_crosses(const struct syn_gear *gear, double station_ft, double *t_s)
{
    double low, high;

    if (station_ft <= gear->touchdown_ft) {
        *t_s = gear->touchdown_s - (gear->touchdown_ft - station_ft) / gear->speed_ft_s;
        return true;
    }
    if (station_ft > gear->stop_ft)
        return false;
    low = gear->touchdown_s;
    high = gear->stop_s;
    for (int i = 0; i < SPLIT_STEPS; i++) {
        double middle = 0.5 * (low + high);

        if (syn_gear_at(gear, middle).x_ft < station_ft)
            low = middle;
        else
            high = middle;
    }
    *t_s = 0.5 * (low + high);
    return true;
}
