/* The film camera: the board sends a trigger pulse, and reports the time of the camera's pulse for
 * each frame.
 *
 * The trigger is a pulse of 10 ms. It is sent by command, when a landing is armed, or (once per
 * landing) when the last motion estimate puts the gear at site.camera_station_ft, depending on the
 * configuration. Frame pulses are reported while a landing is recorded, numbered from arming. A
 * camera sends 64 to 200 frame pulses per second. At 200 per second they take 2.4 % of the CAN bus,
 * 1.8 % of serial and 2.1 kB/s of the black box. With site.camera 0 nothing is captured, triggered
 * or sent. */
#ifndef MATRIG_FIRMWARE_CAMERA_H
#define MATRIG_FIRMWARE_CAMERA_H

#include "common/onboard/landing.h"
#include "common/status.h"
#include "firmware/pulses.h"
#include "firmware/telemetry.h"

#define CAMERA_PULSE_BLOCKS 10u

struct camera {
    /* the trigger at the station has been sent in this landing, or is not configured */
    bool is_station_trigger_done;
    /* cause of the trigger to be sent in the next block (enum mr_camera_cause); 0: none */
    uint8_t pending_cause;
    bool is_high;
    uint32_t high_block; /* block at which the pulse began */
    struct pulses pulses;
    uint16_t frame_count; /* number of frames since arming */
};

/* Executes the trigger command. MR_OK; MR_NOT_NOW: there is no camera. */
enum mr_status camera_trigger(struct camera *camera);
/* Call when a landing is armed. */
void camera_arm(struct camera *camera);
/* Call in each block, after landing_on_block. `until_tick`: captures up to this tick belong to the
 * block. */
void camera_on_block(struct camera *camera, struct telemetry *telemetry,
                     const struct landing *landing, uint32_t index, uint32_t tick,
                     uint32_t until_tick);

#endif
