/* The day on a page of this computer: what is done and what is next, and a button for each key that
 * is taken now. What has to be typed, as readings of a survey, is typed at the terminal; the page
 * says so. Served by host/live/server.h, behind its doors. */
#ifndef MATRIG_HOST_DAY_PAGE_H
#define MATRIG_HOST_DAY_PAGE_H

#include <jansson.h>

#include "host/base/error.h"

struct day_page;

/* `where` as of live_server_open; both texts stay the caller's. MR_USAGE, MR_IO. */
enum mr_status day_page_open(const char *where, const char *db, struct day_page **page,
                             struct error *error);
/* With the token; static in the page. */
const char *day_page_url(const struct day_page *page);
/* What the page shows from now on; takes `state`. `keys`: those that are taken now. NULL: no
 * page. */
void day_page_tell(struct day_page *page, json_t *state, const char *keys);
/* Keys that were pressed there come from it, a byte each; -1 of NULL. */
int day_page_keys(const struct day_page *page);
void day_page_close(struct day_page *page); /* NULL is allowed */

#endif
