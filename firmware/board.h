/* The seam between the application and the board: everything the application needs of hardware.
 *
 * firmware/f407/ implements it with the STM32F407's registers; tests link a fake. The application
 * above it has no registers and no clock: time is the block it is given. None of the calls waits
 * without a bound, and none but the notes is called from an interrupt. Faults met on the way are
 * counted with health_count (health.h). */
#ifndef MATRIG_FIRMWARE_BOARD_H
#define MATRIG_FIRMWARE_BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/image.h"

struct board_identity {
    uint32_t uid[3];       /* RM0090 39.1 */
    uint32_t image_crc;    /* CRC-32 of the program in flash, computed at start */
    struct mr_image image; /* the image's header; zeros when there is none */
    uint8_t image_state;   /* enum mr_image_state, as found at start */
    uint8_t reset_cause;   /* bits as in the message hello */
    uint8_t clock_source;  /* enum mr_clock_source */
    uint8_t board;         /* which it is: common/boards.def */
};

struct board_can_frame {
    uint16_t id; /* the catalogue's, 11 bits */
    uint8_t length;
    uint8_t data[8];
};

struct board_can_errors {
    uint8_t tec;
    uint8_t rec;
    uint8_t last_error; /* LEC, as in the message can_alarm */
    bool passive;
    bool bus_off;
    bool missing;     /* the controller did not start */
    bool pending;     /* a frame waits to be sent */
    uint32_t passed;  /* frames that went out */
    uint32_t removed; /* frames that were queued and never went: board_can_clear */
};

/* What went before this start. */
struct board_restart {
    uint8_t restarts;  /* by watchdog or processor fault, since power on */
    uint8_t in_row;    /* of them, without ten good seconds in between */
    bool quiet;        /* too many: no scans and no black box, the warning output warns */
    uint8_t brown_out; /* level of the option bytes, as in the message restarts */
    uint8_t late_task; /* that let the watchdog pass; 0: none */
    uint32_t late_pc;
    /* MR_CRASH_ITEMS words that a processor fault left; NULL: none since power on */
    const uint32_t *crash;
    uint16_t crash_age; /* restarts since its own */
};

/* What is watched in the background. */
struct board_upkeep {
    uint16_t stack_used, stack_size; /* bytes */
    uint16_t ram_rounds;             /* times that all RAM in use was tested */
    uint16_t flash_rounds;           /* times that the program's checksum was computed again */
    bool ram_bad, flash_bad;         /* ever */
    uint32_t bad_address;            /* of the first RAM that did not hold */
};

/* Brings up what answers. Everything else may be called after it, whatever was missing. */
void board_start(void);
void board_identify(struct board_identity *identity);
/* Bit c: the board has an input for channel c (common/block.h); staircase and reference always. */
uint32_t board_inputs(void);
/* Supply of the converters, nominal. */
uint32_t board_supply_mv(void);

/* Next block in order; false when none is ready. A loss shows as a jump of the index. */
bool board_block_take(struct mr_block *block);
/* Blocks that are ready and wait to be taken. */
unsigned board_blocks_waiting(void);
/* Captured switch edges that happened at or before `until_tick` (TIM2, modulo 2^32), oldest first.
 * Returns how many. */
size_t board_edges_take(uint32_t until_tick, uint32_t *ticks, size_t capacity);

/* Capture the camera's frame pulses, or no longer. */
void board_frames_capture(bool on);
/* Captured frame pulses that happened at or before `until_tick`, oldest first; their filter's delay
 * is taken off. */
size_t board_frames_take(uint32_t until_tick, uint32_t *ticks, size_t capacity);
/* Level of the camera's trigger output. Returns TIM2 at the moment it was set. */
uint32_t board_camera(bool high);

/* From now on what is sent has identifiers of the catalogue plus `base`, and only what is sent to
 * those comes in (common/canbase.h). Frames that are queued already keep theirs. Until the first
 * call the board takes no part in the bus. */
void board_can_move(uint16_t base);
/* Queue one frame; false when the queue is full or the link is down (the caller counts the
 * drop). */
bool board_can_send(const struct board_can_frame *frame);
/* Frames that are queued and have not come to the controller yet. */
unsigned board_can_waiting(void);
bool board_can_receive(struct board_can_frame *frame);
/* TIM2 when the last sync frame had left, end of frame acknowledged, if that was the one whose
 * message has `block`; false: it has not left. Late by what delays the interrupt: below 30 us. */
bool board_can_sync_tick(uint32_t block, uint32_t *tick);
/* Drop what waits, the controller's mailboxes included; a frame on the wire ends first: `pending`
 * says when all are gone. */
void board_can_clear(void);
/* The way out of bus-off: begin, and a tick later go on. The controller then waits for 128 times 11
 * recessive bits by itself. */
void board_can_rejoin(bool begin);
void board_can_state(struct board_can_errors *errors);
/* Queue `length` bytes, all or none. */
bool board_serial_send(const uint8_t *bytes, size_t length);
size_t board_serial_receive(uint8_t *bytes, size_t capacity);

/* Warning lamp and horn. The output is fail-safe: a dead board warns. */
void board_warn(bool warning);
/* Shunt resistors across an arm of every strain bridge; off after reset. */
void board_shunt(bool on);
/* The lamp draws current. */
bool board_lamp_draws(void);
void board_watchdog_feed(void);

/* The maintenance jumper is fitted. */
bool board_jumper(void);
/* The boot ROM listens at the serial link's pins; otherwise the board could not be recovered from
 * it. */
bool board_rom_hears(void);
/* Restart into the chip's boot ROM. Does not return on the board. */
void board_enter_rom(void);
/* Restart. Does not return on the board. */
void board_reset(void);
void board_restarted(struct board_restart *restart);
/* For the time after the watchdog's reset: which task was late, and where; 0: it has come round.
 * From an interrupt. */
void board_note_late(uint8_t task, uint32_t pc);
/* Ten good seconds: the next restart is the first of a row. From an interrupt. */
void board_note_good(void);

/* Test the next piece of RAM and check the next of flash: 15 us, interrupts masked for less than 1
 * us at a time. What fails is counted. */
void board_upkeep(void);
/* Begin both at their beginning. */
void board_upkeep_restart(void);
void board_upkeep_state(struct board_upkeep *upkeep);
/* Is flash, read now, the image that was built: vectors, header and program? Some 5 ms. False: it
 * has no header with a CRC. */
bool board_image_check(bool *good);

/* Sleep until the next interrupt. Returns true when a supervision tick (10 ms) has passed since the
 * last call. */
bool board_sleep(void);
/* Time awake since the last call, in 1/1000. */
uint16_t board_load_permille(void);
/* Begin the scans, of the channels whose bits are set (staircase and reference always), or begin
 * them again with others: blocks keep their index and tick, one or two are missing. Bounded to
 * about 2 ms. */
void board_scans_configure(uint32_t fitted);
/* Begin the scans again after a stall; likewise. */
void board_scans_restart(void);

/* ---- flash ---- */

/* The seam to the two flash sectors that hold the configuration: 16 KiB each, erased to ones,
 * programmed in words.
 *
 * The flash has one bank: while an operation lasts, the processor stands still (a sector's erase:
 * 0.25 to 0.5 s, a word: 16 to 100 us). So sampling stops from flash_begin to flash_end, and the
 * blocks lost show as a jump of the index; only while idle. firmware/f407/flash.c implements it;
 * tests link a memory that tears (fake_flash.h). */
#define FLASH_COPIES     2u
#define FLASH_COPY_BYTES (MR_CONFIGURATION_BYTES / FLASH_COPIES)

/* What a copy's sector holds now, FLASH_COPY_BYTES. */
const uint8_t *flash_copy(unsigned copy);

/* Between these two alone: */
void flash_begin(void);
void flash_end(void);
/* False: it did not work, or not in its time (1 s); what the sector holds then is not known. */
bool flash_erase(unsigned copy);
/* `offset` in bytes, a multiple of 4. Ones become zeroes only. */
bool flash_program(unsigned copy, uint32_t offset, uint32_t word);

/* ---- nor ---- */

/* The seam to the NOR memory of the black box: 16 MiB, pages of 256 bytes, sectors of 4 KiB that
 * are erased to ones.
 *
 * One operation at a time: begin it when nor_poll says idle, then poll. Nothing waits; buffers stay
 * the driver's until the poll says idle or failed. firmware/f407/nor.c implements it; tests link a
 * memory that wears, tears and fails (fake_nor.h). */
#define NOR_PAGE             256u
#define NOR_SECTOR           4096u
#define NOR_CHIP_SECTORS     4096u
/* the last ones are the predictor's runway's (runwaystore.h), a sector each, before them the key's
 * (keystore.h), */
#define RUNWAY_COPIES        2u
#define KEY_COPIES           2u
/* the rest the black box's */
#define NOR_SECTORS          (NOR_CHIP_SECTORS - RUNWAY_COPIES - KEY_COPIES)
#define KEY_FIRST_SECTOR     NOR_SECTORS
#define RUNWAY_FIRST_SECTOR  (NOR_CHIP_SECTORS - RUNWAY_COPIES)
#define NOR_PAGES_PER_SECTOR (NOR_SECTOR / NOR_PAGE)

enum nor_status {
    NOR_IDLE, /* the last operation is over; only reading back shows whether it succeeded */
    NOR_BUSY,
    NOR_FAILED,  /* the last operation did not end in its time; the next may be tried */
    NOR_MISSING, /* no chip, or not the one expected: stays so */
};

enum nor_status nor_poll(void);
/* Ask the chip who it is: NOR_IDLE: the one expected; NOR_BUSY: ask later; NOR_MISSING. Nothing
 * else is disturbed. */
enum nor_status nor_identify(void);
/* At most NOR_PAGE bytes. */
void nor_begin_read(uint32_t address, uint8_t *bytes, size_t length);
/* A whole page; bytes of 0xff leave what is there. */
void nor_begin_program(uint32_t address, const uint8_t page[NOR_PAGE]);
void nor_begin_erase(uint32_t address);

/* ---- i2c ---- */

/* The seam to the bus of the thermometer: one transfer at a time, a step at each poll; nothing
 * waits.
 *
 * firmware/f407/i2c.c implements it on I2C1 (PB6 SCL, PB7 SDA); tests link a bus that fails
 * (fake_i2c.h). */
enum i2c_status {
    I2C_IDLE, /* the last transfer is over, and was acknowledged */
    I2C_BUSY,
    I2C_NO_ANSWER, /* it was not acknowledged; the next may be tried */
    /* a line was held, or it took too long: nine clocks and a stop were tried; likewise */
    I2C_STUCK,
};

/* Clock and pins; before that, and after the stop, the bus costs nothing and its pins are
 * inputs. */
void i2c_start(void);
void i2c_stop(void);
/* Write `out_length` bytes (1 to 4) to a device, then, behind a repeated start, read `in_length` (0
 * or 2). Begun when i2c_poll did not say busy; the buffers stay the driver's until it no longer
 * says busy. */
void i2c_begin(uint8_t address, const uint8_t *out, size_t out_length, uint8_t *in,
               size_t in_length);
enum i2c_status i2c_poll(void);

#endif
