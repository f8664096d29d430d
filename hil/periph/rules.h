/* Timing and electrical rules: requirements of the chips around the microcontroller, checked while
 * the firmware uses their pins.
 *
 * The rules are rows of rules.def, each with its limit and source. A store to a port has the time
 * of its instruction (hil/core/core.h). A pin reaches its new level only after the slew time for
 * the OSPEEDR setting, while the next edge may be effective immediately after the next store. The
 * duration of a level is therefore the time between the two stores minus the slew time of the first
 * edge.
 *
 * A violation stops the run (MR_HALTED) with a message that contains the measured value, both
 * instructions and the source of the limit; or it is only counted. The tally of a rule contains its
 * measurements. Rules have no other effect on the board.
 *
 * The state of pins is recorded here when the firmware stores to them (output, open drain).
 * Peripherals report their own use of pins (spi.c, hil/chips/w25q.c). */
#ifndef MATRIG_HIL_RULES_H
#define MATRIG_HIL_RULES_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

enum hil_rule {
#define PIN(NAME, port, pin, words)
#define RULE(NAME, kind, least_ns, what, source) HIL_RULE_##NAME,
#include "hil/periph/rules.def"
    HIL_RULE_COUNT
};

enum hil_rules_pin {
#define PIN(NAME, port, pin, words) HIL_RULES_##NAME,
#define RULE(NAME, kind, least_ns, what, source)
#include "hil/periph/rules.def"
    HIL_RULES_PIN_COUNT
};

/* Measurements of one rule. */
struct hil_rule_tally {
    uint64_t measurement_count;
    uint64_t violation_count;
    double limit_ns; /* limit of the rule when `worst_ns` was measured */
    /* measured value, after subtraction of slew_ns, that was closest to the limit or farthest
     * beyond it */
    double worst_ns;
    double slew_ns; /* slew time in that measurement */
    /* instructions at the start and end of that measurement; 0: an event in hardware */
    uint32_t from_pc, to_pc;
};

struct hil_rules_edges {
    bool is_high;
    /* last edges of the pin; ps 0: none since the reset, or one whose instruction is not known */
    struct hil_timestamp last_rise, last_fall;
};

/* Contains no pointers: a copy is a snapshot. */
struct hil_rules {
    struct hil_rules_edges pin[HIL_RULES_PIN_COUNT];
    uint64_t unlocated_edge_count; /* edges whose instruction was not found; they are not checked */
    struct hil_timestamp last_bus_stop; /* last stop on the thermometer's bus */
    struct hil_rule_tally tally[HIL_RULE_COUNT];
};

struct hil_rules_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_rules *state;
    /* writes the function at an address as text; NULL: no names are available */
    const char *(*get_function_name)(void *context, uint32_t pc);
    void *context;
};

/* Call when the core has stored to a port: records the edges and checks the rules of pins. `device`
 * is a struct hil_rules_device. */
void hil_rules_on_store(void *device, unsigned port);
/* Call when the core reads IDR while `pins` float. Checks the rule that their value must not affect
 * the program. */
void hil_rules_check_floating(void *device, unsigned port, uint32_t value, uint32_t pins);
/* As hil_rules_check_floating, for a word that a peripheral received from a pin. */
void hil_rules_check_unknown(struct hil_rules_device *dev, const char *pin, uint32_t value,
                             uint32_t bits);
/* Call after a reset: edges caused by the reset do not start or end a measurement. */
void hil_rules_reset(struct hil_rules_device *dev);
static inline const struct hil_rules_edges *hil_rules_get_edges(const struct hil_rules_device *dev,
                                                                enum hil_rules_pin pin)
{
    return &dev->state->pin[pin];
}
bool hil_rules_are_checked(const struct hil_rules_device *dev);
/* Checks a MINIMUM rule for the time between two moments. A moment with ps 0 is unknown and is not
 * checked. */
void hil_rules_check_interval(struct hil_rules_device *dev, enum hil_rule rule,
                              struct hil_timestamp from, struct hil_timestamp to);
/* As hil_rules_check_interval, for a time in nanoseconds; `least_ns` 0: the limit in rules.def. */
void hil_rules_check_time(struct hil_rules_device *dev, enum hil_rule rule, double ns,
                          double least_ns, uint32_t pc);
/* Records that a FAULT rule was met, or violated with a short explanation. */
void hil_rules_record_pass(struct hil_rules_device *dev, enum hil_rule rule);
__attribute__((format(printf, 4, 5))) void hil_rules_record_violation(struct hil_rules_device *dev,
                                                                      enum hil_rule rule,
                                                                      uint32_t pc,
                                                                      const char *format, ...);
double hil_rules_min_period_ns(const struct hil_rules_device *dev, unsigned port, unsigned pin);

/* Rule with this name; HIL_RULE_COUNT: there is none. */
enum hil_rule hil_rule_by_name(const char *name, size_t length);
/* Number of violated rules among those that are only counted, and the total number of their
 * violations. */
unsigned hil_rules_count_violated(const struct hil_rules_device *dev, uint64_t *times);
/* Prints the tallies as a table. */
void hil_rules_print_tallies(const struct hil_rules_device *dev, FILE *out);

#endif
