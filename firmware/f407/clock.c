/* System clock: 168 MHz, from the 8 MHz crystal or an external 8 MHz clock, or from the internal
 * oscillator if the crystal does not start or has stopped repeatedly. If the PLL does not lock, the
 * board stays silent with its lamp on until the watchdog resets it and it tries again. RM0090 7.2;
 * 3.5.1 for wait states; 5.1.3 for the regulator scale. */
#include "firmware/f407/drivers.h"
#include "firmware/health.h"

/* Limits for polling a flag, about 8 cycles each at 16 MHz: 100 ms for the crystal (typically 2
 * ms), 20 ms for the PLL (0.3 ms). */
#define CRYSTAL_POLLS 200000u
#define PLL_POLLS     40000u

/* Range of the internal oscillator, for measuring the crystal: its error is at most -8 to 4.5 %
 * (STM32F407 data sheet, ACC_HSI). The nearest other crystals that boards have are 7.3728 and 10
 * MHz. */
#define INTERNAL_KHZ    16000u
#define CRYSTAL_KHZ_MIN 7500u
#define CRYSTAL_KHZ_MAX 8800u
#define RTC_DIVIDER     31u
#define CAPTURE_COUNT   16u
#define CAPTURE_POLLS   1000u /* 0.5 ms; with a 4 MHz crystal, captures are 62 us apart */

#define DETAIL_STOPPED 255u /* detail of the fault */

static uint32_t crystal_khz; /* measured at start; 0 without a crystal */

static bool wait_for_bits(reg32 *reg, uint32_t mask, uint32_t value, uint32_t polls)
{
    while (polls-- > 0) {
        if ((*reg & mask) == value)
            return true;
    }
    return false;
}

/* Dividers: 8 MHz / 4 or 16 MHz / 8 = 2 MHz, * 168 = 336 MHz, / 2 = 168 MHz; / 7 = 48 MHz for the
 * unused USB. */
static bool start_pll(bool from_crystal)
{
    uint32_t input_divider = from_crystal ? 4u : 8u;
    RCC->CR &= ~RCC_CR_PLLON;
    RCC->PLLCFGR = RCC_PLLCFGR_RESERVED | input_divider | 168u << 6 | 0u << 16 | 7u << 24 |
                   (from_crystal ? RCC_PLLCFGR_SRC_HSE : 0u);
    RCC->CR |= RCC_CR_PLLON;
    if (!wait_for_bits(&RCC->CR, RCC_CR_PLLRDY, RCC_CR_PLLRDY, PLL_POLLS))
        return false;
    FLASH_ACR = FLASH_ACR_168MHZ;
    /* set the wait states before the clock becomes faster (RM0090 3.5.1) */
    if (!wait_for_bits(&FLASH_ACR, FLASH_ACR_LATENCY, FLASH_ACR_168MHZ & FLASH_ACR_LATENCY,
                       PLL_POLLS))
        return false;
    /* Change the prescalers first: a change takes up to 16 cycles, and must be complete before the
     * clock changes (RM0090 7.3.3). */
    const uint32_t prescalers = RCC_CFGR_PPRE1_DIV4 | RCC_CFGR_PPRE2_DIV2;
    RCC->CFGR = prescalers;
    if (!wait_for_bits(&RCC->CFGR, prescalers, prescalers, PLL_POLLS))
        return false;
    RCC->CFGR = prescalers | RCC_CFGR_SW_PLL;
    return wait_for_bits(&RCC->CFGR, RCC_CFGR_SWS_MASK, RCC_CFGR_SWS_PLL, PLL_POLLS);
}

void clock_reset(void)
{
    RCC->CR |= RCC_CR_HSION;
    wait_for_bits(&RCC->CR, RCC_CR_HSIRDY, RCC_CR_HSIRDY, PLL_POLLS);
    RCC->CFGR &= ~RCC_CFGR_SW_MASK;
    wait_for_bits(&RCC->CFGR, RCC_CFGR_SWS_MASK, 0, PLL_POLLS);
    RCC->CFGR = 0;
    RCC->CR &= ~(RCC_CR_PLLON | RCC_CR_HSEON | RCC_CR_CSSON);
    wait_for_bits(&RCC->CR, RCC_CR_PLLRDY, 0, PLL_POLLS);
    RCC->AHB1RSTR = BOARD_AHB1_ALL;
    RCC->AHB1RSTR = 0;
    RCC->APB1RSTR = BOARD_APB1_ALL;
    RCC->APB1RSTR = 0;
    RCC->APB2RSTR = BOARD_APB2_ALL;
    RCC->APB2RSTR = 0;
    RCC->AHB1ENR = BOARD_AHB1_AT_RESET;
    RCC->APB1ENR = 0;
    RCC->APB2ENR = 0;
}

static bool wait_for_capture(uint16_t *count)
{
    if (!wait_for_bits(&TIM11->SR, TIM_SR_CC1IF, TIM_SR_CC1IF, CAPTURE_POLLS))
        return false;
    *count = (uint16_t)TIM11->CCR1;
    return true;
}

/* Measures the crystal with the internal oscillator, from which the chip still runs: TIM11 captures
 * every eighth edge of the crystal divided by 31. Returns 0 without edges. RM0090 7.2.11,
 * 19.4.11 */
static uint32_t measure_crystal_khz(void)
{
    uint16_t first = 0, last = 0;
    RCC->CFGR = RCC_CFGR_RTCPRE(RTC_DIVIDER);
    RCC->APB2ENR |= RCC_APB2ENR_TIM11;
    (void)RCC->APB2ENR;
    TIM11->OR = TIM11_OR_HSE_RTC;
    TIM11->CCMR1 = TIM_CCMR1_CC1_TI1 | TIM_CCMR1_IC1PSC_8;
    TIM11->CCER = TIM_CCER_CC1E;
    TIM11->CR1 = TIM_CR1_CEN;
    bool came = wait_for_capture(&first);
    for (unsigned n = 0; came && n < CAPTURE_COUNT; n++)
        came = wait_for_capture(&last);
    TIM11->CR1 = 0;
    RCC->APB2ENR &= ~RCC_APB2ENR_TIM11;
    RCC->CFGR = 0;
    uint32_t ticks = (uint16_t)(last - first);
    return came && ticks ? INTERNAL_KHZ * CAPTURE_COUNT * 8u * RTC_DIVIDER / ticks : 0;
}

/* Starts the crystal and checks that its frequency fits the PLL setting. With another crystal the
 * PLL would leave its range: 504 MHz from 12 MHz. */
static bool start_crystal(void)
{
    if (BOARD_CLOCK_BYPASS)
        RCC->CR |= RCC_CR_HSEBYP;
    RCC->CR |= RCC_CR_HSEON;
    bool swings = wait_for_bits(&RCC->CR, RCC_CR_HSERDY, RCC_CR_HSERDY, CRYSTAL_POLLS);
    uint32_t khz = crystal_khz = swings ? measure_crystal_khz() : 0;
    if (khz >= CRYSTAL_KHZ_MIN && khz <= CRYSTAL_KHZ_MAX) {
        /* If the crystal stops later, the chip switches to the internal oscillator and raises an
         * NMI (fault.c; RM0090 7.2.7). */
        RCC->CR |= RCC_CR_CSSON;
        return true;
    }
    RCC->CR &= ~RCC_CR_HSEON;
    health_count_fault(MR_FAULT_CLOCK_FALLBACK, (uint8_t)((khz + 500u) / 1000u));
    return false;
}

enum mr_clock_source clock_start(bool crystal_wanted)
{
    RCC->APB1ENR |= RCC_APB1ENR_PWR;
    /* read back, which waits long enough: a peripheral responds two cycles after its clock is on
     * (RM0090 7.2.13) */
    (void)RCC->APB1ENR;
    PWR_CR |= PWR_CR_VOS;

    if (!crystal_wanted)
        health_count_fault(MR_FAULT_CLOCK_FALLBACK, DETAIL_STOPPED);
    bool crystal = crystal_wanted && start_crystal();
    while (!start_pll(crystal)) {
    }
    return crystal ? MR_CLOCK_CRYSTAL : MR_CLOCK_INTERNAL_PLL;
}

uint32_t clock_crystal_khz(void)
{
    return crystal_khz;
}
