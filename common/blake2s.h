/* Keyed BLAKE2s (RFC 7693): a message authentication code of one contiguous buffer.
 *
 * The output length is an input of the hash: an output of 8 bytes is not the first 8 bytes of an
 * output of 32. Pure function; uses 400 bytes of stack. */
#ifndef MATRIG_COMMON_BLAKE2S_H
#define MATRIG_COMMON_BLAKE2S_H

#include <stddef.h>
#include <stdint.h>

#define MR_BLAKE2S_BYTES_MAX 32u /* maximum bytes of an output and of a key */

/* Computes the hash. `out_length`: 1 to 32; `key_length`: 0 (no key) to 32; `length`: below 2^32 -
 * 64. */
void mr_blake2s(uint8_t *out, size_t out_length, const uint8_t *key, size_t key_length,
                const uint8_t *bytes, size_t length);

#endif
