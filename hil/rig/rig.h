/* The rig converts the physical truth of a run into the signals on the board's pins.
 *
 * The board's type (hil/periph/options.h) assigns the pins; the pins named here are those of the
 * board zg.
 *
 * R is the 2.500 V reference, which supplies the drive of the transducers and excites the bridges.
 * VDDA supplies the staircase and scales every code. Edges and excitation depend only on time.
 *
 * Switches: each switch opens permanently, triggers a one-shot of 20 us on PA15, and adds its step
 * to the staircase on PC4:
 *     V = (0.050 + sum over opened switches of step * 3.3/4096 * (1 - exp(-(t - t_open)/20 us)))
 *         * VDDA / 3.3,   step(p) = 64 + 8 * ((7 (p - 1)) mod 24) codes, p = 1..24
 * Gages 1..14 on PA0..PA7, PB0, PB1, PC0..PC3: V = (0.400 + 0.005 * (gain * (tension_lb + shunt_lb)
 * + offset_lb)) * R / 2.5. Without a drift fault, gain is 1 and offset_lb is 0. shunt_lb is 40
 * while PE1 is high (its relay puts a resistor across an arm of every bridge), else 0. Reference on
 * PC5: R. Transducers 1..8 on PF3..PF10, excited by PD12 and PD13:
 *     V = (1.65 + a * (0.050 + 0.5 * displacement_in)) * R / 2.5,
 * where a is +1 while PD12 is high and PD13 low, -1 while reversed, and 0 while equal. After a
 * change, a settles exponentially with a time constant of 4 us. Electrolytic transducers must not
 * receive a direct component, so the time at each polarity is counted. The converter clips all
 * voltages to 0..VDDA. Unconnected pins float at 0 V.
 *
 * A drawn board has individual gains, zeros, steps and times (hil/rig/electronics.h). The filter of
 * a gage is modelled as a delay by its time constant, because the truth changes slowly in
 * comparison. */
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

#define HIL_RIG_SHUNT_LB   40.0
#define HIL_TRAIN_PULSE_PS 100000000ull /* width of the pulses of camera, brake and wheel: 100 us */

/* A contact that may bounce. Its contribution to the staircase follows its last movement, which
 * began at moved_ps from the level `start_level` (0 closed, 1 open). */
struct hil_contact {
    bool has_moved, is_open, is_skipped;
    uint8_t remaining_bounces; /* number of openings that remain */
    double start_level;
    uint64_t moved_ps;
    uint64_t bounce_period_ps; /* period of the bouncing */
    uint64_t next_move_ps;     /* time of the next movement; HIL_NEVER: at rest */
};

/* Cache for the settling of the transducers: after `taus` time constants, `remaining_share` of a
 * step remains; taus 0: empty entry. */
#define HIL_SETTLING_CACHE_SIZE 32u
#define HIL_SETTLING_CYCLES     512u
struct hil_settling {
    double taus, remaining_share;
};

enum hil_channel_fault {
    HIL_CHANNEL_GOOD,
    HIL_CHANNEL_STUCK,
    HIL_CHANNEL_HIGH,
    HIL_CHANNEL_LOW,
    HIL_CHANNEL_OPEN
};
enum hil_lamp_fault { HIL_LAMP_GOOD, HIL_LAMP_BROKEN, HIL_LAMP_SHORTED };

struct hil_rig {
    struct hil_contact contact[24];
    /* pulses of brake and wheel on PB10 and PB11 */
    struct hil_pulse_train_state pulse_train[HIL_RUN_TRAINS];
    uint8_t channel_fault[HIL_BOARD_CHANNELS]; /* enum hil_channel_fault */
    double stuck_value[HIL_BOARD_CHANNELS];    /* value of a stuck channel: inches, pounds, volts */
    double gain_drift[HIL_RUN_GAGES];          /* gain minus 1 */
    double offset_drift_lb[HIL_RUN_GAGES];
    bool are_shunts_on;
    bool is_shunt_requested;       /* level of PE1 */
    uint8_t remaining_shunt_moves; /* number of movements of the relay's contacts that remain */
    uint64_t next_shunt_move_ps;   /* time of the next movement; HIL_NEVER: none */
    bool is_lamp_on;               /* state that the lamp's read-back follows */
    uint64_t lamp_changed_ps;
    uint8_t opening_order[24];         /* switches (0..23) in the order in which they open */
    uint8_t opening_count;             /* number of switches that open in the run */
    uint8_t opened_count;              /* number of switches that have opened */
    uint64_t one_shot_end_ps;          /* HIL_NEVER: the one-shot is low */
    uint8_t lamp_fault;                /* enum hil_lamp_fault */
    int8_t excitation;                 /* polarity of the excitation: +1, -1, 0 */
    double excitation_start_amplitude; /* amplitude of the excitation at its last change */
    uint64_t excitation_changed_cycle; /* cycle of the last change of the excitation */
    uint64_t excitation_changed_ps;
};

struct hil_rig_device {
    struct hil_core *core;
    struct hil_rig *state;
    struct hil_gpio_device *gpio;
    struct hil_adc_device *adc;
    const struct hil_board_type *type;
    const struct hil_electronics *electronics;
    bool has_no_rig;
    const struct hil_run *run; /* run whose values are applied; NULL: nothing moves */
    struct hil_pin lamp_sense_pin;
    /* derived from other members when needed */
    struct hil_settling settling[HIL_SETTLING_CACHE_SIZE];
};

/* Connects the rig to the pins, the converters and the event queue. The caller must have set all
 * members of `dev` except `lamp` and `settling`. */
void hil_rig_create(struct hil_rig_device *dev);
/* Determines from the run in which order the switches open, and schedules the first one. */
void hil_rig_start(struct hil_rig_device *dev);
/* Call when the excitation pins change: they have these levels from cycle `at` on. */
void hil_rig_set_excitation(struct hil_rig_device *dev, bool pd12, bool pd13, uint64_t at);
/* Adds the time since the last change to the counters of the excitation. */
void hil_rig_count_excitation(struct hil_rig_device *dev, uint64_t at);
/* Faults (hil/rig/faults.h). hil_rig_set_channel_fault sets the fault of a channel;
 * hil_rig_skip_switch and hil_rig_bounce_switch apply to a switch that has not opened yet. */
void hil_rig_set_channel_fault(struct hil_rig_device *dev, unsigned channel,
                               enum hil_channel_fault fault);
/* Sets the drift of a bridge or its amplifier. Gages count from 0; without drift, gain is 1 and
 * offset_lb is 0. */
void hil_rig_set_gage_drift(struct hil_rig_device *dev, unsigned gage, double gain,
                            double offset_lb);
void hil_rig_set_lamp_fault(struct hil_rig_device *dev, enum hil_lamp_fault lamp);
void hil_rig_skip_switch(struct hil_rig_device *dev, unsigned position);
void hil_rig_bounce_switch(struct hil_rig_device *dev, unsigned position, uint32_t times,
                           uint64_t period_ps);
/* Channel of the rig on a pin, 0..23, or -1; `device` is a struct hil_rig_device. */
int hil_rig_find_channel(const void *device, unsigned port, unsigned pin);
/* Voltage of a channel at cycle `at`, not clipped; 0 V for channel -1. `device` is a struct
 * hil_rig_device. */
double hil_rig_channel_volts(void *device, int channel, uint64_t at);
/* True if the warning lamp draws current. PE0 low, or not driven (the rig has a pull resistor),
 * turns the lamp on. PE3 is low while the lamp draws current. */
bool hil_rig_has_lamp_current(const struct hil_rig_device *dev);

/* Scripted commands of a run file. They arrive at the board at their virtual time, as CAN frames or
 * as bytes on the serial line, exactly as commands from a host do. */

struct hil_command_script {
    uint32_t next_command; /* next command of the run */
    uint16_t sequence;     /* sequence number of the next serial frame */
};

struct hil_command_script_device {
    struct hil_core *core;
    struct hil_command_script *state;
    const struct hil_rig_device *rig; /* provides the run */
    struct hil_can_device *can;
    struct hil_usart_device *usart;
};

/* Sends a command to the board on one of its links, as a host would. `sequence`: number of the next
 * frame on serial. Any status except MR_OK means that too many commands are waiting and that this
 * one is lost. */
enum mr_status hil_command_send(struct hil_can_device *can, struct hil_usart_device *usart,
                                uint16_t *sequence, const struct mr_command *message, bool serial);

void hil_command_script_create(struct hil_command_script_device *dev);
/* Schedules the first command of the rig's run. */
void hil_command_script_start(struct hil_command_script_device *dev);

/* The film camera of the rig. A rising edge on PE2 triggers it. After a delay it gives a pulse of
 * 100 us on PB3 for each frame, at a constant rate with jitter, until the power fails. A trigger
 * while the camera runs has no effect. */

struct hil_camera {
    bool is_trigger_high; /* level of PE2 */
    bool is_running;
    bool is_pulse_high;     /* PB3 is high */
    uint64_t trigger_ps;    /* time of the trigger */
    uint64_t next_frame;    /* number of the next frame, from 0 */
    uint64_t next_frame_ps; /* time of the next frame */
    uint64_t pulse_end_ps;  /* end of the pulse */
    uint64_t random_state;
    uint32_t frames_to_skip; /* number of frames from now on that give no pulse */
};

struct hil_camera_device {
    struct hil_core *core;
    const struct hil_options *options;
    struct hil_camera *state;
    struct hil_gpio_device *gpio;
};

/* Connects the camera to its pins and the event queue. */
void hil_camera_create(struct hil_camera_device *dev);
/* The next `frames` frames give no pulse. */
void hil_camera_skip_frames(struct hil_camera_device *dev, uint32_t frames);

#endif
