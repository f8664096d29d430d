/* The table of what is modelled (hil/core/registers.def) against what the peripherals do: every
 * word of every peripheral is read after reset, and every bit of every register is written. What
 * the table calls plain reads back, what it refuses or calls reserved ends the run, what is not in
 * it ends the run. */
#include "hil/board/board.h"
#include "hil/core/bus.h"
#include "hil/core/core.h"
#include "hil/periph/options.h"
#include "tests/cmocka_all.h"
#include "tests/hil/bench.h"

#define PERIPHERAL_BYTES 0x400u
#define SYSTEM_BYTES     0x1000u
#define SYSTEM_BASE      0xe000e000u
#define MCR              0x40006400u

/* State copies are far cheaper than boards: nothing runs in between. */
static struct hil_board *board;
static struct hil_core_state *core_before;
static struct hil_state *before;

static bool stops(void)
{
    bool stopped = board->core.is_stopped;
    board->core.is_stopped = false;
    return stopped;
}

static void restore(void)
{
    board->core.state = *core_before;
    board->state = *before;
    board->core.is_stopped = false;
    board->core.reset = (struct hil_reset){0};
}

static uint32_t read_word(uint32_t address)
{
    return hil_bus_read(&board->core, address, 4);
}
static void write_word(uint32_t address, uint32_t value)
{
    hil_bus_write(&board->core, address, 4, value);
}

/* All clocks on and whatever a register needs so that it can be written: CAN in initialisation,
 * watchdog unlocked. */
static void prepare_type(const char *name)
{
    struct hil_options options;
    hil_options_default(&options);
    options.type = hil_board_type_by_name(name);
    board = hil_board_create(&options);
    board->core.is_stopped = false; /* there is no firmware */
    board->state.mcu.rcc.ahb1enr = 0x7e7411ff;
    board->state.mcu.rcc.apb1enr = 0x36fec9ff;
    board->state.mcu.rcc.apb2enr = 0x00075f33;
    before = malloc(sizeof *before);
    core_before = malloc(sizeof *core_before);
    assert_non_null(before);
    assert_non_null(core_before);
    *before = board->state;
    *core_before = board->core.state;
}

static void prepare(void **state)
{
    (void)state;
    prepare_type("zg");
}

static void dismantle(void)
{
    hil_board_destroy(board);
    free(before);
    free(core_before);
}

/* Of both boards those whose serial link is another USART. */
static void prepare_for(const struct hil_register_set *set)
{
    bool other = strcmp(set->peripheral, "USART6") == 0;
    if (other == (board->options.type->usart == 6))
        return;
    dismantle();
    prepare_type(other ? "discovery" : "zg");
}

static bool differs_by_preparation(uint32_t address)
{
    return address == 0x40023830u || address == 0x40023840u || address == 0x40023844u;
}

static void make_writable(uint32_t address)
{
    if ((address & ~0x3ffu) == 0x40006400u) {
        write_word(MCR, 0x00010001);
        board->state.mcu.can.msr = 0xc01; /* as some bit times later */
    }
    if ((address & ~0x3ffu) == 0x40003000u)
        write_word(0x40003000u, 0x5555);
}

TEST(every_word_is_in_the_table_or_ends_the_run)
{
    size_t sets;
    const struct hil_register_set *set = hil_registers_all(&sets);
    unsigned modelled = 0, not_modelled = 0;
    prepare(NULL);
    for (size_t i = 0; i < sets; i++) {
        prepare_for(&set[i]);
        uint32_t bytes = set[i].base == SYSTEM_BASE ? SYSTEM_BYTES : PERIPHERAL_BYTES;
        for (uint32_t offset = 0; offset < bytes; offset += 4) {
            const struct hil_register *r = hil_register_at(&set[i], offset);
            uint32_t address = set[i].base + offset;
            uint32_t value = read_word(address);
            if (stops() != (r == NULL))
                fail_msg("%s + 0x%x: %s", set[i].peripheral, offset,
                         r ? "is in the table, but stops" : "answers");
            /* pins and flags that come up as they do */
            uint32_t known = r && !r->reset ? ~r->status : UINT32_MAX;
            if (r && r->access != 'w' && ((value ^ r->reset) & known) &&
                !differs_by_preparation(address))
                fail_msg("%s %s (+ 0x%x) is 0x%08x after reset, not 0x%08x", set[i].peripheral,
                         r->name, offset, (unsigned)value, (unsigned)r->reset);
            *(r ? &modelled : &not_modelled) += 1;
            restore();
            write_word(address, r ? r->reset : 0);
            if (!r && !stops())
                fail_msg("%s + 0x%x takes a write", set[i].peripheral, offset);
            restore();
        }
    }
    print_message("# %u registers modelled, %u words beside them refused\n", modelled,
                  not_modelled);
    assert_true(modelled > 400);
    dismantle();
}

/* A bit of MODER whose pin the package does not have. */
static bool is_of_no_pin(uint32_t address, uint32_t bit)
{
    uint32_t port = (address - 0x40020000u) / PERIPHERAL_BYTES;
    return port < HIL_BOARD_PORTS && address % PERIPHERAL_BYTES == 0 &&
           !hil_board_type_has_pin(board->options.type, port, (unsigned)__builtin_ctz(bit) / 2u);
}

/* One bit of one register. Returns what is wrong, or NULL. */
static const char *poke(uint32_t address, const struct hil_register *r, uint32_t bit)
{
    make_writable(address);
    write_word(address, (r->reset & ~r->conditional_bits) ^ bit);
    bool stopped = stops();
    if (is_of_no_pin(address, bit))
        return stopped ? NULL : "a use of a pin that is not there, but taken";
    if (r->access == 'r')
        return stopped ? NULL : "read-only, but takes a write";
    if (r->unmodelled_bits & bit)
        return stopped ? NULL : "refused by the table, but taken";
    if (r->conditional_bits & bit)
        return NULL;
    if ((r->plain_bits | r->action_bits | r->status) & bit ? stopped
                                                           : !r->allows_reserved && !stopped)
        return stopped ? "in the table, but ends the run" : "reserved, but taken";
    if (!(r->plain_bits & bit))
        return NULL;
    return ((read_word(address) ^ r->reset) & r->plain_bits) == bit
             ? NULL
             : "called plain, but does not read back";
}

TEST(every_bit_does_as_the_table_says)
{
    size_t sets;
    const struct hil_register_set *set = hil_registers_all(&sets);
    unsigned pokes = 0, wrong = 0;
    prepare(NULL);
    for (size_t i = 0; i < sets; i++) {
        prepare_for(&set[i]);
        for (size_t k = 0; set[i].registers[k].name; k++) {
            const struct hil_register *r = &set[i].registers[k];
            for (unsigned n = 0; n < r->count; n++) {
                for (unsigned bit = 0; bit < 32; bit++, pokes++) {
                    uint32_t offset = r->offset + n * r->stride;
                    restore();
                    const char *why = poke(set[i].base + offset, r, 1u << bit);
                    if (why && wrong++ < 20)
                        print_error("%s %s (+ 0x%x) bit %u: %s (%s)\n", set[i].peripheral, r->name,
                                    offset, bit, why, hil_board_failure_reason(board));
                }
            }
        }
    }
    print_message("# %u bits poked\n", pokes);
    assert_int_equal(wrong, 0);
    dismantle();
}

/* A peripheral that the bus knows and the table does not would be refused by nobody but itself. */
TEST(every_peripheral_has_a_table)
{
    prepare(NULL);
    for (uint32_t base = 0x40000000u; base < 0x40080000u; base += PERIPHERAL_BYTES) {
        const struct hil_register_set *set = hil_registers_by_base(base);
        if (set)
            prepare_for(set);
        bool there = hil_peripheral_at(&board->core.bus, base) != NULL;
        if (there != (set != NULL))
            fail_msg("0x%08x: on the bus or in hil/core/registers.def, but not in both",
                     (unsigned)base);
    }
    dismantle();
}

TEST(masks_do_not_overlap)
{
    size_t sets;
    const struct hil_register_set *set = hil_registers_all(&sets);
    for (size_t i = 0; i < sets; i++) {
        for (size_t k = 0; set[i].registers[k].name; k++) {
            const struct hil_register *r = &set[i].registers[k];
            uint32_t masks[5] = {r->plain_bits, r->action_bits, r->status, r->conditional_bits,
                                 r->unmodelled_bits};
            for (unsigned a = 0; a < 5; a++) {
                for (unsigned b = 0; b < a; b++) {
                    if (masks[a] & masks[b])
                        fail_msg("%s %s: 0x%08x is in two masks", set[i].peripheral, r->name,
                                 (unsigned)(masks[a] & masks[b]));
                }
            }
            if ((r->conditional_bits | r->unmodelled_bits) && !*r->explanation)
                fail_msg("%s %s does not say what it refuses", set[i].peripheral, r->name);
        }
    }
}
