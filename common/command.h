/* Commands to the board, which the host sends, run files contain, and the firmware executes.
 *
 * A command is one `command` message. The rows of common/catalogue_commands.def define its code,
 * name and argument, who may send it, when, and on which link. */
#ifndef MATRIG_COMMON_COMMAND_H
#define MATRIG_COMMON_COMMAND_H

#include <stdbool.h>

#include "common/catalogue.h"

enum mr_command_code {
    MR_COMMAND_INVALID, /* code 0, which every board refuses as unknown */
#define COMMAND(NAME, code, ...) MR_COMMAND_##NAME = (code),
#include "common/catalogue.def"
};

/* Who may send the command: anybody on the links (READ and OPEN; READ changes nothing), the
 * operator of the test, or the maintainer of the board. */
enum mr_privilege {
    MR_PRIVILEGE_READ,
    MR_PRIVILEGE_OPEN,
    MR_PRIVILEGE_OPERATOR,
    MR_PRIVILEGE_MAINTENANCE
};

/* Links by which the command may be received. */
enum mr_command_links { MR_LINKS_BOTH, MR_LINKS_CABLE, MR_LINKS_JUMPER, MR_LINKS_REPLAY };

/* States in which the command is executed, as bits of enum mr_landing_state. */
enum mr_command_states {
    MR_STATES_IDLE = 1u << MR_LANDING_IDLE,
    MR_STATES_AT_REST = MR_STATES_IDLE | 1u << MR_LANDING_DONE,
    MR_STATES_RECORDING = 1u << MR_LANDING_ARMED | 1u << MR_LANDING_LANDING |
                          1u << MR_LANDING_SETTLING,
    MR_STATES_ANY = MR_STATES_AT_REST | MR_STATES_RECORDING,
};

/* Parses one typed command: `arm 5`, `survey 12 0.305` (segment, inches), `mark 1`, `state`. A
 * missing argument is 0. `tag` is copied into the message. MR_UNKNOWN: no such command; MR_USAGE:
 * an argument is missing, superfluous, not a number or out of range. */
enum mr_status mr_command_parse(const char *text, uint16_t tag, struct mr_command *command);

/* True for statuses that refuse a command because of its sender or link, whatever the command is. A
 * replay, which would be allowed to send such a command, sends MR_COMMAND_INVALID in its place, so
 * that the number of answers is the same. */
static inline bool mr_status_is_sender_refused(int status)
{
    return status <= MR_CABLE && status >= MR_LOCKOUT;
}

/* Returns the privilege that a command code requires; MR_PRIVILEGE_OPEN for an unknown code. */
enum mr_privilege mr_command_privilege(unsigned code);
/* Returns the name of a command code, or "unknown". Static storage. */
const char *mr_command_name(unsigned code);

#endif
