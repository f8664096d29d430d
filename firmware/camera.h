/* The film camera: a trigger pulse, and the camera's pulse for each frame, sent with its time.
 *
 * The trigger is a pulse of 10 ms: when a landing is armed, or when the gear is to be at
 * site.camera_station_ft by the motion estimated last (once a landing), and by command. Frame
 * pulses are sent while a landing is recorded, numbered from arming on. A camera gives 64 to 200 of
 * them a second; one less than a millisecond after the one before is refused and counted. At 200 a
 * second they take 2.4 % of the CAN bus, 1.8 % of serial and 2.1 kB/s of the black box. With
 * site.camera 0 nothing is captured, triggered or sent. */
#ifndef MATRIG_FIRMWARE_CAMERA_H
#define MATRIG_FIRMWARE_CAMERA_H

#include "common/onboard/landing.h"
#include "common/status.h"
#include "firmware/telemetry.h"

#define CAMERA_PULSE_BLOCKS 10u
/* taken of one block; a thousand a second may stand in 2 ms of blocks that wait */
#define CAMERA_FRAMES       8u

struct camera {
    bool fitted; /* frame pulses are captured */
    bool passed; /* it was triggered by station in this landing, or need not be */
    uint8_t due; /* why it is triggered in the next block (enum mr_camera_cause); 0: it is not */
    bool high;
    uint32_t high_block; /* since */
    bool frame_known;
    uint32_t frame_tick, frame_block; /* of the last one that counts */
    uint16_t frames;                  /* since arming */
};

/* The command: MR_NOT_NOW: there is no camera. */
enum mr_status camera_command(struct camera *camera);
/* A landing is armed. */
void camera_arm(struct camera *camera);
/* Each block, after the landing had it. `until_tick`: captures up to here belong to it. */
void camera_block(struct camera *camera, struct telemetry *telemetry, const struct landing *landing,
                  uint32_t index, uint32_t tick, uint32_t until_tick);

#endif
