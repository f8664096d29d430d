/* Timing and electrical rules: the requirements of the chips around the microcontroller, checked
 * against the firmware's use of their pins while it runs.
 *
 * The rules are rows of rules.def, each with its limit and its source. Stores to a port have the
 * time of their own instruction (hil/core/core.h); an edge is not over when its store is: a level
 * is reached only after the slew that OSPEEDR allows, and the far chip sees its end as early as the
 * next store. So a level lasts from store to store less the slew of its own edge.
 *
 * A broken rule stops the run (MR_HALTED) with the measured value, both instructions and the source
 * of the limit; or it is only counted. The tally of a rule has its measurements. Rules do not
 * change the board's behaviour otherwise.
 *
 * Pins are kept here as the firmware stores to them (output, open drain). A peripheral reports its
 * own use of pins (spi.c, hil/chips/w25q.c). */
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
    HIL_RULES
};

enum hil_rules_pin {
#define PIN(NAME, port, pin, words) HIL_RULES_##NAME,
#define RULE(NAME, kind, least_ns, what, source)
#include "hil/periph/rules.def"
    HIL_RULES_PINS
};

/* Of one rule. */
struct hil_tally {
    uint64_t judged;
    uint64_t broken;
    double least_ns;         /* what the rule wanted when `worst_ns` was measured */
    double worst_ns;         /* nearest to what it wanted, or beyond; slew is taken off */
    double slew_ns;          /* which was this */
    uint32_t from_pc, to_pc; /* who began and ended it; 0: the hardware */
};

struct hil_rules_edges {
    bool high;
    struct hil_moment rose, fell; /* ps 0: not since the reset, or of unknown origin */
};

/* Without pointers: a copy is a snapshot. */
struct hil_rules {
    struct hil_rules_edges pin[HIL_RULES_PINS];
    uint64_t unplaced;         /* edges that no instruction was found for: they are not judged */
    struct hil_moment stopped; /* the thermometer's bus */
    struct hil_tally tally[HIL_RULES];
};

struct hil_rules_device {
    HIL_NEIGHBOURS;
    struct hil_rules *state;
    /* Words for the function at an address; NULL: there are no names. */
    const char *(*function)(void *who, uint32_t pc);
    void *who;
};

/* The core has stored to a port: keep the edges, hold the rules of pins. `device` is a struct
 * hil_rules_device. */
void hil_rules_stored(void *device, unsigned port);
/* The core reads IDR, and nothing holds these pins: it must not matter what they are. */
void hil_rules_floats(void *device, unsigned port, uint32_t value, uint32_t pins);
/* The same of a word that a peripheral received from a pin. */
void hil_rules_unknown(struct hil_rules_device *dev, const char *pin, uint32_t value,
                       uint32_t bits);
/* A reset moved the pins: this begins or ends nothing. */
void hil_rules_reset(struct hil_rules_device *dev);
static inline const struct hil_rules_edges *hil_rules_edges(const struct hil_rules_device *dev,
                                                            enum hil_rules_pin pin)
{
    return &dev->state->pin[pin];
}
/* Are rules held at all? */
bool hil_rules_hold(const struct hil_rules_device *dev);
/* Hold a LEAST rule against the time from one moment to another. Moments of ps 0 are not known, and
 * nothing is judged by them. */
void hil_rules_judge(struct hil_rules_device *dev, enum hil_rule rule, struct hil_moment from,
                     struct hil_moment to);
/* The same, of a time in nanoseconds; `least_ns` 0: the limit of the row. */
void hil_rules_measure(struct hil_rules_device *dev, enum hil_rule rule, double ns, double least_ns,
                       uint32_t pc);
/* A FAULT rule: kept, or broken with a few words about it. */
void hil_rules_kept(struct hil_rules_device *dev, enum hil_rule rule);
__attribute__((format(printf, 4, 5))) void hil_rules_broken(struct hil_rules_device *dev,
                                                            enum hil_rule rule, uint32_t pc,
                                                            const char *format, ...);
double hil_rules_period_ns(const struct hil_rules_device *dev, unsigned port, unsigned pin);

/* The rule of that name, or HIL_RULES. */
enum hil_rule hil_rule_named(const char *name, size_t length);
/* How many of the rules that only count were broken, and how often in all. */
unsigned hil_rules_counted(const struct hil_rules_device *dev, uint64_t *times);
/* The tallies as a table. */
void hil_rules_print(const struct hil_rules_device *dev, FILE *out);

#endif
