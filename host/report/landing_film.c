/* Frames of the film by gear position. */
#include <math.h>

#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

#define EVERY_FT 10.0
#define STATIONS 13 /* 0 to 120 ft */

/* The frame nearest to a station; NULL: none within half a step. */
static const struct film_frame *frame_at(const struct film *film, double station_ft)
{
    const struct film_frame *best = NULL;
    double nearest_ft = 0.5 * EVERY_FT;
    for (size_t i = 0; i < film->frames; i++) {
        double away_ft = fabs(film->frame[i].station_ft.value - station_ft);
        if (!(away_ft < nearest_ft))
            continue;
        nearest_ft = away_ft;
        best = &film->frame[i];
    }
    return best;
}

static void table(FILE *out, const struct film *film, bool si)
{
    char station[40], speed[40];
    snprintf(station, sizeof station, "gear at, %s", unit_of(UNIT_STATION, si)->text);
    snprintf(speed, sizeof speed, "speed, %s", unit_of(UNIT_SPEED, si)->text);
    html_table(out,
               (const char *const[]){"frame", "time since touchdown, s", station, speed, NULL});
    for (int i = 0; i < STATIONS; i++) {
        const struct film_frame *frame = frame_at(film, EVERY_FT * i);
        if (!frame)
            continue;
        fputs("<tr>", out);
        html_cell(out, "%lld", (long long)frame->number);
        html_number(out, frame->t_s, 4);
        html_estimate(out, frame->station_ft.value * unit_of(UNIT_STATION, si)->factor,
                      frame->station_ft.error * unit_of(UNIT_STATION, si)->factor, 3);
        html_estimate(out, frame->speed_ft_s.value * unit_of(UNIT_SPEED, si)->factor,
                      frame->speed_ft_s.error * unit_of(UNIT_SPEED, si)->factor, 3);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
}

enum mr_status landing_film(const struct report *report, const struct report_landing *landing,
                            FILE *out, struct error *error)
{
    const struct film *film = &landing->summary.film;
    (void)error;
    if (film->frames == 0)
        return MR_OK;
    fprintf(out,
            "<p>%zu frames, %.2f a second, %lld missing; numbered from 1, the first pulse of the "
            "landing. Below: the frame nearest to every tenth foot of the gear's way; &plusmn; is "
            "one standard error.</p>\n",
            film->frames, film->rate_hz, (long long)film->missing);
    table(out, film, report->si);
    return MR_OK;
}
