/* How matrig and matrig-study begin and end a command. */
#ifndef MATRIG_HOST_COMMANDS_PROGRAM_H
#define MATRIG_HOST_COMMANDS_PROGRAM_H

#include <stddef.h>

#include "host/base/cli.h"
#include "host/store/store.h"

/* Checks that standard output was written. Returns exit_code; if exit_code is 0 and writing failed,
 * reports the error on standard error and returns its code. */
int program_end(int exit_code);

/* Runs a command: argv[0] is the command's name. */
int program_run(int (*run)(int argc, char **argv, const struct cli *cli), int argc, char **argv,
                const struct cli *cli);

/* Opens the campaign of a command; a failure ends the program. The campaign is closed when the
 * program ends, and uncommitted changes are rolled back. */
struct store *program_open_campaign(const char *db, enum store_mode mode);

/* As program_open_campaign, but creates the campaign if it does not exist. A mistyped name must not
 * create a campaign, so a person at the terminal is asked for confirmation; without a terminal, a
 * note is printed. */
struct store *program_open_or_create_campaign(const struct cli *cli, const char *db);
/* The two parts of program_open_or_create_campaign: program_is_new_campaign asks before a new
 * campaign is opened and returns whether it will be new; program_note_new_campaign prints the note.
 * */
bool program_is_new_campaign(const char *db);
void program_note_new_campaign(const struct cli *cli, const char *db);

/* Writes the given global options of matrig (--json, --quiet, --si) into `words`, which has room
 * for command_matrig.count, for a program that is started with them. Returns their number. The
 * options are the rows of command_matrig. */
size_t program_read_options(const char *words[], const struct cli *cli);

#endif
