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
    }
    fprintf(out, " | %s |\n", kind->si_unit);
}

void reference_units(FILE *out)
{
    const struct quantity_kind *kind;
    reference_head(out, "Units", "the tables of units in `host/base/quantity.c`");
    fputs(
        "A number in an option, in typed input or in a table of readings may have a unit, with or "
        "without a blank: `15mm`, `15 mm`. In JSON, write both in quotes: `\"15 mm\"`. A "
        "number without a unit is in the unit that the help of the option, the name of the key or "
        "the column head states.\n\n"
        "- A unit of the wrong kind is an error: `3 lb` is not a length.\n"
        "- Units combine: `kip/in`, `kN/mm`, `lb s/in`. A power is written as a digit: `mm2`, "
        "`m/s2`.\n"
        "- Conversions use the exact definitions: `ft` 0.3048 m, `g` 9.80665 m/s2, `kn` 1852 m/h, "
        "`kip` 1000 lb, `slug` 1 lb s2/ft. `lb` is a force, 4.4482216152605 N. Where a force is "
        "expected, `kg` is the weight of that mass (`kgf`).\n"
        "- `ft`, `in`, `mm`, `cm`, `m`, `lb`, `N`, `kN`, `kgf` and `kg` may be in capitals, but a "
        "lone `M` is an error (it could mean mega). Other units are case-sensitive: `g` is an "
        "acceleration, `kn` "
        "a knot.\n"
        "- Units may be spelled out: inches, feet, metres, pounds, newtons, seconds, degrees.\n"
        "- The decimal separator is a point. A comma is an error.\n"
        "\n"
        "| Kind | Units | SI |\n|---|---|---|\n",
        out);
    for (size_t i = 0; (kind = quantity_kind_get(i)); i++)
        write_kind(out, kind);
    fputs("\nmatrig prints ft, in, lb and s; with `--si`, it prints m, mm, N and s.\n", out);
}
