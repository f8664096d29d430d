/* The series of a landing that another instrument's file gave (matrig import). Only
 * measured_series.c. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_IMPORT_H
#define MATRIG_HOST_ANALYSE_MEASURED_IMPORT_H

#include "host/analyse/measured.h"

/* Fills source, first_block, samples and the raw series; nothing when the campaign has no such
 * readings. */
enum mr_status measured_load_import(struct store *store, struct measured *measured,
                                    struct error *error);

#endif
