/* Why what came over CAN is doubted: frames on the board's identifiers that are not the board's,
 * and what they did to a landing. Each is an event `doubt` of the campaign: code is the cause and,
 * from DOUBT_ID on, the identifier; detail how often since the event before, value how often in the
 * session. The numbers are in campaign databases: new ones go to the end. Those that are not obeyed
 * change no number. DOUBT_ALONE makes nothing doubtful by itself, it says that something of the
 * landing rests on CAN. */
#ifndef MATRIG_HOST_COLLECT_DOUBT_H
#define MATRIG_HOST_COLLECT_DOUBT_H

#include <stdbool.h>
#include <stdint.h>

/*     name            obeyed  text of what came */
/* clang-format off */
#define DOUBT_TABLE(X)                                                                      \
    X(DOUBT_UNSAID,    false,  "that serial did not say")                                   \
    X(DOUBT_LAYOUT,    false,  "of another layout")                                         \
    X(DOUBT_BOARD,     false,  "of another board")                                          \
    X(DOUBT_LENGTH,    false,  "of another length")                                         \
    X(DOUBT_TIME,      false,  "with a time that is not the board's")                       \
    X(DOUBT_STATE,     false,  "with a state that the landing cannot have")                 \
    X(DOUBT_EXCESS,    true,   "more than the board sent, which of them nobody knows")      \
    X(DOUBT_TORN,      true,   "that tore the landing: it was joined again")                \
    X(DOUBT_PHANTOM,   true,   "that began this landing, of which the board knows nothing") \
    X(DOUBT_ALONE,     true,   "that serial could neither say nor deny")
/* clang-format on */

enum doubt {
#define DOUBT_ENUM(name, obeyed, text) name,
    DOUBT_TABLE(DOUBT_ENUM) DOUBTS
};
#undef DOUBT_ENUM

#define DOUBT_ID 256 /* code: cause + DOUBT_ID * identifier */

/* "unknown" for a number not in the table. Static storage. */
const char *doubt_text(unsigned doubt);
/* It may have changed what is stated. */
bool doubt_obeyed(unsigned doubt);

#endif
