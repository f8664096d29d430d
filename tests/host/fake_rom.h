/* A boot ROM in memory, written from AN3155's flow charts: bytes go in, bytes come out, time passes
 * only when nobody has anything to say. On the way each byte can be turned over in one bit,
 * dropped, or be the last before the line is gone. */
#ifndef MATRIG_TESTS_HOST_FAKE_ROM_H
#define MATRIG_TESTS_HOST_FAKE_ROM_H

#include <stdio.h>
#include <string.h>

#include "host/flash/bootrom.h"

#define CHIP_FLASH   0x20000u /* sectors 0 to 4 */
#define CHIP_SECTORS 12u
#define CHIP_ACK     0x79u
#define CHIP_NACK    0x1fu

enum chip_stage {
    CHIP_SYNC,
    CHIP_COMMAND,
    CHIP_COMPLEMENT,
    CHIP_ADDRESS,
    CHIP_LENGTH,
    CHIP_DATA,
    CHIP_COUNT,
    CHIP_LIST,
    CHIP_GONE
};
enum damage { DAMAGE_NONE, DAMAGE_FLIP, DAMAGE_DROP, DAMAGE_CUT };
enum way { TO_CHIP, TO_HOST };

struct chip {
    uint8_t flash[CHIP_FLASH];
    uint16_t id;
    bool read_protected, deaf, refuses_all;
    unsigned write_protected; /* bit n: sector n */
    uint32_t weak;            /* a byte whose lowest bit reads 0 once written; 0: none */

    enum chip_stage stage;
    uint8_t command, buffer[600];
    size_t have, need;
    uint32_t address;
    uint8_t sum;
    unsigned count, taken; /* of an erase list */
    bool bad;
    unsigned erases[CHIP_SECTORS], writes, nacks, harm;
    bool gone; /* GO */

    uint8_t out[600];
    size_t out_start, out_end;

    enum damage damage;
    enum way way;
    size_t at; /* the n-th byte that way, from 0 */
    unsigned bit;
    size_t passed[2];
    bool damaged, cut;
};

static void chip_init(struct chip *chip)
{
    memset(chip, 0, sizeof *chip);
    memset(chip->flash, 0xff, sizeof chip->flash);
    chip->id = 0x413;
}

static void chip_say(struct chip *chip, uint8_t byte)
{
    if (chip->out_end < sizeof chip->out)
        chip->out[chip->out_end++] = byte;
}

static void chip_answer(struct chip *chip, bool good)
{
    chip->nacks += !good;
    chip_say(chip, good ? CHIP_ACK : CHIP_NACK);
}

/* RM0090 table 5 */
static uint32_t chip_sector_start(unsigned sector)
{
    static const uint32_t starts[] = {0x00000, 0x04000, 0x08000, 0x0c000, 0x10000, 0x20000, 0x40000,
                                      0x60000, 0x80000, 0xa0000, 0xc0000, 0xe0000, 0x100000};
    return starts[sector];
}

static unsigned chip_sector_of(uint32_t at)
{
    unsigned sector = 0;
    while (at >= chip_sector_start(sector + 1))
        sector++;
    return sector;
}

static void chip_erase(struct chip *chip, unsigned sector)
{
    chip->erases[sector]++;
    if (chip->write_protected >> sector & 1u)
        return; /* the ROM does not tell */
    for (uint32_t at = chip_sector_start(sector);
         at < chip_sector_start(sector + 1) && at < CHIP_FLASH; at++)
        chip->flash[at] = 0xff;
}

static bool chip_in_flash(uint32_t address, size_t count)
{
    return address >= 0x08000000u && address + count <= 0x08000000u + CHIP_FLASH;
}

static void chip_expect(struct chip *chip, enum chip_stage stage, size_t need)
{
    chip->stage = stage;
    chip->need = need;
    chip->have = 0;
}

static void chip_command(struct chip *chip, uint8_t command)
{
    static const uint8_t get[] = {11,   0x31, 0x00, 0x01, 0x02, 0x11, 0x21,
                                  0x31, 0x44, 0x63, 0x73, 0x82, 0x92};
    chip_expect(chip, CHIP_COMMAND, 1);
    chip->command = command;
    bool always = command <= 0x02;
    if (chip->refuses_all || (chip->read_protected && !always)) {
        chip_answer(chip, false);
        return;
    }
    switch (command) {
    case 0x00:
        chip_answer(chip, true);
        for (size_t i = 0; i < sizeof get; i++)
            chip_say(chip, get[i]);
        chip_answer(chip, true);
        break;
    case 0x02:
        chip_answer(chip, true);
        chip_say(chip, 1);
        chip_say(chip, (uint8_t)(chip->id >> 8));
        chip_say(chip, (uint8_t)chip->id);
        chip_answer(chip, true);
        break;
    case 0x11:
    case 0x21:
    case 0x31:
        chip_answer(chip, true);
        chip_expect(chip, CHIP_ADDRESS, 5);
        break;
    case 0x44:
        chip_answer(chip, true);
        chip->sum = 0;
        chip_expect(chip, CHIP_COUNT, 2);
        break;
    case 0x63:
        /* all of these change the option bytes, and the last may erase everything: nobody here
         * wants them */
    case 0x73:
    case 0x82:
    case 0x92:
        chip_answer(chip, true);
        chip->harm++;
        break;
    default: chip_answer(chip, false); break;
    }
}

static void chip_address(struct chip *chip)
{
    const uint8_t *b = chip->buffer;
    chip->address = (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3];
    bool good = (uint8_t)(b[0] ^ b[1] ^ b[2] ^ b[3]) == b[4] && chip_in_flash(chip->address, 1);
    chip_answer(chip, good);
    if (!good)
        chip_expect(chip, CHIP_COMMAND, 1);
    else if (chip->command == 0x21)
        chip->gone = true, chip->stage = CHIP_GONE;
    else
        chip_expect(chip, CHIP_LENGTH, chip->command == 0x11 ? 2 : 1);
}

static void chip_length(struct chip *chip)
{
    uint8_t n = chip->buffer[0];
    if (chip->command == 0x31) {
        chip_expect(chip, CHIP_DATA, n + 2u);
        chip->sum = n;
        return;
    }
    bool good = (uint8_t)(n ^ chip->buffer[1]) == 0xff && chip_in_flash(chip->address, n + 1u);
    chip_expect(chip, CHIP_COMMAND, 1);
    chip_answer(chip, good);
    for (unsigned i = 0; good && i <= n; i++)
        chip_say(chip, chip->flash[chip->address - 0x08000000u + i]);
}

static void chip_data(struct chip *chip)
{
    size_t n = chip->need - 1;
    uint8_t sum = chip->sum;
    for (size_t i = 0; i < n; i++)
        sum ^= chip->buffer[i];
    bool good = sum == chip->buffer[n] && chip_in_flash(chip->address, n);
    chip_expect(chip, CHIP_COMMAND, 1);
    chip->writes += good;
    for (size_t i = 0; good && i < n; i++) {
        uint32_t at = chip->address - 0x08000000u + (uint32_t)i;
        if (!(chip->write_protected >> chip_sector_of(at) & 1u))
            chip->flash[at] &= at && at == chip->weak ? chip->buffer[i] & 0xfe : chip->buffer[i];
    }
    chip_answer(chip, good);
}

static void chip_list(struct chip *chip, uint8_t byte)
{
    size_t last = 2u * (chip->count + 1u);
    if (chip->taken < last) {
        if (chip->taken < sizeof chip->buffer)
            chip->buffer[chip->taken] = byte;
        chip->bad |= chip->taken % 2 ? byte >= CHIP_SECTORS : byte != 0;
        chip->sum ^= byte;
        chip->taken++;
        return;
    }
    bool good = chip->sum == byte && !chip->bad;
    chip->harm += good && chip->count == 0xffff;
    for (unsigned i = 0; good && i <= chip->count && i < CHIP_SECTORS && chip->count < CHIP_SECTORS;
         i++)
        chip_erase(chip, chip->buffer[2 * i + 1]);
    chip_expect(chip, CHIP_COMMAND, 1);
    chip_answer(chip, good);
}

static void chip_hear(struct chip *chip, uint8_t byte)
{
    if (chip->stage == CHIP_GONE || chip->deaf)
        return;
    if (chip->stage == CHIP_SYNC) {
        if (byte == 0x7f) {
            chip_expect(chip, CHIP_COMMAND, 1);
            chip_answer(chip, true);
        }
        return;
    }
    if (chip->stage == CHIP_LIST) {
        chip_list(chip, byte);
        return;
    }
    chip->buffer[chip->have++] = byte;
    if (chip->have < chip->need)
        return;
    switch (chip->stage) {
    case CHIP_COMMAND:
        chip->command = byte;
        chip_expect(chip, CHIP_COMPLEMENT, 1);
        break;
    case CHIP_COMPLEMENT:
        if ((uint8_t)(chip->command ^ byte) == 0xff) {
            chip_command(chip, chip->command);
        } else {
            chip_expect(chip, CHIP_COMMAND, 1);
            chip_answer(chip, false);
        }
        break;
    case CHIP_ADDRESS: chip_address(chip); break;
    case CHIP_LENGTH: chip_length(chip); break;
    case CHIP_DATA: chip_data(chip); break;
    case CHIP_COUNT:
        chip->count = (unsigned)chip->buffer[0] << 8 | chip->buffer[1];
        chip->sum = chip->buffer[0] ^ chip->buffer[1];
        chip->taken = 0;
        chip->bad = false;
        chip->stage = CHIP_LIST;
        if (chip->count >= 0xfff0u) { /* everything, or a bank: a checksum follows at once */
            chip->bad = chip->count != 0xffffu;
            chip->count = 0xffff;
            chip->taken = 2u * 0x10000u;
        }
        break;
    default: break;
    }
}

/* ---- the line ---- */

/* What becomes of a byte on its way. False: nothing arrives. */
static bool chip_pass(struct chip *chip, enum way way, uint8_t *byte)
{
    bool here = chip->damage != DAMAGE_NONE && way == chip->way && chip->passed[way] == chip->at;
    chip->passed[way]++;
    if (chip->cut)
        return false;
    chip->damaged |= here;
    if (here && chip->damage == DAMAGE_FLIP)
        *byte ^= (uint8_t)(1u << chip->bit);
    chip->cut |= here && chip->damage == DAMAGE_CUT;
    return !(here && chip->damage == DAMAGE_DROP);
}

static enum mr_status chip_line_send(void *context, const uint8_t *bytes, size_t count,
                                     struct error *error)
{
    struct chip *chip = context;
    for (size_t i = 0; i < count && !chip->cut; i++) {
        uint8_t byte = bytes[i];
        if (chip->stage == CHIP_GONE || chip->deaf)
            return MR_OK;
        if (chip_pass(chip, TO_CHIP, &byte))
            chip_hear(chip, byte);
    }
    return chip->cut ? error_set(error, MR_IO, "the device went away: fake; plug it in") : MR_OK;
}

static enum mr_status chip_line_receive(void *context, uint8_t *byte, unsigned timeout_ms,
                                        struct error *error)
{
    struct chip *chip = context;
    (void)timeout_ms;
    while (!chip->cut && chip->out_start < chip->out_end) {
        *byte = chip->out[chip->out_start++];
        if (chip->out_start == chip->out_end)
            chip->out_start = chip->out_end = 0;
        if (chip_pass(chip, TO_HOST, byte))
            return MR_OK;
    }
    return chip->cut ? error_set(error, MR_IO, "the device went away: fake; plug it in")
                     : MR_TIMEOUT;
}

/* The cable is in again: what was on the way is lost, the chip is where it was. */
static void chip_reconnect(struct chip *chip)
{
    chip->damage = DAMAGE_NONE;
    chip->cut = chip->damaged = false;
    chip->out_start = chip->out_end = 0;
    chip->passed[TO_CHIP] = chip->passed[TO_HOST] = 0;
}

#endif
