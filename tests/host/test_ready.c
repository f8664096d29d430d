/* Ready: what facts are go and what no-go; what a walk says; movements by hand. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/channels.h"
#include "common/fault.h"
#include "host/board/ready.h"
#include "host/board/walk.h"
#include "host/store/store.h"
#include "tests/cmocka_all.h"

static struct ready_inputs f;
static struct ready_report report;

/* A rig with one transducer, two gages on a band of 100 lb, two switches of 64 and 120 codes, on
 * which nothing is wrong. */
static int all_well(void **state)
{
    (void)state;
    memset(&f, 0, sizeof f);
    f.today_day = 20000;
    f.now_s = 20000 * 86400 + 43200;
    f.shunt_done = f.self_test_done = f.box_known = f.temperature_known = f.alarm_known = true;
    f.is_can_used = f.database_checked = f.has_previous_landing = true;
    f.identity.hello = (struct mr_hello){.layout = MR_LAYOUT};
    f.identity.key_known = true;
    f.identity.commit_known = true;
    f.identity.commit.state = MR_IMAGE_INTACT;
    f.identity.image_crc = 0x1234;
    f.previous_run = 3;
    f.previous_image_crc = 0x1234;
    f.previous_config_crc = f.config_crc = 0xabcd;
    f.config.site[0] = (struct mr_site_config){.black_box = 1, .thermometer = 1};
    f.config.channel[0] = (struct mr_channel_config){
        .kind = MR_KIND_DISPLACEMENT, .number = 1, .calibrated_day = 1, .expires_day = 20001};
    for (unsigned i = 8; i < 10; i++)
        f.config.channel[i] = (struct mr_channel_config){.kind = MR_KIND_TENSION,
                                                         .number = (uint8_t)(i - 7),
                                                         .band = 1,
                                                         .shunt_lb = 40.0f,
                                                         .calibrated_day = 1};
    for (unsigned i = 0; i < 10; i += i ? 1 : 8) /* 0, 8, 9 */ {
        f.certificates.is_known[i] = true;
        f.certificates.certificate[i] = (struct store_certificate){
            .index = i, .number = "C-1", .calibrated_day = 19900, .due_day = 20100};
    }
    f.config.channel[22] = (struct mr_channel_config){.kind = MR_KIND_STAIRCASE,
                                                      .zero_code = 62.0f};
    f.config.gate[0].step_codes = 64;
    f.config.gate[1].step_codes = 120;
    f.config.band[0].pretension_lb = 100.0f;
    f.block_count = 100;
    f.channel[0] = (struct ready_channel){.block_count = 100, .mean = 0.01f, .noise_codes = 0.7f};
    f.channel[8] = f.channel[9] =
        (struct ready_channel){.block_count = 100, .mean = 101.0f, .noise_codes = 0.7f};
    f.channel[22] = (struct ready_channel){.block_count = 100, .mean = 62.3f, .noise_codes = 0.3f};
    f.time_fit = (struct timemap_fit){
        .refusal = TIMEMAP_OK, .pair_count = 30, .rate_ppm = {.value = 20.0, .half_width = 50.0}};
    f.shunts.count = 2;
    for (unsigned i = 0; i < MR_GAGES; i++)
        f.previous_span_lb[i] = NAN;
    for (unsigned i = 0; i < 2; i++) {
        f.shunts.result[i] =
            (struct mr_shunt_result){.gage = (uint8_t)(i + 1), .noise_lb = 0.05f, .span_lb = 40.0f};
        f.shunts.check[i] = (struct mr_shunt_check){.gage = (uint8_t)(i + 1), .expected_lb = 40.0f};
        f.previous_span_lb[i] = 40.1f;
    }
    f.self_test.done = 0x7f;
    f.box_state = (struct mr_box_state){.state = 2, .ready = 400, .reserve = 288};
    f.temperature.temperature_c = 21.0f;
    f.can_frame_count = 1000;
    f.serial_frame_count = 2000;
    f.bytes_per_landing = 3e6;
    f.free_bytes = 30e6;
    return 0;
}

static const struct ready_check *check_named(const char *name)
{
    for (unsigned i = 0; i < report.count; i++) {
        if (strcmp(report.check[i].name, name) == 0)
            return &report.check[i];
    }
    fail_msg("no check %s", name);
    return NULL;
}

/* That check alone is no-go, with this in its words and something to do about it. */
static void only_no_go(const char *name, const char *words)
{
    ready_check_all(&f, &report);
    const struct ready_check *c = check_named(name);
    if (c->verdict != READY_NO_GO || !strstr(c->value, words) || !c->advice[0])
        fail_msg("%s: %s: %s -> %s", name, ready_verdict_text(c->verdict), c->value, c->advice);
    assert_int_equal(ready_count_checks(&report, READY_NO_GO), 1);
    assert_int_equal(ready_verdict(&report), READY_NO_GO);
    all_well(NULL);
}

static void no_go_advises(const char *name, const char *words)
{
    ready_check_all(&f, &report);
    const struct ready_check *c = check_named(name);
    if (c->verdict != READY_NO_GO || !strstr(c->advice, words))
        fail_msg("%s: %s -> %s", name, ready_verdict_text(c->verdict), c->advice);
    all_well(NULL);
}

TEST_IN(what_is_well_is_go, all_well, NULL)
{
    ready_check_all(&f, &report);
    for (unsigned i = 0; i < report.count; i++) {
        if (report.check[i].verdict != READY_GO)
            fail_msg("%s: %s", report.check[i].name, report.check[i].value);
    }
    assert_int_equal(ready_verdict(&report), READY_GO);
    assert_true(report.count >= 20);
    f.free_bytes = 29.9e6; /* ten landings of 3 MB */
    only_no_go("disk", "30 MB are free");
}

/* Storing a file raises its revision, and with it the CRC: that is no other configuration. Another
 * field is. */
TEST_IN(a_configuration_is_compared_but_for_its_revision, all_well, NULL)
{
    static uint8_t image[MR_CONFIG_IMAGE_BYTES];
    struct mr_config given = f.config;
    f.config.site[0].revision = 7;
    f.config_crc = mr_config_encode(&f.config, image);
    f.has_expected_crc = true;
    f.expected_config = &given;
    ready_check_all(&f, &report);
    assert_int_equal(check_named("configuration")->verdict, READY_GO);
    given.gate[1].step_codes = 121;
    only_no_go("configuration", "revision 7");
}

TEST_IN(each_thing_that_is_wrong_is_named, all_well, NULL)
{
    f.identity.image_crc = 0x1235;
    only_no_go("firmware", "image 00001235");
    f.identity.commit.state = MR_IMAGE_PROGRAM_DAMAGED;
    only_no_go("firmware", mr_image_state_text(MR_IMAGE_PROGRAM_DAMAGED));
    f.config_crc = 1;
    only_no_go("configuration", "CRC 00000001");
    f.has_expected_crc = true;
    f.expected_crc = 2;
    only_no_go("configuration", "CRC 0000abcd");
    f.config.channel[8].expires_day = 20000;
    only_no_go("calibration", "expired: gage 1");
    f.identity.hello.clock_source = 1;
    only_no_go("clock", "internal oscillator");
    f.identity.hello.clock_source =
        2; /* its cause is named, also when the alarm has not come yet */
    f.alarm_known = false;
    f.can_frame_count = 0;
    no_go_advises("CAN", "correct the fault of the clock");
    f.time_fit.rate_ppm.value = 260.0;
    only_no_go("time of day", "+260");
    f.lost_block_count = 1;
    only_no_go("readings", "1 lost");
    f.block_count = 49;
    only_no_go("readings", "49 blocks");
    f.channel[0].invalid_count = 4;
    f.channel[0].validity = MR_INVALID_OPEN;
    only_no_go("transducer 1", "4 of 100");
    f.channel[0].mean = -0.26f;
    only_no_go("transducer 1", "-0.2600 in");
    f.channel[9].noise_codes = 3.1f;
    only_no_go("gage 2", "noise 3.10");
    f.channel[8].mean = 126.0f; /* the band's mean is 102: good, but this gage is not */
    f.channel[9].mean = 78.0f;
    only_no_go("gage 1", "126.0 lb");
    f.channel[8].mean = f.channel[9].mean = 89.9f;
    only_no_go("band 1", "89.9 lb");
    f.channel[22].mean = 62.0f + 120.0f;
    only_no_go("switches", "switch 2 is open");
    f.channel[22].mean = 62.0f + 184.0f;
    only_no_go("switches", "switches are open");
    f.channel[22].mean = 20.0f;
    only_no_go("switches", "lower than possible");
    f.shunts.result[1].verdict = 3;
    f.shunts.result[1].span_lb = 41.2f;
    only_no_go("shunt calibration", "gage 2 wrong (41.20 lb of 40.00 lb)");
    f.shunts.result[0].span_lb = 40.7f; /* 0.6 lb more than before: beyond 0.401 + 3 * 0.05 */
    only_no_go("shunt calibration", "gage 1 drifted by +0.60 lb");
    f.shunt_done = false;
    only_no_go("shunt calibration", "did not answer");
    f.box_state.state = 0;
    only_no_go("black box", "no memory answers");
    f.box_state.wait_s = 12.5f;
    only_no_go("black box", "12.5 s until");
    f.box_state.wait_s = NAN;
    f.box_state.records = 26;
    only_no_go("black box", "26 records to free");
    f.self_test.failed = 1u << MR_SELF_TEST_NOR;
    only_no_go("self-test", "memory of the black box");
    f.self_test.done = 0x7d;
    only_no_go("self-test", "not tested: the program's checksum");
    f.self_test.failed = 1u << MR_SELF_TEST_LAMP_OFF;
    only_no_go("warning lamp", "does not go out");
    f.self_test.done = 0x1f;
    only_no_go("warning lamp", "not tested");
    f.temperature.temperature_c = NAN;
    only_no_go("thermometer", "no reading");
    f.fault[MR_FAULT_BLOCK_LATE].count = 9;
    f.fault_increase[MR_FAULT_BLOCK_LATE] = 2;
    only_no_go("faults", mr_fault_text(MR_FAULT_BLOCK_LATE));
    f.alarm.state = MR_CAN_UNPLUGGED;
    only_no_go("CAN", mr_can_state_text(MR_CAN_UNPLUGGED));
    f.can_lost_count = 1;
    only_no_go("CAN", "1 lost");
    f.can_frame_count = 0;
    only_no_go("CAN", "0 frames");
    f.can_frame_count = 10;
    f.can_base = 0x190;
    f.identity.uid[0] = 0x00310042;
    only_no_go("CAN",
               "frames not from this board at base 0x190: the UID is unknown on CAN and 00310042");
    f.can_frame_count = 10;
    f.can_base = 0x190;
    f.identity.uid[0] = 0x00310042;
    f.board_on_can.uid[0] = 0x00310043;
    only_no_go("CAN", "another board at base 0x190: the UID is 0031004300000000");
    f.serial_dropped_count = 1;
    only_no_go("serial", "1 dropped");
    snprintf(f.database_fault, sizeof f.database_fault, "read-only");
    only_no_go("database", "read-only");
}

TEST_IN(what_was_not_done_is_no_reason, all_well, NULL)
{
    f.has_previous_landing = f.is_can_used = false;
    f.alarm.state = MR_CAN_UNPLUGGED; /* nobody wants CAN */
    f.time_fit.refusal = TIMEMAP_WRONG_RATE;
    f.config.channel[0].calibrated_day = 0;
    f.fault[MR_FAULT_WATCHDOG_RESET].count = 1; /* of some time before */
    /* less than 1 % and three errors from 40.1: 0.401 + 0.15 */
    f.shunts.result[0].span_lb = 40.5f;
    ready_check_all(&f, &report);
    assert_int_equal(ready_verdict(&report), READY_GO);
    assert_int_equal(ready_count_checks(&report, READY_NOT_DONE), 5);
    assert_int_equal(check_named("CAN")->verdict, READY_NOT_DONE);
    assert_non_null(strstr(check_named("faults")->value, mr_fault_text(MR_FAULT_WATCHDOG_RESET)));
    memset(&report, 0, sizeof report); /* nothing was looked at: that is no go */
    assert_int_equal(ready_verdict(&report), READY_NO_GO);
}

/* Codes 100 and 104 in turn: mean 102, standard deviation sqrt(n / (n - 1)) * 2; 0.1 lb per code
 * from 2 on: 10 lb. */
TEST_IN(mean_and_noise, all_well, NULL)
{
    static struct mr_block blocks[50];
    struct mr_config config = {0};
    struct ready_channel channel;
    memset(blocks, 0, sizeof blocks);
    config.channel[8] = (struct mr_channel_config){
        .kind = MR_KIND_TENSION, .number = 1, .unit_per_code = 0.1f, .zero_code = 2.0f};
    for (unsigned i = 0; i < 50; i++) {
        blocks[i].sum[0] = (uint16_t)(8u * (i % 2 ? 100u : 104u));
        blocks[i].sum[MR_ADC1_REFERENCE] = 8u * 3103u;
    }
    ready_summarize_channel(&config, blocks, 50, 8, &channel);
    assert_near(channel.mean, 10.0, 1e-5);
    assert_near(channel.noise_codes, 2.0 * sqrt(50.0 / 49.0), 1e-4);
    assert_int_equal(channel.invalid_count, 0);
    blocks[7].sum[MR_ADC1_REFERENCE] = 0;
    ready_summarize_channel(&config, blocks, 50, 8, &channel);
    assert_int_equal(channel.invalid_count, 1);
    assert_int_equal(channel.validity, MR_INVALID_REFERENCE);
    ready_summarize_channel(&config, blocks, 0, 8, &channel);
    assert_true(isnan(channel.mean));
}

/* ---- the walk ---- */

static struct walk_test walk;

static void walked(unsigned fitted, const char *answers)
{
    static struct mr_config config;
    memset(&config, 0, sizeof config);
    for (unsigned i = 0; i < fitted; i++)
        config.gate[i].step_codes = (uint16_t)(64 + 8 * i);
    walk_start(&walk, &config);
    for (const char *p = answers; *p; p++)
        walk_add_edge(&walk,
                      &(struct mr_edge){.position = (uint8_t)(*p - 'a' + 1), .step_codes = 70.0f});
    memset(&report, 0, sizeof report);
    walk_check_responses(&walk, &report);
}

TEST_IN(an_order_is_compared_with_what_is_fitted, all_well, NULL)
{
    walked(6, "abcdef");
    assert_int_equal(ready_verdict(&report), READY_GO);
    assert_string_equal(check_named("switch walk")->value, "all 6 responded, in order");
    assert_true(walk_is_complete(&walk));
    walked(6, "fedcba"); /* from the other end */
    assert_int_equal(ready_verdict(&report), READY_GO);
    walked(6, "abbgcdef"); /* one twice, one that is not fitted */
    assert_int_equal(ready_verdict(&report), READY_GO);
    walked(6, "abdcef");
    assert_int_equal(report.count, 2);
    assert_string_equal(check_named("switch 3")->value, "responded in the place of number 4");
    assert_string_equal(check_named("switch 4")->value, "responded in the place of number 3");
    walked(6, "fecdba");
    assert_int_equal(report.count, 2);
    assert_string_equal(check_named("switch 4")->value, "responded in the place of number 3");
    walked(6, "abdef");
    assert_int_equal(report.count, 1);
    assert_string_equal(check_named("switch 3")->value, "did not respond");
    assert_false(walk_is_complete(&walk));
    walked(6, "abdfe"); /* one dead, two swapped */
    assert_int_equal(report.count, 3);
    assert_string_equal(check_named("switch 5")->value, "responded in the place of number 6");
    walked(6, ""); /* nobody walked along them */
    assert_int_equal(report.count, 1);
    assert_int_equal(report.check[0].verdict, READY_NOT_DONE);
    walked(0, ""); /* none fitted */
    assert_int_equal(report.count, 0);
}

/* Switches 1 and 2 trip, each with a bounce, an edge without a step and an event of neither. */
TEST_IN(a_bounce_is_no_answer, all_well, NULL)
{
    walk_start(&walk, &f.config);
    for (unsigned n = 1; n <= 2; n++) {
        for (unsigned i = 0; i < 4; i++)
            walk_add_edge(&walk, &(struct mr_edge){.count = (uint8_t)n,
                                                   .position = (uint8_t)n,
                                                   .step_codes = i == 1 ? 0.5f
                                                               : i == 2 ? NAN
                                                                        : 64.0f});
        walk_add_event(&walk,
                       &(struct mr_switch_event){.reason = MR_SWITCH_BOUNCE, .count = (uint8_t)n});
        walk_add_event(&walk, &(struct mr_switch_event){.reason = MR_SWITCH_BOUNCE,
                                                        .count = (uint8_t)(n - 1)});
    }
    assert_int_equal(walk.response_count[WALK_SWITCH], 2);
    assert_int_equal(walk.unexpected_event_count, 0);
}

/* ---- movements ---- */

static struct walk_motion motion;

/* `rows` readings with channel k at v[k] and a noise of +- 1/10 of the limit; the channel named
 * meanwhile. */
static unsigned feed(const float v[3], unsigned rows)
{
    unsigned named = 0;
    for (unsigned i = 0; i < rows; i++) {
        float row[3];
        for (unsigned c = 0; c < 3; c++)
            row[c] = v[c] + ((i + c) % 2 ? 0.005f : -0.005f);
        unsigned now = walk_motion_add(&motion, row);
        assert_false(now && named);
        named = now ? now : named;
    }
    return named;
}

TEST_IN(the_one_that_moved_most_is_meant, all_well, NULL)
{
    walk_motion_start(&motion, 3, 0.05f);
    /* where it stood before is no movement */
    assert_int_equal(feed((float[]){1.0f, 0.0f, -1.0f}, 100), 0);
    assert_int_equal(feed((float[]){1.08f, 0.2f, -0.92f}, 20), 0);
    assert_int_equal(feed((float[]){1.0f, 0.0f, -1.0f}, 40), 2);
    /* it stays where it was pushed to: once */
    assert_int_equal(feed((float[]){1.0f, 0.0f, -1.3f}, 100), 3);
    assert_int_equal(feed((float[]){1.0f, 0.0f, -1.3f}, 100), 0);
    assert_int_equal(feed((float[]){1.03f, 0.0f, -1.3f}, 100), 0); /* less than the limit */
    assert_int_equal(feed((float[]){1.03f, NAN, -1.3f}, 100), 0);  /* not valid is no movement */
    assert_int_equal(feed((float[]){1.2f, NAN, -1.3f}, 100), 1);
}

/* What rounds to nothing has no sign; SI units are asked for with --si; lines fit. */
TEST_IN(numbers_are_for_people, all_well, NULL)
{
    char *text;
    size_t length;
    f.channel[0].mean = -0.00004f;
    f.channel[22].mean = 61.99f;
    ready_check_all(&f, &report);
    assert_non_null(strstr(check_named("transducer 1")->value, "+0.0000 in from its zero"));
    assert_non_null(strstr(check_named("switches")->value, "the staircase is 0.0 codes"));
    f.si = true;
    f.channel[0].mean = 0.1f;
    ready_check_all(&f, &report); /* 101 lb are 449.27 N, 0.1 in 2.54 mm */
    assert_non_null(strstr(check_named("transducer 1")->value, "+2.540 mm from its zero"));
    assert_non_null(strstr(check_named("gage 1")->value, "449.3 N"));
    assert_string_equal(check_named("gage 1")->limit, "445 +- 111 N, 3 codes");
    for (unsigned columns = 60; columns < 200; columns += 20) {
        FILE *out = open_memstream(&text, &length);
        ready_print(&report, 1.0, columns, out);
        fclose(out);
        for (const char *line = text; *line; line += strcspn(line, "\n") + 1)
            assert_true(strcspn(line, "\n") <= columns);
        free(text);
    }
}

/* As a board of an older firmware may hold it. */
TEST_IN(an_impossible_gain_is_no_go, all_well, NULL)
{
    f.config.channel[0].unit_per_code = 25.4f * 0.0016f;
    only_no_go("calibration d1",
               "no sensor of the rig has such a gain; the unit of the values may have been mm");
}
