/* The channels on the emulated board: an excitation without direct component, whatever happens to
 * the scans; the noise that the board tells; the faults of leads. */
#include <math.h>

#include "common/channels.h"
#include "tests/hil/ear.h"

static double plus_s(const struct ear *ear)
{
    return (double)hil_board_counters(ear->board)->excitation_plus_ps * 1e-12;
}
static double minus_s(const struct ear *ear)
{
    return (double)hil_board_counters(ear->board)->excitation_minus_ps * 1e-12;
}

static void overrun(struct ear *ear, unsigned unit)
{
    struct hil_adc *adc = &ear->board->state.mcu.adc[unit];
    adc->sr |= 0x20u; /* OVR: it stops */
    adc->is_sequence_running = false;
}

/* Landing 5 from its arming on, both converters stopping once on the way. The time at each
 * polarity, every 10 ms, at all phases: never further apart than one of 125 us, 0.1 % of the
 * landing 80 times over in all; and so is the charge, for the transducer follows each reversal
 * alike. */
TEST(the_excitation_has_no_mean_through_stalls)
{
    struct ear *ear = ear_open(NULL, 5);
    ear_until(ear, 0.8);
    double plus = plus_s(ear), minus = minus_s(ear), worst_s = 0.0;
    for (unsigned step = 0; step < 800; step++) {
        if (step == 170)
            overrun(ear, HIL_ADC1);
        if (step == 320)
            overrun(ear, HIL_ADC3);
        ear_until(ear, 0.8 + 0.0100625 * (step + 1));
        worst_s = fmax(worst_s, fabs((plus_s(ear) - plus) - (minus_s(ear) - minus)));
    }
    double sum_s = plus_s(ear) - plus + minus_s(ear) - minus;
    double mean = fabs((plus_s(ear) - plus) - (minus_s(ear) - minus)) / sum_s;
    printf(
        "# excitation: mean %.1e of its amplitude over %.3f s, at most %.1f us apart, %u stalls\n",
        mean, sum_s, worst_s * 1e6, ear->fault[MR_FAULT_SCAN_STALL].count);
    assert_int_equal(ear->fault[MR_FAULT_SCAN_STALL].count, 2);
    assert_int_equal(ear->fault[MR_FAULT_POLARITY].count, 0);
    assert_near(sum_s, 8.05, 1e-4); /* always at one of them */
    assert_true(mean < 1e-3);
    assert_true(worst_s < 126e-6);
    ear_close(ear);
}

/* Wherever in a block one of them stops, right at its end too, where the codes that it has left
 * look whole to every second block. */
TEST(a_converter_that_stops_is_started_again)
{
    struct ear *ear = ear_open(NULL, 0);
    for (unsigned phase = 0; phase < MR_SCANS_PER_BLOCK; phase++) {
        ear_until(ear, 1.0 + 0.2 * phase + 125e-6 * phase);
        overrun(ear, phase % 2 ? HIL_ADC1 : HIL_ADC3);
        ear_until(ear, 1.1 + 0.2 * phase + 125e-6 * phase);
        overrun(ear, phase % 2 ? HIL_ADC3 : HIL_ADC1);
    }
    ear_until(ear, 1.0 + 0.2 * MR_SCANS_PER_BLOCK + 0.1);
    assert_int_equal(ear->fault[MR_FAULT_SCAN_STALL].count, 2 * MR_SCANS_PER_BLOCK);
    ear_close(ear);
}

/* 2 LSB rms and rounding, sqrt(4 + 1/48 + 1/12) a code, mean of eight: 0.716 codes. A reading
 * follows its block's reference too, 0.716 codes of 3103: of a gage at 100 lb, 1117 codes, 0.26. */
TEST(the_noise_told_is_the_converters)
{
    struct hil_options options = ear_options();
    options.has_adc_noise = true;
    struct ear *ear = ear_open(&options, 1);
    double sum[2] = {0.0, 0.0};
    unsigned count[2] = {0, 0}, told[MR_CHANNELS] = {0};
    ear->listens = true;
    ear_until(ear, 5.0);
    for (unsigned i = 0; i < ear->said_count[EAR_SERIAL]; i++) {
        struct mr_channel_quality quality;
        if (ear->said[EAR_SERIAL][i].id != MR_ID_CHANNEL_QUALITY)
            continue;
        mr_channel_quality_get(&quality, ear->said[EAR_SERIAL][i].payload, 8);
        unsigned kind = quality.index >= MR_TRANSDUCERS;
        if (told[quality.index]++ < 1)
            continue; /* not long enough yet */
        sum[kind] += (double)quality.noise_codes;
        count[kind]++;
        assert_int_equal(quality.invalid, 0);
        /* it is told to a hundredth */
        assert_true(quality.error_codes > quality.noise_codes - 0.0055f);
    }
    printf("# noise told: transducers %.3f, gages %.3f codes\n", sum[0] / count[0],
           sum[1] / count[1]);
    for (unsigned c = 0; c < MR_TRANSDUCERS + MR_GAGES; c++)
        assert_in_range(told[c], 4, 5); /* armed at 0.8 s */
    assert_near(sum[0] / count[0], 0.72, 0.05);
    assert_near(sum[1] / count[1], 0.76, 0.05);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_CHANNEL_EVENT], 0);
    ear_close(ear);
}

static void expect_event(const struct ear *ear, unsigned channel, unsigned validity)
{
    for (unsigned link = 0; link < EAR_LINKS; link++) {
        struct mr_channel_event event;
        mr_channel_event_get(&event, ear->last[link][MR_ID_CHANNEL_EVENT], 8);
        assert_int_equal(event.index, channel);
        assert_int_equal(event.validity, validity);
    }
}

/* While idle too: found, told within half a second, and told again when it is mended. */
TEST(a_broken_lead_is_told_while_idle)
{
    static const struct {
        unsigned channel, fault, validity;
    } cases[] = {
        {2, HIL_CHANNEL_OPEN, MR_INVALID_OPEN},
        {2, HIL_CHANNEL_HIGH, MR_INVALID_SHORTED},
        {9, HIL_CHANNEL_OPEN, MR_INVALID_OPEN},
        {9, HIL_CHANNEL_HIGH, MR_INVALID_SHORTED},
    };
    struct ear *ear = ear_open(NULL, 0);
    double t_s = 1.0;
    ear_until(ear, t_s);
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        unsigned told = ear->heard[EAR_CAN][MR_ID_CHANNEL_EVENT];
        hil_rig_set_channel_fault(&ear->board->rig, cases[i].channel,
                                  (enum hil_channel_fault)cases[i].fault);
        ear_until(ear, t_s += 1.0);
        assert_int_equal(ear->heard[EAR_CAN][MR_ID_CHANNEL_EVENT], told + 1);
        expect_event(ear, cases[i].channel, cases[i].validity);
        assert_int_equal(ear->fault[MR_FAULT_CHANNEL].count, i + 1);
        assert_int_equal(ear->fault[MR_FAULT_CHANNEL].detail, cases[i].channel);
        hil_rig_set_channel_fault(&ear->board->rig, cases[i].channel, HIL_CHANNEL_GOOD);
        ear_until(ear, t_s += 4.0);
        assert_int_equal(ear->heard[EAR_CAN][MR_ID_CHANNEL_EVENT], told + 2);
        expect_event(ear, cases[i].channel, MR_VALID);
    }
    ear_close(ear);
}
