/* Planar engine: the state of landing.h's solver and what a step does to it (which mats slide and
 * which rise, tensions, speeds, the gear), and one run. landing.c has the runs and their error.
 * Mats, nodes and joints count from 0 as in model.h. */
#ifndef MATRIG_HOST_SIM_SOLVERS_PLANAR_ENGINE_H
#define MATRIG_HOST_SIM_SOLVERS_PLANAR_ENGINE_H

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
    double *gap0_ft, *grit_lb, *give_ft, *reach_ft; /* per joint; elements/law.h */
    double *tilt_ft, *rest_cos; /* per mat on uneven ground: model.h, and the cosine of its tilt */
    /* what modifications and the gear press nodes down with and bend joints by; NULL: nothing */
    double *brace_lb, *brace_lb_ft;
    void (*brace_heaves)(struct planar_engine *l); /* puts it there; NULL: nothing */
    double *push_lb, *pull_lb, *rise_ft;           /* per joint and node: most so far */
    /* a step in parts, as a node lands in it: what mats rub with, in it and in the next one */
    bool in_parts;
    double *rub_lb, *rub_next_lb; /* per node, from rub_first to rub_last */
    int rub_first, rub_last;
    double rub_share;   /* of that in the next step, which rub_next_lb does not have; else 1 */
    double last_step_s; /* what of it a joint was closed for its damper acts for; 0: all of it */
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
 * left out. Whatever becomes of it, engine_free releases it. */
enum mr_status engine_make(struct planar_engine *l, const struct sim_scene *scene,
                           struct sim_result *result, struct error *error);
void engine_free(struct planar_engine *l);

/* What the modifications see of a landing. */
static inline struct mods_view engine_view(const struct planar_engine *l)
{
    return (struct mods_view){l->z, l->z + l->model.size, 2, -1, l->tension_lb, 1};
}

/* One run over the whole landing; the record is made before. */
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

/* March through the whole landing with march->steps steps; the record is made. */
void engine_march(struct planar_engine *l, struct march *march, const struct sim_options *options);

#endif
