#include "docs/reference/reference.h"

#define OK    "ok"
#define LOOK  "look"
#define WRONG "wrong"

static void row(FILE *out, const char *section, const char *name, const char *should,
                const char *beyond, const char *none, const char *source, const char *advice)
{
    fprintf(out, "| %s | `%s` | %s | %s | %s | ", section, name, should, beyond, none);
    reference_cell(out, source);
    fputs(" | ", out);
    reference_cell(out, advice);
    fputs(" |\n", out);
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
        "*Outside* is the result for a value outside the limits, *None* the result for a missing "
        "value; `look` means that you decide whether the value is acceptable. `*` stands for the "
        "rest of a name.\n\n"
        "| Section | Line | Limits | Outside | None | Source | Remedy |\n"
        "|---|---|---|---|---|---|---|\n",
        out);
#define LIMIT(section, name, least, most, beyond, none, source, advice) \
    row(out, #section, name, #least " to " #most, beyond, none, source, advice);
#define WORD(section, name, words, beyond, none, source, advice) \
    row(out, #section, name, words, beyond, none, source, advice);
#define OF_BOARD(section, name, fact, beyond, none, source, advice) \
    row(out, #section, name, "`" #fact "` of the board", beyond, none, source, advice);
#include "host/board/bringup_limits.def"
    fputs("\n`cycles_predict` is the number of cycles that the predictor takes per block of a "
          "landing. `of_budget_predict` is `cycles_predict` divided by the budget (1.5 cycles "
          "per instruction, and 12.5 more per division or root). A value above 1 means that the "
          "chip is slower than `make budget` assumes. The emulated board counts instructions, so "
          "its value of 0.66 to 0.67 does not apply to hardware.\n",
          out);
}
