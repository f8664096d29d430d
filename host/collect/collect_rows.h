/* What messages say of the campaign's rows: collect_zone_row(), collect_zone_lead_row(), ..., one
 * for each KEPT of the catalogue. It fills those fields of the row that the message has, and leaves
 * the others. Pure. */
#ifndef MATRIG_HOST_COLLECT_COLLECT_ROWS_H
#define MATRIG_HOST_COLLECT_COLLECT_ROWS_H

#include "common/catalogue.h"
#include "host/store/rows.h"

#define KEPT(name, NAME, row, ...) \
    void collect_##name##_row(struct store_##row *row, const struct mr_##name *message);
#include "common/catalogue.def"

#endif
