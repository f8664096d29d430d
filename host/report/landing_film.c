/* Frames of the film by gear position, with their pictures where there are any. */
#include <math.h>

#include "host/report/film_pictures.h"
#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

#define EVERY_FT 10.0
#define STATIONS 13 /* 0 to 120 ft */

/* The frame nearest to a station, of those that have a picture when there are pictures at all;
 * NULL: none within half a step. */
static const struct film_frame *frame_at(const struct film *film,
                                         const struct film_pictures *pictures, double station_ft)
{
    const struct film_frame *best = NULL;
    double nearest_ft = 0.5 * EVERY_FT;
    for (size_t i = 0; i < film->frames; i++) {
        double away_ft = fabs(film->frame[i].station_ft.value - station_ft);
        if (!(away_ft < nearest_ft) ||
            (pictures->count && !film_pictures_find(pictures, film->frame[i].number)))
            continue;
        nearest_ft = away_ft;
        best = &film->frame[i];
    }
    return best;
}

static void table(FILE *out, const struct film *film, const struct film_pictures *pictures, bool si)
{
    char station[40], speed[40];
    snprintf(station, sizeof station, "gear at, %s", unit_of(UNIT_STATION, si)->text);
    snprintf(speed, sizeof speed, "speed, %s", unit_of(UNIT_SPEED, si)->text);
    html_table(out,
               (const char *const[]){"frame", "time since touchdown, s", station, speed, NULL});
    for (int i = 0; i < STATIONS; i++) {
        const struct film_frame *frame = frame_at(film, pictures, EVERY_FT * i);
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

static enum mr_status pictures_write(FILE *out, const struct film *film,
                                     const struct film_pictures *pictures, bool si,
                                     struct error *error)
{
    enum mr_status status = MR_OK;
    fputs("<div class=\"film\">\n", out);
    for (int i = 0; i < STATIONS && status == MR_OK; i++) {
        const struct film_frame *frame = frame_at(film, pictures, EVERY_FT * i);
        if (!frame)
            continue;
        fputs("<figure>", out);
        status = film_picture_write(film_pictures_find(pictures, frame->number), out, error);
        fprintf(out, "<figcaption>frame %lld: gear at %.2f %s, %.3f s</figcaption></figure>\n",
                (long long)frame->number,
                frame->station_ft.value * unit_of(UNIT_STATION, si)->factor,
                unit_of(UNIT_STATION, si)->text, frame->t_s);
    }
    fputs("</div>\n", out);
    return status;
}

enum mr_status landing_film(const struct report *report, const struct report_landing *landing,
                            FILE *out, struct error *error)
{
    const struct film *film = &landing->summary.film;
    struct film_pictures pictures = {0};
    enum mr_status status = MR_OK;
    if (film->frames == 0)
        return MR_OK;
    if (report->film)
        status = film_pictures_list(report->film, landing->summary.measured.landing.id,
                                    report->landings == 1 && !report->folder, &pictures, error);
    fprintf(out,
            "<p>%zu frames, %.2f a second, %lld missing; numbered from 1, the first pulse of the "
            "landing. Below: the frame nearest to every "
            "tenth foot of the gear's way%s; &plusmn; is one standard error.</p>\n",
            film->frames, film->rate_hz, (long long)film->missing,
            pictures.count ? ", of those that have a picture" : "");
    table(out, film, &pictures, report->si);
    if (status == MR_OK && pictures.count)
        status = pictures_write(out, film, &pictures, report->si, error);
    film_pictures_free(&pictures);
    return status;
}
