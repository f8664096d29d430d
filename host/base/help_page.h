/* The page of a command's help, as rows: what --help prints, and completion is made from. */
#ifndef MATRIG_HOST_BASE_HELP_PAGE_H
#define MATRIG_HOST_BASE_HELP_PAGE_H

#include "host/base/command.h"

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
