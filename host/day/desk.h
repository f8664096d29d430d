/* Where a person sits: keys and lines that are typed, programs that take over for a while. Without
 * a terminal a key is a line, of which the first letter counts. */
#ifndef MATRIG_HOST_DAY_DESK_H
#define MATRIG_HOST_DAY_DESK_H

#include <stdbool.h>
#include <stddef.h>

#include "host/base/error.h"

#define DESK_ENTER '\n'
#define DESK_END   'q' /* also when there is no more to read */
#define DESK_WORDS 24

/* Ctrl-C ends the program that has taken over, not the day. */
void desk_begin(void);

/* Keys come also from there, a byte each; -1: from the keyboard alone. */
void desk_listen(int keys);
/* Forgets what came from there. */
void desk_forget(void);

/* The next key; within_ms: not longer than that, then 0 (-1: as long as it takes). */
char desk_key(int within_ms);
/* A line without its end; false: there is no more to read. Nothing is read beyond it. `*whole`: it
 * had room. */
bool desk_line(char *line, size_t size, bool *whole);
/* A question with an answer in one line, blanks around it apart; "" by Enter alone. One that is too
 * long is asked for again; of a paste the first line is taken, the rest is no key. False: nothing
 * more is typed. */
bool desk_ask(const char *question, char *answer, size_t size);

/* What is run: matrig with these words. Texts stay the caller's. */
struct desk_command {
    const char *words[DESK_WORDS]; /* [0]: the program */
    size_t count;
};
void desk_command_begin(struct desk_command *command, const char *name);
void desk_command_add(struct desk_command *command, const char *word);
/* "--serial X", unless the value is NULL or "". */
void desk_command_option(struct desk_command *command, const char *option, const char *value);
/* As a person would type it. Returns `out`. */
const char *desk_command_text(const struct desk_command *command, char *out, size_t size);

/* Runs it at this terminal until it ends; its exit code, 128 and more when a signal ended it. -1:
 * it could not be started, see `error`. */
int desk_run(const struct desk_command *command, struct error *error);

#endif
