#include "host/store/store_recalibrate.h"

#include <math.h>

#include "host/store/store_sql.h"

static bool same(float a, float b)
{
    return a == b || (isnan(a) && isnan(b));
}

static enum mr_status keep(struct store *store, int64_t run, unsigned index, int64_t item,
                           float was, float value, const struct store_recalibration *how,
                           unsigned *changed, struct error *error)
{
    if (same(was, value))
        return MR_OK;
    ++*changed;
    const struct store_recalibrated row = {.index = index,
                                           .item = item,
                                           .was = (double)was,
                                           .value = (double)value,
                                           .made_us = how->made_us,
                                           .who = how->who,
                                           .reason = how->reason};
    return STORE_PUT(store, error, recalibrated, &row, run);
}

enum mr_status store_recalibrate(struct store *store, int64_t run, unsigned index,
                                 const struct mr_channel_config *old,
                                 const struct mr_channel_config *new,
                                 const struct store_recalibration *how, unsigned *changed,
                                 struct error *error)
{
    struct mr_channel_config becomes = *old;
    becomes.unit_per_code = new->unit_per_code;
    if (old->kind != MR_KIND_TENSION || how->zeros)
        becomes.zero_code = new->zero_code;
    *changed = 0;
    enum mr_status status = keep(store, run, index, STORE_ITEM_UNIT, old->unit_per_code,
                                 becomes.unit_per_code, how, changed, error);
    if (status == MR_OK)
        status = keep(store, run, index, STORE_ITEM_ZERO, old->zero_code, becomes.zero_code, how,
                      changed, error);
    for (unsigned item = 0; item < MR_CALIBRATION_ITEMS && status == MR_OK; item++) {
        float was = mr_channel_item(old, item), value = mr_channel_item(new, item);
        status = keep(store, run, index, item, was, value, how, changed, error);
        if (status == MR_OK && !same(was, value))
            status = store_calibration_put(store, run, index, item, (double)value, error);
    }
    return status == MR_OK && *changed ? store_channel_put(store, run, index, &becomes, error)
                                       : status;
}

enum mr_status store_is_recalibrated(struct store *store, int64_t run, bool *is,
                                     struct error *error)
{
    int64_t rows = 0;
    enum mr_status status = STORE_NUMBER(store, error, RECALIBRATED, &rows, BIND(run));
    *is = rows > 0;
    return status == MR_TOO_FEW ? MR_OK : status;
}
