/* How long pins stay at a level: a check of what outside chips demand, on request.
 *
 *     static const struct hil_pin_rule rules[] = {{"/CS", 1, 12, true, 50.0, "W25Q128JV, tSHSL2"}};
 *     static struct hil_pin_times times;
 *     hil_pin_times_watch(first, &times, rules, 1);    run it: learns which blocks of the image
 *                                                      store to the ports
 *     hil_pin_times_watch(second, &times, rules, 1);   another board, the same again: measures;
 *                                                      look at times.of[0]
 *
 * Everything else of the emulator happens at the start of a basic block. Here each store of the
 * core is placed at its own instruction: the start of its block plus one cycle for every
 * instruction before it in the block. The times are therefore lower bounds of those on silicon,
 * where an instruction takes one cycle or more. (An IT instruction or a NOP can take none there.
 * Each counts one cycle here.)
 *
 * To know the instruction, blocks that store to a port of a rule are walked through, as for a
 * debugger (hil/debug/debug.h), which changes nothing of the run. Which blocks these are must be
 * known before they run: hence the first board. A store from a block that was not yet known is
 * counted in `unlocated`, and the pulses that it begins or ends are not judged.
 *
 * An edge is not over when the store is. A level is reached only after the slew that OSPEEDR
 * allows, and the far chip sees the level's end as early as the next store. So a level lasts from
 * store to store less the slew of its own edge.
 *
 * Covered are pins in output mode. A pin that a peripheral drives (alternate function) changes
 * without a store. */
#ifndef MATRIG_TESTS_HIL_PIN_TIMES_H
#define MATRIG_TESTS_HIL_PIN_TIMES_H

#include <stdbool.h>
#include <stdint.h>

struct hil_board;

#define HIL_PIN_RULES  16u
#define HIL_PIN_BLOCKS 256u

struct hil_pin_rule {
    const char *name;
    unsigned port, pin; /* port 0 = A .. 8 = I */
    bool level;         /* true: of the high level */
    double least_ns;    /* the level must last this long */
    const char *source; /* who says so */
};

struct hil_pin_time {
    uint64_t pulses;    /* times that the level began and ended */
    uint64_t too_short; /* of those, shorter than the rule allows */
    double shortest_ns; /* of all, less the slew; may be negative: the level was not reached */
    double slew_ns;     /* of that pulse's first edge, by OSPEEDR as it was then */
    uint32_t begin_pc, end_pc; /* the two stores of the shortest */
    /* of the pulse that lasts */
    bool lasts;
    uint64_t begin_ps;
    double begin_slew_ns;
    uint32_t pulse_pc;
};

struct hil_pin_times {
    struct hil_board *board;
    const struct hil_pin_rule *rules;
    unsigned count;
    struct hil_pin_time of[HIL_PIN_RULES]; /* in the order of the rules */
    /* stores that changed a pin of a rule, from blocks met for the first time */
    uint64_t unlocated;
    struct {
        uint32_t address, size;
    } block[HIL_PIN_BLOCKS]; /* that store to a port of a rule */
    unsigned blocks;
    /* the instruction that runs, while a block is walked through */
    uint32_t pc;
    bool was_high[HIL_PIN_RULES];
};

/* Watch a board from now on, until it is destroyed; `rules` and `times` outlive it. Before its
 * first hil_board_run_until. `times` is zero, or what an earlier board with the same image has
 * left. At most HIL_PIN_RULES rules. */
void hil_pin_times_watch(struct hil_board *board, struct hil_pin_times *times,
                         const struct hil_pin_rule *rules, unsigned count);

#endif
