/* The board's clock compared with this computer's clock: the time of day of an event on the board,
 * with its uncertainty.
 *
 * A pair is a moment of the board and the time at which this computer received it. The time of
 * reception is later by a delay that is never negative, mostly small, and sometimes large. Over ten
 * minutes both clocks run at constant rates, so the true relation is a straight line below all
 * pairs:
 *
 *     host = offset + rate * board + delay,   delay >= 0
 *
 * The only assumption about the distribution of delays is that their density is constant near the
 * smallest delay. Then the pairs in a narrow strip above the line form a Poisson process of unknown
 * intensity. The prior is uniform in offset, rate and the logarithm of the intensity (the invariant
 * prior of a location and a scale). The posterior of the line (offset and rate) is
 *
 *     p(c, b) ~ (T - c)^-m   for every line c + b (t - mean t) below all pairs,
 *
 * where T is the top, at the mean time, of the strip that holds m pairs. It depends only on c, so c
 * is integrated numerically, and b uniformly between the two tangents to the lower convex hull.
 * Intervals are the 2.5 and 97.5 % quantiles; tests/host/test_timemap.c checks them with delays of
 * known distribution.
 *
 * The smallest delay cannot be separated from the offset: a link with a constant delay of a
 * millisecond makes every time of day a millisecond late, and no interval shows it. The known part
 * of the delay is subtracted beforehand (TIMEMAP_SERIAL_DELAY_US). Pure functions. */
#ifndef MATRIG_HOST_LINK_TIMEMAP_H
#define MATRIG_HOST_LINK_TIMEMAP_H

#include <stddef.h>
#include <stdint.h>

/* Number of newest pairs that are used; at one pair a second, ten minutes. Crystals keep their rate
 * to about 0.01 ppm for that long. */
#define TIMEMAP_PAIRS_MAX   600u
#define TIMEMAP_PAIRS_MIN   12u
#define TIMEMAP_GRID_POINTS 96u

/* Delay of a clock message on serial. It contains the time of a block's first trigger, is sent when
 * the block is complete, 970 us later, and takes at least 17 bytes of 5 us each. */
#define TIMEMAP_SERIAL_DELAY_US 1055

struct timemap {
    size_t pair_count; /* number of pairs ever added */
    struct timemap_pair {
        double board_us;
        int64_t host_us;       /* Unix time */
    } pair[TIMEMAP_PAIRS_MAX]; /* ring: pair n is at index n modulo TIMEMAP_PAIRS_MAX */
};

/* A value with its 95 % interval, both in the unit of the field's name. */
struct timemap_value {
    double value;      /* middle of the interval */
    double half_width; /* half the width of the interval */
};

enum timemap_refusal {
    TIMEMAP_OK,
    TIMEMAP_TOO_FEW_PAIRS,
    /* The time stamps are not times of day: the recording was made without a clock. */
    TIMEMAP_UNDATED,
    /* The board's time does not run at the rate of this computer's clock: the board is emulated, or
     * a file is read. */
    TIMEMAP_WRONG_RATE,
    /* the delays vary too much, or this computer's clock was set during the recording */
    TIMEMAP_UNCERTAIN,
};

struct timemap_fit {
    /* If it is not TIMEMAP_OK, the fields below are not valid, except pair_count and, for
     * TIMEMAP_WRONG_RATE, rate_ppm. */
    enum timemap_refusal refusal;
    size_t pair_count;
    double from_us, to_us;         /* board time of the first and the last time pair */
    double spread_us;              /* median delay minus the smallest delay */
    struct timemap_value rate_ppm; /* how much faster the board's clock runs than this computer's */

    /* The posterior distribution. Times in s and offsets in us are relative to board_origin_us and
     * host_origin_us. */
    double board_origin_us, mean_time_s;
    int64_t host_origin_us;
    double offset_us[TIMEMAP_GRID_POINTS], low_ppm[TIMEMAP_GRID_POINTS],
        high_ppm[TIMEMAP_GRID_POINTS], weight[TIMEMAP_GRID_POINTS];
};

/* Adds a pair. A pair whose board time is not later than the last one is ignored. */
void timemap_add(struct timemap *map, double board_us, int64_t host_us);
/* Fits the line. `tolerance_ppm`: largest possible rate error of both clocks together; if the rate
 * error is certainly larger, the result is TIMEMAP_WRONG_RATE. */
void timemap_fit(const struct timemap *map, double tolerance_ppm, struct timemap_fit *fit);
/* Converts a board time to the time of day, Unix microseconds. The interval is wider for times
 * farther from the pairs. */
struct timemap_value timemap_to_host_us(const struct timemap_fit *fit, double board_us);
/* Returns the meaning of a refusal and what to do, as text. Static storage. */
const char *timemap_refusal_text(unsigned refusal);

#endif
