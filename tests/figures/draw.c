/* Drawing: a figure is two plots over one distance axis: height of the mat, and how far each mat
 * has moved. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/output.h"
#include "host/base/html.h"
#include "host/base/svg.h"
#include "host/base/svg_words.h"
#include "tests/figures/figures.h"

#define CURVES   4
#define STATED   2
#define RUNS_MAX 40

struct curve {
    const char *scene;
    int time;
    const char *text;
};

/* A number that the text states: u of a mat, or height of a node, of one of the curves; node 0: a
 * height as such. The words stand at dx, dy pixels from it. */
struct stated {
    int curve, number;
    double value_ft;
    const char *text;
    bool height;
    double dx, dy;
};

static const struct figure {
    const char *number, *title;
    double to_ft; /* end of the distance axis */
    struct curve curves[CURVES];
    struct stated stated[STATED];
} figures[] = {
    {"3.6",
     "Early bow wave, tightly compressed mat (KL 16e6 lb/ft)",
     60,
     {{"rstar_fig3_6", 0, "after 1 mat"},
      {"rstar_fig3_6", 1, "after 2 mats"},
      {"rstar_fig3_6", 2, "after 3 mats"}},
     {{2, 4, 0.056, "text: 0.056 ft", false, 30, 45}}},
    {"3.7",
     "Early bow wave, moderately compressed mat (KL 8e6 lb/ft)",
     60,
     {{"rstar_fig3_7", 0, "after 1 mat"},
      {"rstar_fig3_7", 1, "after 2 mats"},
      {"rstar_fig3_7", 2, "after 3 mats"}},
     {{2, 4, 0.1036, "text: 0.1036 ft", false, 8, 18}}},
    {"3.8",
     "Joint elasticity, after 2 mats",
     60,
     {{"rstar_fig3_8_stiff", 1, "KL 16e6"},
      {"rstar_fig3_8_middle", 1, "KL 16e5"},
      {"rstar_fig3_8_soft", 1, "KL 16e4"},
      {"rstar_fig3_8_middle", 0, "KL 16e5 after 1 mat"}},
     {{3, 12, 0.0075, "text, after 1 mat: 0.0075 ft", false, 26, -72},
      {3, 16, 0.73e-7, "text: 0.73e-7 ft", false, 26, -52}}},
    {"3.9",
     "Friction between mat and ground, three mats not flat, after 2 mats",
     60,
     {{"rstar_fig3_9_f05", 1, "f 0.5"}, {"rstar_fig3_9_f09", 1, "f 0.9"}, {NULL, 0, NULL}},
     {{0}}},
    {"3.10",
     "Friction between mat and ground, two mats not flat, after 2 mats",
     60,
     {{"rstar_fig3_10_f05", 1, "f 0.5"}, {"rstar_fig3_10_f09", 1, "f 0.9"}, {NULL, 0, NULL}},
     {{0}}},
    {"3.11",
     "Horizontal thrust, after 2.5 mats",
     60,
     {{"rstar_fig3_11_24000", 2, "24,000 lb"},
      {"rstar_fig3_11_12000", 2, "12,000 lb"},
      {"rstar_fig3_11_6000", 2, "6,000 lb"}},
     {{1, 6, 0.25, "text: 3 in (12,000 lb)", true, 90, -5},
      {0, 0, 1.0, "text: over 1 ft (24,000 lb)", true, -8, -5}}},
    {"3.12",
     "Parameters of the physical model, TAD 10 and 1 degrees (right end free, 12,375 lb)",
     60,
     {{"rstar_fig3_12_free", 1, "TAD 10, after 2 mats"},
      {"rstar_fig3_12_free", 3, "TAD 10, after 4 mats"},
      {"rstar_fig3_12_free_tad1", 1, "TAD 1, after 2 mats"}},
     {{1, 4, 0.1612, "text: 0.1612 ft", false, 8, 18}}},
};
#define FIGURES (sizeof figures / sizeof figures[0])

static const char style[] =
    "svg{background:#fff;font:11px sans-serif}.frame{fill:none;stroke:#888}.grid{stroke:#e4e4e4}"
    ".tick,.label{fill:#333}.c0{stroke:#0b5cad;stroke-width:1.6;fill:none}"
    ".c1{stroke:#c2410c;stroke-width:1.6;fill:none}.c2{stroke:#15803d;stroke-width:1.6;fill:none}"
    ".c3{stroke:#7e22ce;stroke-width:1.6;fill:none}.wheel{stroke:#777;stroke-dasharray:3 "
    "3;fill:none}"
    ".w0,.w1,.w2,.w3{stroke-dasharray:3 3;stroke-width:1}"
    ".stated{fill:#fff;stroke:#000;stroke-width:1.4}.bound{stroke:#000;stroke-dasharray:7 "
    "4;fill:none}"
    ".lead{stroke:#000;stroke-width:.6;fill:none}"
    ".note{fill:#000;font-style:italic;stroke:#fff;stroke-width:3px;paint-order:stroke}";
static const char *const classes[CURVES] = {"c0", "c1", "c2", "c3"};
/* Where the curves are of different times, each wheel has its curve's colour. */
static const char *const wheels[CURVES] = {"c0 w0", "c1 w1", "c2 w2", "c3 w3"};

static struct run *runs;
static size_t run_total;

/* Each scene is run once. */
static const struct run *run_of(const char *scene, struct error *error)
{
    for (size_t i = 0; i < run_total; i++) {
        if (strcmp(runs[i].scene, scene) == 0)
            return &runs[i];
    }
    if (run_total == RUNS_MAX) {
        error_set(error, MR_FULL, "too many scenes: %s; raise RUNS_MAX", scene);
        return NULL;
    }
    return run_scene(&runs[run_total], scene, error) == MR_OK ? &runs[run_total++] : NULL;
}

static size_t nodes_within(const double *x, size_t count, double to_ft)
{
    size_t within = 0;
    while (within < count && x[within] <= to_ft)
        within++;
    return within < count ? within + 1 : count; /* up to the edge, clipped there */
}

static void draw_stated(const struct svg_plot *plot, const struct stated *stated,
                        const struct profile *p)
{
    if (stated->number == 0) {
        const double x[2] = {plot->x.low, plot->x.high},
                     y[2] = {stated->value_ft, stated->value_ft};
        svg_line(plot, "bound", x, y, 2);
        svg_text(plot, "note", "end", plot->x.high, stated->value_ft, stated->dx, stated->dy,
                 stated->text);
        return;
    }
    double x = (stated->height ? p->x_ft : p->station_ft)[stated->number - 1];
    double px = svg_x(plot, x), py = svg_y(plot, stated->value_ft);
    if (stated->dx > 20) /* words that stand away */
        fprintf(plot->out, "<path class=\"lead\" d=\"M%.1f %.1fL%.1f %.1f\"/>\n", px, py,
                px + stated->dx - 3, py + stated->dy - 3);
    svg_mark(plot->out, "stated", 3, px, py, 3.6);
    svg_text(plot, "note", "start", x, stated->value_ft, stated->dx, stated->dy, stated->text);
}

static bool same_time(const struct profile *const *profiles)
{
    for (int c = 1; c < CURVES && profiles[c]; c++) {
        if (fabs(profiles[c]->wheel_ft - profiles[0]->wheel_ft) > 1e-6)
            return false;
    }
    return true;
}

static void draw_panel(FILE *out, const struct figure *figure,
                       const struct profile *const *profiles, const struct run *run, bool heights,
                       double top)
{
    double low = 0, high = heights ? 0.05 : 0.01;
    for (int c = 0; c < CURVES && figure->curves[c].scene; c++) {
        const double *values = heights ? profiles[c]->height_ft : profiles[c]->u_ft;
        for (int i = 0; i < run->mats; i++) {
            low = fmin(low, values[i]);
            high = fmax(high, values[i]);
        }
    }
    svg_widen(&low, &high, 0.01);
    struct svg_plot plot = {
        .out = out,
        .left = 70,
        .top = top,
        .width = 620,
        .height = 150,
        .x = {0, figure->to_ft, heights ? NULL : "distance from the left edge of mat 1, ft", true},
        .y = {low, high, heights ? "height of the mat, ft" : "moved downfield, ft", true},
    };
    svg_axes(&plot);
    for (int c = 0; c < CURVES && figure->curves[c].scene; c++) {
        const struct profile *p = profiles[c];
        const double *x = heights ? p->x_ft : p->station_ft;
        const double wheel_x[2] = {p->wheel_ft, p->wheel_ft}, wheel_y[2] = {low, high};
        svg_line(&plot, same_time(profiles) ? "wheel" : wheels[c], wheel_x, wheel_y, 2);
        svg_line(&plot, classes[c], x, heights ? p->height_ft : p->u_ft,
                 nodes_within(x, (size_t)run->mats + (heights ? 1 : 0), figure->to_ft));
    }
    for (int i = 0; i < STATED && figure->stated[i].text; i++) {
        if (figure->stated[i].height == heights)
            draw_stated(&plot, &figure->stated[i], profiles[figure->stated[i].curve]);
    }
}

static enum mr_status draw_figure(FILE *out, const struct figure *figure, struct error *error)
{
    const struct profile *profiles[CURVES] = {NULL};
    const struct run *run = NULL;
    struct svg_key keys[CURVES + 1];
    size_t count = 0;
    char title[160];
    for (int c = 0; c < CURVES && figure->curves[c].scene; c++) {
        run = run_of(figure->curves[c].scene, error);
        if (!run)
            return error->status;
        profiles[c] = &run->at[figure->curves[c].time];
        keys[count++] = (struct svg_key){classes[c], figure->curves[c].text};
    }
    keys[count++] = (struct svg_key){"wheel", "wheel then"};
    snprintf(title, sizeof title, "Figure %s. %s", figure->number, figure->title);
    svg_open_file(out, 720, 430, title);
    fprintf(out, "<style>%s</style>\n<rect width=\"720\" height=\"430\" fill=\"#fff\"/>\n", style);
    fprintf(out, "<text class=\"label\" x=\"70\" y=\"18\" font-weight=\"bold\">%s</text>\n", title);
    svg_legend(out, 70, 700, 36, keys, count);
    draw_panel(out, figure, profiles, run, true, 48);
    draw_panel(out, figure, profiles, run, false, 230);
    svg_close(out);
    return MR_OK;
}

static void cell_value(FILE *out, const struct row *row, double value)
{
    if (!isfinite(value))
        html_cell(out, "in words");
    else if (row->quantity == VERDICT)
        html_cell(out, "%s", value > 0 ? "bow wave" : "none");
    else
        html_cell(out, "%.4g ft", value);
}

static enum mr_status write_table(FILE *out, struct error *error)
{
    static const char *const heads[] = {"figure", "the text",   "scene", "text",
                                        "ours",   "difference", "",      NULL};
    html_table(out, heads);
    for (size_t i = 0; i < row_count; i++) {
        const struct row *row = &rows[i];
        const struct run *run = run_of(row->scene, error);
        if (!run)
            return error->status;
        double ours = row_value(row, run), off = ours - row->stated;
        bool held = row->within > 0, met = fabs(off) <= row->within * fmax(fabs(row->stated), 1e-3);
        if (row->quantity == VERDICT)
            met = off == 0;
        else if (row->stated == 0)
            met = fabs(ours) < 1e-9;
        fputs("<tr>", out);
        html_cell(out, "%s", row->figure);
        html_cell(out, "%s", row->text);
        html_cell(out, "%s", row->scene);
        cell_value(out, row, row->stated);
        cell_value(out, row, ours);
        if (row->quantity == VERDICT || !isfinite(row->stated) || row->stated == 0)
            html_cell(out, "%s", isfinite(row->stated) ? met ? "agrees" : "DIFFERS" : "");
        else
            html_cell(out, "%+.1f %%",
                      fabs(off) < 5e-4 * row->stated ? 0.0 : 100 * off / row->stated);
        html_cell(out, "%s", row->note);
        fputs("</tr>\n", out);
        if (held && !met)
            return error_set(error, MR_LIMIT, "figure %s: %s: ours is %.6g; the text says %.6g",
                             row->figure, row->text, ours, row->stated);
    }
    fputs("</table>\n", out);
    return MR_OK;
}

static enum mr_status write_file(const char *folder, const char *name, const struct figure *figure,
                                 struct error *error)
{
    char path[300];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    struct output output;
    if (output_begin(&output, path, true, error) != MR_OK)
        return error->status;
    FILE *out = output.file;
    if (figure) {
        draw_figure(out, figure, error);
    } else {
        fputs(
            "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Figures 3.6 to "
            "3.12</title><style>"
            "body{font:15px sans-serif;max-width:60em;margin:2em "
            "auto}table{border-collapse:collapse}"
            "td,th{border:1px solid #ccc;padding:3px 8px;text-align:left}"
            "td:nth-child(n+3):nth-child(-n+6){white-space:nowrap}</style></head><body>\n"
            "<h1>Figures 3.6 to 3.12 of the 1973 report</h1>\n<p>Its prints are lost; these are "
            "drawn from "
            "the scenes of "
            "host/scenes as its text describes them. Height is up; a dashed upright line is the "
            "wheel; "
            "what the text states is marked in black. Lifts are in ft.</p>\n",
            out);
        write_table(out, error);
        for (size_t i = 0; error->status == MR_OK && i < FIGURES; i++) {
            fputs("<p>", out);
            draw_figure(out, &figures[i], error);
            fputs("</p>\n", out);
        }
        fputs("</body></html>\n", out);
    }
    return output_end(&output, error);
}

enum mr_status draw_figures(const char *folder, struct error *error)
{
    runs = calloc(RUNS_MAX, sizeof *runs);
    if (!runs)
        return error_set(error, MR_FULL, "out of memory: runs of the figures");
    for (size_t i = 0; error->status == MR_OK && i < FIGURES; i++) {
        char name[40];
        snprintf(name, sizeof name, "fig%s.svg", figures[i].number);
        *strchr(name, '.') = '_';
        write_file(folder, name, &figures[i], error);
    }
    if (error->status == MR_OK)
        write_file(folder, "figures.html", NULL, error);
    if (error->status == MR_OK) {
        printf("%-6s %-66s %12s %12s\n", "figure", "the text", "text", "ours");
        for (size_t i = 0; i < row_count; i++) {
            const struct run *run = run_of(rows[i].scene, error);
            char stated[24] = "";
            if (isfinite(rows[i].stated))
                snprintf(stated, sizeof stated, "%.4g", rows[i].stated);
            printf("%-6s %-66s %12s %12.4g\n", rows[i].figure, rows[i].text, stated,
                   run ? row_value(&rows[i], run) : (double)NAN);
        }
    }
    free(runs);
    return error->status;
}
