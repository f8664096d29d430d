#include "host/analyse/film.h"

#include <math.h>
#include <stdlib.h>

#include "host/base/statistics.h"

#define PERIODS_MOST 1e9 /* of a gap, whatever a damaged time says */
/* steps on each side whose median is the period: half of them may be gaps */
#define AROUND       7u

/* Median of the steps from `from` to `to`. A gap of n periods is n steps, so a shorter one is taken
 * where there are two. */
static double median_step(const double *t_us, size_t from, size_t to)
{
    double step_us[2 * AROUND + 1];
    size_t count = 0;
    for (size_t i = from; i < to; i++)
        step_us[count++] = t_us[i + 1] - t_us[i];
    sort_numbers(step_us, count);
    return step_us[(count - 1) / 2];
}

void film_number(const double *t_us, size_t count, int64_t *number)
{
    if (count)
        number[0] = 1;
    for (size_t i = 1; i < count; i++) {
        size_t from = i - 1 > AROUND ? i - 1 - AROUND : 0;
        size_t to = i + AROUND < count - 1 ? i + AROUND : count - 1;
        int64_t periods =
            llround(fmin((t_us[i] - t_us[i - 1]) / median_step(t_us, from, to), PERIODS_MOST));
        number[i] = number[i - 1] + (periods > 1 ? periods : 1);
    }
}

static enum mr_status number_frames(struct film *film, const char *path, struct error *error)
{
    double *t_us = calloc(film->frames, sizeof *t_us);
    int64_t *number = calloc(film->frames, sizeof *number);
    enum mr_status status = t_us && number
                              ? MR_OK
                              : error_set(error, MR_FULL,
                                          "no memory: film of %s; close other programs", path);
    for (size_t i = 0; status == MR_OK && i < film->frames; i++)
        t_us[i] = film->frame[i].board_us;
    if (status == MR_OK)
        film_number(t_us, film->frames, number);
    for (size_t i = 0; status == MR_OK && i < film->frames; i++)
        film->frame[i].number = number[i];
    free(t_us);
    free(number);
    return status;
}

/* Pulses in order of their count; one whose time is not known, or not later than the one before, is
 * no frame. */
static void take_frame(struct film *film, const struct measured *measured,
                       const struct track *track, const struct store_film_frame *row)
{
    const struct film_frame *last = film->frames ? &film->frame[film->frames - 1] : NULL;
    if (isnan(row->board_us) || (last && row->board_us <= last->board_us))
        return;
    double t_s = (row->board_us - (double)measured->t0_us) / 1e6;
    struct film_frame *frame = &film->frame[film->frames++];
    *frame = (struct film_frame){.pulse = row->number,
                                 .board_us = row->board_us,
                                 .t_s = t_s,
                                 .station_ft = track_at(track, t_s)};
    frame->speed_ft_s.value = measured_speed_ft_s(measured, t_s, &frame->speed_ft_s.error);
}

enum mr_status film_load(struct store *store, const struct measured *measured, struct film *film,
                         struct error *error)
{
    struct store_film_frame *row = NULL;
    size_t count = 0;
    struct track track;
    *film = (struct film){.rate_hz = (double)NAN};
    enum mr_status status = store_film_frames(store, measured->landing.id, &row, &count, error);
    if (status != MR_OK || count == 0)
        return status;
    film->frame = calloc(count, sizeof *film->frame);
    if (!film->frame)
        status = error_set(error, MR_FULL, "no memory: film of %s; close other programs",
                           store_path(store));
    track_make(measured, &track);
    for (size_t i = 0; status == MR_OK && i < count; i++)
        take_frame(film, measured, &track, &row[i]);
    free(row);
    if (status == MR_OK && film->frames)
        status = number_frames(film, store_path(store), error);
    if (status == MR_OK && film->frames > 1) {
        const struct film_frame *last = &film->frame[film->frames - 1];
        film->rate_hz = (double)(last->number - 1) /
                        ((last->board_us - film->frame[0].board_us) / 1e6);
        film->missing = last->number - (int64_t)film->frames;
    }
    return status;
}

void film_free(struct film *film)
{
    free(film->frame);
}
