#include "tests/firmware/fake_board.h"

#include <string.h>

struct fake_board fake;

void fake_reset(void)
{
    memset(&fake, 0, sizeof fake);
}

void board_start(void)
{
}

void board_identify(struct board_identity *identity)
{
    *identity = (struct board_identity){.uid = {1, 2, 3}, .image_crc = 0xabcd, .clock_source = fake.clock_source,
                                         .image_state = fake.image_state,
                                         .image = {.commit = 0x11223344, .commit_more = 0x5566, .changed = true,
                                                   .program_crc = 0xabcd, .header_crc = 0xef01}};
}

bool image_ok(void)
{
    return fake.image_state == MR_IMAGE_GOOD;
}

bool board_block_take(struct mr_block *block)
{
    if (!fake.block_ready)
        return false;
    fake.block_ready = false;
    *block = fake.block;
    return true;
}

size_t board_edges_take(uint32_t until_tick, uint32_t *ticks, size_t capacity)
{
    size_t count = 0;
    while (fake.edges_taken < fake.edges && count < capacity &&
           (int32_t)(fake.edge_tick[fake.edges_taken] - until_tick) <= 0)
        ticks[count++] = fake.edge_tick[fake.edges_taken++];
    return count;
}

bool board_can_send(const struct board_can_frame *frame)
{
    if (fake.can_full || fake.sent_count == FAKE_FRAMES)
        return false;
    fake.sent_block[fake.sent_count] = fake.block.index;
    fake.sent[fake.sent_count++] = *frame;
    return true;
}

bool board_can_receive(struct board_can_frame *frame)
{
    if (fake.received_taken == fake.received_count)
        return false;
    *frame = fake.received[fake.received_taken++];
    return true;
}

void board_can_state(struct board_can_errors *errors)
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

void board_warn(bool warning)
{
    fake.warning = warning;
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

void board_scans_restart(void)
{
    fake.restarts++;
}

void board_enter_rom(void)
{
    fake.rom_entries++;
}
