/* Drawing: a figure is two plots over one distance axis: height of the mat, and how far each mat
 * has moved. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/output.h"
#include "host/base/svg.h"
#include "host/base/svg_words.h"
#include "tests/figures/figures.h"

#define CURVES 4
#define STATED 2

struct curve {
    enum run_id run;
    int time; /* of the run's own */
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
     {{RUN_36, 0, "after 1 mat"}, {RUN_36, 1, "after 2 mats"}, {RUN_36, 2, "after 3 mats"}},
     {{2, 4, 0.056, "text: 0.056 ft", false, 30, 45}}},
    {"3.7",
     "Early bow wave, moderately compressed mat (KL 8e6 lb/ft)",
     60,
     {{RUN_37, 0, "after 1 mat"}, {RUN_37, 1, "after 2 mats"}, {RUN_37, 2, "after 3 mats"}},
     {{2, 4, 0.1036, "text: 0.1036 ft", false, 8, 18}}},
    {"3.8",
     "Joint elasticity, after 2 mats",
     60,
     {{RUN_38_STIFF, 1, "KL 16e6"},
      {RUN_38_MIDDLE, 1, "KL 16e5"},
      {RUN_38_SOFT, 1, "KL 16e4"},
      {RUN_38_MIDDLE, 0, "KL 16e5 after 1 mat"}},
     {{3, 12, 0.0075, "text, after 1 mat: 0.0075 ft", false, 26, -72},
      {3, 16, 0.73e-7, "text: 0.73e-7 ft", false, 26, -52}}},
    {"3.9",
     "Friction between mat and ground, three mats not flat, after 2 mats",
     60,
     {{RUN_39_F05, 1, "f 0.5"}, {RUN_39_F09, 1, "f 0.9"}, {0}},
     {{0}}},
    {"3.10",
     "Friction between mat and ground, two mats not flat, after 2 mats",
     60,
     {{RUN_310_F05, 1, "f 0.5"}, {RUN_310_F09, 1, "f 0.9"}, {0}},
     {{0}}},
    {"3.11",
     "Horizontal thrust, after 2.5 mats",
     60,
     {{RUN_311_24, 2, "24,000 lb"}, {RUN_311_12, 2, "12,000 lb"}, {RUN_311_6, 2, "6,000 lb"}},
     {{1, 6, 0.25, "text: 3 in (12,000 lb)", true, 90, -5},
      {0, 0, 1.0, "text: over 1 ft (24,000 lb)", true, -8, -5}}},
    {"3.12",
     "Parameters of the physical model, TAD 10 and 1 degrees",
     60,
     {{RUN_312_TAD10, 1, "TAD 10, after 2 mats"},
      {RUN_312_TAD10, 3, "TAD 10, after 4 mats"},
      {RUN_312_TAD1, 1, "TAD 1, after 2 mats"}},
     {{1, 4, 0.1612, "text: 0.1612 ft", false, 8, 18}}},
};
#define FIGURES (sizeof figures / sizeof figures[0])

/* A reading that is drawn, and how its files begin. */
struct drawn {
    const char *name, *file;
    struct reading reading;
};

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

static bool same_time(const struct profile *profiles, int count)
{
    for (int c = 1; c < count; c++) {
        if (fabs(profiles[c].wheel_ft - profiles[0].wheel_ft) > 1e-6)
            return false;
    }
    return true;
}

static void draw_panel(FILE *out, const struct figure *figure, const struct profile *profiles,
                       int count, bool heights, double top)
{
    double low = 0, high = heights ? 0.05 : 0.01;
    for (int c = 0; c < count; c++) {
        const double *values = heights ? profiles[c].height_ft : profiles[c].u_ft;
        for (int i = 0; i < profiles[c].mats; i++) {
            low = fmin(low, values[i]);
            high = fmax(high, values[i]);
        }
    }
    for (int i = 0; i < STATED && figure->stated[i].text; i++) {
        if (figure->stated[i].height == heights)
            high = fmax(high, figure->stated[i].value_ft);
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
    for (int c = 0; c < count; c++) {
        const struct profile *p = &profiles[c];
        const double *x = heights ? p->x_ft : p->station_ft;
        const double wheel_x[2] = {p->wheel_ft, p->wheel_ft}, wheel_y[2] = {low, high};
        svg_line(&plot, same_time(profiles, count) ? "wheel" : wheels[c], wheel_x, wheel_y, 2);
        svg_line(&plot, classes[c], x, heights ? p->height_ft : p->u_ft,
                 nodes_within(x, (size_t)p->mats + (heights ? 1 : 0), figure->to_ft));
    }
    for (int i = 0; i < STATED && figure->stated[i].text; i++) {
        if (figure->stated[i].height == heights)
            draw_stated(&plot, &figure->stated[i], &profiles[figure->stated[i].curve]);
    }
}

/* A figure by a reading, played once. */
struct scene_set {
    struct profile profiles[CURVES];
    int count;
};

static enum mr_status play_figure(struct scene_set *set, const struct figure *figure,
                                  const struct reading *reading, struct error *error)
{
    for (; set->count < CURVES && figure->curves[set->count].text; set->count++) {
        const struct curve *curve = &figure->curves[set->count];
        if (play_profile(&set->profiles[set->count], curve->run, reading, curve->time, error) !=
            MR_OK)
            break;
    }
    return error->status;
}

static void draw_figure(FILE *out, const struct figure *figure, const struct drawn *drawn,
                        const struct scene_set *set)
{
    struct svg_key keys[CURVES + 1];
    char title[160];
    for (int c = 0; c < set->count; c++)
        keys[c] = (struct svg_key){classes[c], figure->curves[c].text};
    keys[set->count] = (struct svg_key){"wheel", "wheel then"};
    snprintf(title, sizeof title, "Figure %s, %s. %s", figure->number, drawn->name, figure->title);
    svg_open_file(out, 720, 430, title);
    fprintf(out, "<style>%s</style>\n<rect width=\"720\" height=\"430\" fill=\"#fff\"/>\n", style);
    fprintf(out, "<text class=\"label\" x=\"70\" y=\"18\" font-weight=\"bold\">%s</text>\n", title);
    svg_legend(out, 70, 700, 36, keys, (size_t)set->count + 1);
    draw_panel(out, figure, set->profiles, set->count, true, 48);
    draw_panel(out, figure, set->profiles, set->count, false, 230);
    svg_close(out);
}

static const char head[] =
    "<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Figures 3.6 to "
    "3.12</title><style>body{font:15px sans-serif;max-width:60em;margin:2em auto}"
    "table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:3px 8px;text-align:left}"
    "</style></head><body>\n<h1>Figures 3.6 to 3.12 of the 1973 report</h1>\n<p>Its prints are "
    "lost; these are drawn as its text describes them, first by the reading R*, which the scenes "
    "of "
    "host/scenes have (in 3.12 with the right end free and 12,375 lb), then by the best reading "
    "that "
    "a search has found. Height is up; a dashed upright line is the wheel; what the text states is "
    "marked in "
    "black. The table has every number and statement of the text (host/sim/FIGURES.md says what "
    "is asked and how the best reading was found). Lengths are in ft, bow waves in the lift that "
    "is called one.</p>\n";

static enum mr_status write_figure(const char *folder, const struct figure *figure,
                                   const struct drawn *drawn, const struct scene_set *set,
                                   struct error *error)
{
    char path[300];
    struct output output;
    int at = snprintf(path, sizeof path, "%s/%s", folder, drawn->file);
    snprintf(path + at, sizeof path - (size_t)at, "3_%s.svg", figure->number + 2);
    if (output_begin(&output, path, true, error) != MR_OK)
        return error->status;
    draw_figure(output.file, figure, drawn, set);
    return output_end(&output, error);
}

enum mr_status draw_figures(const char *folder, const struct sheet *sheet,
                            const struct found *found, struct error *error)
{
    static struct scene_set sets[2 * FIGURES];
    struct drawn drawn[] = {{"R*", "fig", reading_rstar()},
                            {"best reading", "best", found->best[SEARCH_ALL]}};
    char path[300];
    struct output output;
    /* as host/scenes/rstar_fig3_12_free.json: the far end does not push back */
    drawn[0].reading.value[IN_RIGHT312] = 1;
    drawn[0].reading.value[IN_F312] = 12375;
    for (size_t i = 0; error->status == MR_OK && i < 2 * FIGURES; i++) {
        if (play_figure(&sets[i], &figures[i / 2], &drawn[i % 2].reading, error) == MR_OK)
            write_figure(folder, &figures[i / 2], &drawn[i % 2], &sets[i], error);
    }
    snprintf(path, sizeof path, "%s/figures.html", folder);
    if (error->status != MR_OK || output_begin(&output, path, true, error) != MR_OK)
        return error->status;
    fputs(head, output.file);
    sheet_print(output.file, sheet, found, true);
    for (size_t i = 0; i < 2 * FIGURES; i++) {
        fputs("<p>", output.file);
        draw_figure(output.file, &figures[i / 2], &drawn[i % 2], &sets[i]);
        fputs("</p>\n", output.file);
    }
    fputs("</body></html>\n", output.file);
    return output_end(&output, error);
}
