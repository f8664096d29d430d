/* The message catalogue as a Vector DBC file, for tools that decode CAN. */
#ifndef MATRIG_HOST_DBC_H
#define MATRIG_HOST_DBC_H

#include <stdio.h>

/* Writes the whole file; the caller checks the stream. Returns the number of messages. */
unsigned dbc_write(FILE *out);

#endif
