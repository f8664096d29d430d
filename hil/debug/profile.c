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
    uint32_t instructions;
    uint16_t kinds[HIL_KINDS];
};

struct hil_profile {
    const struct hil_core *core;
    struct block block[BLOCKS_MAX]; /* 0: all that found no room */
    uint32_t blocks;
    uint16_t hash[1u << HASH_BITS]; /* numbers; 0: free */
    uint64_t *runs[HIL_EXCEPTIONS]; /* of each block, by exception; NULL: never entered */
    uint64_t part[HIL_EXCEPTIONS];  /* instructions of blocks that a debugger jumped out of */
    unsigned exception;
};

static const char *const kind_names[HIL_KINDS] = {"integer arithmetic and moves",
                                                  "multiply",
                                                  "divide",
                                                  "load",
                                                  "store",
                                                  "branch, call",
                                                  "floating point",
                                                  "floating point divide, root",
                                                  "floating point load",
                                                  "floating point store",
                                                  "system"};

const char *hil_profile_kind_name(enum hil_kind kind)
{
    return kind_names[kind];
}

static enum hil_kind kind16(uint16_t op)
{
    if (op < 0x4400u)
        return (op & 0xffc0u) == 0x4340u ? HIL_KIND_MULTIPLY : HIL_KIND_ALU; /* MULS */
    if (op < 0x4700u)
        /* MOV, ADD to PC */
        return (op & 0xff87u) == 0x4687u || (op & 0xff87u) == 0x4487u ? HIL_KIND_BRANCH
                                                                      : HIL_KIND_ALU;
    if (op < 0x4800u)
        return HIL_KIND_BRANCH; /* BX, BLX */
    if (op < 0x5000u)
        return HIL_KIND_LOAD;
    if (op < 0x6000u)
        return (op >> 9 & 7u) < 3 ? HIL_KIND_STORE : HIL_KIND_LOAD;
    if (op < 0xa000u)
        return (op & 0x0800u) ? HIL_KIND_LOAD : HIL_KIND_STORE;
    if (op < 0xb000u)
        return HIL_KIND_ALU; /* ADR, ADD SP */
    if (op < 0xc000u) {
        if ((op & 0xf500u) == 0xb100u)
            return HIL_KIND_BRANCH; /* CBZ, CBNZ */
        if ((op & 0xfe00u) == 0xb400u)
            return HIL_KIND_STORE; /* PUSH */
        if ((op & 0xfe00u) == 0xbc00u)
            return HIL_KIND_LOAD; /* POP */
        if ((op & 0xff00u) == 0xbf00u)
            return (op & 0xfu) ? HIL_KIND_ALU : HIL_KIND_SYSTEM; /* IT, hints */
        /* CPS, BKPT */
        return (op & 0xffe8u) == 0xb660u || (op & 0xff00u) == 0xbe00u ? HIL_KIND_SYSTEM
                                                                      : HIL_KIND_ALU;
    }
    if (op < 0xd000u)
        return (op & 0x0800u) ? HIL_KIND_LOAD : HIL_KIND_STORE; /* LDM, STM */
    return (op & 0xff00u) == 0xdf00u ? HIL_KIND_SYSTEM : HIL_KIND_BRANCH;
}

static enum hil_kind kind_fp(uint16_t a, uint16_t b)
{
    if ((a & 0xff00u) == 0xee00u || (a & 0xff00u) == 0xfe00u) {
        if (b & 0x10u)
            return HIL_KIND_FP; /* moves to and from core registers */
        bool divide = (a & 0xffb0u) == 0xee80u && !(b & 0x40u);
        bool root = (a & 0xffbfu) == 0xeeb1u && (b & 0xc0u) == 0xc0u;
        return divide || root ? HIL_KIND_FP_SLOW : HIL_KIND_FP;
    }
    if ((a & 0xffe0u) == 0xec40u)
        return HIL_KIND_FP; /* VMOV of two core registers */
    return (a & 0x10u) ? HIL_KIND_FP_LOAD : HIL_KIND_FP_STORE;
}

static enum hil_kind kind32(uint16_t a, uint16_t b)
{
    unsigned coprocessor = b >> 8 & 0xfu;
    if ((a & 0xec00u) == 0xec00u)
        return coprocessor == 10 || coprocessor == 11 ? kind_fp(a, b) : HIL_KIND_SYSTEM;
    if ((a & 0xfe00u) == 0xe800u) {
        if ((a & 0xfff0u) == 0xe8d0u && (b & 0xf0e0u) == 0xf000u)
            return HIL_KIND_BRANCH; /* TBB, TBH */
        return (a & 0x10u) ? HIL_KIND_LOAD : HIL_KIND_STORE;
    }
    if ((a & 0xf800u) == 0xf000u && (b & 0x8000u)) { /* branches and miscellaneous control */
        bool branch = (b & 0x5000u) != 0 || (a & 0x0380u) != 0x0380u;
        return branch ? HIL_KIND_BRANCH : HIL_KIND_SYSTEM;
    }
    if ((a & 0xfe00u) == 0xf800u)
        return (a & 0x10u) ? HIL_KIND_LOAD : HIL_KIND_STORE;
    if ((a & 0xff80u) == 0xfb00u)
        return HIL_KIND_MULTIPLY;
    if ((a & 0xff80u) == 0xfb80u)
        return (a & 0x50u) == 0x10u && (b & 0xf0u) == 0xf0u ? HIL_KIND_DIVIDE : HIL_KIND_MULTIPLY;
    return HIL_KIND_ALU;
}

enum hil_kind hil_profile_kind(uint16_t first, uint16_t second)
{
    return first < 0xe800u ? kind16(first) : kind32(first, second);
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
        block.kinds[hil_profile_kind(first, second)]++;
        i += wide ? 4 : 2;
    }
    if (!block.instructions)
        block.instructions = block.kinds[HIL_KIND_SYSTEM] = 1; /* counted as the core counts it */
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
        profile->runs[profile->exception][number]++;
    else
        profile->part[profile->exception] += instructions;
}

static void enter(void *who, unsigned exception)
{
    struct hil_profile *profile = who;
    profile->exception = exception < HIL_EXCEPTIONS ? exception : 0;
    if (profile->runs[profile->exception])
        return;
    profile->runs[profile->exception] = calloc(BLOCKS_MAX, sizeof(uint64_t));
    if (!profile->runs[profile->exception])
        abort();
}

static void end(void *who)
{
    struct hil_profile *profile = who;
    for (unsigned i = 0; i < HIL_EXCEPTIONS; i++)
        free(profile->runs[i]);
    free(profile);
}

static const struct hil_profiler_calls calls = {
    .block = number_of, .count = count, .exception = enter, .end = end};

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
    enter(profile, hil_board_register(board, 16) & 0x1ffu);
    hil_cpu_forget_code(&board->core); /* blocks have no numbers yet */
}

void hil_profile_end(struct hil_board *board)
{
    if (profile_of(board))
        end(profile_of(board));
    board->core.onlookers.profiler = NULL;
    board->core.onlookers.profiler_who = NULL;
}

/* --- the report --- */

struct row {
    const struct mr_symbol *symbol; /* NULL: outside of any function */
    unsigned exception;
    uint64_t instructions, entries;
};

static uint64_t instructions_of(const struct hil_profile *profile, unsigned exception,
                                uint32_t number)
{
    return profile->runs[exception]
             ? profile->runs[exception][number] * profile->block[number].instructions
             : 0;
}

static uint64_t total_of(const struct hil_profile *profile, unsigned exception)
{
    uint64_t total = profile->part[exception];
    for (uint32_t i = 1; i < profile->blocks; i++)
        total += instructions_of(profile, exception, i);
    return total;
}

static int by_instructions(const void *a, const void *b)
{
    const struct row *x = a, *y = b;
    if (x->instructions != y->instructions)
        return x->instructions > y->instructions ? -1 : 1;
    if (x->exception != y->exception)
        return x->exception < y->exception ? -1 : 1;
    return x->symbol && y->symbol ? strcmp(x->symbol->name, y->symbol->name)
                                  : !x->symbol - !y->symbol;
}

static double percent(uint64_t part, uint64_t whole)
{
    return whole ? 100.0 * (double)part / (double)whole : 0.0;
}

static void level_name(const struct hil_board *board, const struct mr_symbols *symbols,
                       unsigned exception, char *text, size_t size)
{
    uint32_t vector = 0;
    if (!exception) {
        snprintf(text, size, "thread");
        return;
    }
    hil_board_peek(board, board->core.state.scb.vtor + 4u * exception, &vector, 4);
    const struct mr_symbol *symbol = mr_symbols_at(symbols, vector & ~1u);
    snprintf(text, size, "exception %u %s", exception, symbol ? symbol->name : "");
}

static void print_levels(const struct hil_board *board, const struct mr_symbols *symbols,
                         uint64_t total, FILE *file)
{
    fputs("\nby level\n   instructions       %  level\n", file);
    for (unsigned i = 0; i < HIL_EXCEPTIONS; i++) {
        char name[96];
        uint64_t n = total_of(profile_of(board), i);
        if (!n)
            continue;
        level_name(board, symbols, i, name, sizeof name);
        fprintf(file, "%15llu  %6.2f  %s\n", (unsigned long long)n, percent(n, total), name);
    }
}

static void print_kinds(const struct hil_profile *profile, uint64_t total, FILE *file)
{
    uint64_t kinds[HIL_KINDS] = {0}, part = 0;
    for (unsigned e = 0; e < HIL_EXCEPTIONS; e++) {
        part += profile->part[e];
        for (uint32_t i = 1; profile->runs[e] && i < profile->blocks; i++) {
            for (unsigned k = 0; k < HIL_KINDS; k++)
                kinds[k] += profile->runs[e][i] * profile->block[i].kinds[k];
        }
    }
    fputs("\nby kind\n   instructions       %  kind\n", file);
    for (unsigned k = 0; k < HIL_KINDS; k++)
        fprintf(file, "%15llu  %6.2f  %s\n", (unsigned long long)kinds[k], percent(kinds[k], total),
                kind_names[k]);
    if (part)
        fprintf(file, "%15llu  %6.2f  in blocks that were not run whole\n",
                (unsigned long long)part, percent(part, total));
}

/* Blocks sorted into functions: one row for each function and level. */
static struct row *collect(const struct hil_profile *profile, const struct mr_symbols *symbols,
                           size_t *count)
{
    size_t room = 0;
    struct row *rows = NULL;
    *count = 0;
    for (unsigned e = 0; e < HIL_EXCEPTIONS; e++) {
        size_t first = *count;
        for (uint32_t i = 1; profile->runs[e] && i < profile->blocks; i++) {
            const struct mr_symbol *symbol = mr_symbols_at(symbols, profile->block[i].address);
            size_t k = first;
            if (!profile->runs[e][i])
                continue;
            while (k < *count && rows[k].symbol != symbol)
                k++;
            if (k == room) {
                room = room ? 2 * room : 256;
                rows = realloc(rows, room * sizeof *rows);
                if (!rows)
                    abort();
            }
            if (k == *count)
                rows[(*count)++] = (struct row){.symbol = symbol, .exception = e};
            rows[k].instructions += instructions_of(profile, e, i);
            if (symbol && symbol->address == profile->block[i].address)
                rows[k].entries += profile->runs[e][i];
        }
    }
    if (rows)
        qsort(rows, *count, sizeof *rows, by_instructions);
    return rows;
}

enum mr_status hil_profile_print(const struct hil_board *board, const struct mr_symbols *symbols,
                                 FILE *file)
{
    const struct hil_profile *profile = profile_of(board);
    const struct hil_counters *c = hil_board_counters(board);
    uint64_t total = 0;
    size_t count;
    for (unsigned i = 0; i < HIL_EXCEPTIONS; i++)
        total += total_of(profile, i);
    fprintf(file,
            "matrig-board profile: %llu instructions in %.6f s of virtual time, asleep %.2f %% of "
            "its cycles\n",
            (unsigned long long)total, (double)hil_board_now_ps(board) * 1e-12,
            percent(c->asleep_cycles, hil_board_now_cycles(board)));
    print_levels(board, symbols, total, file);
    print_kinds(profile, total, file);
    fputs("\nby function (entries: calls, and returns to its first instruction)\n"
          "   instructions       %       entries  function, level\n",
          file);
    struct row *rows = collect(profile, symbols, &count);
    for (size_t i = 0; i < count; i++) {
        char name[96];
        level_name(board, symbols, rows[i].exception, name, sizeof name);
        fprintf(file, "%15llu  %6.2f  %12llu  %s, %s\n", (unsigned long long)rows[i].instructions,
                percent(rows[i].instructions, total), (unsigned long long)rows[i].entries,
                rows[i].symbol ? rows[i].symbol->name : "(no function)", name);
    }
    free(rows);
    return fflush(file) == 0 && !ferror(file) ? MR_OK : MR_IO;
}
