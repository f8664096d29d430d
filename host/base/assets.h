/* Files of the web pages, embedded in the program. */
#ifndef MATRIG_HOST_BASE_ASSETS_H
#define MATRIG_HOST_BASE_ASSETS_H

struct asset {
    const char *path; /* path on the live page's server: "/live.js" */
    const char *type; /* HTTP content type */
    const char *bytes, *end;
};

/* Finds a file; NULL if there is none with this path. */
const struct asset *asset_find(const char *path);

#endif
