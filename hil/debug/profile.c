#include "hil/debug/profile.h"

#include <stdlib.h>
#include <string.h>

#include "hil/board/board.h"
#include "hil/board/parts.h"
#include "hil/core/cpu.h"

#define HASH_BITS  15u
#define BLOCKS_MAX (1u << (HASH_BITS - 1))

struct block {
    uint32_t address, size; /* size 0: what found no room */
    uint32_t instructions, slow;
    uint64_t runs;
};

struct hil_profile {
    const struct hil_core *core;
    struct block block[BLOCKS_MAX]; /* 0: all that found no room */
    uint32_t blocks;
    uint16_t hash[1u << HASH_BITS]; /* numbers; 0: free */
    uint64_t part;                  /* instructions of blocks that a debugger jumped out of */
};

bool hil_profile_is_slow(uint16_t a, uint16_t b)
{
    unsigned coprocessor = b >> 8 & 0xfu;
    bool divide = (a & 0xffb0u) == 0xee80u && !(b & 0x40u);
    bool root = (a & 0xffbfu) == 0xeeb1u && (b & 0xc0u) == 0xc0u;
    return (coprocessor == 10 || coprocessor == 11) && !(b & 0x10u) && (divide || root);
}

static uint16_t halfword(const uint8_t *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

static struct block look_at(const struct hil_core *core, uint32_t address, uint32_t size)
{
    struct block block = {.address = address, .size = size};
    const uint8_t *code = hil_memory_at(core, address, size, false);
    for (uint32_t i = 0; code && i + 2 <= size; block.instructions++) {
        uint16_t first = halfword(code + i);
        bool wide = first >= 0xe800u;
        uint16_t second = wide && i + 4 <= size ? halfword(code + i + 2) : 0;
        block.slow += wide && hil_profile_is_slow(first, second);
        i += wide ? 4 : 2;
    }
    if (!block.instructions)
        block.instructions = 1; /* counted as the core counts it */
    return block;
}

static uint32_t number_of(void *who, uint32_t address, uint32_t size)
{
    struct hil_profile *profile = who;
    uint32_t slot = ((address >> 1) * 0x9e3779b1u ^ size * 0x85ebca6bu) >> (32u - HASH_BITS);
    for (; profile->hash[slot]; slot = (slot + 1u) & ((1u << HASH_BITS) - 1u)) {
        const struct block *block = &profile->block[profile->hash[slot]];
        if (block->address == address && block->size == size)
            return profile->hash[slot];
    }
    if (profile->blocks == BLOCKS_MAX)
        return 0;
    uint32_t number = profile->blocks++;
    profile->block[number] = look_at(profile->core, address, size);
    profile->hash[slot] = (uint16_t)number;
    return number;
}

static void count(void *who, uint32_t number, uint32_t instructions)
{
    struct hil_profile *profile = who;
    if (number && instructions == (profile->block[number].instructions & 0xffu))
        profile->block[number].runs++;
    else
        profile->part += instructions;
}

static const struct hil_profiler_calls calls = {.block = number_of, .count = count, .end = free};

static struct hil_profile *profile_of(const struct hil_board *board)
{
    return board->core.onlookers.profiler_who;
}

void hil_profile_begin(struct hil_board *board)
{
    struct hil_profile *profile = calloc(1, sizeof *profile);
    if (!profile)
        abort();
    profile->core = &board->core;
    profile->blocks = 1;
    board->core.onlookers.profiler_who = profile;
    board->core.onlookers.profiler = &calls;
    hil_cpu_forget_code(&board->core); /* blocks have no numbers yet */
}

void hil_profile_end(struct hil_board *board)
{
    free(profile_of(board));
    board->core.onlookers.profiler = NULL;
    board->core.onlookers.profiler_who = NULL;
}

/* --- the report --- */

struct row {
    const struct mr_symbol *symbol; /* NULL: outside of any function */
    uint64_t instructions, entries;
};

static int by_instructions(const void *a, const void *b)
{
    const struct row *x = a, *y = b;
    if (x->instructions != y->instructions)
        return x->instructions > y->instructions ? -1 : 1;
    return x->symbol && y->symbol ? strcmp(x->symbol->name, y->symbol->name)
                                  : !x->symbol - !y->symbol;
}

static double percent(uint64_t part, uint64_t whole)
{
    return whole ? 100.0 * (double)part / (double)whole : 0.0;
}

/* Blocks sorted into functions. */
static struct row *collect(const struct hil_profile *profile, const struct mr_symbols *symbols,
                           size_t *count)
{
    struct row *rows = calloc(profile->blocks, sizeof *rows);
    if (!rows)
        abort();
    *count = 0;
    for (uint32_t i = 1; i < profile->blocks; i++) {
        const struct block *block = &profile->block[i];
        const struct mr_symbol *symbol = mr_symbols_at(symbols, block->address);
        size_t k = 0;
        if (!block->runs)
            continue;
        while (k < *count && rows[k].symbol != symbol)
            k++;
        *count += k == *count;
        rows[k].symbol = symbol;
        rows[k].instructions += block->runs * block->instructions;
        rows[k].entries += symbol && symbol->address == block->address ? block->runs : 0;
    }
    qsort(rows, *count, sizeof *rows, by_instructions);
    return rows;
}

enum mr_status hil_profile_print(const struct hil_board *board, const struct mr_symbols *symbols,
                                 FILE *file)
{
    const struct hil_profile *profile = profile_of(board);
    uint64_t total = profile->part, slow = 0;
    size_t count;
    for (uint32_t i = 1; i < profile->blocks; i++) {
        total += profile->block[i].runs * profile->block[i].instructions;
        slow += profile->block[i].runs * profile->block[i].slow;
    }
    fprintf(file,
            "matrig-board profile: %llu instructions in %.6f s of virtual time, asleep %.2f %% of "
            "its cycles\n"
            "%15llu  %6.2f  floating point divide, root\n"
            "%15llu  %6.2f  in blocks that were not run whole\n\n"
            "by function (entries: calls, and returns to its first instruction)\n"
            "   instructions       %%       entries  function\n",
            (unsigned long long)total, (double)hil_board_now_ps(board) * 1e-12,
            percent(hil_board_counters(board)->asleep_cycles, hil_board_now_cycles(board)),
            (unsigned long long)slow, percent(slow, total), (unsigned long long)profile->part,
            percent(profile->part, total));
    struct row *rows = collect(profile, symbols, &count);
    for (size_t i = 0; i < count; i++)
        fprintf(file, "%15llu  %6.2f  %12llu  %s\n", (unsigned long long)rows[i].instructions,
                percent(rows[i].instructions, total), (unsigned long long)rows[i].entries,
                rows[i].symbol ? rows[i].symbol->name : "(no function)");
    free(rows);
    return fflush(file) == 0 && !ferror(file) ? MR_OK : MR_IO;
}
