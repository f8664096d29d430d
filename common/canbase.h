/* Several boards on one CAN bus: each board has a base, which is added to the identifiers of all
 * messages from and to the board. With base 0 the identifiers are those of the catalogue. A serial
 * link connects a single board and uses no base.
 *
 * Identifiers have 11 bits, and the mapping is one to one. An identifier of a different board or
 * device is mapped to a number beyond the catalogue; mapping this number back gives the original
 * identifier. */
#ifndef MATRIG_COMMON_CANBASE_H
#define MATRIG_COMMON_CANBASE_H

#include <stdint.h>

#include "common/catalogue.h"

#define MR_CAN_ID_MAX   0x7ffu /* largest 11-bit identifier */
/* largest base: MR_ID_CONFIG_WORD is the largest identifier of the catalogue */
#define MR_CAN_BASE_MAX (MR_CAN_ID_MAX - MR_ID_CONFIG_WORD)

/* These functions convert an identifier between the catalogue and the bus. */
static inline uint16_t mr_can_id_to_bus(uint16_t id, uint16_t base)
{
    return (uint16_t)((id + base) & MR_CAN_ID_MAX);
}
static inline uint16_t mr_can_id_from_bus(uint16_t id, uint16_t base)
{
    return (uint16_t)((id - base) & MR_CAN_ID_MAX);
}

#endif
