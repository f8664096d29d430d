/* Planar engine: the state of landing.h's solver and what a step does to it: which mats slide and
 * which rise, tensions, speeds, the gear. landing.c has the steps of one run, and the runs. Mats,
 * nodes and joints count from 0 as in model.h. */
#ifndef MATRIG_HOST_SIM_SOLVERS_LANDING_ENGINE_H
#define MATRIG_HOST_SIM_SOLVERS_LANDING_ENGINE_H

#include "host/sim/elements/gear.h"
#include "host/sim/elements/law.h"
#include "host/sim/elements/mods.h"
#include "host/sim/models/model.h"
#include "host/sim/scene/result.h"
#include "host/sim/elements/wheel.h"

/* Mats first..last, from 0; empty when last < first. */
struct part {
    int first, last;
    int quiet_first, quiet_last; /* steps that its ends have been at rest */
};

struct planar_engine {
    struct model model; /* its window is the part that heaves */
    const struct sim_scene *scene;
    size_t stored; /* values from z on: all that a march leaves in this */
    double *z;     /* every mat's, all the time */
    double *accel, *u, *v, *height;
    double *gap0_ft, *hold_lb, *give_ft, *reach_ft; /* per joint; elements/law.h */
    double *tilt_ft, *rest_cos; /* per mat on uneven ground: model.h, and the cosine of its tilt */
    /* what modifications and the gear press nodes down with and bend joints by; NULL: nothing */
    double *brace_lb, *brace_lb_ft;
    void (*brace_heaves)(struct planar_engine *l); /* puts it there; NULL: nothing */
    double *push_lb, *pull_lb, *rise_ft;           /* per joint and node: most so far */
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
    struct part slides; /* mats that move along the runway, and one at rest on either side */
    struct part heaves; /* mats whose nodes are not at rest */
    struct mods *mods;  /* NULL when the scene has none */
    struct gear *gear;  /* likewise */
};

/* One strip, ready to march; the landing is all zero before. The result, if any, is told what is
 * left out. Whatever becomes of it, landing_free releases it. */
enum mr_status engine_make(struct planar_engine *l, const struct sim_scene *scene,
                           struct sim_result *result, struct error *error);
void engine_free(struct planar_engine *l);

/* What the modifications see of a landing. */
static inline struct mods_view engine_view(const struct planar_engine *l)
{
    return (struct mods_view){l->z, l->z + l->model.size, 2, -1, l->tension_lb, 1};
}

/* Make a part reach from mat `low` to mat `high`. */
void engine_take_in(struct part *part, const struct model *m, int low, int high);
/* The parts before a step: what the wheel touches and what moves is taken in, what has come to rest
 * is left behind. */
void engine_follow_slides(struct planar_engine *l, const struct sim_touch *touch, int count);
void engine_follow_heaves(struct planar_engine *l);
/* Turning pulls at the joints of profile `full`, and heaving changes the soil's hold on the
 * mats. */
void engine_slide_what_heaves(struct planar_engine *l);
bool engine_mat_rests(const struct planar_engine *l, int n);

/* Tensions of all joints of the sliding part, and the most that each has had. */
void engine_stretch_joints(struct planar_engine *l);

/* What modifications do along the runway in a step, before its kicks. */
void engine_brace_slides(struct planar_engine *l, const struct sim_touch *touch, int count,
                         double h_s);

/* What the wheel, or the gear, does over t0..t1; what a gear loads heaves from now on. */
int engine_span(struct planar_engine *l, struct sim_wheel *wheel, double t0_s, double t1_s,
                struct sim_touch *touch);
/* Speeds over a step of h_s; heaves before slides, whose friction is of the soil's reactions in
 * that step. The first returns the largest change of a node's speed by the soil, the second how
 * many mats came to rest within the step. */
double engine_kick_heaves(struct planar_engine *l, double h_s);
double engine_soil_lb(const struct model *m, const double *z, int node);
unsigned engine_kick_slides(struct planar_engine *l, const struct sim_touch *touch, int count,
                            double h_s);

#endif
