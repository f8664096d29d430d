/* The pictures of a landing, and the one of a campaign. Each writes one <svg>. */
#ifndef MATRIG_HOST_REPORT_PLOTS_H
#define MATRIG_HOST_REPORT_PLOTS_H

#include <stdio.h>

#include "host/analyse/summary.h"

/* What a landing's section is drawn from. */
struct report_landing {
    struct summary summary;
    struct zones_closure survey;
    struct store_motion *motion;
    size_t motions;
    struct store_simulation *simulation; /* of the newest comparison */
    size_t simulations;
    struct store_simulation_head head; /* of the same */
};

/* Speed against time: the fit with its 95 % band, what the board said as it went, and the mean between
 * switches. */
void plot_speed(FILE *out, const struct report_landing *landing, bool si);
/* Eight small plots of displacement against gear position, measured and simulated. */
void plot_displacements(FILE *out, const struct report_landing *landing, bool si);
/* Tension against time, a small plot for each station, one line per band. */
void plot_tensions(FILE *out, const struct report_landing *landing, bool si);
/* Stations across, time upwards: closed segments, the wheel's track, the zone warned of, the transducers. */
void plot_zones(FILE *out, const struct report_landing *landing, bool si);
/* Peak movement against station, a line per landing. */
void plot_campaign(FILE *out, const struct report_landing *landings, size_t count, bool si);
/* Rows of the slow log: movement of each transducer since the first of them, mean tension, temperature, against hours. False: fewer than two
 * rows of one board whose time, or boot, is known; nothing was drawn. */
bool plot_slow(FILE *out, const struct store_slow *rows, size_t count, bool si);

#endif
