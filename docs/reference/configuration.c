#include "docs/reference/reference.h"

static void write_limits(FILE *out, double least, double most)
{
    fprintf(out, "%.10g to %.10g", least, most);
}

static void write_row(FILE *out, const char *field, const char *type, const char *unit,
                      const char *text)
{
    fprintf(out, "| `%s` | %s%s", field, type, unit[0] ? ", " : "");
    reference_cell(out, unit);
    fputs(" | ", out);
    reference_cell(out, text);
    fputs(" | ", out);
}

void reference_configuration(FILE *out)
{
    reference_head(out, "Configuration", "`common/config.def`");
    fputs("`matrig board config get` prints the configuration as text, one field per line: "
          "`site.mats = 420`. Members of a group are numbered from 1: "
          "`gate[3].station_ft = 12.5`. `channel[1]` to `[8]` are the transducers, `[9]` to `[22]` "
          "the gages, `[23]` the staircase, `[24]` the reference. `#` begins a comment. `matrig "
          "board config check FILE` reports wrong lines and shows their correct form.\n",
          out);
#define GROUP(name, count)                      \
    fputs("\n## " #name "\n\n", out);           \
    if ((count) > 1)                            \
        fprintf(out, "%d members.\n\n", count); \
    fputs("| Field | Type, unit | Meaning | Limits |\n|---|---|---|---|\n", out);
#define INTEGER(group, type, field, least, most, unit, text) \
    write_row(out, #field, #type, unit, text);               \
    write_limits(out, least, most);                          \
    fputs(" |\n", out);
#define REAL(group, field, least, most, unit, text) \
    write_row(out, #field, "number", unit, text);   \
    write_limits(out, least, most);                 \
    fputs(" |\n", out);
#define OPTIONAL(group, field, least, most, unit, text)      \
    write_row(out, #field, "number or missing", unit, text); \
    write_limits(out, least, most);                          \
    fputs(" |\n", out);
#define REALS(group, field, count, least, most, unit, text) \
    write_row(out, #field, #count " numbers", unit, text);  \
    write_limits(out, least, most);                         \
    fputs(" |\n", out);
#define TEXT(group, field, size, text)        \
    write_row(out, #field, "text", "", text); \
    fprintf(out, "%d bytes |\n", size);
#define END_GROUP(name)
#include "common/config.def"
#undef GROUP
#undef INTEGER
#undef REAL
#undef OPTIONAL
#undef REALS
#undef TEXT
#undef END_GROUP
}
