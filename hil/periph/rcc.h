/* Reset and clock control with power control (RM0090 7, 5.4); the flash interface is in
 * hil/periph/flash.h.
 *
 * Oscillators take their time: HSE 2 ms, PLL 200 us, LSI 40 us. Settings that hardware would not
 * survive (PLL out of range, bus too fast, too few flash wait states, voltage scale too low) halt
 * the run with a message. */
#ifndef MATRIG_HIL_RCC_H
#define MATRIG_HIL_RCC_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

enum hil_rcc_bus { HIL_RCC_AHB1, HIL_RCC_APB1, HIL_RCC_APB2, HIL_RCC_BUSES };

struct hil_rcc {
    HIL_WORDS(word, cr, pllcfgr, cfgr, cir, rstr[8], ahb1enr, ahb2enr, ahb3enr, at_3c, apb1enr,
              apb2enr, at_48[2], lpenr[6], at_68[3], csr);
    uint32_t flash_acr;
    uint32_t pwr_cr;
    uint64_t scale_ready_cycle; /* PWR_CSR.VOSRDY */
    bool crystal_failed;        /* it stopped; survives resets */
    bool watchdog_runs;         /* and keeps the LSI on */
    bool latency_unread;        /* FLASH_ACR was written and not read since */
};

/* What a bit of a reset register resets. */
struct hil_reset_line {
    void (*reset)(void *device, unsigned unit); /* NULL: nothing */
    void *device;
    unsigned unit;
};

/* Clocks that a store switched on; of the present run. */
struct hil_rcc_fresh {
    uint32_t pc;
    uint64_t block_cycle; /* of the block that it was in */
    unsigned cycles;      /* that have to pass */
};

struct hil_rcc_device {
    HIL_NEIGHBOURS;
    struct hil_rcc_fresh fresh;
    struct hil_rcc *state;
    struct hil_reset_line line[HIL_RCC_BUSES][32];
};

/* After a reset; `csr_flags` are the reset flags that RCC_CSR will show. */
void hil_rcc_reset(struct hil_rcc_device *dev, uint32_t csr_flags);
/* As after a jump from another program, without a reset: the PLL at 168 MHz from an 8 MHz crystal
 * is the system clock, ports and timers have theirs. A debugger leaves it so, and the boot ROM's
 * Go. */
void hil_rcc_leave_on(struct hil_rcc_device *dev);
/* The register that switches the clocks of a bus. */
const uint32_t *hil_rcc_clocks(const struct hil_rcc_device *dev, enum hil_rcc_bus bus);
bool hil_rcc_enabled(const struct hil_rcc_device *dev, enum hil_rcc_bus bus, unsigned bit);
/* HCLK cycles to one cycle of PCLK1, PCLK2, and of the timers on APB1 and APB2. */
uint32_t hil_rcc_divider(const struct hil_rcc_device *dev, enum hil_rcc_bus bus);
uint32_t hil_rcc_timer_divider(const struct hil_rcc_device *dev, enum hil_rcc_bus bus);
/* The crystal stops, or can oscillate again. With CSSON: NMI, HSI in its place, PLL off (7.2.7). */
void hil_rcc_crystal(struct hil_rcc_device *dev, bool on);

/* For the bus and the event queue; `device` is a struct hil_rcc_device. */
HIL_ON_BUS(rcc)
void hil_rcc_hse_event(void *device, uint64_t at);
void hil_rcc_pll_event(void *device, uint64_t at);
void hil_rcc_lsi_event(void *device, uint64_t at);

HIL_ON_BUS(pwr)
/* HCLK that flash wait states and voltage scale allow, Hz. */
uint32_t hil_power_limit_hz(const struct hil_rcc *rcc);

/* ---- iwdg ---- */

/* Independent watchdog (RM0090 21), clocked by the LSI, which is anywhere from 17 to 47 kHz. */

struct hil_iwdg {
    HIL_WORDS(word, kr, pr, rlr);
    bool unlocked, running;
    /* SR.PVU and SR.RVU: a value written to PR or RLR takes up to five LSI cycles to arrive */
    uint64_t until_ps[2];
};

struct hil_iwdg_device {
    HIL_NEIGHBOURS;
    struct hil_iwdg *state;
};

void hil_iwdg_reset(struct hil_iwdg_device *dev);
/* For the bus and the event queue; `device` is a struct hil_iwdg_device. */
HIL_ON_BUS(iwdg)
void hil_iwdg_event(void *device, uint64_t at);

#endif
