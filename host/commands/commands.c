#include "host/commands/commands.h"

#define COMMAND(group, name) {HELP_##group, &command_##name},
static const struct command_entry commands[] = {
#include "host/commands/commands.def"
};
#undef COMMAND

const struct command_table command_table = {commands, sizeof commands / sizeof commands[0]};
