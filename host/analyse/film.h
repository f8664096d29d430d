/* The film of a landing: which frame each pulse of the camera was, and where the gear stood on it.
 *
 * Frames are numbered from 1, the first pulse of the landing. A pulse that is not there - the
 * camera gave none, or it was lost with every link - leaves a gap in time: the next frame's number
 * is as much greater as mean periods fit into the gap, the period taken from the steps around it,
 * since a camera may run up or drift. */
#ifndef MATRIG_HOST_ANALYSE_FILM_H
#define MATRIG_HOST_ANALYSE_FILM_H

#include "host/analyse/track.h"

struct film_frame {
    int64_t number;
    int64_t pulse; /* the board's own count of pulses */
    double board_us;
    double t_s;                    /* as measured.h counts it */
    struct mr_estimate station_ft; /* of the lead wheel, by its track; NaN: not known */
    struct mr_estimate speed_ft_s;
};

struct film {
    struct film_frame *frame;
    size_t frames;
    double rate_hz;  /* NaN: fewer than two frames */
    int64_t missing; /* frames without a pulse between the first and the last */
};

/* The caller releases it with film_free, also after an error. A landing without a camera has no
 * frames. */
enum mr_status film_load(struct store *store, const struct measured *measured, struct film *film,
                         struct error *error);
void film_free(struct film *film);

/* Frame numbers from pulse times that rise, microseconds. */
void film_number(const double *t_us, size_t count, int64_t *number);

#endif
