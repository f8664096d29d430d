/* Reset and clock control with power control (RM0090 7, 5.4); the flash interface is in
 * hil/periph/flash.h.
 *
 * Start-up times of the oscillators are modelled: HSE 2 ms, PLL 200 us, LSI 40 us. Settings outside
 * the limits of hardware (PLL out of range, bus too fast, too few flash wait states, voltage scale
 * too low) halt the run with a message. */
#ifndef MATRIG_HIL_RCC_H
#define MATRIG_HIL_RCC_H

#include <stdbool.h>
#include <stdint.h>

#include "hil/core/state.h"
#include "hil/periph/wire.h"

enum hil_rcc_bus { HIL_RCC_AHB1, HIL_RCC_APB1, HIL_RCC_APB2, HIL_RCC_BUS_COUNT };

struct hil_rcc {
    HIL_NAMED_WORDS(word, cr, pllcfgr, cfgr, cir, rstr[8], ahb1enr, ahb2enr, ahb3enr, reserved_3c,
                    apb1enr, apb2enr, reserved_48[2], lpenr[6], reserved_68[3], csr);
    uint32_t flash_acr;
    uint32_t pwr_cr;
    uint64_t voltage_scale_ready_cycle; /* PWR_CSR.VOSRDY */
    bool has_crystal_failed;            /* the crystal has stopped; survives resets */
    bool is_watchdog_running;           /* the watchdog runs and keeps the LSI on */
    bool is_latency_unread;             /* FLASH_ACR was written and has not been read since */
};

/* Peripheral that a bit of a reset register resets. */
struct hil_reset_line {
    void (*reset)(void *device, unsigned unit); /* NULL: nothing */
    void *device;
    unsigned unit;
};

/* Clocks that the last store to a clock register has switched on. Only used during a run. */
struct hil_rcc_new_clock {
    uint32_t store_pc;
    uint64_t block_cycle;     /* cycle of the block with the store */
    unsigned required_cycles; /* cycles that must pass after that before an access */
};

struct hil_rcc_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_rcc_new_clock new_clock;
    struct hil_rcc *state;
    struct hil_reset_line reset_lines[HIL_RCC_BUS_COUNT][32];
};

/* Sets the state after a reset; `csr_flags`: reset flags for RCC_CSR. */
void hil_rcc_reset(struct hil_rcc_device *dev, uint32_t csr_flags);
/* Sets the state that a debugger or the Go command of the boot ROM leaves when it starts the
 * program without a reset. The system clock is then the PLL at 168 MHz from an 8 MHz crystal, and
 * the clocks of ports and timers are on. */
void hil_rcc_leave_clocks_on(struct hil_rcc_device *dev);
/* Register that switches the clocks of a bus. */
const uint32_t *hil_rcc_clock_enables(const struct hil_rcc_device *dev, enum hil_rcc_bus bus);
bool hil_rcc_is_clock_on(const struct hil_rcc_device *dev, enum hil_rcc_bus bus, unsigned bit);
/* HCLK cycles per cycle of PCLK1 or PCLK2, and per cycle of the timers on APB1 or APB2. */
uint32_t hil_rcc_pclk_divider(const struct hil_rcc_device *dev, enum hil_rcc_bus bus);
uint32_t hil_rcc_timer_divider(const struct hil_rcc_device *dev, enum hil_rcc_bus bus);
/* Stops the crystal or lets it oscillate again. A stop with CSSON set causes an NMI and a switch to
 * the HSI, with the PLL off (RM0090 7.2.7). */
void hil_rcc_set_crystal(struct hil_rcc_device *dev, bool on);

/* Functions that bus and event queue call; `device` is a struct hil_rcc_device. */
HIL_DECLARE_BUS_CALLS(rcc)
void hil_rcc_hse_event(void *device, uint64_t at);
void hil_rcc_pll_event(void *device, uint64_t at);
void hil_rcc_lsi_event(void *device, uint64_t at);

HIL_DECLARE_BUS_CALLS(pwr)
/* Maximum HCLK for the present flash wait states and voltage scale, Hz. */
uint32_t hil_rcc_max_hclk_hz(const struct hil_rcc *rcc);

/* ---- the independent watchdog ---- */

/* Independent watchdog (RM0090 21), clocked by the LSI (17 to 47 kHz). */

struct hil_iwdg {
    HIL_NAMED_WORDS(word, kr, pr, rlr);
    bool is_unlocked, is_running;
    /* times until which SR.PVU and SR.RVU are set: a value written to PR or RLR takes effect after
     * up to five LSI cycles */
    uint64_t update_end_ps[2];
};

struct hil_iwdg_device {
    HIL_NEIGHBOUR_POINTERS;
    struct hil_iwdg *state;
};

void hil_iwdg_reset(struct hil_iwdg_device *dev);
/* Functions that bus and event queue call; `device` is a struct hil_iwdg_device. */
HIL_DECLARE_BUS_CALLS(iwdg)
void hil_iwdg_event(void *device, uint64_t at);

#endif
