/* The emulated STM32F407ZG board as a library: it runs a firmware ELF unmodified, in virtual time, with a
 * rig on its pins.
 *
 *     struct hil_board *board = hil_board_create(&options);
 *     hil_board_load_elf(board, "build/firmware/matrig.elf");
 *     hil_board_attach_rig(board, &run);             (optional; see hil/rig/runfile.h)
 *     hil_board_run_until(board, 10 * HIL_SECOND_PS);
 *
 * Time. Virtual time counts HCLK cycles; an instruction takes one, exception entry 12, return 10. That is
 * an approximation (wait states, flash cache misses, divides and multiple loads are not modelled; silicon
 * differs by up to a factor of two in CPU time), so figures from here are instruction counts, not cycle
 * counts. Peripherals are exact in their own clocks. Events and interrupts are seen at the next basic
 * block of the firmware, a handful of instructions late at most.
 *
 * Errors. Functions that can fail return an enum mr_status and leave one line in hil_board_reason(). After
 * a failed hil_board_run_until the board stays where it is: MR_UNMODELLED (an access or a setting that the
 * emulator does not model; with address, size and PC) or MR_HALTED (lockup, or something that silicon
 * would not survive).
 *
 * Two boards share nothing; one board belongs to one thread. Same ELF, options, run file and injected
 * input: same bytes. */
#ifndef MATRIG_HIL_BOARD_H
#define MATRIG_HIL_BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"
#include "hil/periph/cells.h"
#include "hil/rig/runfile.h"
#include "hil/periph/serial_line.h"

#define HIL_SECOND_PS 1000000000000ull
#define HIL_MS_PS 1000000000ull
#define HIL_US_PS 1000000ull
#define HIL_NS_PS 1000ull

struct hil_board;    /* opaque; hil/board/machine.h */
struct hil_snapshot; /* opaque */

enum hil_can_bus {
    HIL_CAN_CONNECTED, /* the other side acknowledges */
    HIL_CAN_UNPLUGGED, /* nobody acknowledges */
    HIL_CAN_SHORTED,   /* wires touching: every bit reads back recessive */
    HIL_CAN_DOMINANT,  /* held dominant: no frame can begin, nobody leaves initialisation */
};

struct hil_options {
    uint64_t seed;           /* of converter noise */
    uint32_t hse_hz;         /* crystal; 0: it never starts */
    int32_t hsi_error_ppm;   /* of the internal 16 MHz oscillator */
    uint32_t lsi_hz;         /* 17000..47000, watchdog clock */
    uint32_t host_baud;      /* rate of the serial line's other end */
    enum hil_parity host_parity; /* and its parity; not used where it follows the board's own */
    bool host_parity_follows;
    enum hil_can_bus can_bus;
    double camera_hz;        /* frames a second of the film camera; 0: there is none (hil/rig/camera.h) */
    uint64_t camera_delay_ps;  /* from its trigger to the first frame */
    uint64_t camera_jitter_ps; /* of each frame, either way, evenly distributed */
    bool adc_noise;          /* false: codes are exact, for tests */
    uint32_t uid[3];         /* unique device identifier */
    bool boot0;              /* level of the BOOT0 pin at reset: high starts the boot ROM */
    double temperature_c;    /* of the mat at power on; NaN: no thermometer is fitted */
    double temperature_c_per_h;
    enum hil_cell_times cell_times; /* how long flash and NOR operations take */
    bool watch_alignment;    /* fault on multiple and double transfers that are not aligned to words; two to three times
                                slower, since every instruction is looked at */
    FILE *trace;             /* NULL, or where exceptions and unusual events are told */
    FILE *log;               /* NULL, or where injected faults are told, a line each (hil/rig/faults.h) */
};

struct hil_can_frame {
    uint32_t id;       /* 11 or 29 bits */
    bool extended;
    bool remote;
    uint8_t length;    /* 0..8 */
    uint8_t data[8];
};

struct hil_callbacks {
    void *ctx;
    /* A frame of the board whose last bit (end of frame) ended at t_ps. */
    void (*on_can_frame)(void *ctx, uint64_t t_ps, const struct hil_can_frame *frame);
    /* n bytes of the board; the stop bit of the last one ended at t_ps. */
    void (*on_serial_bytes)(void *ctx, uint64_t t_ps, const uint8_t *bytes, size_t n);
};

/* All since creation; they survive resets of the chip. */
struct hil_counters {
    uint64_t instructions;
    uint64_t asleep_cycles;        /* HCLK cycles spent in WFI or WFE */
    uint64_t exceptions;           /* entries, tail-chained ones included */
    uint64_t tail_chains;
    uint64_t faults;               /* MemManage, BusFault, UsageFault, HardFault entries */
    uint64_t resets;               /* all but power on */
    uint64_t watchdog_resets;
    uint64_t can_frames_out;
    uint64_t can_frames_in;
    uint64_t can_frames_filtered;  /* of those in: no filter let them pass */
    uint64_t can_errors;           /* frames that were not acknowledged or were destroyed */
    uint64_t can_in_dropped;       /* injected while the queue of the other side was full */
    uint64_t serial_bytes_out;
    uint64_t serial_bytes_in;
    uint64_t serial_wrong_rate;    /* bytes sent at a rate or parity that is not the other end's: garbled */
    uint64_t serial_in_dropped;    /* injected while the queue was full */
    uint64_t adc_scans[2];         /* sequences completed: ADC1, ADC3 */
    uint64_t adc_triggers_ignored; /* came while a sequence was running */
    uint64_t adc_overruns;
    uint64_t switches_opened;
    uint64_t edges_captured;       /* TIM2 channel 1 */
    uint64_t frames_captured;      /* TIM2 channel 2 */
    uint64_t film_frames;          /* pulses the camera gave */
    /* time with PD12 high and PD13 low; no direct component: plus equals minus */
    uint64_t excitation_plus_ps;
    uint64_t excitation_minus_ps;
    uint64_t commands_scripted;    /* of the run file, given to the board */
    uint64_t faults_injected;      /* lines told of hil/rig/faults.h */
    uint64_t flash_refused;        /* stores and operations that set an error flag, wrong keys */
    uint64_t flash_stall_cycles;   /* HCLK cycles for which the core waited for flash */
    uint64_t power_cuts;
    uint32_t last_fault_pc;
    uint32_t last_fault_cfsr;
    uint32_t last_fault_address;
};

/* Defaults: 8 MHz crystal, exact HSI, 32 kHz LSI, 2 Mbaud, bus connected, noise on, seed 1. */
void hil_options_default(struct hil_options *options);

/* Power on, with erased flash. Aborts on lack of memory. Destroy frees it; NULL is allowed. */
struct hil_board *hil_board_create(const struct hil_options *options);
void hil_board_destroy(struct hil_board *board);
void hil_board_set_callbacks(struct hil_board *board, const struct hil_callbacks *callbacks);
/* Those on the board's pins: before what injected faults do to the links. */
void hil_board_set_pin_callbacks(struct hil_board *board, const struct hil_callbacks *callbacks);

/* Put an ELF's segments into memory and reset the chip. MR_IO; MR_MALFORMED, MR_TRUNCATED; MR_VERSION: for
 * another chip. */
enum mr_status hil_board_load_elf(struct hil_board *board, const char *path);

/* Connect a rig; `run` is not copied and must outlive the board. Its time 0 is the board's power on. */
void hil_board_attach_rig(struct hil_board *board, const struct hil_run *run);

/* Run until virtual time t_ps (since power on). MR_OK there; MR_UNMODELLED, MR_HALTED. Where the calls cut
 * time into pieces has no influence on what the board does. */
enum mr_status hil_board_run_until(struct hil_board *board, uint64_t t_ps);
const char *hil_board_reason(const struct hil_board *board);

uint64_t hil_board_now_ps(const struct hil_board *board);
uint64_t hil_board_now_cycles(const struct hil_board *board);
uint32_t hil_board_hclk_hz(const struct hil_board *board);

/* A frame of another node; it waits for the bus and arbitrates. MR_FULL when 64 wait. */
enum mr_status hil_board_can_inject(struct hil_board *board, const struct hil_can_frame *frame);
/* Bytes from the other end, back to back at its rate after those given before. MR_FULL: room for 4096,
 * rest dropped. */
enum mr_status hil_board_serial_inject(struct hil_board *board, const uint8_t *bytes, size_t n);
/* Bytes that hil_board_serial_inject takes now. */
size_t hil_board_serial_room(const struct hil_board *board);
/* The other end changes its rate; between calls of hil_board_run_until. */
void hil_board_set_host_baud(struct hil_board *board, uint32_t baud);
void hil_board_set_can_bus(struct hil_board *board, enum hil_can_bus can_bus);

/* The supply goes and comes back at once: operations of flash and NOR stop half done, RAM holds noise, everything else
 * is as at power on; time, rig and what is on the links go on. Callable while the board runs or between. */
void hil_board_cut_power(struct hil_board *board);
/* The same for a time: nothing runs until the supply is back. */
void hil_board_power_off(struct hil_board *board, uint64_t duration_ps);
/* The supply dips to `volts` for a time. Below the brown-out level of the option bytes (factory: off) the chip is held in
 * reset and RAM stays; below 1.68 V it is a power cut. Otherwise the run ends when silicon could not go on at that supply
 * with the clock and wait states set, and nothing happens when it could. */
void hil_board_brown_out(struct hil_board *board, double volts, uint64_t duration_ps);
/* Do that in the n-th flash operation from now (1: the next; 0: no longer), permille (0..999) of its time after it
 * began. */
void hil_board_cut_at_flash(struct hil_board *board, uint64_t n, unsigned permille);

/* Level of a pin: port 0 = A .. 8 = I. The warning lamp is pin ('E' - 'A', 0). */
bool hil_board_pin(const struct hil_board *board, unsigned port, unsigned pin);
/* Drive a pin from outside, for tests; it holds until changed. */
void hil_board_drive_pin(struct hil_board *board, unsigned port, unsigned pin, bool level);

const struct hil_counters *hil_board_counters(const struct hil_board *board);

/* Bytes of the board's memory, for tests and benches. MR_UNKNOWN when the range is not in one memory. */
enum mr_status hil_board_peek(const struct hil_board *board, uint32_t address, void *out, size_t n);
enum mr_status hil_board_poke(struct hil_board *board, uint32_t address, const void *bytes, size_t n);
/* Core registers: 0..12, 13 the current SP, 14, 15 PC, 16 xPSR, 17 PRIMASK. */
#define HIL_PRIMASK 17u
uint32_t hil_board_register(const struct hil_board *board, unsigned number);

/* The whole machine (memories, core, peripherals, counters) as one block of memory without pointers.
 * Restoring into another board gives a second one that goes on identically; rig, callbacks and options'
 * trace stay the target's own. A reservation of LDREX is not part of it. The caller frees a snapshot with
 * free(). */
struct hil_snapshot *hil_board_snapshot(const struct hil_board *board);
void hil_board_restore(struct hil_board *board, const struct hil_snapshot *snapshot);
/* New board in the same state, same rig, no callbacks, no trace. */
struct hil_board *hil_board_fork(const struct hil_board *board);

#endif
