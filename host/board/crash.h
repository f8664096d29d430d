/* What a board tells of a processor fault (message `crash`): put together, and in words. */
#ifndef MATRIG_HOST_CRASH_H
#define MATRIG_HOST_CRASH_H

#include <stdbool.h>
#include <stddef.h>

#include "common/catalogue.h"
#include "common/crash.h"
#include "common/symbols.h"
#include "host/base/answer.h"

struct crash_report {
    uint32_t word[MR_CRASH_ITEMS];
    uint64_t present; /* bit n: word n */
    uint16_t age;     /* restarts since */
};

_Static_assert(MR_CRASH_ITEMS <= 64, "crash_report.present has one bit per word");

/* Takes one word. True: now all are there, and were not before this one. */
bool crash_take(struct crash_report *report, const struct mr_crash *message);

/* One line without its end: "the board restarted after a usage fault at 0x0801234a in
 * take_block+0x12 ...". `symbols` NULL: the function is not known. */
void crash_headline(const struct crash_report *report, const struct mr_symbols *symbols, char *out,
                    size_t size);
/* An address, with its function where it has one. */
void crash_place(uint32_t address, const struct mr_symbols *symbols, char *out, size_t size);
/* Headline, registers, stack: object `crash`. */
void crash_answer(const struct crash_report *report, const struct mr_symbols *symbols,
                  struct answer *answer);

#endif
