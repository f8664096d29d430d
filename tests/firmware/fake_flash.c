#include "tests/firmware/fake_flash.h"

#include <string.h>

struct fake_flash fake_flash = {
    .cell = {[0 ... FLASH_COPIES - 1] = {[0 ... FLASH_COPY_BYTES - 1] = 0xff}}, .random = 1};

void fake_flash_reset(void)
{
    memset(&fake_flash, 0, sizeof fake_flash);
    memset(fake_flash.cell, 0xff, sizeof fake_flash.cell);
    fake_flash.random = 1;
}

const uint8_t *flash_get_copy(unsigned copy)
{
    return fake_flash.cell[copy];
}

void flash_begin(void)
{
    fake_flash.open = true;
}

void flash_end(void)
{
    fake_flash.open = false;
}

/* Each bit that was to change has changed with this probability. */
static void change(uint8_t *cell, const uint8_t *wanted, size_t n, unsigned permille)
{
    for (size_t bit = 0; bit < 8 * n; bit++) {
        uint8_t to = wanted ? wanted[bit / 8] : 0xff;
        fake_flash.random = fake_flash.random * 1664525u + 1013904223u;
        if (((cell[bit / 8] ^ to) >> bit % 8 & 1u) && (fake_flash.random >> 8) % 1000u < permille)
            cell[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
}

static bool operate(uint8_t *cell, const uint8_t *wanted, size_t n)
{
    fake_flash.operations++;
    fake_flash.stray += !fake_flash.open;
    if (fake_flash.dark || fake_flash.broken)
        return false;
    fake_flash.dark = fake_flash.operations == fake_flash.cut_at;
    change(cell, wanted, n, fake_flash.dark ? fake_flash.cut_permille : 1000);
    return !fake_flash.dark;
}

bool flash_erase(unsigned copy)
{
    fake_flash.erases[copy]++;
    return operate(fake_flash.cell[copy], NULL, FLASH_COPY_BYTES);
}

bool flash_program(unsigned copy, uint32_t offset, uint32_t word)
{
    uint8_t *cell = fake_flash.cell[copy] + offset;
    uint8_t wanted[4];
    for (unsigned i = 0; i < 4; i++) {
        uint8_t byte = (uint8_t)(word >> 8 * i);
        fake_flash.stray += (byte & (uint8_t)~cell[i]) != 0 && !fake_flash.dark;
        wanted[i] = byte & cell[i];
    }
    return operate(cell, wanted, 4);
}
