#include <math.h>
#include <string.h>

#include "docs/reference/reference.h"
#include "host/base/quantity.h"

static void write_kind(FILE *out, const struct quantity_kind *kind)
{
    char units[200], *rest = units, *unit;
    snprintf(units, sizeof units, "%s", kind->units);
    fprintf(out, "| %s | ", kind->name + (kind->name[1] == 'n' ? 3 : 2));
    while ((unit = strsep(&rest, ","))) {
        unit += strspn(unit, " ");
        fprintf(out, "%s`%s`", unit == units ? "" : ", ", unit);
        if (strcmp(unit, kind->si) != 0)
            fprintf(out, " = %.15g", quantity_convert(1.0, unit, kind->si));
    }
    fprintf(out, " | %s |\n", kind->si);
}

void reference_units(FILE *out)
{
    const struct quantity_kind *kind;
    reference_head(out, "Units", "the tables of units in `host/base/quantity.c`");
    fputs(
        "A number may have its unit behind it, with a blank or without: `15mm`, `15 mm`. This "
        "holds for options, what is typed, tables of readings; in a "
        "JSON file such a number is text: `\"15 mm\"`. A number without a unit "
        "is in the unit that the help of the option, the name of the key or the head of the column "
        "says.\n\n"
        "- Any unit of the right kind is read. A unit of another kind is an error, never a guess: "
        "`3 lb` is no length.\n"
        "- Units can be made of the words below: `kip/in`, `kN/mm`, `lb s/in`. A power is a digit: "
        "`mm2`, `m/s2`.\n"
        "- `lb` is a force, 4.4482216152605 N. Where a force is wanted, `kg` is the weight of that "
        "mass: times 9.80665 m/s2.\n"
        "- `ft`, `in`, `mm`, `cm`, `m`, `lb`, `N`, `kN`, `kgf` and `kg` may be in capitals, but "
        "for "
        "`M`, which is mega. The others are as they stand: `g` is an acceleration, `kn` a knot.\n"
        "- Words may be spelled out: inches, feet, metres, pounds, newtons, seconds, degrees.\n"
        "- Decimals have a point. A comma is an error, but for a caliper that types one in `matrig "
        "survey`.\n"
        "- A conversion is exact to 0.502 units in the last place of a double. In its own unit a "
        "number is what its digits say.\n\n"
        "Each unit with its size in the SI unit of the last column:\n\n"
        "| kind | units | SI |\n|---|---|---|\n",
        out);
    for (size_t i = 0; (kind = quantity_kind_at(i)); i++)
        write_kind(out, kind);
    fputs("\nWhat matrig shows is in ft, in, lb and s; with `--si` in m, mm, N and s.\n", out);
}
