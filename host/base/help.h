/* Help texts of matrig, generated from its table of commands. */
#ifndef MATRIG_HOST_BASE_HELP_H
#define MATRIG_HOST_BASE_HELP_H

#include "host/base/command.h"
#include "host/base/spell_suggest.h"

/* Heading of a group of commands. Static storage. */
const char *help_group_title(enum command_group group);

void help_print_overview(const struct command_table *table);
void help_print_command(const struct command *command);
/* Finds a command; NULL if there is none with this name. */
const struct command *help_find(const struct command_table *table, const char *name);
/* Sets the error for an unknown command, with a suggestion if a similar name exists. */
enum mr_status help_refuse_unknown(const struct command_table *table, const char *word,
                                   struct error *error);
/* Writes "; did you mean config?" with the nearest word of the command, or "". */
void help_suggest_word(const struct command *command, const char *word,
                       char out[static SPELL_SUGGEST_TEXT_SIZE]);
void help_print_version(const struct cli *cli);

/* Runs matrig help [COMMAND]. Returns the exit code. */
int help_run(int argc, char **argv, const struct command_table *table, const struct cli *cli);

/* Rows of a command's help page. */

#define HELP_TEXT_COLUMN 17 /* column where the text of an item begins, counted from 0 */

struct help_row {
    char *term; /* term, such as "--for S"; NULL: the row is prose */
    /* paragraphs, each terminated by a newline; lines are wrapped when the page is printed */
    char *text;
};

struct help_page {
    struct help_row *row;
    size_t row_count;
};

/* Makes the page; the caller releases it with help_page_free. */
struct help_page help_page_make(const struct command *command);
void help_page_free(struct help_page *page);

/* The page as --help prints it after the usage line and the summary. The caller frees the text. */
char *help_page_text(const struct command *command);

/* Calls `each` for every row of the command, including the rows of included descriptors, in
 * order. */
void help_for_each_part(const struct command *command,
                        void (*each)(void *context, const struct command_part *part),
                        void *context);

#endif
