#include "firmware/camera.h"

#include "firmware/config.h"

enum mr_status camera_trigger(struct camera *camera)
{
    if (!config.site[0].camera)
        return MR_NOT_NOW;
    camera->pending_cause = MR_CAMERA_BY_COMMAND;
    return MR_OK;
}

void camera_arm(struct camera *camera)
{
    camera->frame_count = 0;
    camera->is_station_trigger_done = __builtin_isnan(config.site[0].camera_station_ft);
    if (config.site[0].camera && camera->is_station_trigger_done)
        camera->pending_cause = MR_CAMERA_BY_ARMING;
}

static void report_frames(struct camera *camera, struct telemetry *telemetry, uint32_t index,
                          uint32_t until_tick, bool recording)
{
    uint32_t ticks[PULSES_PER_BLOCK];
    size_t count = pulses_get(&camera->pulses, BOARD_FRAME_PULSES, config.site[0].camera, index,
                              until_tick, ticks);
    for (size_t i = 0; i < count && recording; i++)
        TELEMETRY_SEND(telemetry, TO_RECORD, film_frame, FILM_FRAME,
                       .number = ++camera->frame_count, .tick = ticks[i],
                       .block16 = (uint16_t)index);
}

/* True if the wheel will be at the camera's station when a pulse sent now would begin, after the
 * end of the block. */
static bool is_at_station(const struct landing *landing, uint32_t tick)
{
    return landing->state == MR_LANDING_LANDING &&
           landing_wheel_at(landing, tick + MR_TICKS_PER_BLOCK).station_ft >=
               config.site[0].camera_station_ft;
}

static void send_trigger(struct camera *camera, struct telemetry *telemetry, uint32_t index)
{
    uint32_t tick = board_set_camera_trigger(true);
    TELEMETRY_SEND(telemetry, TO_RECORD, camera, CAMERA, .tick = tick,
                   .cause = (uint8_t)camera->pending_cause, .block16 = (uint16_t)index);
    camera->pending_cause = 0;
    camera->is_high = true;
    camera->high_block = index;
}

void camera_on_block(struct camera *camera, struct telemetry *telemetry,
                     const struct landing *landing, uint32_t index, uint32_t tick,
                     uint32_t until_tick)
{
    report_frames(camera, telemetry, index, until_tick, landing_is_recording(landing));
    if (camera->is_high && index - camera->high_block >= CAMERA_PULSE_BLOCKS) {
        (void)board_set_camera_trigger(false);
        camera->is_high = false;
    }
    if (!config.site[0].camera) {
        camera->pending_cause = 0; /* discard the request: the camera is no longer configured */
        return;
    }
    if (!camera->is_station_trigger_done && is_at_station(landing, tick)) {
        camera->is_station_trigger_done = true;
        camera->pending_cause = MR_CAMERA_BY_STATION;
    }
    if (camera->pending_cause && !camera->is_high)
        send_trigger(camera, telemetry, index);
}
