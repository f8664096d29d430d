/* The black box's memory: who it is, and a sector erased, programmed and verified again and again.
 * Of a record or the runway nothing is touched: the sector is one of the black box's
 * that holds nothing, and holds nothing afterwards. A sector bears 100,000 erases (W25Q128JV rev. F
 * 9.6). */
#include <string.h>

#include "firmware/bringup/bringup.h"
#include "firmware/bringup/say.h"
#include "firmware/f407/drivers.h"
#include "firmware/nor.h"

#define LOOKS        9000u /* 9 s or more: nor.c gives up after 6 s of an erase */
#define TICKS_PER_US 84u
#define SEARCHED     256u /* sectors, from the last of the black box's down */
#define NO_SECTOR    UINT32_MAX
#define TOLD_ROUNDS  10u /* who reads wants to hear something: host/board/bringup.c, silence_s */

static uint8_t page[NOR_PAGE] DMA_BUFFER, back[NOR_PAGE] DMA_BUFFER;

struct outcome {
    uint32_t rounds, wrong, failed;
    uint32_t erase_us, erase_most_us, program_us, program_most_us; /* sums, and most */
};

/* Asleep between two looks: each block of the scan wakes, or each supervision tick. By TIM2, which
 * goes on meanwhile, as the core's cycle counter does not. */
static void doze(void)
{
    struct mr_block block;
    watchdog_feed();
    while (board_block_take(&block)) {
    }
    (void)board_sleep();
}

/* Until the operation is over; how long it took. */
static bool ends(uint32_t *us)
{
    uint32_t begun = TIM2->CNT;
    enum nor_status status = nor_poll();
    for (unsigned n = 0; status == NOR_BUSY && n < LOOKS; n++) {
        doze();
        status = nor_poll();
    }
    *us = (TIM2->CNT - begun) / TICKS_PER_US;
    return status == NOR_IDLE;
}

static bool read_page(uint32_t address)
{
    uint32_t us;
    nor_begin_read(address, back, NOR_PAGE);
    return ends(&us);
}

static bool is_blank(uint32_t sector)
{
    for (uint32_t n = 0; n < NOR_PAGES_PER_SECTOR; n++) {
        if (!read_page(sector * NOR_SECTOR + n * NOR_PAGE))
            return false;
        for (unsigned i = 0; i < NOR_PAGE; i++) {
            if (back[i] != 0xffu)
                return false;
        }
    }
    return true;
}

static uint32_t find_blank_sector(void)
{
    for (uint32_t sector = NOR_SECTORS - 1u; sector >= NOR_SECTORS - SEARCHED; sector--) {
        if (is_blank(sector))
            return sector;
    }
    return NO_SECTOR;
}

static bool erase(uint32_t sector, struct outcome *o)
{
    uint32_t us;
    nor_begin_erase(sector * NOR_SECTOR);
    bool done = ends(&us);
    o->erase_us += us;
    o->erase_most_us = us > o->erase_most_us ? us : o->erase_most_us;
    o->failed += !done;
    return done;
}

/* Every page another content, and every round. */
static void fill_page(uint32_t round, uint32_t number)
{
    uint32_t random = round * 2654435761u + number * 40503u + 1u;
    for (unsigned i = 0; i < NOR_PAGE; i++) {
        random = random * 1664525u + 1013904223u;
        page[i] = (uint8_t)(random >> 24);
    }
}

static void write_page(uint32_t address, struct outcome *o)
{
    uint32_t us;
    nor_begin_program(address, page);
    bool done = ends(&us);
    o->program_us += us;
    o->program_most_us = us > o->program_most_us ? us : o->program_most_us;
    o->failed += !done;
    if (!read_page(address) || memcmp(page, back, NOR_PAGE) != 0)
        o->wrong++;
}

static void test_sector(uint32_t sector, uint32_t rounds, struct outcome *o)
{
    for (uint32_t round = 0; round < rounds && o->failed == 0; round++) {
        if (!erase(sector, o))
            break;
        o->wrong += !is_blank(sector);
        for (uint32_t n = 0; n < NOR_PAGES_PER_SECTOR; n++) {
            fill_page(round, n);
            write_page(sector * NOR_SECTOR + n * NOR_PAGE, o);
        }
        o->rounds++;
        if (o->rounds % TOLD_ROUNDS == 0)
            say_number("memory_done", (int32_t)o->rounds, "rounds");
    }
    (void)erase(sector, o);
    o->wrong += !is_blank(sector);
}

static void say_outcome(uint32_t sector, uint32_t wanted, const struct outcome *o)
{
    say_number("memory_sector", (int32_t)sector, "sector");
    say_number("memory_rounds", (int32_t)o->rounds, "rounds");
    say_number("memory_rounds_missing", (int32_t)(wanted - o->rounds), "rounds");
    say_number("memory_wrong", (int32_t)o->wrong, "pages");
    say_number("memory_failed", (int32_t)o->failed, "operations");
    uint32_t pages = o->rounds * NOR_PAGES_PER_SECTOR;
    say_number("memory_erase", (int32_t)(o->erase_us / (o->rounds + 1u)), "us");
    say_number("memory_erase_most", (int32_t)o->erase_most_us, "us");
    say_number("memory_program", (int32_t)(pages ? o->program_us / pages : 0), "us");
    say_number("memory_program_most", (int32_t)o->program_most_us, "us");
}

/* It may still be busy with what it did before a reset. */
static bool memory_is_there(void)
{
    uint32_t us;
    return ends(&us) && nor_identify() == NOR_IDLE;
}

void bringup_memory(uint32_t rounds)
{
    struct outcome outcome = {0};
    uint32_t sector = NO_SECTOR;
    if (!memory_is_there()) {
        say_none("memory_id", "id");
        return;
    }
    say_hex("memory_id", nor_jedec(), "id");
    sector = find_blank_sector();
    if (sector == NO_SECTOR) {
        say_none("memory_sector", "sector");
        return;
    }
    test_sector(sector, rounds, &outcome);
    say_outcome(sector, rounds, &outcome);
}
