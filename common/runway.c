#include "common/runway.h"

#include <string.h>

#include "common/crc32.h"
#include "common/wire.h"

#define MAGIC 0x5752524du /* "MRRW" */

static void put_fields(const struct mr_predictor_state *state, uint8_t *p)
{
    p = mr_put_u16(mr_put_u16(p, state->mats), state->landing_count);
    p = mr_put_f32(p, state->resistance_scale);
    for (unsigned j = 0; j < MR_RUNWAY_JOINTS; j++)
        p = mr_put_u16(p, state->gap_counts[j]);
}

void mr_runway_encode(const struct mr_predictor_state *state, uint32_t sequence, uint8_t *image)
{
    mr_put_u32(mr_put_u32(image, MAGIC), sequence);
    put_fields(state, image + 8);
    mr_put_u32(image + MR_RUNWAY_IMAGE_BYTES - 4, mr_crc32(0, image, MR_RUNWAY_IMAGE_BYTES - 4));
}

enum mr_status mr_runway_decode(struct mr_predictor_state *state, uint32_t *sequence,
                                const uint8_t image[MR_RUNWAY_IMAGE_BYTES])
{
    const uint8_t *p = image, *end = image + MR_RUNWAY_IMAGE_BYTES - 4;
    if (mr_get_u32(&p) != MAGIC)
        return MR_MALFORMED;
    if (mr_get_u32(&end) != mr_crc32(0, image, MR_RUNWAY_IMAGE_BYTES - 4))
        return MR_CRC;
    *sequence = mr_get_u32(&p);
    state->mats = mr_get_u16(&p);
    state->landing_count = mr_get_u16(&p);
    state->resistance_scale = mr_get_f32(&p);
    for (unsigned j = 0; j < MR_RUNWAY_JOINTS; j++)
        state->gap_counts[j] = mr_get_u16(&p);
    return MR_OK;
}

uint32_t mr_runway_crc(const struct mr_predictor_state *state)
{
    uint8_t word[8];
    uint8_t *p = mr_put_u16(mr_put_u16(word, state->mats), state->landing_count);
    mr_put_f32(p, state->resistance_scale);
    uint32_t crc = mr_crc32(0, word, 8);
    for (unsigned j = 0; j < MR_RUNWAY_JOINTS; j++) {
        mr_put_u16(word, state->gap_counts[j]);
        crc = mr_crc32(crc, word, 2);
    }
    return crc;
}

static unsigned get_joint_count(const struct mr_predictor_state *state)
{
    return (state->mats < MR_CHAIN_MATS ? state->mats : MR_CHAIN_MATS) + 1u;
}

unsigned mr_runway_message_count(const struct mr_predictor_state *state)
{
    return (get_joint_count(state) + MR_RUNWAY_JOINTS_PER_MESSAGE - 1u) /
           MR_RUNWAY_JOINTS_PER_MESSAGE;
}

static uint16_t get_gap_counts(const struct mr_predictor_state *state, unsigned j)
{
    return j < get_joint_count(state) ? state->gap_counts[j] : 0;
}

struct mr_runway_joints mr_runway_make_message(const struct mr_predictor_state *state, unsigned n)
{
    unsigned j = n * MR_RUNWAY_JOINTS_PER_MESSAGE;
    return (struct mr_runway_joints){.index = (uint16_t)(j + 1u),
                                     .gap_1 = get_gap_counts(state, j),
                                     .gap_2 = get_gap_counts(state, j + 1u),
                                     .gap_3 = get_gap_counts(state, j + 2u)};
}

static void set_gap_counts(struct mr_predictor_state *state, unsigned j, uint16_t gap_counts)
{
    if (j < MR_RUNWAY_JOINTS)
        state->gap_counts[j] = gap_counts;
}

void mr_runway_apply_message(struct mr_predictor_state *state,
                             const struct mr_runway_joints *message)
{
    if (message->index == 0)
        return;
    set_gap_counts(state, message->index - 1u, message->gap_1);
    set_gap_counts(state, message->index, message->gap_2);
    set_gap_counts(state, message->index + 1u, message->gap_3);
}

int32_t mr_runway_make_joints_argument(const struct mr_predictor_state *state, unsigned index)
{
    return (int32_t)((uint32_t)get_gap_counts(state, 2u * index) |
                     (uint32_t)get_gap_counts(state, 2u * index + 1u) << 16);
}

void mr_runway_apply_joints(struct mr_predictor_state *state, unsigned index, int32_t argument)
{
    set_gap_counts(state, 2u * index, (uint16_t)argument);
    set_gap_counts(state, 2u * index + 1u, (uint16_t)((uint32_t)argument >> 16));
}

int32_t mr_runway_make_word_argument(const struct mr_predictor_state *state, unsigned index)
{
    int32_t bits;
    memcpy(&bits, &state->resistance_scale, sizeof bits);
    return index == 0 ? bits
         : index == 1 ? (int32_t)state->landing_count
                      : (int32_t)state->gap_counts[MR_RUNWAY_JOINTS - 1u];
}

bool mr_runway_apply_word(struct mr_predictor_state *state, unsigned index, int32_t argument)
{
    if (index >= MR_RUNWAY_WORD_COUNT ||
        (index > 0 && (argument < 0 || argument > (int32_t)UINT16_MAX)))
        return false;
    if (index == 0)
        memcpy(&state->resistance_scale, &argument, sizeof state->resistance_scale);
    else if (index == 1)
        state->landing_count = (uint16_t)argument;
    else
        state->gap_counts[MR_RUNWAY_JOINTS - 1u] = (uint16_t)argument;
    return true;
}

float mr_predict_get_item(const struct mr_predictor_config *config, unsigned item)
{
    unsigned n = 0;
#define ITEM(field, text, unit) \
    if (item == n++)            \
        return (float)config->field;
    MR_PREDICT_ITEM_TABLE(ITEM)
#undef ITEM
    return item - n < MR_TRANSDUCERS ? config->station_ft[item - n] : MR_NAN;
}

/* Converts a count, which is transferred as a real, back to an integer. */
static uint32_t convert_real_to_count(float value)
{
    return value >= 0.0f && value < 1e9f ? (uint32_t)value : 0;
}

/* clang-format off */
#define COPY_FIELD(field, value) \
    (__typeof__(field))_Generic((field), float: (value), default: convert_real_to_count(value))
/* clang-format on */

void mr_predict_set_item(struct mr_predictor_config *config, unsigned item, float value)
{
    unsigned n = 0;
#define ITEM(field, text, unit) \
    if (item == n++)            \
        config->field = COPY_FIELD(config->field, value);
    MR_PREDICT_ITEM_TABLE(ITEM)
#undef ITEM
    if (item - n < MR_TRANSDUCERS)
        config->station_ft[item - n] = value;
}
