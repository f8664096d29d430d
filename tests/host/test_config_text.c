/* The configuration as text: bit for bit there and back, whatever the values; days against the C
 * library's calendar. */
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "host/board/config_text.h"
#include "tests/cmocka_all.h"
#include "tests/common/sound_config.h"

static uint8_t image[MR_CONFIG_IMAGE_BYTES], again[MR_CONFIG_IMAGE_BYTES];

static void comes_back(const struct mr_config *c)
{
    struct mr_config back;
    struct error error = {0};
    char *text = config_text_write(c);
    if (config_text_read(text, "text", &back, &error) != MR_OK)
        fail_msg("%s", error.text);
    mr_config_encode(c, image);
    mr_config_encode(&back, again);
    assert_memory_equal(again, image, sizeof image);
    free(text);
}

static uint32_t random_state = 1;
static uint32_t draw(void)
{
    random_state = random_state * 1664525u + 1013904223u;
    return random_state >> 8 ^ random_state << 16;
}

/* Any bits that are a number within the limits, tiny and negative zero among them. */
static float draw_real(float low, float high)
{
    for (;;) {
        uint32_t bits = draw() ^ draw() << 13;
        float value;
        memcpy(&value, &bits, 4);
        if (value >= low && value <= high)
            return value;
    }
}

TEST(reals_come_back_bit_for_bit)
{
    struct mr_config c = sound_config();
    comes_back(&c);
    for (int round = 0; round < 200; round++) {
        c.site[0].touchdown_ft = draw_real(-100.0f, 1000.0f);
        c.site[0].camera_station_ft = round % 3 ? draw_real(-100.0f, 1000.0f) : MR_NAN;
        for (unsigned i = 0; i < MR_CHANNELS; i++) {
            /* within what common/gain.h takes for low to high of 6.1 */
            if (mr_channel_is_sensor(&c.channel[i]))
                c.channel[i].unit_per_code = i < MR_TRANSDUCERS ? draw_real(0.001f, 0.013f)
                                                                : draw_real(0.01f, 0.06f);
            else
                c.channel[i].unit_per_code = draw_real(1e-30f, 1000.0f);
            c.channel[i].zero_error = draw_real(0.0f, 1000.0f);
            c.channel[i].rate_limit_per_s = draw_real(0.0f, 1e6f);
            for (unsigned k = 3; k < MR_CONFIG_POINTS; k++)
                c.channel[i].point_value[k] = draw_real(-10000.0f, 10000.0f);
        }
        comes_back(&c);
    }
    c.site[0].touchdown_ft = -0.0f;
    c.site[0].revision = UINT32_MAX;
    comes_back(&c);
}

TEST(texts_come_back)
{
    struct mr_config c = sound_config();
    for (int first = ' '; first <= '~'; first++) {
        memset(c.site[0].name, 0, sizeof c.site[0].name);
        c.site[0].name[0] = (char)first;
        c.site[0].name[1] = '\\';
        c.site[0].name[2] = (char)first;
        comes_back(&c);
    }
    memset(c.site[0].name, '"', sizeof c.site[0].name);
    comes_back(&c);
    memset(c.site[0].name, 0, sizeof c.site[0].name);
    comes_back(&c);
}

/* Every day up to the limit is written as the C library has it. */
TEST(days_are_those_of_the_calendar)
{
    struct mr_config c = sound_config();
    for (unsigned i = 0; i < MR_CHANNELS; i++)
        c.channel[i].expires_day = 0;
    for (uint32_t day = 1; day <= 100000; day += 24u) {
        char expected[80];
        for (unsigned i = 0; i < MR_CHANNELS; i++)
            c.channel[i].calibrated_day = day + i > 100000 ? 100000 : day + i;
        char *text = config_text_write(&c);
        for (unsigned i = 0; i < MR_CHANNELS; i++) {
            time_t t = (time_t)c.channel[i].calibrated_day * 86400;
            struct tm tm;
            gmtime_r(&t, &tm);
            snprintf(expected, sizeof expected, "channel[%u].calibrated_day = %04d-%02d-%02d\n",
                     i + 1, tm.tm_year + 1900, tm.tm_mon + 1, tm.tm_mday);
            if (!strstr(text, expected))
                fail_msg("not written: %s", expected);
        }
        free(text);
        if (day < 1000 || day > 99900)
            comes_back(&c);
    }
}

TEST(order_and_blanks_do_not_matter)
{
    struct mr_config c = sound_config(), back;
    struct error error = {0};
    char *text = config_text_write(&c), *turned = NULL, *line[2000], *rest = NULL;
    size_t size, lines = 0;
    FILE *out = open_memstream(&turned, &size);
    for (char *p = strtok_r(text, "\n", &rest); p; p = strtok_r(NULL, "\n", &rest))
        line[lines++] = p;
    while (lines-- > 0)
        fprintf(out, "  \t%s   # tail \"'=\r\n\n", line[lines]);
    fclose(out);
    assert_int_equal(config_text_read(turned, "turned", &back, &error), MR_OK);
    assert_int_equal(mr_config_encode(&back, again), mr_config_encode(&c, image));
    free(text);
    free(turned);
}

static void is_said(struct mr_config_violation reason, const char *expected)
{
    struct mr_config c = sound_config();
    char text[500];
    config_text_reason(&c, &reason, text, sizeof text);
    if (!strstr(text, expected))
        fail_msg("said: %s\nexpected: %s", text, expected);
}

/* What a board refuses, in words; also what it has no words for. */
TEST(a_reason_is_said_in_words)
{
    is_said(
        (struct mr_config_violation){.group = MR_GROUP_gate,
                                     .index = 7,
                                     .field = MR_FIELD_gate_station_ft,
                                     .rule = MR_RULE_NOT_RISING},
        "gate[8].station_ft is 32.5, gate[1].station_ft is -2.5: the first value must be larger");
    is_said((struct mr_config_violation){.group = MR_GROUP_site,
                                         .field = MR_FIELD_site_revision,
                                         .rule = MR_RULE_REVISION},
            "site.revision is 7: must be the active revision plus 1");
    is_said((struct mr_config_violation){.group = MR_GROUP_channel,
                                         .index = 3,
                                         .field = MR_FIELD_channel_point_value,
                                         .element = 2,
                                         .rule = MR_RULE_NOT_RISING,
                                         .other = 1},
            "value 3 of channel[4].point_value is -2.00999999 0.1");
    is_said((struct mr_config_violation){.group = MR_GROUP_gate,
                                         .index = 3,
                                         .field = MR_FIELD_gate_step_codes,
                                         .rule = MR_RULE_STEPS_TOO_CLOSE,
                                         .other = 2},
            "gate[4].step_codes is 232, gate[3].step_codes is 176: the board cannot distinguish "
            "these switches; "
            "give steps that differ by 6 codes or more");
    is_said((struct mr_config_violation){.group = 200, .index = 1, .field = 2, .rule = 77},
            "group 200, index 1, field 2: unknown rule");
    is_said((struct mr_config_violation){.group = MR_GROUP_site, .index = 1}, "group 0, index 1");
    is_said(
        (struct mr_config_violation){
            .group = MR_GROUP_gate, .field = 1, .rule = MR_RULE_STEPS_TOO_CLOSE, .other = 99},
        "too close to the step of another switch");
}

static unsigned changes;
static void count_change(void *context, const char *field, const char *old, const char *new)
{
    (void)context;
    changes++;
    assert_string_equal(field, "band[4].yield_lb");
    assert_string_equal(old, "0");
    assert_string_equal(new, "12.5");
}

TEST(differences_are_named)
{
    struct mr_config a = sound_config(), b = a;
    b.band[3].yield_lb = 12.5f;
    assert_int_equal(config_text_compare(&a, &a, count_change, NULL), 0);
    assert_int_equal(config_text_compare(&a, &b, count_change, NULL), 1);
    assert_int_equal(changes, 1);
}

/* Removes the lines that begin with `field`. */
static void without(char *text, const char *field)
{
    char *line;
    while ((line = strstr(text, field)) != NULL) {
        char *next = strchr(line, '\n') + 1;
        memmove(line, next, strlen(next) + 1);
    }
}

/* A text of before brake and wheel could be fitted: neither is. Of other fields each is needed. */
TEST(a_text_of_before_has_no_wheel)
{
    struct mr_config c = sound_config(), back;
    struct error error = {0};
    char *text = config_text_write(&c);
    without(text, "site.brake_edge =");
    without(text, "site.wheel_pulses =");
    without(text, "site.wheel_radius_ft =");
    without(text, "site.wheel_radius_error_ft =");
    assert_int_equal(config_text_read(text, "text", &back, &error), MR_OK);
    c.site[0].brake_edge = c.site[0].wheel_pulses = 0;
    c.site[0].wheel_radius_ft = c.site[0].wheel_radius_error_ft = 0.0f;
    mr_config_encode(&c, image);
    mr_config_encode(&back, again);
    assert_memory_equal(again, image, sizeof image);
    without(text, "site.can_base =");
    assert_int_equal(config_text_read(text, "text", &back, &error), MR_MALFORMED);
    assert_non_null(strstr(error.text, "site.can_base is missing"));
    free(text);
}
