/* Record: what one pass of a solver leaves behind: u of every mat at set times, and samples at
 * stations.
 *
 * The set times are 64 even ones to the end (for comparing passes) and the scene's t_out. The
 * solver reports each step as it ends; between steps u is taken as linear, which is how the fixed
 * step moves. Units ft, s. */
#ifndef MATRIG_HOST_SIM_SOLVERS_RECORD_H
#define MATRIG_HOST_SIM_SOLVERS_RECORD_H

#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

struct sim_snapshot {
    double t_s;
    int output;   /* index among the scene's t_out, or -1 */
    double *u_ft; /* mats + 1 values by mat */
    double lift_ft;
    int lift_node;
};

struct sim_record {
    int mats;
    double end_s;
    struct sim_snapshot *snapshots; /* in order of time */
    size_t snapshot_count;
    double *storage;
    int *station_mat;
    size_t station_count;
    double *sample_u_ft;
    double *sample_y_ft; /* NULL in model chain */
    size_t sample_count;
    double sample_dt_s;
    size_t next_snapshot;
    size_t next_sample;
    double next_s; /* the earliest time still wanted; INFINITY when none is */
    /* by mat: of its left end, up; set by the solver of a planar model like the lift */
    const double *height_ft;
    double lift_ft; /* set by the solver before it calls sim_record_take; 0 and node 1 else */
    int lift_node;
};

void sim_record_make(struct sim_record *record, const struct sim_scene *scene,
                     const struct sim_options *options);

/* Take everything wanted up to t_s, where the mats are at u, having moved at v. Cheap when next_s
 * is later: test it first. */
void sim_record_take(struct sim_record *record, double t_s, const double *u_ft,
                     const double *v_ft_s);

/* Largest difference between two complete records of the same scene, and where. */
struct sim_difference {
    double u_ft;
    int mat;
    double t_s;
};
struct sim_difference sim_record_difference(const struct sim_record *a, const struct sim_record *b);

/* Largest difference of the lift between the same. */
double sim_record_lift_difference(const struct sim_record *a, const struct sim_record *b);

/* Largest |u| of a complete record, and where. */
struct sim_difference sim_record_peak(const struct sim_record *record);

/* Hand outputs and samples over to a result, which owns them from then on. */
void sim_record_deliver(struct sim_record *record, struct sim_result *result);

void sim_record_free(struct sim_record *record);

#endif
