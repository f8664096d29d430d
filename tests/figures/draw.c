/* Drawing: a figure is two plots over one distance axis: height of the mat, and how far each mat
 * has moved. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/base/plot.h"
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
     {{2, 4, 0.056, "text: 0.056 ft", false}}},
    {"3.7",
     "Early bow wave, moderately compressed mat (KL 8e6 lb/ft)",
     60,
     {{RUN_37, 0, "after 1 mat"}, {RUN_37, 1, "after 2 mats"}, {RUN_37, 2, "after 3 mats"}},
     {{2, 4, 0.1036, "text: 0.1036 ft", false}}},
    {"3.8",
     "Joint elasticity, after 2 mats",
     60,
     {{RUN_38_STIFF, 1, "KL 16e6"},
      {RUN_38_MIDDLE, 1, "KL 16e5"},
      {RUN_38_SOFT, 1, "KL 16e4"},
      {RUN_38_MIDDLE, 0, "KL 16e5 after 1 mat"}},
     {{3, 12, 0.0075, "text, after 1 mat: 0.0075 ft", false},
      {3, 16, 0.73e-7, "text: 0.73e-7 ft", false}}},
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
     {{1, 6, 0.25, "text: 3 in (12,000 lb)", true},
      {0, 0, 1.0, "text: over 1 ft (24,000 lb)", true}}},
    {"3.12",
     "Parameters of the physical model, TAD 10 and 1 degrees",
     60,
     {{RUN_312_TAD10, 1, "TAD 10, after 2 mats"},
      {RUN_312_TAD10, 3, "TAD 10, after 4 mats"},
      {RUN_312_TAD1, 1, "TAD 1, after 2 mats"}},
     {{1, 4, 0.1612, "text: 0.1612 ft", false}}},
};
#define FIGURES (sizeof figures / sizeof figures[0])

static size_t nodes_within(const double *x, size_t count, double to_ft)
{
    size_t within = 0;
    while (within < count && x[within] <= to_ft)
        within++;
    return within < count ? within + 1 : count; /* up to the edge, clipped there */
}

static void draw_stated(struct plot *plot, const struct stated *stated, const struct profile *p)
{
    const struct plot_series at = {.kind = stated->number ? PLOT_POINTS : PLOT_LEVELS,
                                   .key = stated->text,
                                   .colour = 5,
                                   .shape = 3,
                                   .open = true,
                                   .dashed = true,
                                   .x = stated->number == 0 ? NULL
                                      : stated->height      ? &p->x_ft[stated->number - 1]
                                                            : &p->station_ft[stated->number - 1],
                                   .y = &stated->value_ft,
                                   .count = 1};
    plot_draw(plot, &at);
}

static void draw_panel(struct plot *plot, const struct figure *figure,
                       const struct profile *profiles, bool heights)
{
    plot_panel(
        plot, NULL,
        (struct plot_axis){"distance from the left edge of mat 1 (ft)", 0, figure->to_ft, false},
        (struct plot_axis){.label = heights ? "height of the mat (ft)" : "moved downfield (ft)"});
    for (unsigned c = 0; c < CURVES && figure->curves[c].text; c++) {
        const struct profile *p = &profiles[c];
        const double *x = heights ? p->x_ft : p->station_ft;
        plot_draw(plot, &(struct plot_series){
                            .kind = PLOT_LINE,
                            .key = figure->curves[c].text,
                            .colour = c,
                            .x = x,
                            .y = heights ? p->height_ft : p->u_ft,
                            .count = nodes_within(x, (size_t)p->mats + heights, figure->to_ft)});
        plot_draw(plot, &(struct plot_series){.kind = PLOT_RULES,
                                              .key = c == 0 ? "wheel" : NULL,
                                              .colour = c,
                                              .dashed = true,
                                              .x = &p->wheel_ft,
                                              .count = 1});
    }
    for (int i = 0; i < STATED && figure->stated[i].text; i++) {
        if (figure->stated[i].height == heights)
            draw_stated(plot, &figure->stated[i], &profiles[figure->stated[i].curve]);
    }
}

static enum mr_status draw_figure(const char *folder, const char *file, const char *name,
                                  const struct figure *figure, const struct reading *reading,
                                  struct error *error)
{
    static struct profile profiles[CURVES];
    char path[300], title[160];
    for (size_t c = 0; c < CURVES && figure->curves[c].text; c++) {
        if (play_profile(&profiles[c], figure->curves[c].run, reading, figure->curves[c].time,
                         error) != MR_OK)
            return error->status;
    }
    snprintf(title, sizeof title, "Figure %s, %s. %s", figure->number, name, figure->title);
    snprintf(path, sizeof path, "%s/%s3_%s.svg", folder, file, figure->number + 2);
    struct plot *plot = plot_new(title, 800, 600, 1);
    draw_panel(plot, figure, profiles, true);
    draw_panel(plot, figure, profiles, false);
    return plot_write(plot, path, error);
}

enum mr_status draw_figures(const char *folder, const struct found *found, struct error *error)
{
    struct reading rstar = reading_rstar();
    /* as host/scenes/rstar_fig3_12_free.json: the far end does not push back */
    rstar.value[IN_RIGHT312] = 1;
    rstar.value[IN_F312] = 12375;
    for (size_t i = 0; i < FIGURES && error->status == MR_OK; i++) {
        if (draw_figure(folder, "fig", "R*", &figures[i], &rstar, error) == MR_OK)
            draw_figure(folder, "best", "best reading", &figures[i], &found->best[SEARCH_ALL],
                        error);
    }
    return error->status;
}
