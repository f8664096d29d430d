/* Board time on one link: blocks since the scans began, unwrapped from the 16 bits that most
 * messages carry, and conversion of capture ticks to time (common/block.h). Pure functions. */
#ifndef MATRIG_HOST_TIMEBASE_H
#define MATRIG_HOST_TIMEBASE_H

#include <stdbool.h>
#include <stdint.h>

struct timebase {
    bool is_block_known; /* a full block index was received */
    bool is_tick_known;
    int64_t newest_block;       /* newest block */
    int64_t newest_clock_block; /* block of the newest clock message */
    uint32_t origin;            /* common/block.h */
};

/* Applies a full block index. Returns true if it is at least a second before the newest one, which
 * means that the board has restarted. */
bool timebase_apply_block(struct timebase *timebase, uint32_t block);
/* As timebase_apply_block, with the value of TIM2 at the first trigger of the block. */
bool timebase_apply_clock(struct timebase *timebase, uint32_t block, uint32_t tick);

enum timebase_result { TIMEBASE_CONTINUES, TIMEBASE_RESTARTED, TIMEBASE_UNCONFIRMED };
/* A board time that does not continue from the known one, until a second one confirms it. */
struct timebase_candidate {
    bool is_pending;
    uint32_t block, origin;
};
/* As timebase_apply_clock, on a link on which other nodes may send. A time that does not continue
 * from the known one changes nothing until a second one continues from it. `hello`: a hello was
 * received since the last clock, so a clock that goes back by any amount is not accepted at
 * once. */
enum timebase_result timebase_check_clock(struct timebase *timebase,
                                          struct timebase_candidate *doubt, uint32_t block,
                                          uint32_t tick, bool hello);
/* For a link that keeps the order of frames. Returns true if the block is before the newest one, by
 * any amount: the board restarted. */
bool timebase_is_restart(const struct timebase *timebase, uint32_t block);
/* Returns the block with these low 16 bits that is nearest to the newest block. It becomes the
 * newest block if it is later by less than half a second; larger steps are accepted only from a
 * clock message.
 * -1: not known. */
int64_t timebase_unwrap(struct timebase *timebase, uint16_t block16);
/* Returns the board time of the newest block, microseconds; -1: not known. */
int64_t timebase_now_us(const struct timebase *timebase);
/* Returns the time of a capture within 25 s of the newest block, in microseconds since the scans
 * began; NaN: not known. */
double timebase_tick_to_us(const struct timebase *timebase, uint32_t tick);

#endif
