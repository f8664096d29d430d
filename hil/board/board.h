/* The emulated STM32F407ZG board as a library: it runs a firmware ELF unmodified, in virtual time,
 * with a rig on its pins.
 *
 *     struct hil_board *board = hil_board_create(&options);
 *     hil_board_load_elf(board, "build/firmware/matrig.elf");
 *     hil_board_attach_rig(board, &run);             (optional; see hil/rig/runfile.h)
 *     hil_board_run_until(board, 10 * HIL_SECOND_PS);
 *
 * Time. Virtual time counts HCLK cycles; an instruction takes one, exception entry 12, return 10.
 * That is an approximation (wait states, flash cache misses, divides and multiple loads are not
 * modelled; silicon differs by up to a factor of two in CPU time), so figures from here are
 * instruction counts, not cycle counts. Peripherals are exact in their own clocks. Events and
 * interrupts are seen at the next basic block of the firmware, a handful of instructions late at
 * most.
 *
 * Errors. Functions that can fail return an enum mr_status and leave one line in
 * hil_board_reason(). After a failed hil_board_run_until the board stays where it is: MR_UNMODELLED
 * (an access or a setting that the emulator does not model; with address, size and PC) or MR_HALTED
 * (lockup, or something that silicon would not survive).
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
#include "hil/core/core.h"
#include "hil/periph/canbits.h"
#include "hil/periph/options.h"
#include "hil/rig/faults.h"

struct hil_fault_script;
struct hil_replay;
struct hil_run;

struct hil_board; /* opaque; parts.h */

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
uint64_t hil_board_now_cycles(const struct hil_board *board);
uint32_t hil_board_hclk_hz(const struct hil_board *board);

/* A frame of another node; it waits for the bus and arbitrates. MR_FULL when 64 wait. */
enum mr_status hil_board_can_inject(struct hil_board *board, const struct hil_can_frame *frame);
/* Bytes from the other end, back to back at its rate after those given before. MR_FULL: room for
 * 4096, rest dropped. */
enum mr_status hil_board_serial_inject(struct hil_board *board, const uint8_t *bytes, size_t n);
/* Bytes that hil_board_serial_inject takes now. */
size_t hil_board_serial_room(const struct hil_board *board);
/* The other end changes its rate; between calls of hil_board_run_until. */
void hil_board_set_host_baud(struct hil_board *board, uint32_t baud);

/* Order all faults of a script (hil/rig/faults.h), with its seed. MR_FULL, MR_USAGE, MR_UNKNOWN: as
 * hil_faults_add says; hil_board_reason says which. */
enum mr_status hil_board_add_faults(struct hil_board *board, const struct hil_fault_script *script);
/* At the end of a run: names each fault that did not come to happen, in a line to
 * hil_options.log. */
void hil_board_tell_faults_left(const struct hil_board *board);

/* What was measured of each rule of time and electricity (hil/periph/rules.h), as a table. */
void hil_board_print_rules(const struct hil_board *board, FILE *out);
/* How many of the rules that only count were broken, and how often in all. */
unsigned hil_board_rules_counted(const struct hil_board *board, uint64_t *times);

/* Level of a pin: port 0 = A .. 8 = I. The warning lamp is pin ('E' - 'A', 0). */
bool hil_board_pin(const struct hil_board *board, unsigned port, unsigned pin);

const struct hil_counters *hil_board_counters(const struct hil_board *board);

/* Bytes of the board's memory, for tests and benches. MR_UNKNOWN when the range is not in one
 * memory. */
enum mr_status hil_board_peek(const struct hil_board *board, uint32_t address, void *out, size_t n);
enum mr_status hil_board_poke(struct hil_board *board, uint32_t address, const void *bytes,
                              size_t n);
/* Core registers by the numbers of hil_cpu_register. */
uint32_t hil_board_register(const struct hil_board *board, unsigned number);

/* Which board an image is for, by what is in a file; one that has no header or cannot be read
 * leaves `type` as it is, for whoever loads it says why. Either may be NULL; the ELF has
 * precedence. MR_VERSION: for a board that is not modelled; `error` says which. */
enum mr_status hil_which_files(const char *elf, const char *flash,
                               const struct hil_board_type **type, char *error, size_t size);

/* What the flash and the NOR of a board hold, as files, so that it outlasts the program.
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

#endif
