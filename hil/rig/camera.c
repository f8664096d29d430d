#include "hil/rig/camera.h"

#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/periph/cells.h"
#include "hil/periph/gpio.h"
#include "hil/periph/options.h"

#define PORT_B      1u
#define FRAME_PIN   3u
#define PORT_E      4u
#define TRIGGER_PIN 2u

static void plan_frame(struct hil_camera_device *dev)
{
    struct hil_camera *camera = dev->state;
    const struct hil_options *options = dev->options;
    double even_ps = (double)camera->next_frame * 1e12 / options->camera_hz;
    double drawn = (double)(hil_random(&camera->random) >> 11) * 0x1p-52 - 1.0; /* -1 to 1 */
    double jitter_ps = drawn * (double)options->camera_jitter_ps;
    double since_ps = (double)options->camera_delay_ps + even_ps + jitter_ps;
    camera->frame_ps = camera->start_ps + (since_ps > 0.0 ? (uint64_t)(since_ps + 0.5) : 0u);
}

static void schedule(struct hil_camera_device *dev)
{
    const struct hil_camera *camera = dev->state;
    uint64_t next = camera->running ? camera->frame_ps : HIL_NEVER;
    if (camera->pulse && camera->low_ps < next)
        next = camera->low_ps;
    hil_event_set_ps(dev->core, HIL_EVENT_CAMERA, next);
}

static void look_at_trigger(void *device, uint64_t at)
{
    struct hil_camera_device *dev = device;
    struct hil_camera *camera = dev->state;
    bool level = hil_gpio_level(dev->gpio, PORT_E, TRIGGER_PIN);
    bool rises = level && !camera->trigger;
    camera->trigger = level;
    if (!rises || camera->running || !(dev->options->camera_hz > 0.0))
        return;
    *camera = (struct hil_camera){.trigger = true,
                                  .running = true,
                                  .skip = camera->skip,
                                  .start_ps = hil_clock_ps(&dev->core->state.clock, at),
                                  .random = dev->options->seed};
    hil_trace(dev->core, "the camera starts");
    plan_frame(dev);
    schedule(dev);
}

static void on_event(void *device, uint64_t at)
{
    struct hil_camera_device *dev = device;
    struct hil_camera *camera = dev->state;
    uint64_t now_ps = hil_clock_ps(&dev->core->state.clock, at);
    if (camera->pulse && camera->low_ps <= now_ps) {
        camera->pulse = false;
        hil_gpio_drive(dev->gpio, PORT_B, FRAME_PIN, false, at);
    }
    if (camera->running && camera->frame_ps <= now_ps) {
        if (camera->skip) {
            camera->skip--;
        } else {
            camera->pulse = true;
            camera->low_ps = camera->frame_ps + HIL_CAMERA_PULSE_PS;
            dev->core->state.counters.film_frames++;
            hil_gpio_drive(dev->gpio, PORT_B, FRAME_PIN, true, at);
        }
        camera->next_frame++;
        plan_frame(dev);
    }
    schedule(dev);
}

void hil_camera_skip(struct hil_camera_device *dev, uint32_t frames)
{
    dev->state->skip = frames;
}

void hil_camera_create(struct hil_camera_device *dev)
{
    hil_gpio_listen(dev->gpio, look_at_trigger, dev);
    hil_event_wire(dev->core, HIL_EVENT_CAMERA, on_event, dev);
}
