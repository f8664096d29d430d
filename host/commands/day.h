/* Parts of the command matrig day: keyboard input, starting of commands, questions for records. */
#ifndef MATRIG_HOST_COMMANDS_DAY_H
#define MATRIG_HOST_COMMANDS_DAY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/analyse/inspection.h"
#include "host/base/error.h"
#include "host/store/store.h"

/* Asks a question and reads a line without surrounding blanks. Returns false if the line is q, or
 * at the end of input. Does not buffer stdin, so that a command that is started later can read the
 * rest of the input. */
bool day_ask(const char *question, char *line, size_t size);
/* Prints the error, if there is one, and clears it. */
void day_print_error(struct error *error);

/* A command line of matrig. The texts belong to the caller. */
#define DAY_WORDS_MAX (INSPECTION_FIELDS_MAX + 8)
struct command_line {
    const char *words[DAY_WORDS_MAX]; /* words[0] is the path of matrig */
    size_t count;
};
struct command_line day_make_command_line(const char *command, const char *word);
void day_add_word(struct command_line *line, const char *word);
/* Adds an option with its value, such as "--serial X". Adds nothing if the value is "". */
void day_add_option(struct command_line *line, const char *option, const char *value);
/* Returns the command line as a user would type it. The caller frees the text. */
char *day_format_command_line(const struct command_line *line);
/* Runs a command at this terminal until it ends. Ctrl-C ends the command but not matrig day.
 * Returns true if the command succeeds. */
bool day_run_command_line(const struct command_line *line, struct error *error);

/* Asks for records of landing `run`, for every kind of which the campaign already has records. */
void day_ask_records(struct store *store, const char *db, int64_t run, struct error *error);

#endif
