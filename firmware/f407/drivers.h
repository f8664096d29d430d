/* Drivers of the F407, one file each; they implement board.h. All loops that wait for hardware are
 * bounded; a part that does not respond is counted as a fault and not used. */
#ifndef MATRIG_FIRMWARE_F407_DRIVERS_H
#define MATRIG_FIRMWARE_F407_DRIVERS_H

#include <stdbool.h>

#include "firmware/board.h"
#include "firmware/f407/pins.h"
#include "firmware/f407/regs.h"

/* Marks a buffer that DMA may write or read at any time. The background test of RAM skips these
 * buffers, which matrig.ld collects. */
#define DMA_BUFFER __attribute__((section(".bss.dma_buffers")))

/* clock.c: resets clocks and peripherals, some of which a debugger or the Go command of the boot
 * ROM may have left on. */
void clock_reset(void);
/* Starts the PLL from the crystal, or from the internal oscillator if the crystal is not wanted or
 * does not start. */
enum mr_clock_source clock_start(bool crystal_wanted);
/* Frequency of the crystal, measured at start with the internal oscillator; 0: no oscillation. */
uint32_t clock_crystal_khz(void);
/* scan.c: TIM4, ADC1, ADC3, their DMA, and blocks. Must be called before board_scans_configure can
 * start the scans. */
void scan_prepare(void);
bool scan_is_block_ready(void);
/* capture.c: TIM2 and its DMA. Call before the scans start, because their timer starts both. */
void capture_start(void);
/* Drops captures that are too old to be processed, and counts them as lost. Call it often enough
 * that their ticks cannot wrap. */
void capture_discard_old(void);
void can_start(void);
/* nor.c: starts SPI2 and the memory of the black box, which counts as missing before this call. */
void nor_start(void);
/* Extends the time limit of the operation by the time in which it could not be polled. Call with
 * interrupts masked. */
void nor_extend_timeout(uint32_t ticks);
/* Manufacturer, type and capacity of the chip: 0x00ef4018. Call only while nor_poll returns
 * NOR_IDLE. */
uint32_t nor_read_jedec_id(void);
void uart_start(void);
/* Changes the rate from the initial 2 Mbaud, after everything has been sent; used by the bring-up
 * image. */
void uart_set_rate(uint32_t baud);
/* True if all queued bytes have been sent or are in the transmitter (at most two bytes). */
bool uart_is_sent(void);
/* board.c: starts the watchdog with half a second at nominal LSI, 0.34 to 0.94 s over the range of
 * LSI. */
void watchdog_start(void);
void watchdog_feed(void);
/* Sets the time-out in counts of LSI / 32 and resets the counter of the watchdog. The erase of a 16
 * KiB sector takes 0.5 s; 1500 counts are at least 1.02 s. */
#define WATCHDOG_DEFAULT_COUNTS 500u
#define WATCHDOG_FLASH_COUNTS   1500u
void watchdog_set_timeout(uint32_t counts);
/* board.c: enters the boot ROM if board_enter_rom requested it before this reset. Call before
 * anything else. */
void enter_rom_if_requested(void);
/* fault.c: counts a processor fault or a late task from before this reset; `cause` as in the
 * message hello. Returns true if there were too many resets in a row; the board then only
 * communicates. */
bool fault_read_record(uint8_t cause);
/* True if the crystal has started and stopped twice since the last requested restart. */
bool fault_has_crystal_stopped_twice(void);
void fault_set_image_crc(uint32_t crc);
/* memory.c: fills the stack with a pattern and tests the DMA buffers. Call before they are used. */
void memory_start(void);
void memory_set_image_crc(uint32_t crc);
#endif
