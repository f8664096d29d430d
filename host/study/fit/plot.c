/* Residual plots of a fit. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/study/fit/print.h"
#include "host/base/output.h"
#include "host/base/svg.h"

#define WIDTH        900.0
#define HEIGHT       448.0
#define TOP          66.0
#define PANEL_HEIGHT 300.0
#define LEFT         56.0
#define PANEL_WIDTH  370.0
#define BETWEEN      76.0
#define RADIUS       3.6
#define LIMIT        1.96
#define NAMED        3.0 /* standard deviations: which landing is written beside it */
#define KINDS        7

static const char style[] =
    "<style>.fp{background:#fff;font:12px Helvetica,Arial,sans-serif}.fp "
    ".frame{fill:none;stroke:#444}"
    ".fp .grid{stroke:#d4d8dc;fill:none}.fp .tick,.fp .label{fill:#222}.fp "
    ".head{fill:#111;font-weight:bold;font-size:13px}"
    ".fp .small{fill:#444;font-size:11px}.fp .line{fill:none;stroke:#444;stroke-width:1.2}.fp "
    ".band{fill:#b8bec5;fill-opacity:.4}"
    ".fp .paper{fill:#fff}.fp .full{stroke:#fff;stroke-width:.4}.fp .k0{fill:#0072b2}.fp "
    ".k1{fill:#d55e00}.fp .k2{fill:#009e73}"
    ".fp .k3{fill:#b8529a}.fp .k4{fill:#a67c00}.fp .k5{fill:#222}.fp .k6{fill:#56b4e9}</style>\n";
static const char *const classes[KINDS] = {"full k0", "full k1", "full k2", "full k3",
                                           "full k4", "full k5", "full k6"};
static const char *const kinds[KINDS] = {"16 to 8 ft ahead", "8 to 4", "4 to 2",       "2 to 0",
                                         "0 to 4 behind",    "end",    "segment after"};

/* Which kind of statistic, for colour and shape: by how its name begins. */
static unsigned kind_of(const struct fit_window *window)
{
    static const char *const begins[] = {"16 to", "8 to", "4 to", "2 to", "0 to", "end"};
    for (unsigned k = 0; k < sizeof begins / sizeof begins[0]; k++) {
        if (window->channel != SIZE_MAX && strncmp(window->name, begins[k], strlen(begins[k])) == 0)
            return k;
    }
    return KINDS - 1;
}

static double station_of(const struct fit_landing *landing, const struct fit_window *window)
{
    return window->channel != SIZE_MAX
             ? landing->channel[window->channel].station_ft
             : ((double)window->segment + 0.5) * (double)MR_SEGMENT_LENGTH_FT;
}

static double shown_in(const struct fit_window *window, double statistic)
{
    return window->channel != SIZE_MAX ? fit_movement_in(statistic) : statistic;
}

struct range {
    double low, high;
};

static void take(struct range *range, double value)
{
    range->low = fmin(range->low, value);
    range->high = fmax(range->high, value);
}

static struct svg_plot panel(FILE *out, double left, struct range x, struct range y,
                             const char *x_label, const char *y_label, const char *head)
{
    struct svg_plot plot = {
        .out = out, .left = left, .top = TOP, .width = PANEL_WIDTH, .height = PANEL_HEIGHT};
    svg_widen(&x.low, &x.high, 0.1);
    svg_widen(&y.low, &y.high, 0.1);
    plot.x = (struct svg_axis){x.low, x.high, x_label, true};
    plot.y = (struct svg_axis){y.low, y.high, y_label, true};
    svg_axes(&plot);
    svg_text(&plot, "head", "start", x.low, y.high, 0.0, -10.0, head);
    return plot;
}

static void name_landing(const struct svg_plot *plot, int64_t run, double station_ft,
                         double residual)
{
    char text[32];
    snprintf(text, sizeof text, "RUN %lld", (long long)run);
    if (fabs(residual) > NAMED)
        svg_text(plot, "small", "start", station_ft, residual, 8.0, 4.0, text);
}

static void draw(FILE *out, const struct fit_landings *list, const struct fit_answer *answer)
{
    struct range station = {HUGE_VAL, -HUGE_VAL}, residual = {-3.0, 3.0},
                 movement = {HUGE_VAL, -HUGE_VAL};
    for (size_t l = 0; l < list->count; l++) {
        for (size_t w = 0; w < list->landing[l].windows; w++) {
            const struct fit_window *window = &list->landing[l].window[w];
            size_t s = list->landing[l].first + w;
            take(&station, station_of(&list->landing[l], window));
            take(&residual, (list->measured[s] - answer->expected[s]) / answer->scatter[s]);
            take(&movement, shown_in(window, list->measured[s]));
            take(&movement, shown_in(window, answer->expected[s]));
        }
    }
    struct svg_plot left = panel(out, LEFT, station, residual, "station, ft",
                                 "(measured - expected) / standard deviation",
                                 "Residuals along the runway");
    svg_rect(&left, "band", left.x.low, -LIMIT, left.x.high, LIMIT);
    struct svg_plot right = panel(out, LEFT + PANEL_WIDTH + BETWEEN, movement, movement,
                                  "expected, in", "measured, in", "Movements and sums of gaps");
    double ends[2] = {right.x.low, right.x.high};
    svg_line(&right, "line", ends, ends, 2);
    for (size_t l = 0; l < list->count; l++) {
        for (size_t w = 0; w < list->landing[l].windows; w++) {
            const struct fit_window *window = &list->landing[l].window[w];
            size_t s = list->landing[l].first + w;
            unsigned kind = kind_of(window);
            svg_mark(out, classes[kind], kind % (SVG_SHAPES - 1),
                     svg_x(&left, station_of(&list->landing[l], window)),
                     svg_y(&left, (list->measured[s] - answer->expected[s]) / answer->scatter[s]),
                     RADIUS);
            name_landing(&left, list->landing[l].run, station_of(&list->landing[l], window),
                         (list->measured[s] - answer->expected[s]) / answer->scatter[s]);
            svg_mark(out, classes[kind], kind % (SVG_SHAPES - 1),
                     svg_x(&right, shown_in(window, answer->expected[s])),
                     svg_y(&right, shown_in(window, list->measured[s])), RADIUS);
        }
    }
}

enum mr_status fit_write_plot(const struct fit_landings *list, const struct fit_answer *answer,
                              const struct misfit *misfit, const char *path, struct error *error)
{
    struct output output;
    if (output_begin(&output, path, error) != MR_OK)
        return error->status;
    FILE *out = output.file;
    svg_open_file(out, WIDTH, HEIGHT, "residuals of a fit");
    fprintf(out, "%s<g class=\"fp\"><rect class=\"paper\" width=\"%.0f\" height=\"%.0f\"/>", style,
            WIDTH, HEIGHT);
    draw(out, list, answer);
    double x = LEFT;
    for (unsigned k = 0; k < KINDS; k++) {
        svg_mark(out, classes[k], k % (SVG_SHAPES - 1), x, 20.0, RADIUS);
        fprintf(out, "<text class=\"small\" x=\"%.0f\" y=\"24\">%s</text>", x + 9.0, kinds[k]);
        x += 26.0 + 6.2 * (double)strlen(kinds[k]);
    }
    fprintf(out,
            "<text class=\"small\" x=\"%.0f\" y=\"%.0f\">Grey: 95 %% of what gaps, resistances and "
            "noise scatter.</text>",
            LEFT, HEIGHT - 30.0);
    fprintf(out, "<text class=\"%s\" x=\"%.0f\" y=\"%.0f\">%s%s</text></g>\n",
            misfit->cannot ? "head" : "small", LEFT, HEIGHT - 12.0,
            !misfit->checked ? "Whether the model can be the data&#39;s was not checked."
            : misfit->cannot ? "The model cannot be the data&#39;s: "
                             : "The model can be the data&#39;s.",
            misfit->cannot ? misfit_words[misfit->worst].words : "");
    svg_close(out);
    return output_end(&output, error);
}
