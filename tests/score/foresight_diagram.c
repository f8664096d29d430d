#include <math.h>

#include "host/base/svg.h"
#include "host/base/wilson.h"
#include "tests/score/foresight.h"

#define WIDTH   1040.0
#define HEIGHT  388.0
#define LEFT    56.0
#define TOP     74.0
#define SIDE    210.0
#define BETWEEN 40.0
#define RADIUS  4.5
#define SHOWN   3u
#define APART   0.014 /* whiskers beside each other */

static const char style[] =
    "<style>.fd{font:12px Helvetica,Arial,sans-serif}.fd .paper{fill:#fff}.fd "
    ".frame{fill:none;stroke:#444}.fd .grid{stroke:#d4d8dc;fill:none}.fd .tick,.fd "
    ".label{fill:#222}.fd .head{fill:#111;font-weight:bold;font-size:13px}.fd "
    ".line{fill:none;stroke:#888;stroke-dasharray:4 3}.fd .w0,.fd .w1,.fd "
    ".w2{fill:none;stroke-width:1.2}.fd .w0{stroke:#0072b2}.fd .w1{stroke:#d55e00}.fd "
    ".w2{stroke:#777}.fd .k0,.fd .n0{fill:#0072b2}.fd .k1,.fd .n1{fill:#d55e00}.fd .k2,.fd "
    ".n2{fill:#777}.fd .n0,.fd .n1,.fd .n2{font-size:11px}</style>\n";
static const char *const names[SHOWN] = {"advise, before touchdown", "board",
                                         "all facts in one rule"};
static const char *const marks[SHOWN] = {"k0", "k1", "k2"};
static const char *const lines[SHOWN] = {"w0", "w1", "w2"};
static const char *const counts[SHOWN] = {"n0", "n1", "n2"};

/* Said against seen with its interval (95 %, Wilson), and how many landings below. */
static void draw_points(const struct svg_plot *plot, const struct foresight_moment *moment,
                        unsigned by)
{
    struct stats_held held;
    stats_held(moment->by[by], moment->event, moment->count, &held);
    for (unsigned b = 0; b < STATS_BINS; b++) {
        char text[16];
        struct wilson interval = wilson_of(held.events[b], held.count[b]);
        double x = held.said[b] + APART * ((double)by - 1.0);
        snprintf(text, sizeof text, "%u", held.count[b]);
        svg_text(plot, counts[by], "middle", (b + 0.5) / STATS_BINS, 0.0, 0.0, 50.0 + 14.0 * by,
                 text);
        if (!held.count[b])
            continue;
        svg_line(plot, lines[by], (double[]){x, x}, (double[]){interval.low, interval.high}, 2);
        svg_mark(plot->out, marks[by], by, svg_x(plot, x), svg_y(plot, held.seen[b]), RADIUS);
    }
}

static void draw_moment(FILE *out, const struct foresight_moment *moment, unsigned when)
{
    char text[80];
    struct svg_plot plot = {.out = out,
                            .left = LEFT + when * (SIDE + BETWEEN),
                            .top = TOP,
                            .width = SIDE,
                            .height = SIDE,
                            .x = {0.0, 1.0, "said", true},
                            .y = {0.0, 1.0, when ? NULL : "seen", true}};
    svg_axes(&plot);
    snprintf(text, sizeof text, "%s: %zu landings, %zu events", foresight_when_names[when],
             moment->count, moment->events);
    svg_text(&plot, "head", "start", 0.0, 1.0, 0.0, -8.0, text);
    svg_line(&plot, "line", (double[]){0.0, 1.0}, (double[]){0.0, 1.0}, 2);
    for (unsigned by = 0; by < SHOWN; by++)
        draw_points(&plot, moment, by);
}

void foresight_draw(FILE *out, const struct foresight_row *row,
                    const struct foresight_moment *moment)
{
    svg_open_file(out, WIDTH, HEIGHT, row->text);
    fprintf(out, "<g class=\"fd\">%s<rect class=\"paper\" width=\"%.0f\" height=\"%.0f\"/>\n",
            style, WIDTH, HEIGHT);
    fprintf(out, "<text class=\"head\" x=\"%.0f\" y=\"22\">%s</text>\n", LEFT, row->text);
    for (unsigned by = 0; by < SHOWN; by++) {
        double x = LEFT + 200.0 * by;
        svg_mark(out, marks[by], by, x + 5.0, 40.0, RADIUS);
        fprintf(out, "<text class=\"tick\" x=\"%.0f\" y=\"44\">%s</text>\n", x + 14.0, names[by]);
    }
    fprintf(out,
            "<text class=\"tick\" x=\"%.0f\" y=\"44\">bars: 95 %% (Wilson); below: landings in "
            "each fifth</text>\n",
            LEFT + 200.0 * SHOWN);
    for (unsigned w = 0; w < WHENS; w++)
        draw_moment(out, &moment[w], w);
    fputs("</g>\n", out);
    svg_close(out);
}
