/* Facts of the board from firmware/boards/pins.def, and the register values that follow from
 * them. */
#ifndef MATRIG_FIRMWARE_F407_FACTS_H
#define MATRIG_FIRMWARE_F407_FACTS_H

#include "common/block.h"
#include "common/image.h"
#include "firmware/f407/regs.h"

enum {
#define FACT(NAME, value, text) BOARD_##NAME = (value),
#include "firmware/boards/pins.def"
};

/* Numbers of all channels, in the order of common/block.h. */
enum board_channel {
#define CHANNEL(n) BOARD_TRANSDUCER_##n
    CHANNEL(1),
    CHANNEL(2),
    CHANNEL(3),
    CHANNEL(4),
    CHANNEL(5),
    CHANNEL(6),
    CHANNEL(7),
    CHANNEL(8),
#undef CHANNEL
#define CHANNEL(n) BOARD_GAGE_##n
    CHANNEL(1),
    CHANNEL(2),
    CHANNEL(3),
    CHANNEL(4),
    CHANNEL(5),
    CHANNEL(6),
    CHANNEL(7),
    CHANNEL(8),
    CHANNEL(9),
    CHANNEL(10),
    CHANNEL(11),
    CHANNEL(12),
    CHANNEL(13),
    CHANNEL(14),
#undef CHANNEL
    BOARD_STAIRCASE,
    BOARD_REFERENCE,
    BOARD_CHANNELS
};
_Static_assert(BOARD_CHANNELS == MR_CHANNELS, "common/block.h's channels");

/* Bits of the channels that have an input. */
enum {
    BOARD_INPUTS = 0
#define ANALOGUE(port, pin, converter, input, SIGNAL, text) | 1 << BOARD_##SIGNAL
#include "firmware/boards/pins.def"
};
_Static_assert((BOARD_INPUTS >> BOARD_STAIRCASE & 3) == 3,
               "the staircase is always scanned, because the speed needs it");
_Static_assert(BOARD_SERIAL == 1 || BOARD_SERIAL == 6,
               "those of APB2, whose requests go to streams 2 and 7 of DMA2; RM0090 table 43");

#endif
