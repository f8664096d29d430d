/* The table of commands: what runs, what --help says, what man page and completion are made from. In main.c. */
#ifndef MATRIG_HOST_COMMANDS_H
#define MATRIG_HOST_COMMANDS_H

#include <stddef.h>

#include "host/cli.h"

/* Options are what begins with - in `words`, and in lines of `details` that begin with it: so man page and completion know those that
 * --help tells of (tests/cli/manners.sh holds them against what the commands take). */
struct command {
    const char *name;
    int (*run)(int argc, char **argv, const struct cli *cli);
    const char *words;   /* what follows the name; alternatives apart by " | " */
    const char *summary;
    const char *details; /* lines for COMMAND --help: two blanks, an item, its text from column 18; "Example: ..." */
};

struct command_table {
    const struct command *commands;
    size_t count;
};

#endif
