/* Independent watchdog: 500 counts of LSI / 32. LSI is 17 to 47 kHz, so 0.34 to 0.94 s. RM0090
 * 21.3. */
#include "firmware/f407/drivers.h"

#define KEY_UNLOCK   0x5555u
#define KEY_FEED     0xaaaau
#define KEY_START    0xccccu
#define UPDATE_POLLS 100000u /* a register takes up to five LSI periods to change */

void watchdog_start(void)
{
    DBGMCU_APB1_FZ |= DBGMCU_APB1_FZ_DBG_IWDG_STOP; /* or a breakpoint would end in a reset */
    IWDG->KR = KEY_START;
    IWDG->KR = KEY_UNLOCK;
    IWDG->PR = 3u; /* / 32 */
    watchdog_patience(WATCHDOG_USUAL);
}

void watchdog_patience(uint32_t counts)
{
    IWDG->KR = KEY_UNLOCK;
    IWDG->RLR = counts;
    for (unsigned polls = 0; IWDG->SR && polls < UPDATE_POLLS; polls++) {
    }
    IWDG->KR = KEY_FEED;
}

void watchdog_feed(void)
{
    IWDG->KR = KEY_FEED;
}
