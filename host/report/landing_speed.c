/* Speed and deceleration against time, and how far each switch is from the fit. */
#include <math.h>

#include "host/report/chart.h"
#include "host/report/report.h"
#include "host/base/svg_words.h"

#define CURVE_POINTS    400
#define SPEED_PX        190.0
#define DECELERATION_PX 120.0
#define RESIDUAL_PX     100.0
#define BETWEEN_PX      16.0
#define TOP_PX          26.0
#define IN_PER_FT       12.0
#define MARK_PX         2.6

static void draw_speed_curve(const struct svg_plot *plot, const struct measured *measured,
                             double factor)
{
    double t[CURVE_POINTS + 1], v[CURVE_POINTS + 1], low[CURVE_POINTS + 1], high[CURVE_POINTS + 1];
    double stop_s = measured->summary.stop_t_s.value;
    for (size_t i = 0; i <= CURVE_POINTS; i++) {
        double error_ft_s;
        t[i] = stop_s * (double)i / CURVE_POINTS;
        v[i] = factor * measured_speed_ft_s(measured, t[i], &error_ft_s);
        low[i] = v[i] - factor * SUMMARY_95 * error_ft_s;
        high[i] = v[i] + factor * SUMMARY_95 * error_ft_s;
    }
    svg_band(plot, "band", t, low, high, CURVE_POINTS + 1);
    svg_line(plot, "line a", t, v, CURVE_POINTS + 1);
}

static void draw_gate_speeds(const struct svg_plot *plot, const struct measured *measured,
                             double factor)
{
    for (size_t i = 1; i < measured->gates; i++) {
        const struct mr_gate *from = &measured->gate[i - 1];
        const struct mr_gate *to = &measured->gate[i];
        double t_s = 0.5 * (from->t_s + to->t_s);
        if (t_s >= plot->x.low)
            svg_mark(
                plot->out, "dot b", 1, svg_x(plot, t_s),
                svg_y(plot, factor * (to->station_ft - from->station_ft) / (to->t_s - from->t_s)),
                MARK_PX);
    }
}

static void draw_online_speeds(const struct svg_plot *plot, const struct report_landing *landing,
                               double factor)
{
    const struct measured *measured = &landing->summary.measured;
    for (size_t i = 0; i < landing->motions; i++) {
        const struct store_motion *motion = &landing->motion[i];
        double t_s = measured_block_s(measured, motion->block);
        double v = factor * motion->speed_ft_s;
        if (t_s < plot->x.low || t_s > plot->x.high || isnan(v) || v > plot->y.high)
            continue;
        double half = isnan(motion->speed_error_ft_s)
                        ? 0.0
                        : factor * SUMMARY_95 * motion->speed_error_ft_s;
        /* else the mark hides it */
        if (svg_y(plot, v - half) - svg_y(plot, v + half) > 2.0 * MARK_PX)
            chart_whisker(plot, "line c", t_s, v - half, v + half);
        svg_mark(plot->out, "dot c", 2, svg_x(plot, t_s), svg_y(plot, v), MARK_PX);
    }
}

static void speed_panel(FILE *out, const struct report_landing *landing, struct svg_axis time,
                        bool si)
{
    const struct measured *measured = &landing->summary.measured;
    struct chart_text label = chart_label("speed", UNIT_SPEED, si);
    double factor = unit_of(UNIT_SPEED, si)->factor;
    struct svg_plot plot = {.out = out,
                            .left = CHART_LEFT,
                            .top = TOP_PX,
                            .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                            .height = SPEED_PX};
    time.label = NULL;
    time.ticks = false;
    plot.x = time;
    plot.y = (struct svg_axis){0.0, 1.12 * factor * measured->summary.touchdown_speed_ft_s.value,
                               label.text, true};
    svg_axes(&plot);
    draw_speed_curve(&plot, measured, factor);
    draw_gate_speeds(&plot, measured, factor);
    draw_online_speeds(&plot, landing, factor);
}

/* Of the fit, where it has switches on both sides. */
static size_t deceleration_curve(const struct measured *measured, double factor, double *t_s,
                                 double *value, double *low, double *high)
{
    double first_s = fmax(0.0, measured->fit.mid_s - measured->fit.half_s),
           last_s = measured->fit.mid_s + measured->fit.half_s;
    for (size_t i = 0; i <= CURVE_POINTS; i++) {
        struct mr_motion_estimate motion;
        t_s[i] = first_s + (last_s - first_s) * (double)i / CURVE_POINTS;
        mr_gates_at(&measured->fit, t_s[i], &motion);
        value[i] = factor * motion.deceleration_ft_s2.value;
        low[i] = value[i] - factor * SUMMARY_95 * motion.deceleration_ft_s2.error;
        high[i] = value[i] + factor * SUMMARY_95 * motion.deceleration_ft_s2.error;
    }
    return CURVE_POINTS + 1;
}

static void deceleration_panel(FILE *out, const struct report_landing *landing,
                               struct svg_axis time, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    struct chart_text label = chart_label("deceleration", UNIT_DECELERATION, si);
    double factor = unit_of(UNIT_DECELERATION, si)->factor, t_s[CURVE_POINTS + 1],
           value[CURVE_POINTS + 1], low[CURVE_POINTS + 1], high[CURVE_POINTS + 1], least = 0.0,
           most = factor;
    double mean = factor * measured->summary.mean_deceleration_ft_s2.value;
    const double means[] = {mean, mean}, ends[] = {0.0, measured->summary.stop_t_s.value};
    size_t count = deceleration_curve(measured, factor, t_s, value, low, high);
    struct svg_plot plot = {.out = out,
                            .left = CHART_LEFT,
                            .top = TOP_PX + SPEED_PX + BETWEEN_PX,
                            .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                            .height = DECELERATION_PX};
    chart_extend(value, count, &least, &most);
    chart_extend(means, 1, &least, &most);
    svg_widen(&least, &most, factor);
    time.label = NULL;
    time.ticks = false;
    plot.x = time;
    plot.y = (struct svg_axis){least, most, label.text, true};
    svg_axes(&plot);
    svg_band(&plot, "band", t_s, low, high, count);
    svg_line(&plot, "line a", t_s, value, count);
    svg_line(&plot, "mark", ends, means, 2);
    for (size_t i = 0; i < landing->motions; i++) {
        double at_s = measured_block_s(measured, landing->motion[i].block),
               v = factor * landing->motion[i].deceleration_ft_s2;
        if (at_s >= 0.0 && at_s <= time.high && v >= least && v <= most)
            svg_mark(out, "dot c", 2, svg_x(&plot, at_s), svg_y(&plot, v), MARK_PX);
    }
}

/* Of the switches that the fit covers. */
static void residual_panel(FILE *out, const struct measured *measured, struct svg_axis time,
                           bool si)
{
    struct chart_text label = chart_label("residual", UNIT_DISPLACEMENT, si);
    double factor = IN_PER_FT * unit_of(UNIT_DISPLACEMENT, si)->factor, residual[MR_GATES_MAX];
    double tolerance = factor * SUMMARY_95 * measured->landing.switch_error_ft, low = -tolerance,
           high = tolerance;
    struct svg_plot plot = {.out = out,
                            .left = CHART_LEFT,
                            .top = TOP_PX + SPEED_PX + DECELERATION_PX + 2.0 * BETWEEN_PX,
                            .width = CHART_WIDTH - CHART_LEFT - CHART_RIGHT,
                            .height = RESIDUAL_PX};
    double first_s = measured->fit.mid_s - measured->fit.half_s - 1e-6,
           last_s = measured->fit.mid_s + measured->fit.half_s + 1e-6;
    for (size_t i = 0; i < measured->gates; i++) {
        struct mr_motion_estimate motion;
        mr_gates_at(&measured->fit, measured->gate[i].t_s, &motion);
        bool inside = measured->gate[i].t_s >= first_s && measured->gate[i].t_s <= last_s;
        residual[i] = inside ? factor * (measured->gate[i].station_ft - motion.position_ft.value)
                             : (double)NAN;
    }
    chart_extend(residual, measured->gates, &low, &high);
    svg_widen(&low, &high, 0.02 * factor / IN_PER_FT);
    plot.x = time;
    plot.y = (struct svg_axis){low, high, label.text, true};
    svg_axes(&plot);
    svg_rect(&plot, "band", time.low, -tolerance, time.high, tolerance);
    svg_line(&plot, "mark", (const double[]){time.low, time.high}, (const double[]){0.0, 0.0}, 2);
    for (size_t i = 0; i < measured->gates; i++) {
        if (!isnan(residual[i]))
            svg_mark(out, "dot b", 1, svg_x(&plot, measured->gate[i].t_s),
                     svg_y(&plot, residual[i]), MARK_PX);
    }
}

static void draw_all(FILE *out, const struct report_landing *landing, bool si)
{
    const struct measured *measured = &landing->summary.measured;
    const struct svg_key keys[] = {{"line a", "fit, with its 95 % band"},
                                   {"mark", "mean deceleration"}};
    struct svg_axis time = {-0.3, measured->summary.stop_t_s.value * 1.03,
                            "time since touchdown, s", true};
    svg_open(out, CHART_WIDTH,
             TOP_PX + SPEED_PX + DECELERATION_PX + RESIDUAL_PX + 2.0 * BETWEEN_PX + 40.0,
             "speed and deceleration of the gear, and residuals of the switches, against time");
    speed_panel(out, landing, time, si);
    deceleration_panel(out, landing, time, si);
    residual_panel(out, measured, time, si);
    svg_legend(out, CHART_LEFT, CHART_WIDTH - CHART_RIGHT, 14.0, keys, 2);
    chart_mark_key(out, "dot b", 1, 430.0, 14.0, "mean between switches; below, a switch");
    chart_mark_key(out, "dot c", 2, 680.0, 14.0, "the board, as it went");
    svg_close(out);
}

enum mr_status landing_speed(const struct report *report, const struct report_landing *landing,
                             FILE *out, struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, report->si);
    (void)error;
    if (measured->fit_status != MR_OK || measured->samples == 0)
        return MR_OK;
    fputs("<figure>", out);
    draw_all(out, landing, report->si);
    fprintf(out,
            "<figcaption>From the switches; their places are the only measure of length. Residual: "
            "place of a switch less the fit's when it opened "
            "(polynomial of order %u through %u of %zu switches, residual standard deviation %.3f "
            "%s); shaded: 95 %% of what the switches are placed to, "
            "&plusmn; %.3f %s.</figcaption></figure>\n",
            measured->fit.order, measured->fit.count, measured->gates,
            measured->fit.residual_ft * IN_PER_FT * length->factor, length->text,
            SUMMARY_95 * measured->landing.switch_error_ft * IN_PER_FT * length->factor,
            length->text);
    return MR_OK;
}
