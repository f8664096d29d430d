/* Several boards on one CAN bus: each has a base that is added to the identifiers of all its
 * messages, those to it too. Base 0: identifiers are those of the catalogue. Serial has one board
 * at its end, and no base.
 *
 * Identifiers are of 11 bits, and both ways are one to one: what is not the board's comes out
 * beyond the catalogue, and goes back to what it was. */
#ifndef MATRIG_COMMON_CANBASE_H
#define MATRIG_COMMON_CANBASE_H

#include <stdint.h>

#include "common/catalogue.h"

#define MR_CAN_ID_MOST   0x7ffu                               /* of 11 bits */
#define MR_CAN_BASE_MOST (MR_CAN_ID_MOST - MR_ID_CONFIG_WORD) /* the last of the catalogue */

/* The identifier on the bus of a message of the catalogue, and back. */
static inline uint16_t mr_can_to_bus(uint16_t id, uint16_t base)
{
    return (uint16_t)((id + base) & MR_CAN_ID_MOST);
}
static inline uint16_t mr_can_from_bus(uint16_t id, uint16_t base)
{
    return (uint16_t)((id - base) & MR_CAN_ID_MOST);
}

#endif
