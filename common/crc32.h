/* CRC-32 (IEEE 802.3: reflected 0xEDB88320, start and final inversion), the one that zlib, PNG and
 * Ethernet use. Check value: the nine bytes "123456789" give 0xCBF43926. */
#ifndef MATRIG_COMMON_CRC32_H
#define MATRIG_COMMON_CRC32_H

#include <stddef.h>
#include <stdint.h>

/* CRC of `length` bytes that follow data whose CRC is `crc` (0 to start). 64-byte table, about 12
 * cycles a byte. */
uint32_t mr_crc32(uint32_t crc, const uint8_t *bytes, size_t length);

#endif
