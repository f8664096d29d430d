/* The rig: turns the physical truth of a run into the signals on the board's pins.
 *
 * The board's type (hil/periph/options.h) assigns the pins; those named here are zg's.
 *
 * R is the 2.500 V reference: it supplies the transducers' drive and excites the bridges. VDDA
 * supplies the staircase and scales every code. Edges and excitation are times.
 *
 * Switches: each opens for good, fires a one-shot of 20 us on PA15, and adds its own step to the
 * staircase on PC4:
 *     V = (0.050 + sum over opened switches of step * 3.3/4096 * (1 - exp(-(t - t_open)/20 us)))
 *         * VDDA / 3.3,   step(p) = 64 + 8 * ((7 (p - 1)) mod 24) codes, p = 1..24
 * Gages 1..14 on PA0..PA7, PB0, PB1, PC0..PC3: V = (0.400 + 0.005 * (gain * (tension_lb + shunt_lb)
 * + offset_lb)) * R / 2.5, with a gain of 1 and no offset unless a fault makes them drift, shunt_lb
 * 40 while PE1 is high (its relay puts a resistor across an arm of every bridge), else 0. Reference
 * on PC5: R. Transducers 1..8 on PF3..PF10, excited by PD12 and PD13:
 *     V = (1.65 + a * (0.050 + 0.5 * displacement_in)) * R / 2.5,
 * where a is +1 while PD12 is high and PD13 low, -1 reversed, 0 while equal, and follows a change
 * exponentially with 4 us. An electrolytic transducer wants no direct component: the time at each
 * polarity is counted. All voltages are clipped to 0..VDDA by the converter. Pins that nothing is
 * connected to float at 0 V.
 *
 * A drawn board has its own gains, zeros, steps and times (hil/rig/electronics.h). The filter of a
 * gage is a delay by its time constant: truth is slow against it. */
#ifndef MATRIG_HIL_RIG_H
#define MATRIG_HIL_RIG_H

#include <stdbool.h>
#include <stdint.h>

#include "common/command.h"
#include "common/status.h"
#include "hil/periph/adc.h"
#include "hil/periph/gpio.h"
#include "hil/periph/options.h"
#include "hil/rig/runfile.h"

struct hil_can_device;
struct hil_core;
struct hil_electronics;
struct hil_usart_device;

#define HIL_RIG_SHUNT_LB 40.0

/* A contact that has moved: the staircase follows it from `level` (0 closed, 1 open) since then. */
struct hil_contact {
    bool moved, open, skipped;
    uint8_t bounces; /* openings still to come */
    double level;
    uint64_t since_ps;
    uint64_t period_ps; /* of its bouncing */
    uint64_t next_ps;   /* when it moves again; HIL_NEVER: it rests */
};

/* What was worked out of the transducers' settling: `rest` of a step is left after `taus`; 0:
 * nothing yet. */
#define HIL_SETTLINGS       32u
#define HIL_SETTLING_CYCLES 512u
struct hil_settling {
    double taus, rest;
};

enum hil_channel_fault {
    HIL_CHANNEL_GOOD,
    HIL_CHANNEL_STUCK,
    HIL_CHANNEL_HIGH,
    HIL_CHANNEL_LOW,
    HIL_CHANNEL_OPEN
};
enum hil_lamp { HIL_LAMP_GOOD, HIL_LAMP_BROKEN, HIL_LAMP_SHORTED };

struct hil_rig {
    struct hil_contact contact[24];
    uint8_t channel_fault[HIL_BOARD_CHANNELS]; /* enum hil_channel_fault */
    double held[HIL_BOARD_CHANNELS];           /* of a channel that sticks: inches, pounds, volts */
    double gain_drift[HIL_RUN_GAGES];          /* gain less 1 */
    double offset_lb[HIL_RUN_GAGES];
    bool shunted;
    bool shunt_wanted;      /* level of PE1 */
    uint8_t shunt_moves;    /* of the relay's contacts still to come */
    uint64_t shunt_next_ps; /* the next; HIL_NEVER: none */
    bool lamp_on;           /* what the lamp's read-back follows */
    uint64_t lamp_since_ps;
    uint8_t order[24];     /* switches (0..23) in the order in which they open */
    uint8_t order_count;   /* number of switches that open at all */
    uint8_t opened;        /* so many have */
    uint64_t pulse_end_ps; /* HIL_NEVER: the one-shot is low */
    uint8_t lamp;          /* enum hil_lamp */
    int8_t excitation;     /* +1, -1, 0 */
    double from;           /* amplitude when it last changed */
    uint64_t since_cycle;  /* when */
    uint64_t since_ps;
};

struct hil_rig_device {
    struct hil_core *core;
    struct hil_rig *state;
    struct hil_gpio_device *gpio;
    struct hil_adc_device *adc;
    const struct hil_board_type *type;
    const struct hil_electronics *electronics;
    bool bare;                 /* it is not plugged in */
    const struct hil_run *run; /* may be NULL: nothing moves */
    struct hil_pin lamp;
    struct hil_settling settling[HIL_SETTLINGS]; /* derived; worked out again when needed */
};

/* Connect it to the pins, the converters and the event queue; its device is filled in but for
 * `lamp` and `settling`. */
void hil_rig_create(struct hil_rig_device *dev);
/* Take the order of the switches from the run and schedule the first. */
void hil_rig_start(struct hil_rig_device *dev);
/* The excitation pins have these levels from cycle `at` on. */
void hil_rig_excitation(struct hil_rig_device *dev, bool pd12, bool pd13, uint64_t at);
/* Add the time since the last change to the counters of the excitation. */
void hil_rig_count_excitation(struct hil_rig_device *dev, uint64_t at);
/* Faults (hil/rig/faults.h): of a channel, of a switch that has not opened yet. */
void hil_rig_fail(struct hil_rig_device *dev, unsigned channel, enum hil_channel_fault fault);
/* A bridge or its amplifier drifts: gage from 0, gain 1 and offset 0 as it should be. */
void hil_rig_drift(struct hil_rig_device *dev, unsigned gage, double gain, double offset_lb);
void hil_rig_lamp(struct hil_rig_device *dev, enum hil_lamp lamp);
void hil_rig_skip(struct hil_rig_device *dev, unsigned position);
void hil_rig_bounce(struct hil_rig_device *dev, unsigned position, uint32_t times,
                    uint64_t period_ps);
/* Channel that the rig has on a pin, 0..23, or -1; `device` is a struct hil_rig_device. */
int hil_rig_channel(const void *device, unsigned port, unsigned pin);
/* Voltage of a channel at cycle `at`, not clipped (none, -1: 0 V); `device` is a struct
 * hil_rig_device. */
double hil_rig_channel_volts(void *device, int channel, uint64_t at);
/* The warning lamp draws current: PE0 low, or not driven (a pull on the rig), turns it on. PE3 is
 * low while it does. */
bool hil_rig_lamp_draws(const struct hil_rig_device *dev);

/* Scripted commands of a run file: at their virtual time they arrive at the board as a CAN frame or
 * as bytes on the serial line, exactly as from the host. */

struct hil_script {
    uint32_t next;     /* command of the run */
    uint16_t sequence; /* of serial frames sent */
};

struct hil_script_device {
    struct hil_core *core;
    struct hil_script *state;
    const struct hil_rig_device *rig; /* whose run it is */
    struct hil_can_device *can;
    struct hil_usart_device *usart;
};

/* A command for the board, put on one of its links as a host sends it.
 * `sequence`: the number of the next frame on serial. MR_OK; else too many wait for the board, and
 * the command is lost. */
enum mr_status hil_command_in(struct hil_can_device *can, struct hil_usart_device *usart,
                              uint16_t *sequence, const struct mr_command *message, bool serial);

void hil_script_create(struct hil_script_device *dev);
/* Begin the rig's run. */
void hil_script_start(struct hil_script_device *dev);

/* The film camera of the rig: a rising edge of its trigger on PE2 starts it, and from a delay on it
 * gives a pulse of 100 us on PB3 for each frame, at an even rate with jitter, until the power goes.
 * A trigger while it runs changes nothing. */

#define HIL_CAMERA_PULSE_PS 100000000ull

struct hil_camera {
    bool trigger; /* level of PE2 */
    bool running;
    bool pulse;          /* PB3 is high */
    uint64_t start_ps;   /* of the trigger */
    uint64_t next_frame; /* from 0 */
    uint64_t frame_ps;   /* its time */
    uint64_t low_ps;     /* when the pulse ends */
    uint64_t random;
    uint32_t skip; /* so many frames from now on give no pulse */
};

struct hil_camera_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_camera *state;
    struct hil_gpio_device *gpio;
};

/* Connect it to its pins and the event queue. */
void hil_camera_create(struct hil_camera_device *dev);
/* So many frames from now on give no pulse. */
void hil_camera_skip(struct hil_camera_device *dev, uint32_t frames);

#endif
