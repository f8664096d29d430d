#include "hil/chips/w25q.h"

#include <string.h>

#include "hil/board/machine.h"

enum command {
    WRITE_STATUS_1 = 0x01, PAGE_PROGRAM = 0x02, READ = 0x03, WRITE_DISABLE = 0x04, READ_STATUS_1 = 0x05,
    WRITE_ENABLE = 0x06, FAST_READ = 0x0b, WRITE_STATUS_3 = 0x11, READ_STATUS_3 = 0x15, ERASE_4K = 0x20,
    WRITE_STATUS_2 = 0x31, READ_STATUS_2 = 0x35, UNIQUE_ID = 0x4b, VOLATILE_ENABLE = 0x50, ERASE_32K = 0x52,
    ERASE_ALL_60 = 0x60, ENABLE_RESET = 0x66, MANUFACTURER_ID = 0x90, RESET = 0x99, JEDEC_ID = 0x9f, RELEASE = 0xab,
    POWER_DOWN = 0xb9, ERASE_ALL = 0xc7, ERASE_64K = 0xd8,
};

#define BUSY 1u
#define WEL 2u
#define MANUFACTURER 0xefu
#define DEVICE 0x17u
#define HUNG 10u /* times the maximum that a failing operation takes */

static const uint8_t factory_status[3] = {0x00, 0x02, 0x60}; /* QE fixed to 1 (-IQ); drive strength 25 % */
static const uint8_t writable_status[3] = {0xfc, 0x79, 0x64};
#define STATUS_1_TB 0x20u
#define STATUS_1_SEC 0x40u
#define STATUS_2_SRL 0x01u
#define STATUS_2_LB 0x38u
#define STATUS_2_CMP 0x40u
#define STATUS_3_WPS 0x04u

static uint8_t *cells(const struct hil_board *board) { return board->memory->nor; }

static bool has_bit(const uint8_t *bits, uint32_t n) { return bits && (bits[n / 8u] >> n % 8u & 1u); }

static void put_cell(struct hil_board *board, uint32_t address, uint8_t value)
{
    uint32_t sector = address / HIL_NOR_SECTOR;
    cells(board)[address] = (uint8_t)~value; /* kept inverted, so that an erased chip is memory never touched */
    board->state.w25q.used[sector / 8u] |= (uint8_t)(1u << sector % 8u);
}

static uint8_t get_cell(const struct hil_board *board, uint32_t address) { return (uint8_t)~cells(board)[address]; }

/* Protected addresses [*from, *to), from BP, TB, SEC, CMP (7.1.3 to 7.1.8; status register memory protection). */
static void protected_range(const struct hil_w25q *w, uint32_t *from, uint32_t *to)
{
    unsigned bp = w->status[0] >> 2 & 7u;
    uint32_t bytes = HIL_NOR_SIZE;
    if (bp == 0)
        bytes = 0;
    else if (bp < 7 && (w->status[0] & STATUS_1_SEC))
        bytes = bp < 4 ? HIL_NOR_SECTOR << (bp - 1u) : 8u * HIL_NOR_SECTOR;
    else if (bp < 7)
        bytes = 0x20000u << bp;
    bool bottom = (w->status[0] & STATUS_1_TB) != 0;
    if (w->status[1] & STATUS_2_CMP) { /* all but that */
        bytes = HIL_NOR_SIZE - bytes;
        bottom = !bottom;
    }
    *from = bottom ? 0 : HIL_NOR_SIZE - bytes;
    *to = bottom ? bytes : HIL_NOR_SIZE;
}

static bool is_protected(const struct hil_w25q *w, uint32_t first, uint32_t bytes)
{
    uint32_t from, to;
    protected_range(w, &from, &to);
    return first < to && first + bytes > from;
}

static bool has_fault(const struct hil_w25q *w, unsigned kind, uint32_t first, uint32_t bytes)
{
    return (w->faults.kinds & kind) && first < w->faults.to && first + bytes > w->faults.from;
}

/* Turn the cells concerned into what the operation wants, as far as it got. */
static void change_cells(struct hil_board *board, unsigned permille)
{
    struct hil_w25q *w = &board->state.w25q;
    uint8_t plain[HIL_NOR_SECTOR], wanted[HIL_NOR_PAGE];
    bool program = w->operation == PAGE_PROGRAM;
    uint32_t step = program ? HIL_NOR_PAGE : HIL_NOR_SECTOR;
    for (uint32_t at = w->first; at < w->first + w->bytes; at += step) {
        if (!program && !has_bit(w->used, at / HIL_NOR_SECTOR))
            continue;
        for (uint32_t i = 0; i < step; i++)
            plain[i] = get_cell(board, at + i);
        for (uint32_t i = 0; program && i < step; i++)
            wanted[i] = has_bit(w->in_page, i) ? plain[i] & w->page[i] : plain[i];
        hil_cells_tear(plain, program ? wanted : NULL, step, permille, &w->random);
        for (uint32_t i = 0; i < step; i++)
            put_cell(board, at + i, plain[i]);
        if (!program && permille >= 1000)
            w->used[at / HIL_NOR_SECTOR / 8u] &= (uint8_t)~(1u << at / HIL_NOR_SECTOR % 8u);
    }
}

static void set_status(struct hil_w25q *w, const uint8_t from[3], bool lasting)
{
    memcpy(w->status, from, 3);
    w->status[0] &= (uint8_t)~(BUSY | WEL);
    if (lasting)
        memcpy(w->lasting_status, w->status, 3);
}

/* The operation ends: in time, or cut off after permille of its time. */
static void end_operation(struct hil_board *board, unsigned permille)
{
    struct hil_w25q *w = &board->state.w25q;
    bool program = w->operation == PAGE_PROGRAM;
    if (w->bytes == 0) {
        if (permille >= 1000 || (hil_random(&w->random) & 1023u) < permille)
            set_status(w, w->written_status, true);
    } else if (!w->fails_silently
               && !has_fault(w, program ? HIL_W25Q_PROGRAM_SILENT : HIL_W25Q_ERASE_SILENT, w->first, w->bytes)) {
        bool fails = has_fault(w, program ? HIL_W25Q_PROGRAM_ERROR : HIL_W25Q_ERASE_ERROR, w->first, w->bytes);
        change_cells(board, fails ? permille / 2u : permille);
    }
    w->operation = 0;
    w->status[0] &= (uint8_t)~(BUSY | WEL);
    hil_event_set_ps(board, HIL_EVENT_NOR, HIL_NEVER);
    hil_event_set_ps(board, HIL_EVENT_NOR_CUT, HIL_NEVER);
}

static void settle(struct hil_board *board, uint64_t t_ps)
{
    struct hil_w25q *w = &board->state.w25q;
    if (w->operation && t_ps >= w->end_ps)
        end_operation(board, 1000);
}

void hil_w25q_event(struct hil_board *board, uint64_t at) { settle(board, hil_clock_ps(&board->state.clock, at)); }

/* Is this program or erase one of those that the script wants to fail? */
static bool is_ordered_to_fail(struct hil_board *board, bool program)
{
    struct hil_nor_faults *orders = &board->state.nor_faults;
    uint32_t *left = program ? &orders->fail_program : &orders->fail_erase;
    if (*left == 0)
        return false;
    --*left;
    return true;
}

static void start(struct hil_board *board, uint64_t t_ps, uint32_t first, uint32_t bytes, uint32_t typical_us,
                  uint32_t maximum_us)
{
    struct hil_w25q *w = &board->state.w25q;
    bool program = w->command == PAGE_PROGRAM;
    if (!(w->status[0] & WEL) || (bytes && is_protected(w, first, bytes))) {
        hil_trace(board, "NOR: command 0x%02x at 0x%06x ignored: %s", w->command, (unsigned)first,
                  (w->status[0] & WEL) ? "protected" : "not write-enabled");
        return;
    }
    w->operation = w->command;
    w->operations++;
    w->first = first;
    w->bytes = bytes;
    w->begin_ps = t_ps;
    w->end_ps = t_ps + hil_cell_time_ps(board->options.cell_times, typical_us, maximum_us, &w->random);
    if (bytes && has_fault(w, program ? HIL_W25Q_PROGRAM_ERROR : HIL_W25Q_ERASE_ERROR, first, bytes))
        w->end_ps = t_ps + HUNG * (uint64_t)maximum_us * HIL_US_PS;
    w->fails_silently = bytes && is_ordered_to_fail(board, program);
    w->status[0] |= BUSY;
    hil_event_set_ps(board, HIL_EVENT_NOR, w->end_ps);
    if (w->operations == w->cut_at)
        hil_event_set_ps(board, HIL_EVENT_NOR_CUT, t_ps + (w->end_ps - t_ps) / 1000u * w->cut_permille);
    if (bytes)
        hil_faults_nor_operation(board);
}

static void write_status(struct hil_board *board, uint64_t t_ps, unsigned which)
{
    struct hil_w25q *w = &board->state.w25q;
    bool lasting = !w->volatile_enabled;
    uint32_t given = w->count - 1u;
    w->volatile_enabled = false;
    if (given == 0 || given > (which == 0 ? 2u : 1u) || (w->status[1] & STATUS_2_SRL)) {
        hil_trace(board, "NOR: status write ignored: %u bytes, SRL %u", (unsigned)given, w->status[1] & STATUS_2_SRL);
        return;
    }
    memcpy(w->written_status, w->status, 3);
    for (unsigned i = 0; i < given; i++) {
        uint8_t mask = writable_status[which + i];
        w->written_status[which + i] = (uint8_t)((w->status[which + i] & ~mask) | (w->parameter[i] & mask));
    }
    w->written_status[1] |= w->status[1] & STATUS_2_LB; /* one time only */
    if (w->written_status[2] & STATUS_3_WPS) {
        hil_board_stop(board, MR_UNMODELLED, "unmodelled: individual block locks of the NOR (WPS)");
        return;
    }
    if (lasting)
        start(board, t_ps, 0, 0, 10000, 15000);
    else
        set_status(w, w->written_status, false);
}

static void reset_chip(struct hil_board *board, uint64_t t_ps)
{
    struct hil_w25q *w = &board->state.w25q;
    if (w->operation) /* "data corruption may happen" (8.2.36) */
        end_operation(board, (unsigned)((t_ps - w->begin_ps) * 1000u / (w->end_ps - w->begin_ps)));
    memcpy(w->status, w->lasting_status, 3);
    w->powered_down = w->reset_enabled = w->volatile_enabled = false;
}

/* Chip select rises: what was shifted in is carried out. */
static void act(struct hil_board *board, uint64_t t_ps)
{
    struct hil_w25q *w = &board->state.w25q;
    uint32_t block = w->command == ERASE_4K ? HIL_NOR_SECTOR : w->command == ERASE_32K ? 0x8000u : 0x10000u;
    bool reset_enabled = w->reset_enabled;
    w->reset_enabled = false;
    switch (w->command) {
    case WRITE_ENABLE:
        w->status[0] |= WEL;
        break;
    case WRITE_DISABLE:
        w->status[0] &= (uint8_t)~WEL;
        break;
    case VOLATILE_ENABLE:
        w->volatile_enabled = true;
        break;
    case WRITE_STATUS_1:
        write_status(board, t_ps, 0);
        break;
    case WRITE_STATUS_2:
        write_status(board, t_ps, 1);
        break;
    case WRITE_STATUS_3:
        write_status(board, t_ps, 2);
        break;
    case PAGE_PROGRAM:
        if (w->page_count)
            start(board, t_ps, w->address & ~(HIL_NOR_PAGE - 1u), HIL_NOR_PAGE, 700, 3000);
        break;
    case ERASE_4K:
    case ERASE_32K:
    case ERASE_64K:
        if (w->count == 4)
            start(board, t_ps, w->address & ~(block - 1u), block,
                  w->command == ERASE_4K ? 45000 : w->command == ERASE_32K ? 120000 : 150000,
                  w->command == ERASE_4K ? 400000 : w->command == ERASE_32K ? 1600000 : 2000000);
        break;
    case ERASE_ALL:
    case ERASE_ALL_60:
        start(board, t_ps, 0, HIL_NOR_SIZE, 40000000, 200000000);
        break;
    case POWER_DOWN:
        w->powered_down = true;
        break;
    case RELEASE:
        w->powered_down = false;
        break;
    case ENABLE_RESET:
        w->reset_enabled = true;
        break;
    case RESET:
        if (reset_enabled)
            reset_chip(board, t_ps);
        break;
    default:
        break;
    }
}

static bool is_status_read(uint8_t command)
{
    return command == READ_STATUS_1 || command == READ_STATUS_2 || command == READ_STATUS_3;
}

/* Is the command heard in the chip's present state? */
static bool hears(const struct hil_w25q *w)
{
    if (w->faults.kinds & HIL_W25Q_DEAD || w->dead)
        return false;
    if (w->operation)
        return is_status_read(w->command) || w->command == ENABLE_RESET || w->command == RESET;
    return !w->powered_down || w->command == RELEASE;
}

static uint8_t read_cell(struct hil_board *board)
{
    struct hil_w25q *w = &board->state.w25q;
    uint32_t address = w->address;
    uint8_t value = get_cell(board, address);
    w->address = (address + 1u) % HIL_NOR_SIZE;
    if (has_fault(w, HIL_W25Q_READ_ERROR, address, 1)) {
        uint64_t random = hil_random(&w->random);
        if (random % 64u == 0)
            value ^= (uint8_t)(1u << (random >> 8 & 7u));
    }
    return value;
}

/* 64 bits that differ from board to board. */
static uint8_t unique_byte(const struct hil_board *board, uint32_t i)
{
    uint64_t seed = (uint64_t)board->options.uid[0] << 32 | board->options.uid[1];
    return (uint8_t)(hil_random(&seed) >> (56u - 8u * (i % 8u)));
}

/* Byte n (1: the first after the command) of a command with a three-byte address. */
static uint8_t addressed(struct hil_board *board, uint32_t n, uint8_t in)
{
    struct hil_w25q *w = &board->state.w25q;
    if (n <= 3) {
        w->address = (w->address << 8 | in) & 0xffffffu;
        return 0xff;
    }
    if (w->command == READ || (w->command == FAST_READ && n > 4))
        return read_cell(board);
    if (w->command == PAGE_PROGRAM) {
        uint32_t at = (w->address + w->page_count++) % HIL_NOR_PAGE; /* wraps; what comes last counts */
        w->page[at] = in;
        w->in_page[at / 8u] |= (uint8_t)(1u << at % 8u);
    } else if (w->command == MANUFACTURER_ID) {
        return ((n ^ w->address) & 1u) ? DEVICE : MANUFACTURER;
    }
    return 0xff;
}

static uint8_t answer(struct hil_board *board, uint32_t n, uint8_t in)
{
    struct hil_w25q *w = &board->state.w25q;
    static const uint8_t jedec[3] = {MANUFACTURER, 0x40, 0x18};
    switch (w->command) {
    case READ_STATUS_1:
        return w->status[0];
    case READ_STATUS_2:
        return w->status[1];
    case READ_STATUS_3:
        return w->status[2];
    case WRITE_STATUS_1:
    case WRITE_STATUS_2:
    case WRITE_STATUS_3:
        if (n <= 2)
            w->parameter[n - 1u] = in;
        return 0xff;
    case JEDEC_ID:
        return jedec[(n - 1u) % 3u];
    case RELEASE:
        return n > 3 ? DEVICE : 0xff;
    case UNIQUE_ID:
        return n > 4 ? unique_byte(board, n - 5u) : 0xff;
    case READ:
    case FAST_READ:
    case PAGE_PROGRAM:
    case ERASE_4K:
    case ERASE_32K:
    case ERASE_64K:
    case MANUFACTURER_ID:
        return addressed(board, n, in);
    default:
        return 0xff;
    }
}

static bool is_known(uint8_t command)
{
    static const uint8_t known[] = {
        WRITE_STATUS_1, PAGE_PROGRAM, READ, WRITE_DISABLE, READ_STATUS_1, WRITE_ENABLE, FAST_READ, WRITE_STATUS_3,
        READ_STATUS_3, ERASE_4K, WRITE_STATUS_2, READ_STATUS_2, UNIQUE_ID, VOLATILE_ENABLE, ERASE_32K, ERASE_ALL_60,
        ENABLE_RESET, MANUFACTURER_ID, RESET, JEDEC_ID, RELEASE, POWER_DOWN, ERASE_ALL, ERASE_64K, 0xff,
    };
    return memchr(known, command, sizeof known) != NULL;
}

/* What the fault script wants of the whole chip (hil/rig/faults.h). */
static void take_orders(struct hil_board *board)
{
    struct hil_w25q *w = &board->state.w25q;
    struct hil_nor_faults *orders = &board->state.nor_faults;
    w->dead = orders->dead;
    if (orders->fill_requested) {
        memset(cells(board), 0xff, HIL_NOR_SIZE); /* inverted: zeroes */
        memset(w->used, 0xff, sizeof w->used);
        orders->fill_requested = false;
    }
}

void hil_w25q_select(struct hil_board *board, uint64_t at)
{
    struct hil_w25q *w = &board->state.w25q;
    (void)at;
    w->selected = true;
    w->count = 0;
    take_orders(board);
}

uint8_t hil_w25q_exchange(struct hil_board *board, uint8_t in, uint64_t at)
{
    struct hil_w25q *w = &board->state.w25q;
    if (w->operation)
        settle(board, hil_clock_ps(&board->state.clock, at));
    uint32_t n = w->count++;
    if (n == 0) {
        w->command = in;
        w->address = w->page_count = 0;
        if (w->operation != PAGE_PROGRAM)
            memset(w->in_page, 0, sizeof w->in_page);
        if (!is_known(in))
            hil_board_stop(board, MR_UNMODELLED, "unmodelled: command 0x%02x of the NOR", in);
        return 0xff;
    }
    return hears(w) ? answer(board, n, in) : 0xff;
}

void hil_w25q_deselect(struct hil_board *board, uint64_t at, bool in_byte)
{
    struct hil_w25q *w = &board->state.w25q;
    uint64_t t_ps = hil_clock_ps(&board->state.clock, at);
    settle(board, t_ps);
    if (w->selected && w->count && !in_byte && hears(w))
        act(board, t_ps);
    w->selected = false;
}

void hil_w25q_power_lost(struct hil_board *board)
{
    struct hil_w25q *w = &board->state.w25q;
    uint64_t now_ps = hil_board_now_ps(board);
    settle(board, now_ps);
    w->lasting_status[1] &= (uint8_t)~STATUS_2_SRL; /* locked until the next power-up (7.1.5) */
    reset_chip(board, now_ps);
    w->selected = false;
}

void hil_w25q_cut_event(struct hil_board *board, uint64_t at)
{
    struct hil_w25q *w = &board->state.w25q;
    (void)at;
    w->cut_at = 0;
    end_operation(board, w->cut_permille);
    hil_board_cut_power(board);
}

void hil_w25q_create(struct hil_board *board)
{
    struct hil_w25q *w = &board->state.w25q;
    *w = (struct hil_w25q){.random = board->options.seed ^ 0x25c128000025c128ull};
    set_status(w, factory_status, true);
}

void hil_w25q_copy(struct hil_memory *to, const uint8_t *stale, const struct hil_memory *from, const uint8_t *used)
{
    for (uint32_t sector = 0; sector < HIL_NOR_SIZE / HIL_NOR_SECTOR; sector++) {
        size_t at = (size_t)sector * HIL_NOR_SECTOR;
        if (has_bit(used, sector))
            memcpy(to->nor + at, from->nor + at, HIL_NOR_SECTOR);
        else if (has_bit(stale, sector))
            memset(to->nor + at, 0, HIL_NOR_SECTOR);
    }
}

void hil_board_w25q_faults(struct hil_board *board, const struct hil_w25q_faults *faults)
{
    board->state.w25q.faults = *faults;
}

void hil_board_cut_at_nor(struct hil_board *board, uint64_t n, unsigned permille)
{
    struct hil_w25q *w = &board->state.w25q;
    w->cut_at = n ? w->operations + n : 0;
    w->cut_permille = permille < 1000 ? permille : 999;
}

uint64_t hil_board_nor_operations(const struct hil_board *board) { return board->state.w25q.operations; }

enum mr_status hil_board_nor_peek(const struct hil_board *board, uint32_t address, void *out, size_t n)
{
    uint8_t *to = out;
    if (address >= HIL_NOR_SIZE || n > HIL_NOR_SIZE - address)
        return MR_UNKNOWN;
    for (size_t i = 0; i < n; i++)
        to[i] = get_cell(board, address + (uint32_t)i);
    return MR_OK;
}

enum mr_status hil_board_nor_poke(struct hil_board *board, uint32_t address, const void *bytes, size_t n)
{
    const uint8_t *from = bytes;
    if (address >= HIL_NOR_SIZE || n > HIL_NOR_SIZE - address)
        return MR_UNKNOWN;
    for (size_t i = 0; i < n; i++) {
        if (from[i] != get_cell(board, address + (uint32_t)i))
            put_cell(board, address + (uint32_t)i, from[i]);
    }
    return MR_OK;
}
