#include "host/compare/picture.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "host/base/svg.h"
#include "host/base/svg_words.h"
#include "host/base/units.h"

#define WIDTH   1040.0
#define COLUMNS 2
#define MARGIN  58.0
#define ROW     200.0
#define TOP     40.0
#define POINTS  300
#define Z95     1.959964

static const struct measured_channel *channel_of(const struct measured *measured,
                                                 const struct store_simulation *row)
{
    int c = measured_find(measured, MR_KIND_DISPLACEMENT, (unsigned)row->number);
    return c >= 0 && measured->channel[c].raw ? &measured->channel[c] : NULL;
}

static double solver_error(const struct store_simulation_head *head,
                           const struct store_simulation *row)
{
    return isnan(head->error_in) ? row->peak_simulated_error_in : head->error_in;
}

/* Thinned to POINTS: every step-th sample. */
struct curve {
    double t_s[POINTS + 1], value[POINTS + 1], low[POINTS + 1], high[POINTS + 1];
    size_t count;
};

static void take(struct curve *curve, const struct compare_curves *s, const double *values,
                 const double *errors, size_t from, size_t to, double in, double *least,
                 double *most)
{
    size_t step = (to - from) / POINTS + 1;
    curve->count = 0;
    for (size_t i = from; i < to; i += step) {
        size_t k = curve->count++;
        curve->t_s[k] = s->t_s[i];
        curve->value[k] = in * values[i];
        curve->low[k] = in * (values[i] - Z95 * errors[i]);
        curve->high[k] = in * (values[i] + Z95 * errors[i]);
        *least = fmin(*least, curve->low[k]);
        *most = fmax(*most, curve->high[k]);
    }
}

/* Runs without NaN: a band has no holes. */
static void draw_band(const struct svg_plot *plot, const char *class, const struct curve *c)
{
    for (size_t from = 0; from < c->count; from++) {
        size_t to = from;
        while (to < c->count && !isnan(c->low[to]))
            to++;
        if (to > from + 1)
            svg_band(plot, class, c->t_s + from, c->low + from, c->high + from, to - from);
        from = to;
    }
}

static void draw_channel(FILE *out, const struct compare_curves *s, size_t samples,
                         const struct store_simulation *row, size_t place, bool si)
{
    struct curve measured, simulated;
    double least = 0.0, most = 0.0, in = unit_of(UNIT_DISPLACEMENT, si)->factor;
    size_t from = 0, to = samples;
    while (from < to && s->t_s[from] < 0.0)
        from++;
    while (to > from && isnan(s->simulated_in[to - 1]))
        to--;
    if (to <= from)
        return;
    take(&measured, s, s->measured_in, s->measured_error_in, from, to, in, &least, &most);
    take(&simulated, s, s->simulated_in, s->simulated_error_in, from, to, in, &least, &most);
    svg_widen(&least, &most, 0.05 * in);
    char label[40], name[60];
    snprintf(label, sizeof label, "movement, %s", unit_of(UNIT_DISPLACEMENT, si)->text);
    snprintf(name, sizeof name, "transducer %" PRId64 ", %.1f %s", row->number,
             row->station_ft * unit_of(UNIT_STATION, si)->factor, unit_of(UNIT_STATION, si)->text);
    double column = (double)(place % COLUMNS), line = (double)(place / COLUMNS),
           width = WIDTH / COLUMNS;
    struct svg_plot plot = {.out = out,
                            .left = column * width + MARGIN,
                            .top = TOP + line * ROW,
                            .width = width - MARGIN - 14.0,
                            .height = ROW - 52.0};
    plot.x = (struct svg_axis){s->t_s[from], s->t_s[to - 1], "time since touchdown, s", true};
    plot.y = (struct svg_axis){least, most, column < 0.5 ? label : NULL, true};
    svg_axes(&plot);
    draw_band(&plot, "band", &measured);
    draw_band(&plot, "band sims", &simulated);
    svg_line(&plot, "line a", measured.t_s, measured.value, measured.count);
    svg_line(&plot, "line sim", simulated.t_s, simulated.value, simulated.count);
    /* movements end high */
    svg_text(&plot, "name", "end", plot.x.high, plot.y.low, -6.0, -8.0, name);
}

enum mr_status compare_draw(FILE *out, const struct measured *measured,
                            const struct store_simulation_head *head,
                            const struct store_simulation *rows, size_t count, bool alone, bool si,
                            struct error *error)
{
    const struct svg_key keys[] = {{"line a", "measured, with its 95 % band"},
                                   {"line sim", "simulated, with its 95 % band"}};
    struct compare_clock clock;
    double height = TOP + ROW * (double)((count + COLUMNS - 1) / COLUMNS);
    compare_clock_make(measured, &clock);
    (alone ? svg_open_file : svg_open)(out, WIDTH, height,
                                       "movement of the mat, measured and simulated");
    if (alone) /* the page's classes; a file of its own brings them along */
        fputs(
            "<style>.band{fill:#0b62c4;opacity:.2;stroke:none}.band.sims{fill:#c2570c}.line{fill:"
            "none;stroke-width:1.5}.a{stroke:#0b62c4}"
            ".sim{stroke:#c2570c;stroke-dasharray:5 "
            "3}.grid{stroke:#e8ebef;fill:none}.frame{fill:none;stroke:#d5dae0}.tick{fill:#59636e}"
            ".label{fill:#59636e;font-size:12px}.name{fill:#1b1f24;font-size:12px;font-weight:600}"
            "svg{font:11px system-ui,sans-serif;background:#fff}</style>",
            out);
    for (size_t i = 0; i < count && error->status == MR_OK; i++) {
        struct compare_curves series;
        const struct measured_channel *channel = channel_of(measured, &rows[i]);
        if (!channel || rows[i].length == 0 ||
            compare_curves(measured, &clock, channel, &rows[i], solver_error(head, &rows[i]),
                           &series, error) != MR_OK)
            continue;
        draw_channel(out, &series, measured->samples, &rows[i], i, si);
        free(series.storage);
    }
    svg_legend(out, MARGIN, WIDTH - MARGIN, 16.0, keys, 2);
    svg_close(out);
    return error->status;
}

static void csv_number(FILE *out, double value)
{
    if (isnan(value))
        fputc(',', out);
    else
        fprintf(out, ",%.8g", value);
}

enum mr_status compare_csv(FILE *out, const struct measured *measured,
                           const struct store_simulation_head *head,
                           const struct store_simulation *rows, size_t count, bool si,
                           struct error *error)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    struct compare_curves series[MR_TRANSDUCERS];
    struct compare_clock clock;
    size_t made = 0;
    compare_clock_make(measured, &clock);
    fputs("t_s", out);
    for (size_t i = 0; i < count && i < MR_TRANSDUCERS && error->status == MR_OK; i++) {
        const struct measured_channel *channel = channel_of(measured, &rows[i]);
        if (!channel || rows[i].length == 0 ||
            compare_curves(measured, &clock, channel, &rows[i], solver_error(head, &rows[i]),
                           &series[made], error) != MR_OK)
            continue;
        made++;
        static const char *const names[] = {"measured", "measured_error", "simulated",
                                            "simulated_error", "alignment"};
        for (size_t k = 0; k < 5; k++)
            fprintf(out, ",d%" PRId64 "_%s_%s", rows[i].number, names[k], length->suffix);
    }
    fputc('\n', out);
    for (size_t i = 0; i < measured->samples && error->status == MR_OK; i++) {
        double t_s = measured_time_s(measured, i);
        if (t_s < 0.0)
            continue;
        fprintf(out, "%.7f", t_s);
        for (size_t c = 0; c < made; c++) {
            const struct compare_curves *s = &series[c];
            const double *columns[] = {s->measured_in, s->measured_error_in, s->simulated_in,
                                       s->simulated_error_in, s->alignment_in};
            for (size_t k = 0; k < 5; k++)
                csv_number(out, columns[k][i] * length->factor);
        }
        fputc('\n', out);
    }
    for (size_t c = 0; c < made; c++)
        free(series[c].storage);
    return error->status;
}
