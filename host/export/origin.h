/* What a table of matrig export says of the landing that its rows are of: who recorded it, switches
 * and edges, what each channel is worth. One comment line of JSON, "# landing: {...}", so that
 * matrig import makes the same landing of it again. */
#ifndef MATRIG_HOST_EXPORT_ORIGIN_H
#define MATRIG_HOST_EXPORT_ORIGIN_H

#include "host/analyse/measured.h"

#define ORIGIN_SWITCHES 64u
#define ORIGIN_EDGES    256u

struct origin {
    /* id: its RUN in the campaign that it was exported from; session and boot: 0 */
    struct store_landing landing;
    struct store_switch place[ORIGIN_SWITCHES];
    size_t places;
    struct store_edge edge[ORIGIN_EDGES];
    size_t edges;
    struct mr_channel_config channel[MR_CHANNELS]; /* kind 0: not told */
    size_t stride[MR_CHANNELS];
};

/* The JSON, on one line; the caller frees it. NULL: `error` says why. */
char *origin_text(struct store *store, const struct measured *measured, struct error *error);
/* False: it is not that, or damaged. */
bool origin_parse(const char *text, size_t length, struct origin *origin);

#endif
