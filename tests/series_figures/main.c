/* series-figures FOLDER [SEEDS [NUMBER...]]: figures 4.1 to 5.12 from the series, 4 runways each
 * when not said otherwise: an SVG file of each, and a table of each on stdout. FOLDER holds
 * standard_prototype.json,
 * the standard series by `matrig scale`.
 *
 * Exit: 0, whatever the verdicts are; 2 usage; 3 files; 5 a runway could not be played. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/series_figures/figures.h"

static enum mr_status one(const char *folder, const struct figure *figure, size_t seeds,
                          struct error *error)
{
    char path[600], number[24];
    struct figure_run run;
    snprintf(number, sizeof number, "%s", figure->number);
    for (char *c = number; *c; c++)
        *c = *c == '.' || *c == ' ' || *c == '=' ? '_' : *c;
    snprintf(path, sizeof path, "%s/fig%s.svg", folder, number);
    if (figure_play(&run, figure, folder, seeds, error) == MR_OK) {
        printf("\n## Figure %s. %s\n\nSeries: %s. ", figure->number, figure->title,
               run.series.name);
        if (run.series.basis[0])
            printf("Basis: %s. ", run.series.basis);
        printf("%zu runways.\n\n", seeds);
        figure_table(stdout, figure, &run);
        figure_draw(path, figure, &run, error);
    }
    figure_run_free(&run);
    return error->status;
}

static bool wanted(const char *number, int count, char **list)
{
    for (int i = 0; i < count; i++) {
        if (strcmp(list[i], number) == 0)
            return true;
    }
    return count == 0;
}

int main(int argc, char **argv)
{
    struct error error = {0};
    size_t seeds = argc > 2 ? (size_t)strtoul(argv[2], NULL, 10) : 4;
    if (argc < 2 || seeds < 1 || seeds > 1000) {
        fputs("usage: series-figures FOLDER [SEEDS [NUMBER...]]\n", stderr);
        return 2;
    }
    for (size_t i = 0; i < series_figure_count && error.status == MR_OK; i++) {
        if (wanted(series_figures[i].number, argc - 3, argv + 3))
            one(argv[1], &series_figures[i], seeds, &error);
    }
    if (error.status == MR_OK)
        return 0;
    fprintf(stderr, "series-figures: %s\n", error.text);
    return mr_status_exit_code(error.status);
}
