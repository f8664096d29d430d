/* Version of the firmware, told in the message hello. */
#ifndef MATRIG_COMMON_VERSION_H
#define MATRIG_COMMON_VERSION_H

#define FIRMWARE_MAJOR 0
#define FIRMWARE_MINOR 1
#define FIRMWARE_PATCH 0

#endif
