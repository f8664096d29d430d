/* Asking a board over serial how it is: the commands state, self-test and reset, and what it says of its health. */
#ifndef MATRIG_HOST_HEALTHTALK_H
#define MATRIG_HOST_HEALTHTALK_H

#include "common/catalogue.h"
#include "common/fault.h"
#include "common/framing.h"
#include "host/board/crash.h"
#include "host/link/link.h"

struct healthtalk {
    struct link *link;
    struct mr_deframer deframer;
    uint16_t seq, tag;
    unsigned hellos;
    bool acknowledged, tested, crashed;
    bool restarts_known, upkeep_known, alarm_known, drops_known, health_known;
    struct mr_hello hello;
    struct mr_ack ack;
    struct mr_restarts restarts;
    struct mr_upkeep upkeep;
    struct mr_can_alarm alarm;
    struct mr_can_drops drops;
    struct mr_health health;
    struct mr_fault fault[MR_FAULT_COUNT]; /* count 0: none */
    struct mr_self_test test;
    struct crash_report crash;
};

/* Waits until the board says hello. MR_TIMEOUT; MR_VERSION: a board of another layout. */
enum mr_status healthtalk_begin(struct healthtalk *talk, struct link *link, struct error *error);
/* Hears everything that the board says each second, and what a processor fault left behind. */
enum mr_status healthtalk_hear(struct healthtalk *talk, struct error *error);
/* Fills `test`. MR_TIMEOUT, or what the board answered. */
enum mr_status healthtalk_self_test(struct healthtalk *talk, struct error *error);
/* Waits until the board speaks again. */
enum mr_status healthtalk_reset(struct healthtalk *talk, struct error *error);

#endif
