#include "host/base/quantity.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "host/base/quantity_units.h"

#define EXACT_TENS  22                 /* 10^22 is the largest power of ten that a double holds */
#define EXACT_WHOLE 9007199254740992.0 /* 2^53 */

/* ---- conversion: twice a double's digits, rounded once at the end ---- */

struct twofold {
    double high, low;
};

static struct twofold settle(double high, double low)
{
    double sum = high + low;
    return (struct twofold){sum, low - (sum - high)};
}

static struct twofold times(struct twofold a, double b)
{
    double product = a.high * b;
    return settle(product, fma(a.high, b, -product) + a.low * b);
}

static struct twofold over(struct twofold a, double b)
{
    double quotient = a.high / b;
    return settle(quotient, (fma(-quotient, b, a.high) + a.low) / b);
}

static double power_of_ten(int power)
{
    double value = 1.0;
    for (int i = 0; i < power; i++)
        value *= 10.0; /* exact up to EXACT_TENS */
    return value;
}

static struct twofold by_tens(struct twofold a, int ten)
{
    for (int left = abs(ten); left > 0; left -= EXACT_TENS) {
        double power = power_of_ten(left < EXACT_TENS ? left : EXACT_TENS);
        a = ten > 0 ? times(a, power) : over(a, power);
    }
    return a;
}

/* `whole` times 10^ten in `from`, in `to`. */
static double converted(double whole, int ten, const struct quantity_unit *from,
                        const struct quantity_unit *to)
{
    struct twofold value = {whole, 0.0};
    for (size_t i = 0; i < quantity_word_count; i++) {
        const struct quantity_word *word = &quantity_words[i];
        int power = from->power[i] - to->power[i];
        ten += power * word->ten;
        for (int k = 0; k < abs(power); k++) {
            value = times(value, power > 0 ? word->times : word->over);
            value = over(value, power > 0 ? word->over : word->times);
        }
    }
    return by_tens(value, ten).high;
}

/* The number between `text` and `end` as a whole number and a power of ten, when a double holds the
 * former; else as it is read. */
static double whole_of(const char *text, const char *end, double value, int *ten)
{
    double whole = 0.0;
    bool point = false;
    *ten = 0;
    for (; text < end && *text != 'e' && *text != 'E'; text++) {
        point |= *text == '.';
        if (!isdigit((unsigned char)*text))
            continue;
        whole = 10.0 * whole + (*text - '0');
        *ten -= point;
        if (whole > EXACT_WHOLE)
            break;
    }
    long power = text < end && whole <= EXACT_WHOLE ? strtol(text + 1, NULL, 10) : 0;
    if (whole > EXACT_WHOLE || labs(power) > 300) {
        *ten = 0;
        return value;
    }
    *ten += (int)power;
    return signbit(value) ? -whole : whole;
}

double quantity_convert(double value, const char *from, const char *to)
{
    struct quantity_unit a, b;
    if (strcmp(from, to) == 0)
        return value;
    if (!quantity_unit_parse(from, &a) || !quantity_unit_parse(to, &b))
        return (double)NAN;
    quantity_unit_weigh(&a, &b);
    quantity_unit_weigh(&b, &a);
    if (!quantity_unit_alike(&a, &b))
        return (double)NAN;
    return memcmp(&a, &b, sizeof a) == 0 ? value : converted(value, 0, &a, &b);
}

bool quantity_same_kind(const char *from, const char *to)
{
    return !isnan(quantity_convert(1.0, from, to));
}

/* ---- what is wrong ---- */

/* "write ft, in, mm, cm or m behind the number, or no unit for ft" */
static void advise(const char *unit, const char *bare, struct quantity_wrong *wrong)
{
    const struct quantity_kind *kind = quantity_kind_of(unit);
    char units[120];
    snprintf(units, sizeof units, "%s", kind ? kind->units : unit);
    char *last = strrchr(units, ',');
    if (!*unit)
        snprintf(wrong->advice, sizeof wrong->advice, "write digits alone");
    else if (last)
        snprintf(wrong->advice, sizeof wrong->advice, "write %.*s or%s behind the number%s%s%s%s",
                 (int)(last - units), units, last + 1, *bare ? ", or no unit for " : "", bare,
                 kind->note ? "; " : "", kind->note ? kind->note : "");
    else
        snprintf(wrong->advice, sizeof wrong->advice, "write digits alone, in %s", bare);
}

static bool is_wrong(struct quantity_wrong *wrong, const char *what, const char *unit,
                     const char *bare)
{
    snprintf(wrong->what, sizeof wrong->what, "%s", what);
    advise(unit, bare, wrong);
    return false;
}

static bool is_no_number(const char *text, const char *unit, const char *bare,
                         struct quantity_wrong *wrong)
{
    is_wrong(wrong, *text ? "not a number" : "no number", unit, bare);
    snprintf(wrong->advice, sizeof wrong->advice,
             *unit ? "write digits such as 4, or 4 %s" : "write digits such as 4",
             *bare ? bare : unit);
    return false;
}

static bool is_of_another_kind(const char *came, const char *unit, const char *bare,
                               struct quantity_wrong *wrong)
{
    const struct quantity_kind *is = quantity_kind_of(came), *wanted = quantity_kind_of(unit);
    char what[sizeof wrong->what];
    if (!*unit)
        snprintf(what, sizeof what, "a unit behind a plain number");
    else if (!is || !wanted)
        snprintf(what, sizeof what, "not in %s", unit);
    else
        snprintf(what, sizeof what, "%s instead of %s", is->name, wanted->name);
    return is_wrong(wrong, what, unit, bare);
}

/* Three digits behind it: thousands, or decimals. */
static bool is_with_comma(const char *text, const char *comma, struct quantity_wrong *wrong)
{
    snprintf(wrong->what, sizeof wrong->what, "a comma");
    if (strspn(comma + 1, "0123456789") == 3)
        snprintf(wrong->advice, sizeof wrong->advice,
                 "write a point before decimals, and nothing between thousands");
    else
        snprintf(wrong->advice, sizeof wrong->advice, "write a point: %.*s.%s", (int)(comma - text),
                 text, comma + 1);
    return false;
}

/* ---- reading ---- */

static bool is_comma(const char *text)
{
    return *text == ',' && (isdigit((unsigned char)text[1]) || text[1] == '\0');
}

bool quantity_parse(const char *text, const char *unit, const char *bare, double *value,
                    struct quantity_wrong *wrong)
{
    struct quantity_unit from, to;
    const char *end, *start = text + strspn(text, " \t\r\n");
    int ten;
    unit = unit ? unit : "";
    bare = bare ? bare : unit;
    *value = mr_decimal_read(start, &end);
    const char *own = end + strspn(end, " \t\r\n");
    if (is_comma(end))
        return is_with_comma(start, end, wrong);
    if (end == start || !isfinite(*value))
        return is_no_number(start, unit, bare, wrong);
    if (!*own && !*bare && *unit)
        return is_wrong(wrong, "a number without its unit", unit, bare);
    const char *came = *own ? own : bare;
    if (strcmp(came, unit) == 0) /* also a word that the table does not have */
        return true;
    if (!quantity_unit_parse(came, &from))
        return is_wrong(wrong, *unit ? "unknown unit" : "a unit behind a plain number", unit, bare);
    if (!*unit || !quantity_unit_parse(unit, &to))
        return is_of_another_kind(came, unit, bare, wrong);
    quantity_unit_weigh(&from, &to);
    if (!quantity_unit_alike(&from, &to))
        return is_of_another_kind(came, unit, bare, wrong);
    if (memcmp(&from, &to, sizeof from) == 0 || *value == 0.0)
        return true;
    double whole = whole_of(start, end, *value, &ten);
    *value = converted(whole, ten, &from, &to);
    return isfinite(*value) || is_no_number(start, unit, bare, wrong);
}

enum mr_status quantity_read(const char *text, const char *name, const char *unit, const char *bare,
                             double *value, struct error *error)
{
    struct quantity_wrong wrong;
    if (quantity_parse(text, unit, bare, value, &wrong))
        return MR_OK;
    return error_set(error, MR_USAGE, "%s: '%s' for %s; %s", wrong.what, text, name, wrong.advice);
}

bool quantity_json(const json_t *json, const char *unit, double *value,
                   struct quantity_wrong *wrong)
{
    *value = json_number_value(json);
    if (json_is_number(json))
        return true;
    if (json_is_string(json) && unit && *unit)
        return quantity_parse(json_string_value(json), unit, "", value, wrong);
    is_wrong(wrong, "not a number", unit ? unit : "", unit ? unit : "");
    snprintf(wrong->advice, sizeof wrong->advice,
             unit && *unit ? "give a number in %s, or text with its unit, as in \"4 %s\""
                           : "give a number",
             unit, unit);
    return false;
}
