/* The files of the live page, carried in the program. */
#ifndef MATRIG_HOST_LIVE_ASSETS_H
#define MATRIG_HOST_LIVE_ASSETS_H

#include <stddef.h>

struct live_asset {
    const char *path; /* "/live.js" */
    const char *type; /* of its content */
    const char *bytes, *end;
};

/* NULL: no such file. */
const struct live_asset *live_asset_find(const char *path);

#endif
