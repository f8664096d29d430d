/* The live view in a terminal: a picture of the model as plain text, for any width from 40 columns
 * on. Pure ASCII and a few ANSI sequences; without colour nothing is lost, for nothing is told by
 * colour alone. */
#ifndef MATRIG_HOST_LIVE_TERMINAL_H
#define MATRIG_HOST_LIVE_TERMINAL_H

#include <stdio.h>

#include "host/live/model.h"

struct live_screen {
    /* 40 to 300 columns are used; what does not fit into the rows is left out, the least important
     * first */
    unsigned columns, rows;
    bool colour;
    bool si;
};

/* Draws the whole screen from its upper left corner; each line is cleared behind its text, and what
 * is below the last. */
void live_terminal_draw(FILE *out, const struct live_model *model, int64_t now_us, const char *db,
                        const struct live_screen *screen);
/* The same as one line of text with its end, for a log: state, gear, warning, health. */
void live_terminal_line(FILE *out, const struct live_model *model, int64_t now_us, bool si);

#endif
