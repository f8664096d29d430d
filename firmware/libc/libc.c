/* C library functions of the image; the compiler inserts calls of the first four by itself. A
 * compiler flag in module.mk keeps gcc from replacing a loop here with a call of the function
 * itself. */
#include <math.h>
#include <stdint.h>
#include <string.h>

/* A word at any address; the core supports unaligned access. */
struct word {
    uint32_t value;
} __attribute__((packed, may_alias));

void *memcpy(void *restrict to, const void *restrict from, size_t length)
{
    uint8_t *out = to;
    const uint8_t *in = from;
    for (; length >= 16u; length -= 16u, out += 16, in += 16) {
        for (unsigned i = 0; i < 4u; i++)
            ((struct word *)out)[i].value = ((const struct word *)in)[i].value;
    }
    for (; length >= 4u; length -= 4u, out += 4, in += 4)
        ((struct word *)out)->value = ((const struct word *)in)->value;
    while (length--)
        *out++ = *in++;
    return to;
}

void *memmove(void *to, const void *from, size_t length)
{
    uint8_t *out = to;
    const uint8_t *in = from;
    if ((uintptr_t)out - (uintptr_t)in >=
        length) { /* copy upwards: each byte is read before it is overwritten */
        while (length--)
            *out++ = *in++;
        return to;
    }
    while (length--)
        out[length] = in[length];
    return to;
}

void *memset(void *to, int byte, size_t length)
{
    uint8_t *out = to;
    uint32_t word = 0x01010101u * (uint8_t)byte;
    for (; length >= 16u; length -= 16u, out += 16) {
        for (unsigned i = 0; i < 4u; i++)
            ((struct word *)out)[i].value = word;
    }
    while (length--)
        *out++ = (uint8_t)byte;
    return to;
}

int memcmp(const void *a, const void *b, size_t length)
{
    const uint8_t *x = a, *y = b;
    for (; length; length--, x++, y++) {
        if (*x != *y)
            return *x < *y ? -1 : 1;
    }
    return 0;
}

int strcmp(const char *a, const char *b)
{
    while (*a && *a == *b) {
        a++;
        b++;
    }
    return (uint8_t)*a - (uint8_t)*b;
}

char *strncpy(char *restrict to, const char *restrict from, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        to[i] = *from;
        from += *from != '\0';
    }
    return to;
}

#define FRACTION_BITS     52
#define BIAS              1023
#define INFINITE_EXPONENT (UINT64_C(0x7ff) << FRACTION_BITS)

/* Computes digit by digit: 53 bits of the root and one more. With the remainder they determine the
 * rounding. */
double sqrt(double x)
{
    union {
        double number;
        uint64_t bits;
    } v = {x};
    uint64_t left = v.bits, root = 0, sum = 0;
    if (left << 1 == 0 || left == INFINITE_EXPONENT)
        return x; /* 0 of either sign, or infinity */
    if (left >= INFINITE_EXPONENT)
        return x != x ? x : (double)NAN; /* NaN, or a negative number */
    int exponent = (int)(left >> FRACTION_BITS) - BIAS;
    if (exponent == -BIAS) { /* subnormal */
        int shift = __builtin_clzll(left) - (63 - FRACTION_BITS);
        left <<= shift;
        exponent = 1 - BIAS - shift;
    }
    left = (left & ((UINT64_C(1) << FRACTION_BITS) - 1u)) | UINT64_C(1) << FRACTION_BITS;
    if (exponent & 1) {
        left <<= 1;
        exponent--;
    }
    left <<= 1;
    for (uint64_t bit = UINT64_C(1) << (FRACTION_BITS + 1); bit; bit >>= 1, left <<= 1) {
        uint64_t next = sum + bit;
        if (next <= left) {
            left -= next;
            sum = next + bit;
            root += bit;
        }
    }
    /* there is no tie: the square of a 54-bit root would have 107 bits */
    root += left ? root & 1u : 0u;
    v.bits = (root >> 1) + ((uint64_t)(exponent / 2 + BIAS - 1) << FRACTION_BITS);
    return v.number;
}
