/* Bands on the emulated board: what the firmware says of landing 5's bands against the truth in the
 * run file, shunts with a gage that has drifted, zeros. The run files' truth is what the gages are
 * exposed to; the shunt's 40 lb is the rig's. */
#include <math.h>
#include <stdio.h>

#include "common/bands.h"
#include "hil/rig/rig.h"
#include "hil/rig/runfile.h"
#include "tests/hil/ear.h"

#define GAGE_COLUMN 8u

/* The message `name` of band `number` that was heard last; `said` keeps all that were. */
#define OF_BAND(ear, name, NAME, number, into)                                            \
    do {                                                                                  \
        bool found_ = false;                                                              \
        for (unsigned i_ = 0; i_ < (ear)->said_count[EAR_SERIAL]; i_++) {                 \
            const struct ear_said *said_ = &(ear)->said[EAR_SERIAL][i_];                  \
            struct mr_##name each_;                                                       \
            if (said_->id == MR_ID_##NAME &&                                              \
                mr_##name##_get(&each_, said_->payload, MR_MESSAGE_BYTES_MAX) == MR_OK && \
                each_.band == (number)) {                                                 \
                *(into) = each_;                                                          \
                found_ = true;                                                            \
            }                                                                             \
        }                                                                                 \
        assert_true(found_);                                                              \
    } while (0)

struct truth {
    double before, least, most, after;
    unsigned least_gage, most_gage;
};

/* From the samples: before the first switch opens, since then, and the last quarter of a second
 * before `end_s`. */
static struct truth truth_of(const struct hil_run *run, unsigned band, double end_s)
{
    struct truth truth = {.least = 1e9, .most = -1e9};
    double open_s = (double)run->switch_open_ps[0] * 1e-12;
    unsigned gages = 0;
    for (unsigned g = 0; g < HIL_RUN_GAGES; g++) {
        if (g / 7u + 1u != band)
            continue;
        gages++;
        truth.before += hil_run_get_true_value(run, GAGE_COLUMN + g, open_s - 0.1);
        for (double t_s = open_s; t_s < end_s; t_s += 0.001) {
            double lb = hil_run_get_true_value(run, GAGE_COLUMN + g, t_s);
            if (lb < truth.least) {
                truth.least = lb;
                truth.least_gage = g + 1;
            }
            if (lb > truth.most) {
                truth.most = lb;
                truth.most_gage = g + 1;
            }
        }
        truth.after += hil_run_get_true_value(run, GAGE_COLUMN + g, end_s);
    }
    truth.before /= gages;
    truth.after /= gages;
    return truth;
}

/* Within a code of the converter and what 4 ms take off a peak. */
static void check_band(struct ear *ear, unsigned number)
{
    struct mr_band_before before = {0};
    struct mr_band_least least = {0};
    struct mr_band_most most = {0};
    struct mr_band_after after = {0};
    struct truth truth = truth_of(&ear->run, number, ear->run.duration_s);
    OF_BAND(ear, band_before, BAND_BEFORE, number, &before);
    OF_BAND(ear, band_least, BAND_LEAST, number, &least);
    OF_BAND(ear, band_most, BAND_MOST, number, &most);
    OF_BAND(ear, band_after, BAND_AFTER, number, &after);
    printf("# band %u: before %.2f (truth %.2f), least %.2f at gage %u (%.2f at %u), most %.2f at "
           "gage %u (%.2f at %u), after %.2f "
           "(%.2f)\n",
           number, (double)before.before_lb, truth.before, (double)least.tension_lb, least.gage,
           truth.least, truth.least_gage, (double)most.tension_lb, most.gage, truth.most,
           truth.most_gage, (double)after.after_lb, truth.after);
    assert_int_equal(before.gages, 7);
    assert_near(before.before_lb, truth.before, 0.2);
    assert_near(least.tension_lb, truth.least, 0.5);
    assert_int_equal(least.gage, truth.least_gage);
    assert_near(most.tension_lb, truth.most, 0.5);
    assert_int_equal(most.gage, truth.most_gage);
    assert_near(after.after_lb, truth.after, 0.3);
    assert_near(after.change_lb, truth.after - truth.before, 0.2);
}

TEST(landing_5_has_its_figures_and_no_finding)
{
    struct hil_options options = ear_options();
    options.has_adc_noise = true;
    struct ear *ear = ear_open(&options, 5);
    ear->listens = true;
    ear_until(ear, 1.5);
    ear->said_count[EAR_SERIAL] = 0;
    unsigned states = ear->heard[EAR_CAN][MR_ID_BAND_STATE];
    ear_until(ear, 2.5);
    /* two bands, ten a second */
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_BAND_STATE] - states, 20);
    ear_until(ear, 8.7);
    ear->said_count[EAR_SERIAL] = 0; /* 4096 places */
    ear_until(ear, ear->run.duration_s);
    check_band(ear, 1);
    check_band(ear, 2);
    assert_int_equal(
        ear->heard[EAR_CAN][MR_ID_BAND_EVENT] + ear->heard[EAR_SERIAL][MR_ID_BAND_EVENT], 0);
    ear_close(ear);
}

static void wait_for_ack(struct ear *ear, unsigned code, int status)
{
    struct mr_ack ack;
    ear_until(ear, (double)hil_board_now_ps(ear->board) * 1e-12 + 1.2);
    assert_int_equal(mr_ack_get(&ack, ear->last[EAR_CAN][MR_ID_ACK], MR_MESSAGE_BYTES_MAX), MR_OK);
    assert_int_equal(ack.code, code);
    assert_int_equal(ack.status, status);
}

static struct mr_shunt_result shunt_of(const struct ear *ear, unsigned gage)
{
    struct mr_shunt_result result = {0};
    for (unsigned i = 0; i < ear->said_count[EAR_SERIAL]; i++) {
        struct mr_shunt_result each;
        if (ear->said[EAR_SERIAL][i].id == MR_ID_SHUNT_RESULT &&
            mr_shunt_result_get(&each, ear->said[EAR_SERIAL][i].payload, MR_MESSAGE_BYTES_MAX) ==
                MR_OK &&
            each.gage == gage)
            result = each;
    }
    assert_int_equal(result.gage, gage);
    return result;
}

/* Through converter noise of 2 codes: a gain 1.5 % off is named, to a tenth of a per cent; then the
 * same gage drifts on. */
TEST(shunts_find_the_gage_that_drifted)
{
    struct hil_options options = ear_options();
    struct mr_shunt_check check = {0};
    options.has_adc_noise = true;
    struct ear *ear = ear_open(&options, 0);
    ear->listens = true;
    ear_order(ear, "at 0.5 gage 5 drift 1.015 2.0");
    ear_until(ear, 1.0);
    ear_command(ear, EAR_CAN, MR_COMMAND_SHUNT, 0, 7);
    ear_until(ear, 1.45); /* rest, settling: the relay pulls */
    assert_true(hil_board_pin_level(ear->board, 'E' - 'A', 1));
    ear_until(ear, 1.0);
    wait_for_ack(ear, MR_COMMAND_SHUNT, MR_LIMIT);
    assert_false(hil_board_pin_level(ear->board, 'E' - 'A', 1));
    ear_logged(ear, "gage 5 drift");
    for (unsigned g = 1; g <= HIL_RUN_GAGES; g++) {
        struct mr_shunt_result result = shunt_of(ear, g);
        assert_int_equal(result.verdict, g == 5 ? 3 : 0);
        assert_near(result.span_lb, g == 5 ? 1.015 * HIL_RIG_SHUNT_LB : HIL_RIG_SHUNT_LB, 0.05);
        /* 2 codes over eight: 0.114 lb */
        assert_true(result.noise_lb > 0.05f && result.noise_lb < 0.2f);
    }
    ear_order(ear, "at 3 gage 5 drift 1.025 1.0");
    ear_until(ear, 3.1);
    ear->said_count[EAR_SERIAL] = 0;
    ear_command(ear, EAR_SERIAL, MR_COMMAND_SHUNT, 0, 8);
    wait_for_ack(ear, MR_COMMAND_SHUNT, MR_LIMIT);
    for (unsigned i = 0; i < ear->said_count[EAR_SERIAL]; i++) {
        struct mr_shunt_check each;
        if (ear->said[EAR_SERIAL][i].id != MR_ID_SHUNT_CHECK)
            continue;
        assert_int_equal(
            mr_shunt_check_get(&each, ear->said[EAR_SERIAL][i].payload, MR_MESSAGE_BYTES_MAX),
            MR_OK);
        if (each.gage == 5)
            check = each;
        else
            assert_near(each.change_lb, 0.0, 0.05);
    }
    assert_int_equal(check.gage, 5);
    assert_near(check.change_lb, 0.010 * HIL_RIG_SHUNT_LB, 0.05);
    assert_near(check.zero_change_lb, -1.0, 0.05);
    ear_close(ear);
}

TEST(a_drifted_zero_is_taken_out)
{
    struct mr_tension_4_6 t;
    struct ear *ear = ear_open(NULL, 0);
    ear_order(ear, "at 0.5 gage 5 drift 1 6.5");
    ear_until(ear, 1.0);
    assert_int_equal(
        mr_tension_4_6_get(&t, ear->last[EAR_CAN][MR_ID_TENSION_4_6], MR_MESSAGE_BYTES_MAX), MR_OK);
    assert_near(t.t5_lb, 6.5, 0.2);
    ear_command(ear, EAR_CAN, MR_COMMAND_ZERO, 2, 1);
    wait_for_ack(ear, MR_COMMAND_ZERO, MR_OK);
    assert_int_equal(
        mr_tension_4_6_get(&t, ear->last[EAR_CAN][MR_ID_TENSION_4_6], MR_MESSAGE_BYTES_MAX), MR_OK);
    assert_near(t.t5_lb, 0.0, 0.05);
    ear_close(ear);
}

TEST(bands_under_tension_are_no_zero)
{
    struct ear *ear = ear_open(NULL, 1); /* its truth holds before it begins: 100 and 60 lb */
    ear_until(ear, 0.05);
    ear_command(ear, EAR_CAN, MR_COMMAND_ZERO, 2, 1);
    ear_until(ear, 0.5);
    assert_int_equal(ear->heard[EAR_CAN][MR_ID_ZERO_RESULT], HIL_RUN_GAGES);
    struct mr_zero_result result;
    assert_int_equal(
        mr_zero_result_get(&result, ear->last[EAR_CAN][MR_ID_ZERO_RESULT], MR_MESSAGE_BYTES_MAX),
        MR_OK);
    assert_int_equal(result.verdict, 3);
    ear_close(ear);
}
