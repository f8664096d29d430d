/* A board for tests of the firmware's application: blocks and edges are put in, frames come out. No
 * registers. */
#ifndef MATRIG_TESTS_FIRMWARE_FAKE_BOARD_H
#define MATRIG_TESTS_FIRMWARE_FAKE_BOARD_H

#include "firmware/board.h"

#define FAKE_FRAMES 200000u
#define FAKE_SERIAL 2000000u

struct fake_board {
    struct mr_block block;
    bool block_ready;
    unsigned blocks_waiting; /* behind it */
    uint32_t edge_tick[64];
    size_t edges, edges_taken;

    struct fake_pulses {
        uint32_t tick[4096];
        size_t count, taken;
        bool captured;
    } pulses[BOARD_PULSE_INPUT_COUNT];
    bool camera;
    unsigned camera_pulses;
    uint32_t camera_tick; /* what board_set_camera_trigger returns */

    struct board_can_frame sent[FAKE_FRAMES];
    uint32_t sent_block[FAKE_FRAMES]; /* block being processed */
    uint16_t sent_base[FAKE_FRAMES];  /* of the identifiers, when it was queued */
    size_t sent_count;
    unsigned moves; /* calls that set the base */
    uint16_t can_base;
    uint8_t serial[FAKE_SERIAL];
    size_t serial_count;
    struct board_can_frame received[64];
    size_t received_count, received_taken;
    uint8_t serial_in[4096];
    size_t serial_in_count, serial_in_taken;

    uint32_t sync_block, sync_tick; /* of the last sync frame; what it says, when it left */
    bool sync_left;

    bool can_full, serial_full; /* refuse everything */
    unsigned can_waiting;       /* frames in the queue */
    struct board_can_errors can_errors;
    unsigned clears, rejoins;
    bool warning, shunted, lamp_broken;
    unsigned resets;
    struct board_restart restart;
    uint8_t late_task;
    uint32_t late_pc;
    unsigned good_notes;
    unsigned upkeep_slices;
    struct board_background_tests upkeep;
    bool image_known, image_bad;
    unsigned restarts;
    uint32_t fitted;    /* channels that are scanned */
    uint32_t without;   /* channels that this board has no input for */
    uint32_t supply_mv; /* 0: 3300 */
    unsigned configurations;
    unsigned rom_entries;
    bool jumper;
    bool rom_deaf; /* the boot ROM does not listen at the serial link */
    uint8_t clock_source;
    uint8_t image_state;
};

extern struct fake_board fake;

void fake_reset(void);

#endif
