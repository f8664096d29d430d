/* A command of matrig: its name, purpose, operands and options with their help, and the function
 * that runs it.
 *
 * The descriptor of a command is the only place where its options are written. `parts` is the page
 * of `matrig COMMAND --help` from top to bottom; command_parse accepts exactly the options in it,
 * and host/base/help.c prints help from the same rows. A new command needs a file with its
 * descriptor in host/commands/ and a row in host/commands/commands.def.
 *
 * Above the rows, the file of a command defines OPTION_VALUES, the struct that receives the values
 * of the options (all zero before command_parse):
 *
 *     #define OPTION_VALUES struct request
 *     static const struct command_part parts[] = {
 *         HELP_ITEM("DB", "campaign database"),
 *         OPTION_INTEGER("--port", "P", port, 1, 65535, 8473, "port of the page on this computer"),
 *         HELP_EXAMPLE("matrig live campaign.db --port 8474"),
 *     };
 *     const struct command command_live = {"live", live_command, "DB [--port P]", "watch a board",
 *                                          COMMAND_PARTS(parts), {1, 1, "DB"}}; */
#ifndef MATRIG_HOST_BASE_COMMAND_H
#define MATRIG_HOST_BASE_COMMAND_H

#include <stddef.h>
#include <stdint.h>

#include "host/base/cli.h"
#include "host/base/error.h"

enum option_kind {
    OPTION_NONE,
    OPTION_IS_FLAG,    /* bool; takes no value */
    OPTION_IS_TEXT,    /* const char *; NULL: not given */
    OPTION_IS_NUMBER,  /* double, in the unit `unit` */
    OPTION_IS_INTEGER, /* int64_t, a whole number within the limits */
    OPTION_IS_RUN,     /* int64_t, a RUN as parse_run returns it; 0: not given */
    OPTION_IS_CHOICE   /* const char *, one of `choices`; NULL: not given */
};

struct command_option {
    const char *name;     /* name with its dashes: "--for", "-o"; NULL: the row is not an option */
    const char *argument; /* placeholder of its value in help: "S"; NULL: a flag */
    enum option_kind kind;
    size_t offset; /* offset of its value in OPTION_VALUES */
    /* For a number: the unit of the stored value, and the unit of a plain number with --si. NULL:
     * no unit; if only unit_si is NULL, `unit` applies with --si too. */
    const char *unit, *unit_si;
    /* For a number: smallest and largest value, in `unit`, and the default. */
    double low, high, default_value;
    const char *noun, *choices; /* noun and values of a choice: "format", "csv|candump" */
};

struct command_part {
    /* Left column of the help page: "DB [RUN]". NULL for a note, and for an option, whose name and
     * argument are shown. */
    const char *term;
    /* Help text, lines separated by \n; {low}, {high} and {standard} are replaced by the limits and
     * the default of the option. NULL: another row describes the item. */
    const char *text;
    bool is_fixed_word; /* the term begins with a fixed word of the command ("read N") */
    bool is_example;
    const struct command_option option; /* option with name NULL: the row is not an option */
    /* Descriptor whose rows are all included here. Its options and words are parsed with this
     * command, as in `matrig board ... config`. */
    const struct command *included;
};

/* Words of a command line that are not options. */
struct command_operands {
    size_t min, max;
    const char *names; /* operand names for the error message: "DB RUN" */
};

struct command {
    const char *name;
    int (*run)(int argc, char **argv, const struct cli *cli);
    /* Operands and options in the usage line; each alternative has its own line. */
    const char *usage;
    const char *summary; /* purpose of the command: one line without full stop */
    const struct command_part *parts;
    size_t part_count;
    struct command_operands operands;
};

/* Groups of commands in the help, by task. */
/* clang-format off */
#define COMMAND_GROUPS(X)                                                     \
    X(DAY, "Test day: get ready, land, survey")                                \
    X(BOARD, "Board: program, configure, calibrate")                \
    X(DATA, "Data: show, compare, report and export a campaign")          \
    X(STUDIES, "Studies: simulate the mat, fit its parameters, design its bands")
/* clang-format on */

enum command_group {
#define COMMAND_GROUP(name, title) HELP_##name,
    COMMAND_GROUPS(COMMAND_GROUP)
#undef COMMAND_GROUP
};

struct command_entry {
    enum command_group group;
    const struct command *command;
};

/* All commands in the order of the help. The commands of a group are consecutive. */
struct command_table {
    const struct command_entry *commands;
    size_t count;
};

#define COMMAND_PARTS_MAX 64
/* Does not compile if the command has more rows than command_parse can handle. */
#define COMMAND_PARTS(parts)                    \
    (parts), sizeof(parts) / sizeof(parts)[0] + \
                 0 * sizeof(char[sizeof(parts) / sizeof(parts)[0] <= COMMAND_PARTS_MAX ? 1 : -1])

/* clang-format off */
/* An operand or another term, and its help. */
#define HELP_ITEM(about, help) {.term = (about), .text = (help)}
/* A fixed word of the command: "config set F". */
#define HELP_WORD(about, help) {.term = (about), .text = (help), .is_fixed_word = true}
/* Lines that are printed unchanged. A line that ends with a blank continues in the next row. */
#define HELP_NOTE(help) {.text = (help)}
/* Lines that a user can run; "Example: " precedes the first line. */
#define HELP_EXAMPLE(lines) {.text = (lines), .is_example = true}
/* Includes the rows of another descriptor. */
#define HELP_INCLUDE(descriptor) {.included = &(descriptor)}

/* Offset of a member of OPTION_VALUES. Does not compile if the member does not have the type of its
 * option. */
#define OPTION_HAS_TYPE(member, type) \
    __builtin_types_compatible_p(__typeof__(((OPTION_VALUES *)0)->member), type)
#define OPTION_OFFSET(member, type) \
    (offsetof(OPTION_VALUES, member) + 0 * sizeof(char[OPTION_HAS_TYPE(member, type) ? 1 : -1]))
#define OPTION(its_name, its_kind, member, type, help, ...)                       \
    {.text = (help), .option = {.name = (its_name), .kind = OPTION_IS_##its_kind, \
                                .offset = OPTION_OFFSET(member, type), __VA_ARGS__}}
#define OPTION_FLAG(its_name, member, help) \
    OPTION(its_name, FLAG, member, bool, help, .argument = NULL)
#define OPTION_TEXT(its_name, of_value, member, help) \
    OPTION(its_name, TEXT, member, const char *, help, .argument = (of_value))
/* A number option. A number without a unit is in `its_unit`, or with --si in `in_si`. A unit may
 * follow the number: 5mm, 2min. */
#define OPTION_NUMBER_SI(its_name, of_value, member, its_unit, in_si, least, most, normal, help) \
    OPTION(its_name, NUMBER, member, double, help, .argument = (of_value), .unit = (its_unit),   \
           .unit_si = (in_si), .low = (least), .high = (most), .default_value = (normal))
#define OPTION_NUMBER(its_name, of_value, member, its_unit, least, most, otherwise, help) \
    OPTION_NUMBER_SI(its_name, of_value, member, its_unit, NULL, least, most, otherwise, help)
#define OPTION_INTEGER(its_name, of_value, member, least, most, otherwise, help)             \
    OPTION(its_name, INTEGER, member, int64_t, help, .argument = (of_value), .low = (least), \
           .high = (most), .default_value = (otherwise))
#define OPTION_RUN(its_name, of_value, member, help) \
    OPTION(its_name, RUN, member, int64_t, help, .argument = (of_value))
#define OPTION_CHOICE(its_name, of_value, member, of_what, values, help)         \
    OPTION(its_name, CHOICE, member, const char *, help, .argument = (of_value), \
           .noun = (of_what), .choices = (values))
/* clang-format on */

/* For commands that write a file which people fill in (host/base/output.h, output_check_new). */
#define OPTION_FORCE(member) OPTION_FLAG("--force", member, "replace an existing file")

/* Global options, which stand before the command. The rows of command_matrig describe them. */
struct global_options {
    struct cli cli;
    bool version, help;
};
extern const struct command command_matrig;

/* Parses the global options; stops at the first one that asks for help or the version. Returns the
 * index of the command's name, or argc if there is none. Sets MR_USAGE in `error` for an unknown
 * option. */
int command_parse_global_options(int argc, char **argv, struct global_options *before,
                                 struct error *error);

/* Sorts argv into options, whose values go to `values` (an OPTION_VALUES), and other words (`words`
 * has room for operands.max; unused entries are NULL). Options are written `--name value` or
 * `--name=value`, one-letter options also `-n4`. Numbers that are not given get their default.
 * MR_USAGE: an unknown option, an option given twice, a missing value, a value outside its limits,
 * too few or too many words. Texts point into argv. */
enum mr_status command_parse(const struct command *command, int argc, char **argv,
                             const struct cli *cli, void *values, const char **words,
                             struct error *error);

/* Parses a RUN, the number of a landing in its database: a whole number from 1. Also accepts the
 * number of a landing on the board, such as landing5, and returns it as -5; store_find_run converts
 * it to the RUN. MR_USAGE: any other text. */
enum mr_status parse_run(const char *text, int64_t *run, struct error *error);

#endif
