/* The seam between the application and the board: everything the application needs of hardware, in a dozen calls.
 *
 * firmware/f407/ implements it with the STM32F407's registers; tests link a fake. The application above it has no
 * registers and no clock: time is the block it is given. None of the calls waits without a bound, and none is called from
 * an interrupt. Faults met on the way are counted with health_count (health.h). */
#ifndef MATRIG_FIRMWARE_BOARD_H
#define MATRIG_FIRMWARE_BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/image.h"

enum board_clock_source {
    BOARD_CLOCK_CRYSTAL = 0,   /* HSE and PLL, 168 MHz */
    BOARD_CLOCK_INTERNAL = 1,  /* HSI and PLL, 168 MHz within 1 %: CAN stays silent */
    BOARD_CLOCK_RAW = 2,       /* HSI alone, 16 MHz: nothing is measured */
};

struct board_identity {
    uint32_t uid[3];       /* RM0090 39.1 */
    uint32_t image_crc;    /* CRC-32 of the program in flash, computed at start */
    struct mr_image image; /* the image's header; zeros when there is none */
    uint8_t image_state;   /* enum mr_image_state, as found at start */
    uint8_t reset_cause;   /* bits as in the message hello */
    uint8_t clock_source;  /* enum board_clock_source */
};

struct board_can_frame {
    uint16_t id; /* 11 bits */
    uint8_t length;
    uint8_t data[8];
};

struct board_can_errors {
    uint8_t tec;
    uint8_t rec;
    bool passive;
    bool bus_off;
};

/* Brings up what answers and begins the scans. Everything else may be called after it, whatever was missing. */
void board_start(void);
void board_identify(struct board_identity *identity);
/* Is flash, read now, the image that was built: vectors, header and program? Takes some 5 ms. */
bool image_ok(void);

/* Next block in order; false when none is ready. A loss shows as a jump of the index. */
bool board_block_take(struct mr_block *block);
/* Captured switch edges that happened at or before `until_tick` (TIM2, modulo 2^32), oldest first. Returns how many. */
size_t board_edges_take(uint32_t until_tick, uint32_t *ticks, size_t capacity);

/* Queue one frame; false when the queue is full or the link is down (the caller counts the drop). */
bool board_can_send(const struct board_can_frame *frame);
bool board_can_receive(struct board_can_frame *frame);
void board_can_state(struct board_can_errors *errors);
/* Queue `length` bytes, all or none. */
bool board_serial_send(const uint8_t *bytes, size_t length);
size_t board_serial_receive(uint8_t *bytes, size_t capacity);

/* Warning lamp and horn. The output is fail-safe: a dead board warns. */
void board_warn(bool warning);
void board_watchdog_feed(void);

/* Restart into the chip's boot ROM. Does not return on the board. */
void board_enter_rom(void);

/* Sleep until the next interrupt. Returns true when a supervision tick (10 ms) has passed since the last call. */
bool board_sleep(void);
/* Time awake since the last call, in 1/1000. */
uint16_t board_load_permille(void);
/* Begin the scans again after a stall; bounded to about 2 ms. */
void board_scans_restart(void);

#endif
