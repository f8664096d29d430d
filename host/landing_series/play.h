/* Play: one runway of a series, from its seed through all its landings. */
#ifndef MATRIG_HOST_LANDING_SERIES_PLAY_H
#define MATRIG_HOST_LANDING_SERIES_PLAY_H

#include "host/landing_series/series.h"
#include "host/sim/scene/result.h"

/* What one landing did. Movements and stations: of this landing; total: since the runway was
 * laid. */
struct series_outcome {
    double stop_ft, deceleration_ft_s2; /* mean */
    bool asked_planar;                  /* the planar engine ran */
    /* largest lift of a joint by the chain's compression, in weights of a mat */
    double skip_ratio;
    double ms_chain, ms_planar;
    double mats_chain, mats_planar; /* integrated, mean over time */
    double peak_in;
    double movement_in[SERIES_STATIONS_MAX], total_in[SERIES_STATIONS_MAX];
    double reach_ft; /* farthest joint beyond the stop that moved by 0.001 in */
    int zone_mats;
    /* longest stretch where any ten joints have closed by two thirds; the last landing's wave is in
     * it */
    double zone_from_ft, zone_to_ft;
    double push_lb, pull_lb; /* largest in a joint */
    int tears;               /* joints pulled beyond their strength */
    int waves;
    double wave_ft[SERIES_WAVES_MAX]; /* stations, highest first */
    double rise_in;                   /* highest */
    double crest_deg, sag_deg;
    int parted; /* joints that came apart by turning, with parting */
    bool unhinged, buckled;
    /* station: where the wheel first met the wave; else, when it stopped before it, its crest */
    double buckle_ft;
    int overruns;
    /* all such stations, the wheel having left the wave in between */
    double overrun_ft[SIM_OVERRUNS_MAX];
    /* stretches of mats that rose so far, between mats that did not, or, with parting, that came
     * apart; at least 1 when buckled */
    int failures;
    /* stations, downfield: where the wheel first met it, else its crest */
    double failure_ft[SERIES_FAILURES_MAX];
    /* of the wheel's mat: where a rise of buckle_in came first; only when crest_ft > 0 */
    int crest_ahead_mats;
    /* station of it; 0: nothing rose so far while the wheel was on the runway */
    double crest_ft;
    /* Bands: change of tension from before the landing to its least and its most, mean over the
     * segments that the aircraft passed; how many segments went slack. 0 without bands. */
    double band_ahead_lb, band_behind_lb;
    int band_slack;
};

struct series_run {
    uint64_t seed;
    size_t played;                   /* landings; a buckled runway takes no more */
    int buckled;                     /* landing, from 1; 0: none */
    double buckle_ft;                /* station */
    struct series_outcome *outcomes; /* landing_count */
    double ms;
    struct error error; /* why this runway could not be played to its end */
};

/* Play the runway of a seed. The result depends on series and seed alone. `all`: integrate every
 * mat (for comparison). */
void series_play(const struct landing_series *series, uint64_t seed, bool all,
                 struct series_run *run);
void series_run_free(struct series_run *run);

/* Play all seeds on `jobs` threads. `progress` is called after each, one call at a time; NULL: not.
 * MR_FULL. A runway that fails keeps its error; the others are played. */
enum mr_status series_ensemble(const struct landing_series *series, int jobs, bool all,
                               void (*progress)(void *ctx, size_t done, size_t of), void *ctx,
                               struct series_run *runs, struct error *error);

#endif
