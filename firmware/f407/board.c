/* board.h on the STM32F407: start-up in order, identity, sleep, supervision tick. */
#include "firmware/f407/drivers.h"
#include "firmware/health.h"
#include "firmware/tasks.h"

#define SUPERVISION_HZ 100u

static struct board_identity identity;
static bool quiet;
static volatile bool tick_passed;
static uint32_t asleep_ticks, load_since_tick;

static uint8_t take_reset_cause(void)
{
    uint32_t csr = RCC->CSR;
    RCC->CSR |= RCC_CSR_RMVF;
    if (csr & RCC_CSR_IWDGRSTF)
        health_count(MR_FAULT_WATCHDOG_RESET, 0);
    return (uint8_t)((csr & RCC_CSR_PORRSTF ? 1u : 0u) | (csr & RCC_CSR_PINRSTF ? 2u : 0u) |
                     (csr & RCC_CSR_SFTRSTF ? 4u : 0u) | (csr & RCC_CSR_IWDGRSTF ? 8u : 0u) |
                     (csr & RCC_CSR_LPWRRSTF ? 16u : 0u) | (csr & RCC_CSR_BORRSTF ? 32u : 0u));
}

static void start_supervision(enum board_clock_source clock)
{
    uint32_t hz = clock == BOARD_CLOCK_RAW ? 16000000u : 168000000u;
    SYST_RVR = hz / SUPERVISION_HZ - 1;
    SYST_CVR = 0;
    SCB_SHPR[11] = PRIORITY_SUPERVISION << 4; /* SysTick is system handler 15; SHPR begins at 4 */
    SYST_CSR = 7u;                            /* on, interrupt, processor clock */
}

/* A stream register that keeps what is written says that the controller is there. */
static bool dma_answers(struct dma_regs *dma, uint8_t number)
{
    bool there = answers(&dma->stream[0].M0AR, 0x20000000u);
    if (!there)
        health_count(MR_FAULT_DMA_MISSING, number);
    return there;
}

void board_start(void)
{
    identity.reset_cause = take_reset_cause();
    quiet = fault_recall(identity.reset_cause);
    clock_reset();
    /* Before the crystal, which may take 100 ms: until then outputs float. */
    pins_start();
    enum board_clock_source clock = clock_start();
    memory_start();
    identity.clock_source = (uint8_t)clock;
    identity.board = BOARD_NUMBER;
    image_identify(&identity);

    fault_set_image_crc(identity.image_crc);
    memory_set_image_crc(identity.image_crc);

    for (unsigned i = 0; i < 3; i++) {
        if (!probe_word(&UID[i], &identity.uid[i]))
            health_count(MR_FAULT_IDENTITY_MISSING, 0);
    }

    bool dma1 = dma_answers(DMA1, 1);
    bool dma2 = dma_answers(DMA2, 2);
    uart_start(dma2, clock == BOARD_CLOCK_RAW);
    if (clock == BOARD_CLOCK_CRYSTAL)
        can_start();
    if (quiet)
        dma1 = false;
    /* No scans on the raw oscillator: neither their times nor the settling would be what the rest
     * relies on. */
    if (clock != BOARD_CLOCK_RAW && dma1 && dma2 && capture_start())
        scan_prepare();
    nor_start(dma1);
    start_supervision(clock);
    watchdog_start();
}

void board_identify(struct board_identity *out)
{
    *out = identity;
}

uint32_t board_inputs(void)
{
    return BOARD_INPUTS;
}

uint32_t board_supply_mv(void)
{
    return BOARD_SUPPLY_MV;
}

void board_warn(bool warning)
{
    warning |= quiet;
    pin_write(PIN_WARNING, !warning);
}

void board_shunt(bool on)
{
    pin_write(PIN_SHUNTS, on);
}

bool board_lamp_draws(void)
{
    return !pin_read(PIN_LAMP);
}

void board_watchdog_feed(void)
{
    watchdog_feed();
}

void systick(void);
void systick_irq(const uint32_t *frame);
__attribute__((naked)) void systick(void)
{
    __asm volatile("mrs r0, msp\n\tb.w systick_irq");
}

void systick_irq(const uint32_t *frame)
{
    tick_passed = true;
    tasks_tick(frame[6]); /* the processor was there */
}

bool board_sleep(void)
{
    /* WFI wakes for a pending interrupt even while masked, so nothing that comes after the check is
     * slept through. */
    uint32_t mask = irq_mask();
    if (!scan_ready() && !tick_passed) {
        uint32_t before = TIM2->CNT;
        __asm volatile("dsb\n\twfi" ::: "memory");
        asleep_ticks += TIM2->CNT - before;
    }
    irq_restore(mask);
    bool passed = tick_passed;
    if (passed) /* one that comes right now is for the next call */
        tick_passed = false;
    return passed;
}

uint16_t board_load_permille(void)
{
    uint32_t now = TIM2->CNT;
    uint32_t elapsed = now - load_since_tick;
    uint32_t asleep = asleep_ticks;
    asleep_ticks = 0;
    load_since_tick = now;
    if (elapsed < 1000 || asleep > elapsed)
        return 1000;
    return (uint16_t)(1000u - asleep / (elapsed / 1000u));
}
