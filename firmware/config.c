#include "firmware/config.h"

#include "common/closure.h"
#include "common/predictor.h"
#include "firmware/builtin.h"

/* Transducers: 4096 codes / 3.3 V * 0.5 V/in = 620.6 codes/in. Their mechanical zero is set at
 * 0.050 V (62.06 codes), so that an unexcited transducer does not read as zero. */
#define IN_PER_CODE            (3.3f / 4096.0f / BUILTIN_TRANSDUCER_V_PER_IN)
#define DISPLACEMENT_ZERO_CODE (0.050f * 4096.0f / 3.3f)

/* With all switches closed the staircase gives 0.050 V. */
#define STAIRCASE_ZERO_CODE (0.050f * 4096.0f / 3.3f)

/* Bridges through their amplifiers: 0.400 V at no tension, 5 mV/lb. */
#define GAGE_V_PER_LB     0.005f
#define LB_PER_CODE       (3.3f / 4096.0f / GAGE_V_PER_LB)
#define TENSION_ZERO_CODE (0.400f * 4096.0f / 3.3f)

/* Errors and limits of uncalibrated sensors, which apply until calibration values replace them. The
 * part due to the electronics is from the circuits (hil/circuits/figures.def) for temperature
 * changes up to 10 degrees; tests/hil/test_electronics.c checks these values against it.
 * Electrolytic transducer, 3 in of travel: reading better than 0.5 % (uniform: 0.5 % over the root
 * of 3), drive and amplifier 0.38 %, conductivity 0.07 % a degree: 0.65 % in all. Its zero is set
 * by hand to 0.01 in; it is linear to 0.1 % of its travel; conductivity moves the zero with
 * temperature, 0.002 in an hour. In the standard series the mat under a braking wheel moves at
 * about 5 in/s; the rate limit of 100 in/s is twenty times that. Bridge: gage factor to 0.5 %
 * (uniform), amplifier to 0.1 %. Before the command `zero`, the zero of a trimmed bridge is within
 * 1 lb. The zero of an untrimmed bridge may be off by hundreds of pounds: beyond the amplifier's
 * range the bridge reads as open or short, and the command `zero` refuses it
 * (firmware/calibrate.h). A measured zero has its own error (firmware/channels.h). Drift 0.5 lb an
 * hour; linear to 0.1 lb. The amplifier's output ends at 0 V (-80 lb) and at 3.3 V (580 lb). Band
 * tension rises within about 50 ms; the rate limit of 20000 lb/s is a hundred times the observed
 * rate. Reference: 0.05 % (uniform). */
#define TRANSDUCER_ERRORS                                                    \
    .gain_error = 0.0065f, .zero_error = 0.0058f, .linearity_error = 0.002f, \
    .drift_error_per_h = 0.002f, .low = -0.5f, .high = 3.0f, .rate_limit_per_s = 100.0f
#define BRIDGE_ERRORS                                                                              \
    .gain_error = 0.0033f, .zero_error = 1.0f, .linearity_error = 0.1f, .drift_error_per_h = 0.5f, \
    .low = -75.0f, .high = 575.0f, .rate_limit_per_s = 20000.0f
#define REFERENCE_GAIN_ERROR 0.00029f

/* Codes in the configuration are those of a converter with a 3.3 V supply. */
#define NOMINAL_MV   3300u
#define REFERENCE_MV 2500u

#define TRANSDUCER(n, station)                      \
    [(n)-1] = {.kind = MR_KIND_DISPLACEMENT,        \
               .number = n,                         \
               .station_ft = station,               \
               .unit_per_code = IN_PER_CODE,        \
               .zero_code = DISPLACEMENT_ZERO_CODE, \
               TRANSDUCER_ERRORS},
/* The shunt of a bridge corresponds to 40 lb of tension. */
#define GAGE(n, on_band, station)                               \
    [MR_TRANSDUCERS + (n)-1] = {.kind = MR_KIND_TENSION,        \
                                .number = n,                    \
                                .band = on_band,                \
                                .station_ft = station,          \
                                .unit_per_code = LB_PER_CODE,   \
                                .zero_code = TENSION_ZERO_CODE, \
                                BRIDGE_ERRORS,                  \
                                .gage_factor = 2.0f,            \
                                .shunt_lb = 40.0f},

/* Switches are 5 ft apart. The first two are on the track before touchdown (negative stations:
 * before the runway's edge) and give the speed on the track. Steps are 64 + 8 i codes, with i
 * permuted as 7 (p - 1) mod 24, so neighbours along the runway differ by 56 codes or more. */
#define SWITCH(p)                                                  \
    {                                                              \
        -2.5f + 5.0f * (float)((p)-1), 64 + 8 * (7 * ((p)-1) % 24) \
    }

struct mr_config config = {
    .site = {{
        .name = "rig",
        .mats = 420,
        .mat_length_ft = MR_MAT_LENGTH_FT,
        .touchdown_ft = 3.0f,
        /* uniform within 0.02 in: half width over the root of 3 */
        .switch_error_ft = 0.02f / 12.0f * 0.57735f,
        .wheel = MR_WHEEL_MAIN,
        .black_box = BUILTIN_BLACK_BOX,
        .camera = BUILTIN_CAMERA,
        .thermometer = 1,
        .camera_station_ft = __builtin_nanf(""),
        .brake_edge = BUILTIN_WHEEL_PULSES > 0,
        .wheel_pulses = BUILTIN_WHEEL_PULSES,
        .wheel_radius_ft = 0.292f,
        .wheel_radius_error_ft = 0.0015f,
    }},
    .channel =
        {
            BUILTIN_TRANSDUCERS(TRANSDUCER) BUILTIN_GAGES(
                GAGE)[MR_TRANSDUCERS + MR_ADC1_STAIRCASE] = {.kind = MR_KIND_STAIRCASE,
                                                             .station_ft = __builtin_nanf(""),
                                                             .unit_per_code = 1.0f,
                                                             .zero_code = STAIRCASE_ZERO_CODE},
            [MR_TRANSDUCERS + MR_ADC1_REFERENCE] = {.kind = MR_KIND_REFERENCE,
                                                    .station_ft = __builtin_nanf(""),
                                                    .unit_per_code = 1.0f,
                                                    .gain_error = REFERENCE_GAIN_ERROR},
        },
    .gate =
        {
            SWITCH(1),  SWITCH(2),  SWITCH(3),  SWITCH(4),  SWITCH(5),  SWITCH(6),
            SWITCH(7),  SWITCH(8),  SWITCH(9),  SWITCH(10), SWITCH(11), SWITCH(12),
            SWITCH(13), SWITCH(14), SWITCH(15), SWITCH(16), SWITCH(17), SWITCH(18),
            SWITCH(19), SWITCH(20), SWITCH(21), SWITCH(22), SWITCH(23), SWITCH(24),
        },
    .band =
        {
            /* the bands are 3/8 x 0.020 in, of mild steel that yields at 33 ksi: 247 lb */
            {.pretension_lb = 100.0f, .yield_lb = 240.0f},
            {.pretension_lb = 100.0f, .yield_lb = 240.0f},
        },
    /* Parameters of the model rig: a strip of 12/7 ft of AM2 mat to scale, 0.466 lb a mat; joint
     * properties that reproduce its movements (tests/runs/README.md); 1300 lb on twelve axles.
     * Critical compression: w L / 2 h0 for an irregularity of 0.043 in. */
    .predict = {{
        .fitted = BUILTIN_PREDICTOR,
        .updates_per_block = BUILTIN_UPDATES_PER_BLOCK,
        .mat_weight_lb = 0.466f,
        .friction = 0.5f,
        .joint_stiffness_lb_ft = 2.9e5f,
        .joint_damping_lb_s_ft = 5.0f,
        .slack_in = 0.030f,
        .step_ms = 0.185f,
        .grit_lb = 10.0f,
        .thrust_lb_per_g = 1300.0f / 12.0f,
        .deceleration_ft_s2 = 5.0f,
        .bump_in = 0.0432f,
    }},
    /* NaN: the lamp follows the predictor's verdict. */
    .risk = {{
        .lamp_cost_ratio = __builtin_nanf(""),
    }},
};

void config_adapt_to_board(uint32_t inputs, uint32_t supply_mv)
{
    float lost_v = 3.3f - (float)supply_mv / 1000.0f;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        struct mr_channel_config *channel = &config.channel[c];
        if (!(inputs >> c & 1u))
            *channel = (struct mr_channel_config){0};
        else if (supply_mv == NOMINAL_MV)
            continue;
        else if (channel->kind == MR_KIND_DISPLACEMENT)
            channel->high -= lost_v / BUILTIN_TRANSDUCER_V_PER_IN;
        else if (channel->kind == MR_KIND_TENSION)
            channel->high -= lost_v / GAGE_V_PER_LB;
        else if (channel->kind == MR_KIND_REFERENCE)
            channel->zero_code = (float)((REFERENCE_MV * 4096u + supply_mv / 2u) / supply_mv);
    }
}

uint32_t config_fitted_channels(void)
{
    uint32_t fitted = ~MR_BITS_OPTIONAL;
    for (unsigned c = 0; c < MR_TRANSDUCERS + MR_GAGES; c++)
        fitted |= (config.channel[c].kind != MR_KIND_NONE ? 1u : 0u) << c;
    return fitted;
}
