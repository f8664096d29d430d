#include "host/compare/zones.h"

#include <math.h>
#include <string.h>

#define STEP_S     0.02
#define REST_S     0.3 /* after the stop; mats have come to rest by then */
#define MAT_FT     ((double)MR_MAT_LENGTH_FT)
#define SEGMENT_FT ((double)MR_SEGMENT_LENGTH_FT)

struct compare_zone compare_closed_run(const float *remaining_in, double wheel_ft)
{
    struct compare_zone best = {.known = true};
    for (unsigned s = 0; s < MR_SEGMENTS; s++) {
        unsigned end = s;
        while (end < MR_SEGMENTS && remaining_in[end] < MR_CLOSURE_OPEN_IN)
            end++;
        double start_ft = fmax(s * SEGMENT_FT, isnan(wheel_ft) ? 0.0 : wheel_ft),
               end_ft = end * SEGMENT_FT;
        double mats = (end_ft - start_ft) / MAT_FT;
        if (end > s && mats > best.mats + 0.5) {
            best.mats = mats;
            best.start_ft = start_ft;
            best.end_ft = end_ft;
            best.start_error_ft = best.end_error_ft = SEGMENT_FT / sqrt(12.0);
        }
        if (end > s)
            s = end;
    }
    return best;
}

struct compare_overlap compare_overlap_of(const struct compare_zone *a,
                                          const struct compare_zone *b)
{
    struct compare_overlap overlap = {
        .known = a->known && b->known, .start_ft = (double)NAN, .end_ft = (double)NAN};
    if (!overlap.known)
        return overlap;
    if (a->mats > 0.0 && b->mats > 0.0) {
        overlap.common_mats =
            fmax(0.0, (fmin(a->end_ft, b->end_ft) - fmax(a->start_ft, b->start_ft)) / MAT_FT);
        overlap.start_ft = a->start_ft - b->start_ft;
        overlap.end_ft = a->end_ft - b->end_ft;
    }
    double of_a = a->mats > 0.0 ? (a->end_ft - a->start_ft) / MAT_FT : 0.0,
           of_b = b->mats > 0.0 ? (b->end_ft - b->start_ft) / MAT_FT : 0.0;
    overlap.all_mats = of_a + of_b - overlap.common_mats;
    overlap.share = overlap.all_mats > 0.0 ? overlap.common_mats / overlap.all_mats : 1.0;
    return overlap;
}

/* The board's newest statement at a time. */
static struct compare_zone board_zone(const struct measured *measured,
                                      const struct compare_said *said, double t_s)
{
    struct compare_zone zone = {.known = false};
    const struct store_zone *row = NULL;
    for (size_t i = 0; i < said->zones && zones_time_s(measured, &said->zone[i]) <= t_s; i++)
        row = &said->zone[i];
    if (!row)
        return zone;
    zone = (struct compare_zone){true,        (double)row->mats, row->start_ft,
                                 row->end_ft, (double)NAN,       (double)NAN};
    for (size_t i = 0; i < said->predictions; i++) {
        if (said->prediction[i].block != row->block)
            continue;
        zone.start_error_ft = said->prediction[i].start_error_ft;
        zone.end_error_ft = said->prediction[i].end_error_ft;
    }
    return zone;
}

/* Where blocks were lost nothing moved the mats that the survey found: its openings alone are no
 * zone of that moment. */
static bool has_movement(const struct measured *measured, size_t sample)
{
    unsigned readings = 0;
    for (unsigned c = 0; c < MR_TRANSDUCERS; c++) {
        const struct measured_channel *channel = &measured->channel[c];
        readings += channel->config.kind == MR_KIND_DISPLACEMENT &&
                    !isnan(measured_smooth(measured, channel, sample, MEASURED_WINDOW / 2));
    }
    return readings >= 2;
}

static struct compare_zone measured_zone(const struct measured *measured,
                                         const struct zones_closure *survey, double t_s)
{
    float remaining_in[MR_SEGMENTS];
    struct mr_closure_zone run;
    double sample = (t_s - measured_time_s(measured, 0)) * 1000.0;
    if (survey->surveyed == 0 || !(sample >= 0.0 && sample < (double)measured->samples) ||
        !has_movement(measured, (size_t)sample))
        return (struct compare_zone){.known = false};
    zones_closed(measured, survey, (size_t)sample, remaining_in, &run);
    const double error_ft = SEGMENT_FT / sqrt(12.0);
    return (struct compare_zone){
        true, (double)run.mats, (double)run.start_ft, (double)run.end_ft, error_ft, error_ft};
}

static struct compare_zone simulated_zone(const struct compare_segments *segments, double t_s,
                                          double wheel_ft)
{
    double row = floor(t_s / segments->dt_s + 0.5);
    if (segments->rows == 0 || !(row >= 0.0))
        return (struct compare_zone){.known = false};
    size_t at = row < (double)segments->rows ? (size_t)row : segments->rows - 1;
    return compare_closed_run(segments->remaining_in + at * MR_SEGMENTS, wheel_ft);
}

struct input {
    const struct measured *measured;
    const struct zones_closure *survey;
    const struct compare_segments *segments;
    const struct compare_said *said;
};

static void look(const struct input *in, const char *what, double t_s,
                 struct compare_zone_moment *moment)
{
    moment->what = what;
    moment->t_s = t_s;
    moment->wheel_ft = measured_station_ft(in->measured, t_s);
    moment->zone[COMPARE_MEASURED] = measured_zone(in->measured, in->survey, t_s);
    moment->zone[COMPARE_BOARD] = board_zone(in->measured, in->said, t_s);
    moment->zone[COMPARE_SIMULATED] = simulated_zone(in->segments, t_s, moment->wheel_ft);
    moment->board = compare_overlap_of(&moment->zone[COMPARE_MEASURED],
                                       &moment->zone[COMPARE_BOARD]);
    moment->simulated = compare_overlap_of(&moment->zone[COMPARE_MEASURED],
                                           &moment->zone[COMPARE_SIMULATED]);
}

/* While the gear moves: when a source's zone is longest, the measured one's when there is one, else
 * the board's, else the simulated. */
static double longest_s(const struct input *in, double stop_s, enum compare_zone_source *source)
{
    double most[COMPARE_SOURCES] = {0.0}, at_s[COMPARE_SOURCES] = {0.0};
    for (double t_s = 0.0; t_s < stop_s; t_s += STEP_S) {
        struct compare_zone_moment moment;
        look(in, "", t_s, &moment);
        for (int k = 0; k < COMPARE_SOURCES; k++) {
            if (!moment.zone[k].known || moment.zone[k].mats <= most[k])
                continue;
            most[k] = moment.zone[k].mats;
            at_s[k] = t_s;
        }
    }
    for (int k = 0; k < COMPARE_SOURCES; k++) {
        *source = (enum compare_zone_source)k;
        if (most[k] > 0.0)
            return at_s[k];
    }
    return (double)NAN;
}

void compare_zones(const struct measured *measured, const struct zones_closure *survey,
                   const struct compare_said *said, const struct compare_segments *segments,
                   struct compare_zones *zones)
{
    static const char *const longest[] = {"longest measured", "longest said", "longest simulated"};
    const struct input in = {measured, survey, segments, said};
    double stop_s = measured->summary.stop_t_s.value,
           end_s = measured_time_s(measured, measured->samples - 1);
    enum compare_zone_source source;
    double t_s = longest_s(&in, stop_s, &source);
    zones->count = 0;
    if (!isnan(t_s))
        look(&in, longest[source], t_s, &zones->moment[zones->count++]);
    look(&in, "at rest", fmin(stop_s + REST_S, end_s), &zones->moment[zones->count++]);
}

const struct compare_zone_moment *compare_moment_of(const struct compare_zones *zones, bool rest)
{
    for (size_t i = 0; i < zones->count; i++) {
        if ((strcmp(zones->moment[i].what, "at rest") == 0) == rest)
            return &zones->moment[i];
    }
    return NULL;
}
