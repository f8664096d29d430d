/* Planar engine: state and step of one run of the solver in landing.h (which mats slide and which
 * heave, tensions, speeds, gear). landing.c compares several runs and estimates their error. Mats,
 * nodes and joints are counted from 0, as in model.h. */
#ifndef MATRIG_HOST_SIM_SOLVERS_PLANAR_ENGINE_H
#define MATRIG_HOST_SIM_SOLVERS_PLANAR_ENGINE_H

#include "host/sim/elements/gear.h"
#include "host/sim/elements/law.h"
#include "host/sim/elements/mods.h"
#include "host/sim/models/model.h"
#include "host/sim/scene/result.h"
#include "host/sim/elements/wheel.h"

/* A range of mats first..last, from 0; empty if last < first. */
struct moving_part {
    int first, last;
    /* number of steps for which the outermost mats at each end have been at rest */
    int first_rest_steps, last_rest_steps;
};

struct planar_engine {
    struct model model; /* the model, whose window (range of integrated mats) is the heaving part */
    const struct sim_scene *scene;
    /* number of values, counted from `z`, that a march changes */
    size_t stored_value_count;
    double *z; /* state of every mat, at all times */
    double *accel, *u, *v, *height;
    /* for each joint: its properties; elements/law.h */
    double *gap0_ft, *grit_lb, *grit_yield_ft, *grit_extent_ft, *kl_lb_ft;
    /* Soil and depth at rest of each node; Coulomb limit and mass of each mat, hinge of each joint
     * (sim_scene_local_value). */
    double *kv_lb_ft, *cv_lb_s_ft, *rest_ft, *limit_lb, *kt_lb_ft_rad, *mass_slug, *mass_ratio;
    double *rest_tilt_ft;
    double *tilt_ft, *rest_cos; /* for each mat on uneven ground: tilt (model.h), and its cosine */
    /* Downward force on each node and moment on each joint, from modifications and gear; NULL:
     * none. */
    double *brace_force_lb, *brace_moment_lb_ft;
    /* function that computes brace_force_lb and brace_moment_lb_ft; NULL: neither is used */
    void (*brace_heaving_part)(struct planar_engine *l);
    double *max_compression_lb, *max_tension_lb,
        *max_rise_ft; /* for each joint and node: largest value so far */
    /* True: the step is divided into parts, because a node lands in it. The fields below then have
     * the normal forces for friction, in this step and in the next one. */
    bool is_step_divided;
    double *normal_lb,
        *next_normal_lb; /* normal forces of the nodes from normal_first to normal_last */
    int normal_first, normal_last;
    /* fraction of the next step's normal force that next_normal_lb does not contain; otherwise 1 */
    double next_normal_share;
    /* Duration of the last step, over which the damper of a joint that closes or opens is averaged.
     * 0: no averaging. */
    double last_step_s;
    /* Tension of each joint. A joint between mats at rest keeps the tension of the last step in
     * which one of them moved. */
    double *tension_lb;
    double slack_ft;
    enum joint_law joint_law;
    /* sliding part: mats that move along the runway, and one mat at rest on either side */
    struct moving_part sliding;
    struct moving_part heaving; /* heaving part: mats whose nodes are not at rest */
    struct mods *mods;          /* NULL: the scene has no modifications */
    struct gear *gear;          /* NULL: the scene has no gear on elastic ground */
};

/* Makes the engine of a scene. `l` must be zeroed. If `result` is given, adds the features that the
 * model omits to it. Call planar_engine_free in every case. */
enum mr_status planar_engine_make(struct planar_engine *l, const struct sim_scene *scene,
                                  struct sim_result *result, struct error *error);
void planar_engine_free(struct planar_engine *l);

/* Returns where the modifications find mats and joints in the engine's arrays. */
static inline struct mods_view planar_engine_view(const struct planar_engine *l)
{
    return (struct mods_view){l->z, l->z + l->model.coordinate_count, 2, -1, l->tension_lb, 1};
}

/* A march: one run over the whole landing with one step size. Its record must be made before. */
struct march {
    uint64_t step_count, completed_step_count, events;
    double h_s, ms;
    enum sim_status status;
    int mat;
    double t_s;
    double max_lift_ft;
    double impact_ft_s; /* largest change of a node's speed due to the soil in one step */
    double speed_end_ft_s;
    double crest_deg, sag_deg;
    int crest_joint, sag_joint;
    int wave_encounter_nodes[SIM_WAVE_ENCOUNTERS_MAX], wave_encounter_count;
    /* true: the wheel has been on a wave since the last entry of `wave_encounter_nodes` */
    bool was_wheel_on_wave;
    int first_crest_node, first_crest_wheel_mat;
    double active_mat_time_s;
    int active_mats_max;
    struct sim_record record;
    struct mods_state *mods; /* state of the modifications at the end of the march; NULL: none */
    int pass_number;         /* number of the march, an argument of may_continue */
};

/* Runs a march over the whole landing with march->steps steps. march->record must be made
 * before. */
void planar_engine_run(struct planar_engine *l, struct march *march,
                       const struct sim_options *options);

#endif
