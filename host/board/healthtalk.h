/* Asking a board over serial how it is: the commands state, self-test and reset, and what it says
 * of its health. */
#ifndef MATRIG_HOST_HEALTHTALK_H
#define MATRIG_HOST_HEALTHTALK_H

#include "common/catalogue.h"
#include "common/fault.h"
#include "host/board/crash.h"
#include "host/board/dialogue.h"

struct healthtalk {
    struct dialogue *dialogue;
    unsigned hellos, wanted; /* that came; that are waited for */
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

/* The dialogue is the caller's; `talk` subscribes to it. Waits until the board says hello. Statuses
 * as dialogue_hello. */
enum mr_status healthtalk_begin(struct healthtalk *talk, struct dialogue *dialogue,
                                struct error *error);
/* Hears everything that the board says each second, and what a processor fault left behind. */
enum mr_status healthtalk_hear(struct healthtalk *talk, struct error *error);
/* Fills `test`. MR_TIMEOUT, or what the board answered. */
enum mr_status healthtalk_self_test(struct healthtalk *talk, struct error *error);
/* Waits until the board speaks again. */
enum mr_status healthtalk_reset(struct healthtalk *talk, struct error *error);

#endif
