/* Quantities of the catalogue: what messages say of them, and what they are called. */
#include <math.h>
#include <string.h>

#include "common/quantity.h"
#include "tests/cmocka_all.h"

static void take(struct mr_quantity_value *values, uint16_t id, const uint8_t *payload,
                 size_t length)
{
    struct mr_message message;
    assert_int_equal(mr_message_decode(&message, id, payload, length), MR_OK);
    mr_quantity_update(values, &message);
}

TEST(a_message_says_its_own)
{
    struct mr_quantity_value values[MR_QUANTITY_COUNT];
    uint8_t payload[MR_MESSAGE_BYTES_MAX];
    for (unsigned i = 0; i < MR_QUANTITY_COUNT; i++)
        values[i] = (struct mr_quantity_value){.value = -1.0, .error = -2.0};
    take(values, MR_ID_TEMPERATURE, payload,
         mr_temperature_put(&(struct mr_temperature){.temperature_c = 20.5f, .error_c = 0.25f},
                            payload));
    assert_true(values[MR_QUANTITY_temperature].value == 20.5 &&
                values[MR_QUANTITY_temperature].error == 0.25);
    assert_true(values[MR_QUANTITY_load].value == -1.0 && values[MR_QUANTITY_load].error == -2.0);
    take(values, MR_ID_HEALTH, payload,
         mr_health_put(&(struct mr_health){.load_permille = 123}, payload));
    assert_near(values[MR_QUANTITY_load].value, 12.3, 1e-12);
    assert_true(isnan(values[MR_QUANTITY_load].error));
    take(values, MR_ID_TEMPERATURE, payload,
         mr_temperature_put(&(struct mr_temperature){.temperature_c = NAN, .error_c = NAN},
                            payload));
    assert_true(isnan(values[MR_QUANTITY_temperature].value) &&
                isnan(values[MR_QUANTITY_temperature].error));
    assert_near(values[MR_QUANTITY_load].value, 12.3, 1e-12);
}

TEST(each_has_its_words)
{
    const struct mr_quantity_info *t = mr_quantity_at(MR_QUANTITY_temperature),
                                  *load = mr_quantity_at(MR_QUANTITY_load);
    assert_string_equal(t->key, "temperature_c");
    assert_string_equal(t->error_key, "temperature_error_c");
    assert_string_equal(t->unit, "\xc2\xb0"
                                 "C");
    assert_int_equal(t->id, MR_ID_TEMPERATURE);
    assert_non_null(t->missing_reason);
    assert_string_equal(load->key, "load_percent");
    assert_null(load->missing_reason); /* the campaign has no column of it */
    for (unsigned i = 0; i < MR_QUANTITY_COUNT; i++) {
        assert_true(strlen(mr_quantity_at(i)->text) > 0 && strlen(mr_quantity_at(i)->unit) > 0);
        for (unsigned k = 0; k < i; k++)
            assert_string_not_equal(mr_quantity_at(i)->key, mr_quantity_at(k)->key);
    }
}
