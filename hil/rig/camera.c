#include "hil/rig/camera.h"

#include "hil/board/machine.h"

#define PORT_B 1u
#define FRAME_PIN 3u

/* SplitMix64: -1 to 1. */
static double draw(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) / 4503599627370496.0 - 1.0;
}

static void plan_frame(struct hil_board *board)
{
    struct hil_camera *camera = &board->state.camera;
    const struct hil_options *options = &board->options;
    double even_ps = (double)camera->next_frame * 1e12 / options->camera_hz;
    double jitter_ps = draw(&camera->random) * (double)options->camera_jitter_ps;
    double since_ps = (double)options->camera_delay_ps + even_ps + jitter_ps;
    camera->frame_ps = camera->start_ps + (since_ps > 0.0 ? (uint64_t)(since_ps + 0.5) : 0u);
}

static void schedule(struct hil_board *board)
{
    const struct hil_camera *camera = &board->state.camera;
    uint64_t next = camera->running ? camera->frame_ps : HIL_NEVER;
    if (camera->pulse && camera->low_ps < next)
        next = camera->low_ps;
    hil_event_set_ps(board, HIL_EVENT_CAMERA, next);
}

void hil_camera_trigger(struct hil_board *board, bool level, uint64_t at)
{
    struct hil_camera *camera = &board->state.camera;
    bool rises = level && !camera->trigger;
    camera->trigger = level;
    if (!rises || camera->running || !(board->options.camera_hz > 0.0))
        return;
    *camera = (struct hil_camera){.trigger = true, .running = true, .skip = camera->skip,
                                  .start_ps = hil_clock_ps(&board->state.clock, at), .random = board->options.seed};
    hil_trace(board, "the camera starts");
    plan_frame(board);
    schedule(board);
}

void hil_camera_event(struct hil_board *board, uint64_t at)
{
    struct hil_camera *camera = &board->state.camera;
    uint64_t now_ps = hil_clock_ps(&board->state.clock, at);
    if (camera->pulse && camera->low_ps <= now_ps) {
        camera->pulse = false;
        hil_gpio_drive(board, PORT_B, FRAME_PIN, false, at);
    }
    if (camera->running && camera->frame_ps <= now_ps) {
        if (camera->skip) {
            camera->skip--;
        } else {
            camera->pulse = true;
            camera->low_ps = camera->frame_ps + HIL_CAMERA_PULSE_PS;
            board->state.counters.film_frames++;
            hil_gpio_drive(board, PORT_B, FRAME_PIN, true, at);
        }
        camera->next_frame++;
        plan_frame(board);
    }
    schedule(board);
}

void hil_camera_skip(struct hil_board *board, uint32_t frames)
{
    board->state.camera.skip = frames;
}
