#include "host/base/units.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* 1 ft = 0.3048 m, 1 in = 25.4 mm, 1 lb = 4.4482216152605 N: exact by definition. */
static const struct unit units[2][UNIT_ALL] = {
    {{"ft", "ft", 1.0},
     {"in", "in", 1.0},
     {"ft/s", "ft_s", 1.0},
     {"ft/s2", "ft_s2", 1.0},
     {"lb", "lb", 1.0},
     {"", "", 1.0},
     {"s", "s", 1.0},
     {"in", "in", 12.0},
     {"lb/ft", "lb_ft", 1.0}},
    {{"m", "m", 0.3048},
     {"mm", "mm", 25.4},
     {"m/s", "m_s", 0.3048},
     {"m/s2", "m_s2", 0.3048},
     {"N", "N", 4.4482216152605},
     {"", "", 1.0},
     {"s", "s", 1.0},

     {"mm", "mm", 304.8},
     {"N/m", "N_m", 4.4482216152605 / 0.3048}},
};

const struct unit *unit_of(enum unit_kind kind, bool si)
{
    return &units[si][kind];
}

const struct unit *unit_given(enum unit_kind kind)
{
    return unit_of(kind == UNIT_MOVEMENT ? UNIT_STATION : kind, false);
}

/* Exact by definition: 1 in = 25.4 mm, 1 lbf = 4.4482216152605 N, 1 kgf = 9.80665 N. A weight on a
 * scale is read in kg. */
#define MM_PER_IN 25.4
#define N_PER_LB  4.4482216152605
#define N_PER_KG  9.80665

static const struct unit_word written[] = {
    {"in", UNIT_DISPLACEMENT, 1.0},
    {"mm", UNIT_DISPLACEMENT, 1.0 / MM_PER_IN},
    {"cm", UNIT_DISPLACEMENT, 10.0 / MM_PER_IN},
    {"m", UNIT_DISPLACEMENT, 1000.0 / MM_PER_IN},
    {"ft", UNIT_DISPLACEMENT, 12.0},
    {"lb", UNIT_TENSION, 1.0},
    {"N", UNIT_TENSION, 1.0 / N_PER_LB},
    {"kN", UNIT_TENSION, 1000.0 / N_PER_LB},
    {"kg", UNIT_TENSION, N_PER_KG / N_PER_LB},
};

static const struct {
    const char *spelling, *word;
} spellings[] = {
    {"inch", "in"},        {"inches", "in"},     {"ins", "in"},         {"millimetre", "mm"},
    {"millimetres", "mm"}, {"millimeter", "mm"}, {"millimeters", "mm"}, {"centimetre", "cm"},
    {"centimetres", "cm"}, {"centimeter", "cm"}, {"centimeters", "cm"}, {"metre", "m"},
    {"metres", "m"},       {"meter", "m"},       {"meters", "m"},       {"foot", "ft"},
    {"feet", "ft"},        {"lbs", "lb"},        {"lbf", "lb"},         {"pound", "lb"},
    {"pounds", "lb"},      {"newton", "N"},      {"newtons", "N"},      {"kilonewton", "kN"},
    {"kilonewtons", "kN"}, {"kgf", "kg"},        {"kgs", "kg"},         {"kp", "kg"},
    {"kilogram", "kg"},    {"kilograms", "kg"},
};

/* A capital M is mega: "Mm" and "M" are no mm and m. Wholly in capitals is another spelling. */
static bool is_mega(const char *word, size_t length)
{
    return length <= 2 && word[0] == 'M' && (length == 1 || word[1] != 'M');
}

static bool is_word(const char *word, size_t length, const char *known)
{
    return strlen(known) == length && strncasecmp(word, known, length) == 0 &&
           !is_mega(word, length);
}

const struct unit_word *unit_words(size_t index)
{
    return index < sizeof written / sizeof written[0] ? &written[index] : NULL;
}

const struct unit_word *unit_read(const char *word, size_t length)
{
    for (size_t i = 0; i < sizeof spellings / sizeof spellings[0]; i++) {
        if (is_word(word, length, spellings[i].spelling))
            return unit_read(spellings[i].word, strlen(spellings[i].word));
    }
    for (size_t i = 0; i < sizeof written / sizeof written[0]; i++) {
        if (is_word(word, length, written[i].word))
            return &written[i];
    }
    return NULL;
}

/* Seconds; 0: no time. */
static double time_s(const char *word)
{
    static const struct {
        const char *word;
        double s;
    } times[] = {{"s", 1.0}, {"ms", 1e-3}, {"min", 60.0}, {"h", 3600.0}};
    for (size_t i = 0; i < sizeof times / sizeof times[0]; i++) {
        if (strcmp(times[i].word, word) == 0)
            return times[i].s;
    }
    return 0.0;
}

/* Speeds and accelerations in the report's units; as they are written, capitals apart. */
static const struct {
    const char *word;
    char kind;
    double factor;
} rates[] = {
    {"ft/s", 'v', 1.0},
    {"m/s", 'v', 1000.0 / MM_PER_IN / 12.0},
    {"km/h", 'v', 1e6 / 3600.0 / MM_PER_IN / 12.0},
    {"mph", 'v', 5280.0 / 3600.0},
    {"kn", 'v', 1852e3 / 3600.0 / MM_PER_IN / 12.0},
    {"kt", 'v', 1852e3 / 3600.0 / MM_PER_IN / 12.0},
    {"ft/s2", 'a', 1.0},
    {"m/s2", 'a', 1000.0 / MM_PER_IN / 12.0},
    {"ft/s^2", 'a', 1.0},
    {"m/s^2", 'a', 1000.0 / MM_PER_IN / 12.0},
    {"g", 'a', 9806.65 / MM_PER_IN / 12.0},
};

static char rate_of(const char *word, double *factor)
{
    for (size_t i = 0; i < sizeof rates / sizeof rates[0]; i++) {
        if (strcmp(rates[i].word, word) == 0) {
            *factor = rates[i].factor;
            return rates[i].kind;
        }
    }
    return 0;
}

bool unit_convert(const char *from, const char *to, double *factor)
{
    double a_rate = 1.0, b_rate = 1.0;
    const char a_kind = rate_of(from, &a_rate), b_kind = rate_of(to, &b_rate);
    const struct unit_word *a = unit_read(from, strlen(from)), *b = unit_read(to, strlen(to));
    double a_s = time_s(from), b_s = time_s(to);
    if (strcmp(from, to) == 0)
        *factor = 1.0;
    else if (a && b && a->kind == b->kind)
        *factor = a->factor / b->factor;
    else if (a_s > 0.0 && b_s > 0.0)
        *factor = a_s / b_s;
    else if (a_kind && a_kind == b_kind)
        *factor = a_rate / b_rate;
    else
        return false;
    return true;
}

double unit_tidy(double value, double least)
{
    return fabs(value) < 0.5 * least ? 0.0 : value;
}

int unit_decimals(enum unit_kind kind, bool si, int decimals)
{
    int kept = decimals -
               (int)floor(log10(unit_of(kind, si)->factor / unit_of(kind, false)->factor));
    return kept > 0 ? kept : 0;
}

static const char *text_of(enum unit_kind kind, bool si, double value, int decimals, bool plus,
                           char out[UNIT_TEXT])
{
    const struct unit *unit = unit_of(kind, si);
    const int kept = unit_decimals(kind, si, decimals);
    const double shown = unit_tidy(value * unit->factor, pow(10.0, -kept));
    if (isfinite(value))
        snprintf(out, UNIT_TEXT, plus ? "%+.*f %s" : "%.*f %s", kept, shown, unit->text);
    else
        snprintf(out, UNIT_TEXT, "-");
    return out;
}

const char *unit_value_text(enum unit_kind kind, bool si, double value, int decimals,
                            char out[UNIT_TEXT])
{
    return text_of(kind, si, value, decimals, false, out);
}

const char *unit_signed_text(enum unit_kind kind, bool si, double value, int decimals,
                             char out[UNIT_TEXT])
{
    return text_of(kind, si, value, decimals, true, out);
}
