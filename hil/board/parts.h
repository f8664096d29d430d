/* What a board is made of. For those who build it (hil/board/), look inside (hil/debug/, tests) and
 * nobody else: a program uses board.h, a part knows its neighbours by their own headers.
 *
 * `core.state`, `state`, the memories and the core's registers are the whole machine, without
 * pointers: a snapshot is a copy of them. What a board is connected to (callbacks, rig, onlookers)
 * is no part of a snapshot. */
#ifndef MATRIG_HIL_PARTS_H
#define MATRIG_HIL_PARTS_H

#include "hil/chips/tmp112.h"
#include "hil/chips/w25q.h"
#include "hil/core/core.h"
#include "hil/periph/mcu.h"
#include "hil/periph/options.h"
#include "hil/rig/rig.h"
#include "hil/rig/electronics.h"
#include "hil/rig/faults.h"
#include "hil/rig/replay.h"
#include "hil/core/elf.h"

struct hil_state {
    struct hil_mcu_state mcu;
    struct hil_w25q w25q;
    struct hil_nor_orders nor_orders;
    struct hil_tmp112 tmp112;
    struct hil_rig rig;
    struct hil_camera camera;
    struct hil_script script;
    struct hil_replay_state replay;
    struct hil_lines lines;
    struct hil_faults faults;
    struct hil_supply supply;
};

/* The memories of a board, chip and NOR. */
struct hil_memories {
    struct hil_memory own;
    uint8_t nor[HIL_NOR_SIZE]; /* inverted, see hil/chips/w25q.h; last, and mostly never touched */
};

struct hil_board {
    struct hil_core core;
    struct hil_mcu mcu;
    struct hil_state state;
    struct hil_memories *memories; /* page-aligned */
    struct hil_options options;
    struct hil_electronics electronics; /* constant once the board is made */
    struct hil_w25q_device w25q;
    struct hil_tmp112_device tmp112;
    struct hil_rig_device rig;
    struct hil_camera_device camera;
    struct hil_script_device script;
    struct hil_replay_device replay;
    struct hil_lines_device lines;
    struct hil_faults_device faults;
    struct hil_supply_device supply;
    char elf[1024];            /* the image's path, "": none */
    struct mr_symbols symbols; /* of it, read when a name is first asked for */
};

/* Reset the chip now, as a debugger asks. */
void hil_board_reset(struct hil_board *board);
/* Draw or take the electronics that the options say, and give the converters theirs. */
void hil_board_fit_electronics(struct hil_board *board);

#endif
