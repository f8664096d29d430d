/* Faults the board counts. A fault is never an error return: the board goes on as well as it can,
 * counts it, and tells (`fault` and `health` of the catalogue). The number of a fault is its bit in
 * health.faults. */
#ifndef MATRIG_COMMON_FAULT_H
#define MATRIG_COMMON_FAULT_H

/*        NAME              number  text (detail in brackets) */
/* clang-format off */
#define MR_FAULT_TABLE(X)                                                                         \
    X(CLOCK_FALLBACK,     0, "no crystal of 8 MHz: internal oscillator, times within 1 % "       \
      "[its MHz; 0: it did not start]")                                                          \
    X(CLOCK_RAW,          1, "no PLL: running slowly from the internal oscillator")               \
    X(DMA_MISSING,        2, "a DMA controller does not answer [1 or 2]")                         \
    X(TIMER_MISSING,      3, "a timer does not answer [2 or 4]")                                  \
    X(ADC_MISSING,        4, "a converter does not answer [1 or 3]")                              \
    X(CAN_MISSING,        5, "the CAN controller did not start")                                  \
    X(SCAN_STALL,         6, "scans stopped coming; they were started again")                     \
    X(SCAN_OVERRUN,       7, "a converter overran or a scan was lost [1 or 3]")                   \
    X(BLOCK_LATE,         8, "blocks were overwritten before they were processed")                \
    X(POLARITY,           9, "the excitation was not in the state the scan expected")             \
    X(EDGE_OVERRUN,      10, "edges came faster than they could be stored [2: pulses of the "     \
      "camera]")                                                                                  \
    X(CAN_PASSIVE,       11, "CAN is error passive: unplugged, or a wrong bit rate [TEC]")        \
    X(CAN_BUS_OFF,       12, "CAN went bus-off")                                                  \
    X(CAN_QUEUE_FULL,    13, "CAN frames were dropped because the queue was full")                \
    X(SERIAL_QUEUE_FULL, 14, "serial frames were dropped because the queue was full")             \
    X(SERIAL_BAD_FRAME,  15, "a received serial frame was refused [minus status]")                \
    X(SERIAL_POLLED,     16, "no DMA for serial: polled output")                                  \
    X(CAN_SILENT,        17, "CAN is kept silent: the clock is not exact enough")                 \
    X(CAN_RX_OVERRUN,    18, "commands on CAN came faster than they could be taken")              \
    X(WATCHDOG_RESET,    19, "the watchdog reset the board")                                      \
    X(HARD_FAULT,        20, "a processor fault reset the board [1 memory, 2 bus, 3 usage, 4 "    \
      "other, 5 the crystal stopped, 6 unasked interrupt]")                                       \
    X(REFERENCE,         21, "the reference channel is out of range: displacements and tensions " \
      "missing")                                                                                  \
    X(IDENTITY_MISSING,  22, "the chip's unique identity cannot be read")                         \
    X(NO_FIT,            23, "no final speed: too few switches were seen, or contradictory ones " \
      "[minus status]")                                                                           \
    X(NOR_MISSING,       24, "no black box: its memory does not answer, or is another [1: since " \
      "start]")                                                                                   \
    X(NOR_FAILED,        25, "a page or sector of the black box failed [1 program, 2 erase, 3 "   \
      "read, 4 mark, 5 slow log]")                                                                \
    X(BOX_LOST,          26, "the black box had no room for a block or a message [0 block, 1 "    \
      "message]")                                                                                 \
    X(CONFIG,            27, "a stored configuration is damaged [1 copy A, 2 copy B, 3 none is "  \
      "whole: what is built in is in force]")                                                     \
    X(SELFTEST,          28, "a self-test failed [which, see the table of self-tests]")           \
    X(TASK_LATE,         29, "a part of the firmware did not run in its time [which, see the "    \
      "table of tasks]")                                                                          \
    X(THERMOMETER,       30, "no mat temperature [1 no answer, 2 bus stuck, 3 value out of "      \
      "range]")                                                                                   \
    X(CHANNEL,           31, "a channel is not valid: channel_event says why [channel, from 0]")
/* clang-format on */

enum mr_fault_code {
#define MR_FAULT_ENUM(NAME, number, text) MR_FAULT_##NAME = (number),
    MR_FAULT_TABLE(MR_FAULT_ENUM) MR_FAULT_COUNT
};
#undef MR_FAULT_ENUM

/* Text of a fault, "unknown fault" beyond the table. Static storage. */
const char *mr_fault_text(unsigned fault);

#endif
