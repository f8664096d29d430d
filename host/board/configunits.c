#include "host/board/configunits.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/decimal.h"
#include "common/wire.h"

#define VALUE_MAX 100u
#define BLANKS    " \t\r"

/* "in or lb per h", "in/s or lb/s", "in or lb per code": a code is not converted. */
void configunits_own(const char *unit, enum configunits_of of, char out[40])
{
    const char * or = strstr(unit, " or "), *per = strstr(unit, " per ");
    int first = or ? (int)(or -unit) : 0, second = per ? (int)(per - or) - 4 : 39;
    const char *rate = per && strcmp(per, " per code") != 0 ? "/" : "";
    if (! or)
        snprintf(out, 40, "%s", unit);
    else
        snprintf(out, 40, "%.*s%s%s", of == CONFIGUNITS_FORCE ? second : first,
                 of == CONFIGUNITS_FORCE ? or +4 : unit, rate, *rate ? per + 5 : "");
}

/* Where the unit behind the number ends; `end` itself: it has none. */
static const char *unit_end(const char *end, bool list)
{
    const char *unit = end + strspn(end, BLANKS);
    if (*unit == '\0' || *unit == '#' || (list && unit > end && strncmp(unit, "missing", 7) == 0))
        return end;
    if (list && unit > end && !isalpha((unsigned char)*unit))
        return end; /* the next value */
    return unit + (list ? strcspn(unit, BLANKS "#") : strcspn(unit, "#"));
}

static bool fail(const char *what, const char *advice, struct quantity_wrong *wrong)
{
    snprintf(wrong->what, sizeof wrong->what, "%s", what);
    snprintf(wrong->advice, sizeof wrong->advice, "%s", advice);
    return false;
}

/* A field of a channel takes either. */
static bool read_with_unit(const char *text, const char *unit, double *value,
                           enum configunits_of *of, struct quantity_wrong *wrong)
{
    char own[40];
    *of = CONFIGUNITS_ANY;
    if (!strstr(unit, " or "))
        return quantity_parse(text, quantity_kind_of(unit) ? unit : "", NULL, value, wrong);
    for (*of = CONFIGUNITS_LENGTH; *of <= CONFIGUNITS_FORCE; ++*of) {
        configunits_own(unit, *of, own);
        if (quantity_parse(text, own, NULL, value, wrong))
            return true;
    }
    configunits_own(unit, CONFIGUNITS_LENGTH, own);
    return quantity_parse(text, own, NULL, value, wrong);
}

bool configunits_read(const char **p, const char *unit, bool list, float *value,
                      enum configunits_of *of, struct quantity_wrong *wrong)
{
    const char *end;
    char text[VALUE_MAX];
    double converted;
    *of = CONFIGUNITS_NONE;
    *p += strspn(*p, BLANKS);
    if (strncmp(*p, "missing", 7) == 0 && (!(*p)[7] || strchr(BLANKS "#", (*p)[7]))) {
        *value = MR_NAN;
        *p += 7;
        return true;
    }
    (void)mr_decimal_read(*p, &end);
    if (end == *p)
        return fail("", "", wrong);
    const char *behind = unit_end(end, list);
    size_t length = (size_t)(behind - *p);
    if (length >= sizeof text)
        return fail("", "", wrong);
    *value = strtof(*p, NULL);
    memcpy(text, *p, length);
    text[length] = '\0';
    *p = behind;
    if (behind == end)
        return true;
    if (!read_with_unit(text, unit, &converted, of, wrong))
        return false;
    *value = (float)converted;
    return true;
}
