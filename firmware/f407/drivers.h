/* The F407's drivers, one file each, behind board.h. All loops that wait for hardware are bounded;
 * what does not answer is counted as a fault and left out. */
#ifndef MATRIG_FIRMWARE_F407_DRIVERS_H
#define MATRIG_FIRMWARE_F407_DRIVERS_H

#include <stdbool.h>

#include "firmware/board.h"
#include "firmware/f407/pins.h"
#include "firmware/f407/regs.h"

/* A buffer that DMA writes or reads at any time: the background test of RAM leaves it alone
 * (matrig.ld gathers them). */
#define DMA_BUFFER __attribute__((section(".bss.dma_buffers")))

/* clock.c: clocks and peripherals as after a reset. A debugger, or the boot ROM's Go, may have
 * left others on. */
void clock_reset(void);
/* Crystal and PLL, or internal oscillator and PLL: also when the crystal is not to be relied on. */
enum mr_clock_source clock_start(bool crystal_wanted);
/* Of the crystal, by the internal oscillator, as measured at start; 0: none swings. */
uint32_t clock_crystal_khz(void);
/* scan.c: TIM4, ADC1, ADC3, their DMA, blocks; board_scans_configure begins, unless this was not
 * called. */
void scan_prepare(void);
bool scan_ready(void); /* a block can be taken */
/* capture.c: TIM2 and its DMA; before the scans, whose timer starts both. */
void capture_start(void);
/* What was captured before the blocks stopped is counted as lost, before its ticks come round. */
void capture_forget_old(void);
void can_start(void);
/* nor.c: SPI2 and the black box's memory, which is missing until then. */
void nor_start(void);
/* The operation could not be polled for this long: its time-out is extended. Interrupts masked. */
void nor_excuse(uint32_t ticks);
/* Manufacturer, type, capacity: 0x00ef4018; only while nor_poll says idle. */
uint32_t nor_jedec(void);
void uart_start(void);
/* Another rate than the 2 Mbaud of the start, after all was sent: the bring-up image's. */
void uart_rate(uint32_t baud);
/* All that was queued has left, or is in the transmitter: two bytes at most. */
bool uart_sent(void);
/* board.c: half a second at nominal LSI, 0.34 to 0.94 s over its range. */
void watchdog_start(void);
void watchdog_feed(void);
/* How many counts of LSI / 32 it waits from now on; feeds it. A 16 KiB sector's erase takes 0.5 s:
 * 1500 are 1.02 s at least. */
#define WATCHDOG_USUAL 500u
#define WATCHDOG_FLASH 1500u
void watchdog_patience(uint32_t counts);
/* board.c: goes to the boot ROM when board_enter_rom asked for it before this reset. Before
 * anything else. */
void rom_if_asked(void);
/* fault.c: counts what a processor fault or a late task before this reset left behind; `cause` as
 * in the message hello. True: too many in a row, the board only communicates. */
bool fault_recall(uint8_t cause);
/* The crystal has started and stopped again, twice since the last requested restart. */
bool fault_crystal_stops(void);
void fault_set_image_crc(uint32_t crc);
/* memory.c: paint the stack and test the buffers of DMA. Before anything is in them. */
void memory_start(void);
void memory_set_image_crc(uint32_t crc);
#endif
