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
        "What the bring-up image says ([how it is used](../howto/bring-up.md)), and what a board "
        "should say. The text is 8N1 at 115200 baud:\n\n"
        "```text\nbegin SECTION FORMAT\nNAME VALUE UNIT\n...\nend SECTION LINES CRC\n```\n\n"
        "VALUE is a number, `0x` and hexadecimal digits, a word, or `none`: it is not there or "
        "did not answer. LINES counts those between. CRC is the CRC-32 of all bytes from `begin` "
        "to the newline before `end`. Sections: `report` at power on and on the word `report`; "
        "`brown-out` on its own. The word `rom` starts the boot ROM.\n\n"
        "*Otherwise* says what a value beyond is, *none* the same of one that is not there or was "
        "not said. `*` stands for all names that begin so.\n\n"
        "| section | line | should be | otherwise | none | source | what to do |\n"
        "|---|---|---|---|---|---|---|\n",
        out);
#define LIMIT(section, name, least, most, beyond, none, source, advice) \
    row(out, #section, name, #least " to " #most, beyond, none, source, advice);
#define WORD(section, name, words, beyond, none, source, advice) \
    row(out, #section, name, words, beyond, none, source, advice);
#define OF_BOARD(section, name, fact, beyond, none, source, advice) \
    row(out, #section, name, "`" #fact "` of the board", beyond, none, source, advice);
#include "host/board/bringup_limits.def"
    fputs(
        "\n`cycles_predict` is what a block of a landing costs the predictor, by the core's cycle "
        "counter (DWT); `of_budget_predict` is that over what its budget assumes: 1.5 cycles an "
        "instruction, a division or root 12.5 more. Above 1 the chip is dearer than the budget "
        "(`make budget`) takes it for. On the emulated board the counter counts instructions, so "
        "it is 0.66 to 0.67 there and says nothing of silicon.\n",
        out);
}
