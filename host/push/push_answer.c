#include "host/push/push_answer.h"

#include <math.h>
#include <stdio.h>

#define IN_PER_FT 12.0
#define SPRUNG    1.0 /* a ground that springs back more than it went is no ground */

const char *push_law_name(enum push_law law)
{
    static const char *const names[] = {"cannot tell", "elastic", "rigid"};
    return names[law];
}

static void add_law(struct answer *answer, const struct push_ground *ground)
{
    double ln = ground->log_odds;
    char times[32] = "over a million"; /* beyond, the gages' errors are not known as normal */
    if (fabs(ln) < log(1e6))
        snprintf(times, sizeof times, "%.3g", exp(fabs(ln)));
    answer_words(answer, "law", NULL, "%s", push_law_name(ground->law));
    answer_value(answer, "log_odds", NULL, UNIT_NUMBER, ln, 1);
    switch (ground->law) {
    case PUSH_ELASTIC:
        answer_sentence(answer, NULL,
                        "Elastic ground: mats move before they slide. These readings are %s times "
                        "as likely as by Coulomb's rigid law.",
                        times);
        break;
    case PUSH_RIGID:
        answer_sentence(answer, NULL,
                        "Coulomb's rigid law: nothing moves before it slides. These readings are "
                        "%s times as likely as by elastic ground within ten times of --expect. "
                        "No gear_ key is written.",
                        times);
        break;
    default:
        answer_sentence(answer, NULL,
                        "Cannot tell elastic ground from Coulomb's rigid law: the readings are "
                        "%s times as likely by %s, and %.0f times are asked for. Push harder "
                        "(to 0.8 of what slides), or read finer. No gear_ key is written.",
                        times, ln > 0.0 ? "elastic ground" : "the rigid law", PUSH_ODDS);
    }
}

/* `kept`: what a scene has without it; NULL: nothing. */
static void add_untold(struct answer *answer, const char *name, const struct push_told *told,
                       const char *kept)
{
    if (!isnan(told->of.value))
        return;
    answer_words(answer, NULL, name, "cannot tell: %s", told->reason);
    if (kept)
        answer_remark(answer, "; a scene keeps %s", kept);
}

static void add_bounds(struct answer *answer, const struct push_ground *ground)
{
    add_untold(answer, "gear_k_lb_ft", &ground->k_lb_ft, NULL);
    if (isnan(ground->k_lb_ft.of.value) && ground->k_lb_ft.of.low > 0.0) {
        answer_remark(answer, "; at least %.0f lb/ft", ground->k_lb_ft.of.low);
        answer_value(answer, "k_at_least_lb_ft", NULL, UNIT_NUMBER, ground->k_lb_ft.of.low, 0);
    }
    add_untold(answer, "gear_unloading", &ground->unloading, "1");
    add_untold(answer, "gear_axle_law", &ground->axle_law, "1");
    add_untold(answer, "f", &ground->friction, NULL);
    if (isnan(ground->friction.of.value)) {
        answer_remark(answer, "; at least %.3f", ground->friction.of.low);
        answer_value(answer, "f_at_least", NULL, UNIT_NUMBER, ground->friction.of.low, 3);
    }
    answer_words(answer, NULL, "gear_damping",
                 "cannot tell: readings at rest say nothing of it; a scene keeps 0.5 of critical");
}

static void add_axle_law(struct answer *answer, const struct push_interval *law)
{
    bool grows = law->low <= 1.0 && law->high >= 1.0, alike = law->low <= 0.0 && law->high >= 0.0;
    if (isnan(law->value))
        return;
    answer_sentence(answer, NULL, "Stiffness and load: %s.",
                    grows && alike ? "proportional (1) and independent (0) both fit; take more "
                                     "tests under both loads"
                    : grows        ? "proportional (1) fits, as friction's limit has it; "
                                     "independent (0) does not"
                    : alike        ? "independent (0) fits; proportional (1), as friction's limit "
                                     "has it, does not"
                                   : "between independent (0) and proportional (1) or beyond; "
                                     "neither fits");
}

static void add_doubts(struct answer *answer, const struct push_ground *ground)
{
    const struct push_interval *rho = &ground->unloading.of;
    if (ground->poor)
        answer_sentence(answer, NULL,
                        "Neither law fits well: readings scatter %.1f times as much as the gages "
                        "are said to (by chance once in 1,000). The intervals are wider by that. "
                        "Look at the curves: a bend, a drift or a rod that seats late is no noise.",
                        ground->scatter);
    if (!isnan(rho->value) && rho->low > SPRUNG)
        answer_sentence(answer, NULL,
                        "The mat came back farther than it went (%.2f, at least %.2f): was the "
                        "dial's zero kept, did the load shift? gear_unloading is written as 1.",
                        rho->value, rho->low);
    if (ground->law == PUSH_ELASTIC && ground->untold > 0)
        answer_sentence(answer, NULL,
                        "%zu test%s did not move enough to tell a stiffness and took no part in "
                        "it: stiff places are under-represented.",
                        ground->untold, ground->untold == 1 ? "" : "s");
}

void push_answer_law(struct answer *answer, const struct push_ground *ground,
                     const struct push_setting *setting)
{
    const struct push_interval *k = &ground->k_lb_ft.of;
    add_law(answer, ground);
    add_doubts(answer, ground);
    add_axle_law(answer, &ground->axle_law.of);
    if (!isnan(k->value))
        answer_sentence(answer, NULL,
                        "For this rig: %.4g lb pressed %u mat%s, which moved as one (--mats). All "
                        "together yield by %.4g lb/in; gear_k_lb_ft is of one mat: 12 in/ft / %u "
                        "of it. Another foot has another k.",
                        ground->axle_load_lb, setting->mats, setting->mats == 1 ? "" : "s",
                        k->value * setting->mats / IN_PER_FT, setting->mats);
    if (!isnan(k->value) && setting->mats == 1)
        answer_sentence(answer, NULL,
                        "A wheel whose foot is as long as a mat presses two mats nearly always: if "
                        "the rig's does, test it over a joint, with --mats 2.");
    answer_value(answer, "axle_load_lb", NULL, UNIT_NUMBER, ground->axle_load_lb, 1);
    answer_count(answer, "mats", NULL, (int64_t)setting->mats);
    answer_value(answer, "scatter", "scatter, in stated errors", UNIT_NUMBER, ground->scatter, 2);
    if (!isnan(ground->spread))
        answer_value(answer, "spread", "k from place to place, standard deviation of ln k",
                     UNIT_NUMBER, ground->spread, 2);
    add_bounds(answer, ground);
}

static void add_interval(struct answer *answer, const char *name, const char *label,
                         const struct push_interval *of, int decimals)
{
    char low[32], high[32];
    snprintf(low, sizeof low, "%s_low", name);
    snprintf(high, sizeof high, "%s_high", name);
    answer_value(answer, name, NULL, UNIT_NUMBER, of->value, decimals);
    answer_value(answer, low, NULL, UNIT_NUMBER, of->low, decimals);
    answer_value(answer, high, NULL, UNIT_NUMBER, of->high, decimals);
    if (!isnan(of->value))
        answer_words(answer, NULL, label, "%.*f (%.*f to %.*f)", decimals, of->value, decimals,
                     of->low, decimals, of->high);
    else if (isfinite(of->low))
        answer_words(answer, NULL, label, "above %.*f", decimals, of->low);
    else
        answer_words(answer, NULL, label, "-");
}

void push_answer_tests(struct answer *answer, const struct push_readings *readings,
                       const struct push_ground *ground)
{
    answer_table(answer, "tests", "Tests");
    for (size_t i = 0; i < readings->count; i++) {
        const struct push_series *series = &readings->series[i];
        const struct push_fit *fit = &ground->fit[i];
        answer_row(answer);
        answer_words(answer, "test", "test", "%s", series->name);
        answer_value(answer, "load_lb", "load, lb", UNIT_NUMBER, series->load_lb, 1);
        answer_count(answer, "readings", "readings", (int64_t)series->count);
        answer_value(answer, "most_lb", "most|force, lb", UNIT_NUMBER, fit->most_lb, 1);
        add_interval(answer, "k_lb_in", "all mats,|lb/in (95 %)", &fit->k_lb_in, 0);
        add_interval(answer, "unloading", "springs back|(95 %)", &fit->unloading, 2);
        answer_value(answer, "slid_lb", "slid|at, lb", UNIT_NUMBER, fit->limit_lb, 1);
        answer_value(answer, "chi_square", NULL, UNIT_NUMBER, fit->chi_square, 1);
        answer_value(answer, "rigid_chi_square", NULL, UNIT_NUMBER, fit->rigid_chi_square, 1);
        answer_count(answer, "freedom", NULL, (int64_t)fit->freedom);
        answer_words(answer, NULL, "chi2 elastic,|rigid (freedom)", "%.0f, %.0f (%zu)",
                     fit->chi_square, fit->rigid_chi_square, fit->freedom);
    }
    answer_close(answer);
}
