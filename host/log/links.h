/* The links of matrig log by number, and whose they are. Link 0 is the CAN bus, which all boards
 * share; link 1 + b is the serial line of board b. Of one board a link's number is its enum
 * link_kind. */
#ifndef MATRIG_HOST_LOG_LINKS_H
#define MATRIG_HOST_LOG_LINKS_H

#include "host/link/link.h"

#define LOGGER_BOARDS LINK_BOARDS
#define LOGGER_LINKS  (1u + LOGGER_BOARDS)

static inline enum link_kind logger_kind(unsigned link)
{
    return link == 0 ? LINK_CAN : LINK_SERIAL;
}

#endif
