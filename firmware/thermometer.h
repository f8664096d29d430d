/* Mat temperature from a TMP112 (data sheet SBOS473) at address 0x48. One conversion per second is
 * started by command ("one-shot"), so that each reading is current and self-heating of the chip is
 * small.
 *
 * One step is executed per block; a reading takes about 80 blocks, at most 250 with any fault. A
 * failure is counted (MR_FAULT_THERMOMETER), and the reading is tried again in the next second. If
 * the thermometer is not fitted (site.thermometer 0), the bus has no clock and no pins. */
#ifndef MATRIG_FIRMWARE_THERMOMETER_H
#define MATRIG_FIRMWARE_THERMOMETER_H

#include <stdbool.h>
#include <stdint.h>

#define THERMOMETER_ADDRESS           0x48u
#define THERMOMETER_CONVERSION_BLOCKS 40u /* blocks; a conversion takes at most 35 ms */

enum thermometer_fault {
    THERMOMETER_NO_ANSWER = 1,
    THERMOMETER_BUS_STUCK = 2,
    THERMOMETER_OUT_OF_RANGE = 3
};

struct thermometer {
    bool is_on;        /* the bus has been started */
    bool is_shut_down; /* the chip is in shutdown mode and converts only by command */
    unsigned step;
    uint32_t step_block; /* block in which the step began */
    uint8_t tx_bytes[3], rx_bytes[2];
    float temperature_c;      /* reading of this second; NaN: none */
    float error_c;            /* standard error of the reading; NaN: none */
    float last_temperature_c; /* newest reading sent, of this or the previous second; NaN: none */
};

void thermometer_start(struct thermometer *thermometer);
/* Call in each block. Returns true once per second, when the reading is to be sent. */
bool thermometer_on_block(struct thermometer *thermometer, uint32_t index, bool fitted);
/* Temperature in C from the temperature register, upper byte first: 12 bits, two's complement,
 * left-justified, 0.0625 C per count. */
float thermometer_celsius(const uint8_t bytes[2]);

#endif
