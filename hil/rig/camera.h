/* The film camera of the rig: a rising edge of its trigger on PE2 starts it, and from a delay on it
 * gives a pulse of 100 us on PB3 for each frame, at an even rate with jitter, until the power goes.
 * A trigger while it runs changes nothing. */
#ifndef MATRIG_HIL_CAMERA_H
#define MATRIG_HIL_CAMERA_H

#include <stdbool.h>
#include <stdint.h>

struct hil_core;
struct hil_gpio_device;
struct hil_options;

#define HIL_CAMERA_PULSE_PS 100000000ull

struct hil_camera {
    bool trigger; /* level of PE2 */
    bool running;
    bool pulse;          /* PB3 is high */
    uint64_t start_ps;   /* of the trigger */
    uint64_t next_frame; /* from 0 */
    uint64_t frame_ps;   /* its time */
    uint64_t low_ps;     /* when the pulse ends */
    uint64_t random;
    uint32_t skip; /* so many frames from now on give no pulse */
};

struct hil_camera_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_camera *state;
    struct hil_gpio_device *gpio;
};

/* Connect it to its pins and the event queue. */
void hil_camera_create(struct hil_camera_device *dev);
/* So many frames from now on give no pulse. */
void hil_camera_skip(struct hil_camera_device *dev, uint32_t frames);

#endif
