#include <stdbool.h>
#include <string.h>

#include "docs/reference/reference.h"

#define OK      "ok"
#define SUSPECT "look"
#define WRONG   "wrong"

static const char *section_title(const char *section)
{
    return strcmp(section, "SECTION_ANY") == 0    ? "both sections"
         : strcmp(section, "SECTION_REPORT") == 0 ? "report"
                                                  : "brown-out";
}

/* What happens outside the limits and when the value is missing: wrong unless stated. */
static void row(FILE *out, const char *section, const char *name, const char *limits,
                const char *beyond, const char *none, const char *advice)
{
    static const char *last_section = "";
    if (strcmp(section, last_section) != 0)
        fprintf(out, "| **%s** | | | |\n", section_title(section));
    last_section = section;
    fprintf(out, "| `%s` | %s | ", name, limits);
    if (strcmp(beyond, WRONG) != 0 || strcmp(none, WRONG) != 0)
        fputs(beyond, out);
    if (strcmp(beyond, none) != 0)
        fprintf(out, ", %s", none);
    fputs(" | ", out);
    reference_cell(out, advice);
    fputs(" |\n", out);
}

/* "5" instead of "5 to 5" */
static void limit_row(FILE *out, const char *section, const char *name, const char *least,
                      const char *most, const char *beyond, const char *none, const char *advice)
{
    char limits[60];
    bool is_value = strcmp(least, most) == 0;
    snprintf(limits, sizeof limits, "%s%s%s", least, is_value ? "" : " to ", is_value ? "" : most);
    row(out, section, name, limits, beyond, none, advice);
}

void reference_bringup(FILE *out)
{
    reference_head(out, "Bring-up", "`host/board/bringup_limits.def`");
    fputs(
        "This page lists the output of the bring-up image ([how to use it](../howto/bring-up.md)) "
        "and the limits that `matrig board bringup` applies. The serial line is 8N1 at 115200 "
        "baud:\n\n"
        "```text\nbegin SECTION FORMAT\nNAME VALUE UNIT\n...\nend SECTION LINES CRC\n```\n\n"
        "VALUE is a decimal number, a hexadecimal number (`0x...`), a word, or `none` (absent or "
        "no answer). "
        "LINES counts the lines between `begin` and `end`. CRC is the CRC-32 of all bytes from "
        "`begin` to the newline before `end`. The image sends the section `report` at power on "
        "and when it receives the word `report`. It sends the section `brown-out` when it "
        "receives `brown-out`. The word `rom` starts the boot ROM.\n\n"
        "A value that is missing or outside its limits gives the result `wrong`, unless the column "
        "*Result* states another. Of two results there, the second is for a missing value. After "
        "`look`, you decide. `*` stands for the rest of a name. Limits are in the unit of the "
        "line.\n\n"
        "| Line | Limits | Result | Remedy |\n|---|---|---|---|\n",
        out);
#define LIMIT(section, name, least, most, beyond, none, source, advice) \
    limit_row(out, #section, name, #least, #most, beyond, none, advice);
#define ALLOWED_WORDS(section, name, words, beyond, none, source, advice) \
    row(out, #section, name, words, beyond, none, advice);
#define BOARD_FACT(section, name, fact, beyond, none, source, advice) \
    row(out, #section, name, "`" #fact "` of the board", beyond, none, advice);
#include "host/board/bringup_limits.def"
    fputs("\n`cycles_predict` is the number of cycles that the predictor takes per block of a "
          "landing. `of_budget_predict` is `cycles_predict` divided by the budget (1.5 cycles "
          "per instruction, and 12.5 more per division or root). A value above 1 means that the "
          "chip is slower than `make budget` assumes.\n",
          out);
}
