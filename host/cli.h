/* The command line: global options, the commands, their errors and options.
 *
 * A command gets its own words only: argv[0] is its name, argv[1..argc-1] what followed it. It returns the
 * process exit code (common/status.h: 0 ok, 1 a limit failed, 2 usage, 3 input or output, 4 malformed input,
 * 5 numerics). Results go to stdout (with --json exactly one object), everything else to stderr. `matrig
 * COMMAND --help` is answered before a command is called. */
#ifndef MATRIG_HOST_CLI_H
#define MATRIG_HOST_CLI_H

#include <jansson.h>
#include <stdbool.h>

#include "host/error.h"

struct cli {
    bool json;  /* one JSON object on stdout */
    bool quiet; /* no progress, no notes */
    bool si;    /* SI units instead of the report's */
};

int log_command(int argc, char **argv, const struct cli *cli);
int live_command(int argc, char **argv, const struct cli *cli);
int board_command(int argc, char **argv, const struct cli *cli);
int flash_command(int argc, char **argv, const struct cli *cli);
/* board's words with `config` among them */
int config_command(int argc, char **argv, const struct cli *cli);
/* board's words with `runway` among them */
int runway_command(int argc, char **argv, const struct cli *cli);
/* board's words with `arm` or `disarm` among them */
int arm_command(int argc, char **argv, const struct cli *cli);
int ready_command(int argc, char **argv, const struct cli *cli);
int gages_command(int argc, char **argv, const struct cli *cli);
int sim_command(int argc, char **argv, const struct cli *cli);
int survey_command(int argc, char **argv, const struct cli *cli);
int landing_command(int argc, char **argv, const struct cli *cli);
int series_command(int argc, char **argv, const struct cli *cli);
int calibrate_command(int argc, char **argv, const struct cli *cli);
int migrate_command(int argc, char **argv, const struct cli *cli);
int compare_command(int argc, char **argv, const struct cli *cli);
int bundle_command(int argc, char **argv, const struct cli *cli);
int predict_command(int argc, char **argv, const struct cli *cli);
int replay_command(int argc, char **argv, const struct cli *cli);
int report_command(int argc, char **argv, const struct cli *cli);
int export_command(int argc, char **argv, const struct cli *cli);
int import_command(int argc, char **argv, const struct cli *cli);
int dbc_command(int argc, char **argv, const struct cli *cli);
int scale_command(int argc, char **argv, const struct cli *cli);
int params_command(int argc, char **argv, const struct cli *cli);
int sweep_command(int argc, char **argv, const struct cli *cli);
int campaign_command(int argc, char **argv, const struct cli *cli);
int bands_command(int argc, char **argv, const struct cli *cli);
int error_command(int argc, char **argv, const struct cli *cli);
int fit_command(int argc, char **argv, const struct cli *cli);

/* Print `matrig: <line>` on stderr and return the exit code of the error's status. */
int cli_fail(const struct error *error);

/* An option of a command: `--name value`, or `--name=value`; of one letter also `-n4`. A flag takes no value. */
struct cli_option {
    const char *name;   /* with its dashes; "-o" is allowed too */
    const char **value; /* receives the value; NULL for a flag */
    bool *flag;         /* set when a flag is given */
};

/* Sort argv into options and up to `most` other words (at least `least`; `names` says what they are, for the
 * error: "DB RUN"). A word that begins with '-' and is no option, an option given twice, a missing or left
 * over word: MR_USAGE. */
enum mr_status cli_parse(int argc, char **argv, const struct cli_option *options, size_t option_count,
                         const char **words, size_t least, size_t most, const char *names,
                         struct error *error);

/* Whole text as a number, within [low, high]; else MR_USAGE naming `what`. */
enum mr_status cli_number(const char *text, const char *what, double low, double high, double *value,
                          struct error *error);

/* A note on stderr, unless --quiet. */
void cli_note(const struct cli *cli, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* Whether stderr is a terminal that may be drawn on (progress), and whether it may be coloured (NO_COLOR
 * unset). */
bool cli_terminal(void);
bool cli_colour(void);

/* Print one JSON object and a newline on stdout and release it. Returns exit_code, or 3 when stdout failed.
 */
int cli_print_json(json_t *object, int exit_code);
/* A real number as JSON; null when it is not finite. `digits` significant digits are kept. */
json_t *cli_json_number(double value, int digits);

#endif
