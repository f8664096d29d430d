/* Commands to the board, by name: what the host sends, what a run file scripts, what the firmware
 * obeys.
 *
 * A command is one `command` message. Its code, its name, the meaning of its argument and who may
 * give it, when and by which link stand in the rows of common/catalogue_commands.def. */
#ifndef MATRIG_COMMON_COMMAND_H
#define MATRIG_COMMON_COMMAND_H

#include <stdbool.h>

#include "common/catalogue.h"

enum mr_command_code {
    MR_COMMAND_NONE, /* which no board knows */
#define COMMAND(NAME, code, ...) MR_COMMAND_##NAME = (code),
#include "common/catalogue.def"
};

/* Who may give it: anybody on the links (READ: it changes nothing), who runs the test, or who looks
 * after the board. */
enum mr_privilege {
    MR_PRIVILEGE_READ,
    MR_PRIVILEGE_OPEN,
    MR_PRIVILEGE_OPERATOR,
    MR_PRIVILEGE_MAINTENANCE
};

/* By what it may come, as the rows say. */
enum mr_command_links { MR_LINKS_BOTH, MR_LINKS_CABLE, MR_LINKS_JUMPER, MR_LINKS_REPLAY };

/* Bits of enum mr_landing_state: when it is obeyed. */
enum mr_command_when {
    MR_WHEN_IDLE = 1u << MR_LANDING_IDLE,
    MR_WHEN_AT_REST = MR_WHEN_IDLE | 1u << MR_LANDING_DONE,
    MR_WHEN_RECORDING = 1u << MR_LANDING_ARMED | 1u << MR_LANDING_LANDING |
                        1u << MR_LANDING_SETTLING,
    MR_WHEN_ANY = MR_WHEN_AT_REST | MR_WHEN_RECORDING,
};

/* Parse one command as people write it: `arm 5`, `survey 12 0.305` (segment, inches), `mark 1`,
 * `state`. Numbers are in the units a person uses; a missing argument is 0. `tag` goes into the
 * message. MR_OK; MR_UNKNOWN: no such command; MR_USAGE: words missing, left over, not a number or
 * out of range. */
enum mr_status mr_command_parse(const char *words, uint16_t tag, struct mr_command *command);

/* A status that refuses who gave a command, or its link, whatever it would do: a replay, which has
 * all rights, gives MR_COMMAND_NONE in its place, so that as many answers go out. */
static inline bool mr_command_giver_refused(int status)
{
    return status <= MR_CABLE && status >= MR_LOCKOUT;
}

/* Of a command code; MR_PRIVILEGE_OPEN where there is no such code. */
enum mr_privilege mr_command_privilege(unsigned code);
/* Name of a command code, or "unknown". Static storage. */
const char *mr_command_name(unsigned code);

#endif
