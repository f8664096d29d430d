#include "tests/firmware/fake_nor.h"

#include <stdlib.h>
#include <string.h>

struct fake_nor fake_nor;

void fake_nor_reset(void)
{
    memset(&fake_nor, 0, sizeof fake_nor);
    memset(fake_nor.cell, 0xff, sizeof fake_nor.cell);
    fake_nor.present = true;
    fake_nor.program_us = 700;
    fake_nor.erase_us = 45000;
    fake_nor.random = 1;
}

void fake_nor_power(void)
{
    fake_nor.dark = false;
    fake_nor.operation = 0;
    fake_nor.cut_at = 0;
}

static uint32_t draw(void)
{
    fake_nor.random = fake_nor.random * 1664525u + 1013904223u;
    return fake_nor.random >> 8;
}

/* Each bit that was to change has changed with this probability. */
static void change(uint8_t *cell, const uint8_t *wanted, size_t n, unsigned permille)
{
    for (size_t i = 0; i < n; i++) {
        uint8_t to = wanted ? (uint8_t)(cell[i] & wanted[i]) : 0xff;
        for (unsigned bit = 0; bit < 8; bit++) {
            if (((cell[i] ^ to) >> bit & 1u) && (permille >= 1000 || draw() % 1000u < permille))
                cell[i] ^= (uint8_t)(1u << bit);
        }
    }
}

static bool suffers(unsigned fault, uint32_t n)
{
    return fake_nor.faults & fault && fake_nor.address < fake_nor.to &&
           fake_nor.address + n > fake_nor.from;
}

static void end(unsigned permille)
{
    uint8_t *cell = fake_nor.cell + fake_nor.address;
    if (fake_nor.operation == 1 && !suffers(FAKE_NOR_PROGRAM_SILENT, NOR_PAGE_BYTES))
        change(cell, fake_nor.page, NOR_PAGE_BYTES,
               suffers(FAKE_NOR_PROGRAM_ERROR, NOR_PAGE_BYTES) ? permille / 2 : permille);
    if (fake_nor.operation == 2 && !suffers(FAKE_NOR_ERASE_SILENT, NOR_SECTOR_BYTES))
        change(cell, NULL, NOR_SECTOR_BYTES,
               suffers(FAKE_NOR_ERASE_ERROR, NOR_SECTOR_BYTES) ? permille / 2 : permille);
    fake_nor.operation = 0;
}

enum nor_status nor_identify(void)
{
    return !fake_nor.present ? NOR_MISSING : fake_nor.stuck ? NOR_STUCK : NOR_IDLE;
}

enum nor_status nor_poll(void)
{
    if (!fake_nor.present)
        return NOR_MISSING;
    if (fake_nor.stuck)
        return NOR_STUCK;
    if (fake_nor.dark)
        return NOR_BUSY;
    if (fake_nor.operation && fake_nor.now_us < fake_nor.end_us)
        return NOR_BUSY;
    if (fake_nor.operation)
        end(1000);
    return NOR_IDLE;
}

static void begin(unsigned operation, uint32_t address, const uint8_t *page, uint64_t us)
{
    if (fake_nor.operation || fake_nor.dark || fake_nor.stuck)
        abort(); /* one at a time */
    fake_nor.operation = operation;
    fake_nor.address = address;
    fake_nor.page = page;
    fake_nor.end_us = fake_nor.now_us + us;
    if (++fake_nor.operations == fake_nor.cut_at) {
        end(fake_nor.cut_permille);
        fake_nor.dark = true;
    }
}

void nor_begin_read(uint32_t address, uint8_t *bytes, size_t length)
{
    if (fake_nor.operation || fake_nor.stuck || length > NOR_PAGE_BYTES ||
        address + length > FAKE_NOR_SIZE)
        abort();
    memcpy(bytes, fake_nor.cell + address, length);
    fake_nor.address = address;
    if (suffers(FAKE_NOR_READ_ERROR, (uint32_t)length))
        bytes[draw() % length] ^= (uint8_t)(1u << draw() % 8u);
}

void nor_begin_program(uint32_t address, const uint8_t page[NOR_PAGE_BYTES])
{
    fake_nor.address = address;
    for (unsigned i = 0; i < NOR_PAGE_BYTES; i++) {
        if (page[i] & ~fake_nor.cell[address + i] && page[i] != 0xff) {
            fake_nor.overwritten++;
            break;
        }
    }
    begin(1, address, page,
          suffers(FAKE_NOR_PROGRAM_ERROR, NOR_PAGE_BYTES) ? 30000u : fake_nor.program_us);
}

void nor_begin_erase(uint32_t address)
{
    fake_nor.address = address;
    fake_nor.erases++;
    begin(2, address, NULL,
          suffers(FAKE_NOR_ERASE_ERROR, NOR_SECTOR_BYTES) ? 4000000u : fake_nor.erase_us);
}
