/* The command line: global options, how a command ends, what it prints (its options:
 * host/base/command.h).
 *
 * A command gets its own words only: argv[0] is its name, argv[1..argc-1] what followed it. It
 * returns the process exit code (common/status.h: 0 ok, 1 a limit failed, 2 usage, 3 input or
 * output, 4 malformed input, 5 numerics). Results go to stdout (with --json exactly one object),
 * everything else to stderr. `matrig COMMAND --help` is answered before a command is called. */
#ifndef MATRIG_HOST_BASE_CLI_H
#define MATRIG_HOST_BASE_CLI_H

#include <jansson.h>
#include <signal.h>
#include <stdbool.h>

#include "host/base/error.h"

struct cli {
    bool json;  /* one JSON object on stdout */
    bool quiet; /* no progress, no notes */
    bool si;    /* SI units instead of the report's */
};

/* The signals that ask a long command for its end: Ctrl-C, kill, and a terminal that goes away
 * unless that is ignored, as by nohup. */
void cli_end_signals(sigset_t *set);
/* What the words before the command ask for; before anything fails. A file that may not grow any
 * more is an error of writing from then on, no signal. */
void cli_begin(const struct cli *cli);
/* Print `matrig: <line>` on stderr and return the exit code of the error's status. With --json the
 * object on stdout contains it, too: {"error": line, "kind": word (error_kind), "exit": code}. */
int cli_fail(const struct error *error);
/* The error of a command that runs once, in place of one of its own: setting it calls cli_fail,
 * which prints it and ends the program, so that the caller needs no check. Not to be used while
 * something is open that the end of the process does not clean up. */
extern struct error *const fatal;
/* At the end of the program: prints that object when there was an error and no other object.
 * Returns exit_code. */
int cli_end(int exit_code);

/* Whole text as a number, within [low, high]; else MR_USAGE naming `what`. */
enum mr_status cli_number(const char *text, const char *what, double low, double high,
                          double *value, struct error *error);

/* A note on stderr, unless --quiet. */
void cli_note(const struct cli *cli, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Asks at a terminal, and waits: "... yes: ". False: another answer than `yes`. Without a terminal
 * (standard input or error) it is true. */
bool cli_confirm(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* Whether stderr is a terminal that may be drawn on (progress), and whether it may be coloured
 * (NO_COLOR unset). */
bool cli_terminal(void);

/* Columns of a line on stdout: the terminal's; 100 of what is none. */
unsigned cli_columns(void);

/* Say on stderr that stdout failed, and return the exit code of that. */
int cli_fail_output(void);
/* Print one JSON object and a newline on stdout and release it. Returns exit_code, or 3 when stdout
 * failed. */
int cli_print_json(json_t *object, int exit_code);
/* A real number as JSON; null when it is not finite. `digits` significant digits are kept. */
json_t *cli_json_number(double value, int digits);

#endif
