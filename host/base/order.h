/* The order of a command's words: those that are plainly in each other's place are named. */
#ifndef MATRIG_HOST_BASE_ORDER_H
#define MATRIG_HOST_BASE_ORDER_H

#include "host/base/command.h"

/* MR_USAGE: a campaign and the number of a landing, or another file, or a name, are swapped; a link
 * and an image; a word is empty. `name`: of the command as it was typed. */
enum mr_status order_check(const struct command *command, const char *name, const char **words,
                           size_t count, struct error *error);

/* The file is an SQLite database, as campaigns are. */
bool order_is_database(const char *path);

#endif
