/* Why no board is understood on a link: nothing comes, or what comes is no frame, because of the
 * rate, or the bus has errors alone. */
#ifndef MATRIG_HOST_LINK_RX_DIAGNOSTICS_H
#define MATRIG_HOST_LINK_RX_DIAGNOSTICS_H

#include "host/link/link.h"

#define DIAGNOSIS_TEXT 400u
/* how such a message begins; the link follows, then what to do */
#define LINK_NO_HELLO  "no hello from a board"

enum diagnosis {
    DIAGNOSIS_SILENT,     /* nothing at all */
    DIAGNOSIS_GARBLED,    /* bytes, and not a frame among them: the rate */
    DIAGNOSIS_BUS_ERRORS, /* error frames alone: the bit rate, or the termination */
    DIAGNOSIS_NO_HELLO,   /* frames, and none that says who speaks */
};

/* `text`: "NAME: what came; what to do", one line. */
enum diagnosis link_diagnose(const struct link *link, char text[DIAGNOSIS_TEXT]);
/* One word for programs: "silent", "garbled", "bus-errors", "no-hello". Static storage. */
const char *diagnosis_word(enum diagnosis diagnosis);
/* Sets the error, of a link on which no board spoke within the time allowed: MR_TIMEOUT when
 * nothing came, else MR_IO. */
enum mr_status link_no_board(const struct link *link, struct error *error);

#endif
