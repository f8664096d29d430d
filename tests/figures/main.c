/* figures FOLDER: redraws figures 3.6 to 3.12 and holds R* and the best reading against the text.
 * Exit 1 when R* misses what its scenes are held to.
 * figures --table: the table alone, as host/sim/FIGURES.md has it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/figures/figures.h"

static enum mr_status show(const char *folder, struct error *error)
{
    static struct found found;
    static struct sheet sheet;
    if (found_load(&found, FOUND_FILE, error) != MR_OK)
        return error->status;
    const struct fact *missed = sheet_make(&sheet, &found);
    if (folder)
        draw_figures(folder, &found, error);
    if (error->status == MR_OK)
        sheet_print(stdout, &sheet, &found);
    if (error->status == MR_OK && missed)
        error_set(error, MR_LIMIT, "figure %s: R* misses: %s", missed->figure, missed->text);
    return error->status;
}

int main(int argc, char **argv)
{
    struct error error = {0};
    if (argc != 2) {
        fputs("usage: figures FOLDER | --table\n", stderr);
        return 2;
    }
    if (play_load(&error) == MR_OK && play_check_rstar(&error) == MR_OK)
        show(strcmp(argv[1], "--table") == 0 ? NULL : argv[1], &error);
    play_free();
    if (error.status == MR_OK)
        return 0;
    fprintf(stderr, "figures: %s\n", error.text);
    return mr_status_exit_code(error.status);
}
