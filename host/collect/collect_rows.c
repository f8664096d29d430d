/* What messages say of the campaign's rows, by the catalogue. */
#include "host/collect/collect_rows.h"

#define KEPT(name, NAME, row, ...)                                              \
    void collect_##name##_row(struct store_##row *r, const struct mr_##name *m) \
    {                                                                           \
        __VA_ARGS__;                                                            \
    }
#include "common/catalogue.def"
