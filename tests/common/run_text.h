/* Run file reader of the tests of tests/runs: strict, fails the running test on whatever the format
 * does not allow. Made from the format's description, without the writer's code. A header because
 * each test program is one file; include it once. */
#ifndef MATRIG_TESTS_COMMON_RUN_TEXT_H
#define MATRIG_TESTS_COMMON_RUN_TEXT_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/cmocka_all.h"

#define JOINTS      421
#define SWITCHES    24
#define TRANSDUCERS 8
#define GAGES       14
#define CHANNELS    (TRANSDUCERS + GAGES)
#define SAMPLES_MAX 16000
#define TRUTHS_MAX  100
#define SEGMENTS    42

/* One landing. 3 MB: on the heap. */
struct run {
    char *text;
    size_t bytes;
    int landing, switches, transducers, gages, gaps, gap_ends, samples, surveys, others;
    double duration_s, touchdown_ft, touchdown_s;
    struct {
        char name[64];
        double value;
    } truth[TRUTHS_MAX];
    int truths;
    double nominal_ft[SWITCHES], true_ft[SWITCHES], open_s[SWITCHES]; /* NaN: never */
    double transducer_ft[TRANSDUCERS], gage_ft[GAGES];
    int band[GAGES];
    double gap_in[JOINTS], gap_end_in[JOINTS];
    double survey_in[SEGMENTS];
    struct {
        double t_s;
        char link[8], name[16];
        int argument;
    } other[8];
    double last_command_s;
    long row[SAMPLES_MAX][CHANNELS];
};

static int numbers_into(const char *text, double *values, int have)
{
    char *end;

    for (;; text = end, have++) {
        double value = strtod(text, &end);

        if (end == text)
            return have;
        assert_true(have < JOINTS);
        values[have] = value;
    }
}

static void parse_command(struct run *run, const char *line)
{
    double t_s, value = 0.0;
    char link[8], name[16];
    int argument = -1;
    int fields = sscanf(line, "command %lf %7s %15s %d %lf", &t_s, link, name, &argument, &value);

    assert_true(fields >= 3);
    assert_true(t_s >= run->last_command_s);
    run->last_command_s = t_s;
    if (strcmp(name, "survey") == 0) {
        assert_int_equal(fields, 5);
        assert_string_equal(link, "serial");
        assert_int_equal(argument, run->surveys); /* in order, none twice */
        assert_true(fabs(t_s - (0.300 + 0.002 * argument)) < 1e-9);
        assert_in_range(argument, 0, SEGMENTS - 1);
        run->survey_in[run->surveys++] = value;
        return;
    }
    assert_in_range(run->others, 0, 7);
    run->other[run->others].t_s = t_s;
    run->other[run->others].argument = argument;
    memcpy(run->other[run->others].link, link, sizeof link);
    memcpy(run->other[run->others].name, name, sizeof name);
    run->others++;
}

/* Sample rows; returns the line after them. */
static char *parse_rows(struct run *run, char *line, int count)
{
    assert_in_range(count, 2, SAMPLES_MAX);
    while (run->samples < count) {
        char *next = strchr(line, '\n');

        assert_non_null(next);
        if (line[0] == 'x') {
            int times = atoi(line + 1);

            assert_true(run->samples > 0 && times > 0 && run->samples + times <= count);
            for (; times > 0; times--, run->samples++)
                memcpy(run->row[run->samples], run->row[run->samples - 1], sizeof run->row[0]);
        } else {
            char *at = line;

            for (int i = 0; i < CHANNELS; i++) {
                char *end;

                run->row[run->samples][i] = strtol(at, &end, 10);
                assert_true(end > at && end <= next);
                at = end;
            }
            assert_ptr_equal(at, next);
            run->samples++;
        }
        line = next + 1;
    }
    return line;
}

static void parse_line(struct run *run, const char *line)
{
    int i, band;
    double a, b;
    char word[64];

    if (sscanf(line, "switch %d %lf %lf %63s", &i, &a, &b, word) == 4) {
        assert_int_equal(i, ++run->switches);
        assert_in_range(i, 1, SWITCHES);
        run->nominal_ft[i - 1] = a;
        run->true_ft[i - 1] = b;
        run->open_s[i - 1] = strcmp(word, "-") == 0 ? (double)NAN : strtod(word, NULL);
    } else if (sscanf(line, "transducer %d %lf", &i, &a) == 2) {
        assert_int_equal(i, ++run->transducers);
        assert_in_range(i, 1, TRANSDUCERS);
        run->transducer_ft[i - 1] = a;
    } else if (sscanf(line, "gage %d %lf %d", &i, &a, &band) == 3) {
        assert_int_equal(i, ++run->gages);
        assert_in_range(i, 1, GAGES);
        run->gage_ft[i - 1] = a;
        run->band[i - 1] = band;
    } else if (sscanf(line, "truth %63s %lf", word, &a) == 2) {
        assert_in_range(run->truths, 0, TRUTHS_MAX - 1);
        snprintf(run->truth[run->truths].name, sizeof word, "%s", word);
        run->truth[run->truths++].value = a;
    } else if (strncmp(line, "gap_in ", 7) == 0) {
        run->gaps = numbers_into(line + 7, run->gap_in, run->gaps);
    } else if (strncmp(line, "gap_end_in ", 11) == 0) {
        run->gap_ends = numbers_into(line + 11, run->gap_end_in, run->gap_ends);
    } else if (strncmp(line, "command ", 8) == 0) {
        parse_command(run, line);
    } else if (sscanf(line, "touchdown %lf %lf", &run->touchdown_ft, &run->touchdown_s) != 2 &&
               sscanf(line, "duration_s %lf", &run->duration_s) != 1 &&
               sscanf(line, "landing %d", &run->landing) != 1 && line[0] != '#' &&
               strncmp(line, "provenance synthetic", 20) != 0) {
        fail_msg("unknown line: %s", line);
    }
}

/* CRC-32 by long division of the message polynomial, one bit at a time from the top of a reflected
 * register. */
static uint32_t crc_of(const char *bytes, size_t count)
{
    uint32_t rest = 0xFFFFFFFFu;

    for (size_t i = 0; i < count * 8; i++) {
        uint32_t bit = ((unsigned)(unsigned char)bytes[i / 8] >> (i % 8)) & 1u;
        uint32_t carry = (rest & 1u) ^ bit;

        rest >>= 1;
        if (carry)
            rest ^= 0xEDB88320u;
    }
    return rest ^ 0xFFFFFFFFu;
}

/* Read tests/runs/landingN.run; the current directory is the project's root. The caller frees
 * run->text. */
static void load(struct run *run, int number)
{
    char path[64];
    FILE *file;
    char *line, *next;

    snprintf(path, sizeof path, "tests/runs/landing%d.run", number);
    file = fopen(path, "rb");
    if (file == NULL)
        fail_msg("%s does not open: run the tests from the project's root", path);
    assert_int_equal(fseek(file, 0, SEEK_END), 0);
    run->bytes = (size_t)ftell(file);
    rewind(file);
    run->text = malloc(run->bytes + 1);
    assert_non_null(run->text);
    assert_int_equal(fread(run->text, 1, run->bytes, file), run->bytes);
    fclose(file);
    run->text[run->bytes] = '\0';
    for (line = run->text; (next = strchr(line, '\n')) != NULL; line = next + 1) {
        char copy[512];
        int count, rate;
        unsigned crc;

        assert_in_range(next - line, 0, sizeof copy - 1);
        memcpy(copy, line, (size_t)(next - line));
        copy[next - line] = '\0';
        if (line == run->text) {
            assert_string_equal(copy, "matrig-run 1");
        } else if (sscanf(copy, "samples %d %d", &count, &rate) == 2) {
            assert_int_equal(rate, 1000);
            next = parse_rows(run, next + 1, count) - 1;
        } else if (sscanf(copy, "end %8x", &crc) == 1) {
            assert_int_equal(crc, crc_of(run->text, (size_t)(line - run->text)));
            assert_ptr_equal(next + 1, run->text + run->bytes); /* nothing after it */
            return;
        } else {
            parse_line(run, copy);
        }
    }
    fail_msg("%s has no end line", path);
}

#endif
