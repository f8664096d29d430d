#include "host/compare/agree.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "host/base/units.h"

#define BEYOND_TWO 0.0455 /* share of a normal distribution beyond two standard deviations */

const char *compare_value_text(enum compare_value value)
{
    static const char *const text[COMPARE_VALUES] = {"peak", "end", "arrival"};
    return text[value];
}

static double en_of(const struct compare_channel *c, enum compare_value value)
{
    return value == COMPARE_PEAK ? c->peak_en : value == COMPARE_END ? c->end_en : c->arrival_en;
}

static void take(struct compare_agreement *a, const struct compare_channel *c,
                 enum compare_value value)
{
    const struct signal_moment *measured = value == COMPARE_PEAK ? &c->f.peak_measured
                                         : value == COMPARE_END  ? &c->end_measured
                                                                 : &c->f.arrival_measured;
    const struct signal_moment *simulated = value == COMPARE_PEAK ? &c->f.peak_simulated
                                          : value == COMPARE_END  ? &c->end_simulated
                                                                  : &c->f.arrival_simulated;
    bool time = value == COMPARE_ARRIVAL;
    a->channel = c;
    a->value = value;
    a->measured = time ? measured->t_s : measured->value;
    a->measured_error = time ? measured->t_error_s : measured->error;
    a->simulated = time ? simulated->t_s : simulated->value;
    a->simulated_error = time ? simulated->t_error_s : simulated->error;
    a->difference = a->measured - a->simulated;
    a->error = hypot(a->measured_error, a->simulated_error);
    a->en = en_of(c, value);
    a->measured_t_s = value == COMPARE_END ? (double)NAN : measured->t_s;
    a->simulated_t_s = value == COMPARE_END ? (double)NAN : simulated->t_s;
}

void compare_agreement(const struct compare_figures *figures, struct compare_agreement *agreement)
{
    *agreement = (struct compare_agreement){.run = figures->run,
                                            .against = figures->against[0] ? figures->against
                                                                           : "the simulation",
                                            .en = (double)NAN};
    for (size_t i = 0; i < figures->channels; i++) {
        const struct compare_channel *c = &figures->channel[i];
        agreement->left_out += !c->compared;
        for (int value = 0; value < COMPARE_VALUES && c->compared; value++) {
            double en = en_of(c, (enum compare_value)value);
            agreement->unknown += isnan(en) ? 1u : 0u;
            agreement->judged += isnan(en) ? 0u : 1u;
            agreement->differ += en > 1.0;
            if (!isnan(en) && !(en <= agreement->en))
                take(agreement, c, (enum compare_value)value);
        }
    }
}

/* ---- the sentence ---- */

struct text {
    char *out;
    size_t at;
};

static void add(struct text *text, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void add(struct text *text, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(text->out + text->at, COMPARE_SENTENCE - text->at, format, arguments);
    va_end(arguments);
    text->at += length > 0 ? (size_t)length : 0;
    if (text->at >= COMPARE_SENTENCE)
        text->at = COMPARE_SENTENCE - 1;
}

static void add_en(struct text *text, double en)
{
    if (isinf(en))
        add(text, "En without end, for neither has an error");
    else
        add(text, "En %.*f", en < 99.95 ? 1 : 0, en);
}

/* What is not in the sentence's count. */
static void add_rest(struct text *text, const struct compare_agreement *a)
{
    if (a->unknown)
        add(text, "; %zu not known", a->unknown);
    if (a->left_out)
        add(text, "; %zu transducer%s not compared", a->left_out, a->left_out == 1 ? "" : "s");
}

/* "0.7542 +- 0.0030 in at 2.422 s" */
static void add_side(struct text *text, const struct compare_agreement *a, bool measured, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    bool time = a->value == COMPARE_ARRIVAL;
    double factor = time ? 1.0 : length->factor,
           t_s = measured ? a->measured_t_s : a->simulated_t_s;
    int digits = time || !si ? 4 : 2;
    add(text, "%.*f +- %.*f %s", digits, (measured ? a->measured : a->simulated) * factor, digits,
        (measured ? a->measured_error : a->simulated_error) * factor, time ? "s" : length->text);
    if (!time && !isnan(t_s))
        add(text, " at %.3f s", t_s);
}

static void add_place(struct text *text, const struct compare_agreement *a, bool si)
{
    const struct unit *station = unit_of(UNIT_STATION, si);
    add(text, "transducer %" PRId64 ", %.1f %s", a->channel->number,
        a->channel->station_ft * station->factor, station->text);
}

static void add_difference(struct text *text, const struct compare_agreement *a, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    bool time = a->value == COMPARE_ARRIVAL;
    double factor = time ? 1.0 : length->factor;
    int digits = time || !si ? 4 : 2;
    add(text, "RUN %" PRId64 " as measured differs from %s, most in the %s at ", a->run, a->against,
        compare_value_text(a->value));
    add_place(text, a, si);
    add(text, ": the simulated%s is ", a->value == COMPARE_END ? ", at rest," : "");
    add_side(text, a, false, si);
    add(text, "%s, %.*f %s %s than the measured, ", time ? " after touchdown" : "", digits,
        fabs(a->difference) * factor, time ? "s" : length->text,
        time                  ? (a->difference < 0.0 ? "later" : "earlier")
        : a->difference < 0.0 ? "more"
                              : "less");
    add_side(text, a, true, si);
    add(text, "; ");
    add_en(text, a->en);
    if (a->error > 0.0)
        add(text, ", the difference over twice their common error of %.*f %s", digits,
            a->error * factor, time ? "s" : length->text);
    add(text, "; %zu of %zu values differ by more than twice their errors, %.1f would by chance",
        a->differ, a->judged, BEYOND_TWO * (double)a->judged);
}

void compare_sentence(const struct compare_agreement *a, bool si, char out[COMPARE_SENTENCE])
{
    struct text text = {out, 0};
    out[0] = '\0';
    if (!a->channel) {
        add(&text,
            "whether RUN %" PRId64
            " agrees with %s is not known: there is no peak, end or arrival with its error",
            a->run, a->against);
    } else if (a->differ) {
        add_difference(&text, a, si);
    } else {
        add(&text,
            "RUN %" PRId64 " as measured agrees with %s: all %zu peaks, ends and arrivals within "
            "twice their errors, the largest ",
            a->run, a->against, a->judged);
        add_en(&text, a->en);
        add(&text, " (%s, ", compare_value_text(a->value));
        add_place(&text, a, si);
        add(&text, ")");
    }
    add_rest(&text, a);
}

void compare_sentence_of(const struct compare_figures *const *figures, size_t count, bool si,
                         char out[COMPARE_SENTENCE])
{
    char worst_text[COMPARE_SENTENCE];
    struct compare_agreement worst = {.against = "the simulation", .en = (double)NAN};
    struct text text = {out, 0};
    size_t differ = 0, known = 0;
    for (size_t i = 0; i < count; i++) {
        struct compare_agreement one;
        compare_agreement(figures[i], &one);
        differ += one.differ > 0;
        known += one.channel != NULL;
        if (one.channel && !(one.en <= worst.en))
            worst = one;
    }
    compare_sentence(&worst, si, worst_text);
    out[0] = '\0';
    if (count > 1 && known)
        add(&text, "%zu of %zu landings differ from what was simulated; ", differ, known);
    add(&text, "%s", worst_text);
}
