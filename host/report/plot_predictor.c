#include "host/report/plot_predictor.h"

#include <math.h>

#include "common/predictor.h"
#include "host/base/svg.h"

#define WIDTH        860.0
#define HEIGHT       500.0
#define TOP          104.0
#define PANEL_HEIGHT 336.0
#define LEFT         64.0
#define BETWEEN      66.0
#define RIGHT        14.0
#define RADIUS       4.0

static const char style[] =
    "<style>.pp{font:12px Helvetica,Arial,sans-serif}.pp .frame{fill:none;stroke:#444}"
    ".pp .grid{stroke:#d4d8dc;fill:none}.pp .minor{stroke:#eff1f3;fill:none}.pp .tick,.pp "
    ".label{fill:#222}"
    ".pp .head{fill:#111;font-weight:bold;font-size:13px}.pp .small{fill:#444;font-size:11px}"
    ".pp .line{fill:none;stroke-width:1.3;stroke-linejoin:round}.pp .paper{fill:#fff}"
    ".pp .la{stroke:#0072b2}.pp .lb{stroke:#009e73}.pp .lc{stroke:#a67c00}.pp "
    ".ld{stroke:#b8529a}.pp .le{stroke:#d55e00}"
    ".pp .full.la{fill:#0072b2}.pp .full.lb{fill:#009e73}.pp .full.lc{fill:#a67c00}.pp "
    ".full.ld{fill:#b8529a}"
    ".pp .full.le{fill:#d55e00}.pp .key{fill:#444}</style>\n";

static const char *const classes[PREDICTOR_STUDY_LANDINGS] = {"la", "lb", "lc", "ld", "le"};

/* Steps of the full model share a shape: they lie side by side on a line. */
static unsigned shape_of(const struct predictor_variant *variant)
{
    return variant->level == MR_PREDICTOR_TWO    ? 1u
         : variant->level == MR_PREDICTOR_FOUR   ? 2u
         : variant->level == MR_PREDICTOR_PLOUGH ? 3u
                                                 : 0u;
}

static const struct predictor_error *error_of(const struct predictor_run *run, bool own)
{
    return own ? &run->own : &run->other;
}

/* From the cheapest to the dearest: the list the other way round. */
static void draw_landing(const struct svg_plot *plot, const struct predictor_study *study,
                         size_t landing, bool own)
{
    double x[PREDICTOR_STUDY_VARIANTS], y[PREDICTOR_STUDY_VARIANTS];
    char class[16];
    size_t count = 0;
    for (size_t i = study->count; i-- > 0;) {
        const struct predictor_variant *variant = &study->variant[i];
        if (variant->refused)
            continue;
        x[count] = variant->run[landing].cycles / 1e6;
        y[count++] = error_of(&variant->run[landing], own)->rms_in;
    }
    snprintf(class, sizeof class, "line %s", classes[landing]);
    svg_line(plot, class, x, y, count);
    snprintf(class, sizeof class, "full %s", classes[landing]);
    count = 0;
    for (size_t i = study->count; i-- > 0;) {
        if (study->variant[i].refused)
            continue;
        svg_mark(plot->out, class, shape_of(&study->variant[i]), svg_x(plot, x[count]),
                 svg_y(plot, y[count]), RADIUS);
        count++;
    }
}

static void draw_panel(FILE *out, const struct predictor_study *study, bool own, double left,
                       double width)
{
    struct svg_plot plot = {.out = out,
                            .left = left,
                            .top = TOP,
                            .width = width,
                            .height = PANEL_HEIGHT,
                            .log_x = true,
                            .log_y = true};
    double low = HUGE_VAL, high = 0.0, least = HUGE_VAL, most = 0.0;
    for (size_t i = 0; i < study->count; i++) {
        for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS && !study->variant[i].refused; k++) {
            const struct predictor_run *run = &study->variant[i].run[k];
            low = fmin(low, fmin(run->own.rms_in, run->other.rms_in));
            high = fmax(high, fmax(run->own.rms_in, run->other.rms_in));
            least = fmin(least, run->cycles / 1e6);
            most = fmax(most, run->cycles / 1e6);
        }
    }
    plot.x = (struct svg_axis){pow(10.0, floor(2.0 * log10(0.9 * least)) / 2.0),
                               pow(10.0, ceil(2.0 * log10(1.1 * most)) / 2.0),
                               "cycles on the board for a landing, millions", true};
    plot.y = (struct svg_axis){pow(10.0, floor(2.0 * log10(0.8 * low)) / 2.0),
                               pow(10.0, ceil(2.0 * log10(1.2 * high)) / 2.0), "rms error of u, in",
                               true};
    svg_rect(&plot, "paper", plot.x.low, plot.y.low, plot.x.high, plot.y.high);
    svg_axes(&plot);
    svg_text(&plot, "head", "start", plot.x.low, plot.y.high, 0.0, -8.0,
             own ? "the runway it assumes, no transducers"
                 : "another runway: survey, eight transducers");
    for (size_t k = 0; k < PREDICTOR_STUDY_LANDINGS; k++)
        draw_landing(&plot, study, k, own);
}

static void draw_legend(FILE *out)
{
    static const char *const levels[] = {"every mat, steps 0.05 to 0.185 ms", "two in one",
                                         "four in one", "plough"};
    double x = LEFT;
    for (unsigned i = 0; i < 4; i++) {
        svg_mark(out, "key", i, x, 44.0, RADIUS);
        fprintf(out, "<text class=\"tick\" x=\"%.1f\" y=\"48\">%s</text>\n", x + 10.0, levels[i]);
        x += i == 0 ? 240.0 : 96.0;
    }
    x = LEFT;
    for (unsigned k = 0; k < PREDICTOR_STUDY_LANDINGS; k++, x += 96.0)
        fprintf(out,
                "<path class=\"line %s\" d=\"M%.1f 66h24\"/><text class=\"tick\" x=\"%.1f\" "
                "y=\"70\">landing %u</text>\n",
                classes[k], x - 4.0, x + 25.0, k + 1u);
}

void plot_predictor_file(FILE *out, const struct predictor_study *study)
{
    static const char title[] = "onboard predictor: error against the fine chain, by cost";
    double width = (WIDTH - LEFT - RIGHT - BETWEEN) / 2.0;
    svg_open_file(out, WIDTH, HEIGHT, title);
    fprintf(out, "<g class=\"pp\">%s<rect class=\"paper\" width=\"%.0f\" height=\"%.0f\"/>\n",
            style, WIDTH, HEIGHT);
    fprintf(out, "<text class=\"head\" x=\"%.0f\" y=\"22\">%s</text>\n", LEFT, title);
    draw_legend(out);
    draw_panel(out, study, true, LEFT, width);
    draw_panel(out, study, false, LEFT + width + BETWEEN, width);
    fputs("</g>\n", out);
    svg_close(out);
}
