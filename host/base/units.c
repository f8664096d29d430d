#include "host/base/units.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "host/base/quantity.h"

/* The factors are exact by definition: 1 ft = 0.3048 m, 1 in = 25.4 mm, 1 lb = 4.4482216152605
 * N. */
static const struct unit units[2][UNIT_KIND_COUNT] = {
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

const struct unit *unit_get(enum unit_kind kind, bool si)
{
    return &units[si][kind];
}

const struct unit *unit_get_json(enum unit_kind kind)
{
    return unit_get(kind == UNIT_MOVEMENT ? UNIT_STATION : kind, false);
}

/* Units of calibration points, a subset of the units in quantity.h. kg means the weight of that
 * mass. */
static const struct unit_word unit_word_table[] = {
    {"in", UNIT_DISPLACEMENT}, {"mm", UNIT_DISPLACEMENT}, {"cm", UNIT_DISPLACEMENT},
    {"m", UNIT_DISPLACEMENT},  {"ft", UNIT_DISPLACEMENT}, {"lb", UNIT_TENSION},
    {"N", UNIT_TENSION},       {"kN", UNIT_TENSION},      {"kg", UNIT_TENSION},
};

const struct unit_word *unit_word_get(size_t index)
{
    return index < sizeof unit_word_table / sizeof unit_word_table[0] ? &unit_word_table[index]
                                                                      : NULL;
}

const struct unit_word *unit_word_find(const char *word, size_t length)
{
    /* in a column of forces "kn" means kN, not knots */
    const char *known = length == 2 && strncasecmp(word, "kn", 2) == 0
                          ? "kN"
                          : quantity_unit_spelling(word, length);
    if (strcmp(known, "kgf") == 0)
        known = "kg";
    for (size_t i = 0; i < sizeof unit_word_table / sizeof unit_word_table[0]; i++) {
        if (strcmp(known, unit_word_table[i].word) == 0)
            return &unit_word_table[i];
    }
    return NULL;
}

double unit_round_to_zero(double value, double resolution)
{
    return fabs(value) < 0.5 * resolution ? 0.0 : value;
}

int unit_decimals(enum unit_kind kind, bool si, int decimals)
{
    int kept = decimals -
               (int)floor(log10(unit_get(kind, si)->factor / unit_get(kind, false)->factor));
    return kept > 0 ? kept : 0;
}

static const char *format_value(enum unit_kind kind, bool si, double value, int decimals, bool plus,
                                char out[UNIT_TEXT_SIZE])
{
    const struct unit *unit = unit_get(kind, si);
    const int kept = unit_decimals(kind, si, decimals);
    const double shown = unit_round_to_zero(value * unit->factor, pow(10.0, -kept));
    if (isfinite(value))
        snprintf(out, UNIT_TEXT_SIZE, plus ? "%+.*f %s" : "%.*f %s", kept, shown, unit->text);
    else
        snprintf(out, UNIT_TEXT_SIZE, "-");
    return out;
}

const char *unit_value_text(enum unit_kind kind, bool si, double value, int decimals,
                            char out[UNIT_TEXT_SIZE])
{
    return format_value(kind, si, value, decimals, false, out);
}

const char *unit_signed_text(enum unit_kind kind, bool si, double value, int decimals,
                             char out[UNIT_TEXT_SIZE])
{
    return format_value(kind, si, value, decimals, true, out);
}
