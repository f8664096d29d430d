/* How each field of the catalogue is compared. */
#ifndef MATRIG_HOST_REPLAY_DIFF_FIELD_H
#define MATRIG_HOST_REPLAY_DIFF_FIELD_H

#include "host/replay/diff.h"

enum field_rule {
    FIELD_PLAIN,        /* equal, or within the tolerance of its unit */
    FIELD_BLOCK,        /* a block index: less the shift */
    FIELD_BLOCK16,      /* its low 16 bits */
    FIELD_TICK,         /* a tick of TIM2 */
    FIELD_QUEUED,       /* frames since reset, dropped ones included: since the landing's first */
    FIELD_FAULTS,       /* of the mask, the faults that follow from the record */
    FIELD_IMAGE,        /* names the image: compared when it is the same */
    FIELD_CIRCUMSTANCE, /* does not follow from the record */
};

enum field_rule field_rule(const struct mr_message_info *info, const struct mr_field_info *field);
/* The whole message is none that follows from the record. */
bool field_circumstance(const struct mr_message_info *info);
/* It is told in turn, when the bus has room. */
bool field_in_turn(const struct mr_message_info *info);
/* Faults that follow from blocks and edges, as bits. */
uint32_t field_record_faults(void);
/* How far apart values in a unit may be when another image ran; 0: equal. */
double field_tolerance(const char *unit);
/* One line that states them all; with `si` lengths, speeds and forces in SI units. */
#define FIELD_TOLERANCES_TEXT 200
void field_tolerances_text(bool si, char out[FIELD_TOLERANCES_TEXT]);

#endif
