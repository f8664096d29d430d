/* Help: what matrig says of itself, from its table of commands. */
#ifndef MATRIG_HOST_BASE_HELP_H
#define MATRIG_HOST_BASE_HELP_H

#include "host/base/command.h"
#include "host/base/near.h"

/* What a group of commands is for. Static storage. */
const char *help_group_title(enum command_group group);

void help_overview(const struct command_table *table);
void help_command(const struct command *command);
/* NULL: there is none of this name. */
const struct command *help_find(const struct command_table *table, const char *name);
/* Sets the error: no command, and what may have been meant. */
enum mr_status help_unknown(const struct command_table *table, const char *word,
                            struct error *error);
/* "; did you mean config?" of the command's words, or "". */
void help_near_word(const struct command *command, const char *word, char out[static NEAR_TEXT]);
void help_version(const struct cli *cli);

/* matrig help [COMMAND | --bash]: exit code. */
int help_words(int argc, char **argv, const struct command_table *table, const struct cli *cli);

/* Completion for bash 4 or later, to be sourced. */
void help_bash(const struct command_table *table);

#endif
