/* The configuration: its stored form against an independent reader, damage, every limit and every
 * rule. */
#include <math.h>
#include <stdio.h>
#include <zlib.h>

#include "common/canbase.h"
#include "tests/cmocka_all.h"
#include "tests/common/sound_config.h"

static uint8_t image[MR_CONFIG_IMAGE_BYTES];

/* --- an independent reader of the stored form --- */
static const uint8_t *at;
static uint32_t number(unsigned bytes)
{
    uint32_t value = 0;
    for (unsigned i = 0; i < bytes; i++)
        value += (uint32_t)at[i] * (1u << (8u * i));
    at += bytes;
    return value;
}

static void is_real(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, 4);
    assert_int_equal(number(4), bits);
}

TEST(stored_form_is_the_table)
{
    const struct mr_config c = sound_config();
    memset(image, 0xa5, sizeof image);
    uint32_t crc = mr_config_encode(&c, image);
    assert_memory_equal(image, "MRCF\1\0\0\0", 8);
    /* name, revision, 420 mats */
    assert_memory_equal(image + 20, "rig \"A\" \\ #1\0\0\0\0\7\0\0\0\xa4\1", 22);
    at = image + 8;
    assert_int_equal(number(4), MR_CONFIG_IMAGE_BYTES);
    number(4);
    assert_int_equal(number(4), 7);
/* clang-format off */
#define BYTES_u8 1
#define BYTES_u16 2
#define BYTES_u32 4
#define GROUP(name, count)                                                                    \
    for (unsigned i = 0; i < (count); i++) { const struct mr_##name##_config *m = &c.name[i]; \
        (void)m;
#define INTEGER(group, type, field, least, most, unit, text) \
    assert_int_equal(number(BYTES_##type), m->field);
#define REAL(group, field, least, most, unit, text) is_real(m->field);
#define REALS(group, field, count, least, most, unit, text) \
    for (unsigned k = 0; k < (count); k++) is_real(m->field[k]);
#define TEXT(group, field, size, text) assert_memory_equal(at, m->field, size); at += (size);
#define END_GROUP(name) }
/* clang-format on */
#include "common/config.def"
    while ((at - image) % 4)
        assert_int_equal(number(1), 0);
    assert_int_equal(number(4), crc);
    assert_int_equal(at - image, MR_CONFIG_IMAGE_BYTES);
    assert_int_equal(crc, crc32(0, image, MR_CONFIG_IMAGE_BYTES - 4));
}

/* Whatever the fields hold, through the stored form and back. */
TEST(it_comes_back)
{
    static struct mr_config c, back;
    static uint8_t again[MR_CONFIG_IMAGE_BYTES];
    uint32_t random = 1;
    for (int round = 0; round < 200; round++) {
        for (size_t i = 0; i < sizeof c; i++) {
            random = random * 1664525u + 1013904223u;
            ((uint8_t *)&c)[i] = (uint8_t)(random >> 24);
        }
        mr_config_encode(&c, image);
        memset(&back, 0, sizeof back);
        assert_int_equal(mr_config_decode(image, sizeof image, &back), MR_OK);
        mr_config_encode(&back, again);
        assert_memory_equal(again, image, sizeof image);
        assert_int_equal(back.gate[23].step_codes, c.gate[23].step_codes);
        assert_memory_equal(&back.band, &c.band, sizeof c.band);
    }
}

TEST(exchanging_twice_changes_nothing)
{
    struct mr_config c = sound_config(), other = c;
    static uint8_t kept[MR_CONFIG_IMAGE_BYTES], of_other[MR_CONFIG_IMAGE_BYTES];
    other.site[0].touchdown_ft = 9.0f;
    other.gate[23].step_codes = 1;
    mr_config_encode(&other, kept);
    memcpy(image, kept, sizeof image);
    mr_config_swap_image(image, &c);
    assert_int_equal(c.gate[23].step_codes, 1);
    assert_near(c.site[0].touchdown_ft, 9.0, 0.0);
    mr_config_encode(&c, of_other);
    assert_memory_equal(of_other, kept, sizeof kept);
    mr_config_swap_image(image, &c);
    assert_memory_equal(image, kept, sizeof image);
    struct mr_config sound = sound_config();
    assert_memory_equal(&c, &sound, sizeof c);
}

TEST(every_wrong_bit_is_noticed)
{
    struct mr_config c = sound_config(), kept;
    mr_config_encode(&c, image);
    for (unsigned bit = 0; bit < 8 * MR_CONFIG_IMAGE_BYTES; bit++) {
        image[bit / 8] ^= (uint8_t)(1u << bit % 8);
        if (mr_config_check_image(image, sizeof image) == MR_OK)
            fail_msg("bit %u of byte %u is wrong and nobody sees it", bit % 8, bit / 8);
        image[bit / 8] ^= (uint8_t)(1u << bit % 8);
    }
    image[100] ^= 1;
    memset(&kept, 0x55, sizeof kept);
    c = kept;
    assert_int_equal(mr_config_decode(image, sizeof image, &c), MR_CRC);
    assert_memory_equal(&c, &kept, sizeof c);
}

static void seal(uint8_t *bytes, unsigned length)
{
    uint32_t crc = (uint32_t)crc32(0, bytes, length - 4);
    for (unsigned i = 0; i < 4; i++)
        bytes[length - 4 + i] = (uint8_t)(crc >> 8 * i);
}

TEST(what_is_wrong_has_a_name)
{
    struct mr_config c = sound_config();
    static uint8_t longer[MR_CONFIG_IMAGE_BYTES + 8];
    mr_config_encode(&c, image);
    assert_int_equal(mr_config_check_image(image, MR_CONFIG_IMAGE_BYTES - 1), MR_TRUNCATED);
    assert_int_equal(mr_config_check_image(image, 10), MR_TRUNCATED);
    image[0] = 'X';
    assert_int_equal(mr_config_check_image(image, sizeof image), MR_MALFORMED);
    for (unsigned byte = 4; byte < 16; byte += byte == 4 ? 2 : byte == 6 ? 6 : 1) {
        /* another format, reserved bits, another table */
        mr_config_encode(&c, image);
        image[byte] ^= 2;
        seal(image, MR_CONFIG_IMAGE_BYTES);
        assert_int_equal(mr_config_check_image(image, sizeof image), MR_VERSION);
    }
    mr_config_encode(&c, image); /* a length too short for its own header */
    image[8] = 4;
    image[9] = 0;
    assert_int_equal(mr_config_check_image(image, sizeof image), MR_MALFORMED);
    mr_config_encode(&c, longer); /* a later version's, with a field more: whole, but not ours */
    longer[8] = (uint8_t)(sizeof longer & 0xff);
    longer[9] = (uint8_t)(sizeof longer >> 8);
    seal(longer, sizeof longer);
    assert_int_equal(mr_config_check_image(longer, sizeof longer), MR_VERSION);
    assert_int_equal(mr_config_check_image(longer, sizeof longer - 4), MR_TRUNCATED);
}

/* --- limits and rules --- */
static void is_refused(const struct mr_config *c, unsigned group, unsigned index, unsigned field,
                       unsigned element, unsigned rule)
{
    struct mr_config_violation r = {0};
    assert_int_equal(mr_config_check(c, &r), MR_LIMIT);
    if (r.group != group || r.index != index || r.field != field || r.element != element ||
        r.rule != rule)
        fail_msg("%s[%u].%s[%u] rule %u is told, %s[%u].%s[%u] rule %u is wrong",
                 mr_config_groups[r.group].name, r.index,
                 mr_config_groups[r.group].fields[r.field].name, r.element, r.rule,
                 mr_config_groups[group].name, index, mr_config_groups[group].fields[field].name,
                 element, rule);
}

static struct mr_config broken;

static void refuse_integer(void *field, unsigned size, uint64_t least, uint64_t most, unsigned g,
                           unsigned i, unsigned f)
{
    uint64_t greatest = (1ull << (8 * size)) - 1;
    uint32_t kept, wrong = (uint32_t)(most + 1);
    memcpy(&kept, field, size);
    if (most < greatest) {
        memcpy(field, &wrong, size);
        is_refused(&broken, g, i, f, 0, MR_RULE_TOO_LARGE);
    }
    wrong = (uint32_t)(least - 1);
    if (least > 0) {
        memcpy(field, &wrong, size);
        is_refused(&broken, g, i, f, 0, MR_RULE_TOO_SMALL);
    }
    memcpy(field, &kept, size);
}

static void refuse_real(float *field, float least, float most, bool optional, unsigned g,
                        unsigned i, unsigned f, unsigned e)
{
    float kept = *field;
    uint32_t other_nan = 0x7fc00001u;
    *field = nextafterf(most, INFINITY);
    is_refused(&broken, g, i, f, e, MR_RULE_TOO_LARGE);
    *field = INFINITY;
    is_refused(&broken, g, i, f, e, MR_RULE_TOO_LARGE);
    *field = nextafterf(least, -INFINITY);
    is_refused(&broken, g, i, f, e, MR_RULE_TOO_SMALL);
    *field = NAN;
    if (!optional)
        is_refused(&broken, g, i, f, e, MR_RULE_NOT_A_NUMBER);
    memcpy(field, &other_nan, 4);
    is_refused(&broken, g, i, f, e, MR_RULE_NOT_A_NUMBER);
    *field = kept;
}

static void refuse_text(char *text, unsigned size, unsigned g, unsigned i, unsigned f)
{
    char kept[64];
    memcpy(kept, text, size);
    memset(text, 'a', size);
    text[size / 2] = '\0'; /* not the end */
    is_refused(&broken, g, i, f, 0, MR_RULE_NOT_TEXT);
    const char unprintable[] = {'\n', '\x7f', '\x1f', (char)0xe9};
    for (unsigned k = 0; k < sizeof unprintable; k++) {
        memset(text, 0, size);
        text[0] = unprintable[k];
        is_refused(&broken, g, i, f, 0, MR_RULE_NOT_TEXT);
    }
    memcpy(text, kept, size);
}

TEST(every_limit_is_refused_with_its_reason)
{
    struct mr_config_violation reason;
    broken = sound_config();
    assert_int_equal(mr_config_check(&broken, &reason), MR_OK);
    unsigned g = 0, f = 0, limits = 0;
/* clang-format off */
#define GROUP(name, count)                                                                   \
    for (unsigned i = 0; i < (count); i++) { struct mr_##name##_config *m = &broken.name[i]; \
        f = 0;
#define INTEGER(group, type, field, least, most, unit, text) \
    refuse_integer(&m->field, sizeof m->field, least, most, g, i, f++); limits++;
#define REAL(group, field, least, most, unit, text) \
    refuse_real(&m->field, (float)(least), (float)(most), false, g, i, f++, 0); limits++;
#define OPTIONAL(group, field, least, most, unit, text) \
    refuse_real(&m->field, (float)(least), (float)(most), true, g, i, f++, 0); limits++;
#define REALS(group, field, count, least, most, unit, text)                          \
    for (unsigned k = 0; k < (count); k++)                                           \
        refuse_real(&m->field[k], (float)(least), (float)(most), false, g, i, f, k); \
    f++; limits++;
#define TEXT(group, field, size, text) refuse_text(m->field, size, g, i, f++); limits++;
#define END_GROUP(name) } g++;
/* clang-format on */
#include "common/config.def"
    assert_int_equal(mr_config_check(&broken, &reason), MR_OK); /* all was put back */
    assert_true(limits > 500);
}

/* The table has a number: with it the last message of the catalogue has the last identifier. */
TEST(a_base_keeps_all_messages_within_11_bits)
{
    const struct mr_config_field *field =
        &mr_config_groups[MR_GROUP_site].fields[MR_FIELD_site_can_base];
    size_t count;
    const struct mr_message_info *messages = mr_catalogue_messages(&count);
    unsigned last = 0;
    for (size_t i = 0; i < count; i++)
        last = messages[i].id > last ? messages[i].id : last;
    assert_string_equal(field->name, "can_base");
    assert_int_equal(field->int_min, 0);
    assert_int_equal(field->int_max + last, 0x7ff);
    assert_int_equal(field->int_max, MR_CAN_BASE_MAX);
}

/* One thing after another is made wrong in a sound configuration. */
#define WRONG(change, name, i, which, e, rule_)                                            \
    do {                                                                                   \
        struct mr_config c = sound_config();                                               \
        change;                                                                            \
        is_refused(&c, MR_GROUP_##name, i, MR_FIELD_##name##_##which, e, MR_RULE_##rule_); \
    } while (0)
#define RIGHT(change)                                           \
    do {                                                        \
        struct mr_config c = sound_config();                    \
        struct mr_config_violation reason_;                     \
        change;                                                 \
        assert_int_equal(mr_config_check(&c, &reason_), MR_OK); \
        assert_int_equal(reason_.rule, MR_RULE_NONE);           \
    } while (0)

TEST(switches_rise_and_differ)
{
    WRONG(c.gate[9].station_ft = c.gate[8].station_ft, gate, 9, station_ft, 0, NOT_RISING);
    /* number 5 is not fitted */
    WRONG(c.gate[6].station_ft = c.gate[4].station_ft, gate, 6, station_ft, 0, NOT_RISING);
    RIGHT(c.gate[5].station_ft = -999.0f);
    WRONG(c.gate[7].step_codes = (uint16_t)(c.gate[2].step_codes + 5), gate, 7, step_codes, 0,
          STEPS_TOO_CLOSE);
    /* no step at all, to the staircase */
    WRONG(c.gate[0].step_codes = 7, gate, 0, step_codes, 0, TOO_SMALL);
    WRONG(for (int i = 0; i < 24; i++) c.gate[i].step_codes = 100, gate, 1, step_codes, 0,
          STEPS_TOO_CLOSE);
    /* 64 + 8 i: all 24 are 24 * 64 + 8 * 276 = 3744, less the absent one's 64 + 8 * 11 = 152: 3592;
     * 503 are left */
    RIGHT(c.channel[22].zero_code = 503.0f);
    WRONG(c.channel[22].zero_code = 503.5f, gate, 23, step_codes, 0, SUM_TOO_LARGE);
}

TEST(channels_go_with_their_place)
{
    WRONG(c.channel[8].kind = MR_KIND_DISPLACEMENT, channel, 8, kind, 0, WRONG_INPUT);
    WRONG(c.channel[7].kind = MR_KIND_TENSION, channel, 7, kind, 0, WRONG_INPUT);
    WRONG(c.channel[22].kind = MR_KIND_REFERENCE, channel, 22, kind, 0, WRONG_INPUT);
    WRONG(c.channel[22].kind = MR_KIND_NONE, channel, 22, kind, 0, WRONG_INPUT);
    WRONG(c.channel[23].kind = MR_KIND_NONE, channel, 23, kind, 0, WRONG_INPUT);
    RIGHT(memset(c.gate, 0, sizeof c.gate); c.channel[22].kind = MR_KIND_NONE);
    WRONG(c.channel[4].number = 2, channel, 4, number, 0, NUMBER_IN_USE);
    WRONG(c.channel[20].number = 0, channel, 20, number, 0, MUST_NOT_BE_ZERO);
    RIGHT(c.channel[1].kind = MR_KIND_NONE; c.channel[4].number = 2);
    WRONG(c.channel[11].unit_per_code = 0.0f, channel, 11, unit_per_code, 0, MUST_NOT_BE_ZERO);
    RIGHT(c.channel[11].kind = MR_KIND_NONE; c.channel[11].unit_per_code = 0.0f);
    WRONG(c.channel[5].station_ft = NAN, channel, 5, station_ft, 0, NO_STATION);
    WRONG(c.channel[5].station_ft = c.channel[2].station_ft, channel, 5, station_ft, 0, NOT_RISING);
    WRONG(c.channel[12].band = 3, channel, 12, band, 0, NO_BAND);
    RIGHT(c.channel[12].band = 0);
    WRONG(c.band[0].yield_lb = 100.0f, band, 0, yield_lb, 0, NOT_ABOVE);
}

/* The limit by hand: m = 0.466 / 32.174 = 0.014484 slug; w^2 = 4 * 2.9e5 / m = 8.0089e7, d = 4 * 5
 * / m = 1380.9; 4 / (d + sqrt(d^2 + 4 w^2)) = 2.0692e-4 s, 0.9 of it 0.18623 ms. */
TEST(the_predictor_is_stable)
{
    RIGHT(c.predict[0].step_ms = 0.1860f);
    WRONG(c.predict[0].step_ms = 0.1865f, predict, 0, step_ms, 0, UNSTABLE);
    /* slugs for pounds */
    WRONG(c.predict[0].mat_weight_lb = 0.466f / 32.174f, predict, 0, step_ms, 0, UNSTABLE);
    WRONG(c.predict[0].joint_stiffness_lb_ft = 2.9e6f, predict, 0, step_ms, 0, UNSTABLE);
    /* seconds for milliseconds */
    WRONG(c.predict[0].step_ms = 0.166e-3f, predict, 0, step_ms, 0, TOO_SMALL);
    /* millimetres for inches */
    WRONG(c.predict[0].slack_in = 0.762f, predict, 0, slack_in, 0, TOO_LARGE);
    WRONG(c.predict[0].level = 4, predict, 0, level, 0, TOO_LARGE);
    RIGHT(c.predict[0].step_ms = 0.5f; c.predict[0].fitted = 0); /* one that does not run */
}

TEST(calibrations_make_sense)
{
    WRONG(c.channel[0].high = c.channel[0].low, channel, 0, high, 0, NOT_ABOVE);
    RIGHT(c.channel[0].high = 0.0f; c.channel[0].low = 0.0f); /* none given */
    RIGHT(c.channel[0].high = 0.0f; c.channel[0].low = -1.0f);
    RIGHT(c.channel[0].high = 1.0f; c.channel[0].low = 0.0f);
    WRONG(c.channel[3].points = 1, channel, 3, points, 0, ONE_POINT);
    WRONG(c.channel[3].point_reading[2] = 0.1f, channel, 3, point_reading, 2, NOT_RISING);
    WRONG(c.channel[3].point_value[1] = -2.01f, channel, 3, point_value, 1, NOT_RISING);
    WRONG(c.channel[3].points = 4, channel, 3, point_reading, 3, NOT_RISING);
    RIGHT(c.channel[3].points = 2; c.channel[3].point_reading[2] = -5.0f);
    WRONG(c.channel[6].expires_day = c.channel[6].calibrated_day, channel, 6, expires_day, 0,
          NOT_ABOVE);
    WRONG(c.channel[6].calibrated_day = 0, channel, 6, calibrated_day, 0, MUST_NOT_BE_ZERO);
    RIGHT(c.channel[6].expires_day = 0);
}
