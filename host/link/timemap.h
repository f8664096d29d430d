/* The board's clock against this computer's: when, in time of day, did something happen on the
 * board, and how well is that known?
 *
 * A pair is a moment of the board and the time at which this computer learnt of it: later by a
 * delay that is never negative and mostly small, sometimes large. Over ten minutes both clocks run
 * evenly, so the truth is a straight line below all pairs:
 *
 *     host = offset + rate * board + delay,   delay >= 0
 *
 * Nothing is assumed of how delays are distributed but that next to the least one they are as dense
 * as a little above it. Then the pairs just above the line are a Poisson process of unknown
 * intensity in the strip there, and the line's posterior (offset and rate evenly distributed
 * beforehand, intensity by its logarithm: the invariant prior of a location and a scale) is
 *
 *     p(c, b) ~ (T - c)^-m  for every line c + b (t - mean t) below all pairs,
 *
 * T the top of the strip that holds m pairs, over the mean time. It depends on c alone, so c is
 * integrated numerically and b evenly between the two tangents to the lower convex hull. Intervals
 * are its 2.5 to 97.5 %: tests/host/test_timemap.c holds them against delays of known distribution.
 *
 * The least delay itself cannot be told from the offset: a link that always takes a millisecond
 * makes every time of day a millisecond late, within no interval. What is known of it is taken off
 * before (timemap_serial_us). Pure. */
#ifndef MATRIG_HOST_LINK_TIMEMAP_H
#define MATRIG_HOST_LINK_TIMEMAP_H

#include <stddef.h>
#include <stdint.h>

/* the newest; at one a second ten minutes: crystals keep their rate to 0.01 ppm or so that long */
#define TIMEMAP_PAIRS 600u
#define TIMEMAP_LEAST 12u
#define TIMEMAP_GRID  96u

/* A clock message on serial tells of a block's first trigger. It is sent when the block is
 * complete, 970 us later, and takes 17 bytes of 5 us at least. */
#define TIMEMAP_SERIAL_US 1055

struct timemap {
    size_t count; /* of pairs ever added */
    struct timemap_pair {
        double board_us;
        int64_t host_us;   /* Unix */
    } pair[TIMEMAP_PAIRS]; /* by count modulo their number */
};

/* A value with its 95 % interval, both in the unit of the name that holds it. */
struct timemap_value {
    double value; /* middle of the interval */
    double half;  /* half its width */
};

enum timemap_refusal {
    TIMEMAP_GOOD,
    TIMEMAP_TOO_FEW, /* pairs */
    /* the stamps are no times of day: a recording that was made without a clock */
    TIMEMAP_NO_DATE,
    /* the board's time does not pass as fast as this computer's: it is emulated, or a file is
     * read */
    TIMEMAP_OTHER_PACE,
    TIMEMAP_UNCERTAIN, /* the delays are too uneven, or this computer's clock was set meanwhile */
};

struct timemap_fit {
    /* of all below but pairs, unless TIMEMAP_GOOD; TIMEMAP_OTHER_PACE knows fast_ppm */
    enum timemap_refusal refusal;
    size_t pairs;
    double from_us, to_us;         /* board time of the first and last */
    double spread_us;              /* median delay beyond the least */
    struct timemap_value fast_ppm; /* the board's clock runs so much faster than this computer's */

    /* The posterior; times in s and offsets in us since these. */
    double board0_us, mean_s;
    int64_t host0_us;
    double c_us[TIMEMAP_GRID], low_ppm[TIMEMAP_GRID], high_ppm[TIMEMAP_GRID], weight[TIMEMAP_GRID];
};

/* A pair; one that is not later on the board than the last is passed over. */
void timemap_add(struct timemap *map, double board_us, int64_t host_us);
/* `tolerance_ppm`: how far both clocks together may be off; beyond it, for certain, the pace is
 * another. */
void timemap_fit(const struct timemap *map, double tolerance_ppm, struct timemap_fit *fit);
/* Time of day, Unix microseconds, of a moment of the board. Beyond the pairs its interval grows. */
struct timemap_value timemap_host_us(const struct timemap_fit *fit, double board_us);
/* What a refusal means, with what to do; static storage. */
const char *timemap_refusal_text(unsigned refusal);

#endif
