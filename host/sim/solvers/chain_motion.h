/* Motion of a chain for the solver in chain_event.h: the state, the power series of a step,
 * switches (changes of mode), and the forces of the wheel.
 *
 * A step calls motion_set_wheel_thrust, motion_expand_series (the series of u of mats first..last),
 * motion_longest_step_s for its length, motion_first_event within it, motion_evaluate at its end,
 * then motion_apply_switch, or motion_set_wheel_action at a break of the wheel. Mats 1..N with the
 * ground at 0 and N+1, joints 1..N+1. Units are ft, lb, s and slug. One owner, one thread:
 * motion_make allocates, motion_free releases; the scene must outlive it. */
#ifndef MATRIG_HOST_SIM_SOLVERS_CHAIN_MOTION_H
#define MATRIG_HOST_SIM_SOLVERS_CHAIN_MOTION_H

#include "host/sim/elements/wheel.h"
#include "host/sim/solvers/polynomial.h"

/* Present mode of a joint, which determines its force and its next switch. README.md, "Joint
 * force"; law.h describes the grit. */
enum joint_mode {
    JOINT_ABSENT,  /* a joint that does not exist, at a free end of the runway */
    JOINT_ELASTIC, /* a joint without slack */
    JOINT_OPEN,    /* without grit: neither closed nor hooked */
    JOINT_PRESSED,
    JOINT_HOOKED,
    /* with grit: open and opening further, so the reach of the grit increases */
    JOINT_GRIT_OPENING,
    JOINT_GRIT_HOLDS, /* the grit holds the joint */
    /* the grit holds the joint, but the force is 0, because the damper would make it a tension */
    JOINT_GRIT_FORCELESS,
    /* the grit holds the joint, but spring and damper together are at the largest force that the
     * grit transmits */
    JOINT_GRIT_AT_LIMIT,
    JOINT_GRIT_YIELDS, /* the grit yields, so its reach decreases */
};

enum ground_mode { GROUND_LOADING, GROUND_UNLOADING, GROUND_YIELDING, GROUND_FRICTIONLESS };

/* The forces of the wheel on one mat, from the last break on. */
struct mat_load {
    int mat;
    double thrust_lb[3];  /* thrust and its first two derivatives: lb, lb/s, lb/s2 */
    double load_share[2]; /* share of an axle's load, and its rate of change */
    double axle_count;    /* number of axles that are on the mat */
    /* Ground under the gear (gear.h): stiffness and damping for this mat, force on the mat, and
     * mode. */
    double k_lb_ft, ground_force_lb, slope_lb_ft;
    int force_sign; /* sign of ground_force_lb */
    enum ground_mode mode;
};

struct motion {
    const struct sim_scene *scene;
    int mats;
    double tanh_rate; /* rate of the friction law tanh at speed 0, 1/s */
    double max_rate;  /* fastest rate of the chain while all joints transmit force, 1/s */
    double inverse_mass, kl_lb_ft, cl_lb_s_ft, slack_ft, ground_damping_lb_s_ft, weight_friction_lb,
        load_friction_lb;
    enum sim_friction friction_law; /* friction law: stick, tanh or none */
    void *storage;
    size_t array_length; /* length of each array */
    /* For each mat: power series of u (c[0] ft, c[1] ft/s, ...), of the thrust, and of tanh. */
    double *u_terms[POLYNOMIAL_DEGREE_MAX + 1], *thrust_terms[3],
        *tanh_terms[POLYNOMIAL_DEGREE_MAX], *tanh_square_terms[POLYNOMIAL_DEGREE_MAX];
    double *moving_inverse_mass; /* 1/mass of a moving mat, otherwise 0 */
    double *limit_lb, *friction_force_lb, *drag_lb_s_ft;
    double *speed_change_max; /* largest possible change of the speed within a step */
    /* For each joint: power series of the tension, which is a g + b g' + c (g: opening, g': its
     * rate). */
    double *tension_terms[POLYNOMIAL_DEGREE_MAX], *tension_a, *tension_b, *tension_c_lb;
    double *gap0_ft, *grit_lb, *grit_extent_ft, *max_compression_lb, *max_tension_lb;
    double *opening_change_max,
        *tension_change_max; /* largest possible changes of opening and tension within a step */
    double *sampled_u_ft, *sum, *slope;
    /* Direction of sliding. 0: at rest. 2: the friction law is none or tanh. SLIDE_ON_GROUND: on
     * elastic ground. */
    signed char *slide_direction;
    unsigned char *joint_mode;
    int moving_low, moving_high;   /* outermost mats that move; low > high: no mat moves */
    int changed_low, changed_high; /* range of mats whose thrust or limit has changed */
    struct sim_wheel wheel;
    /* Times at which the forces of the wheel change, ascending. The last one is the end of the
     * run. */
    double *break_times_s;
    size_t break_count, next_break;
    double last_break_s; /* time of the last break */
    struct mat_load loads[SIM_TOUCH_MAX];
    int load_count;
    bool has_gear; /* true: the gear is on elastic ground */
    double recovered_share;
    double t_s;
    double max_speed_ft_s;
};

/* The first switch within a step. */
struct event {
    double h_s;
    int mat, joint; /* number of the mat or of the joint; the other one is 0; both 0: no switch */
    /* number of the condition that failed, for the mode of the joint or of the elastic ground */
    int condition;
};

void motion_make(struct motion *m, const struct sim_scene *scene);
void motion_free(struct motion *m);
/* Sets the motion to the start of the scene. */
void motion_start(struct motion *m);

/* Sets the thrust of the wheel from the present time on. */
void motion_set_wheel_thrust(struct motion *m);
/* Sets the forces of the wheel from the present time to the next break. */
void motion_set_wheel_action(struct motion *m);

/* Computes the series of u of mats first..last and of their joints' tensions, up to the term
 * `order`. */
void motion_expand_series(const struct motion *m, int first, int last, int order);
/* Longest step for which the omitted terms are within `tolerance` of the speed. */
double motion_longest_step_s(const struct motion *m, int first, int last, int order,
                             double tolerance);
/* Finds the first switch within wide_s. If there is none, h_s is wide_s. Also sets
 * tension_change_max to the possible change of the tensions within wide_s. */
struct event motion_first_event(struct motion *m, int first, int last, int order, double wide_s);
/* Computes u and, unless `v` is NULL, v of mats first..last at time h of the step. */
void motion_evaluate(const struct motion *m, int first, int last, int order, double h, double *u,
                     double *v);
void motion_apply_switch(struct motion *m, const struct event *event);

double motion_opening_ft(const struct motion *m, int joint);
double motion_ground_limit_lb(const struct motion *m, const struct mat_load *part);
double motion_largest_value(const double *values, int first, int last);

#endif
