/* figures FOLDER: redraws figures 3.6 to 3.12 and holds R* and the best reading against the text.
 * Exit 1 when R* misses what its scenes are held to.
 * figures --table: the table alone, as host/sim/FIGURES.md has it.
 * figures --search READINGS: searches the unknown inputs; writes FOUND_FILE and FOUND_PAGE. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/figures/figures.h"

#define LEAST_READINGS 10

struct both {
    struct sheet sheet;
    struct found found;
};
static struct both both;

static void write_table(FILE *out, const void *what)
{
    const struct both *of = what;
    sheet_print(out, &of->sheet, &of->found);
}

static void write_inputs(FILE *out, const void *what)
{
    say_inputs(out, what);
}

static void write_pairs(FILE *out, const void *what)
{
    say_pairs(out, what);
}

static enum mr_status search(size_t count, struct error *error)
{
    struct search search;
    if (search_run(&search, count, error) == MR_OK) {
        both.found = found_of(&search);
        sheet_make(&both.sheet, &both.found);
        found_save(&both.found, FOUND_FILE, error);
        if (error->status == MR_OK)
            page_put(FOUND_PAGE, "numbers", write_table, &both, error);
        if (error->status == MR_OK)
            page_put(FOUND_PAGE, "inputs", write_inputs, &search, error);
        if (error->status == MR_OK)
            page_put(FOUND_PAGE, "pairs", write_pairs, &search, error);
        fprintf(stderr, "%zu readings were played\n", search.played);
    }
    search_free(&search);
    return error->status;
}

static enum mr_status show(const char *folder, struct error *error)
{
    if (found_load(&both.found, FOUND_FILE, error) != MR_OK)
        return error->status;
    const struct fact *missed = sheet_make(&both.sheet, &both.found);
    if (folder)
        draw_figures(folder, &both.found, error);
    if (error->status == MR_OK)
        write_table(stdout, &both);
    if (error->status == MR_OK && missed)
        error_set(error, MR_LIMIT, "figure %s: R* misses: %s", missed->figure, missed->text);
    return error->status;
}

int main(int argc, char **argv)
{
    struct error error = {0};
    bool table = argc == 2 && strcmp(argv[1], "--table") == 0;
    bool searches = argc == 3 && strcmp(argv[1], "--search") == 0;
    long readings = searches ? strtol(argv[2], NULL, 10) : LEAST_READINGS;
    if ((argc != 2 && !searches) || readings < LEAST_READINGS) {
        fprintf(stderr, "usage: figures FOLDER | --table | --search READINGS (%d or more)\n",
                LEAST_READINGS);
        return 2;
    }
    if (play_load(&error) == MR_OK && play_check_rstar(&error) == MR_OK) {
        if (searches)
            search((size_t)readings, &error);
        else
            show(table ? NULL : argv[1], &error);
    }
    play_free();
    if (error.status == MR_OK)
        return 0;
    fprintf(stderr, "figures: %s\n", error.text);
    return mr_status_exit_code(error.status);
}
