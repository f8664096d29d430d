#include "hil/chips/w25q.h"

#include <string.h>

#include "hil/core/core.h"
#include "hil/core/event.h"
#include "hil/core/state.h"
#include "hil/periph/cells.h"
#include "hil/periph/options.h"
#include "hil/periph/rules.h"

#define BUSY         1u
#define WEL          2u
#define MANUFACTURER 0xefu
#define DEVICE       0x17u
#define HUNG         10u /* times the maximum that a failing operation takes */

/* QE fixed to 1 (-IQ); drive strength 25 % */
static const uint8_t factory_status[3] = {0x00, 0x02, 0x60};
static const uint8_t writable_status[3] = {0xfc, 0x79, 0x64};
#define STATUS_1_TB  0x20u
#define STATUS_1_SEC 0x40u
#define STATUS_2_SRL 0x01u
#define STATUS_2_LB  0x38u
#define STATUS_2_CMP 0x40u
#define STATUS_3_WPS 0x04u

static bool has_bit(const uint8_t *bits, uint32_t n)
{
    return (bits[n / 8u] >> n % 8u & 1u);
}

static void put_cell(struct hil_w25q_device *dev, uint32_t address, uint8_t value)
{
    uint32_t sector = address / HIL_NOR_SECTOR;
    /* kept inverted, so that an erased chip is memory never touched */
    dev->cells[address] = (uint8_t)~value;
    dev->state->used[sector / 8u] |= (uint8_t)(1u << sector % 8u);
}

static uint8_t get_cell(const struct hil_w25q_device *dev, uint32_t address)
{
    return (uint8_t)~dev->cells[address];
}

/* Protected addresses [*from, *to), from BP, TB, SEC, CMP (7.1.3 to 7.1.8; status register memory
 * protection). */
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
static void change_cells(struct hil_w25q_device *dev, unsigned permille)
{
    struct hil_w25q *w = dev->state;
    uint8_t plain[HIL_NOR_SECTOR], wanted[HIL_NOR_PAGE];
    bool program = w->operation == PAGE_PROGRAM;
    uint32_t step = program ? HIL_NOR_PAGE : HIL_NOR_SECTOR;
    for (uint32_t at = w->first; at < w->first + w->bytes; at += step) {
        if (!program && !has_bit(w->used, at / HIL_NOR_SECTOR))
            continue;
        for (uint32_t i = 0; i < step; i++)
            plain[i] = get_cell(dev, at + i);
        for (uint32_t i = 0; program && i < step; i++)
            wanted[i] = has_bit(w->in_page, i) ? plain[i] & w->page[i] : plain[i];
        hil_cells_tear(plain, program ? wanted : NULL, step, permille, &w->random);
        for (uint32_t i = 0; i < step; i++)
            put_cell(dev, at + i, plain[i]);
        if (!program && permille >= 1000)
            w->used[at / HIL_NOR_SECTOR / 8u] &= (uint8_t) ~(1u << at / HIL_NOR_SECTOR % 8u);
    }
}

static void set_status(struct hil_w25q *w, const uint8_t from[3], bool lasting)
{
    memcpy(w->status, from, 3);
    w->status[0] &= (uint8_t) ~(BUSY | WEL);
    if (lasting)
        memcpy(w->lasting_status, w->status, 3);
}

/* The operation ends: in time, or cut off after permille of its time. */
static void end_operation(struct hil_w25q_device *dev, unsigned permille)
{
    struct hil_w25q *w = dev->state;
    bool program = w->operation == PAGE_PROGRAM;
    if (w->bytes == 0) {
        if (permille >= 1000 || (hil_random(&w->random) & 1023u) < permille)
            set_status(w, w->written_status, true);
    } else if (!w->fails_silently &&
               !has_fault(w, program ? HIL_W25Q_PROGRAM_SILENT : HIL_W25Q_ERASE_SILENT, w->first,
                          w->bytes)) {
        bool fails = has_fault(w, program ? HIL_W25Q_PROGRAM_ERROR : HIL_W25Q_ERASE_ERROR, w->first,
                               w->bytes);
        change_cells(dev, fails ? permille / 2u : permille);
    }
    w->operation = 0;
    w->status[0] &= (uint8_t) ~(BUSY | WEL);
    hil_event_set_ps(dev->core, HIL_EVENT_NOR, HIL_NEVER);
    hil_event_set_ps(dev->core, HIL_EVENT_NOR_CUT, HIL_NEVER);
}

static void settle(struct hil_w25q_device *dev, uint64_t t_ps)
{
    struct hil_w25q *w = dev->state;
    if (w->operation && t_ps >= w->end_ps)
        end_operation(dev, 1000);
}

static void on_end(void *device, uint64_t at)
{
    struct hil_w25q_device *dev = device;
    settle(dev, hil_clock_ps(&dev->core->state.clock, at));
}

/* Is this program or erase one of those that the script wants to fail? */
static bool is_ordered_to_fail(struct hil_w25q_device *dev, bool program)
{
    struct hil_nor_orders *orders = dev->orders;
    uint32_t *left = program ? &orders->fail_program : &orders->fail_erase;
    if (*left == 0)
        return false;
    --*left;
    return true;
}

static void start(struct hil_w25q_device *dev, uint64_t t_ps, uint32_t first, uint32_t bytes,
                  uint32_t typical_us, uint32_t maximum_us)
{
    struct hil_w25q *w = dev->state;
    bool program = w->command == PAGE_PROGRAM;
    if (!(w->status[0] & WEL) || (bytes && is_protected(w, first, bytes))) {
        hil_trace(dev->core, "NOR: command 0x%02x at 0x%06x ignored: %s", w->command,
                  (unsigned)first, (w->status[0] & WEL) ? "protected" : "not write-enabled");
        return;
    }
    w->operation = w->command;
    w->operations++;
    w->first = first;
    w->bytes = bytes;
    w->begin_ps = t_ps;
    w->end_ps = t_ps +
                hil_cell_time_ps(dev->options->cell_times, typical_us, maximum_us, &w->random);
    if (bytes &&
        has_fault(w, program ? HIL_W25Q_PROGRAM_ERROR : HIL_W25Q_ERASE_ERROR, first, bytes))
        w->end_ps = t_ps + HUNG * (uint64_t)maximum_us * HIL_US_PS;
    w->fails_silently = bytes && is_ordered_to_fail(dev, program);
    w->status[0] |= BUSY;
    hil_event_set_ps(dev->core, HIL_EVENT_NOR, w->end_ps);
    if (w->operations == w->cut_at)
        hil_event_set_ps(dev->core, HIL_EVENT_NOR_CUT,
                         t_ps + (w->end_ps - t_ps) / 1000u * w->cut_permille);
    if (bytes)
        hil_call(&dev->began);
}

static void write_status(struct hil_w25q_device *dev, uint64_t t_ps, unsigned which)
{
    struct hil_w25q *w = dev->state;
    bool lasting = !w->volatile_enabled;
    uint32_t given = w->count - 1u;
    w->volatile_enabled = false;
    if (given == 0 || given > (which == 0 ? 2u : 1u) || (w->status[1] & STATUS_2_SRL)) {
        hil_trace(dev->core, "NOR: status write ignored: %u bytes, SRL %u", (unsigned)given,
                  w->status[1] & STATUS_2_SRL);
        return;
    }
    memcpy(w->written_status, w->status, 3);
    for (unsigned i = 0; i < given; i++) {
        uint8_t mask = writable_status[which + i];
        w->written_status[which + i] = (uint8_t)((w->status[which + i] & ~mask) |
                                                 (w->parameter[i] & mask));
    }
    w->written_status[1] |= w->status[1] & STATUS_2_LB; /* one time only */
    if (w->written_status[2] & STATUS_3_WPS) {
        hil_core_stop(dev->core, MR_UNMODELLED,
                      "unmodelled: individual block locks of the NOR (WPS)");
        return;
    }
    if (lasting)
        start(dev, t_ps, 0, 0, 10000, 15000);
    else
        set_status(w, w->written_status, false);
}

static void reset_chip(struct hil_w25q_device *dev, uint64_t t_ps)
{
    struct hil_w25q *w = dev->state;
    if (w->operation) /* "data corruption may happen" (8.2.36) */
        end_operation(dev, (unsigned)((t_ps - w->begin_ps) * 1000u / (w->end_ps - w->begin_ps)));
    memcpy(w->status, w->lasting_status, 3);
    w->powered_down = w->reset_enabled = w->volatile_enabled = false;
}

/* A block of so many bytes, when its address was given and nothing more. */
static void erase(struct hil_w25q_device *dev, uint64_t t_ps, uint32_t block, uint32_t typical_us,
                  uint32_t maximum_us)
{
    if (dev->state->count == 4)
        start(dev, t_ps, dev->state->address & ~(block - 1u), block, typical_us, maximum_us);
}

/* Chip select rises: what was shifted in is carried out. */
static void act(struct hil_w25q_device *dev, uint64_t t_ps)
{
    struct hil_w25q *w = dev->state;
    bool reset_enabled = w->reset_enabled;
    w->reset_enabled = false;
    w->past.rests = w->command == RESET && !reset_enabled ? 0 : w->command;
    switch (w->command) {
    case WRITE_ENABLE: w->status[0] |= WEL; break;
    case WRITE_DISABLE: w->status[0] &= (uint8_t)~WEL; break;
    case VOLATILE_ENABLE: w->volatile_enabled = true; break;
    case WRITE_STATUS_1: write_status(dev, t_ps, 0); break;
    case WRITE_STATUS_2: write_status(dev, t_ps, 1); break;
    case WRITE_STATUS_3: write_status(dev, t_ps, 2); break;
    case PAGE_PROGRAM:
        if (w->page_count)
            start(dev, t_ps, w->address & ~(HIL_NOR_PAGE - 1u), HIL_NOR_PAGE, 700, 3000);
        break;
    case ERASE_4K: erase(dev, t_ps, HIL_NOR_SECTOR, 45000, 400000); break;
    case ERASE_32K: erase(dev, t_ps, 0x8000, 120000, 1600000); break;
    case ERASE_64K: erase(dev, t_ps, 0x10000, 150000, 2000000); break;
    case ERASE_ALL:
    case ERASE_ALL_60: start(dev, t_ps, 0, HIL_NOR_SIZE, 40000000, 200000000); break;
    case POWER_DOWN: w->powered_down = true; break;
    case RELEASE: w->powered_down = false; break;
    case ENABLE_RESET: w->reset_enabled = true; break;
    case RESET:
        if (reset_enabled)
            reset_chip(dev, t_ps);
        break;
    default: break;
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

static uint8_t read_cell(struct hil_w25q_device *dev)
{
    struct hil_w25q *w = dev->state;
    uint32_t address = w->address;
    uint8_t value = get_cell(dev, address);
    w->address = (address + 1u) % HIL_NOR_SIZE;
    if (has_fault(w, HIL_W25Q_READ_ERROR, address, 1)) {
        uint64_t random = hil_random(&w->random);
        if (random % 64u == 0)
            value ^= (uint8_t)(1u << (random >> 8 & 7u));
    }
    return value;
}

/* 64 bits that differ from board to board. */
static uint8_t unique_byte(const struct hil_w25q_device *dev, uint32_t i)
{
    uint64_t seed = (uint64_t)dev->options->uid[0] << 32 | dev->options->uid[1];
    return (uint8_t)(hil_random(&seed) >> (56u - 8u * (i % 8u)));
}

/* Byte n (1: the first after the command) of a command with a three-byte address. */
static uint8_t addressed(struct hil_w25q_device *dev, uint32_t n, uint8_t in)
{
    struct hil_w25q *w = dev->state;
    if (n <= 3) {
        w->address = (w->address << 8 | in) & 0xffffffu;
        return 0xff;
    }
    if (w->command == READ || (w->command == FAST_READ && n > 4))
        return read_cell(dev);
    if (w->command == PAGE_PROGRAM) {
        /* wraps; what comes last counts */
        uint32_t at = (w->address + w->page_count++) % HIL_NOR_PAGE;
        w->page[at] = in;
        w->in_page[at / 8u] |= (uint8_t)(1u << at % 8u);
    } else if (w->command == MANUFACTURER_ID) {
        return ((n ^ w->address) & 1u) ? DEVICE : MANUFACTURER;
    }
    return 0xff;
}

static uint8_t answer(struct hil_w25q_device *dev, uint32_t n, uint8_t in)
{
    struct hil_w25q *w = dev->state;
    static const uint8_t jedec[3] = {MANUFACTURER, 0x40, 0x18};
    switch (w->command) {
    case READ_STATUS_1: return w->status[0];
    case READ_STATUS_2: return w->status[1];
    case READ_STATUS_3: return w->status[2];
    case WRITE_STATUS_1:
    case WRITE_STATUS_2:
    case WRITE_STATUS_3:
        if (n <= 2)
            w->parameter[n - 1u] = in;
        return 0xff;
    case JEDEC_ID: return jedec[(n - 1u) % 3u];
    case RELEASE: return n > 3 ? DEVICE : 0xff;
    case UNIQUE_ID: return n > 4 ? unique_byte(dev, n - 5u) : 0xff;
    case READ:
    case FAST_READ:
    case PAGE_PROGRAM:
    case ERASE_4K:
    case ERASE_32K:
    case ERASE_64K:
    case MANUFACTURER_ID: return addressed(dev, n, in);
    default: return 0xff;
    }
}

/* Does the chip drive its output in byte n of a command (1: the first behind it)? */
static bool drives(uint8_t command, uint32_t n)
{
    switch (command) {
    case READ_STATUS_1:
    case READ_STATUS_2:
    case READ_STATUS_3:
    case JEDEC_ID: return n >= 1;
    case READ:
    case RELEASE:
    case MANUFACTURER_ID: return n > 3;
    case FAST_READ:
    case UNIQUE_ID: return n > 4;
    default: return false;
    }
}

static bool speaks(const void *device)
{
    const struct hil_w25q_device *dev = device;
    return dev->state->spoke;
}

static bool is_known(uint8_t command)
{
    static const uint8_t known[] = {
        WRITE_STATUS_1, PAGE_PROGRAM,    READ,           WRITE_DISABLE,
        READ_STATUS_1,  WRITE_ENABLE,    FAST_READ,      WRITE_STATUS_3,
        READ_STATUS_3,  ERASE_4K,        WRITE_STATUS_2, READ_STATUS_2,
        UNIQUE_ID,      VOLATILE_ENABLE, ERASE_32K,      ERASE_ALL_60,
        ENABLE_RESET,   MANUFACTURER_ID, RESET,          JEDEC_ID,
        RELEASE,        POWER_DOWN,      ERASE_ALL,      ERASE_64K,
        0xff,
    };
    return memchr(known, command, sizeof known) != NULL;
}

/* What the fault script wants of the whole chip (hil/rig/faults.h). */
static void take_orders(struct hil_w25q_device *dev)
{
    struct hil_w25q *w = dev->state;
    struct hil_nor_orders *orders = dev->orders;
    w->dead = orders->dead;
    if (orders->fill_requested) {
        memset(dev->cells, 0xff, HIL_NOR_SIZE); /* inverted: zeroes */
        memset(w->used, 0xff, sizeof w->used);
        orders->fill_requested = false;
    }
}

static void begin_command(void *device, uint64_t at)
{
    struct hil_w25q_device *dev = device;
    struct hil_w25q *w = dev->state;
    (void)at;
    w->selected = true;
    w->count = 0;
    take_orders(dev);
}

static uint8_t exchange(void *device, uint8_t in, uint64_t at)
{
    struct hil_w25q_device *dev = device;
    struct hil_w25q *w = dev->state;
    if (w->operation)
        settle(dev, hil_clock_ps(&dev->core->state.clock, at));
    uint32_t n = w->count++;
    if (n == 0) {
        w->spoke = false;
        hil_w25q_hold_rules(dev->rules, &w->past, in, hil_spi_period_ns(dev->spi));
        w->command = w->past.before = in;
        w->past.rests = 0;
        w->address = w->page_count = 0;
        if (w->operation != PAGE_PROGRAM)
            memset(w->in_page, 0, sizeof w->in_page);
        if (!is_known(in))
            hil_core_stop(dev->core, MR_UNMODELLED, "unmodelled: command 0x%02x of the NOR", in);
        return 0xff;
    }
    w->spoke = hears(w) && drives(w->command, n);
    return hears(w) ? answer(dev, n, in) : 0xff;
}

static void end_command(void *device, uint64_t at, bool in_byte)
{
    struct hil_w25q_device *dev = device;
    struct hil_w25q *w = dev->state;
    uint64_t t_ps = hil_clock_ps(&dev->core->state.clock, at);
    settle(dev, t_ps);
    if (w->selected && w->count && !in_byte && hears(w))
        act(dev, t_ps);
    w->selected = false;
}

struct hil_spi_slave hil_w25q_slave(struct hil_w25q_device *dev)
{
    return (struct hil_spi_slave){dev, begin_command, end_command, exchange, speaks};
}

void hil_w25q_power_lost(struct hil_w25q_device *dev)
{
    struct hil_w25q *w = dev->state;
    uint64_t now_ps = hil_now_ps(dev->core);
    settle(dev, now_ps);
    w->lasting_status[1] &= (uint8_t)~STATUS_2_SRL; /* locked until the next power-up (7.1.5) */
    reset_chip(dev, now_ps);
    w->selected = false;
    hil_w25q_power_back(dev);
}

void hil_w25q_power_back(struct hil_w25q_device *dev)
{
    dev->state->past.before = dev->state->past.rests = 0;
    dev->state->past.power_ps = hil_now_ps(dev->core) + 1u; /* 0: not known */
}

static void on_cut(void *device, uint64_t at)
{
    struct hil_w25q_device *dev = device;
    struct hil_w25q *w = dev->state;
    (void)at;
    w->cut_at = 0;
    end_operation(dev, w->cut_permille);
    hil_call(&dev->cut);
}

void hil_w25q_create(struct hil_w25q_device *dev)
{
    struct hil_w25q *w = dev->state;
    *w = (struct hil_w25q){.past.power_ps = 1,
                           .random = dev->options->seed ^ 0x25c128000025c128ull};
    hil_event_wire(dev->core, HIL_EVENT_NOR, on_end, dev);
    hil_event_wire(dev->core, HIL_EVENT_NOR_CUT, on_cut, dev);
    set_status(w, factory_status, true);
}

void hil_w25q_set_faults(struct hil_w25q_device *dev, const struct hil_w25q_faults *faults)
{
    dev->state->faults = *faults;
}

void hil_w25q_cut_at(struct hil_w25q_device *dev, uint64_t n, unsigned permille)
{
    struct hil_w25q *w = dev->state;
    w->cut_at = n ? w->operations + n : 0;
    w->cut_permille = permille < 1000 ? permille : 999;
}

enum mr_status hil_w25q_peek(const struct hil_w25q_device *dev, uint32_t address, void *out,
                             size_t n)
{
    uint8_t *to = out;
    if (address >= HIL_NOR_SIZE || n > HIL_NOR_SIZE - address)
        return MR_UNKNOWN;
    for (size_t i = 0; i < n; i++)
        to[i] = get_cell(dev, address + (uint32_t)i);
    return MR_OK;
}

enum mr_status hil_w25q_poke(struct hil_w25q_device *dev, uint32_t address, const void *bytes,
                             size_t n)
{
    const uint8_t *from = bytes;
    if (address >= HIL_NOR_SIZE || n > HIL_NOR_SIZE - address)
        return MR_UNKNOWN;
    for (size_t i = 0; i < n; i++) {
        if (from[i] != get_cell(dev, address + (uint32_t)i))
            put_cell(dev, address + (uint32_t)i, from[i]);
    }
    return MR_OK;
}

/* ---- w25q_rules ---- */

static bool is_array_read(uint8_t command)
{
    return command == READ || command == FAST_READ;
}

/* What a command wants to be left alone for. */
static enum hil_rule rest_after(uint8_t command)
{
    return command == RELEASE    ? HIL_RULE_RELEASE
         : command == POWER_DOWN ? HIL_RULE_POWER_DOWN
         : command == RESET      ? HIL_RULE_RESTART
                                 : HIL_RULES;
}

void hil_w25q_hold_rules(struct hil_rules_device *rules, const struct hil_w25q_past *past,
                         uint8_t command, double clock_period_ns)
{
    const struct hil_rules_edges *select = hil_rules_edges(rules, HIL_RULES_MEMORY_SELECT);
    const struct hil_moment power = {.ps = past->power_ps};
    bool reads = is_array_read(past->before) && is_array_read(command);
    enum hil_rule rest = rest_after(past->rests);
    if (!past->before)
        hil_rules_judge(rules, HIL_RULE_POWER_TO_SELECT, power, select->fell);
    else
        hil_rules_judge(rules, reads ? HIL_RULE_SELECT_HIGH_READS : HIL_RULE_SELECT_HIGH,
                        select->rose, select->fell);
    if (rest != HIL_RULES)
        hil_rules_judge(rules, rest, select->rose, select->fell);
    if (command == WRITE_ENABLE || command == VOLATILE_ENABLE)
        hil_rules_judge(rules, HIL_RULE_POWER_TO_WRITE, power, select->fell);
    hil_rules_measure(rules, command == READ ? HIL_RULE_CLOCK_PERIOD_READ : HIL_RULE_CLOCK_PERIOD,
                      clock_period_ns, 0.0, select->fell.pc);
}
