/* One drawn board on the emulated rig: its 24 switches open one after the other, its zeros are
 * measured by command, then each transducer and gage is taken through known values, as a
 * calibration does, and through others in between, at which the calibration is judged.
 *
 * The board runs the firmware's image; what is taken is what it says on its serial line. The
 * straight line is matrig calibrate's own (host/calibrate/fit.h). */
#ifndef MATRIG_TESTS_ELECTRONICS_BOARDS_H
#define MATRIG_TESTS_ELECTRONICS_BOARDS_H

#include <stdbool.h>
#include <stdint.h>

#include "common/config.h"
#include "hil/rig/electronics.h"

#define BOARDS_ELF "build/firmware/matrig.elf"

struct board_channel {
    double zero;       /* in or lb: what it reads at 0 as configured */
    double span_rel;   /* its gain as configured, less 1 */
    double zeroed;     /* what it reads at 0 once the zero was measured by command */
    double left_zero;  /* calibrated: what it reads at 0 */
    double left_span;  /* calibrated: its gain between known values, less 1 */
    double left_worst; /* calibrated: largest error at the values in between */
    bool valid;        /* at every value */
};

struct board_outcome {
    unsigned named, unnamed, misnamed;  /* of 24 switches */
    float step_codes[HIL_RUN_SWITCHES]; /* as told; NaN: no edge */
    uint8_t position[HIL_RUN_SWITCHES]; /* the name each was given; 0: none */
    bool zero_taken;                    /* the command zero was answered with ok */
    struct board_channel channel[HIL_RUN_COLUMNS];
    struct hil_electronics electronics;
    char trouble[160]; /* empty: the run went to its end */
};

struct board_request {
    uint64_t seed;
    double vdda_v;
    const struct hil_figures *figures; /* NULL: the reference circuits' */
    bool only_switches;
    unsigned stays_closed; /* a switch that does not open, 1 to 24; 0: all open */
};

void board_play(const struct board_request *request, struct board_outcome *outcome);

/* 3.24 to 3.36 V, evenly, by seed. */
double board_vdda_v(uint64_t seed);

#endif
