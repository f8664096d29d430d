/* campaign-figures FOLDER [SEEDS [NUMBER...]]: figures 4.1 to 5.12 from the series, 4 runways each
 * when not said otherwise: an SVG file of each and one page. FOLDER holds standard_prototype.json,
 * the standard series by `matrig scale`.
 *
 * Exit: 0, whatever the verdicts are; 2 usage; 3 files; 5 a runway could not be played. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/output.h"
#include "host/base/html.h"
#include "tests/campaign_figures/figures.h"

static const char head[] =
    "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Figures 4.1 to "
    "5.12</title><style>"
    "body{font:15px/1.4 sans-serif;max-width:66em;margin:1.5em auto;padding:0 "
    "1em}table{border-collapse:collapse;font-size:13px}"
    "td,th{border:1px solid #bbb;padding:2px "
    "7px;text-align:left}.scroll{overflow-x:auto}svg{width:100%;height:auto}"
    "section{margin:1.5em 0 2.5em;break-inside:avoid}</style></head><body>\n<h1>Figures 4.1 to "
    "5.12 of the 1973 report</h1>\n"
    "<p>Its drawings are lost; these are drawn from the series of host/campaign/series as the "
    "campaign plays them. Letters mark "
    "what captions and text state; the tables say what came out, and agree means more than half of "
    "the runways. Runways differ in gaps, dirt and ground (seeds 1 to ";

static enum mr_status one(FILE *page, const char *folder, const struct figure *figure, size_t seeds,
                          struct error *error)
{
    char path[600], number[24];
    struct figure_run run;
    snprintf(number, sizeof number, "%s", figure->number);
    for (char *c = number; *c; c++)
        *c = *c == '.' || *c == ' ' || *c == '=' ? '_' : *c;
    snprintf(path, sizeof path, "%s/fig%s.svg", folder, number);
    if (figure_play(&run, figure, folder, seeds, error) == MR_OK) {
        struct output output;
        if (output_begin(&output, path, true, error) == MR_OK) {
            figure_draw(output.file, figure, &run, true);
            output_end(&output, error);
        }
        fputs("<section>\n", page);
        figure_draw(page, figure, &run, false);
        fputs("<p>Series: ", page);
        html_text(page, run.campaign.name);
        fprintf(page, "; %zu runways%s. ", run.played ? seeds : 0,
                run.played ? "" : ": not played");
        fputs(run.campaign.basis[0] ? "Basis: " : "", page);
        html_text(page, run.campaign.basis);
        fputs("</p>\n", page);
        figure_table(page, figure, &run);
        fputs("</section>\n", page);
        fprintf(stderr, "figure %s: %s\n", figure->number,
                run.played ? "drawn" : "its series awaits something");
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
    char path[600];
    size_t seeds = argc > 2 ? (size_t)strtoul(argv[2], NULL, 10) : 4;
    if (argc < 2 || seeds < 1 || seeds > 1000) {
        fputs("usage: campaign-figures FOLDER [SEEDS [NUMBER...]]\n", stderr);
        return 2;
    }
    snprintf(path, sizeof path, "%s/figures.html", argv[1]);
    struct output output;
    if (output_begin(&output, path, true, &error) == MR_OK) {
        FILE *page = output.file;
        fprintf(page, "%s%zu).</p>\n", head, seeds);
        for (size_t i = 0; i < campaign_figure_count && error.status == MR_OK; i++) {
            if (wanted(campaign_figures[i].number, argc - 3, argv + 3))
                one(page, argv[1], &campaign_figures[i], seeds, &error);
        }
        fputs("</body></html>\n", page);
        output_end(&output, &error);
    }
    if (error.status == MR_OK)
        return 0;
    fprintf(stderr, "campaign-figures: %s\n", error.text);
    return mr_status_exit_code(error.status);
}
