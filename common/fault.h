/* Faults that the board counts. A fault is not returned as an error: the board continues as far as
 * possible, counts the fault and reports it (messages `fault` and `health`). The number of a fault
 * is its bit in health.faults; numbers that are not in the table are unused. */
#ifndef MATRIG_COMMON_FAULT_H
#define MATRIG_COMMON_FAULT_H

/*        NAME              number  text (detail in brackets) */
/* clang-format off */
#define MR_FAULT_TABLE(X)                                                                         \
    X(CLOCK_FALLBACK,       0, "no 8 MHz crystal: the board runs on the internal oscillator, "    \
      "times are accurate to 1 % [measured frequency of the crystal in MHz; 0: it did not "       \
      "start; 255: it stopped twice]")                                                            \
    X(CAN_MISSING,          5, "CAN controller did not start")                                    \
    X(SCAN_STALL,           6, "scans stopped and were restarted")                                \
    X(SCAN_OVERRUN,         7, "converter overrun, or lost scan [converter, 1 or 3]")             \
    X(BLOCK_LATE,           8, "blocks were overwritten before they were processed")              \
    X(POLARITY,             9, "excitation had the wrong polarity for the scan")                  \
    X(EDGE_OVERRUN,        10, "edges came faster than they could be stored [1: edges dropped "   \
      "as too old, after a pause of the blocks; 2: camera pulses, not edges]")                    \
    X(CAN_PASSIVE,         11, "CAN is error passive: unplugged, or wrong bit rate [transmit "    \
      "error counter]")                                                                           \
    X(CAN_BUS_OFF,         12, "CAN went bus-off")                                                \
    X(CAN_QUEUE_FULL,      13, "CAN frames were dropped because the queue was full")              \
    X(SERIAL_QUEUE_FULL,   14, "serial frames were dropped because the queue was full")           \
    X(SERIAL_BAD_FRAME,    15, "a received serial frame was refused [status code]")               \
    X(CAN_SILENT,          17, "the board does not send on CAN: its clock is not accurate "       \
      "enough")                                                                                   \
    X(CAN_RX_OVERRUN,      18, "commands on CAN came faster than they could be processed")        \
    X(WATCHDOG_RESET,      19, "the watchdog reset the board")                                    \
    X(HARD_FAULT,          20, "a processor fault reset the board [1 memory, 2 bus, 3 usage, 4 "  \
      "other, 5 crystal stopped, 6 unexpected interrupt]")                                        \
    X(REFERENCE,           21, "reference channel out of range: displacements and tensions are "  \
      "missing")                                                                                  \
    X(NO_FIT,              23, "no final speed: too few or contradictory switches [status "       \
      "code]")                                                                                    \
    X(NOR_MISSING,         24, "no black box: its memory does not answer, or is of a "            \
      "different type [0: at the start, 1: later]")                                               \
    X(NOR_FAILED,          25, "the black-box memory failed [1 program, 2 erase, 3 read, 4 "      \
      "mark a record as free, 5 remain busy, 6 store the runway, 7 store the key]")                \
    X(BOX_LOST,            26, "the black box had no room for a block or a message [0 block, 1 "  \
      "message]")                                                                                 \
    X(CONFIG,              27, "a stored configuration is damaged [1 copy A, 2 copy B, 3 both: "  \
      "the built-in configuration is active]")                                                    \
    X(SELFTEST,            28, "a self-test failed [its number in common/fault.h]")               \
    X(TASK_LATE,           29, "a task of the firmware was late [its number in common/fault.h]")  \
    X(THERMOMETER,         30, "no mat temperature [1 no answer, 2 bus stuck, 3 value out of "    \
      "range]")                                                                                   \
    X(CHANNEL,             31, "a channel is not valid: see channel_event [channel, "             \
      "from 0]")
/* clang-format on */

enum mr_fault_code {
#define MR_FAULT_ENUM(NAME, number, text) MR_FAULT_##NAME = (number),
    MR_FAULT_TABLE(MR_FAULT_ENUM) MR_FAULT_COUNT
};
#undef MR_FAULT_ENUM

/* Returns the text of a fault, "unknown fault" for a number that is not in the table. Static
 * storage. */
const char *mr_fault_text(unsigned fault);

/* ---- crash ---- */

/* Names and numbers of the diagnostics that the board reports after a failure: the words recorded
 * by a processor fault, the parts of the firmware supervised by the watchdog, and the self-tests.
 * Shared by board and host. */

/* number of words of the stack that are recorded, beginning at the stack pointer of the fault */
#define MR_CRASH_STACK_WORDS 16u

/* Words of the message `crash`, in this order. MR_CRASH_STACK_WORDS words of the stack follow
 * them. */
/* clang-format off */
#define MR_CRASH_TABLE(X)                                                          \
    X(KIND, "kind") X(BLOCK, "block") X(TASK, "task") X(IMAGE, "image crc")        \
    X(EXCEPTION, "exception") X(R0, "r0") X(R1, "r1") X(R2, "r2") X(R3, "r3")      \
    X(R4, "r4") X(R5, "r5") X(R6, "r6") X(R7, "r7") X(R8, "r8") X(R9, "r9")        \
    X(R10, "r10") X(R11, "r11") X(R12, "r12") X(SP, "sp") X(LR, "lr") X(PC, "pc")  \
    X(XPSR, "xpsr") X(CFSR, "cfsr") X(HFSR, "hfsr") X(MMFAR, "mmfar") X(BFAR, "bfar")
/* clang-format on */

enum mr_crash_item {
#define MR_CRASH_ENUM(NAME, text) MR_CRASH_##NAME,
    MR_CRASH_TABLE(MR_CRASH_ENUM) MR_CRASH_STACK_FIRST,
    MR_CRASH_ITEM_COUNT = MR_CRASH_STACK_FIRST + MR_CRASH_STACK_WORDS
};
#undef MR_CRASH_ENUM

/* Values of the word MR_CRASH_KIND, also the detail of the fault HARD_FAULT. */
/* clang-format off */
#define MR_CRASH_KIND_TABLE(X)             \
    X(MEMORY,  1, "memory fault")          \
    X(BUS,     2, "bus fault")             \
    X(USAGE,   3, "usage fault")           \
    X(OTHER,   4, "processor fault")       \
    X(CRYSTAL, 5, "crystal stopped")       \
    X(UNEXPECTED, 6, "unexpected interrupt")
/* clang-format on */

enum mr_crash_kind {
#define MR_CRASH_KIND_ENUM(NAME, number, text) MR_CRASH_##NAME = (number),
    MR_CRASH_KIND_TABLE(MR_CRASH_KIND_ENUM)
};
#undef MR_CRASH_KIND_ENUM

/*       NAME         number  limit, 10 ms  part */
/* clang-format off */
#define MR_TASK_TABLE(X)                         \
    X(LOOP,        1,   20,  "the main loop")    \
    X(BLOCKS,      2,   30,  "block processing") \
    X(COMMANDS,    3,   30,  "commands")         \
    X(LANDING,     4,   30,  "the landing")      \
    X(TELEMETRY,   5,   30,  "telemetry")        \
    X(BOX,         6,   30,  "the black box")    \
    X(SUPERVISION, 7,   20,  "supervision")      \
    X(UPKEEP,      8,  100,  "background tests") \
    X(PREDICTOR,   9,   30,  "the predictor")
/* clang-format on */

enum mr_task {
#define MR_TASK_ENUM(NAME, number, limit, text) MR_TASK_##NAME = (number),
    MR_TASK_TABLE(MR_TASK_ENUM) MR_TASK_COUNT
};
#undef MR_TASK_ENUM

/*       NAME         number  test */
/* clang-format off */
#define MR_SELF_TEST_TABLE(X)                          \
    X(RAM,         0, "RAM in use")                    \
    X(FLASH,       1, "the program's checksum")        \
    X(REFERENCE,   2, "reference channel")             \
    X(EXCITATION,  3, "excitation of the transducers") \
    X(NOR,         4, "memory of the black box")       \
    X(LAMP_ON,     5, "warning lamp, on")              \
    X(LAMP_OFF,    6, "warning lamp, off")             \
    X(IMAGE,       8, "integrity of the program")
/* clang-format on */

enum mr_self_test_number {
#define MR_SELF_TEST_ENUM(NAME, number, text) MR_SELF_TEST_##NAME = (number),
    MR_SELF_TEST_TABLE(MR_SELF_TEST_ENUM) MR_SELF_TEST_COUNT
};
#undef MR_SELF_TEST_ENUM

/* clang-format off */
#define MR_CAN_STATE_TABLE(X)                                            \
    X(GOOD,      0, "good")                                              \
    X(WARNING,   1, "many errors")                                       \
    X(PASSIVE,   2, "error passive")                                     \
    X(UNPLUGGED, 3, "no acknowledgement: unplugged, or no other node")   \
    X(STUCK,     4, "no frame gets through")                             \
    X(OFF,       5, "bus-off")                                           \
    X(SILENT,    6, "silent: the clock is not accurate enough")          \
    X(MISSING,   7, "missing")
/* clang-format on */

enum mr_can_state {
#define MR_CAN_STATE_ENUM(NAME, number, text) MR_CAN_##NAME = (number),
    MR_CAN_STATE_TABLE(MR_CAN_STATE_ENUM)
};
#undef MR_CAN_STATE_ENUM

/* These functions return names and texts of the tables, in static storage; "unknown ..." for other
 * numbers. */
const char *mr_crash_item_name(unsigned item); /* "stack" for words of the stack */
const char *mr_crash_kind_text(unsigned kind); /* "usage fault" */
const char *mr_task_text(unsigned task);
const char *mr_self_test_text(unsigned test);
const char *mr_can_state_text(unsigned state);

#endif
