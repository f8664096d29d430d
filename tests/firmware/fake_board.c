#include "tests/firmware/fake_board.h"

#include <string.h>

struct fake_board fake;

void fake_reset(void)
{
    memset(&fake, 0, sizeof fake);
    fake.jumper = true; /* what a test forbids it says */
}

void board_start(void)
{
}

uint32_t board_input_mask(void)
{
    return ~fake.without;
}

bool board_is_jumper_fitted(void)
{
    return fake.jumper;
}

bool board_is_rom_reachable(void)
{
    return !fake.rom_deaf;
}

uint32_t board_supply_mv(void)
{
    return fake.supply_mv ? fake.supply_mv : 3300u;
}

void board_identify(struct board_identity *identity)
{
    *identity = (struct board_identity){.uid = {1, 2, 3},
                                        .image_crc = 0xabcd,
                                        .clock_source = fake.clock_source,
                                        .image_state = fake.image_state,
                                        .image = {.commit = 0x11223344,
                                                  .commit_more = 0x5566,
                                                  .is_modified = true,
                                                  .program_crc = 0xabcd,
                                                  .header_crc = 0xef01}};
}

unsigned board_blocks_waiting(void)
{
    return fake.blocks_waiting;
}

bool board_block_get(struct mr_block *block)
{
    if (!fake.block_ready)
        return false;
    fake.block_ready = false;
    *block = fake.block;
    return true;
}

size_t board_edges_get(uint32_t until_tick, uint32_t *ticks, size_t capacity)
{
    size_t count = 0;
    while (fake.edges_taken < fake.edges && count < capacity &&
           (int32_t)(fake.edge_tick[fake.edges_taken] - until_tick) <= 0)
        ticks[count++] = fake.edge_tick[fake.edges_taken++];
    return count;
}

void board_pulses_enable(enum board_pulse_input input, bool on)
{
    fake.pulses[input].captured = on;
}

size_t board_pulses_get(enum board_pulse_input input, uint32_t until_tick, uint32_t *ticks,
                        size_t capacity)
{
    struct fake_pulses *pulses = &fake.pulses[input];
    size_t count = 0;
    while (pulses->captured && pulses->taken < pulses->count && count < capacity &&
           (int32_t)(pulses->tick[pulses->taken] - until_tick) <= 0)
        ticks[count++] = pulses->tick[pulses->taken++];
    return count;
}

uint32_t board_set_camera_trigger(bool high)
{
    fake.camera_pulses += high && !fake.camera;
    fake.camera = high;
    return fake.camera_tick;
}

void board_can_set_base(uint16_t base)
{
    fake.moves++;
    fake.can_base = base;
}

bool board_can_send(const struct board_can_frame *frame)
{
    if (fake.can_full || fake.sent_count == FAKE_FRAMES)
        return false;
    fake.sent_base[fake.sent_count] = fake.can_base;
    fake.sent_block[fake.sent_count] = fake.block.index;
    fake.sent[fake.sent_count++] = *frame;
    return true;
}

unsigned board_can_waiting(void)
{
    return fake.can_waiting;
}

void board_can_clear(void)
{
    fake.clears++;
}

void board_can_leave_bus_off(bool begin)
{
    fake.rejoins += begin;
}

bool board_has_lamp_current(void)
{
    return fake.lamp_broken ? false : fake.warning;
}

void board_reset(void)
{
    fake.resets++;
}

void board_get_restart(struct board_restart *restart)
{
    *restart = fake.restart;
}

void board_record_late_task(uint8_t task, uint32_t pc)
{
    fake.late_task = task;
    fake.late_pc = pc;
}

void board_reset_restart_count(void)
{
    fake.good_notes++;
}

void board_check_memory(void)
{
    fake.upkeep_slices++;
    if (fake.upkeep_slices % 100 == 0) {
        fake.upkeep.ram_test_count++;
        fake.upkeep.flash_check_count++;
    }
}

void board_restart_memory_test(void)
{
}

void board_get_background_tests(struct board_background_tests *upkeep)
{
    *upkeep = fake.upkeep;
}

bool board_image_check(bool *good)
{
    *good = !fake.image_bad;
    return fake.image_known;
}

bool board_can_receive(struct board_can_frame *frame)
{
    if (fake.received_taken == fake.received_count)
        return false;
    *frame = fake.received[fake.received_taken++];
    return true;
}

bool board_can_sync_tick(uint32_t block, uint32_t *tick)
{
    *tick = fake.sync_tick;
    return fake.sync_left && fake.sync_block == block;
}

void board_can_get_errors(struct board_can_errors *errors)
{
    *errors = fake.can_errors;
}

bool board_serial_send(const uint8_t *bytes, size_t length)
{
    if (fake.serial_full || fake.serial_count + length > FAKE_SERIAL)
        return false;
    memcpy(fake.serial + fake.serial_count, bytes, length);
    fake.serial_count += length;
    return true;
}

size_t board_serial_receive(uint8_t *bytes, size_t capacity)
{
    size_t count = 0;
    while (count < capacity && fake.serial_in_taken < fake.serial_in_count)
        bytes[count++] = fake.serial_in[fake.serial_in_taken++];
    return count;
}

void board_set_warning(bool warning)
{
    fake.warning = warning;
}

void board_set_shunts(bool on)
{
    fake.shunted = on;
}

void board_watchdog_feed(void)
{
}

bool board_sleep(void)
{
    return false;
}

uint16_t board_load_permille(void)
{
    return 123;
}

void board_scans_configure(uint32_t fitted)
{
    fake.fitted = fitted;
    fake.configurations++;
}

void board_scans_restart(void)
{
    fake.restarts++;
}

void board_enter_rom(void)
{
    fake.rom_entries++;
}
