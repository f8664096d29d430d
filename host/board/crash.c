#include "host/board/crash.h"

#include <string.h>

#define ALL_WORDS ((1ull << MR_CRASH_ITEMS) - 1u)
#define FLASH 0x08000000u
#define FLASH_END 0x08100000u
#define PLACE_MAX 120

bool crash_take(struct crash_report *report, const struct mr_crash *message)
{
    if (message->item >= MR_CRASH_ITEMS || message->items != MR_CRASH_ITEMS)
        return false;
    if (message->item == 0 || message->age != report->age) /* told anew */
        *report = (struct crash_report){.age = message->age};
    bool whole = report->present == ALL_WORDS;
    report->word[message->item] = message->value;
    report->present |= 1ull << message->item;
    return !whole && report->present == ALL_WORDS;
}

void crash_place(uint32_t address, const struct mr_symbols *symbols, char *out, size_t size)
{
    const struct mr_symbol *symbol = symbols && symbols->count ? mr_symbols_at(symbols, address & ~1u) : NULL;
    if (symbol)
        snprintf(out, size, "0x%08x (%s+0x%x)", (unsigned)address, symbol->name, (unsigned)((address & ~1u) - symbol->address));
    else
        snprintf(out, size, "0x%08x", (unsigned)address);
}

void crash_headline(const struct crash_report *report, const struct mr_symbols *symbols, char *out, size_t size)
{
    const uint32_t *word = report->word;
    char place[PLACE_MAX], running[64] = "";
    bool named = symbols && symbols->count;
    crash_place(word[MR_CRASH_PC], symbols, place, sizeof place);
    if (word[MR_CRASH_TASK])
        snprintf(running, sizeof running, ", in %s", mr_task_text(word[MR_CRASH_TASK]));
    snprintf(out, size, "the board restarted after a%s %s at %s%s, block %u%s", report->age ? "n earlier" : "",
             mr_crash_kind_text(word[MR_CRASH_KIND]), place, running, (unsigned)word[MR_CRASH_BLOCK],
             named ? "" : " (function unknown without --elf)");
}

void crash_print(const struct crash_report *report, const struct mr_symbols *symbols, FILE *out)
{
    char text[300];
    crash_headline(report, symbols, text, sizeof text);
    fprintf(out, "%s\n", text);
    crash_place(report->word[MR_CRASH_LR], symbols, text, sizeof text);
    fprintf(out, "  called from    %s\n  image          %08x\n", text, (unsigned)report->word[MR_CRASH_IMAGE]);
    for (unsigned i = MR_CRASH_R0; i < MR_CRASH_STACK_FIRST; i++)
        fprintf(out, "%s%-5s %08x%s", (i - MR_CRASH_R0) % 4 == 0 ? "  " : "   ", mr_crash_item_name(i),
                (unsigned)report->word[i], (i - MR_CRASH_R0) % 4 == 3 ? "\n" : "");
    fprintf(out, "\n  stack from sp on\n");
    for (unsigned i = 0; i < MR_CRASH_STACK; i++) {
        uint32_t value = report->word[MR_CRASH_STACK_FIRST + i];
        crash_place(value, value >= FLASH && value < FLASH_END ? symbols : NULL, text, sizeof text);
        fprintf(out, "    %s\n", text);
    }
}

json_t *crash_json(const struct crash_report *report, const struct mr_symbols *symbols)
{
    char text[300];
    json_t *words = json_object(), *stack = json_array();
    crash_headline(report, symbols, text, sizeof text);
    for (unsigned i = 0; i < MR_CRASH_STACK_FIRST; i++)
        json_object_set_new(words, mr_crash_item_name(i), json_integer(report->word[i]));
    for (unsigned i = 0; i < MR_CRASH_STACK; i++)
        json_array_append_new(stack, json_integer(report->word[MR_CRASH_STACK_FIRST + i]));
    const struct mr_symbol *at =
        symbols && symbols->count ? mr_symbols_at(symbols, report->word[MR_CRASH_PC] & ~1u) : NULL;
    return json_pack("{sssisssososs?}", "text", text, "age", report->age, "kind",
                     mr_crash_kind_text(report->word[MR_CRASH_KIND]), "words", words, "stack", stack, "function",
                     at ? at->name : NULL);
}
