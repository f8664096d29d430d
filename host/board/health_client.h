/* Health of a board: restarts, faults, and the report of a processor fault. */
#ifndef MATRIG_HOST_BOARD_HEALTH_CLIENT_H
#define MATRIG_HOST_BOARD_HEALTH_CLIENT_H

#include <stdbool.h>
#include <stddef.h>

#include "common/catalogue.h"
#include "common/fault.h"
#include "host/base/answer.h"
#include "host/base/cli.h"
#include "host/base/error.h"
#include "host/board/dialogue.h"

/* A processor fault, assembled from the board's `crash` messages. */
struct crash_report {
    uint32_t word[MR_CRASH_ITEM_COUNT];
    uint64_t present_bits;  /* bit n: word n was received */
    uint16_t restart_count; /* number of restarts since the fault */
};

_Static_assert(MR_CRASH_ITEM_COUNT <= 64, "crash_report.present_bits has one bit per word");

/* Adds one word. Returns true if this word completes the report. */
bool crash_receive(struct crash_report *report, const struct mr_crash *message);

/* Writes the causes of a reset, from reset_cause of hello: "pin, software"; "": no cause is
 * known. */
void health_reset_text(int64_t cause, char *out, size_t size);
/* Writes one line without newline: "the board restarted after a usage fault at 0x0801234a, in
 * channels, block 1234". */
void crash_format_summary(const struct crash_report *report, char *out, size_t size);

/* A client for a board's health over serial: the commands state, self-test and reset, and the
 * messages about health. */
struct health_client {
    struct dialogue *dialogue;
    unsigned hello_count,
        required_hello_count; /* number of hellos received, and number to wait for */
    bool self_test_done, crash_reported;
    bool restarts_known, upkeep_known, alarm_known, drops_known, health_known;
    struct mr_hello hello; /* newest hello */
    struct mr_restarts restarts;
    struct mr_upkeep upkeep;
    struct mr_can_alarm alarm;
    struct mr_can_drops drops;
    struct mr_health health;
    struct mr_fault fault[MR_FAULT_COUNT]; /* count 0: no fault */
    struct mr_self_test self_test;
    struct crash_report crash;
};

/* Runs matrig board health | self-test | reset. Returns the exit code; 1: the board reports a
 * fault. An error ends the program. */
int health_print_report(struct dialogue *dialogue, const char *verb, const struct cli *cli);

#endif
