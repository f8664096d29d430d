/* The run file's parser: reads what the format says, refuses the rest with line and reason. */
#include "common/command.h"
#include "common/crc32.h"
#include "hil/rig/runfile.h"
#include "tests/hil/bench.h"

static char text[65536];

static void line(const char *format, ...) __attribute__((format(printf, 1, 2)));
static void line(const char *format, ...)
{
    va_list arguments;
    size_t n = strlen(text);
    va_start(arguments, format);
    vsnprintf(text + n, sizeof text - n, format, arguments);
    va_end(arguments);
}

/* A complete file, without its end line. */
static void body(void)
{
    text[0] = '\0';
    line("matrig-run 1\n# a comment\nprovenance made up for this test\nlanding 5\n");
    line("duration_s 1.5\ntouchdown 3.0 0.5\n");
    line("truth touchdown_speed_ft_s 35.5\n");
    for (unsigned p = 1; p <= 24; p++) {
        if (p == 2)
            line("switch 2 7.5 7.501 0.123456789\n");
        else
            line("switch %u %.1f %.3f -\n", p, 5.0 * p - 2.5, 5.0 * p - 2.5);
    }
    line("transducer 1 40.0\ngage 14 140 2\ngap_in 0.0001 0.0002\ngap_end_in 0.0001 0.0002\n");
    line("command 0.25 can survey 3 0.305\ncommand 0.5 serial arm 5\n");
    line("samples 4 1000\n");
    line("1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22\nx2\n");
    line("100 2 3 4 5 6 7 8 -900 10 11 12 13 14 15 16 17 18 19 20 21 22\n");
}

static void finish(void)
{
    line("end %08x\n", (unsigned)mr_crc32(0, (const uint8_t *)text, strlen(text)));
}

static enum mr_status read_text(struct hil_run *run, char *error, size_t size)
{
    return hil_run_read(bench_scratch("test.run", text, strlen(text)), run, error, size);
}

static void refused(enum mr_status status, const char *part)
{
    struct hil_run run;
    char error[256] = "";
    assert_int_equal(read_text(&run, error, sizeof error), status);
    assert_non_null(strstr(error, "test.run"));
    if (!strstr(error, part))
        fail_msg("`%s` is not in: %s", part, error);
    assert_null(run.samples);
}

TEST(test_whole)
{
    struct hil_run run;
    char error[256];
    body();
    finish();
    if (read_text(&run, error, sizeof error) != MR_OK)
        fail_msg("%s", error);
    assert_true(run.duration_s == 1.5);
    assert_true(run.switch_open_ps[0] == HIL_RUN_NEVER);
    assert_true(run.switch_open_ps[1] == 123456789000ull);
    assert_true(run.switch_ft[1] == 7.501);
    assert_int_equal(run.command_count, 2);
    assert_int_equal(run.commands[0].message.code, MR_COMMAND_SURVEY);
    assert_int_equal(run.commands[0].message.index, 3);
    assert_int_equal(run.commands[0].message.argument, 3050);
    assert_false(run.commands[0].is_sent_by_serial);
    assert_true(run.commands[1].is_sent_by_serial);
    assert_int_equal(run.commands[1].message.tag, 2);
    assert_true(run.commands[1].t_ps == 500000000000ull);
    assert_int_equal(run.sample_count, 4);
    assert_int_equal(run.samples[2][21], 22);
    assert_int_equal(run.samples[3][8], -900);
    hil_run_free(&run);
}

TEST(test_truncated)
{
    body();
    refused(MR_TRUNCATED, "`end`");
    text[0] = '\0';
    refused(MR_MALFORMED, "does not begin with `matrig-run 1`");
}

TEST(test_foreign)
{
    snprintf(text, sizeof text, "ID3\1\2 some music");
    refused(MR_MALFORMED, "does not begin");
    body();
    text[11] = '2';
    refused(MR_VERSION, "version");
}

TEST(test_damaged)
{
    body();
    finish();
    strstr(text, "100 2 3")[0] = '7';
    refused(MR_CRC, "checksum");
    body();
    finish();
    line("more\n");
    refused(MR_MALFORMED, "as the last line");
}

/* Change one thing, keep the checksum right: the line number is named. */
TEST(test_malformed)
{
    static const struct {
        const char *from, *to, *part;
    } cases[] = {
        {"landing 5", "lending 5", "test.run:4: unknown keyword `lending`"},
        {"duration_s 1.5", "duration_s no!", "test.run:5"},
        {"switch 3 12.5", "switch 9 12.5", "`switch 3 <nominal_ft>"},
        {"0.123456789", "0.12345678x", "test.run:9"},
        {"can survey 3 0.305", "can survey x 0.305", "not a command"},
        {"0.25 can", "0.25 air", "<can or serial>"},
        {"command 0.25", "command 0.75", "order of time"},
        {"samples 4 1000", "samples 4 0000", "rate_hz"},
        {"20 21 22\nx2", "20 21 zz\nx2", "22 integers"},
        {"x2\n", "x9\n", "is not a repeat count"},
        {"samples 4", "samples 5", "4 of 5 samples"},
        {"switch 24", "#witch 24", "23 of 24 switches"},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        body();
        char *place = strstr(text, cases[i].from);
        assert_non_null(place);
        assert_int_equal(strlen(cases[i].from), strlen(cases[i].to));
        memcpy(place, cases[i].to, strlen(cases[i].to));
        finish();
        refused(MR_MALFORMED, cases[i].part);
    }
}
