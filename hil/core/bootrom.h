/* System memory: the program in hil/rom/bootrom.c, which answers AN3155 on USART1, as bytes at
 * 0x1FFF0000. */
#ifndef MATRIG_HIL_BOOTROM_H
#define MATRIG_HIL_BOOTROM_H

#include <stdint.h>

#define HIL_ROM_BASE    0x1fff0000u
#define HIL_ROM_SIZE    0x00007000u
#define HIL_ROM_VERSION 0x31u /* of the protocol; shown at 0x1FFF77DE too (AN2606) */

/* HIL_ROM_SIZE bytes, page-aligned. */
extern const uint8_t hil_bootrom_image[];

#endif
