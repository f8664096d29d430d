/* The interface between the application and the board: everything that the application needs from
 * the hardware.
 *
 * firmware/f407/ implements it with the registers of the STM32F407; tests link a fake. The
 * application uses no registers and no clock: its time is the index of the current block. Every
 * wait in these calls is bounded. Only board_record_late_task and board_reset_restart_count may be
 * called from an interrupt. Faults are counted with health_count_fault (health.h). */
#ifndef MATRIG_FIRMWARE_BOARD_H
#define MATRIG_FIRMWARE_BOARD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/block.h"
#include "common/catalogue.h"
#include "common/image.h"

struct board_identity {
    uint32_t uid[3];       /* unique identifier (RM0090 39.1) */
    uint32_t image_crc;    /* CRC-32 of the program in flash, computed at start */
    struct mr_image image; /* header of the image; zeros if there is none */
    uint8_t image_state;   /* enum mr_image_state, as found at start */
    uint8_t reset_cause;   /* bits as in the message hello */
    uint8_t clock_source;  /* enum mr_clock_source */
    uint8_t board;         /* number of the board (common/boards.def) */
};

struct board_can_frame {
    uint16_t id; /* identifier in the catalogue, 11 bits */
    uint8_t length;
    uint8_t data[8];
};

struct board_can_errors {
    uint8_t tec;
    uint8_t rec;
    uint8_t last_error; /* LEC, as in the message can_alarm */
    bool is_passive;
    bool is_bus_off;
    bool is_missing;        /* the controller did not start */
    bool is_pending;        /* a frame is waiting to be sent */
    uint32_t sent_count;    /* frames sent */
    uint32_t removed_count; /* queued frames that were dropped by board_can_clear */
};

/* Restarts before this start. */
struct board_restart {
    uint8_t restarts;    /* restarts by watchdog or processor fault since power on */
    uint8_t consecutive; /* consecutive restarts, without ten good seconds in between */
    /* too many restarts in a row: the board starts without scans and black box, with the warning
     * output on */
    bool is_safe_mode;
    uint8_t brown_out; /* brown-out level of the option bytes, as in the message restarts */
    uint8_t late_task; /* task that was late before the watchdog reset; 0: none */
    uint32_t late_pc;
    /* MR_CRASH_ITEM_COUNT words recorded by a processor fault; NULL: none since power on */
    const uint32_t *crash;
    uint16_t crash_age; /* number of restarts since the one that the crash caused */
};

/* Results of the background tests. */
struct board_background_tests {
    uint16_t stack_used, stack_size; /* bytes */
    uint16_t ram_test_count;         /* completed tests of all RAM in use */
    uint16_t flash_check_count;      /* completed checks of the program's checksum */
    bool is_ram_bad, is_flash_bad;   /* a fault was found since the start */
    uint32_t bad_address;            /* address of the first bad RAM */
};

/* Starts the hardware. If parts are missing, the other functions may still be called afterwards. */
void board_start(void);
void board_identify(struct board_identity *identity);
/* Bit c: the board has an input for channel c (common/block.h). The bits of staircase and reference
 * are always set. */
uint32_t board_input_mask(void);
/* Nominal supply voltage of the converters. */
uint32_t board_supply_mv(void);

/* Returns the next block in order; false: none is ready. A jump of the index means lost blocks. */
bool board_block_get(struct mr_block *block);
/* Number of blocks that are ready. */
unsigned board_blocks_waiting(void);
/* Returns the captured switch edges up to and including `until_tick` (TIM2, modulo 2^32), oldest
 * first, and their number. */
size_t board_edges_get(uint32_t until_tick, uint32_t *ticks, size_t capacity);

enum board_pulse_input {
    BOARD_FRAME_PULSES,
    BOARD_BRAKE_PULSES,
    BOARD_WHEEL_PULSES,
    BOARD_PULSE_INPUT_COUNT
};
/* Switches the capture of an input's pulses on or off. */
void board_pulses_enable(enum board_pulse_input input, bool on);
/* As board_edges_get, for pulses; the delay of their input filter has been subtracted. */
size_t board_pulses_get(enum board_pulse_input input, uint32_t until_tick, uint32_t *ticks,
                        size_t capacity);
/* Sets the level of the camera's trigger output. Returns TIM2 at that moment. */
uint32_t board_set_camera_trigger(bool high);

/* Sets the base that is added to the identifiers of all frames sent and received
 * (common/canbase.h). Frames that are already queued keep their identifiers. Until the first call
 * the board does not take part in the bus. */
void board_can_set_base(uint16_t base);
/* Queues one frame; false: the queue is full or the link is down (the caller counts the drop). */
bool board_can_send(const struct board_can_frame *frame);
/* Number of queued frames that are not in the controller yet. */
unsigned board_can_waiting(void);
bool board_can_receive(struct board_can_frame *frame);
/* Returns TIM2 at the acknowledged end of the last sync frame if its message had `block`; false:
 * that frame has not been sent. The time is too late by the interrupt latency, which is less than
 * 30 us. */
bool board_can_sync_tick(uint32_t block, uint32_t *tick);
/* Drops all waiting frames, including those in the controller's mailboxes. A frame on the wire is
 * completed first; board_can_errors.is_pending becomes false when no frame is left. */
void board_can_clear(void);
/* Leaves bus-off in two steps: call with `begin` true, then with false one tick later. The
 * controller then waits for 128 times 11 recessive bits. */
void board_can_leave_bus_off(bool begin);
void board_can_get_errors(struct board_can_errors *errors);
/* Queues all of `length` bytes, or none and returns false. */
bool board_serial_send(const uint8_t *bytes, size_t length);
size_t board_serial_receive(uint8_t *bytes, size_t capacity);

/* Sets the warning output (lamp and horn). The output is fail-safe: it is on when the board does
 * not run. */
void board_set_warning(bool warning);
/* Switches the shunt resistors, one across an arm of every strain bridge. They are off after a
 * reset. */
void board_set_shunts(bool on);
/* True if the lamp draws current. */
bool board_has_lamp_current(void);
void board_watchdog_feed(void);

/* True if the maintenance jumper is fitted. */
bool board_is_jumper_fitted(void);
/* True if the boot ROM uses the pins of the serial link. Otherwise the board could not be recovered
 * from the boot ROM. */
bool board_is_rom_reachable(void);
/* Restarts into the chip's boot ROM. Does not return on the board. */
void board_enter_rom(void);
/* Restarts the board. Does not return on the board. */
void board_reset(void);
void board_get_restart(struct board_restart *restart);
/* Records the late task and its PC for the report after a watchdog reset; task 0: the task is no
 * longer late. May be called from an interrupt. */
void board_record_late_task(uint8_t task, uint32_t pc);
/* Call after ten good seconds: the next restart counts as the first in a row. May be called from an
 * interrupt. */
void board_reset_restart_count(void);

/* Tests the next part of RAM and checks the next part of flash. Takes 15 us, with interrupts masked
 * for less than 1 us at a time. Failures are counted. */
void board_check_memory(void);
/* Restarts both tests from the beginning. */
void board_restart_memory_test(void);
void board_get_background_tests(struct board_background_tests *upkeep);
/* Reads the flash and checks that vectors, header and program match the image that was built; takes
 * about 5 ms. False: the image has no header with a CRC. */
bool board_image_check(bool *good);

/* Sleeps until the next interrupt. Returns true if a supervision tick (every 10 ms) has occurred
 * since the last call. */
bool board_sleep(void);
/* Returns the share of time since the last call in which the processor was not asleep, in
 * 1/1000. */
uint16_t board_load_permille(void);
/* Starts the scans of the channels whose bits are set (staircase and reference always), or restarts
 * them with different channels. Indexes and ticks of blocks continue without a jump; one or two
 * blocks are lost. Takes at most about 2 ms. */
void board_scans_configure(uint32_t fitted);
/* Restarts the scans after a stall. Blocks and time as in board_scans_configure. */
void board_scans_restart(void);

/* ---- flash ---- */

/* Interface to the two flash sectors that hold the configuration: 16 KiB each, erased to ones,
 * programmed in words.
 *
 * The flash has one bank: the processor stalls during an operation (erase of a sector: 0.25 to 0.5
 * s; programming of a word: 16 to 100 us). Sampling therefore stops from flash_begin to flash_end,
 * and the lost blocks appear as a jump of the index. Use only while idle. firmware/f407/flash.c
 * implements the interface; tests link a memory that simulates power failures (fake_flash.h). */
#define FLASH_COPIES     2u
#define FLASH_COPY_BYTES (MR_CONFIGURATION_BYTES / FLASH_COPIES)

/* Present content of a copy's sector, FLASH_COPY_BYTES bytes. */
const uint8_t *flash_get_copy(unsigned copy);

/* Erase and program only between calls of these two functions. */
void flash_begin(void);
void flash_end(void);
/* Erases a sector. Returns false if the erase failed or timed out (1 s); the content of the sector
 * is then undefined. */
bool flash_erase(unsigned copy);
/* Programs a word. `offset` is in bytes, a multiple of 4. Programming can only change ones to
 * zeroes. */
bool flash_program(unsigned copy, uint32_t offset, uint32_t word);

/* ---- nor ---- */

/* Interface to the NOR memory of the black box: 16 MiB, pages of 256 bytes, sectors of 4 KiB that
 * are erased to ones.
 *
 * Only one operation at a time is possible: begin it when nor_poll returns NOR_IDLE, then poll. No
 * call waits. The driver uses the buffers until nor_poll returns NOR_IDLE or NOR_FAILED.
 * firmware/f407/nor.c implements the interface; tests link a memory that simulates wear, power
 * failures and faults (fake_nor.h). */
#define NOR_PAGE_BYTES       256u
#define NOR_SECTOR_BYTES     4096u
#define NOR_CHIP_SECTORS     4096u
/* The last sectors hold the copies of the predictor's runway (runwaystore.h), one sector each; the
 * sectors before them hold the copies of the key (keystore.h). */
#define RUNWAY_COPIES        2u
#define KEY_COPIES           2u
/* the black box uses all other sectors */
#define NOR_SECTORS          (NOR_CHIP_SECTORS - RUNWAY_COPIES - KEY_COPIES)
#define KEY_FIRST_SECTOR     NOR_SECTORS
#define RUNWAY_FIRST_SECTOR  (NOR_CHIP_SECTORS - RUNWAY_COPIES)
#define NOR_PAGES_PER_SECTOR (NOR_SECTOR_BYTES / NOR_PAGE_BYTES)

enum nor_status {
    NOR_IDLE, /* the last operation has ended; only reading back shows whether it was successful */
    NOR_BUSY,
    NOR_FAILED, /* the last operation timed out; the next one may be tried */
    /* there is no chip, or not the expected one; this state does not change any more */
    NOR_MISSING,
    NOR_STUCK, /* a chip responds, but stays busy; this state does not change any more */
};

/* Continues the operation in progress and returns the state of the memory. */
enum nor_status nor_poll(void);
/* Reads the chip's identification. NOR_IDLE: the expected chip; NOR_BUSY: call again later;
 * NOR_MISSING and NOR_STUCK as nor_poll. Does not disturb other operations. */
enum nor_status nor_identify(void);
/* Reads at most NOR_PAGE_BYTES bytes. */
void nor_begin_read(uint32_t address, uint8_t *bytes, size_t length);
/* Programs a whole page; bytes of 0xff leave the memory unchanged. */
void nor_begin_program(uint32_t address, const uint8_t page[NOR_PAGE_BYTES]);
void nor_begin_erase(uint32_t address);

/* ---- i2c ---- */

/* Interface to the bus of the thermometer: one transfer at a time, one step per poll. No call
 * waits.
 *
 * firmware/f407/i2c.c implements the interface on I2C1 (PB6 SCL, PB7 SDA); tests link a bus that
 * simulates faults (fake_i2c.h). */
enum i2c_status {
    I2C_IDLE, /* the last transfer was acknowledged and has ended */
    I2C_BUSY,
    I2C_NO_ANSWER, /* the last transfer was not acknowledged; the next one may be tried */
    /* a line was held low, or the transfer timed out. Nine clocks and a stop have been sent to free
     * the bus, and the next transfer may be tried */
    I2C_STUCK,
};

/* Start and stop clock and pins of the bus. While stopped, the bus has no clock and its pins are
 * inputs. */
void i2c_start(void);
void i2c_stop(void);
/* Writes `out_length` bytes (1 to 4) to a device, then reads `in_length` bytes (0 or 2) after a
 * repeated start. Call only when i2c_poll does not return I2C_BUSY. The driver uses the buffers
 * until i2c_poll no longer returns I2C_BUSY. */
void i2c_begin(uint8_t address, const uint8_t *out, size_t out_length, uint8_t *in,
               size_t in_length);
enum i2c_status i2c_poll(void);

#endif
