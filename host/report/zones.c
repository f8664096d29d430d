/* Sections of a landing: the zone map, and what the board predicted. */
#include <math.h>
#include <stdlib.h>

#include "common/predictor.h"
#include "host/base/xmalloc.h"
#include "host/report/chart.h"
#include "host/report/report.h"

#define PATH_POINTS 200
#define STATEMENT_S 0.05

/* ---- the zone map ---- */

#define LOOK_BLOCKS  20 /* between looks at the closure */
#define AFTER_STOP_S 0.8

/* A segment that is closed from one look to the next becomes a rectangle; what the wheel has not
 * reached yet is drawn stronger than what is behind it. */
static void draw_closed(struct figure *figure, const struct report_landing *landing,
                        unsigned segment, double from_s, double to_s, double station)
{
    double start_ft = (double)MR_SEGMENT_LENGTH_FT * segment,
           end_ft = start_ft + (double)MR_SEGMENT_LENGTH_FT;
    double passed_s = measured_reach_s(&landing->summary.measured, end_ft);
    if (measured_station_ft(&landing->summary.measured, from_s) > end_ft)
        passed_s = from_s;
    passed_s = isnan(passed_s) ? to_s : fmin(to_s, fmax(from_s, passed_s));
    if (passed_s > from_s)
        figure_shape(figure, "closed", station * start_ft, station * end_ft, from_s, passed_s,
                     NULL);
    if (to_s > passed_s)
        figure_shape(figure, "behind", station * start_ft, station * end_ft, passed_s, to_s, NULL);
}

static void draw_closure(struct figure *figure, const struct report_landing *landing,
                         double station, double last_s)
{
    const struct measured *measured = &landing->summary.measured;
    double since_s[MR_SEGMENTS], t_s = 0.0;
    for (unsigned s = 0; s < MR_SEGMENTS; s++)
        since_s[s] = (double)NAN;
    for (size_t i = 0; i < measured->samples; i += LOOK_BLOCKS) {
        float remaining_in[MR_SEGMENTS];
        struct mr_closure_zone zone;
        t_s = measured_time_s(measured, i);
        if (t_s < -0.2 || t_s > last_s)
            continue;
        zones_closed(measured, &landing->survey, i, remaining_in, &zone);
        for (unsigned s = 0; s < MR_SEGMENTS; s++) {
            bool closed = remaining_in[s] < MR_CLOSURE_OPEN_IN;
            if (closed && isnan(since_s[s])) {
                since_s[s] = t_s;
            } else if (!closed && !isnan(since_s[s])) {
                draw_closed(figure, landing, s, since_s[s], t_s, station);
                since_s[s] = (double)NAN;
            }
        }
    }
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        if (!isnan(since_s[s]))
            draw_closed(figure, landing, s, since_s[s], fmin(t_s, last_s), station);
    }
}

static void draw_warnings(struct figure *figure, const struct report_landing *landing,
                          double station)
{
    const struct measured *measured = &landing->summary.measured;
    const struct zones *zones = &landing->summary.zones;
    const struct zone_warning *warning = &zones->warning;
    char text[100], doubt[ZONES_HEARD_TEXT];
    for (size_t i = 0; i < zones->count; i++) {
        const struct store_zone *row = &zones->row[i];
        double t_s = zones_time_s(measured, row);
        double until_s = i + 1 < zones->count ? zones_time_s(measured, row + 1) : t_s + STATEMENT_S;
        if (row->warning == 1)
            figure_shape(figure, "warned", station * row->start_ft, station * row->end_ft, t_s,
                         fmin(until_s, t_s + 0.1), NULL);
    }
    if (!warning->warned)
        return;
    double t_s = fmax(warning->t_s, -0.1), wheel_ft = measured_station_ft(measured, warning->t_s);
    const char *heard = zones_earlier_text(zones, doubt) ? " that was heard" : "";
    if (warning->reached)
        snprintf(text, sizeof text, "first warning%s: %lld mats, %.2f s before the wheel", heard,
                 (long long)warning->mats, warning->true_lead_s);
    else
        snprintf(text, sizeof text, "first warning%s: %lld mats%s", heard, (long long)warning->mats,
                 warning->path_known ? "; the wheel stops before" : "");
    figure_shape(figure, "lead", station * (isnan(wheel_ft) ? warning->start_ft : wheel_ft),
                 station * warning->end_ft, t_s, t_s, text);
}

enum mr_status report_zone_map(const struct report *report, const struct report_landing *landing,
                               FILE *out, struct error *error)
{
    static const char *const keys[] = {"closed", "closed segments ahead of it",
                                       "behind", "behind it",
                                       "warned", "zone warned of",
                                       "sensor", "transducers",
                                       NULL};
    const struct measured *measured = &landing->summary.measured;
    const double station = unit_of(UNIT_STATION, report->si)->factor,
                 last_s = measured->summary.stop_t_s.value + AFTER_STOP_S;
    double x[PATH_POINTS + 1], t_s[PATH_POINTS + 1], gate_ft[MR_GATES_MAX], gate_s[MR_GATES_MAX];
    char label[CHART_LABEL];
    size_t gates = 0;
    (void)error;
    if (!report_is_fitted(landing))
        return MR_OK;
    struct figure figure = figure_begin(
        out, "zone map: closed segments, wheel and warning over station and time", 1, FIGURE_EACH);
    figure_plot(&figure,
                &(struct chart_axes){.x = chart_label(label, "station", UNIT_STATION, report->si),
                                     .y = CHART_TIME,
                                     .x_high = CHART_RUNWAY_FT * station,
                                     .y_low = -0.2,
                                     .y_high = last_s,
                                     .height_px = 340});
    draw_closure(&figure, landing, station, last_s);
    draw_warnings(&figure, landing, station);
    for (size_t i = 0; i <= PATH_POINTS; i++) {
        t_s[i] = last_s * (double)i / PATH_POINTS;
        x[i] = station * measured_station_ft(measured, t_s[i]);
    }
    figure_series(&figure, &(struct chart_series){"wheel, and switches it opened", 0, "line", x,
                                                  t_s, NULL, PATH_POINTS + 1});
    for (size_t i = 0; i < measured->gates; i++) {
        gate_ft[gates] = station * measured->gate[i].station_ft;
        gate_s[gates] = measured->gate[i].t_s;
        gates += measured->gate[i].station_ft >= 0.0;
    }
    figure_series(&figure, &(struct chart_series){NULL, 0, "points", gate_ft, gate_s, NULL, gates});
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        double at = station * (double)measured->channel[c].config.station_ft;
        if (measured->channel[c].config.kind == MR_KIND_DISPLACEMENT)
            figure_shape(&figure, "sensor", at, at, (double)NAN, (double)NAN, NULL);
    }
    figure_end(&figure, keys,
               "Closed segments are found here from survey and transducers, the zone warned of is "
               "what the board reported.");
    return MR_OK;
}

/* ---- the predictor ---- */

/* Statements that say the same, in a row, are one rectangle. */
static void draw_reported(struct figure *figure, const struct zones *zones,
                          const struct measured *measured)
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
                                                     : t_s + STATEMENT_S;
            to_s = fmin(until_s, t_s + 2.0 * STATEMENT_S);
        }
        if (row->mats > 0)
            figure_shape(figure, row->warning == 1 ? "warned" : "reported",
                         fmax(from_s, -CHART_BEFORE_S), to_s, 0.0, (double)row->mats, NULL);
    }
}

static void draw_mats(struct figure *figure, const struct report_landing *landing,
                      struct chart_axes axes)
{
    const struct zones *zones = &landing->summary.zones;
    const struct measured *measured = &landing->summary.measured;
    double *t_s = xmalloc(2 * (landing->predictions + 1) * sizeof *t_s),
           *mats = t_s + landing->predictions + 1;
    size_t count = 0;
    axes.x = CHART_TIME;
    axes.y = "mats in the zone";
    axes.y_high = 60.0;
    axes.height_px = 150;
    for (size_t i = 0; i < zones->count; i++)
        axes.y_high = fmax(axes.y_high, 1.05 * (double)zones->row[i].mats);
    figure_plot(figure, &axes);
    draw_reported(figure, zones, measured);
    figure_shape(figure, "mark", (double)NAN, (double)NAN, MR_PREDICTOR_WARNING_MATS,
                 MR_PREDICTOR_WARNING_MATS, NULL);
    figure_shape(figure, "mark", (double)NAN, (double)NAN, MR_PREDICTOR_ADVISORY_MATS,
                 MR_PREDICTOR_ADVISORY_MATS, NULL);
    for (size_t i = 0; i < landing->predictions; i++) {
        t_s[count] = measured_block_s(measured, landing->prediction[i].block);
        mats[count] = (double)landing->prediction[i].coming_mats;
        count += landing->prediction[i].coming_mats > 0;
    }
    figure_series(figure, &(struct chart_series){"longest zone that it saw coming", 2, "dots", t_s,
                                                 mats, NULL, count});
    free(t_s);
}

enum mr_status report_predictions(const struct report *report, const struct report_landing *landing,
                                  FILE *out, struct error *error)
{
    static const char *const keys[] = {
        "warned", "closed zone ahead, warning", "reported", "the same, no warning",
        "mark",   "limits: 30 and 50 mats",     NULL};
    const struct measured *measured = &landing->summary.measured;
    const struct chart_axes axes = {.x_low = -CHART_BEFORE_S,
                                    .x_high = measured->summary.stop_t_s.value + CHART_SETTLED_S};
    struct answer *answer = answer_new(report->si);
    (void)error;
    summary_zone_answer(&landing->summary, answer);
    report_answer(answer, out);
    if (measured->fit_status != MR_OK || landing->summary.zones.count == 0)
        return MR_OK;
    struct figure figure = figure_begin(out, "zone that the board reported, against time", 1,
                                        FIGURE_EACH);
    draw_mats(&figure, landing, axes);
    figure_end(&figure, keys, "Every statement of the board.");
    return MR_OK;
}
