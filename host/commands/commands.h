/* All commands, by name and as a table (commands.def). host/base/command.h describes what a command
 * consists of. */
#ifndef MATRIG_HOST_COMMANDS_H
#define MATRIG_HOST_COMMANDS_H

#include "host/base/command.h"

#define COMMAND(group, name) extern const struct command command_##name;
#include "host/commands/commands.def"
#undef COMMAND

/* subcommands of matrig board that have files and options of their own */
extern const struct command command_board_config, command_board_bringup;

extern const struct command_table command_table;

#endif
