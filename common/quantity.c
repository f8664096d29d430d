#include "common/quantity.h"

#include "common/wire.h"

/* QUANTITY sets the row of a quantity, LANDING_MEAN the member of that row about its mean. */
static const struct mr_quantity_info quantities[MR_QUANTITY_COUNT] = {
#define QUANTITY(name_, NAME, quantity, suffix, words, sign, digits, value, error) \
    [MR_QUANTITY_##quantity].name = #quantity,                                     \
    [MR_QUANTITY_##quantity].key = #quantity "_" #suffix,                          \
    [MR_QUANTITY_##quantity].error_key = #quantity "_error_" #suffix,              \
    [MR_QUANTITY_##quantity].text = words, [MR_QUANTITY_##quantity].unit = sign,   \
    [MR_QUANTITY_##quantity].decimals = digits, [MR_QUANTITY_##quantity].id = MR_ID_##NAME,
#define LANDING_MEAN(name_, NAME, quantity, table, column, error, reason) \
    [MR_QUANTITY_##quantity].missing_reason = reason,
#include "common/catalogue.def"
};

const struct mr_quantity_info *mr_quantity_at(unsigned quantity)
{
    return &quantities[quantity];
}

void mr_quantity_update(struct mr_quantity_value *values, const struct mr_message *message)
{
#define QUANTITY(name, NAME, quantity, suffix, words, unit, decimals, value_, error_) \
    if (message->index == MR_INDEX_##NAME) {                                          \
        const struct mr_##name *m = &message->as.name;                                \
        values[MR_QUANTITY_##quantity] = (struct mr_quantity_value){.value = value_,  \
                                                                    .error = error_}; \
    }
#include "common/catalogue.def"
}
