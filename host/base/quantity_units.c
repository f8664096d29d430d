#include "host/base/quantity_units.h"

#include <ctype.h>
#include <math.h>
#include <string.h>
#include <strings.h>

#include "host/base/quantity.h"

#define LB    44482216152605.0 /* 1 lbf = 4.4482216152605 N: 0.45359237 kg times 9.80665 m/s2 */
#define FEET  3048.0           /* 1 ft = 0.3048 m */
#define MILES 1609344.0        /* 5280 ft, in mm */

/* clang-format off */
#define OF_LENGTH       {1}
#define OF_AREA         {2}
#define OF_FORCE        {0, 1}
#define OF_TIME         {0, 0, 1}
#define OF_SPEED        {1, 0, -1}
#define OF_ACCELERATION {1, 0, -2}
#define OF_MASS         {-1, 1, 2}
#define OF_STRESS       {-2, 1}
#define OF_ANGLE        {0, 0, 0, 1}
#define OF_VOLTAGE      {0, 0, 0, 0, 1}
#define OF_RESISTANCE   {0, 0, 0, 0, 0, 1}
#define OF_TEMPERATURE  {0, 0, 0, 0, 0, 0, 1}
/* clang-format on */

const struct quantity_word quantity_words[] = {
    {"ft", OF_LENGTH, FEET, 1, -4, true},     {"in", OF_LENGTH, 254, 1, -4, true},
    {"mm", OF_LENGTH, 1, 1, -3, true},        {"cm", OF_LENGTH, 1, 1, -2, true},
    {"m", OF_LENGTH, 1, 1, 0, true},          {"km", OF_LENGTH, 1, 1, 3, false},
    {"lb", OF_FORCE, LB, 1, -13, true},       {"kip", OF_FORCE, LB, 1, -10, false},
    {"N", OF_FORCE, 1, 1, 0, true},           {"kN", OF_FORCE, 1, 1, 3, true},
    {"kgf", OF_FORCE, 980665, 1, -5, true},   {"kg", OF_MASS, 1, 1, 0, true},
    {"slug", OF_MASS, LB, FEET, -9, false},   {"s", OF_TIME, 1, 1, 0, false},
    {"ms", OF_TIME, 1, 1, -3, false},         {"us", OF_TIME, 1, 1, -6, false},
    {"min", OF_TIME, 60, 1, 0, false},        {"h", OF_TIME, 3600, 1, 0, false},
    {"d", OF_TIME, 86400, 1, 0, false},       {"mph", OF_SPEED, MILES, 3600, -3, false},
    {"kn", OF_SPEED, 1852, 3600, 0, false},   {"g", OF_ACCELERATION, 980665, 1, -5, false},
    {"psi", OF_STRESS, LB, 64516, -5, false}, /* 254 squared */
    {"ksi", OF_STRESS, LB, 64516, -2, false}, {"Pa", OF_STRESS, 1, 1, 0, false},
    {"kPa", OF_STRESS, 1, 1, 3, false},       {"MPa", OF_STRESS, 1, 1, 6, false},
    {"GPa", OF_STRESS, 1, 1, 9, false},       {"rad", OF_ANGLE, 1, 1, 0, false},
    {"deg", OF_ANGLE, M_PI, 180, 0, false},   {"V", OF_VOLTAGE, 1, 1, 0, false},
    {"mV", OF_VOLTAGE, 1, 1, -3, false},      {"ohm", OF_RESISTANCE, 1, 1, 0, false},
    {"kohm", OF_RESISTANCE, 1, 1, 3, false},  {"Mohm", OF_RESISTANCE, 1, 1, 6, false},
    {"K", OF_TEMPERATURE, 1, 1, 0, false},    {"F", OF_TEMPERATURE, 5, 9, 0, false},
};
const size_t quantity_word_count = sizeof quantity_words / sizeof quantity_words[0];
_Static_assert(sizeof quantity_words / sizeof quantity_words[0] <= QUANTITY_WORDS_MAX,
               "a unit has room for every word");

/* The first unit of a kind stands for it. */
static const struct quantity_kind kinds[] = {
    {"a length", "ft, in, mm, cm, m", "m", NULL},
    {"a force", "lb, kip, N, kN, kgf, kg", "N", "kg is the weight of that mass"},
    {"a speed", "ft/s, m/s, km/h, mph, kn, in/s, mm/s", "m/s", NULL},
    {"an acceleration", "ft/s2, m/s2, g", "m/s2", NULL},
    {"a time", "s, ms, us, min, h, d", "s", NULL},
    {"an angle", "deg, rad", "rad", NULL},
    {"a stiffness", "lb/ft, lb/in, kip/in, N/m, N/mm, kN/m", "N/m", NULL},
    {"a damping", "lb s/ft, lb s/in, N s/m", "N s/m", NULL},
    {"a stress", "psi, ksi, lb/ft2, Pa, kPa, MPa, GPa, N/m2, N/mm2", "Pa", NULL},
    {"an area", "in2, ft2, mm2, cm2, m2", "m2", NULL},
    {"a moment", "ft lb, in lb, N m", "N m", NULL},
    {"a stiffness of a hinge", "ft lb/rad, ft lb/deg, N m/rad", "N m/rad", NULL},
    {"a damping of a hinge", "ft lb s/rad, N m s/rad", "N m s/rad", NULL},
    {"a moment of inertia", "slug ft2, kg m2", "kg m2", NULL},
    {"a mass", "kg, slug", "kg", NULL},
    {"a rate of force", "lb/s, N/s, lb/h, N/h", "N/s", NULL},
    {"a voltage", "V, mV", "V", NULL},
    {"a resistance", "ohm, kohm, Mohm", "ohm", NULL},
    {"a difference of temperature", "F, K, degF, degC", "K", NULL},
    {"a thermal expansion", "1/F, 1/K", "1/K", NULL},
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
    {"kilonewtons", "kN"}, {"kp", "kgf"},        {"kgs", "kg"},         {"kilogram", "kg"},
    {"kilograms", "kg"},   {"kips", "kip"},      {"sec", "s"},          {"second", "s"},
    {"seconds", "s"},      {"minute", "min"},    {"minutes", "min"},    {"hour", "h"},
    {"hours", "h"},        {"day", "d"},         {"days", "d"},         {"kt", "kn"},
    {"knots", "kn"},       {"degree", "deg"},    {"degrees", "deg"},    {"degF", "F"},
    {"degC", "K"},
};

/* What a name may end with; the longer one comes first. */
static const struct {
    const char *ending, *unit;
} endings[] = {
    {"_lb_in_in", ""},
    {"_lb_in", "lb/in"},
    {"_lb_s_ft", "lb s/ft"},
    {"_ft_lb_rad", "ft lb/rad"},
    {"_slug_ft2", "slug ft2"},
    {"_ft_lb", "ft lb"},
    {"_lb_ft", "lb/ft"},
    {"_ft_s2", "ft/s2"},
    {"_ft_s", "ft/s"},
    {"_lb", "lb"},
    {"_ft", "ft"},
    {"_in", "in"},
    {"_mm", "mm"},
    {"_m", "m"},
    {"_N", "N"},
    {"_ms", "ms"},
    {"_s", "s"},
    {"_deg", "deg"},
};

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

/* A capital M is mega: "Mm" and "M" are no mm and m. Wholly in capitals is another spelling. */
static bool is_mega(const char *text, size_t length)
{
    return length <= 2 && text[0] == 'M' && (length == 1 || text[1] != 'M');
}

static bool is_any_case(const char *text, size_t length, const char *known)
{
    return strlen(known) == length && strncasecmp(text, known, length) == 0 &&
           !is_mega(text, length);
}

size_t quantity_word_find(const char *text, size_t length)
{
    for (size_t i = 0; i < quantity_word_count; i++) {
        const char *word = quantity_words[i].word;
        if (strlen(word) == length && memcmp(text, word, length) == 0)
            return i;
    }
    for (size_t i = 0; i < COUNT(spellings); i++) {
        if (is_any_case(text, length, spellings[i].spelling))
            return quantity_word_find(spellings[i].word, strlen(spellings[i].word));
    }
    for (size_t i = 0; i < quantity_word_count; i++) {
        if (quantity_words[i].any_case && is_any_case(text, length, quantity_words[i].word))
            return i;
    }
    return quantity_word_count;
}

static const char *skip(const char *text)
{
    return text + strspn(text, " \t\r\n");
}

static size_t letters(const char *text)
{
    size_t length = 0;
    while (isalpha((unsigned char)text[length]))
        length++;
    return length;
}

/* "m2", "m^2"; the text behind it, NULL: there is none. */
static const char *take_power(const char *text, int sign, struct quantity_unit *unit)
{
    size_t length = letters(text), word = quantity_word_find(text, length);
    int power = 1;
    if (length == 0 || word == quantity_word_count)
        return NULL;
    text += length;
    if (*text == '^' && (text[1] < '2' || text[1] > '4'))
        return NULL;
    text += *text == '^';
    if (*text >= '2' && *text <= '4')
        power = *text++ - '0';
    unit->power[word] += sign * power;
    return isalnum((unsigned char)*text) ? NULL : text;
}

bool quantity_unit_parse(const char *text, struct quantity_unit *unit)
{
    *unit = (struct quantity_unit){{0}};
    text = skip(text);
    if (*text == '1' && *skip(text + 1) == '/')
        text = skip(text + 1);
    while (text && *text && *text != '/') {
        text = take_power(text, 1, unit);
        text = text ? skip(text) : NULL;
    }
    if (text && *text == '/')
        text = take_power(skip(text + 1), -1, unit);
    return text && *skip(text) == '\0';
}

static void bases_of(const struct quantity_unit *unit, int base[QUANTITY_BASES])
{
    for (size_t b = 0; b < QUANTITY_BASES; b++) {
        base[b] = 0;
        for (size_t i = 0; i < quantity_word_count; i++)
            base[b] += unit->power[i] * quantity_words[i].base[b];
    }
}

bool quantity_unit_alike(const struct quantity_unit *a, const struct quantity_unit *b)
{
    int of_a[QUANTITY_BASES], of_b[QUANTITY_BASES];
    bases_of(a, of_a);
    bases_of(b, of_b);
    return memcmp(of_a, of_b, sizeof of_a) == 0;
}

void quantity_unit_weigh(struct quantity_unit *unit, const struct quantity_unit *wanted)
{
    struct quantity_unit mass, force;
    quantity_unit_parse("kg", &mass);
    quantity_unit_parse("kgf", &force);
    if (memcmp(unit, &mass, sizeof mass) == 0 && quantity_unit_alike(wanted, &force))
        *unit = force;
}

const struct quantity_kind *quantity_kind_at(size_t index)
{
    return index < COUNT(kinds) ? &kinds[index] : NULL;
}

const struct quantity_kind *quantity_kind_of(const char *text)
{
    struct quantity_unit unit, first;
    char name[40];
    if (!text || !*text || !quantity_unit_parse(text, &unit))
        return NULL;
    for (size_t i = 0; i < COUNT(kinds); i++) {
        size_t length = strcspn(kinds[i].units, ",");
        memcpy(name, kinds[i].units, length); /* a few letters */
        name[length] = '\0';
        if (quantity_unit_parse(name, &first) && quantity_unit_alike(&unit, &first))
            return &kinds[i];
    }
    return NULL;
}

const char *quantity_unit_of_name(const char *name)
{
    for (size_t i = 0; i < COUNT(endings); i++) {
        size_t length = strlen(name), end = strlen(endings[i].ending);
        if (length > end && strcmp(name + length - end, endings[i].ending) == 0)
            return endings[i].unit;
    }
    return "";
}
