/* Reset and clock control with power control (RM0090 7, 5.4); the flash interface is in hil/periph/flash.h.
 *
 * Oscillators take their time: HSE 2 ms, PLL 200 us, LSI 40 us. Settings that silicon would not survive
 * (PLL out of range, bus too fast, too few flash wait states, voltage scale too low) halt the run with a
 * message. */
#ifndef MATRIG_HIL_RCC_H
#define MATRIG_HIL_RCC_H

#include <stdbool.h>
#include <stdint.h>

struct hil_board;

enum hil_rcc_bus { HIL_RCC_ALWAYS, HIL_RCC_AHB1, HIL_RCC_APB1, HIL_RCC_APB2, HIL_RCC_ANY_ADC };

struct hil_rcc {
    uint32_t cr, pllcfgr, cfgr, cir, csr;
    uint32_t ahb1enr, apb1enr, apb2enr;
    uint32_t flash_acr;
    uint32_t pwr_cr;
    uint64_t scale_ready_cycle; /* PWR_CSR.VOSRDY */
    bool crystal_failed;        /* it stopped; survives resets */
    bool no_clock;              /* it was behind the system clock, and nothing watched it */
};

/* After a reset; `csr_flags` are the reset flags that RCC_CSR will show. */
void hil_rcc_reset(struct hil_board *board, uint32_t csr_flags);
bool hil_rcc_enabled(const struct hil_board *board, unsigned bus, unsigned bit);
/* HCLK cycles to one cycle of PCLK1, PCLK2, and of the timers on APB1. */
uint32_t hil_rcc_apb1_divider(const struct hil_board *board);
uint32_t hil_rcc_apb2_divider(const struct hil_board *board);
uint32_t hil_rcc_apb1_timer_divider(const struct hil_board *board);
/* The crystal stops, or can oscillate again. With CSSON: NMI, HSI in its place, PLL off (7.2.7). */
void hil_rcc_crystal(struct hil_board *board, bool on);
/* The watchdog starts the LSI by itself. */
void hil_rcc_start_lsi(struct hil_board *board);

uint32_t hil_rcc_read(struct hil_board *board, unsigned unit, uint32_t offset);
void hil_rcc_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value);
void hil_rcc_hse_event(struct hil_board *board, uint64_t at);
void hil_rcc_pll_event(struct hil_board *board, uint64_t at);
void hil_rcc_lsi_event(struct hil_board *board, uint64_t at);

uint32_t hil_pwr_read(struct hil_board *board, unsigned unit, uint32_t offset);
void hil_pwr_write(struct hil_board *board, unsigned unit, uint32_t offset, uint32_t value);
/* HCLK that flash wait states and voltage scale allow, Hz. */
uint32_t hil_power_limit_hz(const struct hil_rcc *rcc);

#endif
