/* Motion: a chain in motion, as chain_event.h solves it: state, series of a step, switches, wheel.
 *
 * A step calls motion_place_wheel, motion_expand (the series of u of mats first..last),
 * motion_longest_s for its length, motion_first_event within it, motion_evaluate at its end, then
 * motion_switch, or motion_press at a break of the wheel. Mats 1..N with the ground at 0 and N+1,
 * joints 1..N+1. Units are ft, lb, s and slug. One owner, one thread: motion_make allocates,
 * motion_free releases; the scene must outlive it. */
#ifndef MATRIG_HOST_SIM_SOLVERS_CHAIN_MOTION_H
#define MATRIG_HOST_SIM_SOLVERS_CHAIN_MOTION_H

#include "host/sim/elements/wheel.h"
#include "host/sim/solvers/polynomial.h"

/* Present mode of a joint, which determines its force and its next switch. README.md, "Joint
 * force"; law.h describes the grit. */
enum mode {
    CUT,     /* cut joint: a free end */
    ELASTIC, /* no slack */
    OPEN,    /* without grit, between closed and hooked */
    PRESSED,
    HOOKED,
    FREED,  /* with grit, open and opening: its reach follows */
    HELD,   /* held by its grit */
    LOOSE,  /* held, but with the damper it would pull */
    FULL,   /* held, and with the damper at the largest force that grit transmits */
    YIELDS, /* the grit yields: its reach follows */
};

enum part_mode { LOADS, UNLOADS, GIVES, RIDES };

/* The wheel's action on one mat from `from_s` on. */
struct part {
    int mat;
    double thrust_lb[3]; /* thrust and its rates: lb, lb/s, lb/s2 */
    double load[2];      /* share of an axle's load, and its rate */
    double touching;     /* number of axles that touch the mat */
    /* Gear on elastic ground (gear.h): stiffness and damping of the mat, its ground force, and the
     * mode. */
    double k_lb_ft, ground_force_lb, rate_lb_ft;
    int side; /* sign of ground_force_lb */
    enum part_mode mode;
};

struct motion {
    const struct sim_scene *scene;
    int mats;
    double tanh_rate; /* rate of the law tanh at rest, 1/s */
    double rate;      /* fastest rate of a chain in which all joints transmit, 1/s */
    double per_slug, kl, cl, slack_ft, ground_lb_s_ft, weight_friction_lb, load_friction_lb;
    enum sim_friction friction; /* friction law: stick, tanh or none */
    void *storage;
    size_t length; /* length of each array */
    /* By mat: series of u (c[0] ft, c[1] ft/s, ...), of thrust, of tanh. */
    double *c[POLYNOMIAL_DEGREE + 1], *thrust[3], *smooth[POLYNOMIAL_DEGREE],
        *square[POLYNOMIAL_DEGREE];
    double *free_per_slug; /* 1/mass of a moving mat, otherwise 0 */
    double *limit_lb, *friction_force_lb, *drag_lb_s_ft;
    double *reach_v; /* possible change of the speed within a step */
    /* By joint: series of tension; tension = a g + b g' + at. */
    double *pull[POLYNOMIAL_DEGREE], *a, *b, *at_lb;
    double *gap0_ft, *grit_lb, *reach_ft, *push_most_lb, *pull_most_lb;
    double *reach_g, *reach_t; /* possible changes of opening and tension within a step */
    double *u_at, *sum, *slope;
    /* Direction of sliding; 0: at rest; 2: without Coulomb's law (none, tanh); RIDDEN: elastic
     * ground. */
    signed char *slide;
    unsigned char *mode;
    int low, high;                 /* outermost moving mats; low > high: no mat moves */
    int changed_low, changed_high; /* mats whose thrust or limit has changed */
    struct sim_wheel wheel;
    /* Times at which the wheel's parts change, in order; the last one is the end. */
    double *breaks_s;
    size_t breaks, next_break;
    double from_s; /* time of the last break */
    struct part parts[SIM_TOUCH_MAX];
    int part_count;
    bool gear; /* the gear is on elastic ground */
    double rho;
    double t_s;
    double max_speed_ft_s;
};

/* The first switch within a step. */
struct event {
    double h_s;
    int mat, joint; /* one of them is set; 0: none */
    /* number of the condition that was met, of the joint's mode or of the elastic ground */
    int which;
};

void motion_make(struct motion *m, const struct sim_scene *scene);
void motion_free(struct motion *m);
/* Returns to t = 0. */
void motion_start(struct motion *m);

/* Applies the thrust from the present time on. */
void motion_place_wheel(struct motion *m);
/* Determines the wheel's parts from the present time to the next break. */
void motion_press(struct motion *m);

/* Computes the series of u and of the tensions for mats first..last, to this order. */
void motion_expand(const struct motion *m, int first, int last, int order);
/* Longest step for which the truncated share of the speed is within `tolerance`. */
double motion_longest_s(const struct motion *m, int first, int last, int order, double tolerance);
/* Finds the first switch; h_s is wide_s if there is none. Leaves in reach_t the possible change of
 * the tensions within wide_s. */
struct event motion_first_event(struct motion *m, int first, int last, int order, double wide_s);
/* Evaluates u and, unless `v` is NULL, v of mats first..last after h. */
void motion_evaluate(const struct motion *m, int first, int last, int order, double h, double *u,
                     double *v);
void motion_switch(struct motion *m, const struct event *event);

double motion_opening_ft(const struct motion *m, int joint);
double motion_part_limit_lb(const struct motion *m, const struct part *part);
double motion_largest(const double *values, int first, int last);

#endif
