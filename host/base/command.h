/* What a command of matrig is: its name, what it is for, its operands and options with their help,
 * and what runs it.
 *
 * A command's descriptor is the only place where its options are written. `parts` is the page of
 * `matrig COMMAND --help` from top to bottom. The options among them are what command_parse takes,
 * and it takes no others; host/base/help.c makes help from the same rows. A
 * new command is a file with its descriptor in host/commands/, and a row in
 * host/commands/commands.def.
 *
 * Before the rows a command's file defines VALUES, the struct that takes the options' values (all
 * zero before command_parse):
 *
 *     #define VALUES struct request
 *     static const struct command_part parts[] = {
 *         HELP_ITEM("DB", "campaign database"),
 *         OPTION_WHOLE("--port", "P", port, 1, 65535, 8473,
 *                      "port of the page on this computer"),
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
    OPTION_IS_FLAG,   /* bool; takes no value */
    OPTION_IS_TEXT,   /* const char *; NULL: not given */
    OPTION_IS_NUMBER, /* double, in `unit` */
    OPTION_IS_WHOLE,  /* int64_t, a whole number */
    OPTION_IS_RUN,    /* int64_t, as run_parse has it; 0: not given */
    OPTION_IS_CHOICE  /* const char *, one of `choices`; NULL: not given */
};

struct command_option {
    const char *name;     /* with its dashes: "--for", "-o" */
    const char *argument; /* of its value, as help has it: "S"; NULL: a flag */
    enum option_kind kind;
    size_t at; /* where its value goes: offset in VALUES */
    /* of a number: of the value, and of a bare number with --si; NULL: it has none, the same */
    const char *unit, *unit_si;
    /* of a number: allowed, in `unit`; the value when the option is not given */
    double low, high, standard;
    const char *noun, *choices; /* of a choice: "format", "csv|candump" */
};

/* A row of the help page. */
struct command_part {
    /* "DB [RUN]"; NULL: an option is called by name and argument, a note has none */
    const char *term;
    /* its help, lines apart by \n; {low}, {high} and {standard} are the option's. NULL: another row
     * describes it */
    const char *text;
    bool word; /* the term begins with a word of the command ("read N") */
    bool example;
    const struct command_option option; /* name NULL: the row is none */
    /* all rows of this one stand here, and its words (matrig board ... config) parse with it */
    const struct command *with;
};

/* Words that are no options. */
struct command_operands {
    size_t least, most;
    const char *names; /* what they are, for the error: "DB RUN" */
};

struct command {
    const char *name;
    int (*run)(int argc, char **argv, const struct cli *cli);
    /* what follows the name, for the usage line; alternatives apart by " | " */
    const char *words;
    const char *summary; /* one line, no full stop */
    const struct command_part *parts;
    size_t count;
    struct command_operands operands;
};

/* Help lists the commands in groups, by who needs them when. */
/* clang-format off */
#define COMMAND_GROUPS(X)                                                     \
    X(DAY, "The day: get ready, land, survey")                                \
    X(BOARD, "The board: program, configure and calibrate it")                \
    X(DATA, "The data: show, compare, report and export a campaign")          \
    X(STUDIES, "Studies: simulate the mat, find its parameters, design its bands")
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

/* All commands, in the order in which help lists them; those of a group stand together. */
struct command_table {
    const struct command_entry *commands;
    size_t count;
};

#define COMMAND_PARTS_MAX 64
/* Does not compile with more rows than command_parse has room for. */
#define COMMAND_PARTS(parts)                    \
    (parts), sizeof(parts) / sizeof(parts)[0] + \
                 0 * sizeof(char[sizeof(parts) / sizeof(parts)[0] <= COMMAND_PARTS_MAX ? 1 : -1])

/* clang-format off */
/* An operand, or another thing to be explained, and its help. */
#define HELP_ITEM(about, help) {.term = (about), .text = (help)}
/* A word of the command's own: "config set F". */
#define HELP_WORD(about, help) {.term = (about), .text = (help), .word = true}
/* Lines as they are. One that ends with a blank goes on in the same line with what follows. */
#define HELP_NOTE(help) {.text = (help)}
/* Lines that can be run; "Example: " precedes the first one. */
#define HELP_EXAMPLE(lines) {.text = (lines), .example = true}
/* The rows of another descriptor. */
#define HELP_WITH(descriptor) {.with = &(descriptor)}

/* Offset of a member of VALUES. Does not compile when the member is of another type than its option
 * has. */
#define OPTION_IS_OF(member, type) \
    __builtin_types_compatible_p(__typeof__(((VALUES *)0)->member), type)
#define OPTION_AT(member, type) \
    (offsetof(VALUES, member) + 0 * sizeof(char[OPTION_IS_OF(member, type) ? 1 : -1]))
#define OPTION(its_name, its_kind, member, type, help, ...)                       \
    {.text = (help), .option = {.name = (its_name), .kind = OPTION_IS_##its_kind, \
                                .at = OPTION_AT(member, type), __VA_ARGS__}}
#define OPTION_FLAG(its_name, member, help) \
    OPTION(its_name, FLAG, member, bool, help, .argument = NULL)
#define OPTION_TEXT(its_name, of_value, member, help) \
    OPTION(its_name, TEXT, member, const char *, help, .argument = (of_value))
/* A bare number is in `its_unit`, with --si `in_si`; a unit may follow it: 5mm, 2min. */
#define OPTION_NUMBER_SI(its_name, of_value, member, its_unit, in_si, least, most, normal, help) \
    OPTION(its_name, NUMBER, member, double, help, .argument = (of_value), .unit = (its_unit),   \
           .unit_si = (in_si), .low = (least), .high = (most), .standard = (normal))
#define OPTION_NUMBER(its_name, of_value, member, its_unit, least, most, otherwise, help) \
    OPTION_NUMBER_SI(its_name, of_value, member, its_unit, NULL, least, most, otherwise, help)
#define OPTION_WHOLE(its_name, of_value, member, least, most, otherwise, help)             \
    OPTION(its_name, WHOLE, member, int64_t, help, .argument = (of_value), .low = (least), \
           .high = (most), .standard = (otherwise))
#define OPTION_RUN(its_name, of_value, member, help) \
    OPTION(its_name, RUN, member, int64_t, help, .argument = (of_value))
#define OPTION_CHOICE(its_name, of_value, member, of_what, values, help)         \
    OPTION(its_name, CHOICE, member, const char *, help, .argument = (of_value), \
           .noun = (of_what), .choices = (values))
/* clang-format on */

/* Of a command that writes what people fill in (host/base/output.h, output_keep). */
#define OPTION_FORCE(member) OPTION_FLAG("--force", member, "replace the file if it exists")

/* What precedes the command; its rows have the options, like those of a command. */
struct command_before {
    struct cli cli;
    bool version, help;
};
extern const struct command command_matrig;

/* Takes the options before the command; the first one that asks for help or the version ends it.
 * Returns the index of the command's name, argc when there is none. MR_USAGE in `error`: an option
 * that matrig does not have. */
int command_begin(int argc, char **argv, struct command_before *before, struct error *error);

/* Sorts argv into options, whose values go to `values` (a VALUES), and other words (`words` has
 * room for operands.most; the rest is NULL). Options: `--name value` or `--name=value`; of one
 * letter also `-n4`. Numbers that are not given get their standard. MR_USAGE: an option that the
 * command does not have, one given twice, a value that is missing or outside its limits, a word too
 * few or too many. Texts point into argv. */
enum mr_status command_parse(const struct command *command, int argc, char **argv,
                             const struct cli *cli, void *values, const char **words,
                             struct error *error);

/* RUN on the command line: the number of a landing in its database. */

/* A whole number from 1; landing5, the board's number: -5, which store_run_find turns into the RUN;
 * else MR_USAGE. */
enum mr_status run_parse(const char *text, int64_t *run, struct error *error);

#endif
