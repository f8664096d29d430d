/* Byte order of everything that matrig sends or stores: little-endian, written and read byte by
 * byte, never as a packed struct.
 *
 * A put function writes its bytes and returns the first byte after them; a get function reads its
 * bytes and advances the caller's pointer. These functions do not check lengths: the code of the
 * catalogue checks the length of a message before reading it.
 *
 * A real quantity is sent as an integer with `counts_per_unit` counts per unit, rounded to nearest
 * and clipped to the range. One code of each type means "missing" and corresponds to NaN on both
 * sides. */
#ifndef MATRIG_COMMON_WIRE_H
#define MATRIG_COMMON_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define MR_NAN (__builtin_nanf(""))

/* Always inlined, because compilers then combine four bytes into a single load or store, which is
 * shorter than a call. */
#define WIRE_INLINE static inline __attribute__((always_inline))

WIRE_INLINE uint8_t *mr_put_u8(uint8_t *p, uint8_t v)
{
    *p = v;
    return p + 1;
}
WIRE_INLINE uint8_t *mr_put_i8(uint8_t *p, int8_t v)
{
    *p = (uint8_t)v;
    return p + 1;
}
WIRE_INLINE uint8_t *mr_put_u16(uint8_t *p, uint16_t v)
{
    p[0] = (uint8_t)v;
    p[1] = (uint8_t)(v >> 8);
    return p + 2;
}
WIRE_INLINE uint8_t *mr_put_i16(uint8_t *p, int16_t v)
{
    return mr_put_u16(p, (uint16_t)v);
}
WIRE_INLINE uint8_t *mr_put_u32(uint8_t *p, uint32_t v)
{
    return mr_put_u16(mr_put_u16(p, (uint16_t)v), (uint16_t)(v >> 16));
}
WIRE_INLINE uint8_t *mr_put_i32(uint8_t *p, int32_t v)
{
    return mr_put_u32(p, (uint32_t)v);
}
WIRE_INLINE uint8_t *mr_put_f32(uint8_t *p, float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return mr_put_u32(p, bits);
}

WIRE_INLINE uint8_t mr_get_u8(const uint8_t **p)
{
    return *(*p)++;
}
WIRE_INLINE int8_t mr_get_i8(const uint8_t **p)
{
    return (int8_t) * (*p)++;
}
WIRE_INLINE uint16_t mr_get_u16(const uint8_t **p)
{
    uint16_t v = (uint16_t)((*p)[0] | (*p)[1] << 8);
    *p += 2;
    return v;
}
WIRE_INLINE int16_t mr_get_i16(const uint8_t **p)
{
    return (int16_t)mr_get_u16(p);
}
WIRE_INLINE uint32_t mr_get_u32(const uint8_t **p)
{
    uint32_t low = mr_get_u16(p);
    return low | (uint32_t)mr_get_u16(p) << 16;
}
WIRE_INLINE int32_t mr_get_i32(const uint8_t **p)
{
    return (int32_t)mr_get_u32(p);
}
WIRE_INLINE float mr_get_f32(const uint8_t **p)
{
    uint32_t bits = mr_get_u32(p);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

#define MR_MISSING_U16 0xffffu
#define MR_MISSING_I16 (-32768)

/* Real quantities with `counts_per_unit` counts per unit; NaN is sent as MR_MISSING_*. */
static inline uint8_t *mr_put_real_u16(uint8_t *p, float value, float counts_per_unit)
{
    float counts = value * counts_per_unit + 0.5f;
    if (__builtin_isnan(value))
        return mr_put_u16(p, MR_MISSING_U16);
    if (counts < 0.0f)
        return mr_put_u16(p, 0);
    return mr_put_u16(p, counts > 65534.0f ? 65534u : (uint16_t)counts);
}
static inline float mr_get_real_u16(const uint8_t **p, float counts_per_unit)
{
    uint16_t counts = mr_get_u16(p);
    return counts == MR_MISSING_U16 ? MR_NAN : (float)counts / counts_per_unit;
}
static inline uint8_t *mr_put_real_i16(uint8_t *p, float value, float counts_per_unit)
{
    float counts = value * counts_per_unit;
    counts += counts < 0.0f ? -0.5f : 0.5f;
    if (__builtin_isnan(value))
        return mr_put_i16(p, MR_MISSING_I16);
    if (counts < -32767.0f)
        return mr_put_i16(p, -32767);
    return mr_put_i16(p, counts > 32767.0f ? 32767 : (int16_t)counts);
}
static inline float mr_get_real_i16(const uint8_t **p, float counts_per_unit)
{
    int16_t counts = mr_get_i16(p);
    return counts == MR_MISSING_I16 ? MR_NAN : (float)counts / counts_per_unit;
}

/* True for erased memory (all ones). */
static inline bool mr_is_blank(const uint8_t *bytes, size_t n)
{
    uint32_t all = UINT32_MAX;
    for (; n >= 4; n -= 4)
        all &= mr_get_u32(&bytes);
    for (; n; n--)
        all &= 0xffffff00u | *bytes++;
    return all == UINT32_MAX;
}

#endif
