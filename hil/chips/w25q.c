#include "hil/chips/w25q.h"

#include <string.h>

#include "hil/core/core.h"
#include "hil/periph/flash.h"
#include "hil/periph/options.h"
#include "hil/periph/rules.h"

#define STATUS_BUSY                  1u
#define STATUS_WEL                   2u
#define MANUFACTURER_ID              0xefu
/* fraction of the changes that a hanging operation makes before a reset */
#define HUNG_OPERATION_DONE_PERMILLE 500u
/* The modelled commands (data sheet rev. F, 8.1.2). */
enum command {
    COMMAND_PAGE_PROGRAM = 0x02,
    COMMAND_READ = 0x03,
    COMMAND_READ_STATUS = 0x05,
    COMMAND_WRITE_ENABLE = 0x06,
    COMMAND_ERASE_4K = 0x20,
    COMMAND_ENABLE_RESET = 0x66,
    COMMAND_RESET = 0x99,
    COMMAND_JEDEC_ID = 0x9f,
    COMMAND_RELEASE = 0xab,
    COMMAND_POWER_DOWN = 0xb9,
};

static bool is_bit_set(const uint8_t *bits, uint32_t n)
{
    return (bits[n / 8u] >> n % 8u & 1u);
}

static void put_cell(struct hil_w25q_device *dev, uint32_t address, uint8_t value)
{
    uint32_t sector = address / HIL_NOR_SECTOR_BYTES;
    /* cells are stored inverted, so that the pages of an erased chip use no memory */
    dev->inverted_cells[address] = (uint8_t)~value;
    dev->state->used_sectors[sector / 8u] |= (uint8_t)(1u << sector % 8u);
}

static uint8_t get_cell(const struct hil_w25q_device *dev, uint32_t address)
{
    return (uint8_t)~dev->inverted_cells[address];
}

/* Makes permille / 1000 of the changes of the operation in progress. */
static void change_cells_partly(struct hil_w25q_device *dev, unsigned permille)
{
    struct hil_w25q *w = dev->state;
    uint8_t plain[HIL_NOR_SECTOR_BYTES], wanted[HIL_NOR_PAGE_BYTES];
    bool program = w->operation_command == COMMAND_PAGE_PROGRAM;
    uint32_t step = program ? HIL_NOR_PAGE_BYTES : HIL_NOR_SECTOR_BYTES;
    for (uint32_t at = w->first_cell; at < w->first_cell + w->cell_count; at += step) {
        if (!program && !is_bit_set(w->used_sectors, at / HIL_NOR_SECTOR_BYTES))
            continue;
        for (uint32_t i = 0; i < step; i++)
            plain[i] = get_cell(dev, at + i);
        for (uint32_t i = 0; program && i < step; i++)
            wanted[i] = is_bit_set(w->page_mask, i) ? plain[i] & w->page_buffer[i] : plain[i];
        hil_cells_change_partly(plain, program ? wanted : NULL, step, permille, &w->random_state);
        for (uint32_t i = 0; i < step; i++)
            put_cell(dev, at + i, plain[i]);
        if (!program && permille >= 1000)
            w->used_sectors[at / HIL_NOR_SECTOR_BYTES / 8u] &=
                (uint8_t) ~(1u << at / HIL_NOR_SECTOR_BYTES % 8u);
    }
}

/* Ends the operation when permille / 1000 of its changes have been made. */
static void end_operation(struct hil_w25q_device *dev, unsigned permille)
{
    struct hil_w25q *w = dev->state;
    if (!w->is_operation_failing)
        change_cells_partly(dev, permille);
    w->operation_command = 0;
    w->status &= (uint8_t) ~(STATUS_BUSY | STATUS_WEL);
    hil_event_set_ps(dev->core, HIL_EVENT_NOR, HIL_NEVER);
}

static void end_operation_if_due(struct hil_w25q_device *dev, uint64_t t_ps)
{
    struct hil_w25q *w = dev->state;
    if (w->operation_command && t_ps >= w->operation_end_ps)
        end_operation(dev, 1000);
}

static void on_operation_end(void *device, uint64_t at)
{
    struct hil_w25q_device *dev = device;
    end_operation_if_due(dev, hil_clock_ps_at_cycle(&dev->core->state.clock, at));
}

/* True if the fault script requests that this program or erase operation fails; counts down the
 * request. */
static bool consume_failure_request(struct hil_w25q_device *dev, bool program)
{
    struct hil_nor_fault_requests *orders = dev->fault_requests;
    uint32_t *left = program ? &orders->failing_program_count : &orders->failing_erase_count;
    if (*left == 0)
        return false;
    --*left;
    return true;
}

static void start_operation(struct hil_w25q_device *dev, uint64_t t_ps, uint32_t first,
                            uint32_t bytes, uint32_t typical_us, uint32_t maximum_us)
{
    struct hil_w25q *w = dev->state;
    bool program = w->command == COMMAND_PAGE_PROGRAM;
    if (!(w->status & STATUS_WEL)) {
        hil_trace(dev->core, "NOR: command 0x%02x at 0x%06x ignored: not write-enabled", w->command,
                  (unsigned)first);
        return;
    }
    w->operation_command = w->command;
    w->operation_count++;
    w->first_cell = first;
    w->cell_count = bytes;
    w->operation_begin_ps = t_ps;
    w->operation_end_ps = t_ps + hil_cell_operation_ps(dev->options->cell_times, typical_us,
                                                       maximum_us, &w->random_state);
    w->is_operation_failing = consume_failure_request(dev, program);
    if (dev->fault_requests->hanging_operation_count) {
        dev->fault_requests->hanging_operation_count--;
        w->operation_end_ps = HIL_NEVER;
    }
    w->status |= STATUS_BUSY;
    hil_event_set_ps(dev->core, HIL_EVENT_NOR, w->operation_end_ps);
    hil_callback_invoke(&dev->on_operation_begin);
}

static void reset_chip(struct hil_w25q_device *dev, uint64_t t_ps)
{
    struct hil_w25q *w = dev->state;
    /* a reset interrupts the operation (data sheet 8.2.36: "data corruption may happen") */
    if (w->operation_command)
        end_operation(dev, w->operation_end_ps == HIL_NEVER
                               ? HUNG_OPERATION_DONE_PERMILLE
                               : (unsigned)((t_ps - w->operation_begin_ps) * 1000u /
                                            (w->operation_end_ps - w->operation_begin_ps)));
    w->status = 0;
    w->is_powered_down = w->is_reset_enabled = false;
}

/* Called when chip select rises: executes the command that was shifted in. */
static void execute_command(struct hil_w25q_device *dev, uint64_t t_ps)
{
    struct hil_w25q *w = dev->state;
    bool reset_enabled = w->is_reset_enabled;
    w->is_reset_enabled = false;
    w->times.pause_command = w->command == COMMAND_RESET && !reset_enabled ? 0 : w->command;
    switch (w->command) {
    case COMMAND_WRITE_ENABLE: w->status |= STATUS_WEL; break;
    case COMMAND_PAGE_PROGRAM:
        if (w->page_byte_count)
            start_operation(dev, t_ps, w->address & ~(HIL_NOR_PAGE_BYTES - 1u), HIL_NOR_PAGE_BYTES,
                            700, 3000);
        break;
    /* an erase is executed only if exactly three address bytes were received */
    case COMMAND_ERASE_4K:
        if (w->byte_count == 4)
            start_operation(dev, t_ps, w->address & ~(HIL_NOR_SECTOR_BYTES - 1u),
                            HIL_NOR_SECTOR_BYTES, 45000, 400000);
        break;
    case COMMAND_POWER_DOWN: w->is_powered_down = true; break;
    case COMMAND_RELEASE: w->is_powered_down = false; break;
    case COMMAND_ENABLE_RESET: w->is_reset_enabled = true; break;
    case COMMAND_RESET:
        if (reset_enabled)
            reset_chip(dev, t_ps);
        break;
    default: break;
    }
}

/* True if the chip accepts the command in its present state. */
static bool is_command_accepted(const struct hil_w25q *w)
{
    if (w->is_dead)
        return false;
    if (w->is_always_busy)
        return w->command == COMMAND_READ_STATUS;
    if (w->operation_command)
        return w->command == COMMAND_READ_STATUS || w->command == COMMAND_ENABLE_RESET ||
               w->command == COMMAND_RESET;
    return !w->is_powered_down || w->command == COMMAND_RELEASE;
}

/* Handles byte n of a command with a three-byte address; n is 1 for the first byte after the
 * command. */
static uint8_t handle_addressed_byte(struct hil_w25q_device *dev, uint32_t n, uint8_t in)
{
    struct hil_w25q *w = dev->state;
    if (n <= 3) {
        w->address = (w->address << 8 | in) & 0xffffffu;
        return 0xff;
    }
    if (w->command == COMMAND_READ) {
        uint32_t address = w->address;
        w->address = (address + 1u) % HIL_NOR_SIZE;
        return get_cell(dev, address);
    }
    if (w->command == COMMAND_PAGE_PROGRAM) {
        /* the address wraps within the page; a later byte for the same address replaces the earlier
         * one */
        uint32_t at = (w->address + w->page_byte_count++) % HIL_NOR_PAGE_BYTES;
        w->page_buffer[at] = in;
        w->page_mask[at / 8u] |= (uint8_t)(1u << at % 8u);
    }
    return 0xff;
}

static uint8_t handle_byte(struct hil_w25q_device *dev, uint32_t n, uint8_t in)
{
    struct hil_w25q *w = dev->state;
    static const uint8_t jedec[3] = {MANUFACTURER_ID, 0x40, 0x18};
    switch (w->command) {
    case COMMAND_READ_STATUS: return w->is_always_busy ? w->status | STATUS_BUSY : w->status;
    case COMMAND_JEDEC_ID: return jedec[(n - 1u) % 3u];
    case COMMAND_READ:
    case COMMAND_PAGE_PROGRAM:
    case COMMAND_ERASE_4K: return handle_addressed_byte(dev, n, in);
    default: return 0xff;
    }
}

/* True if the chip drives its output in byte n of a command; n is 1 for the first byte after the
 * command. */
static bool is_output_byte(uint8_t command, uint32_t n)
{
    return command == COMMAND_READ_STATUS || command == COMMAND_JEDEC_ID ||
           (command == COMMAND_READ && n > 3);
}

static bool is_driving_output(const void *device)
{
    const struct hil_w25q_device *dev = device;
    return dev->state->has_driven_output;
}

static bool is_command_known(uint8_t command)
{
    static const uint8_t known[] = {COMMAND_PAGE_PROGRAM,
                                    COMMAND_READ,
                                    COMMAND_READ_STATUS,
                                    COMMAND_WRITE_ENABLE,
                                    COMMAND_ERASE_4K,
                                    COMMAND_RELEASE,
                                    COMMAND_POWER_DOWN,
                                    COMMAND_ENABLE_RESET,
                                    COMMAND_RESET,
                                    COMMAND_JEDEC_ID,
                                    0xff};
    return memchr(known, command, sizeof known) != NULL;
}

/* Applies the requests of the fault script to the chip (hil/rig/faults.h). */
static void apply_fault_requests(struct hil_w25q_device *dev)
{
    struct hil_w25q *w = dev->state;
    struct hil_nor_fault_requests *orders = dev->fault_requests;
    w->is_dead = orders->is_dead;
    w->is_always_busy = orders->is_always_busy;
    if (orders->is_fill_requested) {
        /* cells are stored inverted: all of them read as 0 */
        memset(dev->inverted_cells, 0xff, HIL_NOR_SIZE);
        memset(w->used_sectors, 0xff, sizeof w->used_sectors);
        orders->is_fill_requested = false;
    }
}

static void begin_command(void *device, uint64_t at)
{
    struct hil_w25q_device *dev = device;
    struct hil_w25q *w = dev->state;
    (void)at;
    w->is_selected = true;
    w->byte_count = 0;
    apply_fault_requests(dev);
}

/* Returns the rule for the pause that must follow a command; HIL_RULE_COUNT: no rule. */
static enum hil_rule get_pause_rule(uint8_t command)
{
    return command == COMMAND_RELEASE    ? HIL_RULE_RELEASE
         : command == COMMAND_POWER_DOWN ? HIL_RULE_POWER_DOWN
         : command == COMMAND_RESET      ? HIL_RULE_RESTART
                                         : HIL_RULE_COUNT;
}

/* Checks the rules of the W25Q128JV (hil/periph/rules.def) when the first byte of a command is
 * known, because the rules for the select line depend on the command. */
static void check_command_rules(struct hil_rules_device *rules, const struct hil_w25q_times *past,
                                uint8_t command, double clock_period_ns)
{
    const struct hil_rules_edges *select = hil_rules_get_edges(rules, HIL_RULES_MEMORY_SELECT);
    const struct hil_timestamp power = {.ps = past->power_on_ps};
    bool reads = past->previous_command == COMMAND_READ && command == COMMAND_READ;
    enum hil_rule rest = get_pause_rule(past->pause_command);
    if (!past->previous_command)
        hil_rules_check_interval(rules, HIL_RULE_POWER_TO_SELECT, power, select->last_fall);
    else
        hil_rules_check_interval(rules, reads ? HIL_RULE_SELECT_HIGH_READS : HIL_RULE_SELECT_HIGH,
                                 select->last_rise, select->last_fall);
    if (rest != HIL_RULE_COUNT)
        hil_rules_check_interval(rules, rest, select->last_rise, select->last_fall);
    if (command == COMMAND_WRITE_ENABLE)
        hil_rules_check_interval(rules, HIL_RULE_POWER_TO_WRITE, power, select->last_fall);
    hil_rules_check_time(
        rules, command == COMMAND_READ ? HIL_RULE_CLOCK_PERIOD_READ : HIL_RULE_CLOCK_PERIOD,
        clock_period_ns, 0.0, select->last_fall.pc);
}

static uint8_t exchange_byte(void *device, uint8_t in, uint64_t at)
{
    struct hil_w25q_device *dev = device;
    struct hil_w25q *w = dev->state;
    if (w->operation_command)
        end_operation_if_due(dev, hil_clock_ps_at_cycle(&dev->core->state.clock, at));
    uint32_t n = w->byte_count++;
    if (n == 0) {
        w->has_driven_output = false;
        check_command_rules(dev->rules, &w->times, in, hil_spi_clock_period_ns(dev->spi));
        w->command = w->times.previous_command = in;
        w->times.pause_command = 0;
        w->address = w->page_byte_count = 0;
        if (w->operation_command != COMMAND_PAGE_PROGRAM)
            memset(w->page_mask, 0, sizeof w->page_mask);
        if (!is_command_known(in))
            hil_core_stop(dev->core, MR_UNMODELLED, "unmodelled: command 0x%02x of the NOR", in);
        return 0xff;
    }
    w->has_driven_output = is_command_accepted(w) && is_output_byte(w->command, n);
    return is_command_accepted(w) ? handle_byte(dev, n, in) : 0xff;
}

static void end_command(void *device, uint64_t at, bool in_byte)
{
    struct hil_w25q_device *dev = device;
    struct hil_w25q *w = dev->state;
    uint64_t t_ps = hil_clock_ps_at_cycle(&dev->core->state.clock, at);
    end_operation_if_due(dev, t_ps);
    if (w->is_selected && w->byte_count && !in_byte && is_command_accepted(w))
        execute_command(dev, t_ps);
    w->is_selected = false;
}

struct hil_spi_slave hil_w25q_slave(struct hil_w25q_device *dev)
{
    return (struct hil_spi_slave){dev, begin_command, end_command, exchange_byte,
                                  is_driving_output};
}

void hil_w25q_power_off(struct hil_w25q_device *dev)
{
    struct hil_w25q *w = dev->state;
    uint64_t now_ps = hil_now_ps(dev->core);
    end_operation_if_due(dev, now_ps);
    reset_chip(dev, now_ps);
    w->is_selected = false;
    hil_w25q_power_on(dev);
}

void hil_w25q_power_on(struct hil_w25q_device *dev)
{
    dev->state->times.previous_command = dev->state->times.pause_command = 0;
    dev->state->times.power_on_ps = hil_now_ps(dev->core) +
                                    1u; /* stored plus 1, because 0 means unknown */
}

void hil_w25q_create(struct hil_w25q_device *dev)
{
    struct hil_w25q *w = dev->state;
    *w = (struct hil_w25q){.times.power_on_ps = 1,
                           .random_state = dev->options->noise_seed ^ 0x25c128000025c128ull};
    hil_event_connect(dev->core, HIL_EVENT_NOR, on_operation_end, dev);
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
