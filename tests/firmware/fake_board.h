/* A board for tests of the firmware's application: blocks and edges are put in, frames come out. No registers. */
#ifndef MATRIG_TESTS_FIRMWARE_FAKE_BOARD_H
#define MATRIG_TESTS_FIRMWARE_FAKE_BOARD_H

#include "firmware/board.h"

#define FAKE_FRAMES 200000u
#define FAKE_SERIAL 2000000u

struct fake_board {
    struct mr_block block;
    bool block_ready;
    uint32_t edge_tick[64];
    size_t edges, edges_taken;

    struct board_can_frame sent[FAKE_FRAMES];
    uint32_t sent_block[FAKE_FRAMES]; /* block being processed */
    size_t sent_count;
    uint8_t serial[FAKE_SERIAL];
    size_t serial_count;
    struct board_can_frame received[64];
    size_t received_count, received_taken;
    uint8_t serial_in[4096];
    size_t serial_in_count, serial_in_taken;

    bool can_full, serial_full; /* refuse everything */
    struct board_can_errors can_errors;
    bool warning;
    unsigned restarts;
    unsigned rom_entries;
    uint8_t clock_source;
    uint8_t image_state;
};

extern struct fake_board fake;

void fake_reset(void);

#endif
