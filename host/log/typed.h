/* Commands typed into a running matrig log: `arm [N]` and `disarm`, a line each, on standard input.
 * Before it arms, and before it ends a landing that is going on, it asks once more. Boards that are
 * logged together are armed together. */
#ifndef MATRIG_HOST_LOG_TYPED_H
#define MATRIG_HOST_LOG_TYPED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/command.h"

struct logger;

struct typed {
    bool on, terminal;
    bool ended;     /* there is no more to read */
    char text[256]; /* read, and not yet obeyed */
    size_t length;
    struct mr_command command; /* the one asked about, or sent */
    bool asked;                /* whether it is meant; `yes` is waited for */
    bool sent;                 /* its answer is waited for until until_us */
    uint16_t tag;              /* of the last one */
    uint64_t until_us;
    uint64_t hold_us; /* no progress is drawn until then, over what is being typed */
};

/* `commands`: also when standard input is no terminal. `listen`: never. */
void typed_begin(struct typed *typed, bool commands, bool listen);
/* To be waited for until it can be read, then typed_read; -1: nothing is. */
int typed_fd(const struct typed *typed);
void typed_read(struct typed *typed);
/* Obeys a line, and looks for the answer of the command before. Every turn. */
void typed_turn(struct logger *logger);
bool typed_holds(const struct typed *typed, uint64_t now_us);

#endif
