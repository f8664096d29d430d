/* Drawing a figure: curves over stations (fig 5.3: points over deceleration), what the text states
 * marked with letters that the lines below the picture explain. Black on white: curves differ by
 * dashes and marks. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/html.h"
#include "host/base/ordered.h"
#include "host/base/svg.h"
#include "host/base/svg_words.h"
#include "tests/campaign_figures/figures.h"

#define WIDTH       1000.0
#define TOP         34.0
#define PLOT_HEIGHT 270.0
#define PLOT_WIDTH  640.0
#define LEFT        76.0
#define LINE        15.0
#define LETTER      12.0
#define MARGIN      8.0
#define MARK_EVERY  5   /* stations */
#define RIG_BANDS   4.0 /* that share the braking force: report 5.1.3.1, C.1 */

static const char style[] =
    "svg{background:#fff;font:12px "
    "sans-serif}.frame{fill:none;stroke:#555}.grid{stroke:#e0e0e0}.tick,.label,.key{fill:#111}"
    ".s0,.s1,.s2,.s3,.s4,.s5,.s6,.s7{fill:none;stroke:#000;stroke-width:1.7}"
    ".s1{stroke-dasharray:9 4}.s2{stroke-dasharray:3 3}.s3{stroke-dasharray:11 3 2 "
    "3}.s4{stroke-dasharray:1 3}"
    ".s5{stroke-width:1}.s6{stroke-width:1;stroke-dasharray:9 "
    "4}.s7{stroke-width:1;stroke-dasharray:3 3}"
    ".m{fill:#fff;stroke:#000;stroke-width:1.1}.m2{fill:#000;stroke:#000}"
    ".spread{fill:#000;opacity:.09}.stated{stroke:#000;stroke-width:1;stroke-dasharray:2 "
    "3;fill:none}"
    ".statedbar{fill:#000;opacity:.3}.letter{fill:#000;font-weight:bold}.halo{stroke:#fff;stroke-"
    "width:4px;paint-order:stroke}"
    ".theory{fill:none;stroke:#000;stroke-width:1}.zero{stroke:#555;stroke-width:1;fill:none}";
static const char *const lines[FIGURE_CURVES] = {"s0", "s1", "s2", "s3", "s4", "s5", "s6", "s7"};

static size_t facts_of(const struct figure *figure)
{
    size_t count = 0;
    while (count < FIGURE_FACTS && figure->facts[count].kind != FACT_NONE)
        count++;
    return count;
}

static size_t curves_of(const struct figure *figure)
{
    size_t count = 0;
    while (count < FIGURE_CURVES && figure->curves[count].text)
        count++;
    return count;
}

/* A curve over the runways that have it: least, middle and most at every station. */
struct bundle {
    double x_ft[CAMPAIGN_STATIONS_MAX], low[CAMPAIGN_STATIONS_MAX], middle[CAMPAIGN_STATIONS_MAX],
        high[CAMPAIGN_STATIONS_MAX];
    size_t runways;
};

static void bundle_curve(struct bundle *bundle, const struct figure *figure,
                         const struct figure_run *run, size_t curve)
{
    const struct campaign *c = &run->campaign;
    double(*moved)[CAMPAIGN_STATIONS_MAX] = calloc(c->seeds, sizeof *moved),
    *column = calloc(c->seeds, sizeof *column);
    bundle->runways = 0;
    for (size_t i = 0; moved && column && i < c->seeds; i++)
        bundle->runways += figure_curve_of(c, &run->runs[i], &figure->curves[curve],
                                           moved[bundle->runways]);
    for (size_t k = 0; k < c->station_count && bundle->runways > 0; k++) {
        size_t n = bundle->runways;
        for (size_t i = 0; i < n; i++)
            column[i] = moved[i][k];
        order_numbers(column, n);
        bundle->x_ft[k] = c->stations_ft[k] + figure->zero_ft;
        bundle->low[k] = column[0];
        bundle->middle[k] = 0.5 * (column[(n - 1) / 2] + column[n / 2]);
        bundle->high[k] = column[n - 1];
    }
    free(moved);
    free(column);
}

static void letter(const struct svg_plot *plot, double x, double y, double dx, double dy,
                   size_t index)
{
    const char text[2] = {(char)('a' + index), 0};
    svg_text(plot, "letter halo", "middle", x, y, dx, dy, text);
}

/* Stations that the text names: a bar or a line under its letter at the top of the plot, a row
 * each. */
static void mark_stations(const struct svg_plot *plot, const struct figure *figure)
{
    double row = 0.0, ft = (plot->y.high - plot->y.low) / plot->height;
    for (size_t i = 0; i < facts_of(figure); i++) {
        const struct figure_fact *fact = &figure->facts[i];
        if (!(fact->at_ft > 0.0) || fact->mark_in != 0.0)
            continue;
        double y = plot->y.high - (14.0 + 18.0 * row++) * ft;
        if (fact->to_ft > fact->at_ft)
            svg_rect(plot, "statedbar", fact->at_ft, y, fact->to_ft, y + 4.0 * ft);
        for (int end = 0; end < (fact->to_ft > 0.0 ? 2 : 1); end++) {
            double x[] = {end ? fact->to_ft : fact->at_ft, end ? fact->to_ft : fact->at_ft},
                   ys[] = {plot->y.low, y};
            svg_line(plot, "stated", x, ys, 2);
        }
        letter(plot, fact->at_ft, y, -8, 4, i);
    }
}

/* Displacements that the text states. */
static void mark_values(const struct svg_plot *plot, const struct figure *figure)
{
    for (size_t i = 0; i < facts_of(figure); i++) {
        const struct figure_fact *fact = &figure->facts[i];
        if (fact->mark_in == 0.0)
            continue;
        double x[] = {plot->x.low, plot->x.high}, y[] = {fact->mark_in, fact->mark_in};
        if (fact->at_ft > 0.0)
            svg_mark(plot->out, "m2", 3, svg_x(plot, fact->at_ft), svg_y(plot, fact->mark_in), 5.0);
        else
            svg_line(plot, "stated", x, y, 2);
        letter(plot, fact->at_ft > 0.0 ? fact->at_ft : plot->x.high, fact->mark_in,
               fact->at_ft > 0.0 ? 12 : -10, -4, i);
    }
}

static void mark_buckles(const struct svg_plot *plot, const struct figure *figure,
                         const struct figure_run *run)
{
    double y = svg_y(plot, plot->y.low) - 6.0;
    for (size_t i = 0; i < run->campaign.seeds; i++) {
        if (run->runs[i].buckled > 0)
            svg_mark(plot->out, "m2", 2, svg_x(plot, run->runs[i].buckle_ft + figure->zero_ft), y,
                     4.0);
    }
}

/* Beside the plot, in as many lines as it takes; returns where the next one begins. */
static double legend_words(FILE *out, double x, double y, const char *text)
{
    const struct svg_block block = {.class = "key",
                                    .x = x,
                                    .y = y,
                                    .width_px = WIDTH - x - MARGIN,
                                    .size_px = LETTER,
                                    .line_px = LINE};
    return y + 20.0 + LINE * ((double)svg_block(out, &block, text) - 1.0);
}

static double legend_line(FILE *out, double y, const char *class, unsigned shape, const char *text)
{
    if (class)
        fprintf(out, "<path class=\"%s\" d=\"M%.0f %.1fh34\"/>\n", class, LEFT + PLOT_WIDTH + 16.0,
                y - 4.0);
    svg_mark(out, class ? "m" : "m2", shape, LEFT + PLOT_WIDTH + 33.0, y - 4.0, 4.0);
    return legend_words(out, LEFT + PLOT_WIDTH + 58.0, y, text);
}

static void draw_curves(FILE *out, const struct figure *figure, const struct figure_run *run)
{
    const struct campaign *c = &run->campaign;
    size_t curves = curves_of(figure);
    double runway_ft = c->landings[0].scene.mats * c->landings[0].scene.length_ft, low = 0.0,
           high = 0.0;
    static struct bundle bundles[FIGURE_CURVES];
    for (size_t i = 0; i < curves; i++) {
        bundle_curve(&bundles[i], figure, run, i);
        for (size_t k = 0; k < c->station_count && bundles[i].runways > 0; k++) {
            low = fmin(low, bundles[i].low[k]);
            high = fmax(high, bundles[i].high[k]);
        }
    }
    for (size_t i = 0; i < facts_of(figure); i++)
        high = fmax(high, figure->facts[i].mark_in);
    high += 0.35 * (high - low) + 0.05; /* room for the letters */
    low -= 0.06 * (high - low);
    struct svg_plot plot = {.out = out,
                            .left = LEFT,
                            .top = TOP,
                            .width = PLOT_WIDTH,
                            .height = PLOT_HEIGHT,
                            .x = {figure->zero_ft, figure->zero_ft + runway_ft,
                                  figure->zero_ft > 0.0
                                      ? "station, ft (22+00 is 2200: where AM2 mat begins)"
                                      : "station, ft",
                                  true},
                            .y = {low, high, "displacement downfield, in", true}};
    double key_y = TOP + 14.0;
    svg_axes(&plot);
    for (size_t i = 0; i < curves; i++) {
        char text[120];
        snprintf(text, sizeof text, "%s (%zu\u00a0of\u00a0%zu)", figure->curves[i].text,
                 bundles[i].runways, c->seeds);
        key_y = legend_line(out, key_y, lines[i], (unsigned)i, text);
        if (bundles[i].runways == 0)
            continue;
        svg_band(&plot, "spread", bundles[i].x_ft, bundles[i].low, bundles[i].high,
                 c->station_count);
        svg_line(&plot, lines[i], bundles[i].x_ft, bundles[i].middle, c->station_count);
        for (size_t k = MARK_EVERY - 1; k < c->station_count; k += MARK_EVERY)
            svg_mark(out, "m", (unsigned)i, svg_x(&plot, bundles[i].x_ft[k]),
                     svg_y(&plot, bundles[i].middle[k]), 3.6);
    }
    key_y = legend_line(out, key_y, NULL, 2, "buckled here, one runway each");
    legend_words(out, LEFT + PLOT_WIDTH + 16.0, key_y, "middle of the runways; grey: all of them");
    mark_stations(&plot, figure);
    mark_values(&plot, figure);
    mark_buckles(&plot, figure, run);
}

/* Fig 5.3, and Appendix C beside it: R = W a/(4 g) a band, half of it ahead and half behind at the
 * middle of a band. */
static void draw_tensions(FILE *out, const struct figure_run *run)
{
    const struct campaign *c = &run->campaign;
    double most_lb = 20.0, to_ft_s2 = 14.0;
    for (size_t i = 0; i < c->seeds; i++) {
        for (size_t k = 0; k < run->runs[i].played; k++) {
            most_lb = fmax(most_lb, fabs(run->runs[i].outcomes[k].band_ahead_lb));
            most_lb = fmax(most_lb, fabs(run->runs[i].outcomes[k].band_behind_lb));
        }
    }
    double theory_lb = 0.5 * c->weight_lb / RIG_BANDS * to_ft_s2 / c->landings[0].scene.g_ft_s2;
    most_lb = 1.1 * fmax(most_lb, theory_lb);
    struct svg_plot plot = {.out = out,
                            .left = LEFT,
                            .top = TOP,
                            .width = PLOT_WIDTH,
                            .height = PLOT_HEIGHT,
                            .x = {0.0, to_ft_s2, "mean deceleration of the landing, ft/s2", true},
                            .y = {-most_lb, most_lb, "change in band tension, lb", true}};
    svg_axes(&plot);
    const double x[] = {0.0, to_ft_s2}, zero[] = {0.0, 0.0}, up[] = {0.0, theory_lb},
                 down[] = {0.0, -theory_lb};
    svg_line(&plot, "zero", x, zero, 2);
    svg_line(&plot, "s1", x, up, 2);
    svg_line(&plot, "s1", x, down, 2);
    for (size_t i = 0; i < c->seeds; i++) {
        for (size_t k = 0; k < run->runs[i].played; k++) {
            const struct campaign_outcome *o = &run->runs[i].outcomes[k];
            double px = svg_x(&plot, o->deceleration_ft_s2);
            unsigned shape = k < 13 ? 0 : 1;
            svg_mark(out, "m2", shape, px, svg_y(&plot, o->band_ahead_lb), 3.0);
            svg_mark(out, "m", shape, px, svg_y(&plot, o->band_behind_lb), 3.0);
        }
    }
    double key_y = legend_line(out, TOP + 14.0, NULL, 0, "least, 100 lb (landings 1 to 13)");
    key_y = legend_line(out, key_y, NULL, 1, "least, 140 lb (14 to 26)");
    svg_mark(out, "m", 0, LEFT + PLOT_WIDTH + 33.0, key_y - 4.0, 4.0);
    key_y = legend_words(out, LEFT + PLOT_WIDTH + 58.0, key_y, "most: open marks alike");
    key_y = legend_words(out, LEFT + PLOT_WIDTH + 16.0, key_y + 6.0,
                         "dashed: +- R/2, R = W a/(4 g) (C.1)");
    legend_words(out, LEFT + PLOT_WIDTH + 16.0, key_y,
                 "mean over segments passed, a mark per landing and runway");
}

void figure_draw(FILE *out, const struct figure *figure, const struct figure_run *run, bool alone)
{
    char title[200];
    size_t facts = facts_of(figure);
    double below = TOP + PLOT_HEIGHT + 52.0,
           height = below + (alone ? LINE * (double)facts : 0.0) + 4.0;
    snprintf(title, sizeof title, "Figure %s. %s", figure->number, figure->title);
    (alone ? svg_open_file : svg_open)(out, WIDTH, height, title);
    fprintf(out, "<style>%s</style>\n<rect width=\"%.0f\" height=\"%.0f\" fill=\"#fff\"/>\n", style,
            WIDTH, height);
    fprintf(out, "<text class=\"label\" x=\"%.0f\" y=\"20\" font-weight=\"bold\">", LEFT);
    html_text(out, title);
    fputs("</text>\n", out);
    if (!run->played) {
        fprintf(out, "<text class=\"label\" x=\"%.0f\" y=\"%.0f\">not played: the series awaits ",
                LEFT + 20.0, TOP + 40.0);
        html_text(out, run->campaign.awaits);
        fputs("</text>\n", out);
    } else if (figure->tension) {
        draw_tensions(out, run);
    } else {
        draw_curves(out, figure, run);
    }
    for (size_t i = 0; alone && i < facts; i++) { /* a page has them in its table */
        fprintf(out,
                "<text class=\"key\" x=\"%.0f\" y=\"%.1f\"><tspan font-weight=\"bold\">%c</tspan>  "
                "text: ",
                LEFT, below + LINE * (double)i, (char)('a' + i));
        html_text(out, figure->facts[i].text);
        fputs("</text>\n", out);
    }
    svg_close(out);
}

static const char *unit_of(enum fact_kind kind)
{
    switch (kind) {
    case FACT_STATION:
    case FACT_PEAK_STATION:
    case FACT_ZONE_REACH: return " ft";
    case FACT_PEAK:
    case FACT_RISE:
    case FACT_AT: return " in";
    case FACT_ZONE: return " mats";
    case FACT_SLACK: return " landings";
    case FACT_AHEAD:
    case FACT_BEHIND: return " lb";
    default: return "";
    }
}

static void put(char *text, size_t size, double value)
{
    if (isinf(value))
        snprintf(text, size, value > 0.0 ? "never" : "any");
    else
        snprintf(text, size, fabs(value) >= 100.0 ? "%.0f" : "%.3g", value);
}

void figure_table(FILE *out, const struct figure *figure, const struct figure_run *run)
{
    static const char *const heads[] = {"",
                                        "observed: the report's text",
                                        "computed: middle (all)",
                                        "runways that agree",
                                        "verdict",
                                        "judged by",
                                        NULL};
    if (!run->played)
        return;
    html_table(out, heads);
    for (size_t i = 0; i < facts_of(figure); i++) {
        const struct figure_fact *fact = &figure->facts[i];
        struct fact_value v = figure_fact_of(figure, fact, run);
        char low[24], middle[24], high[24];
        put(low, sizeof low, v.low);
        put(middle, sizeof middle, v.middle);
        put(high, sizeof high, v.high);
        fputs("<tr>", out);
        html_cell(out, "%c", (char)('a' + i));
        html_cell(out, "%s", fact->text);
        if (v.of == 0)
            html_cell(out, "no runway gets there");
        else
            html_cell(out, "%s%s (%s to %s)", middle, unit_of(fact->kind), low, high);
        html_cell(out, "%zu of %zu", v.agree, v.of);
        html_cell(out, "%s", 2 * v.agree > v.of ? "agrees" : "DIFFERS");
        html_cell(out, "%s", fact->note);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}
