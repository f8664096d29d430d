#include "host/campaign/page.h"

#include <math.h>

#include "host/base/html.h"
#include "host/base/svg.h"
#include "host/campaign/campaign_answer.h"

#define WIDTH  900.0
#define HEIGHT 330.0
#define LINES  8 /* colours */

static const char style[] =
    "<style>.campaign{font:13px sans-serif}.campaign .frame,.campaign .grid{fill:none;stroke:#ccc}"
    ".campaign text{font:12px sans-serif;fill:#333}.campaign .band{fill:#3465a4;opacity:.15}"
    ".campaign .l0,.campaign .l1,.campaign .l2,.campaign .l3,.campaign .l4,.campaign .l5,.campaign "
    ".l6,.campaign .l7{fill:none;stroke-width:1.6}"
    ".campaign .l0{stroke:#3465a4}.campaign .l1{stroke:#4e9a06}.campaign "
    ".l2{stroke:#c17d11}.campaign .l3{stroke:#75507b}"
    ".campaign .l4{stroke:#cc0000}.campaign .l5{stroke:#06989a}.campaign "
    ".l6{stroke:#888a85}.campaign .l7{stroke:#2e3436}"
    ".campaign .dot{fill:#cc0000}</style>";

/* Which landings are drawn: all, or the last of every so many. */
static bool drawn(size_t landing, size_t played)
{
    size_t every = (played + LINES - 1) / LINES;
    return landing + 1 == played || (landing + 1) % every == 0;
}

static size_t landings_played(const struct campaign *c, const struct campaign_summary *s)
{
    size_t played = 0;
    while (played < c->landing_count && s->landing[played].played > 0)
        played++;
    return played;
}

static void movement(FILE *out, const struct campaign *c, const struct campaign_summary *s,
                     double runway_ft)
{
    static const char *const classes[LINES] = {"l0", "l1", "l2", "l3", "l4", "l5", "l6", "l7"};
    size_t played = landings_played(c, s);
    double low = 0.0, high = 0.0, middle[CAMPAIGN_STATIONS_MAX];
    for (size_t i = 0; i < played; i++) {
        for (size_t k = 0; k < c->station_count; k++) {
            low = fmin(low, s->landing[i].total_in[k].middle);
            high = fmax(high, s->landing[i].total_in[k].middle);
        }
    }
    svg_widen(&low, &high, 0.1);
    struct svg_plot plot = {.out = out,
                            .left = 60,
                            .top = 20,
                            .width = WIDTH / 2 - 80,
                            .height = HEIGHT - 80,
                            .x = {0.0, runway_ft, "station, ft", true},
                            .y = {low, high, "movement in all, in (median)", true}};
    svg_axes(&plot);
    for (size_t i = 0, line = 0; i < played; i++) {
        char label[24];
        if (!drawn(i, played))
            continue;
        for (size_t k = 0; k < c->station_count; k++)
            middle[k] = s->landing[i].total_in[k].middle;
        svg_line(&plot, classes[line % LINES], c->stations_ft, middle, c->station_count);
        snprintf(label, sizeof label, "%zu", i + 1);
        svg_text(&plot, "label", "start", c->stations_ft[c->station_count / 2],
                 middle[c->station_count / 2], 4, -4, label);
        line++;
    }
}

static void buckles(FILE *out, const struct campaign *c, const struct campaign_run *runs,
                    double runway_ft)
{
    struct svg_plot plot = {.out = out,
                            .left = WIDTH / 2 + 50,
                            .top = 20,
                            .width = WIDTH / 2 - 70,
                            .height = HEIGHT - 80,
                            .x = {0.0, runway_ft, "station, ft", true},
                            .y = {0.5, (double)c->landing_count + 0.5, "buckles in landing", true}};
    svg_axes(&plot);
    for (size_t i = 0; i < c->seeds; i++) {
        if (runs[i].buckled > 0)
            svg_dot(&plot, "dot", runs[i].buckle_ft,
                    runs[i].buckled + 0.6 * ((double)(i % 9) / 8.0 - 0.5));
    }
}

void campaign_picture(FILE *out, const struct campaign *c, const struct campaign_run *runs,
                      const struct campaign_summary *s, bool alone)
{
    double runway_ft = c->landings[0].scene.mats * c->landings[0].scene.length_ft;
    (alone ? svg_open_file : svg_open)(out, WIDTH, HEIGHT, c->name);
    fputs(style, out);
    fputs("<g class=\"campaign\">\n", out);
    movement(out, c, s, runway_ft);
    buckles(out, c, runs, runway_ft);
    fputs("</g>\n", out);
    svg_close(out);
}

static void show(FILE *out, const struct campaign *c, const struct campaign_run *runs,
                 const struct campaign_summary *s,
                 void (*describe)(struct answer *, const struct campaign *,
                                  const struct campaign_run *, const struct campaign_summary *))
{
    struct answer *answer = answer_new(false);
    describe(answer, c, runs, s);
    if (!answer_html(answer, out))
        fputs("<p>Memory ended here: this page is cut short.</p>\n", out);
    answer_free(answer);
}

void campaign_page(FILE *out, const struct campaign *c, const struct campaign_run *runs,
                   const struct campaign_summary *s)
{
    fputs("<!DOCTYPE html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>", out);
    html_text(out, c->name);
    fputs(
        "</title><style>body{font:15px/1.5 sans-serif;max-width:64em;margin:2em auto;padding:0 1em}"
        "table{border-collapse:collapse;font-size:13px;margin:8px 0}td,th{border:1px solid "
        "#ccc;padding:2px 8px;"
        "text-align:left}.scroll{overflow-x:auto}svg{width:100%;height:auto}"
        "dl div{display:flex}dt{min-width:9em;color:#555}dd{margin:0}</style></head><body>\n<h1>",
        out);
    html_text(out, c->name);
    fputs("</h1>\n", out);
    show(out, c, runs, s, campaign_answer_outcome);
    campaign_picture(out, c, runs, s, false);
    show(out, c, runs, s, campaign_answer_landings);
    fputs("</body></html>\n", out);
}
