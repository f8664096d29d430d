/* A configuration with nothing wrong in it and something in every field. */
#ifndef MATRIG_TESTS_COMMON_SOUND_CONFIG_H
#define MATRIG_TESTS_COMMON_SOUND_CONFIG_H

#include <string.h>

#include "common/channels.h"
#include "common/config.h"
#include "common/wire.h"

static inline struct mr_config sound_config(void)
{
    struct mr_config c;
    memset(&c, 0, sizeof c);
    strcpy(c.site[0].name, "rig \"A\" \\ #1");
    c.site[0].revision = 7;
    c.site[0].mats = 420;
    c.site[0].mat_length_ft = 0.2857142857f;
    c.site[0].touchdown_ft = 3.0f;
    c.site[0].switch_error_ft = 0.00096f;
    c.site[0].wheel_ahead_ft = -1.5f;
    c.site[0].wheel = 1;
    c.site[0].camera_station_ft = MR_NAN;
    c.site[0].can_base = 0x190;
    c.site[0].brake_edge = 1;
    c.site[0].wheel_pulses = 8;
    c.site[0].wheel_radius_ft = 0.292f;
    c.site[0].wheel_radius_error_ft = 0.0015f;
    for (unsigned i = 0; i < MR_CHANNELS; i++) {
        struct mr_channel_config *channel = &c.channel[i];
        channel->kind = i < 8   ? MR_KIND_DISPLACEMENT
                      : i < 22  ? MR_KIND_TENSION
                      : i == 22 ? MR_KIND_STAIRCASE
                                : MR_KIND_REFERENCE;
        channel->number = (uint8_t)(i < 8 ? i + 1 : i < 22 ? i - 7 : 0);
        channel->band = (uint8_t)(i < 8 || i > 21 ? 0 : 1 + i % 2);
        channel->station_ft = i < 22 ? 10.0f + 1.1f * (float)i : MR_NAN;
        channel->unit_per_code = i < 22 ? 0.0016113281f * (float)(i + 1) : 1.0f;
        channel->zero_code = i < 22 ? 62.060604f - (float)i : 0.0f;
        channel->gain_error = 0.001f;
        channel->low = -3.0f;
        channel->high = 3.1f;
        channel->points = i == 3 ? 3 : 0;
        if (i == 3) {
            const float readings[] = {-2.0f, 0.1f, 2.0f}, values[] = {-2.01f, 0.1f, 1.97f};
            memcpy(channel->point_reading, readings, sizeof readings);
            memcpy(channel->point_value, values, sizeof values);
        }
        memcpy(channel->serial, "SN-000000042", 12); /* all of it: no zero at the end */
        channel->calibrated_day = 20000 + i;
        channel->expires_day = 20365 + i;
    }
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++) {
        c.gate[i].station_ft = -2.5f + 5.0f * (float)i;
        c.gate[i].step_codes = (uint16_t)(i == 5 ? 0 : 64 + 8 * ((7 * i) % 24));
    }
    c.band[0] = (struct mr_band_config){.pretension_lb = 100.0f, .yield_lb = 1000.0f};
    c.band[1] = (struct mr_band_config){.pretension_lb = 130.0f};
    c.predict[0] = (struct mr_predict_config){.fitted = 1,
                                              .level = 1,
                                              .updates_per_block = 800,
                                              .mat_weight_lb = 0.466f,
                                              .friction = 0.45f,
                                              .joint_stiffness_lb_ft = 2.9e5f,
                                              .joint_damping_lb_s_ft = 5.0f,
                                              .slack_in = 0.030f,
                                              .step_ms = 0.166f,
                                              .grit_lb = 10.0f,
                                              .thrust_lb_per_g = 108.3f,
                                              .deceleration_ft_s2 = 5.0f,
                                              .bump_in = 0.043f};
    c.risk[0] = (struct mr_risk_config){.lamp_cost_ratio = 4.0f};
    return c;
}

#endif
