/* Scripted faults, each with a trigger and an action, from a text file (hil/README.md, "Faults") or
 * by calls.
 *
 * Each fault (with the text of its line) and each affected frame or byte is reported with its time
 * in one line to hil_options.log. */
#ifndef MATRIG_HIL_FAULTS_H
#define MATRIG_HIL_FAULTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "common/status.h"
#include "hil/core/state.h"
#include "hil/periph/canbits.h"
#include "hil/periph/wire.h"
#include "hil/rig/rig.h"

struct hil_can_device;
struct hil_core;
struct hil_flash_device;
struct hil_i2c_device;
struct hil_nor_fault_requests;
struct hil_rcc_device;
struct hil_tmp112;
struct hil_tmp112_device;
struct hil_w25q_device;

/* ---- the two links, from the board's pins to the host's end, and their faults ---- */

/* maximum number of delayed frames; further frames are not delayed */
#define HIL_FAULT_DELAYED_FRAMES_MAX 16u
/* maximum number of delayed bytes; further bytes are not delayed */
#define HIL_FAULT_DELAYED_BYTES_MAX  16384u
#define HIL_FAULT_NO_LIMIT           UINT32_MAX

struct hil_callbacks {
    void *context;
    /* Called with a frame from the board; its last bit (end of frame) ended at t_ps. */
    void (*on_can_frame)(void *context, uint64_t t_ps, const struct hil_can_frame *frame);
    /* Called with n bytes from the board; the stop bit of the last byte ended at t_ps. */
    void (*on_serial_bytes)(void *context, uint64_t t_ps, const uint8_t *bytes, size_t n);
};

struct hil_line_effect {
    /* number of frames or bytes that the fault will still affect; HIL_FAULT_NO_LIMIT: no limit */
    uint32_t remaining_units;
    double probability;
    uint64_t duration_ps;
    unsigned file_line;
};

struct hil_lines {
    uint64_t random_state;
    struct hil_line_effect effect[HIL_LINE_COUNT][HIL_LINE_FAULT_COUNT];
    uint32_t delayed_frame_count; /* delayed CAN frames to the host */
    uint64_t delayed_frame_due_ps[HIL_FAULT_DELAYED_FRAMES_MAX];
    uint8_t delayed_frame[HIL_FAULT_DELAYED_FRAMES_MAX][24];
    uint32_t delayed_byte_count; /* delayed serial bytes to the host */
    uint64_t delayed_bytes_due_ps;
    uint8_t delayed_bytes[HIL_FAULT_DELAYED_BYTES_MAX];
};

struct hil_lines_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_lines *state;
    struct hil_callbacks callbacks; /* called for output that reaches the host */
    /* called for output at the board's pins, before the faults of the links */
    struct hil_callbacks pin_callbacks;
    struct hil_callback on_frame_sent; /* called when a CAN frame has left the board */
};

/* Initialises the links without faults. `seed`: for probabilities and corrupted bits. */
void hil_lines_init(struct hil_lines_device *dev, uint64_t seed);
/* Returns the calls by which peripherals use the links (struct hil_line_calls). */
struct hil_line_calls hil_lines_calls(struct hil_lines_device *dev);
/* ---- the supply: power failures, brown-outs, and restarts of the chip ---- */

#define HIL_CSR_POWER_ON 0x0e000000u /* flags of RCC_CSR at power on: POR, pin, brown-out */

struct hil_supply {
    bool is_held_in_reset; /* the supply is missing or too low */
};

struct hil_supply_device {
    struct hil_core *core;
    struct hil_supply *state;
    struct hil_flash_device *flash;
    struct hil_rcc_device *rcc;
    struct hil_w25q_device *nor;
    struct hil_tmp112_device *thermometer;
};

void hil_supply_create(struct hil_supply_device *dev);
/* Simulates a power failure with immediate return of the supply. Operations of flash and NOR are
 * interrupted, RAM contains random data, and everything else is reset as at power on. Time, rig and
 * data on the links continue. May be called while the board runs or between runs. */
void hil_supply_cut(struct hil_supply_device *dev);
/* Call after a reset of the chip: holds it in reset while the supply is missing. */
void hil_supply_hold_reset(struct hil_supply_device *dev);

/* ---- faults ---- */

#define HIL_FAULTS_MAX 64u

enum hil_fault_trigger {
    HIL_TRIGGER_TIME,
    HIL_TRIGGER_STATION,
    HIL_TRIGGER_CAN_FRAME,
    HIL_TRIGGER_FLASH_OPERATION,
    HIL_TRIGGER_NOR_OPERATION
};

enum hil_fault_action {
    HIL_FAULT_POWER_CUT, /* uses duration_ps */
    HIL_FAULT_BROWN_OUT, /* uses volts, duration_ps */
    HIL_FAULT_CRYSTAL,   /* uses choice: 1 starts the crystal, 0 stops it */
    HIL_FAULT_BIT_FLIP,  /* uses address, bit */
    HIL_FAULT_CAN_BUS,   /* uses choice: enum hil_can_bus */
    /* uses line, choice (enum hil_line_fault), count, probability, duration_ps */
    HIL_FAULT_LINE,
    /* target_index: 0..7 transducers, 8..21 gages, 22 staircase, 23 reference; choice: enum
     * hil_channel_fault */
    HIL_FAULT_CHANNEL,
    HIL_FAULT_SWITCH_SKIP, /* target_index: number of the switch, from 0 */
    /* target_index: number of the switch, from 0; count; duration_ps between openings */
    HIL_FAULT_SWITCH_BOUNCE,
    HIL_FAULT_CAMERA,      /* uses count: number of frames without a pulse */
    HIL_FAULT_NOR,         /* choice: enum hil_nor_fault, count */
    HIL_FAULT_GAGE_DRIFT,  /* target_index: number of the gage, from 0; gain, offset_lb */
    HIL_FAULT_THERMOMETER, /* choice: enum hil_thermometer_fault, duration_ps of stretch */
    HIL_FAULT_STUCK_BIT,   /* address, bit; choice: level of the bit */
    HIL_FAULT_LAMP,        /* choice: enum hil_lamp_fault */
};

/* In the order of the keywords in a fault file. */
enum hil_nor_fault {
    HIL_NOR_FILL,
    HIL_NOR_DEAD,
    HIL_NOR_REPAIR,
    HIL_NOR_STUCK,
    HIL_NOR_FAIL_PROGRAM,
    HIL_NOR_FAIL_ERASE,
    HIL_NOR_HANG
};
enum hil_thermometer_fault {
    HIL_THERMOMETER_DEAD,
    HIL_THERMOMETER_STUCK,
    HIL_THERMOMETER_HANG,
    HIL_THERMOMETER_REPAIR,
    HIL_THERMOMETER_BERR,
    HIL_THERMOMETER_STRETCH,
};

/* One fault. Ranges are as in a fault file; hil_faults_read checks them. */
struct hil_fault {
    enum hil_fault_trigger trigger;
    uint64_t trigger_ps; /* for HIL_TRIGGER_TIME */
    /* for HIL_TRIGGER_CAN_FRAME, _FLASH, _NOR: number of the event since power on, from 1 */
    uint64_t event_number;
    double station_ft; /* for HIL_TRIGGER_STATION */
    uint64_t delay_ps; /* delay after the trigger */
    enum hil_fault_action
        /* action; the comments of enum hil_fault_action list which of the following members it
         * uses */
        action;
    enum hil_line line;
    unsigned variant;
    uint32_t target_index, count, address, bit;
    double probability; /* probability p of the fault, 0 < p <= 1 */
    double volts;
    double gain, offset_lb;
    uint64_t duration_ps;
    unsigned file_line;   /* line in the fault file; 0: the fault is not from a file */
    char action_text[80]; /* text of the action in the fault file */
};

struct hil_fault_script {
    uint64_t seed;
    size_t count;
    struct hil_fault fault[HIL_FAULTS_MAX];
};

/* Reads a fault file. `elf`: path of the image whose symbols may be used as addresses; NULL: none.
 * On failure `error` contains file, line, the mistake and the correct form. MR_IO; MR_MALFORMED;
 * MR_VERSION; MR_UNKNOWN: no such symbol; MR_FULL: too many lines. */
enum mr_status hil_faults_read(const char *path, const char *elf, struct hil_fault_script *script,
                               char *error, size_t size);

struct hil_faults {
    uint32_t count;
    struct hil_fault fault[HIL_FAULTS_MAX];
    /* time at which each fault is due; HIL_NEVER: it waits for its trigger, or is over */
    uint64_t due_ps[HIL_FAULTS_MAX];
    bool is_finished[HIL_FAULTS_MAX];
    uint64_t flash_operation_count, nor_operation_count;
};

struct hil_faults_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_faults *state;
    struct hil_lines_device *lines;
    struct hil_rig_device *rig;
    struct hil_camera_device *camera;
    struct hil_supply_device *supply;
    struct hil_rcc_device *rcc;
    struct hil_can_device *can;
    struct hil_i2c_device *i2c;
    struct hil_nor_fault_requests *nor;
    struct hil_tmp112 *thermometer;
};

/* Initialises without faults. */
void hil_faults_create(struct hil_faults_device *dev);
/* Adds one fault. For a trigger by station, the rig must be attached first. MR_FULL: too many
 * faults; MR_USAGE: no such memory, or a time in the past; MR_UNKNOWN: no gear passes that station.
 * The core's `reason` has the text. */
enum mr_status hil_faults_add(struct hil_faults_device *dev, const struct hil_fault *fault);
/* Adds all faults of a script and sets its seed. */
enum mr_status hil_faults_add_all(struct hil_faults_device *dev,
                                  const struct hil_fault_script *script);
/* Call at the end of a run: reports each fault that did not occur in a line to hil_options.log. */
void hil_faults_report_pending(const struct hil_faults_device *dev);

/* Call when a counted event has occurred; `device` is a struct hil_faults_device. */
void hil_faults_on_flash_operation(void *device);
void hil_faults_on_nor_operation(void *device);
void hil_faults_on_can_sent(void *device);

#endif
