/* Board time on one link: blocks since the scans began, unwrapped from the 16 bits that most
 * messages carry, and capture ticks turned into time by common/block.h. Pure. */
#ifndef MATRIG_HOST_TIMEBASE_H
#define MATRIG_HOST_TIMEBASE_H

#include <stdbool.h>
#include <stdint.h>

struct timebase {
    bool known; /* a whole block index has come */
    bool tick_known;
    int64_t block;   /* newest */
    int64_t clock;   /* block of the newest clock */
    uint32_t origin; /* common/block.h */
};

/* Whole block index: true when it lies a second or more before the newest, so the board began
 * again. */
bool timebase_block(struct timebase *timebase, uint32_t block);
/* The same with TIM2 at the first trigger of the block. */
bool timebase_clock(struct timebase *timebase, uint32_t block, uint32_t tick);

enum timebase_verdict { TIMEBASE_GOES_ON, TIMEBASE_BEGAN_AGAIN, TIMEBASE_DOUBTED };
/* A time that does not go on from the one known, until a second one says the same. */
struct timebase_doubt {
    bool waits;
    uint32_t block, origin;
};
/* As timebase_clock, on a link on which strangers may speak. A time that does not go on from the
 * one known is doubted, and changes nothing, until the next one goes on from it. `hello`: a board
 * has introduced itself since the last clock, so a clock that goes back at all is doubted. */
enum timebase_verdict timebase_clock_doubting(struct timebase *timebase,
                                              struct timebase_doubt *doubt, uint32_t block,
                                              uint32_t tick, bool hello);
/* On a link whose frames keep their order: the block precedes the newest one, so the board began
 * again, by however little. */
bool timebase_is_back(const struct timebase *timebase, uint32_t block);
/* Block whose low 16 bits are given, the one nearest the newest; it becomes the newest when it is
 * later, by less than half a second: time that goes further is a clock's to say. -1: not known. */
int64_t timebase_unwrap(struct timebase *timebase, uint16_t block16);
/* Board time of the newest block, microseconds; -1: not known. */
int64_t timebase_now_us(const struct timebase *timebase);
/* Microseconds since the scans began of a capture within 25 s of the newest block; NaN: not
 * known. */
double timebase_tick_us(const struct timebase *timebase, uint32_t tick);

#endif
