/* Mat temperature from a TMP112 (data sheet SBOS473) at address 0x48: one conversion a second,
 * begun by command ("one-shot"), so that each reading is this second's and the chip does not warm
 * itself.
 *
 * Every step is taken on a block; a reading takes some 80 of them, whatever is wrong 250 at most.
 * What fails is counted (MR_FAULT_THERMOMETER) and tried again in the next second. Not fitted
 * (site.thermometer 0): the bus has no clock and no pins. */
#ifndef MATRIG_FIRMWARE_THERMOMETER_H
#define MATRIG_FIRMWARE_THERMOMETER_H

#include <stdbool.h>
#include <stdint.h>

#define THERMOMETER_ADDRESS    0x48u
#define THERMOMETER_CONVERSION 40u /* blocks; 35 ms at most */

enum thermometer_fault {
    THERMOMETER_NO_ANSWER = 1,
    THERMOMETER_BUS_STUCK = 2,
    THERMOMETER_OUT_OF_RANGE = 3
};

struct thermometer {
    bool on;        /* the bus has been started */
    bool shut_down; /* the chip converts only when asked */
    unsigned step;
    uint32_t since; /* block in which the step began */
    uint8_t out[3], in[2];
    float temperature_c; /* of this second; NaN: none */
    float error_c;       /* its standard error; NaN likewise */
    float last_c;        /* of the newest reading sent, or NaN: of this second or the last */
};

void thermometer_start(struct thermometer *thermometer);
/* A block. Returns true once a second, when the reading is to be sent. */
bool thermometer_block(struct thermometer *thermometer, uint32_t index, bool fitted);
/* Degrees of the temperature register, the upper byte first: 12 bits, two's complement,
 * left-justified, 0.0625 C each. */
float thermometer_celsius(const uint8_t bytes[2]);

#endif
