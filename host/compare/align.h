/* Alignment on switch edges: which time of a simulation belongs to a measured time. Pure.
 *
 * At each named edge the wheel is at a known station; the simulated wheel, on its path, comes to
 * that station at some time. Between two edges both times are joined by a straight line, outside
 * them they differ by what they differ at the nearest one. A simulation along the measured motion
 * needs almost none of it; one with a motion of its own is brought to the same wheel position.
 * Times in seconds since touchdown. */
#ifndef MATRIG_HOST_COMPARE_ALIGN_H
#define MATRIG_HOST_COMPARE_ALIGN_H

#include "host/analyse/track.h"
#include "host/sim/scene/scene.h"

struct compare_alignment {
    size_t edges;
    double measured_s[MR_GATES_MAX], simulated_s[MR_GATES_MAX];
    double offset_s;  /* median of simulated - measured */
    double scatter_s; /* rms of the rest, before alignment */
};

/* MR_TOO_FEW: fewer than two edges that both wheels passed. */
enum mr_status compare_align(const struct measured *measured, const struct sim_scene *scene,
                             struct compare_alignment *alignment, struct error *error);
double compare_simulated_time(const struct compare_alignment *alignment, double t_s);

/* How well the measured wheel's times are known: the error of its station (host/analyse/track.h)
 * over its speed, at most that of the stop. This is what the timing of edges and the places of
 * switches leave uncertain when two movements are laid over each other. */
#define COMPARE_CLOCK_POINTS 512
struct compare_clock {
    double stop_s, stop_error_s;
    double error_s[COMPARE_CLOCK_POINTS + 1]; /* evenly from touchdown to the stop */
};
void compare_clock_make(const struct measured *measured, struct compare_clock *clock);
double compare_time_error(const struct compare_clock *clock, double t_s);

#endif
