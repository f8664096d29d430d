/* Motion: a chain in motion, as chain_event.h solves it: state, series of a step, switches, wheel.
 *
 * A step goes: motion_touch, motion_expand (the series of u of mats first..last), a length from
 * motion_longest_s, motion_first_event within it, motion_evaluate at its end, then motion_switch,
 * or motion_press at a break of the wheel. Mats 1..N with the ground at 0 and N+1, joints 1..N+1.
 * Units ft, lb, s, slug. One owner, one thread: motion_make allocates, motion_free releases; the
 * scene must outlive it. */
#ifndef MATRIG_HOST_SIM_SOLVERS_CHAIN_MOTION_H
#define MATRIG_HOST_SIM_SOLVERS_CHAIN_MOTION_H

#include "host/sim/elements/wheel.h"
#include "host/sim/solvers/polynomial.h"

/* A joint's law at present: what it pulls, and what ends that. README.md, "Joint force", and law.h
 * for the dirt (`grit`). */
enum mode {
    CUT,     /* a free end */
    ELASTIC, /* no slack */
    OPEN,    /* without dirt, between closed and hooked */
    PRESSED,
    HOOKED,
    FREED,  /* open with dirt, and opening: its reach follows */
    HELD,   /* by its dirt */
    LOOSE,  /* held, but the damper would pull */
    FULL,   /* held, and the damper makes it the most that dirt transmits */
    YIELDS, /* dirt gives way: its reach follows */
};

enum part_mode { LOADS, UNLOADS, GIVES, RIDES };

/* What the wheel does to one mat from `from_s` on. */
struct part {
    int mat;
    double thrust_lb[3]; /* and its rates: lb, lb/s, lb/s2 */
    double load[2];      /* shares of an axle's load, and their rate */
    double touching;     /* axles */
    /* gear on elastic ground (gear.h): stiffness and damping of the mat, what it holds, and how */
    double k_lb_ft, hold_lb, rate_lb_ft;
    int side; /* of hold_lb */
    enum part_mode mode;
};

struct motion {
    const struct sim_scene *scene;
    int mats;
    double bend_rate; /* of the law tanh at rest, 1/s */
    double rate;      /* fastest of a chain that transmits throughout, 1/s */
    double per_slug, kl, cl, slack_ft, ground_lb_s_ft, weight_limit_lb, load_limit_lb;
    enum sim_friction friction; /* stick, tanh or none */
    void *storage;
    size_t length; /* of one array */
    /* by mat; series of u: c[0] ft, c[1] ft/s, ... ; of thrust; of tanh */
    double *c[POLYNOMIAL_DEGREE + 1], *thrust[3], *smooth[POLYNOMIAL_DEGREE],
        *square[POLYNOMIAL_DEGREE];
    double *free_per_slug; /* 1/mass of a mat that moves, else 0 */
    double *limit_lb, *rub_lb, *drag_lb_s_ft;
    double *reach_v; /* how far the speed can get within a step */
    /* by joint; series of tension; tension = a g + b g' + at */
    double *pull[POLYNOMIAL_DEGREE], *a, *b, *at_lb;
    double *gap0_ft, *grit_lb, *reach_ft, *push_most_lb, *pull_most_lb;
    double *reach_g, *reach_t; /* how far opening and tension can get within a step */
    double *u_at, *sum, *slope;
    /* way a mat slides; 0 at rest; 2 without Coulomb's law (none, tanh); RIDDEN: elastic ground */
    signed char *slide;
    unsigned char *mode;
    int low, high;           /* outermost mats that move; low > high: none */
    int near_low, near_high; /* mats whose thrust or limit has changed */
    struct sim_wheel wheel;
    /* times at which the wheel's parts are other ones, in order; the end is last */
    double *breaks_s;
    size_t breaks, next_break;
    double from_s; /* the last of them */
    struct part parts[SIM_TOUCH_MAX];
    int part_count;
    bool gear; /* on elastic ground */
    double rho;
    double t_s;
    double most_v_ft_s;
};

/* The first switch within a step. */
struct event {
    double h_s;
    int mat, joint; /* one of them; 0: none */
    int which;      /* of a joint's ends */
};

void motion_make(struct motion *m, const struct sim_scene *scene);
void motion_free(struct motion *m);
/* Back to t = 0. */
void motion_start(struct motion *m);

/* Thrust from the present time on. */
void motion_touch(struct motion *m);
/* The wheel's parts from the present time to the next break. */
void motion_press(struct motion *m);

/* Series of u and of the tensions of mats first..last, to this order. */
void motion_expand(const struct motion *m, int first, int last, int order);
/* How long a step may be, in which this share of the speed is cut off. */
double motion_longest_s(const struct motion *m, int first, int last, int order, double tolerance);
/* h_s is wide_s when there is none; leaves in reach_t how far tensions can get in wide_s. */
struct event motion_first_event(struct motion *m, int first, int last, int order, double wide_s);
/* u and, unless NULL, v of mats first..last after h. */
void motion_evaluate(const struct motion *m, int first, int last, int order, double h, double *u,
                     double *v);
void motion_switch(struct motion *m, const struct event *event);

double motion_opening_ft(const struct motion *m, int joint);
double motion_part_limit_lb(const struct motion *m, const struct part *part);
double motion_largest(const double *values, int first, int last);

#endif
