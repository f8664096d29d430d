/* Where the samples of a measured landing came from: serial, the black box, CAN, a file of another
 * instrument, or nowhere. */
#ifndef MATRIG_HOST_ANALYSE_MEASURED_SOURCE_H
#define MATRIG_HOST_ANALYSE_MEASURED_SOURCE_H

#include "host/analyse/measured.h"
#include "host/base/cli.h"

#define MEASURED_SOURCE_TEXT 600

/* Fills stretch, stretches and blocks_from from the channels' sources. */
enum mr_status measured_find_stretches(struct measured *measured, struct error *error);

/* "serial", "can", "blackbox", "import", "none". Static storage. */
const char *measured_source_name(enum measured_source source);
/* The same as one letter of a table: S, C, B, I, and - for none. */
char measured_source_letter(enum measured_source source);
/* In words: "serial block records, 1 kHz", and what CAN and the black box filled of it, and
 * nobody. */
void measured_source_text(const struct measured *measured, char out[MEASURED_SOURCE_TEXT]);
/* What was set aside because of its time, a part of the text above, as a note where that text is
 * not shown. */
void measured_aside_note(const struct measured *measured, const struct cli *cli);
/* The same in numbers; null: nothing. */
json_t *measured_aside_json(const struct measured *measured);

#endif
