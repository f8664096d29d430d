#include "host/push/push_page.h"

#include <math.h>

#include "host/base/html.h"
#include "host/base/svg.h"
#include "host/push/push_answer.h"
#include "host/report/chart.h"
#include "host/report/page.h"

#define WIDTH  500.0
#define HEIGHT 350.0
#define LEFT   54.0
#define TOP    52.0

/* One column where a page is narrow; letters that can be read there. */
static const char style[] =
    "<style>.push{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,440px),1fr));"
    "gap:14px 22px}.push figure{margin:0}.push svg{font-size:13px}.push .label,.push .tick{"
    "font-size:13px}.push .rigid{stroke:var(--ink);stroke-dasharray:7 4;stroke-width:1.6;fill:none}"
    ".push .law{stroke:var(--b);stroke-width:2;fill:none}.push .way{stroke:var(--soft);"
    "stroke-width:.8;fill:none}.push "
    ".read{fill:var(--a)}td:last-child{min-width:11em}pre{background:var(--panel);"
    "border:1px solid var(--rule);border-radius:6px;padding:10px 14px;overflow-x:auto}</style>\n";

/* Pixels are those of the picture: a key of a line that svg_text cannot place. */
static void key(FILE *out, const char *class, double left, double top, const char *text)
{
    fprintf(out, "<path class=\"%s\" d=\"M%.0f %.0fh26\"/>", class, left, top - 4.0);
    fprintf(out, "<text class=\"tick\" x=\"%.0f\" y=\"%.0f\">%s</text>\n", left + 32.0, top, text);
}

static struct svg_plot axes(FILE *out, const struct push_series *series, double limit_lb)
{
    double low_in = 0.0, high_in = 0.0, low_lb = 0.0, high_lb = 0.0;
    chart_extend(series->moved_in, series->count, &low_in, &high_in);
    chart_extend(series->force_lb, series->count, &low_lb, &high_lb);
    if (limit_lb > high_lb && limit_lb < 2.5 * high_lb)
        high_lb = limit_lb;
    svg_widen(&low_in, &high_in, 0.004);
    svg_widen(&low_lb, &high_lb, 1.0);
    struct svg_plot plot = {.out = out,
                            .left = LEFT,
                            .top = TOP,
                            .width = WIDTH - LEFT - 12.0,
                            .height = HEIGHT - TOP - 44.0,
                            .x = {low_in, high_in, "displacement, in", true},
                            .y = {low_lb, high_lb, "force, lb", true}};
    svg_axes(&plot);
    return plot;
}

/* Up at the zero, and along the limit; beyond the picture where nobody knows the limit. */
static void draw_rigid(const struct svg_plot *plot, double zero_in, double limit_lb)
{
    double top_lb = isfinite(limit_lb) && limit_lb < plot->y.high ? limit_lb : plot->y.high;
    double x[3] = {zero_in, zero_in, plot->x.high}, y[3] = {fmax(0.0, plot->y.low), top_lb, top_lb};
    svg_line(plot, "rigid", x, y, top_lb < plot->y.high ? 3 : 2);
}

static void draw_test(FILE *out, const struct push_series *series, struct push_gages gages,
                      const struct push_fit *fit, double limit_lb)
{
    double law_in[PUSH_READINGS_MAX];
    struct svg_plot plot = axes(out, series, limit_lb);
    bool told = !isnan(fit->k_lb_in.value);
    svg_line(&plot, "way", series->moved_in, series->force_lb, series->count);
    draw_rigid(&plot, fit->zero_in, limit_lb);
    push_fit_curve(series, gages, fit, law_in);
    svg_line(&plot, "law", law_in, series->force_lb, series->count);
    for (size_t i = 0; i < series->count; i++)
        svg_mark(out, "read", 0, svg_x(&plot, series->moved_in[i]),
                 svg_y(&plot, series->force_lb[i]), 3.2);
    svg_mark(out, "read", 0, LEFT + 13.0, 14.0, 3.2);
    fprintf(out, "<text class=\"tick\" x=\"%.0f\" y=\"18\">read, in turn</text>\n", LEFT + 32.0);
    key(out, "law", LEFT + 150.0, 18.0, told ? "elastic ground" : "elastic, as soft as it may be");
    key(out, "rigid", LEFT + 150.0, 38.0,
        isfinite(limit_lb) ? "Coulomb, rigid, to its limit" : "Coulomb, rigid; limit not known");
}

static void draw_tests(FILE *out, const struct push_readings *readings,
                       const struct push_setting *setting, const struct push_ground *ground)
{
    fputs("<div class=\"push\">\n", out);
    for (size_t i = 0; i < readings->count; i++) {
        const struct push_series *series = &readings->series[i];
        double limit_lb = ground->fit[i].slid > 0
                            ? fabs(ground->fit[i].limit_lb)
                            : push_ground_limit_lb(ground, setting, series->load_lb);
        fputs("<figure>", out);
        svg_open(out, WIDTH, HEIGHT, "force against displacement");
        draw_test(out, series, setting->gages, &ground->fit[i], limit_lb);
        svg_close(out);
        fputs("<figcaption>Test ", out);
        html_text(out, series->name);
        fprintf(out, ", %.4g lb on %u mat%s.</figcaption></figure>\n", series->load_lb,
                setting->mats, setting->mats == 1 ? "" : "s");
    }
    fputs("</div>\n", out);
}

static void show(FILE *out, struct answer *answer)
{
    if (!answer_html(answer, out))
        fputs("<p>Memory ended here: this page is cut short.</p>\n", out);
    answer_free(answer);
}

static void show_rows(FILE *out, const struct push_page_row *rows, size_t count)
{
    static const char *const heads[] = {"scene key", "value", "95 % from", "to",
                                        "unit",      "from",  NULL};
    if (count == 0)
        return;
    fputs("<h2>Parameters</h2>\n", out);
    html_table(out, heads);
    for (size_t i = 0; i < count; i++) {
        fputs("<tr>", out);
        html_cell(out, "%s", rows[i].key);
        html_cell(out, "%.4g", rows[i].of.value);
        if (isfinite(rows[i].of.low + rows[i].of.high)) {
            html_cell(out, "%.4g", rows[i].of.low);
            html_cell(out, "%.4g", rows[i].of.high);
        } else
            fputs("<td>\xe2\x80\x93</td><td>\xe2\x80\x93</td>", out);
        html_cell(out, "%s", rows[i].unit);
        html_cell(out, "%s", rows[i].from);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

void push_page(FILE *out, const char *title, const struct push_readings *readings,
               const struct push_setting *setting, const struct push_ground *ground,
               const struct push_page_row *rows, size_t row_count, const char *const *lines)
{
    page_head(out, title);
    fputs(style, out);
    fputs("<h1>Push test</h1>\n<p>", out);
    html_text(out, title);
    fputs("</p>\n", out);
    struct answer *law = answer_new(false), *tests = answer_new(false);
    push_answer_law(law, ground, setting);
    show(out, law);
    show_rows(out, rows, row_count);
    fputs("<h2>Force against displacement</h2>\n", out);
    draw_tests(out, readings, setting, ground);
    push_answer_tests(tests, readings, ground);
    show(out, tests);
    if (lines[0]) {
        fputs("<h2>The board's predictor</h2>\n<p>Lines of its configuration that follow from "
              "these tests. It has no elastic ground: k cannot be given to it.</p>\n<pre>",
              out);
        for (size_t i = 0; lines[i]; i++) {
            html_text(out, lines[i]);
            fputs("\n", out);
        }
        fputs("</pre>\n", out);
    }
    fputs("</body></html>\n", out);
}
