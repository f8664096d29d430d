#include "host/store/store_bands.h"

#include "host/store/store_sql.h"

STORE_PUT_OF_LANDING(band)
STORE_PUT_OF_LANDING(band_event)
STORE_ROWS_OF_LANDING(store_bands, BANDS)
STORE_ROWS_OF_LANDING(store_band_events, BAND_EVENTS)

enum mr_status store_shunt_put(struct store *store, int64_t session, int64_t boot,
                               const struct store_shunt *shunt, struct error *error)
{
    return STORE_PUT(store, error, shunt, shunt, session, boot);
}

enum mr_status store_shunts_before(struct store *store, int64_t session, int64_t boot,
                                   int64_t block, struct store_shunt **rows, size_t *count,
                                   struct error *error)
{
    STORE_ROWS(SHUNTS_BEFORE, BIND(session), BIND(boot), BIND(block));
}

enum mr_status store_shunts_after(struct store *store, int64_t session, int64_t boot, int64_t block,
                                  struct store_shunt **rows, size_t *count, struct error *error)
{
    STORE_ROWS(SHUNTS_AFTER, BIND(session), BIND(boot), BIND(block));
}
