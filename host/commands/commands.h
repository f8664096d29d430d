/* All commands, by name and as a table (commands.def). What a descriptor is:
 * host/base/command.h. */
#ifndef MATRIG_HOST_COMMANDS_H
#define MATRIG_HOST_COMMANDS_H

#include "host/base/command.h"

#define COMMAND(group, name) extern const struct command command_##name;
#include "host/commands/commands.def"
#undef COMMAND

/* The words of matrig board that have a file of their own; their options are theirs. */
extern const struct command command_board_config, command_board_bringup;

extern const struct command_table command_table;

#endif
