/* CRC-32 of IEEE 802.3 (reflected polynomial 0xEDB88320, initial and final inversion), as in zlib,
 * PNG and Ethernet. Check value: the nine bytes "123456789" give 0xCBF43926. */
#ifndef MATRIG_COMMON_CRC32_H
#define MATRIG_COMMON_CRC32_H

#include <stddef.h>
#include <stdint.h>

/* Extends `crc`, the CRC of the preceding data (0 to start), by `length` bytes and returns it. Uses
 * a table of 64 bytes; about 12 cycles per byte. */
uint32_t mr_crc32(uint32_t crc, const uint8_t *bytes, size_t length);

#endif
