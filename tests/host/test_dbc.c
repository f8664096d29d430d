/* The DBC: signals decoded by its own text, on bytes worked out by hand. */
#include <math.h>
#include <stdlib.h>

#include "host/exchange/export.h"
#include "tests/host/scratch.h"

static char *text;

static int write_text(void **state)
{
    size_t length;
    FILE *out = open_memstream(&text, &length);
    (void)state;
    dbc_write(out, 0);
    return fclose(out);
}

static int free_text(void **state)
{
    (void)state;
    free(text);
    return 0;
}

struct signal {
    unsigned start, length;
    char sign;
    double factor, offset, low, high;
    char unit[20];
};

/* Reads the signal's line as a tool would; fails when it is not well formed. */
static struct signal find(unsigned id, const char *message, const char *name)
{
    struct signal s = {0};
    char head[80], line[80];
    snprintf(head, sizeof head, "\nBO_ %u %s: ", id, message);
    const char *at = strstr(text, head);
    if (!at)
        fail_msg("no message %s", head);
    const char *end = strstr(at + 1, "\nBO_ ");
    snprintf(line, sizeof line, "\n SG_ %s : ", name);
    const char *signal = strstr(at, line);
    if (!signal || (end && signal > end))
        fail_msg("no signal %s in %s", name, message);
    char one;
    int got = sscanf(signal + strlen(line), "%u|%u@%c%c (%lf,%lf) [%lf|%lf] \"%19[^\"]\"", &s.start,
                     &s.length, &one, &s.sign, &s.factor, &s.offset, &s.low, &s.high, s.unit);
    assert_true(got >= 8);
    assert_int_equal(one, '1'); /* little-endian */
    return s;
}

/* Value of a signal in a payload, by the rules of the format: bit 0 is the lowest of byte 0. */
static double decode(const struct signal *s, const uint8_t *payload)
{
    uint64_t raw = 0;
    for (unsigned i = 0; i < s->length; i++) {
        unsigned bit = s->start + i;
        raw |= (uint64_t)(payload[bit / 8] >> (bit % 8) & 1u) << i;
    }
    int64_t value = (int64_t)raw;
    if (s->sign == '-' && raw >> (s->length - 1) & 1u)
        value -= (int64_t)1 << s->length;
    return s->offset + s->factor * (double)value;
}

TEST(motion_and_command)
{
    /* 12.5 ft of 500 counts = 6250 = 0x186A; 30.123 ft/s = 30123 = 0x75AB; -2 ft/s2 = -1000 =
     * 0xFC18 */
    const uint8_t motion[8] = {0x6A, 0x18, 0xAB, 0x75, 0x18, 0xFC, 0, 0};
    /* survey, segment 12, tag 258, 3050 counts */
    const uint8_t command[8] = {5, 12, 0x02, 0x01, 0xEA, 0x0B, 0, 0};
    struct signal x = find(0x91, "motion", "position_ft"), v = find(0x91, "motion", "speed_ft_s");
    struct signal a = find(0x91, "motion", "deceleration_ft_s2"),
                  argument = find(0x400, "command", "argument");
    struct signal index = find(0x400, "command", "index"), tag = find(0x400, "command", "tag");
    assert_near(decode(&x, motion), 12.5, 1e-9);
    assert_near(decode(&v, motion), 30.123, 1e-9);
    assert_near(decode(&a, motion), -2.0, 1e-9);
    assert_near(decode(&argument, command), 3050.0, 0.0);
    assert_near(decode(&index, command), 12.0, 0.0);
    assert_near(decode(&tag, command), 258.0, 0.0);
    assert_int_equal(argument.sign, '-');
    assert_non_null(strstr(text, "\nBO_ 1024 command: 8 HOST\n"));
}

TEST(floats_and_names)
{
    struct signal station = find(0x1f7, "switch_place", "station_ft");
    assert_int_equal(station.start, 32);
    assert_int_equal(station.length, 32);
    assert_non_null(strstr(text, "\nSIG_VALTYPE_ 503 station_ft : 1;\n"));
    assert_non_null(strstr(text, "\nSIG_VALTYPE_ 502 zero_code : 1;\n"));
    assert_non_null(strstr(text, "\nVAL_ 256 d1_in -32768 \"missing\" ;\n"));
    assert_null(strstr(text, "SIG_VALTYPE_ 256"));
    assert_non_null(strstr(
        text,
        "\nVAL_ 160 state 0 \"idle\" 1 \"armed\" 2 \"landing\" 3 \"settling\" 4 \"done\" ;\n"));
    assert_non_null(strstr(text, "\nVAL_ 176 code 1 \"state\" 2 \"arm\" 3 \"disarm\" 4 \"mark\" 5 "
                                 "\"survey\" 6 \"bootrom\" 7 \"reset\" 8 \"self-test\" ;\n"));
    /* A state has its names wherever it stands, a validity that no message carries none, and bits
     * are no values. */
    assert_non_null(strstr(
        text,
        "\nVAL_ 496 state 0 \"idle\" 1 \"armed\" 2 \"landing\" 3 \"settling\" 4 \"done\" ;\n"));
    assert_non_null(strstr(text, "\nVAL_ 233 validity 0 \"valid\" 2 \"saturated\" "));
    assert_null(strstr(text, "\nVAL_ 496 reset_cause"));
    assert_non_null(strstr(text, "\nCM_ SG_ 496 reset_cause \"bit 0 power, 1 pin, "));
    assert_non_null(strstr(text, " 19 \"the watchdog reset the board\" "));
    assert_non_null(strstr(text, "\nBU_: BOARD HOST\n"));
}

TESTS_BETWEEN(write_text, free_text);
