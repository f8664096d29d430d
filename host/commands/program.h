/* What matrig and matrig-study have in common around a command: how it begins and ends. */
#ifndef MATRIG_HOST_COMMANDS_PROGRAM_H
#define MATRIG_HOST_COMMANDS_PROGRAM_H

#include <stddef.h>

#include "host/base/cli.h"
#include "host/store/store.h"

/* What was printed must have arrived: returns exit_code, or when exit_code is 0 and standard output
 * failed, the code of that error, which is then told on standard error. */
int program_end(int exit_code);

/* Runs a command: argv[0] is the command's name. */
int program_run(int (*run)(int argc, char **argv, const struct cli *cli), int argc, char **argv,
                const struct cli *cli);

/* Opens the campaign of a command. It is closed when the program ends, and what was not committed
 * is taken back. One that cannot be opened ends the program. */
struct store *program_campaign(const char *db, enum store_mode mode);

/* The same, made when there is none: a name that was mistyped is no new campaign, so a person is
 * asked, and who runs without one is told. */
struct store *program_campaign_or_new(const struct cli *cli, const char *db);
/* That question alone, before it is opened: whether it will be new; and what is told then. */
bool program_new(const char *db);
void program_tell_new(const struct cli *cli, const char *db);

/* matrig's own options (--json, --quiet, --si), as they were given, into `words`, which has room
 * for command_matrig.count: for a program that is started with them. Returns how many. The rows
 * tell which they are. */
size_t program_options(const char *words[], const struct cli *cli);

#endif
