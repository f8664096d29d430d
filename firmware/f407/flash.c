/* board.h's flash on the STM32F407: sectors 2 and 3, words of 32 bits (2.7 to 3.6 V). RM0090 3.6
 * and 3.9.
 *
 * The watchdog may time out after 0.34 s, but an erase may take 0.5 s, and the watchdog cannot be
 * served during an erase. Its time-out is therefore three times as long from flash_begin to
 * flash_end. Interrupts are off, because their handlers are in the flash, which is busy. */
#include "firmware/board.h"

#include "firmware/f407/drivers.h"

#define COPY_A_ADDRESS ((uint32_t)MR_CONFIGURATION)
/* sectors 0 to 3 have the size of one copy */
#define SECTOR_A       ((MR_CONFIGURATION - MR_FLASH) / FLASH_COPY_BYTES)
#define FLASH_KEY_1    0x45670123u
#define FLASH_KEY_2    0xcdef89abu
/* about 1 s if the loop runs from the cache; otherwise it stalls while the flash is busy */
#define POLLS_MAX      12000000u

static uint32_t irq_state, start_tick;

const uint8_t *flash_get_copy(unsigned copy)
{
    return (const uint8_t *)(COPY_A_ADDRESS + copy * FLASH_COPY_BYTES);
}

/* Resets the data cache, which may hold old content of changed sectors. It must be off for that
 * (RM0090 3.5.2). */
static void reset_data_cache(void)
{
    FLASH_ACR &= ~FLASH_ACR_DCEN;
    FLASH_ACR |= FLASH_ACR_DCRST;
    FLASH_ACR &= ~FLASH_ACR_DCRST;
    FLASH_ACR |= FLASH_ACR_DCEN;
}

void flash_begin(void)
{
    irq_state = irq_mask();
    start_tick = TIM2->CNT;
    watchdog_set_timeout(WATCHDOG_FLASH_COUNTS);
    if (FLASH_CR & FLASH_CR_LOCK) {
        FLASH_KEYR = FLASH_KEY_1;
        FLASH_KEYR = FLASH_KEY_2;
    }
    FLASH_SR = FLASH_SR_ERRORS;
}

void flash_end(void)
{
    FLASH_CR = FLASH_CR_LOCK;
    reset_data_cache();
    watchdog_set_timeout(WATCHDOG_DEFAULT_COUNTS);
    board_scans_restart();
    nor_extend_timeout(TIM2->CNT - start_tick);
    irq_restore(irq_state);
}

static bool is_flash_done(void)
{
    uint32_t polls = POLLS_MAX;
    while ((FLASH_SR & FLASH_SR_BSY) && --polls) {
    }
    uint32_t status = FLASH_SR;
    FLASH_SR = FLASH_SR_ERRORS;
    return !(status & (FLASH_SR_BSY | FLASH_SR_ERRORS));
}

bool flash_erase(unsigned copy)
{
    watchdog_feed();
    FLASH_CR = FLASH_CR_PSIZE_32 | FLASH_CR_SER | (SECTOR_A + copy) << 3;
    FLASH_CR |= FLASH_CR_STRT;
    bool done = is_flash_done();
    FLASH_CR = FLASH_CR_PSIZE_32;
    reset_data_cache();
    return done;
}

bool flash_program(unsigned copy, uint32_t offset, uint32_t word)
{
    watchdog_feed();
    FLASH_CR = FLASH_CR_PSIZE_32 | FLASH_CR_PG;
    *(volatile uint32_t *)(COPY_A_ADDRESS + copy * FLASH_COPY_BYTES + offset) = word;
    __asm volatile("dsb" ::: "memory");
    bool done = is_flash_done();
    FLASH_CR = FLASH_CR_PSIZE_32;
    return done;
}
