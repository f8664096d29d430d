/* Loads a landing from the campaign: its gates and its samples. Samples are taken from block
 * records where they exist, otherwise from CAN messages or from an imported file. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_LOAD_H
#define MATRIG_HOST_ANALYSE_MEASURED_LOAD_H

#include "host/analyse/measured.h"

/* The caller releases `measured` with measured_free, also after an error. */
enum mr_status measured_load(struct store *store, int64_t run, struct measured_landing *measured,
                             struct error *error);
/* As measured_load, for callers that need only the motion of the gear. Samples are loaded only if
 * they are needed to find out whether the gear stopped; otherwise the channels are empty. */
enum mr_status measured_load_gear(struct store *store, int64_t run,
                                  struct measured_landing *measured, struct error *error);

#endif
