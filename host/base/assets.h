/* Files of the pages, carried in the program. */
#ifndef MATRIG_HOST_BASE_ASSETS_H
#define MATRIG_HOST_BASE_ASSETS_H

struct asset {
    const char *path; /* at which the live page's server has it: "/live.js" */
    const char *type; /* of its content */
    const char *bytes, *end;
};

/* NULL: no such file. */
const struct asset *asset_find(const char *path);

#endif
