#include "common/slowrow.h"

#include <stdbool.h>

#include "common/crc32.h"
#include "common/wire.h"

#define IN_COUNTS          10000.0f
#define LB_COUNTS          50.0f
#define C_COUNTS           16.0f
#define CRC_AT             (MR_SLOWROW - 4u)
#define PER_PART           3u
#define FIRST_DISPLACEMENT 2u /* parts */
#define FIRST_TENSION      (FIRST_DISPLACEMENT + (MR_TRANSDUCERS + PER_PART - 1u) / PER_PART)
_Static_assert(FIRST_TENSION + (MR_GAGES + PER_PART - 1u) / PER_PART == MR_SLOWROW_PARTS,
               "parts of a row");
_Static_assert(4 + 4 + 4 + 2 + 2 * MR_TRANSDUCERS + 2 * MR_GAGES + 2 == CRC_AT, "bytes of a row");

void mr_slowrow_put(const struct mr_slowrow *row, uint8_t bytes[MR_SLOWROW])
{
    uint8_t *p = mr_put_u32(mr_put_u32(mr_put_u32(bytes, row->seq), row->block), row->faults);
    p = mr_put_real_i16(p, row->temperature_c, C_COUNTS);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        p = mr_put_real_i16(p, row->displacement_in[i], IN_COUNTS);
    for (unsigned i = 0; i < MR_GAGES; i++)
        p = mr_put_real_i16(p, row->tension_lb[i], LB_COUNTS);
    p = mr_put_u8(mr_put_u8(p, row->boot), row->state);
    mr_put_u32(p, mr_crc32(0, bytes, CRC_AT));
}

enum mr_status mr_slowrow_get(struct mr_slowrow *row, const uint8_t bytes[MR_SLOWROW])
{
    const uint8_t *p = bytes, *crc = bytes + CRC_AT;
    size_t i = 0;
    while (i < MR_SLOWROW && bytes[i] == 0xff)
        i++;
    if (i == MR_SLOWROW)
        return MR_TOO_FEW;
    if (mr_get_u32(&crc) != mr_crc32(0, bytes, CRC_AT))
        return MR_CRC;
    row->seq = mr_get_u32(&p);
    row->block = mr_get_u32(&p);
    row->faults = mr_get_u32(&p);
    row->temperature_c = mr_get_real_i16(&p, C_COUNTS);
    for (i = 0; i < MR_TRANSDUCERS; i++)
        row->displacement_in[i] = mr_get_real_i16(&p, IN_COUNTS);
    for (i = 0; i < MR_GAGES; i++)
        row->tension_lb[i] = mr_get_real_i16(&p, LB_COUNTS);
    row->boot = mr_get_u8(&p);
    row->state = mr_get_u8(&p);
    return MR_OK;
}

static float value_at(const float *values, unsigned count, unsigned i)
{
    return i < count ? values[i] : MR_NAN;
}

size_t mr_slowrow_part(const struct mr_slowrow *row, unsigned part, uint16_t *id,
                       uint8_t payload[MR_MESSAGE_MAX])
{
    uint8_t seq8 = (uint8_t)row->seq;
    if (part == 0) {
        *id = MR_ID_SLOW_ROW;
        return mr_slow_row_put(&(struct mr_slow_row){row->seq, row->block}, payload);
    }
    if (part == 1) {
        *id = MR_ID_SLOW_STATE;
        return mr_slow_state_put(
            &(struct mr_slow_state){row->faults, row->temperature_c, row->boot, row->state},
            payload);
    }
    bool tension = part >= FIRST_TENSION;
    const float *values = tension ? row->tension_lb : row->displacement_in;
    unsigned count = tension ? MR_GAGES : MR_TRANSDUCERS;
    unsigned i = PER_PART * (part - (tension ? FIRST_TENSION : FIRST_DISPLACEMENT));
    float a = value_at(values, count, i), b = value_at(values, count, i + 1),
          c = value_at(values, count, i + 2);
    *id = tension ? MR_ID_SLOW_TENSION : MR_ID_SLOW_DISPLACEMENT;
    if (tension)
        return mr_slow_tension_put(&(struct mr_slow_tension){seq8, (uint8_t)(i + 1), a, b, c},
                                   payload);
    return mr_slow_displacement_put(&(struct mr_slow_displacement){seq8, (uint8_t)(i + 1), a, b, c},
                                    payload);
}

static void take_values(float *values, unsigned count, unsigned first, const float part[PER_PART])
{
    for (unsigned k = 0; k < PER_PART && first + k < count; k++)
        values[first + k] = part[k];
}

/* Whether part reader->parts is this one; its values are taken. */
static bool follows(struct mr_slowrow_reader *reader, uint16_t id, const uint8_t *payload,
                    size_t length)
{
    struct mr_slowrow *row = &reader->row;
    unsigned part = reader->parts;
    struct mr_slow_state state;
    struct mr_slow_displacement d;
    struct mr_slow_tension t;
    if (part == 1 && id == MR_ID_SLOW_STATE &&
        mr_slow_state_get(&state, payload, length) == MR_OK) {
        row->faults = state.faults;
        row->temperature_c = state.temperature_c;
        row->boot = state.boot;
        row->state = state.state;
        return true;
    }
    unsigned i = PER_PART * (part - FIRST_DISPLACEMENT);
    if (part >= FIRST_DISPLACEMENT && part < FIRST_TENSION && id == MR_ID_SLOW_DISPLACEMENT &&
        mr_slow_displacement_get(&d, payload, length) == MR_OK && d.seq8 == (uint8_t)row->seq &&
        d.first == i + 1) {
        take_values(row->displacement_in, MR_TRANSDUCERS, i, (float[]){d.a_in, d.b_in, d.c_in});
        return true;
    }
    i = PER_PART * (part - FIRST_TENSION);
    if (part >= FIRST_TENSION && id == MR_ID_SLOW_TENSION &&
        mr_slow_tension_get(&t, payload, length) == MR_OK && t.seq8 == (uint8_t)row->seq &&
        t.first == i + 1) {
        take_values(row->tension_lb, MR_GAGES, i, (float[]){t.a_lb, t.b_lb, t.c_lb});
        return true;
    }
    return false;
}

enum mr_status mr_slowrow_take(struct mr_slowrow_reader *reader, uint16_t id,
                               const uint8_t *payload, size_t length)
{
    struct mr_slow_row begin;
    if (id == MR_ID_SLOW_ROW && mr_slow_row_get(&begin, payload, length) == MR_OK) {
        *reader = (struct mr_slowrow_reader){.row = {.seq = begin.seq, .block = begin.block},
                                             .parts = 1};
        return MR_TOO_FEW;
    }
    if (id != MR_ID_SLOW_STATE && id != MR_ID_SLOW_DISPLACEMENT && id != MR_ID_SLOW_TENSION)
        return MR_UNKNOWN;
    if (!reader->parts || !follows(reader, id, payload, length)) {
        reader->parts = 0;
        return MR_UNKNOWN;
    }
    if (++reader->parts < MR_SLOWROW_PARTS)
        return MR_TOO_FEW;
    reader->parts = 0;
    return MR_OK;
}
