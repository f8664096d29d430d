/* The command line: global options, how a command ends, and what it prints. host/base/command.h has
 * the options of commands.
 *
 * A command receives only its part of the command line: argv[0] is its name, argv[1..argc-1] are
 * the words after it. It returns the exit code of the process (MR_EXIT_TABLE in common/status.h).
 * Results go to stdout (with --json exactly one object), everything else to stderr. `matrig COMMAND
 * --help` is handled before a command is called. */
#ifndef MATRIG_HOST_BASE_CLI_H
#define MATRIG_HOST_BASE_CLI_H

#include <jansson.h>
#include <signal.h>
#include <stdbool.h>

#include "host/base/error.h"

struct cli {
    bool json;  /* print one JSON object on stdout */
    bool quiet; /* print no progress and no notes */
    bool si;    /* use SI units instead of the report's */
};

/* Sets the signals that end a long command: Ctrl-C, kill, and hangup of the terminal unless hangup
 * is ignored, as under nohup. */
void cli_fill_termination_signals(sigset_t *set);
/* Applies the global options. Call it before any function that can fail. From then on, a write
 * beyond the file size limit is a write error and does not raise a signal. */
void cli_begin(const struct cli *cli);
/* Prints `matrig: <line>` on stderr and returns the exit code of the error's status. With --json,
 * stdout also gets an object: {"error": line, "kind": word (error_kind_text), "exit": code}. */
int cli_fail(const struct error *error);
/* An error object for commands that run once. Setting it prints the error (cli_fail) and ends the
 * program, so the caller needs no check. Do not use it while a resource is open that is not
 * released when the process ends. */
extern struct error *const fatal;
/* Call at the end of the program. With --json, prints the JSON object of an error if no other
 * object was printed. Returns `exit_code`. */
int cli_end(int exit_code);

/* Converts the whole text to a number from `low` to `high`. Fails with MR_USAGE and `what` in the
 * message. */
enum mr_status cli_parse_number(const char *text, const char *what, double low, double high,
                                double *value, struct error *error);

/* Prints a note on stderr, unless --quiet. */
void cli_note(const struct cli *cli, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Asks at the terminal and waits for an answer; the question ends with "yes: ". Returns false for
 * any answer except `yes`. Returns true if standard input or stderr is not a terminal. */
bool cli_confirm(const char *format, ...) __attribute__((format(printf, 1, 2)));
/* True if stderr is a terminal on which progress may be drawn (TERM is not "dumb"). */
bool cli_is_stderr_terminal(void);

/* Width of stdout in columns; 100 if stdout is not a terminal. */
unsigned cli_terminal_columns(void);

/* Reports on stderr that writing to stdout failed. Returns the exit code. */
int cli_report_output_failure(void);
/* Prints one JSON object and a newline on stdout and releases it. Returns exit_code, or 3 if stdout
 * failed. */
int cli_print_json(json_t *object, int exit_code);
/* A real number as JSON, with `digits` significant digits; null if it is not finite. */
json_t *cli_json_number(double value, int digits);

#endif
