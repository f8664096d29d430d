/* The emulated STM32F407ZG board as a library: it runs a firmware ELF unmodified, in virtual time,
 * with a rig on its pins.
 *
 *     struct hil_board *board = hil_board_create(&options);
 *     hil_board_load_elf(board, "build/firmware/matrig.elf");
 *     hil_board_attach_rig(board, &run);             (optional; see hil/rig/runfile.h)
 *     hil_board_run_until(board, 10 * HIL_PS_PER_S);
 *
 * Time: virtual time counts HCLK cycles. An instruction takes one cycle (or options.cpi), an
 * exception entry 12, an exception return 10. This is an approximation: wait states, flash cache
 * misses, divides and multiple loads are not modelled, and CPU time on hardware differs by up to a
 * factor of two. Figures from the emulator are therefore instruction counts, not cycle counts.
 * Peripherals are exact in their own clocks. Events and interrupts take effect at the next basic
 * block of the firmware, at most a few instructions late.
 *
 * Errors: functions that can fail return an enum mr_status and set a line of text for
 * hil_board_failure_reason(). When hil_board_run_until fails, the board stops at the cause:
 * MR_UNMODELLED (an access or a setting that the emulator does not model; the text has address,
 * size and PC) or MR_HALTED (lockup, or a setting that would damage hardware or make it fail).
 *
 * Two boards share no state; use each board in one thread only. The same ELF, options, run file and
 * injected input give the same output, byte for byte. */
#ifndef MATRIG_HIL_BOARD_H
#define MATRIG_HIL_BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"
#include "hil/chips/tmp112.h"
#include "hil/chips/w25q.h"
#include "hil/core/core.h"
#include "hil/core/elf.h"
#include "hil/periph/mcu.h"
#include "hil/periph/options.h"
#include "hil/rig/electronics.h"
#include "hil/rig/faults.h"
#include "hil/rig/replay.h"
#include "hil/rig/rig.h"

/* `core.state`, `state`, the memories and the core's registers are the complete state of the
 * machine and contain no pointers: a snapshot is a copy of them. Connections of a board (callbacks,
 * rig, observers) are not part of a snapshot. Programs must use only the functions of this header;
 * only hil/debug/ and tests access the members. */
struct hil_state {
    struct hil_mcu_state mcu;
    struct hil_w25q w25q;
    struct hil_nor_fault_requests nor_fault_requests;
    struct hil_tmp112 tmp112;
    struct hil_rig rig;
    struct hil_camera camera;
    struct hil_command_script script;
    struct hil_replay_state replay;
    struct hil_lines lines;
    struct hil_faults faults;
    struct hil_supply supply;
};

/* The memories of a board, chip and NOR. */
struct hil_memories {
    struct hil_memory mcu;
    /* cells are stored inverted (hil/chips/w25q.h); last member, because most of it is never
     * used */
    uint8_t nor[HIL_NOR_SIZE];
};

struct hil_board {
    struct hil_core core;
    struct hil_mcu mcu;
    struct hil_state state;
    struct hil_memories *memories; /* page-aligned */
    struct hil_options options;
    struct hil_electronics electronics; /* constant after the board has been created */
    struct hil_w25q_device w25q;
    struct hil_tmp112_device tmp112;
    struct hil_rig_device rig;
    struct hil_camera_device camera;
    struct hil_command_script_device script;
    struct hil_replay_device replay;
    struct hil_lines_device lines;
    struct hil_faults_device faults;
    struct hil_supply_device supply;
    char elf[1024];            /* path of the image; "": none */
    struct mr_symbols symbols; /* symbols of the image, read at the first look-up of a name */
};

/* Creates a board at power on, with erased flash. Aborts on lack of memory. hil_board_destroy frees
 * it; NULL is allowed. */
struct hil_board *hil_board_create(const struct hil_options *options);
void hil_board_destroy(struct hil_board *board);
void hil_board_set_callbacks(struct hil_board *board, const struct hil_callbacks *callbacks);

/* Copies the segments of an ELF file into memory and resets the chip. MR_IO; MR_MALFORMED or
 * MR_TRUNCATED: not a valid file; MR_VERSION: for a different chip. */
enum mr_status hil_board_load_elf(struct hil_board *board, const char *path);

/* Connects a rig. `run` is not copied and must outlive the board. Time 0 of the run is the board's
 * power on. */
void hil_board_attach_rig(struct hil_board *board, const struct hil_run *run);

/* Connects a replay in place of a rig. `replay` is not copied and must outlive the board. Call
 * before the first run. */
void hil_board_attach_replay(struct hil_board *board, const struct hil_replay *replay);

/* Runs until virtual time t_ps (since power on). MR_OK when reached; MR_UNMODELLED, MR_HALTED. The
 * result is the same for one long run and for several short ones. */
enum mr_status hil_board_run_until(struct hil_board *board, uint64_t t_ps);
const char *hil_board_failure_reason(const struct hil_board *board);

uint64_t hil_board_now_ps(const struct hil_board *board);

/* Level of a pin; port 0 = A .. 8 = I. The warning lamp is pin ('E' - 'A', 0). */
bool hil_board_pin_level(const struct hil_board *board, unsigned port, unsigned pin);

const struct hil_counters *hil_board_counters(const struct hil_board *board);

/* Read and write the board's memory, for tests and benchmarks. MR_UNKNOWN: the range is not within
 * one memory. */
enum mr_status hil_board_peek(const struct hil_board *board, uint32_t address, void *out, size_t n);
enum mr_status hil_board_poke(struct hil_board *board, uint32_t address, const void *bytes,
                              size_t n);

/* Determines the board type of an image from an ELF or flash file; the ELF has precedence, and
 * either path may be NULL. A file that is unreadable or without a header leaves `type` unchanged;
 * loading it then reports the reason. MR_OK; MR_VERSION: for a board that is not modelled, which
 * `error` names. */
enum mr_status hil_board_type_from_files(const char *elf, const char *flash,
                                         const struct hil_board_type **type, char *error,
                                         size_t size);

/* Files with the flash and NOR contents of a board, which preserve them between runs of the
 * program.
 *
 * A flash file is the 1 MiB from 0x08000000; the rest of a shorter file counts as erased. If the
 * option bytes differ from their factory values, their 16 bytes (as at 0x1FFFC000) follow. A NOR
 * file is 16 MiB; the rest of a shorter file counts as erased.
 *
 * Load a file; a missing file leaves the memory unchanged. Loading flash resets the chip as at
 * power on. MR_IO; MR_MALFORMED: not such a file; MR_VERSION: for a different board; MR_HALTED: the
 * flash contains no program. hil_board_failure_reason has the text. */
enum mr_status hil_board_load_flash(struct hil_board *board, const char *path);
enum mr_status hil_board_load_nor(struct hil_board *board, const char *path);
/* Write the flash or NOR file. The data are first written to a temporary file in the same folder,
 * so the old file remains after a failure. MR_OK, MR_IO. */
enum mr_status hil_board_save_flash(struct hil_board *board, const char *path);
enum mr_status hil_board_save_nor(struct hil_board *board, const char *path);
/* As hil_board_load_elf, but as a flash programmer does it: sectors that the ELF file does not use
 * keep their content. */
enum mr_status hil_board_program_elf(struct hil_board *board, const char *path);

/* True for a file that must not be overwritten: a campaign (SQLite) or a program (ELF). */
bool hil_is_protected_file(const char *path);

/* Resets the chip now, for a debugger. */
void hil_board_reset(struct hil_board *board);
/* Computes the board's electronics from the options, or draws their tolerances, and sets the errors
 * of the converters. */
void hil_board_set_electronics(struct hil_board *board);

#endif
