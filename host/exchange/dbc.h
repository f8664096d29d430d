/* The message catalogue as a Vector DBC file, for tools that decode CAN. */
#ifndef MATRIG_HOST_EXCHANGE_DBC_H
#define MATRIG_HOST_EXCHANGE_DBC_H

#include <stdint.h>
#include <stdio.h>

/* Writes the whole file, of a board with this base on its bus (common/canbase.h); the caller checks
 * the stream. Returns the number of messages. */
unsigned dbc_write(FILE *out, uint16_t base);

#endif
