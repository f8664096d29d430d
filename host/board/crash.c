#include "host/board/crash.h"

#include <stdio.h>

#define ALL_WORDS ((1ull << MR_CRASH_ITEMS) - 1u)
#define FLASH     0x08000000u
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
    const struct mr_symbol *symbol = symbols && symbols->count
                                       ? mr_symbols_at(symbols, address & ~1u)
                                       : NULL;
    if (symbol)
        snprintf(out, size, "0x%08x (%s+0x%x)", (unsigned)address, symbol->name,
                 (unsigned)((address & ~1u) - symbol->address));
    else
        snprintf(out, size, "0x%08x", (unsigned)address);
}

void crash_headline(const struct crash_report *report, const struct mr_symbols *symbols, char *out,
                    size_t size)
{
    const uint32_t *word = report->word;
    char place[PLACE_MAX], running[64] = "";
    bool named = symbols && symbols->count;
    crash_place(word[MR_CRASH_PC], symbols, place, sizeof place);
    if (word[MR_CRASH_TASK])
        snprintf(running, sizeof running, ", in %s", mr_task_text(word[MR_CRASH_TASK]));
    snprintf(out, size, "the board restarted after a%s %s at %s%s, block %u%s",
             report->age ? "n earlier" : "", mr_crash_kind_text(word[MR_CRASH_KIND]), place,
             running, (unsigned)word[MR_CRASH_BLOCK],
             named ? "" : " (function unknown without --elf)");
}

void crash_answer(const struct crash_report *report, const struct mr_symbols *symbols,
                  struct answer *answer)
{
    const struct mr_symbol *at = symbols && symbols->count
                                   ? mr_symbols_at(symbols, report->word[MR_CRASH_PC] & ~1u)
                                   : NULL;
    char text[300], label[20];
    answer_open(answer, "crash", "");
    crash_headline(report, symbols, text, sizeof text);
    answer_sentence(answer, "text", "%s", text);
    answer_count(answer, "age", NULL, report->age);
    answer_words(answer, "kind", NULL, "%s", mr_crash_kind_text(report->word[MR_CRASH_KIND]));
    answer_words_or_none(answer, "function", NULL, at ? at->name : NULL, NULL);
    crash_place(report->word[MR_CRASH_LR], symbols, text, sizeof text);
    answer_words(answer, NULL, "called from", "%s", text);
    answer_words(answer, NULL, "image", "%08x", (unsigned)report->word[MR_CRASH_IMAGE]);
    answer_open(answer, "words", "registers");
    for (unsigned i = 0; i < MR_CRASH_STACK_FIRST; i++) {
        answer_count(answer, mr_crash_item_name(i), NULL, report->word[i]);
        if (i >= MR_CRASH_R0)
            answer_words(answer, NULL, mr_crash_item_name(i), "%08x", (unsigned)report->word[i]);
    }
    answer_close(answer);
    answer_list(answer, "stack", NULL);
    for (unsigned i = 0; i < MR_CRASH_STACK; i++)
        answer_count(answer, NULL, NULL, report->word[MR_CRASH_STACK_FIRST + i]);
    answer_close(answer);
    answer_open(answer, NULL, "stack from sp on");
    for (unsigned i = 0; i < MR_CRASH_STACK; i++) {
        uint32_t value = report->word[MR_CRASH_STACK_FIRST + i];
        crash_place(value, value >= FLASH && value < FLASH_END ? symbols : NULL, text, sizeof text);
        snprintf(label, sizeof label, "sp + %u", 4 * i);
        answer_words(answer, NULL, label, "%s", text);
    }
    answer_close(answer);
    answer_close(answer);
}
