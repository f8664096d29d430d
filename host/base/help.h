/* Help: what matrig says of itself, from its table of commands. */
#ifndef MATRIG_HOST_BASE_HELP_H
#define MATRIG_HOST_BASE_HELP_H

#include "host/base/command.h"
#include "host/base/spell_suggest.h"

/* What a group of commands is for. Static storage. */
const char *help_group_title(enum command_group group);

void help_overview(const struct command_table *table);
void help_command(const struct command *command);
/* NULL: there is none of this name. */
const struct command *help_find(const struct command_table *table, const char *name);
/* Sets the error: no command, and what may have been meant. */
enum mr_status help_unknown(const struct command_table *table, const char *word,
                            struct error *error);
/* "; did you mean config?" of the command's words, or "". */
void help_suggest_word(const struct command *command, const char *word,
                       char out[static SPELL_SUGGEST_TEXT]);
void help_version(const struct cli *cli);

/* matrig help [COMMAND]: exit code. */
int help_words(int argc, char **argv, const struct command_table *table, const struct cli *cli);

/* The page of a command's help, as rows: what --help prints. */

#define HELP_TEXT_COLUMN 17 /* where the text of an item begins, from 0 */

struct help_row {
    char *term; /* "--for S"; NULL: lines of prose, with their examples */
    char *text; /* lines, each with its newline; those of an item without their indent */
};

struct help_page {
    struct help_row *row;
    size_t rows;
};

/* The caller releases it with help_page_free. */
struct help_page help_page_make(const struct command *command);
void help_page_free(struct help_page *page);

/* All of it as --help prints it, behind the usage line and the summary; the caller frees it. */
char *help_page_text(const struct command *command);

/* Calls `each` for the command's rows and those of the descriptors that it contains, in order. */
void help_each_part(const struct command *command,
                    void (*each)(void *context, const struct command_part *part), void *context);

#endif
