#include "host/board/walksteps.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/board/configtext.h"

/* The n-th switch that is fitted, n from 0; 0: there are fewer. */
static unsigned fitted(const struct mr_config *config, unsigned n)
{
    for (unsigned i = 0; i < MR_CONFIG_SWITCHES; i++) {
        if (config->gate[i].step_codes && n-- == 0)
            return i + 1;
    }
    return 0;
}

static unsigned fitted_count(const struct mr_config *config)
{
    unsigned n = 0;
    while (fitted(config, n))
        n++;
    return n;
}

unsigned walk_steps_take(struct walk_steps *steps, const struct mr_config *config, uint8_t number,
                         double step_codes)
{
    if (!(step_codes >= MR_CONFIG_STEP_CODES) || steps->count == WALK_STEPS_KEPT)
        return 0;
    unsigned n = steps->count++;
    steps->number[n] = number;
    steps->codes[n] = step_codes;
    return fitted(config, n);
}

void walk_steps_bounced(struct walk_steps *steps, uint8_t number)
{
    if (steps->count && steps->number[steps->count - 1] == number)
        steps->count--;
}

bool walk_steps_over(const struct walk_steps *steps, const struct mr_config *config)
{
    return steps->count >= fitted_count(config);
}

/* The two that are nearest to each other. */
static void find_nearest(const struct walk_steps *steps, const struct mr_config *config,
                         struct walk_steps_found *found)
{
    found->apart_codes = (double)INFINITY;
    for (unsigned i = 1; i < steps->count; i++) {
        for (unsigned k = 0; k < i; k++) {
            double apart = fabs(steps->codes[i] - steps->codes[k]);
            if (apart >= found->apart_codes)
                continue;
            found->apart_codes = apart;
            found->near = fitted(config, k);
            found->near_other = fitted(config, i);
        }
    }
}

/* Are the configured steps as far from each other as they are built? */
static bool is_as_built(const struct mr_config *config, unsigned count)
{
    for (unsigned i = 1; i < count; i++) {
        for (unsigned k = 0; k < i; k++) {
            int one = config->gate[fitted(config, i) - 1].step_codes,
                other = config->gate[fitted(config, k) - 1].step_codes;
            if (abs(one - other) < (int)WALK_STEP_BUILT_CODES)
                return false;
        }
    }
    return true;
}

static bool is_sound(const struct mr_config *learned, char *why, size_t size)
{
    struct mr_config_reason reason;
    if (mr_config_check(learned, &reason) == MR_OK)
        return true;
    configtext_reason(learned, &reason, why, size);
    return false;
}

bool walk_steps_learn(const struct walk_steps *steps, const struct mr_config *config,
                      struct mr_config *learned, struct walk_steps_found *found, char *why,
                      size_t size)
{
    unsigned wanted = fitted_count(config);
    *learned = *config;
    *found = (struct walk_steps_found){.count = steps->count};
    if (steps->count != wanted) {
        snprintf(why, size, "%u steps of %u switches: trip each once, upfield first", steps->count,
                 wanted);
        return false;
    }
    for (unsigned n = 0; n < wanted; n++) {
        unsigned position = fitted(config, n);
        double configured = config->gate[position - 1].step_codes;
        double off = fabs(steps->codes[n] - configured);
        if (off >= WALK_STEP_FAR_CODES) {
            snprintf(
                why, size,
                "switch %u: a step of %.1f codes, configured %.0f: was it tripped in its turn? "
                "is its resistor the right one?",
                position, steps->codes[n], configured);
            return false;
        }
        found->furthest_codes = fmax(found->furthest_codes, off);
        learned->gate[position - 1].step_codes = (uint16_t)lround(steps->codes[n]);
    }
    find_nearest(steps, config, found);
    bool close = found->apart_codes < MR_CONFIG_STEP_APART_CODES;
    if (close && found->furthest_codes <= WALK_STEP_CURVE_CODES && is_as_built(config, wanted)) {
        found->configured_stay = true;
        *learned = *config;
    } else if (close) {
        snprintf(why, size,
                 "switches %u and %u: their steps are %.1f codes apart, %u are needed to tell them "
                 "apart: walk once more; else change a resistor, or keep the configured steps",
                 found->near, found->near_other, found->apart_codes, MR_CONFIG_STEP_APART_CODES);
        return false;
    }
    return is_sound(learned, why, size);
}
