#include "host/base/quantity.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/decimal.h"

/* Base dimensions of units. Mass is derived: force x time^2 / length. */
enum dimension {
    DIMENSION_LENGTH,
    DIMENSION_FORCE,
    DIMENSION_TIME,
    DIMENSION_ANGLE,
    DIMENSION_TEMPERATURE,
    DIMENSION_COUNT
};

#define LB_NUMERATOR \
    44482216152605.0             /* 1 lbf = 4.4482216152605 N: 0.45359237 kg times 9.80665 m/s2 */
#define FOOT_NUMERATOR 3048.0    /* 1 ft = 0.3048 m */
#define MILE_NUMERATOR 1609344.0 /* 1 mile = 5280 ft, in mm */

/* clang-format off */
#define DIM_LENGTH       {1}
#define DIM_AREA         {2}
#define DIM_FORCE        {0, 1}
#define DIM_TIME         {0, 0, 1}
#define DIM_SPEED        {1, 0, -1}
#define DIM_ACCELERATION {1, 0, -2}
#define DIM_MASS         {-1, 1, 2}
#define DIM_STRESS       {-2, 1}
#define DIM_ANGLE        {0, 0, 0, 1}
#define DIM_TEMPERATURE  {0, 0, 0, 0, 1}
/* clang-format on */

/* The unit equals numerator / denominator * 10^exponent10 in SI units of its dimensions.
 * `numerator` and `denominator` are integers, except for pi. */
struct unit_symbol {
    const char *text;
    signed char power[DIMENSION_COUNT];
    double numerator, denominator;
    int exponent10;
    bool ignores_case; /* "LB" is accepted as "lb" */
};

static const struct unit_symbol unit_symbols[] = {
    {"ft", DIM_LENGTH, FOOT_NUMERATOR, 1, -4, true},
    {"in", DIM_LENGTH, 254, 1, -4, true},
    {"mm", DIM_LENGTH, 1, 1, -3, true},
    {"cm", DIM_LENGTH, 1, 1, -2, true},
    {"m", DIM_LENGTH, 1, 1, 0, true},
    {"km", DIM_LENGTH, 1, 1, 3, false},
    {"lb", DIM_FORCE, LB_NUMERATOR, 1, -13, true},
    {"kip", DIM_FORCE, LB_NUMERATOR, 1, -10, false},
    {"N", DIM_FORCE, 1, 1, 0, true},
    {"kN", DIM_FORCE, 1, 1, 3, true},
    {"kgf", DIM_FORCE, 980665, 1, -5, true},
    {"kg", DIM_MASS, 1, 1, 0, true},
    {"slug", DIM_MASS, LB_NUMERATOR, FOOT_NUMERATOR, -9, false},
    {"s", DIM_TIME, 1, 1, 0, false},
    {"ms", DIM_TIME, 1, 1, -3, false},
    {"us", DIM_TIME, 1, 1, -6, false},
    {"min", DIM_TIME, 60, 1, 0, false},
    {"h", DIM_TIME, 3600, 1, 0, false},
    {"d", DIM_TIME, 86400, 1, 0, false},
    {"mph", DIM_SPEED, MILE_NUMERATOR, 3600, -3, false},
    {"kn", DIM_SPEED, 1852, 3600, 0, false},
    {"g", DIM_ACCELERATION, 980665, 1, -5, false},
    {"psi", DIM_STRESS, LB_NUMERATOR, 64516, -5, false},
    {"ksi", DIM_STRESS, LB_NUMERATOR, 64516, -2, false},
    {"Pa", DIM_STRESS, 1, 1, 0, false},
    {"kPa", DIM_STRESS, 1, 1, 3, false},
    {"MPa", DIM_STRESS, 1, 1, 6, false},
    {"GPa", DIM_STRESS, 1, 1, 9, false},
    {"rad", DIM_ANGLE, 1, 1, 0, false},
    {"deg", DIM_ANGLE, M_PI, 180, 0, false},
    {"K", DIM_TEMPERATURE, 1, 1, 0, false},
    {"F", DIM_TEMPERATURE, 5, 9, 0, false},
};

/* quantity_kind_find compares only the first unit of each kind. */
static const struct quantity_kind quantity_kinds[] = {
    {"a length", "ft, in, mm, cm, m", "m", NULL},
    {"a force", "lb, kip, N, kN, kgf, kg", "N", "kg means the weight of that mass"},
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
    {"a difference of temperature", "F, K, degF, degC", "K", NULL},
    {"a thermal expansion", "1/F, 1/K", "1/K", NULL},
};

/* Each of these spellings may also have a plural s. */
static const struct {
    const char *spelling, *word;
} spellings[] = {
    {"inch", "in"},       {"inches", "in"},     {"millimetre", "mm"}, {"millimeter", "mm"},
    {"centimetre", "cm"}, {"centimeter", "cm"}, {"metre", "m"},       {"meter", "m"},
    {"foot", "ft"},       {"feet", "ft"},       {"lbf", "lb"},        {"lbs", "lb"},
    {"ins", "in"},        {"kgs", "kg"},        {"kips", "kip"},      {"pound", "lb"},
    {"newton", "N"},      {"kilonewton", "kN"}, {"kp", "kgf"},        {"kilogram", "kg"},
    {"sec", "s"},         {"second", "s"},      {"minute", "min"},    {"hour", "h"},
    {"day", "d"},         {"kt", "kn"},         {"knot", "kn"},       {"degree", "deg"},
    {"degF", "F"},        {"degC", "K"},
};

/* Units that a name can end with, longer endings first. */
static const struct {
    const char *ending, *unit;
} name_endings[] = {
    {"_lb_in_in", ""},
    {"_lb_in3", "lb/in3"},
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
    {"_in2", "in2"},
    {"_in", "in"},
    {"_mm", "mm"},
    {"_m", "m"},
    {"_N", "N"},
    {"_ms", "ms"},
    {"_s", "s"},
    {"_deg", "deg"},
    {"_psi", "psi"},
    {"_percent", "%"},
    {"_f", "F"},
};

#define ARRAY_COUNT(array) (sizeof(array) / sizeof((array)[0]))

/* ---- units: products of words ---- */

struct unit {
    int power[DIMENSION_COUNT];
    /* the fraction is exact for all units in `quantity_kinds` */
    long double numerator, denominator;
    int exponent10;
    bool is_kg; /* the unit is kg alone */
};

/* True if the text begins with M for mega, as "M" and "Mm" do. "MM" is a spelling of mm. */
static bool begins_with_mega(const char *text, size_t length)
{
    return length <= 2 && text[0] == 'M' && (length == 1 || text[1] != 'M');
}

static bool equals_ignoring_case(const char *text, size_t length, const char *known)
{
    return strlen(known) == length && strncasecmp(text, known, length) == 0 &&
           !begins_with_mega(text, length);
}

static const struct unit_symbol *find_unit_symbol(const char *text, size_t length)
{
    for (size_t i = 0; i < ARRAY_COUNT(unit_symbols); i++) {
        if (strlen(unit_symbols[i].text) == length &&
            memcmp(text, unit_symbols[i].text, length) == 0)
            return &unit_symbols[i];
    }
    size_t singular = length - (length > 2 && (text[length - 1] | 32) == 's');
    for (size_t i = 0; i < ARRAY_COUNT(spellings); i++) {
        if (equals_ignoring_case(text, length, spellings[i].spelling) ||
            equals_ignoring_case(text, singular, spellings[i].spelling))
            return find_unit_symbol(spellings[i].word, strlen(spellings[i].word));
    }
    for (size_t i = 0; i < ARRAY_COUNT(unit_symbols); i++) {
        if (unit_symbols[i].ignores_case &&
            equals_ignoring_case(text, length, unit_symbols[i].text))
            return &unit_symbols[i];
    }
    return NULL;
}

const char *quantity_unit_spelling(const char *text, size_t length)
{
    const struct unit_symbol *word = find_unit_symbol(text, length);
    return word ? word->text : "";
}

static const char *skip_blanks(const char *text)
{
    return text + strspn(text, " \t\r\n");
}

static void multiply_unit(struct unit *unit, const struct unit_symbol *word, int power)
{
    for (int i = 0; i < abs(power); i++) {
        unit->numerator *= (long double)(power > 0 ? word->numerator : word->denominator);
        unit->denominator *= (long double)(power > 0 ? word->denominator : word->numerator);
    }
    unit->exponent10 += power * word->exponent10;
    for (size_t b = 0; b < DIMENSION_COUNT; b++)
        unit->power[b] += power * word->power[b];
}

/* Reads a word and its power: "m2" or "m^2". Returns the text after it; NULL if it is invalid. */
static const char *read_power(const char *text, int sign, struct unit *unit)
{
    size_t length = 0;
    int power = 1;
    while (isalpha((unsigned char)text[length]))
        length++;
    const struct unit_symbol *word = length > 0 ? find_unit_symbol(text, length) : NULL;
    if (!word)
        return NULL;
    text += length;
    if (*text == '^' && (text[1] < '2' || text[1] > '4'))
        return NULL;
    text += *text == '^';
    if (*text >= '2' && *text <= '4')
        power = *text++ - '0';
    multiply_unit(unit, word, sign * power);
    return isalnum((unsigned char)*text) ? NULL : text;
}

/* Reads a whole unit. Returns false if the text is not a unit. An empty text gives a unit with all
 * powers 0. */
static bool read_unit(const char *text, struct unit *unit)
{
    *unit = (struct unit){.numerator = 1.0L, .denominator = 1.0L};
    text = skip_blanks(text);
    unit->is_kg = strncasecmp(text, "kg", 2) == 0 && *skip_blanks(text + 2) == '\0';
    if (*text == '1' && *skip_blanks(text + 1) == '/')
        text = skip_blanks(text + 1);
    while (text && *text && *text != '/') {
        text = read_power(text, 1, unit);
        text = text ? skip_blanks(text) : NULL;
    }
    if (text && *text == '/')
        text = read_power(skip_blanks(text + 1), -1, unit);
    return text && *skip_blanks(text) == '\0';
}

static bool has_same_dimension(const struct unit *a, const struct unit *b)
{
    return memcmp(a->power, b->power, sizeof a->power) == 0;
}

/* Replaces a plain kg by kgf if the wanted unit is a force. */
static void convert_kg_to_force(struct unit *unit, const struct unit *wanted)
{
    struct unit force;
    if (unit->is_kg && read_unit("kgf", &force) && has_same_dimension(wanted, &force))
        *unit = force;
}

/* ---- conversion: in long double, rounded once to a double ---- */

static long double power_of_ten(int power)
{
    long double value = 1.0L;
    for (int i = 0; i < power; i++)
        value *= 10.0L;
    return value;
}

static double convert_value(long double value, const struct unit *from, const struct unit *to)
{
    int ten = from->exponent10 - to->exponent10;
    return (double)(value * (from->numerator * to->denominator * power_of_ten(ten > 0 ? ten : 0)) /
                    (from->denominator * to->numerator * power_of_ten(ten < 0 ? -ten : 0)));
}

static bool is_same_unit(const struct unit *a, const struct unit *b)
{
    return a->numerator == b->numerator && a->denominator == b->denominator &&
           a->exponent10 == b->exponent10;
}

double quantity_convert(double value, const char *from, const char *to)
{
    struct unit a, b;
    if (strcmp(from, to) == 0)
        return value;
    if (!read_unit(from, &a) || !read_unit(to, &b))
        return (double)NAN;
    convert_kg_to_force(&a, &b);
    convert_kg_to_force(&b, &a);
    if (!has_same_dimension(&a, &b))
        return (double)NAN;
    return is_same_unit(&a, &b) ? value : convert_value((long double)value, &a, &b);
}

/* ---- error messages ---- */

/* Writes the advice "write ft, in, mm, cm or m after the number, or no unit for ft". */
static void write_advice(const char *unit, const char *bare, struct quantity_error *wrong)
{
    const struct quantity_kind *kind = quantity_kind_find(unit);
    char units[120];
    snprintf(units, sizeof units, "%s", kind ? kind->units : unit);
    char *last = strrchr(units, ',');
    if (!*unit)
        snprintf(wrong->advice, sizeof wrong->advice, "write the number without a unit");
    else if (last)
        snprintf(wrong->advice, sizeof wrong->advice, "write %.*s or%s after the number%s%s%s%s",
                 (int)(last - units), units, last + 1, *bare ? ", or no unit for " : "", bare,
                 kind->note ? "; " : "", kind->note ? kind->note : "");
    else
        snprintf(wrong->advice, sizeof wrong->advice, "write the number alone; it is in %s", bare);
}

static bool refuse_quantity(struct quantity_error *wrong, const char *what, const char *unit,
                            const char *bare)
{
    snprintf(wrong->what, sizeof wrong->what, "%s", what);
    write_advice(unit, bare, wrong);
    return false;
}

static bool refuse_no_number(const char *text, const char *unit, const char *bare,
                             struct quantity_error *wrong)
{
    refuse_quantity(wrong, *text ? "not a number" : "no number", unit, bare);
    snprintf(wrong->advice, sizeof wrong->advice,
             *unit ? "write digits such as 4, or 4 %s" : "write digits such as 4",
             *bare ? bare : unit);
    return false;
}

static bool refuse_other_dimension(const char *given_unit, const char *unit, const char *bare,
                                   struct quantity_error *wrong)
{
    const struct quantity_kind *is = quantity_kind_find(given_unit),
                               *wanted = quantity_kind_find(unit);
    char what[sizeof wrong->what];
    if (!*unit)
        snprintf(what, sizeof what, "unexpected unit");
    else if (!is || !wanted)
        snprintf(what, sizeof what, "not in %s", unit);
    else
        snprintf(what, sizeof what, "%s instead of %s", is->name, wanted->name);
    return refuse_quantity(wrong, what, unit, bare);
}

/* Refuses a comma before three digits, because it may separate thousands or decimals. */
static bool refuse_comma(const char *text, const char *comma, struct quantity_error *wrong)
{
    snprintf(wrong->what, sizeof wrong->what, "a comma in a number");
    if (strspn(comma + 1, "0123456789") == 3)
        snprintf(wrong->advice, sizeof wrong->advice,
                 "use a decimal point and no thousands separator");
    else
        snprintf(wrong->advice, sizeof wrong->advice, "write a point: %.*s.%s", (int)(comma - text),
                 text, comma + 1);
    return false;
}

/* ---- reading ---- */

static bool is_decimal_comma(const char *text)
{
    return *text == ',' && (isdigit((unsigned char)text[1]) || text[1] == '\0');
}

bool quantity_parse(const char *text, const char *unit, const char *bare, double *value,
                    struct quantity_error *wrong)
{
    struct unit from, to;
    const char *end, *start = skip_blanks(text);
    unit = unit ? unit : "";
    bare = bare ? bare : unit;
    *value = mr_decimal_parse(start, &end);
    const char *own = skip_blanks(end);
    if (is_decimal_comma(end))
        return refuse_comma(start, end, wrong);
    if (end == start || !isfinite(*value))
        return refuse_no_number(start, unit, bare, wrong);
    if (!*own && !*bare && *unit)
        return refuse_quantity(wrong, "a number without a unit", unit, bare);
    const char *given_unit = *own ? own : bare;
    /* An identical unit needs no conversion, so it may even be missing from the table. */
    if (strcmp(given_unit, unit) == 0)
        return true;
    if (!read_unit(given_unit, &from))
        return refuse_quantity(wrong, *unit ? "unknown unit" : "unexpected unit", unit, bare);
    if (!*unit || !read_unit(unit, &to))
        return refuse_other_dimension(given_unit, unit, bare, wrong);
    convert_kg_to_force(&from, &to);
    if (!has_same_dimension(&from, &to))
        return refuse_other_dimension(given_unit, unit, bare, wrong);
    if (!is_same_unit(&from, &to) && *value != 0.0)
        *value = convert_value(strtold(start, NULL), &from, &to);
    return isfinite(*value) || refuse_no_number(start, unit, bare, wrong);
}

enum mr_status quantity_read(const char *text, const char *name, const char *unit, const char *bare,
                             double *value, struct error *error)
{
    struct quantity_error wrong;
    if (quantity_parse(text, unit, bare, value, &wrong))
        return MR_OK;
    return error_set(error, MR_USAGE, "%s: '%s' for %s; %s", wrong.what, text, name, wrong.advice);
}

bool quantity_read_json(const json_t *json, const char *unit, double *value,
                        struct quantity_error *wrong)
{
    *value = json_number_value(json);
    if (json_is_number(json))
        return true;
    if (json_is_string(json) && unit && *unit)
        return quantity_parse(json_string_value(json), unit, "", value, wrong);
    refuse_quantity(wrong, "not a number", unit ? unit : "", unit ? unit : "");
    snprintf(wrong->advice, sizeof wrong->advice,
             unit && *unit ? "give a number in %s, or text with its unit, as in \"4 %s\""
                           : "give a number",
             unit, unit);
    return false;
}

/* ---- kinds ---- */

const struct quantity_kind *quantity_kind_get(size_t index)
{
    return index < ARRAY_COUNT(quantity_kinds) ? &quantity_kinds[index] : NULL;
}

const struct quantity_kind *quantity_kind_find(const char *text)
{
    struct unit unit, first;
    char name[40];
    if (!text || !*text || !read_unit(text, &unit))
        return NULL;
    for (size_t i = 0; i < ARRAY_COUNT(quantity_kinds); i++) {
        size_t length = strcspn(quantity_kinds[i].units, ",");
        /* Each name is copied once and never freed; the texts are a few letters long. */
        memcpy(name, quantity_kinds[i].units, length);
        name[length] = '\0';
        if (read_unit(name, &first) && has_same_dimension(&unit, &first))
            return &quantity_kinds[i];
    }
    return NULL;
}

void quantity_find_dimension(const char *text, int powers[3])
{
    struct unit unit;
    bool known = read_unit(text, &unit);
    powers[0] = known ? unit.power[DIMENSION_FORCE] : 0;
    powers[1] = known ? unit.power[DIMENSION_LENGTH] : 0;
    powers[2] = known ? unit.power[DIMENSION_TIME] : 0;
}

const char *quantity_unit_from_name(const char *name)
{
    for (size_t i = 0; i < ARRAY_COUNT(name_endings); i++) {
        size_t length = strlen(name), end = strlen(name_endings[i].ending);
        if (length > end && strcmp(name + length - end, name_endings[i].ending) == 0)
            return name_endings[i].unit;
    }
    return "";
}
