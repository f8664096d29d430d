/* Landing engine: the state of landing.h's solver and what a step does to it. Private to
 * landing*.c.
 *
 * landing_parts.c follows which mats slide and which heave, landing_joints.c has tensions,
 * landing_kick.c the speeds' change in a step,
 * landing_parting.c ends of mats that came apart, landing_march.c the steps of one run and what is
 * noted on the way, landing_make.c their memory, landing.c the runs and what they are worth. Mats,
 * nodes and joints count from 0 as in model.h. */
#ifndef MATRIG_HOST_SIM_SOLVERS_LANDING_ENGINE_H
#define MATRIG_HOST_SIM_SOLVERS_LANDING_ENGINE_H

#include "host/sim/elements/gear.h"
#include "host/sim/elements/joint.h"
#include "host/sim/elements/mods.h"
#include "host/sim/models/model.h"
#include "host/sim/solvers/record.h"
#include "host/sim/elements/wheel.h"

/* Mats first..last, from 0; empty when last < first. */
struct part {
    int first, last;
    int quiet_first, quiet_last; /* steps that its ends have been at rest */
};

struct landing {
    struct model model; /* its window is the part that heaves */
    const struct sim_scene *scene;
    size_t stored; /* values from z on: all that a march leaves in this */
    double *z;     /* every mat's, all the time */
    double *accel, *u, *v, *height;
    double *gap0_ft, *hold_lb, *give_ft, *reach_ft; /* per joint; elements/joint.h */
    double *tilt_ft, *rest_cos; /* per mat on uneven ground: model.h, and the cosine of its tilt */
    /* what modifications and the gear press nodes down with and bend joints by; NULL: nothing */
    double *brace_lb, *brace_lb_ft;
    void (*brace_heaves)(struct landing *l); /* puts it there; NULL: nothing */
    double *push_lb, *pull_lb, *rise_ft;     /* per joint and node: most so far */
    /* a step in parts, as a node lands in it: what mats rub with, in it and in the next one */
    bool in_parts;
    double *rub_lb, *rub_next_lb; /* per node, from rub_first to rub_last */
    int rub_first, rub_last;
    double rub_share; /* of that in the next step, which rub_next_lb does not have; else 1 */
    double
        closing_step_s; /* joints that closed in the last step are damped for their share; or 0 */
    /* per joint; between mats at rest that of the last step in which one of them moved */
    double *tension_lb;
    double slack_ft;
    enum joint_law joints;
    struct part slides;      /* mats that move along the runway, and one at rest on either side */
    struct part heaves;      /* mats whose nodes are not at rest */
    struct mods *mods;       /* NULL when the scene has none */
    struct gear *gear;       /* likewise */
    struct parting *parting; /* likewise, with mods */
};

struct march {
    uint64_t steps, done, events;
    double h_s, ms;
    enum sim_status status;
    int mat;
    double t_s;
    double max_lift_ft;
    double jolt_ft_s; /* the soil's largest: what a node's speed has changed by in a step */
    double speed_end_ft_s;
    double crest_deg, sag_deg;
    int crest_joint, sag_joint;
    int overrun[SIM_OVERRUNS_MAX], overruns;
    bool on_wave; /* the wheel, since it met the last of them */
    int first_crest, first_crest_wheel;
    double awake_s;
    int mats_max;
    struct sim_record record;
    struct mods_state *mods; /* at its end; NULL without modifications */
    int number;              /* of this march, for go_on */
};

/* One strip, ready to march; the landing is all zero before. The result, if any, is told what is
 * left out. Whatever becomes of it, landing_free releases it. */
enum mr_status landing_make(struct landing *l, const struct sim_scene *scene,
                            struct sim_result *result, struct error *error);
void landing_free(struct landing *l);

/* What the modifications see of a landing. */
static inline struct mods_view landing_view(const struct landing *l)
{
    return (struct mods_view){l->z, l->z + l->model.size, 2, -1, l->tension_lb, 1};
}

/* Make a part reach from mat `low` to mat `high`. */
void landing_take_in(struct part *part, const struct model *m, int low, int high);
/* The parts before a step: what the wheel touches and what moves is taken in, what has come to rest
 * is left behind. */
void landing_follow_slides(struct landing *l, const struct sim_touch *touch, int count);
void landing_follow_heaves(struct landing *l);
/* Turning pulls at the joints of profile `full`, and heaving changes the soil's hold on the
 * mats. */
void landing_slide_what_heaves(struct landing *l);
bool landing_mat_rests(const struct landing *l, int n);

/* Tensions of all joints of the sliding part, and the most that each has had. */
void landing_stretch_joints(struct landing *l);

/* With parting: joints that come apart at t_s; the hinges of the heaving part; its ends' speeds
 * (returns the largest change by the soil) and heights over a step. */
void landing_part_joints(struct landing *l, double t_s);
void landing_shape_ends(struct landing *l);
double landing_kick_ends(struct landing *l, double h_s);
void landing_move_ends(struct landing *l, double h_s);
bool landing_settle_ends(struct landing *l, double h_s); /* as the soil's contacts */
double landing_worst_angle_deg(const struct landing *l, int *mat_from_1);
/* Mat n stands upright: if it has come apart from a neighbour it is pushed over and lies loose on
 * the ground. False: it has not. */
bool landing_topple(struct landing *l, int n, double t_s);
/* Loose mats that the brakes push get no faster than the aircraft. */
void landing_hold_back(struct landing *l, const struct sim_wheel *wheel,
                       const struct sim_touch *touch, int count);

/* Sine of mat n's angle. */
static inline double landing_slope(const struct landing *l, int n)
{
    const struct model *m = &l->model;
    return (parting_right_y_ft(l->parting, l->z, n) - l->z[2 * n] +
            (m->tilt_ft ? m->tilt_ft[n] : 0.0)) /
           m->length_ft;
}

/* What modifications do in a step, before its kicks: along the runway, and on nodes and joints of
 * the heaving part. */
void landing_brace_slides(struct landing *l, const struct sim_touch *touch, int count, double h_s);
void landing_brace_heaves(struct landing *l);

/* With gear (landing_gear.c): at the start of a run in steps of h_s; its spans are then the
 * wheel's, and what it loads is taken in. */
void landing_mount(struct landing *l, struct sim_wheel *wheel, double h_s);
/* The gear's weight on the nodes of the heaving part, beside what modifications do. */
void landing_load_heaves(struct landing *l);
/* Speeds over a step of h_s; heaves before slides, whose friction is of the soil's reactions in
 * that step. Slides say how many mats came to rest within the step. */
/* The largest change of a node's speed by the soil. */
double landing_kick_heaves(struct landing *l, double h_s);
double landing_soil_lb(const struct model *m, const double *z, int node);
unsigned landing_kick_slides(struct landing *l, const struct sim_touch *touch, int count,
                             double h_s);

/* March through the whole landing with march->steps steps; the record is made. */
void landing_march(struct landing *l, struct march *march, const struct sim_options *options);

#endif
