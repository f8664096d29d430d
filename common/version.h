/* The version of all parts of matrig. The message `hello`, the header of the firmware image
 * (common/image.h), the programs and the packages contain it. */
#ifndef MATRIG_COMMON_VERSION_H
#define MATRIG_COMMON_VERSION_H

#define FIRMWARE_MAJOR 0
#define FIRMWARE_MINOR 2
#define FIRMWARE_PATCH 0

#define VERSION_JOIN_(a, b, c) #a "." #b "." #c
#define VERSION_JOIN(a, b, c)  VERSION_JOIN_(a, b, c)
/* for example "1.2.3" */
#define VERSION_TEXT           VERSION_JOIN(FIRMWARE_MAJOR, FIRMWARE_MINOR, FIRMWARE_PATCH)

#endif
