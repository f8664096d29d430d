/* The emulated STM32F407ZG board as a library: it runs a firmware ELF unmodified, in virtual time,
 * with a rig on its pins.
 *
 *     struct hil_board *board = hil_board_create(&options);
 *     hil_board_load_elf(board, "build/firmware/matrig.elf");
 *     hil_board_attach_rig(board, &run);             (optional; see hil/rig/runfile.h)
 *     hil_board_run_until(board, 10 * HIL_SECOND_PS);
 *
 * Time. Virtual time counts HCLK cycles; an instruction takes one (or options.cpi), exception entry
 * 12, return 10. That is an approximation (wait states, flash cache misses, divides and multiple
 * loads are not modelled; hardware differs by up to a factor of two in CPU time), so figures from
 * here are instruction counts, not cycle counts. Peripherals are exact in their own clocks. Events
 * and interrupts are seen at the next basic block of the firmware, a handful of instructions late
 * at most.
 *
 * Errors. Functions that can fail return an enum mr_status and leave one line in
 * hil_board_reason(). After a failed hil_board_run_until the board stays where it is: MR_UNMODELLED
 * (an access or a setting that the emulator does not model; with address, size and PC) or MR_HALTED
 * (lockup, or something that hardware would not survive).
 *
 * Two boards share nothing; one board belongs to one thread. Same ELF, options, run file and
 * injected input: same bytes. */
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

/* `core.state`, `state`, the memories and the core's registers are the whole machine, without
 * pointers: a snapshot is a copy of them. What a board is connected to (callbacks, rig, onlookers)
 * is no part of a snapshot. A program uses the calls below and a part knows its neighbours by their
 * own headers; hil/debug/ and tests look inside. */
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

/* Power on, with erased flash. Aborts on lack of memory. Destroy frees it; NULL is allowed. */
struct hil_board *hil_board_create(const struct hil_options *options);
void hil_board_destroy(struct hil_board *board);
void hil_board_set_callbacks(struct hil_board *board, const struct hil_callbacks *callbacks);

/* Put an ELF's segments into memory and reset the chip. MR_IO; MR_MALFORMED, MR_TRUNCATED;
 * MR_VERSION: for another chip. */
enum mr_status hil_board_load_elf(struct hil_board *board, const char *path);

/* Connect a rig; `run` is not copied and must outlive the board. Its time 0 is the board's power
 * on. */
void hil_board_attach_rig(struct hil_board *board, const struct hil_run *run);

/* Connect a replay in place of a rig; it is not copied and must outlive the board. Before the first
 * run. */
void hil_board_attach_replay(struct hil_board *board, const struct hil_replay *replay);

/* Run until virtual time t_ps (since power on). MR_OK there; MR_UNMODELLED, MR_HALTED. Where the
 * calls cut time into pieces has no influence on what the board does. */
enum mr_status hil_board_run_until(struct hil_board *board, uint64_t t_ps);
const char *hil_board_reason(const struct hil_board *board);

uint64_t hil_board_now_ps(const struct hil_board *board);

/* Level of a pin: port 0 = A .. 8 = I. The warning lamp is pin ('E' - 'A', 0). */
bool hil_board_pin(const struct hil_board *board, unsigned port, unsigned pin);

const struct hil_counters *hil_board_counters(const struct hil_board *board);

/* Bytes of the board's memory, for tests and benches. MR_UNKNOWN when the range is not in one
 * memory. */
enum mr_status hil_board_peek(const struct hil_board *board, uint32_t address, void *out, size_t n);
enum mr_status hil_board_poke(struct hil_board *board, uint32_t address, const void *bytes,
                              size_t n);

/* Board type of an image, from the content of a file; a file without header, or unreadable, leaves
 * `type` unchanged, and its loader reports why. Either may be NULL; the ELF has precedence.
 * MR_VERSION: for a board that is not modelled; `error` says which. */
enum mr_status hil_which_files(const char *elf, const char *flash,
                               const struct hil_board_type **type, char *error, size_t size);

/* Flash and NOR contents of a board as files, so that they outlast the program.
 *
 * A flash file is the 1 MiB from 0x08000000, shorter ones are erased above; when the option bytes
 * are not factory new, their 16 bytes (as at 0x1FFFC000) follow. A NOR file is 16 MiB, likewise.
 *
 * Load; a file that is not there leaves the memory as it is. Flash: the chip is reset, as at power
 * on. MR_IO; MR_MALFORMED: not such a file; MR_VERSION: for another board. hil_board_reason says
 * why. MR_HALTED: nothing in it to run. */
enum mr_status hil_board_load_flash(struct hil_board *board, const char *path);
enum mr_status hil_board_load_nor(struct hil_board *board, const char *path);
/* Write, by way of a file beside it, so that a failure leaves the old one. MR_IO. */
enum mr_status hil_board_save_flash(struct hil_board *board, const char *path);
enum mr_status hil_board_save_nor(struct hil_board *board, const char *path);
/* Load an ELF as a flasher would: sectors that it has nothing in keep their content. As
 * hil_board_load_elf. */
enum mr_status hil_board_load_elf_sparing(struct hil_board *board, const char *path);

/* Is it a file that nothing here overwrites: a campaign (SQLite) or a program (ELF)? */
bool hil_is_precious(const char *path);

/* Reset the chip now, as a debugger asks. */
void hil_board_reset(struct hil_board *board);
/* Draw or compute the electronics of the options, and give the converters theirs. */
void hil_board_fit_electronics(struct hil_board *board);

#endif
