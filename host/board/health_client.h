/* Health of a board: restarts, faults, and what a processor fault left behind. */
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

/* A board's messages about a processor fault (`crash`): put together, and in words. */
struct crash_report {
    uint32_t word[MR_CRASH_ITEMS];
    uint64_t present; /* bit n: word n */
    uint16_t age;     /* restarts since */
};

_Static_assert(MR_CRASH_ITEMS <= 64, "crash_report.present has one bit per word");

/* Takes one word. True: now all are there, and were not before this one. */
bool crash_take(struct crash_report *report, const struct mr_crash *message);

/* "pin, software": the causes of hello's reset_cause; "": none is known. */
void health_reset_text(int64_t cause, char *out, size_t size);
/* One line without its end: "the board restarted after a usage fault at 0x0801234a, in
 * channels, block 1234". */
void crash_headline(const struct crash_report *report, char *out, size_t size);

/* A board's health over serial: the commands state, self-test and reset, and the messages about its
 * health. */
struct health_client {
    struct dialogue *dialogue;
    unsigned hellos, wanted; /* received; awaited */
    bool tested, crashed;
    bool restarts_known, upkeep_known, alarm_known, drops_known, health_known;
    struct mr_hello hello; /* the newest */
    struct mr_restarts restarts;
    struct mr_upkeep upkeep;
    struct mr_can_alarm alarm;
    struct mr_can_drops drops;
    struct mr_health health;
    struct mr_fault fault[MR_FAULT_COUNT]; /* count 0: none */
    struct mr_self_test test;
    struct crash_report crash;
};

/* matrig board health | self-test | reset. Exit code; 1: the board found a fault in itself. What
 * goes wrong ends the program. */
int board_health(struct dialogue *dialogue, const char *verb, const struct cli *cli);

#endif
