/* Figures 3.6 to 3.12 of the 1973 report, redrawn from host/scenes as its text describes them. */
#ifndef MATRIG_TESTS_FIGURES_FIGURES_H
#define MATRIG_TESTS_FIGURES_FIGURES_H

#include <stdbool.h>
#include <stdio.h>

#include "host/base/error.h"

#define FIGURE_NODES 256
#define FIGURE_TIMES 4

/* A scene run once: profiles at its t_out. Nodes and mats from 1. */
struct run {
    const char *scene; /* file name without folder and .json */
    int mats;
    double length_ft;
    double max_lift_ft;
    bool bow_wave;
    double error_u_ft, error_lift_ft;
    int times;
    struct profile {
        double t_s, wheel_ft;
        double x_ft[FIGURE_NODES], height_ft[FIGURE_NODES];  /* by node */
        double station_ft[FIGURE_NODES], u_ft[FIGURE_NODES]; /* by mat: its centre */
        double lift_ft;
    } at[FIGURE_TIMES];
};

/* Runs a scene of host/scenes; a run that is not `ok` is an error. */
enum mr_status run_scene(struct run *run, const char *scene, struct error *error);

/* Each figure to FOLDER/fig3_N.svg, and all of them with the table to FOLDER/figures.html. */
enum mr_status draw_figures(const char *folder, struct error *error);

/* One row of the table: what the text says, what comes out here. */
struct row {
    const char *figure;
    const char *text; /* quantity and what the report's text says of it */
    const char *scene;
    enum { DISPLACEMENT, LIFT_THEN, LARGEST_LIFT, VERDICT } quantity;
    int mat;       /* of a displacement */
    int time;      /* which t_out, from 0 */
    double stated; /* ft; for a verdict 1 bow, 0 none; NaN: only words */
    double within; /* share of `stated` that is agreement; 0: not held to it, see note */
    const char *note;
};
extern const struct row rows[];
extern const size_t row_count;

/* Our value of a row. */
double row_value(const struct row *row, const struct run *run);

#endif
