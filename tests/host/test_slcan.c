/* SLCAN against lines of the LAWICEL CANUSB manual, and against noise. */
#include "host/link/can_error.h"
#include "host/link/slcan.h"
#include "tests/host/scratch.h"

/* The kinds that `text` gives, one character each. */
static const char *kinds_of(struct slcan_parser *parser, const char *text, size_t length)
{
    static const char letters[] = "-FDRSAG"; /* in the order of enum slcan_kind */
    static char out[4096];
    size_t n = 0;
    for (size_t i = 0; i < length && n + 1 < sizeof out; i++) {
        enum slcan_kind kind = slcan_push(parser, text[i]);
        if (kind != SLCAN_MORE)
            out[n++] = letters[kind];
    }
    out[n] = '\0';
    return out;
}

static void parse(const char *text, const char *kinds, struct slcan_parser *parser)
{
    memset(parser, 0, sizeof *parser);
    if (strcmp(kinds_of(parser, text, strlen(text)), kinds) != 0)
        fail_msg("'%s' gives %s, expected %s", text, kinds_of(parser, text, strlen(text)), kinds);
}

static void lines_of_the_manual(void **state)
{
    struct slcan_parser p;
    (void)state;
    parse("t10021133\r", "F", &p);
    assert_int_equal(p.frame.id, 0x100);
    assert_int_equal(p.frame.length, 2);
    assert_memory_equal(p.frame.data, "\x11\x33\0\0\0\0\0\0", 8);
    assert_int_equal(p.stamp_ms, SLCAN_STAMP_NONE);
    parse("T0000010021133\r", "F", &p);
    assert_true(p.frame.id == (0x100u | LINK_ID_EXTENDED));
    parse("t12338a1B2C3D4E\r", "F", &p); /* three bytes and a time */
    assert_int_equal(p.stamp_ms, 0x3d4e);
    parse("t12388a1B2C3D4E5\r", "G", &p); /* length 8, but 5 bytes and a half */
    parse("r1238\r", "F", &p);
    assert_true(p.frame.id == (0x123u | LINK_ID_REMOTE));
    assert_int_equal(p.frame.length, 8);
    parse("R1F3344550\r", "F", &p);
    assert_true(p.frame.id == (0x1f334455u | LINK_ID_EXTENDED | LINK_ID_REMOTE));
    assert_int_equal(p.frame.length, 0);
    parse("t7FF80102030405060708EA5F\r", "F", &p);
    assert_int_equal(p.frame.id, 0x7ff);
    assert_int_equal(p.frame.data[7], 8);
    assert_int_equal(p.stamp_ms, 59999);
    parse("t10001234\r", "F", &p);
    assert_int_equal(p.stamp_ms, 0x1234);
    parse("F28\r", "S", &p);
    assert_int_equal(p.status, 0x28);
    parse("\rz\rZ\r\a", "DDDR", &p);
    parse("V1013\rNA123\rv0107\r", "AAA", &p);
}

static void lines_that_are_none(void **state)
{
    static const char *const lines[] = {
        "t80011\r",         /* 11 bits end at 7FF */
        "T2000000011122\r", /* 29 bits end at 1FFFFFFF */
        "t1009\r",          /* 9 bytes */
        "t1g01\r",          /* no digit */
        "t1001\r",          /* a byte is missing */
        "t1001112\r",       /* three digits of a time */
        "t10011EA60X\r",    /* more after the time */
        "t100111EA60\r",    /* the clock ends at EA5F */
        "t1001112345678\r", /* more after the time */
        "x\r",              /* nothing of the protocol */
        "F0\r",             /* half a flag byte */
        "Fzz\r",
        "zz\r",
        "t100\a", /* refused in mid-line */
        "T1F33445581122334455667788EA5F0\r",
    };
    struct slcan_parser p;
    (void)state;
    for (size_t i = 0; i < COUNT_OF(lines); i++)
        parse(lines[i], "G", &p);
}

/* Whatever came before, the first whole line after a CR counts. */
static void noise_ends_at_the_next_line(void **state)
{
    uint32_t seed = 7;
    (void)state;
    for (unsigned round = 0; round < 20000; round++) {
        struct slcan_parser p = {0};
        char noise[100];
        seed = seed * 1664525u + 1013904223u;
        size_t length = (seed >> 16) % sizeof noise;
        for (size_t i = 0; i < length; i++) {
            seed = seed * 1664525u + 1013904223u;
            /* every other round with the protocol's own characters */
            noise[i] = round & 1 ? "tTrRF0123456789ABCDEFzZ\r\a"[(seed >> 16) % 25]
                                 : (char)(seed >> 24);
        }
        kinds_of(&p, noise, length);
        slcan_push(&p, '\r');
        assert_string_equal(kinds_of(&p, "t1232ABCD0001\r", 14), "F");
        assert_int_equal(p.frame.id, 0x123);
        assert_int_equal(p.frame.data[1], 0xcd);
        assert_int_equal(p.stamp_ms, 1);
    }
}

/* A line cut anywhere is garbled or another valid line, never an accepted frame with a wrong
 * tail. */
static void cut_lines(void **state)
{
    static const char line[] = "t12381122334455667788EA5F";
    (void)state;
    for (size_t cut = 1; cut < sizeof line - 1; cut++) {
        struct slcan_parser p = {0};
        char text[40];
        snprintf(text, sizeof text, "%.*s\r", (int)cut, line);
        const char *kind = kinds_of(&p, text, strlen(text));
        if (cut == 21) /* just without the time */
            assert_string_equal(kind, "F");
        else
            assert_string_equal(kind, "G");
    }
}

static void frames_there_and_back(void **state)
{
    static const struct {
        struct link_frame frame;
        const char *line;
    } cases[] = {
        {{.id = 0x100, .length = 2, .data = {0x11, 0x33}}, "t10021133\r"},
        {{.id = 0x7ff, .length = 0}, "t7FF0\r"},
        {{.id = 0x1f334455u | LINK_ID_EXTENDED, .length = 1, .data = {0xee}}, "T1F3344551EE\r"},
        {{.id = 0x123u | LINK_ID_REMOTE, .length = 8}, "r1238\r"},
        {{.id = 1u | LINK_ID_EXTENDED | LINK_ID_REMOTE, .length = 3}, "R000000013\r"},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct slcan_parser p = {0};
        char line[SLCAN_LINE_MAX];
        assert_int_equal(slcan_print(&cases[i].frame, line), strlen(cases[i].line));
        assert_string_equal(line, cases[i].line);
        assert_string_equal(kinds_of(&p, line, strlen(line)), "F");
        assert_true(p.frame.id == cases[i].frame.id);
        assert_memory_equal(p.frame.data, cases[i].frame.data, 8);
    }
    struct link_frame longest = {.id = 0x1fffffffu | LINK_ID_EXTENDED, .length = 8};
    char line[SLCAN_LINE_MAX];
    assert_int_equal(slcan_print(&longest, line), 27);
}

/* Flags of the manual: bit 0 receive FIFO full, 1 transmit FIFO full, 2 warning, 3 overrun, 5
 * passive, 6 arbitration lost, 7 bus error. */
static void status_flags(void **state)
{
    static const struct {
        uint8_t flags;
        uint32_t troubles;
    } cases[] = {
        {0x01, 1u << LINK_RX_OVERFLOW},
        {0x02, 1u << LINK_TX_OVERFLOW},
        {0x04, 1u << LINK_ERROR_WARNING},
        {0x08, 1u << LINK_RX_OVERFLOW},
        {0x20, 1u << LINK_ERROR_PASSIVE},
        {0x40, 1u << LINK_ARBITRATION_LOST},
        {0x80, 1u << LINK_BUS_ERROR},
        {0xa4, 1u << LINK_ERROR_WARNING | 1u << LINK_ERROR_PASSIVE | 1u << LINK_BUS_ERROR},
    };
    struct link_frame frame;
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        assert_true(slcan_status_frame(cases[i].flags, &frame));
        assert_true(frame.id & LINK_ID_ERROR);
        assert_int_equal(can_error_troubles(&frame), cases[i].troubles);
    }
    assert_false(slcan_status_frame(0, &frame));
    assert_false(slcan_status_frame(0x10, &frame)); /* not used */
}

/* An adapter that is 50 ppm fast sends for ten minutes; frames take 2 ms plus up to 30 ms to the
 * host. */
static void adapter_clock(void **state)
{
    struct slcan_clock clock = {0};
    const uint64_t start_us = 1700000000000000u;
    uint32_t seed = 3;
    (void)state;
    for (unsigned i = 0; i < 60000; i++) {
        uint64_t true_us = start_us + 10000u * i;
        uint64_t adapter_us = 12345678u + (uint64_t)(10000.0 * i * (1.0 + 50e-6));
        seed = seed * 1664525u + 1013904223u;
        uint64_t host_us = true_us + 2000 + (seed >> 16) % 30000;
        uint64_t got_us = slcan_time(&clock, (unsigned)(adapter_us / 1000 % 60000), host_us);
        assert_true(got_us <= host_us);
        /* 1 ms of the stamp, 2 ms of the least delay, 0.5 ms that 50 ppm make in 10 s, and what the
         * least of 500 delays may exceed the least possible by: 30 ms / 500, ten times over. Before
         * 100 have come, less. */
        int64_t error_us = (int64_t)(got_us - true_us);
        if (i > 100)
            assert_true(error_us > -2000 && error_us < 5000);
    }
    /* A silence of any length, the wrap included: 7 minutes and 1 s. */
    uint64_t before_us = slcan_time(&clock, 100, start_us + 600000000u);
    uint64_t after_us = slcan_time(&clock, 1100, start_us + 600000000u + 421000000u);
    assert_near((double)(after_us - before_us), 421e6, 40e3);
    assert_int_equal(slcan_time(&clock, SLCAN_STAMP_NONE, 42), 42);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lines_of_the_manual),
        cmocka_unit_test(lines_that_are_none),
        cmocka_unit_test(noise_ends_at_the_next_line),
        cmocka_unit_test(cut_lines),
        cmocka_unit_test(frames_there_and_back),
        cmocka_unit_test(status_flags),
        cmocka_unit_test(adapter_clock),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
