/* What the tests of the emulated board share: a board with a test image on it, its words, its
 * time. */
#ifndef MATRIG_TESTS_HIL_BENCH_H
#define MATRIG_TESTS_HIL_BENCH_H

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "hil/board/board.h"
#include "tests/hil/still_run.h"
#include "tests/cmocka_all.h"

#define BENCH_IMAGES  "build/tests/hil/images/"
#define BENCH_SCRATCH "build/test-tmp/hil"
#define BENCH_RESULTS 0x20000000u
#define BENCH_CONTROL 56u

static inline struct hil_board *bench_board(const char *image, const struct hil_options *options)
{
    struct hil_options usual;
    char path[128];
    hil_options_default(&usual);
    usual.has_adc_noise = false;
    struct hil_board *board = hil_board_create(options ? options : &usual);
    snprintf(path, sizeof path, BENCH_IMAGES "%s.elf", image);
    if (hil_board_load_elf(board, path) != MR_OK)
        fail_msg("%s", hil_board_failure_reason(board));
    return board;
}

static inline uint32_t bench_word(const struct hil_board *board, uint32_t address)
{
    uint32_t value = 0;
    assert_int_equal(hil_board_peek(board, address, &value, 4), MR_OK);
    return value;
}

static inline uint32_t bench_result(const struct hil_board *board, unsigned n)
{
    return bench_word(board, BENCH_RESULTS + 4u * n);
}

static inline void bench_control(struct hil_board *board, unsigned n, uint32_t value)
{
    assert_int_equal(hil_board_poke(board, BENCH_RESULTS + 4u * (BENCH_CONTROL + n), &value, 4),
                     MR_OK);
}

static inline void bench_run(struct hil_board *board, uint64_t t_ps)
{
    enum mr_status status = hil_board_run_until(board, t_ps);
    if (status != MR_OK)
        fail_msg("the board stopped: %s", hil_board_failure_reason(board));
}

/* The power goes in the n-th operation from now of the flash or, `nor`, of the black box's memory,
 * permille of its time after it began. One at a time. */
static struct bench_cut {
    struct hil_board *board;
    struct hil_callback told;
    uint64_t left;
    unsigned permille;
    bool nor;
} bench_cut;

static inline void bench_cut_began(void *context)
{
    struct bench_cut *cut = context;
    hil_callback_invoke(&cut->told);
    if (!cut->left || --cut->left)
        return;
    const struct hil_state *state = &cut->board->state;
    uint64_t begin = cut->nor ? state->w25q.operation_begin_ps : state->mcu.flash.begin_ps;
    uint64_t end = cut->nor ? state->w25q.operation_end_ps : state->mcu.flash.end_ps;
    struct hil_fault fault = {.trigger = HIL_TRIGGER_TIME,
                              .trigger_ps = begin + (end - begin) / 1000u * cut->permille,
                              .action = HIL_FAULT_POWER_CUT};
    assert_int_equal(hil_faults_add(&cut->board->faults, &fault), MR_OK);
}

static inline void bench_cut_at(struct hil_board *board, bool nor, uint64_t n, unsigned permille)
{
    struct hil_callback *began = nor ? &board->w25q.on_operation_begin
                                     : &board->mcu.flash.on_operation_begin;
    bench_cut = (struct bench_cut){board, *began, n, permille, nor};
    *began = (struct hil_callback){bench_cut_began, &bench_cut};
}

/* Write a scratch file; returns its path, static storage. */
static inline const char *bench_scratch(const char *name, const void *bytes, size_t n)
{
    static char path[160];
    mkdir("build", 0777);
    mkdir("build/test-tmp", 0777);
    mkdir(BENCH_SCRATCH, 0777);
    snprintf(path, sizeof path, BENCH_SCRATCH "/%s", name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
    return path;
}

#endif
