/* A landing read back from the campaign: its gates, and its series from block records where there
 * are any, the rest from CAN messages, or from an imported file. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_LOAD_H
#define MATRIG_HOST_ANALYSE_MEASURED_LOAD_H

#include "host/analyse/measured.h"

/* The caller releases it with measured_free, also after an error. */
enum mr_status measured_load(struct store *store, int64_t run, struct measured *measured,
                             struct error *error);
/* The same for who asks for the gear alone, without the series where the record leaves no question
 * of the stop: the channels are then empty. */
enum mr_status measured_load_gear(struct store *store, int64_t run, struct measured *measured,
                                  struct error *error);

#endif
