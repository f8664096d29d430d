/* BLAKE2s with a key (RFC 7693): a message authentication code over bytes that are all there.
 *
 * The output's length is part of the computation: 8 bytes are not the first 8 of 32. Pure; 400
 * bytes of stack. */
#ifndef MATRIG_COMMON_BLAKE2S_H
#define MATRIG_COMMON_BLAKE2S_H

#include <stddef.h>
#include <stdint.h>

#define MR_BLAKE2S_MOST 32u /* bytes of an output, and of a key */

/* `out_length` 1 to 32, `key_length` 0 (no key) to 32, `length` below 2^32 - 64. */
void mr_blake2s(uint8_t *out, size_t out_length, const uint8_t *key, size_t key_length,
                const uint8_t *bytes, size_t length);

#endif
