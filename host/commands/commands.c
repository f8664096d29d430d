#include "host/commands/commands.h"

#define COMMAND(name) &command_##name,
static const struct command *const commands[] = {
#include "host/commands/commands.def"
};
#undef COMMAND

const struct command_table command_table = {commands, sizeof commands / sizeof commands[0]};
