#include "common/blake2s.h"

#include <string.h>

#include "common/wire.h"

#define BLOCK_BYTES 64u
#define ROUNDS      10u

/* first 32 bits of the fractional parts of the square roots of 2, 3, 5 ... 19 (RFC 7693 2.6) */
static const uint32_t initial_state[8] = {0x6a09e667u, 0xbb67ae85u, 0x3c6ef372u, 0xa54ff53au,
                                          0x510e527fu, 0x9b05688cu, 0x1f83d9abu, 0x5be0cd19u};

/* order of the message words in each round (RFC 7693 2.7) */
static const uint8_t sigma[ROUNDS][16] = {{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15},
                                          {14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3},
                                          {11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4},
                                          {7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8},
                                          {9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13},
                                          {2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9},
                                          {12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11},
                                          {13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10},
                                          {6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5},
                                          {10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0}};

/* words of `v` in each of the eight mixings of a round: columns, then diagonals */
static const uint8_t mixed_words[8][4] = {{0, 4, 8, 12},  {1, 5, 9, 13},  {2, 6, 10, 14},
                                          {3, 7, 11, 15}, {0, 5, 10, 15}, {1, 6, 11, 12},
                                          {2, 7, 8, 13},  {3, 4, 9, 14}};

static uint32_t rotate_right(uint32_t word, unsigned bits)
{
    return word >> bits | word << (32u - bits);
}

/* Compresses one block (RFC 7693 3.2). `counted`: number of bytes so far, including this block. */
static void compress(uint32_t h[8], const uint8_t block[BLOCK_BYTES], uint32_t counted,
                     uint32_t last)
{
    uint32_t m[16], v[16];
    const uint8_t *p = block;
    for (unsigned i = 0; i < 16; i++)
        m[i] = mr_get_u32(&p);
    memcpy(v, h, 8 * sizeof *v);
    memcpy(v + 8, initial_state, sizeof initial_state);
    v[12] ^= counted;
    v[14] ^= last;
    for (unsigned round = 0; round < ROUNDS; round++) {
        for (unsigned i = 0; i < 8; i++) {
            uint32_t *a = &v[mixed_words[i][0]], *b = &v[mixed_words[i][1]],
                     *c = &v[mixed_words[i][2]], *d = &v[mixed_words[i][3]];
            *a += *b + m[sigma[round][2 * i]];
            *d = rotate_right(*d ^ *a, 16);
            *c += *d;
            *b = rotate_right(*b ^ *c, 12);
            *a += *b + m[sigma[round][2 * i + 1]];
            *d = rotate_right(*d ^ *a, 8);
            *c += *d;
            *b = rotate_right(*b ^ *c, 7);
        }
    }
    for (unsigned i = 0; i < 8; i++)
        h[i] ^= v[i] ^ v[i + 8];
}

void mr_blake2s(uint8_t *out, size_t out_length, const uint8_t *key, size_t key_length,
                const uint8_t *bytes, size_t length)
{
    uint32_t h[8], counted = 0;
    uint8_t block[BLOCK_BYTES] = {0};
    memcpy(h, initial_state, sizeof h);
    h[0] ^= 0x01010000u ^ (uint32_t)key_length << 8 ^ (uint32_t)out_length;
    if (key_length) { /* the key is a block of its own before the message */
        memcpy(block, key, key_length);
        counted = BLOCK_BYTES;
        compress(h, block, counted, length ? 0 : UINT32_MAX);
    }
    bool done = key_length && !length;
    while (!done) {
        size_t n = length < BLOCK_BYTES ? length : BLOCK_BYTES;
        done = length <= BLOCK_BYTES;
        memset(block, 0, sizeof block);
        if (n)
            memcpy(block, bytes, n);
        counted += (uint32_t)n;
        compress(h, block, counted, done ? UINT32_MAX : 0);
        bytes += n;
        length -= n;
    }
    for (size_t i = 0; i < out_length; i++)
        out[i] = (uint8_t)(h[i / 4] >> 8 * (i % 4));
}
