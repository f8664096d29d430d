/* Result: what an ensemble did, as JSON (README.md, "The result"). */
#ifndef MATRIG_HOST_CAMPAIGN_RESULT_JSON_H
#define MATRIG_HOST_CAMPAIGN_RESULT_JSON_H

#include <jansson.h>

#include "host/campaign/summary.h"

/* A new object, as `matrig study --json` prints it. `apart`: of --check; NULL: none. */
json_t *campaign_json(const struct campaign *campaign, const struct campaign_run *runs, const struct campaign_summary *summary,
                      const struct campaign_difference *apart);

#endif
