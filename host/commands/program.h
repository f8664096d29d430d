/* How matrig and matrig-study begin and end a command. */
#ifndef MATRIG_HOST_COMMANDS_PROGRAM_H
#define MATRIG_HOST_COMMANDS_PROGRAM_H

#include <stddef.h>

#include "host/base/cli.h"
#include "host/store/store.h"

/* Checks that everything was written to standard output. Returns exit_code. If exit_code is 0 and
 * writing failed, reports the error on standard error and returns its exit code. */
int program_end(int exit_code);

/* Runs a command: argv[0] is the command's name. */
int program_run(int (*run)(int argc, char **argv, const struct cli *cli), int argc, char **argv,
                const struct cli *cli);

/* Opens the campaign of a command. A failure ends the program. The end of the program closes the
 * campaign and rolls back uncommitted changes. */
struct store *program_open_campaign(const char *db, enum store_mode mode);

/* Opens the campaign, or creates it if it does not exist. A mistyped name must not create a
 * campaign, so a user at a terminal is asked for confirmation; without a terminal, a note is
 * printed. */
struct store *program_open_or_create_campaign(const struct cli *cli, const char *db);
/* The two parts of program_open_or_create_campaign. program_is_new_campaign asks before a new
 * campaign is opened, and returns true if the campaign is new. program_note_new_campaign prints the
 * note. */
bool program_is_new_campaign(const char *db);
void program_note_new_campaign(const struct cli *cli, const char *db);

/* Writes the global options of `cli` (--json, --quiet, --si) into `words`, for a program that is
 * started with the same options. `words` has room for command_matrig.part_count words. Returns the
 * number of options. */
size_t program_global_options(const char *words[], const struct cli *cli);

#endif
