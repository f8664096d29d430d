#include "hil/debug/hang.h"

#include <stdio.h>

#include "hil/core/bootrom.h"
#include "hil/core/cpu_registers.h"

void hil_hang_start(struct hil_hang *hang, double limit_s)
{
    *hang = (struct hil_hang){.limit_ps = (uint64_t)(limit_s * (double)HIL_SECOND_PS)};
}

static void note_place(struct hil_hang *hang, const struct mr_symbols *symbols, uint32_t pc)
{
    const struct mr_symbol *symbol = mr_symbols_at(symbols, pc);
    uint32_t address = symbol ? symbol->address : pc;
    unsigned i = 0;
    while (i < hang->places && hang->place[i].address != address)
        i++;
    if (i == HIL_HANG_PLACES)
        return; /* so many functions in turn: the first are as good as any */
    if (i == hang->places)
        hang->places++;
    hang->place[i].address = address;
    hang->place[i].pc = pc;
    hang->place[i].seen++;
}

static void tell(const struct hil_hang *hang, const struct hil_board *board,
                 const struct mr_symbols *symbols, uint64_t since_ps, char *text, size_t size)
{
    unsigned most = 0;
    for (unsigned i = 1; i < hang->places; i++) {
        if (hang->place[i].seen > hang->place[most].seen)
            most = i;
    }
    uint32_t pc = hang->place[most].pc;
    const struct mr_symbol *symbol = mr_symbols_at(symbols, pc);
    bool masked = (hil_board_register(board, HIL_PRIMASK) & 1u) != 0;
    unsigned exception = hil_board_register(board, 16) & 0x1ffu;
    char where[48] = "";
    if (exception)
        snprintf(where, sizeof where, " of exception %u", exception);
    snprintf(text, size,
             "the firmware hangs: since %.3f s it runs without sleeping%s, at PC 0x%08x in %s%s%s; "
             "look with --gdb, "
             "or allow more with --hang S",
             (double)since_ps * 1e-12, hang->progress_ps > since_ps ? " (interrupts go on)" : "",
             (unsigned)pc, symbol ? symbol->name : "no known function", where,
             masked ? ", interrupts masked" : "");
}

bool hil_hang_look(struct hil_hang *hang, const struct hil_board *board,
                   const struct mr_symbols *symbols, char *text, size_t size)
{
    const struct hil_counters *c = hil_board_counters(board);
    uint64_t now_ps = hil_board_now_ps(board);
    uint64_t spoken = c->can_frames_out + c->serial_bytes_out;
    if (!hang->limit_ps)
        return false;
    bool slept = c->asleep_cycles != hang->asleep_cycles;
    /* The boot ROM waits for its first byte by polling the pin: that is no hang, and what it starts
     * begins anew. */
    bool in_rom = hil_board_register(board, 15) - HIL_ROM_BASE < HIL_ROM_SIZE;
    if (c->resets != hang->resets || in_rom) {
        hang->sleeps = false;
        hang->slept_ps = hang->progress_ps = now_ps;
    }
    if (slept && !in_rom) {
        hang->sleeps = true;
        hang->slept_ps = now_ps;
        hang->places = 0;
    }
    if (slept || c->exceptions != hang->exceptions || spoken != hang->spoken)
        hang->progress_ps = now_ps;
    hang->asleep_cycles = c->asleep_cycles;
    hang->exceptions = c->exceptions;
    hang->spoken = spoken;
    hang->resets = c->resets;
    if (slept)
        return false;
    if (!hang->places)
        for (unsigned i = 0; i < HIL_HANG_PLACES; i++)
            hang->place[i].seen = 0;
    note_place(hang, symbols, hil_board_register(board, 15) & ~1u);
    uint64_t since_ps = hang->sleeps ? hang->slept_ps : hang->progress_ps;
    if (now_ps - since_ps < hang->limit_ps)
        return false;
    tell(hang, board, symbols, since_ps, text, size);
    return true;
}
