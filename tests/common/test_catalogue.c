#include "common/catalogue.h"

#include <math.h>
#include <string.h>

#include "common/command.h"
#include "tests/cmocka_all.h"

/* Bytes worked out by hand from catalogue.def, little-endian. */
static void messages_put_the_bytes_worked_out_by_hand(void **state)
{
    (void)state;
    uint8_t out[MR_MESSAGE_MAX];

    /* 35.5 ft/s * 1000 = 35500 = 0x8aac; 0.0125 * 10000 = 125; 7.9 * 1000 = 7900 = 0x1edc; 0.05 * 10000 = 500 = 0x01f4 */
    const uint8_t touchdown[] = {0xac, 0x8a, 0x7d, 0x00, 0xdc, 0x1e, 0xf4, 0x01};
    assert_int_equal(mr_touchdown_put(&(struct mr_touchdown){35.5f, 0.0125f, 7.9f, 0.05f}, out), 8);
    assert_memory_equal(out, touchdown, 8);

    /* -0.3312 in * 10000 = -3312 = 0xf310; missing = 0x8000; 4 in clips to 32767 */
    const uint8_t displacement[] = {0x10, 0xf3, 0x00, 0x80, 0xff, 0x7f, 0x34, 0x12};
    assert_int_equal(mr_displacement_1_3_put(&(struct mr_displacement_1_3){-0.3312f, NAN, 4.0f, 0x1234}, out), 8);
    assert_memory_equal(out, displacement, 8);

    const uint8_t edge[] = {0xef, 0xbe, 0xad, 0xde, 17, 3, 0x64, 0x03}; /* 108.5 * 8 = 868 = 0x364 */
    assert_int_equal(mr_edge_put(&(struct mr_edge){0xdeadbeefu, 17, 3, 108.5f}, out), 8);
    assert_memory_equal(out, edge, 8);

    const uint8_t zero[] = {4, 5, 0, 0, 0x00, 0x00, 0x80, 0xbf}; /* -1.0f is 0xbf800000 */
    assert_int_equal(mr_channel_zero_put(&(struct mr_channel_zero){4, 5, 0, 0, -1.0f}, out), 8);
    assert_memory_equal(out, zero, 8);
}

static void missing_stays_missing(void **state)
{
    (void)state;
    uint8_t out[MR_MESSAGE_MAX];
    struct mr_zone_lead got;
    size_t length = mr_zone_lead_put(&(struct mr_zone_lead){NAN, 12.5f, 1, 40, 99}, out);
    assert_int_equal(mr_zone_lead_get(&got, out, length), MR_OK);
    assert_true(isnan(got.lead_s));
    assert_near(got.wheel_ft, 12.5, 0.001);
    assert_int_equal(got.warning, 1);
    assert_int_equal(got.block16, 99);
}

static void a_wrong_length_is_refused(void **state)
{
    (void)state;
    uint8_t bytes[16] = {0};
    struct mr_clock clock;
    assert_int_equal(mr_clock_get(&clock, bytes, 7), MR_TRUNCATED);
    assert_int_equal(mr_clock_get(&clock, bytes, 9), MR_TOO_LONG);
    assert_int_equal(mr_clock_get(&clock, bytes, 8), MR_OK);
}

static void the_table_is_consistent(void **state)
{
    (void)state;
    size_t count;
    const struct mr_message_info *messages = mr_catalogue(&count);
    assert_true(count > 20);
    for (size_t m = 0; m < count; m++) {
        unsigned at = 0;
        assert_true(messages[m].id < 0x800);
        if (m > 0)
            assert_true(messages[m].id > messages[m - 1].id);
        for (unsigned f = 0; f < messages[m].field_count; f++) {
            assert_int_equal(messages[m].fields[f].offset, at);
            at += messages[m].fields[f].size;
        }
        assert_int_equal(messages[m].length, at);
        assert_true(at <= 8);
        assert_ptr_equal(mr_message_find(messages[m].id), &messages[m]);
    }
    assert_null(mr_message_find(0x7ff));
}

static void field_values_are_in_units(void **state)
{
    (void)state;
    const uint8_t motion[8] = {0xf4, 0x01, 0x10, 0x27, 0x18, 0xfc, 0xff, 0xff}; /* 500, 10000, -1000, 65535 */
    const struct mr_message_info *info = mr_message_find(MR_ID_MOTION);
    assert_near(mr_field_value(&info->fields[0], motion), 1.0, 1e-9);
    assert_near(mr_field_value(&info->fields[1], motion), 10.0, 1e-9);
    assert_near(mr_field_value(&info->fields[2], motion), -2.0, 1e-9);
    assert_near(mr_field_value(&info->fields[3], motion), 65535.0, 0.0);
    const uint8_t missing[8] = {0xff, 0xff, 0, 0, 0x00, 0x80, 0, 0};
    assert_true(isnan(mr_field_value(&info->fields[0], missing)));
    assert_true(isnan(mr_field_value(&info->fields[2], missing)));
}

static void commands_parse_as_people_write_them(void **state)
{
    (void)state;
    struct mr_command command;
    assert_int_equal(mr_command_parse("survey 12 0.305", 7, &command), MR_OK);
    assert_int_equal(command.code, MR_COMMAND_SURVEY);
    assert_int_equal(command.index, 12);
    assert_int_equal(command.argument, 3050);
    assert_int_equal(command.tag, 7);
    assert_int_equal(mr_command_parse("  arm 5\n", 0, &command), MR_OK);
    assert_int_equal(command.argument, 5);
    assert_int_equal(mr_command_parse("disarm", 0, &command), MR_OK);
    assert_int_equal(mr_command_parse("survey 1 0.00005", 0, &command), MR_OK);
    assert_int_equal(command.argument, 1); /* half a digit rounds up */
    assert_int_equal(mr_command_parse("launch", 0, &command), MR_UNKNOWN);
    assert_int_equal(mr_command_parse("arming", 0, &command), MR_UNKNOWN);
    assert_int_equal(mr_command_parse("arm five", 0, &command), MR_USAGE);
    assert_int_equal(mr_command_parse("arm 5 6", 0, &command), MR_USAGE);
    assert_int_equal(mr_command_parse("survey 300 0.1", 0, &command), MR_USAGE);
    assert_int_equal(mr_command_parse("survey 3", 0, &command), MR_USAGE);
    assert_int_equal(mr_command_parse("arm 99999999999", 0, &command), MR_USAGE);
    assert_int_equal(mr_command_parse("survey 1 300000", 0, &command), MR_USAGE); /* 3e9 steps of 0.0001 in */
    assert_int_equal(mr_command_parse("arm 4.6", 0, &command), MR_USAGE);
    assert_int_equal(mr_command_parse("survey 1.5 0.1", 0, &command), MR_USAGE);
    assert_string_equal(mr_command_name(MR_COMMAND_MARK), "mark");
    assert_string_equal(mr_command_name(200), "unknown");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(messages_put_the_bytes_worked_out_by_hand),
        cmocka_unit_test(missing_stays_missing),
        cmocka_unit_test(a_wrong_length_is_refused),
        cmocka_unit_test(the_table_is_consistent),
        cmocka_unit_test(field_values_are_in_units),
        cmocka_unit_test(commands_parse_as_people_write_them),
    };
    return cmocka_run_group_tests_name("common/catalogue", tests, NULL, NULL);
}
