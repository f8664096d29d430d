/* Sections about a landing: facts, motion of the gear, movement of the mat, tension of the bands,
 * health of the instrument. */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

#include "common/predictor.h"
#include "host/analyse/rig.h"
#include "host/analyse/summary.h"
#include "host/analyse/track.h"
#include "host/base/html.h"
#include "host/base/xmalloc.h"
#include "host/compare/figures.h"
#include "host/compare/show.h"
#include "host/report/chart.h"
#include "host/report/report.h"

#define CURVE_POINTS      200
#define COMPARISON_POINTS 100u
#define IN_PER_FT         12.0

static bool has_motion_fit(const struct report_landing *landing)
{
    const struct measured_landing *measured = &landing->summary.measured;
    return measured->fit_status == MR_OK && measured->samples > 0;
}

/* ---- facts ---- */

static void write_facts(const struct report *report, const struct report_landing *landing,
                        FILE *out)
{
    struct answer *answer = answer_new(report->si);
    summary_add_facts(&landing->summary, answer);
    if (landing->summary.measured.source != MEASURED_IMPORT)
        answer_add_text(
            answer, NULL, "sample rate and filter",
            "1 kHz; a sample is the mean of 8 conversions at 8 kHz (-3 dB at 443 Hz). %s "
            "Plots show samples without further filtering",
            landing->summary.measured.source == MEASURED_CAN
                ? "From CAN: means of 2 ms (displacement) and 4 ms (tension)."
                : "");
    answer_add_text(answer, NULL, "raw data", "matrig export %s %lld --format csv -o run%lld.csv",
                    report_database_name(report), (long long)landing->summary.measured.landing.id,
                    (long long)landing->summary.measured.landing.id);
    report_write_answer(answer, out);
}

/* ---- speed and deceleration ---- */

struct curve {
    double t_s[CURVE_POINTS + 1], value[CURVE_POINTS + 1], half_width[CURVE_POINTS + 1];
};

static void draw_curve(struct figure *figure, const struct curve *curve)
{
    figure_add_series(figure,
                      &(struct chart_series){"curve with 95 % band", 0, "line", curve->t_s,
                                             curve->value, curve->half_width, CURVE_POINTS + 1});
}

/* Draws the board's own estimates during the landing, without values above `most`. */
static void draw_board_estimates(struct figure *figure, const struct report_landing *landing,
                                 bool speed, double most)
{
    size_t count = 0;
    double *t_s = xcalloc(3 * (landing->motion_count + 1), sizeof *t_s),
           *value = t_s + landing->motion_count + 1, *half = value + landing->motion_count + 1;
    for (size_t i = 0; i < landing->motion_count; i++) {
        const struct store_motion *motion = &landing->motion[i];
        double v = speed ? motion->speed_ft_s : motion->deceleration_ft_s2;
        t_s[count] = measured_block_time_s(&landing->summary.measured, motion->block);
        if (t_s[count] < -CHART_TIME_BEFORE_TOUCHDOWN_S || !(v >= 0.0) || v > most)
            continue;
        double error = speed ? motion->speed_error_ft_s : motion->deceleration_error_ft_s2;
        half[count] = isfinite(error) ? SUMMARY_HALF_WIDTH_95 * error : 0.0;
        value[count++] = v;
    }
    figure_add_series(figure, &(struct chart_series){"board, during the landing", 2,
                                                     speed ? "whiskers" : "apart", t_s, value, half,
                                                     count});
    free(t_s);
}

static void draw_speed(struct figure *figure, const struct report_landing *landing,
                       struct chart_axes axes)
{
    const struct measured_landing *measured = &landing->summary.measured;
    double t_s[MR_GATES_MAX], mean[MR_GATES_MAX];
    double most = 1.12 * measured->summary.touchdown_speed_ft_s.value;
    struct curve curve;
    size_t count = 0;
    axes.y = "speed";
    axes.y_unit = UNIT_SPEED;
    axes.y_high = most;
    axes.height_px = 200;
    figure_begin_plot(figure, &axes);
    for (size_t i = 0; i <= CURVE_POINTS; i++) {
        double error_ft_s;
        curve.t_s[i] = measured->summary.stop_t_s.value * (double)i / CURVE_POINTS;
        curve.value[i] = measured_speed_ft_s(measured, curve.t_s[i], &error_ft_s);
        curve.half_width[i] = SUMMARY_HALF_WIDTH_95 * error_ft_s;
    }
    draw_curve(figure, &curve);
    for (size_t i = 1; i < measured->gate_count; i++) {
        const struct mr_gate *from = &measured->gate[i - 1], *to = &measured->gate[i];
        t_s[count] = 0.5 * (from->t_s + to->t_s);
        mean[count++] = (to->station_ft - from->station_ft) / (to->t_s - from->t_s);
    }
    figure_add_series(figure, &(struct chart_series){"mean between two switches", 1, "points", t_s,
                                                     mean, NULL, count});
    draw_board_estimates(figure, landing, true, most);
}

/* Draws the deceleration, only between the first switch beyond touchdown and the last one. */
static void draw_deceleration(struct figure *figure, const struct report_landing *landing,
                              struct chart_axes axes)
{
    const struct measured_landing *measured = &landing->summary.measured;
    double most = 1.0;
    double first_s = measured->track->first_gate.t_s,
           span_s = measured->track->last_gate.t_s - first_s,
           mean = measured->summary.mean_deceleration_ft_s2.value;
    struct curve curve;
    for (size_t i = 0; i <= CURVE_POINTS; i++) {
        curve.t_s[i] = first_s + span_s * (double)i / CURVE_POINTS;
        struct mr_estimate at = track_compute_deceleration(measured->track, curve.t_s[i]);
        curve.value[i] = at.value;
        curve.half_width[i] = SUMMARY_HALF_WIDTH_95 * at.error;
        most = fmax(most, curve.value[i]);
    }
    axes.y = "deceleration";
    axes.y_unit = UNIT_DECELERATION;
    axes.y_high = 1.1 * fmax(most, mean);
    axes.height_px = 140;
    figure_begin_plot(figure, &axes);
    draw_curve(figure, &curve);
    figure_add_shape(figure, "mark", 0.0, measured->summary.stop_t_s.value, mean, mean, NULL);
    draw_board_estimates(figure, landing, false, axes.y_high);
}

/* Draws the residuals of the switches beyond touchdown, each from its prediction by the others. */
static void draw_residuals(struct figure *figure, const struct track *track, struct chart_axes axes)
{
    double t_s[MR_GATES_MAX], residual[MR_GATES_MAX], half_width[MR_GATES_MAX];
    axes.y = "residual";
    axes.y_unit = UNIT_DISPLACEMENT;
    axes.x = CHART_TIME_LABEL;
    axes.height_px = 120;
    figure_begin_plot(figure, &axes);
    figure_add_shape(figure, "mark", (double)NAN, (double)NAN, 0.0, 0.0, NULL);
    for (size_t i = 0; i < track->gate_count; i++) {
        struct mr_estimate residual_ft = track_compute_residual_ft(track, i);
        t_s[i] = track->first_gate.t_s + track->t_s[i];
        residual[i] = IN_PER_FT * residual_ft.value;
        half_width[i] = IN_PER_FT * SUMMARY_HALF_WIDTH_95 * residual_ft.error;
    }
    figure_add_series(figure, &(struct chart_series){NULL, 1, "whiskers", t_s, residual, half_width,
                                                     track->gate_count});
}

static void write_speed(const struct report *report, const struct report_landing *landing,
                        FILE *out)
{
    static const char *const keys[] = {"mark", "mean deceleration", NULL};
    const struct measured_landing *measured = &landing->summary.measured;
    const struct chart_axes axes = {.x_unit = UNIT_NUMBER,
                                    .x_low = -CHART_TIME_BEFORE_TOUCHDOWN_S,
                                    .x_high = measured->summary.stop_t_s.value * 1.03};
    if (!has_motion_fit(landing))
        return;
    struct figure figure = figure_begin(
        out, report->si,
        "speed and deceleration of the gear, and residuals of the switches, against time", 1,
        FIGURE_RANGE_PER_PLOT);
    draw_speed(&figure, landing, axes);
    if (measured->track->has_gates) {
        draw_deceleration(&figure, landing, axes);
        if (measured->track->gate_count >= TRACK_RESIDUAL_GATES_MIN)
            draw_residuals(&figure, measured->track, axes);
    }
    figure_end(&figure, keys,
               "Curve: smoothed through the switches, which also determine the amount of "
               "smoothing. Deceleration: mean over about the time between two switches; the bands "
               "do not include faster changes, such as by anti-skid. Residual: station of a switch "
               "minus its prediction from the other switches, with 95 %% interval.");
}

/* ---- the mat ---- */

/* Readings of a channel between two times. Depending on the axis, x is the time, the station of the
 * wheel, or the distance of the transducer ahead of the wheel (between SHOWN_BEHIND_WHEEL_FT and
 * SHOWN_AHEAD_OF_WHEEL_FT). The caller frees x. */
enum trace_axis { TRACE_OVER_TIME, TRACE_OVER_WHEEL_STATION, TRACE_OVER_DISTANCE_AHEAD };
#define SHOWN_BEHIND_WHEEL_FT   30.0
#define SHOWN_AHEAD_OF_WHEEL_FT 50.0

struct trace {
    double *x, *y;
    size_t count;
};

static struct trace make_trace(const struct report_landing *landing,
                               const struct measured_channel *channel, enum trace_axis against,
                               double from_s, double to_s)
{
    const struct measured_landing *measured = &landing->summary.measured;
    struct trace trace = {.x = xmalloc(2 * (measured->samples + 1) * sizeof *trace.x)};
    trace.y = trace.x + measured->samples + 1;
    for (size_t i = 0; i < measured->samples; i++) {
        double t_s = measured_time_s(measured, i),
               ahead_ft = (double)channel->config.station_ft - landing->station_ft[i];
        if (t_s < from_s || t_s > to_s ||
            (against == TRACE_OVER_DISTANCE_AHEAD &&
             !(ahead_ft >= -SHOWN_BEHIND_WHEEL_FT && ahead_ft <= SHOWN_AHEAD_OF_WHEEL_FT)))
            continue;
        trace.x[trace.count] = against == TRACE_OVER_TIME          ? t_s
                             : against == TRACE_OVER_WHEEL_STATION ? landing->station_ft[i]
                                                                   : ahead_ft;
        trace.y[trace.count++] = measured_value(channel, i);
    }
    return trace;
}

static void draw_trace(struct figure *figure, const char *name, unsigned look, const char *kind,
                       struct trace trace)
{
    figure_add_series(
        figure, &(struct chart_series){name, look, kind, trace.x, trace.y, NULL, trace.count});
    free(trace.x);
}

/* Writes the sensor that the configuration names, " (LV-1023)"; "": none. */
#define SENSOR_TEXT_SIZE 20
static const char *format_sensor(const struct report_landing *landing, unsigned channel,
                                 char out[SENSOR_TEXT_SIZE])
{
    const struct mr_channel_config *read = landing->config ? &landing->config->channel[channel]
                                                           : NULL;
    out[0] = '\0';
    if (read && read->serial[0])
        snprintf(out, SENSOR_TEXT_SIZE, " (%.*s)", (int)sizeof read->serial, read->serial);
    return out;
}

static void write_movement(const struct report *report, const struct report_landing *landing,
                           FILE *out)
{
    static const char *const keys[] = {"mark", "wheel at the transducer", NULL};
    const struct measured_landing *measured = &landing->summary.measured;
    const struct unit *station = unit_get(UNIT_STATION, report->si);
    const double end_s = measured->summary.stop_t_s.value + CHART_TIME_AFTER_STOP_S;
    char title[CHART_LABEL_SIZE], sensor[SENSOR_TEXT_SIZE];
    if (!has_motion_fit(landing))
        return;
    struct figure figure = figure_begin(out, report->si,
                                        "displacement of eight stations against gear position", 2,
                                        FIGURE_RANGE_SHARED | FIGURE_RANGE_WITH_ZERO);
    for (unsigned number = 1; number <= MR_TRANSDUCERS; number++) {
        int c = measured_channel_index(measured, MR_KIND_DISPLACEMENT, number);
        if (c < 0)
            continue;
        const struct measured_channel *channel = &measured->channel[c];
        double at = (double)channel->config.station_ft;
        snprintf(title, sizeof title, "Transducer %u%s: %.*f %s%s", number,
                 format_sensor(landing, (unsigned)c, sensor), report->si ? 1 : 0,
                 station->factor * at, station->text, channel->valid_samples ? "" : ", not valid");
        figure_begin_plot(&figure, &(struct chart_axes){.title = title,
                                                        .x = "gear position",
                                                        .x_unit = UNIT_STATION,
                                                        .y = "displacement",
                                                        .y_unit = UNIT_DISPLACEMENT,
                                                        .x_high = RIG_RUNWAY_FT,
                                                        .height_px = 150});
        figure_add_shape(&figure, "mark", at, at, (double)NAN, (double)NAN, NULL);
        draw_trace(&figure, "measured", 0, "line",
                   make_trace(landing, channel, TRACE_OVER_WHEEL_STATION, 0.0, end_s));
    }
    figure_end(&figure, keys,
               "Displacement relative to the mean of the 0.5 s before the first switch opened; "
               "downfield is positive. Compare fig. 2.13 of the 1973 report.");
}

/* Draws the displacement over the distance from the wheel, only while the gear rolls: after the
 * stop the distance is constant. */
static void write_movement_by_wheel_distance(const struct report *report,
                                             const struct report_landing *landing, FILE *out)
{
    const struct measured_landing *measured = &landing->summary.measured;
    const struct unit *station = unit_get(UNIT_STATION, report->si);
    char name[CHART_LABEL_SIZE];
    if (!has_motion_fit(landing))
        return;
    struct figure figure = figure_begin(
        out, report->si, "displacement against distance from the front wheel of the main bogie", 1,
        FIGURE_RANGE_PER_PLOT);
    figure_begin_plot(
        &figure, &(struct chart_axes){.x = "distance of the transducer ahead of the front wheel",
                                      .x_unit = UNIT_STATION,
                                      .y = "displacement",
                                      .y_unit = UNIT_DISPLACEMENT,
                                      .x_low = -SHOWN_BEHIND_WHEEL_FT,
                                      .x_high = SHOWN_AHEAD_OF_WHEEL_FT,
                                      .height_px = 270});
    figure_add_shape(&figure, "mark", 0.0, 0.0, (double)NAN, (double)NAN, NULL);
    for (unsigned number = 1; number <= MR_TRANSDUCERS; number++) {
        int c = measured_channel_index(measured, MR_KIND_DISPLACEMENT, number);
        if (c < 0 || measured->channel[c].valid_samples == 0)
            continue;
        snprintf(name, sizeof name, "%.*f %s", report->si ? 1 : 0,
                 (double)measured->channel[c].config.station_ft * station->factor, station->text);
        draw_trace(&figure, name, number - 1, "marked",
                   make_trace(landing, &measured->channel[c], TRACE_OVER_DISTANCE_AHEAD, 0.0,
                              measured->summary.stop_t_s.value));
    }
    figure_end(
        &figure, NULL,
        "One line for each transducer while the gear rolls; the name of a line is the station. The "
        "wheel approaches from the right; behind the wheel the distance is negative.");
}

#define WHEEL_PATH_POINTS           200
#define PLOTTED_ZONE_DURATION_MIN_S 0.05

/* ---- the zone map ---- */

#define CHECK_PERIOD_BLOCKS   20 /* number of blocks between two checks for closed segments */
#define ZONE_MAP_AFTER_STOP_S 0.8

/* Draws a rectangle for a segment that is closed, from one check to the next. Segments ahead of the
 * wheel have a stronger colour than those behind it. */
static void draw_closed_segment(struct figure *figure, const struct report_landing *landing,
                                unsigned segment, double from_s, double to_s)
{
    double start_ft = (double)MR_SEGMENT_LENGTH_FT * segment,
           end_ft = start_ft + (double)MR_SEGMENT_LENGTH_FT;
    double passed_s = measured_arrival_time_s(&landing->summary.measured, end_ft);
    if (measured_station_ft(&landing->summary.measured, from_s) > end_ft)
        passed_s = from_s;
    passed_s = isnan(passed_s) ? to_s : fmin(to_s, fmax(from_s, passed_s));
    if (passed_s > from_s)
        figure_add_shape(figure, "closed", start_ft, end_ft, from_s, passed_s, NULL);
    if (to_s > passed_s)
        figure_add_shape(figure, "behind", start_ft, end_ft, passed_s, to_s, NULL);
}

static void draw_closed_segments(struct figure *figure, const struct report_landing *landing,
                                 double last_s)
{
    const struct measured_landing *measured = &landing->summary.measured;
    double since_s[MR_SEGMENTS], t_s = 0.0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        since_s[s] = (double)NAN;
    for (size_t i = 0; i < measured->samples; i += CHECK_PERIOD_BLOCKS) {
        float remaining_in[MR_SEGMENTS];
        t_s = measured_time_s(measured, i);
        if (t_s < -0.2 || t_s > last_s)
            continue;
        zones_compute_remaining_slack(measured, &landing->survey, i, remaining_in);
        for (unsigned s = 0; s < MR_SEGMENTS; s++) {
            bool closed = remaining_in[s] < ZONES_CLOSED_SEGMENT_MAX_IN;
            if (closed && isnan(since_s[s])) {
                since_s[s] = t_s;
            } else if (!closed && !isnan(since_s[s])) {
                draw_closed_segment(figure, landing, s, since_s[s], t_s);
                since_s[s] = (double)NAN;
            }
        }
    }
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(since_s[s]))
            draw_closed_segment(figure, landing, s, since_s[s], fmin(t_s, last_s));
    }
}

static void draw_warnings(struct figure *figure, const struct report_landing *landing)
{
    const struct measured_landing *measured = &landing->summary.measured;
    const struct zones *zones = &landing->summary.zones;
    const struct zone_warning *warning = &zones->warning;
    for (size_t i = 0; i < zones->count; i++) {
        const struct store_zone *row = &zones->row[i];
        double t_s = zones_time_s(measured, row);
        double until_s = i + 1 < zones->count ? zones_time_s(measured, row + 1)
                                              : t_s + PLOTTED_ZONE_DURATION_MIN_S;
        if (row->warning == 1)
            figure_add_shape(figure, "warned", row->start_ft, row->end_ft, t_s,
                             fmin(until_s, t_s + 0.1), NULL);
    }
    if (!warning->has_warning)
        return;
    double t_s = fmax(warning->t_s, -0.1), wheel_ft = measured_station_ft(measured, warning->t_s);
    figure_add_shape(figure, "lead", isnan(wheel_ft) ? warning->start_ft : wheel_ft,
                     warning->end_ft, t_s, t_s, NULL);
}

static void write_zone_map(const struct report *report, const struct report_landing *landing,
                           FILE *out)
{
    char doubt[ZONES_REASON_SIZE], caption[200] = "";
    const struct zone_warning *warning = &landing->summary.zones.warning;
    const char *keys[] = {"closed", "closed segments ahead of the wheel",
                          "behind", "closed segments behind the wheel",
                          "sensor", "transducers",
                          "warned", "zone reported, warning on",
                          "lead",   "first warning",
                          NULL};
    const struct measured_landing *measured = &landing->summary.measured;
    const double last_s = measured->summary.stop_t_s.value + ZONE_MAP_AFTER_STOP_S;
    double x[WHEEL_PATH_POINTS + 1], t_s[WHEEL_PATH_POINTS + 1], gate_ft[MR_GATES_MAX],
        gate_s[MR_GATES_MAX];
    size_t gates = 0;
    if (!has_motion_fit(landing))
        return;
    struct figure figure = figure_begin(
        out, report->si, "zone map: closed segments, wheel and warning over station and time", 1,
        FIGURE_RANGE_PER_PLOT);
    figure_begin_plot(&figure, &(struct chart_axes){.x = "station",
                                                    .x_unit = UNIT_STATION,
                                                    .y = CHART_TIME_LABEL,
                                                    .y_unit = UNIT_NUMBER,
                                                    .x_high = RIG_RUNWAY_FT,
                                                    .y_low = -0.2,
                                                    .y_high = last_s,
                                                    .height_px = 340});
    draw_closed_segments(&figure, landing, last_s);
    draw_warnings(&figure, landing);
    for (size_t i = 0; i <= WHEEL_PATH_POINTS; i++) {
        t_s[i] = last_s * (double)i / WHEEL_PATH_POINTS;
        x[i] = measured_station_ft(measured, t_s[i]);
    }
    figure_add_series(&figure,
                      &(struct chart_series){"wheel, and the switches opened by the wheel", 0,
                                             "line", x, t_s, NULL, WHEEL_PATH_POINTS + 1});
    for (size_t i = 0; i < measured->gate_count; i++) {
        gate_ft[gates] = measured->gate[i].station_ft;
        gate_s[gates] = measured->gate[i].t_s;
        gates += measured->gate[i].station_ft >= 0.0;
    }
    figure_add_series(&figure,
                      &(struct chart_series){NULL, 0, "points", gate_ft, gate_s, NULL, gates});
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        double at = (double)measured->channel[c].config.station_ft;
        if (measured->channel[c].config.kind == MR_KIND_DISPLACEMENT)
            figure_add_shape(&figure, "sensor", at, at, (double)NAN, (double)NAN, NULL);
    }
    if (warning->has_warning) {
        if (zones_format_earlier_warning_reason(&landing->summary.zones, doubt))
            keys[9] = "first warning received";
        snprintf(caption, sizeof caption,
                 " Zone reported: by the board. First warning: line from the wheel to the end of "
                 "the zone of %lld mats reported then.",
                 (long long)warning->mats);
    }
    figure_end(&figure, keys, "Closed segments: computed here from survey and transducers.%s",
               caption);
}

/* ---- the predictor ---- */

/* Draws one rectangle for consecutive messages with the same zone. */
static void draw_reported_zones(struct figure *figure, const struct zones *zones,
                                const struct measured_landing *measured)
{
    for (size_t i = 0, next; i < zones->count; i = next) {
        const struct store_zone *row = &zones->row[i];
        double from_s = zones_time_s(measured, row), to_s = from_s;
        for (next = i; next < zones->count; next++) {
            const struct store_zone *other = &zones->row[next];
            double t_s = zones_time_s(measured, other);
            if (other->mats != row->mats || (other->warning == 1) != (row->warning == 1) ||
                t_s > to_s + 0.001)
                break;
            double until_s = next + 1 < zones->count ? zones_time_s(measured, other + 1)
                                                     : t_s + PLOTTED_ZONE_DURATION_MIN_S;
            to_s = fmin(until_s, t_s + 2.0 * PLOTTED_ZONE_DURATION_MIN_S);
        }
        if (row->mats > 0)
            figure_add_shape(figure, row->warning == 1 ? "warned" : "reported",
                             fmax(from_s, -CHART_TIME_BEFORE_TOUCHDOWN_S), to_s, 0.0,
                             (double)row->mats, NULL);
    }
}

static void draw_zone_lengths(struct figure *figure, const struct report_landing *landing,
                              struct chart_axes axes)
{
    const struct zones *zones = &landing->summary.zones;
    const struct measured_landing *measured = &landing->summary.measured;
    double *t_s = xmalloc(2 * (landing->prediction_count + 1) * sizeof *t_s),
           *mats = t_s + landing->prediction_count + 1;
    size_t count = 0;
    axes.x = CHART_TIME_LABEL;
    axes.y = "mats in the zone";
    axes.y_unit = UNIT_NUMBER;
    axes.y_high = 60.0;
    axes.height_px = 150;
    for (size_t i = 0; i < zones->count; i++)
        axes.y_high = fmax(axes.y_high, 1.05 * (double)zones->row[i].mats);
    for (size_t i = 0; i < landing->prediction_count; i++)
        axes.y_high = fmax(axes.y_high, 1.05 * (double)landing->prediction[i].coming_mats);
    figure_begin_plot(figure, &axes);
    draw_reported_zones(figure, zones, measured);
    figure_add_shape(figure, "mark", (double)NAN, (double)NAN, MR_PREDICTOR_WARNING_MATS,
                     MR_PREDICTOR_WARNING_MATS, NULL);
    figure_add_shape(figure, "mark", (double)NAN, (double)NAN, MR_PREDICTOR_ADVISORY_MATS,
                     MR_PREDICTOR_ADVISORY_MATS, NULL);
    for (size_t i = 0; i < landing->prediction_count; i++) {
        t_s[count] = measured_block_time_s(measured, landing->prediction[i].block);
        mats[count] = (double)landing->prediction[i].coming_mats;
        count += landing->prediction[i].coming_mats > 0;
    }
    figure_add_series(figure, &(struct chart_series){"longest zone predicted", 2, "dots", t_s, mats,
                                                     NULL, count});
    free(t_s);
}

static void write_predictions(const struct report *report, const struct report_landing *landing,
                              FILE *out)
{
    static const char *const keys[] = {
        "warned", "closed zone ahead, warning", "reported", "closed zone ahead, no warning",
        "mark",   "limits: 30 and 50 mats",     NULL};
    const struct measured_landing *measured = &landing->summary.measured;
    const struct chart_axes axes = {.x_unit = UNIT_NUMBER,
                                    .x_low = -CHART_TIME_BEFORE_TOUCHDOWN_S,
                                    .x_high = measured->summary.stop_t_s.value +
                                              CHART_TIME_AFTER_STOP_S};
    struct answer *answer = answer_new(report->si);
    summary_add_zone(&landing->summary, answer);
    report_write_answer(answer, out);
    if (measured->fit_status != MR_OK || landing->summary.zones.count == 0)
        return;
    struct figure figure = figure_begin(
        out, report->si, "zone that the board reported, against time", 1, FIGURE_RANGE_PER_PLOT);
    draw_zone_lengths(&figure, landing, axes);
    figure_end(&figure, keys, "All zone reports of the board.");
}

/* ---- the bands ---- */

static void write_tensions(const struct report *report, const struct report_landing *landing,
                           FILE *out)
{
    const struct measured_landing *measured = &landing->summary.measured;
    const struct unit *station = unit_get(UNIT_STATION, report->si);
    const double end_s = measured->summary.stop_t_s.value + CHART_TIME_AFTER_STOP_S;
    char title[CHART_LABEL_SIZE], name[CHART_LABEL_SIZE];
    bool drawn[MR_CHANNELS] = {false}, any = false;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        drawn[c] = measured->channel[c].config.kind != MR_KIND_TENSION ||
                   isnan(measured->channel[c].config.station_ft);
        any = any || !drawn[c];
    }
    if (!has_motion_fit(landing) || !any)
        return;
    struct figure figure = figure_begin(out, report->si, "band tensions against time", 2,
                                        FIGURE_RANGE_SHARED);
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        float station_ft = measured->channel[c].config.station_ft;
        if (drawn[c])
            continue;
        snprintf(title, sizeof title, "Station %.*f %s", report->si ? 1 : 0,
                 (double)station_ft * station->factor, station->text);
        figure_begin_plot(&figure, &(struct chart_axes){.title = title,
                                                        .x = CHART_TIME_LABEL,
                                                        .x_unit = UNIT_NUMBER,
                                                        .y = "tension",
                                                        .y_unit = UNIT_TENSION,
                                                        .x_low = -CHART_TIME_BEFORE_TOUCHDOWN_S,
                                                        .x_high = end_s,
                                                        .height_px = 140});
        for (unsigned k = c; k < MR_CHANNELS; k++) {
            const struct measured_channel *channel = &measured->channel[k];
            if (drawn[k] || channel->config.station_ft != station_ft)
                continue;
            drawn[k] = true;
            snprintf(name, sizeof name, "band %u", channel->config.band);
            draw_trace(&figure, name, (channel->config.band + 5u) % 6u, "marked",
                       make_trace(landing, channel, TRACE_OVER_TIME, -CHART_TIME_BEFORE_TOUCHDOWN_S,
                                  end_s));
        }
    }
    figure_end(&figure, NULL, "Tension against time at each station, unfiltered.");
}

/* Finds the gages of a band, sorted by station; returns their number. */
static size_t find_band_gages(const struct measured_landing *measured, unsigned band,
                              const struct measured_channel *gage[MR_GAGES])
{
    size_t count = 0;
    for (unsigned number = 1; number <= MR_GAGES; number++) {
        int c = measured_channel_index(measured, MR_KIND_TENSION, number);
        if (c < 0 || measured->channel[c].config.band != band ||
            isnan(measured->channel[c].baseline))
            continue;
        size_t at = count++;
        for (; at > 0 && gage[at - 1]->config.station_ft > measured->channel[c].config.station_ft;
             at--)
            gage[at] = gage[at - 1];
        gage[at] = &measured->channel[c];
    }
    return count;
}

/* Writes the largest fall and the largest rise of the tension along each band. */
static void write_tension_extremes(const struct report *report,
                                   const struct report_landing *landing, FILE *out)
{
    const struct measured_channel *gage[MR_GAGES];
    struct figure figure = {0};
    for (unsigned band = 1; band <= REPORT_BANDS_MAX; band++) {
        size_t count = find_band_gages(&landing->summary.measured, band, gage);
        double x[MR_GAGES], y[3][MR_GAGES], half[3][MR_GAGES];
        char title[CHART_LABEL_SIZE];
        static const char *const names[] = {"least", "most", "at the end"};
        if (count == 0)
            continue;
        if (!figure.out)
            figure = figure_begin(out, report->si, "change of tension along the bands", 2,
                                  FIGURE_RANGE_SHARED | FIGURE_RANGE_WITH_ZERO);
        snprintf(title, sizeof title, "Band %u", band);
        figure_begin_plot(&figure, &(struct chart_axes){.title = title,
                                                        .x = "station",
                                                        .x_unit = UNIT_STATION,
                                                        .y = "change",
                                                        .y_unit = UNIT_TENSION,
                                                        .x_high = RIG_RUNWAY_FT,
                                                        .height_px = 170});
        figure_add_shape(&figure, "mark", (double)NAN, (double)NAN, 0.0, 0.0, NULL);
        for (size_t i = 0; i < count; i++) {
            x[i] = (double)gage[i]->config.station_ft;
            y[0][i] = (gage[i]->low - gage[i]->baseline);
            y[1][i] = (gage[i]->high - gage[i]->baseline);
            y[2][i] = (gage[i]->end - gage[i]->baseline);
            half[0][i] = SUMMARY_HALF_WIDTH_95 * gage[i]->low_error;
            half[1][i] = SUMMARY_HALF_WIDTH_95 * gage[i]->high_error;
        }
        for (unsigned k = 0; k < 3; k++)
            figure_add_series(&figure,
                              &(struct chart_series){names[k], k, k < 2 ? "whiskers" : "marks", x,
                                                     y[k], k < 2 ? half[k] : NULL, count});
    }
    if (figure.out)
        figure_end(&figure, NULL,
                   "Change since the 0.5 s before the first switch opened: minimum and maximum, "
                   "with 95 %% intervals, and value at the end.");
}

static void write_bands(const struct report *report, const struct report_landing *landing,
                        FILE *out)
{
    struct answer *answer = answer_new(report->si);
    bands_to_answer(&landing->summary.bands, &landing->summary.measured, answer);
    bands_add_shunts(&landing->summary.bands, true, answer);
    report_write_answer(answer, out);
}

/* ---- transducers and gages ---- */

static void write_channels(const struct report *report, const struct report_landing *landing,
                           FILE *out)
{
    const struct measured_landing *measured = &landing->summary.measured;
    struct answer *answer = answer_new(report->si);
    if (measured->samples > 0) {
        summary_add_channels(measured, MR_KIND_DISPLACEMENT, "", answer);
        answer_add_sentence(
            answer, NULL,
            "Peaks are extremes of an %d ms moving mean; the end is the mean of the last %d ms. "
            "\xc2\xb1 is one standard error, which includes calibration and noise.",
            MEASURED_MEAN_BLOCKS, MEASURED_FINAL_MEAN_BLOCKS);
        summary_add_channels(measured, MR_KIND_TENSION, "", answer);
    }
    report_write_answer(answer, out);
}

/* ---- measured against simulated ---- */

static void write_comparison_text(FILE *out, const struct compare_figures *figures, bool si)
{
    const struct unit *length = unit_get(UNIT_DISPLACEMENT, si);
    struct compare_agreement agreement;
    char sentence[COMPARE_AGREEMENT_SIZE];
    fputs("<p class=\"say\">", out);
    if (figures->model_file[0]) {
        fputs("Simulation: ", out);
        html_write_text(out, figures->model_file);
        fputs(", ", out);
    }
    if (figures->seed_count > 1)
        fprintf(out, "%lld runways, ", (long long)figures->seed_count);
    if (!isnan(figures->solver_error_in))
        fprintf(out, "standard error (estimated by the solver) %.*f %s, ", si ? 2 : 4,
                figures->solver_error_in * length->factor, length->text);
    fprintf(out, "%zu of %u segments surveyed.</p>\n", figures->surveyed_segment_count,
            MR_SEGMENTS);
    compare_compute_agreement(figures, &agreement);
    compare_write_agreement(&agreement, si, sentence);
    fputs("<p class=\"say\"><strong>", out);
    html_write_text(out, sentence);
    fputs(".</strong></p>\n", out);
}

/* Draws every `step`-th sample from touchdown to the end of the simulation. */
static void draw_compared_signal(struct figure *figure, const struct compare_curves *curves,
                                 size_t samples, bool simulated)
{
    const double *value = simulated ? curves->simulated_in : curves->measured_in,
                 *error = simulated ? curves->simulated_error_in : curves->measured_error_in;
    double t_s[COMPARISON_POINTS + 1], y[COMPARISON_POINTS + 1], half[COMPARISON_POINTS + 1];
    size_t from = 0, to = samples, count = 0;
    while (from < to && curves->t_s[from] < 0.0)
        from++;
    while (to > from && isnan(curves->simulated_in[to - 1]))
        to--;
    size_t step = (to - from) / COMPARISON_POINTS + 1;
    for (size_t i = from; i < to; i += step) {
        t_s[count] = curves->t_s[i];
        y[count] = value[i];
        half[count++] = SUMMARY_HALF_WIDTH_95 * error[i];
    }
    figure_add_series(
        figure,
        &(struct chart_series){simulated ? "simulated with 95 % band" : "measured with 95 % band",
                               simulated, simulated ? "sim" : "line", t_s, y, half, count});
}

static void draw_comparison(const struct report_landing *landing, bool si, FILE *out)
{
    const struct measured_landing *measured = &landing->summary.measured;
    const struct unit *station = unit_get(UNIT_STATION, si);
    struct figure figure = figure_begin(out, si, "movement of the mat, measured and simulated", 2,
                                        FIGURE_RANGE_PER_PLOT);
    for (size_t i = 0; i < landing->simulation_count; i++) {
        const struct store_simulation *row = &landing->simulation[i];
        int c = measured_channel_index(measured, MR_KIND_DISPLACEMENT, (unsigned)row->number);
        double error_in = isnan(landing->simulation_summary.error_in)
                            ? row->peak_simulated_error_in
                            : landing->simulation_summary.error_in;
        char title[CHART_LABEL_SIZE];
        struct compare_curves curves;
        if (c < 0 || !measured->channel[c].raw || row->length == 0)
            continue;
        compare_fill_curves(measured, &landing->comparison->timing, &measured->channel[c], row,
                            error_in, &curves);
        snprintf(title, sizeof title, "Transducer %" PRId64 ": %.1f %s", row->number,
                 row->station_ft * station->factor, station->text);
        figure_begin_plot(&figure, &(struct chart_axes){.title = title,
                                                        .x = CHART_TIME_LABEL,
                                                        .x_unit = UNIT_NUMBER,
                                                        .y = "displacement",
                                                        .y_unit = UNIT_DISPLACEMENT,
                                                        .height_px = 150});
        for (int simulated = 0; simulated < 2; simulated++)
            draw_compared_signal(&figure, &curves, measured->samples, simulated);
        free(curves.storage);
    }
    figure_end(&figure, NULL, "Displacement against time.");
}

static void write_comparison(const struct report *report, const struct report_landing *landing,
                             FILE *out)
{
    struct answer *answer;
    if (!landing->comparison)
        return;
    write_comparison_text(out, landing->comparison, report->si);
    answer = answer_new(report->si);
    compare_add_channels(landing->comparison, answer);
    compare_add_zones(&landing->comparison->zones, answer);
    report_write_answer(answer, out);
    draw_comparison(landing, report->si, out);
}

/* ---- health ---- */

static void write_health(const struct report *report, const struct report_landing *landing,
                         FILE *out)
{
    struct store_backlog *backlog = NULL;
    size_t backlogs = 0;
    int64_t most = 0;
    struct answer *answer = answer_new(report->si);
    summary_add_health(&landing->summary, answer);
    store_backlogs_get(report->store, landing->summary.measured.landing.id, &backlog, &backlogs,
                       report->error);
    for (size_t i = 0; i < backlogs; i++)
        most = backlog[i].waiting > most ? backlog[i].waiting : most;
    if (backlogs)
        answer_add_sentence(
            answer, NULL, "The predictor delayed other work in %zu blocks, by at most %lld blocks.",
            backlogs, (long long)most);
    report_write_answer(answer, out);
    free(backlog);
}

/* ---- the parts, in the order of the page ---- */

const struct report_landing_section report_landing_sections[] = {
    {"Speed and deceleration", write_speed},
    {"Displacement against distance from the front wheel", write_movement_by_wheel_distance},
    {"Zone map", write_zone_map},
    {"Movement of the mat", write_movement},
    {"Predictions", write_predictions},
    {"Band tensions", write_tensions},
    {"Tension change along the bands", write_tension_extremes},
    {"Bands", write_bands},
    {"Transducers and gages", write_channels},
    {"Measured against simulated", write_comparison},
    {"Conditions, damage and pictures", report_write_landing_records},
    {"Record", write_facts},
    {"Health and losses", write_health},
    {NULL, NULL},
};
