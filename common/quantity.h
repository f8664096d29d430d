/* Quantities of the board that are shown to users, as defined by the QUANTITY and LANDING_MEAN rows
 * of the catalogue. Pure. */
#ifndef MATRIG_COMMON_QUANTITY_H
#define MATRIG_COMMON_QUANTITY_H

#include "common/catalogue.h"

enum mr_quantity {
#define QUANTITY(name, NAME, quantity, suffix, words, unit, decimals, value, error) \
    MR_QUANTITY_##quantity,
#include "common/catalogue.def"
    MR_QUANTITY_COUNT
};

struct mr_quantity_info {
    const char *name; /* "temperature" */
    /* keys of value and error in JSON: "temperature_c", "temperature_error_c" */
    const char *key, *error_key;
    const char *text, *unit; /* "mat temperature", in UTF-8 */
    /* text for a missing reading; NULL: the mean over a landing is not sent */
    const char *missing_reason;
    int decimals;
    uint16_t id; /* identifier of the message that carries the quantity */
};

/* Description of a quantity below MR_QUANTITY_COUNT. Static storage. */
const struct mr_quantity_info *mr_quantity_at(unsigned quantity);

/* Value and standard error in the unit of the quantity; NaN: missing. */
struct mr_quantity_value {
    double value, error;
};
/* Stores the values of a message in `values`, an array of MR_QUANTITY_COUNT. */
void mr_quantity_update(struct mr_quantity_value *values, const struct mr_message *message);

#endif
