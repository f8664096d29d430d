#include "hil/debug/profile.h"

#include <stdlib.h>
#include <string.h>

#include "hil/board/board.h"

/* number of halfwords of flash and SRAM */
#define CODE_HALFWORD_COUNT ((HIL_FLASH_SIZE + HIL_SRAM_SIZE) / 2u)

/* Counts for the basic block that begins at a halfword of memory. */
struct profile_block {
    uint64_t run_count, instructions;
    uint16_t size, slow_instructions;
};

struct hil_profile {
    const struct hil_core *core;
    uint64_t rom_instruction_count;  /* number of instructions executed in the boot ROM */
    uint64_t slow_instruction_count; /* number of divisions and square roots */
    struct profile_block blocks[CODE_HALFWORD_COUNT];
};

bool hil_profile_is_slow_instruction(uint16_t a, uint16_t b)
{
    unsigned coprocessor = b >> 8 & 0xfu;
    bool divide = (a & 0xffb0u) == 0xee80u && !(b & 0x40u);
    bool root = (a & 0xffbfu) == 0xeeb1u && (b & 0xc0u) == 0xc0u;
    return (coprocessor == 10 || coprocessor == 11) && !(b & 0x10u) && (divide || root);
}

static uint16_t read_halfword(const uint8_t *p)
{
    return (uint16_t)(p[0] | p[1] << 8);
}

static uint16_t count_slow_instructions(const struct hil_core *core, uint32_t address,
                                        uint32_t size)
{
    const uint8_t *code = hil_memory_at(core, address, size, false);
    unsigned slow = 0;
    for (uint32_t i = 0; code && i + 4 <= size;) {
        bool wide = read_halfword(code + i) >= 0xe800u;
        slow += wide && hil_profile_is_slow_instruction(read_halfword(code + i),
                                                        read_halfword(code + i + 2));
        i += wide ? 4 : 2;
    }
    return (uint16_t)slow;
}

static uint32_t get_halfword_address(uint32_t halfword)
{
    return 2u * halfword < HIL_FLASH_SIZE ? HIL_FLASH_BASE + 2u * halfword
                                          : HIL_SRAM_BASE + 2u * halfword - HIL_FLASH_SIZE;
}

static void count_instructions(void *context, uint32_t address, uint32_t size,
                               uint32_t instructions)
{
    struct hil_profile *profile = context;
    uint32_t in_flash = address - HIL_FLASH_BASE, in_ram = address - HIL_SRAM_BASE;
    if (in_flash >= HIL_FLASH_SIZE && in_ram >= HIL_SRAM_SIZE) {
        profile->rom_instruction_count += instructions;
        return;
    }
    struct profile_block *block =
        &profile->blocks[(in_flash < HIL_FLASH_SIZE ? in_flash : HIL_FLASH_SIZE + in_ram) / 2u];
    if (block->size != size) {
        block->size = (uint16_t)size;
        block->slow_instructions = count_slow_instructions(profile->core, address, size);
    }
    block->run_count++;
    block->instructions += instructions;
    profile->slow_instruction_count += block->slow_instructions;
}

static const struct hil_profiler_calls profiler_calls = {.count_instructions = count_instructions};

void hil_profile_begin(struct hil_board *board)
{
    struct hil_profile *profile = hil_allocate(sizeof *profile);
    profile->core = &board->core;
    board->core.observers.profiler_context = profile;
    board->core.observers.profiler = &profiler_calls;
}

/* --- the report --- */

struct function_row {
    const struct mr_symbol *symbol; /* NULL: not inside a function */
    uint64_t instructions, entries;
};

static int compare_instructions(const void *a, const void *b)
{
    const struct function_row *x = a, *y = b;
    if (x->instructions != y->instructions)
        return x->instructions > y->instructions ? -1 : 1;
    return x->symbol && y->symbol ? strcmp(x->symbol->name, y->symbol->name)
                                  : !x->symbol - !y->symbol;
}

static double compute_percent(uint64_t part, uint64_t whole)
{
    return whole ? 100.0 * (double)part / (double)whole : 0.0;
}

/* Sums the blocks by function, one row each. Returns the number of rows. */
static size_t sum_by_function(const struct hil_profile *profile, const struct mr_symbols *symbols,
                              struct function_row *rows)
{
    size_t count = 0;
    for (uint32_t i = 0; i < CODE_HALFWORD_COUNT; i++) {
        const struct profile_block *block = &profile->blocks[i];
        if (!block->run_count)
            continue;
        const struct mr_symbol *symbol = mr_symbols_by_address(symbols, get_halfword_address(i));
        size_t k = 0;
        while (k < count && rows[k].symbol != symbol)
            k++;
        count += k == count;
        rows[k].symbol = symbol;
        rows[k].instructions += block->instructions;
        rows[k].entries += symbol && symbol->address == get_halfword_address(i) ? block->run_count
                                                                                : 0;
    }
    qsort(rows, count, sizeof *rows, compare_instructions);
    return count;
}

enum mr_status hil_profile_end(struct hil_board *board, const struct mr_symbols *symbols,
                               FILE *file)
{
    struct hil_profile *profile = board->core.observers.profiler_context;
    uint64_t total = profile->rom_instruction_count;
    struct function_row *rows = hil_allocate((symbols->entry_count + 1u) * sizeof *rows);
    size_t count = sum_by_function(profile, symbols, rows);
    for (size_t i = 0; i < count; i++)
        total += rows[i].instructions;
    fprintf(file,
            "matrig-board profile: %llu instructions in %.6f s of virtual time, asleep for %.2f %% "
            "of the cycles\n"
            "%15llu  %6.2f  floating point divide, root\n"
            "%15llu  %6.2f  in the boot ROM\n\n"
            "by function (entries: calls and branches to the first instruction)\n"
            "   instructions       %%       entries  function\n",
            (unsigned long long)total, (double)hil_board_now_ps(board) * 1e-12,
            compute_percent(hil_board_counters(board)->asleep_cycles, hil_now_cycle(&board->core)),
            (unsigned long long)profile->slow_instruction_count,
            compute_percent(profile->slow_instruction_count, total),
            (unsigned long long)profile->rom_instruction_count,
            compute_percent(profile->rom_instruction_count, total));
    for (size_t i = 0; i < count; i++)
        fprintf(file, "%15llu  %6.2f  %12llu  %s\n", (unsigned long long)rows[i].instructions,
                compute_percent(rows[i].instructions, total), (unsigned long long)rows[i].entries,
                rows[i].symbol ? rows[i].symbol->name : "(no function)");
    free(rows);
    free(profile);
    board->core.observers.profiler = NULL;
    return fflush(file) == 0 && !ferror(file) ? MR_OK : MR_IO;
}
