/* Landing series: one runway, landings on it, and an ensemble of runways drawn from seeds.
 * README.md.
 *
 * The file's own quantities have their units in their names; scene keys are host/sim/README.md's
 * (ft, lb, s, slug). Stations are feet from the runway's upfield edge. Mats 1..N, joints and nodes
 * 1..N+1; in arrays by joint [0] is joint 1. One owner: series_load allocates, series_free
 * releases. A loaded series is only read: any number of threads may play runways of it at
 * once. */
#ifndef MATRIG_HOST_LANDING_SERIES_SERIES_H
#define MATRIG_HOST_LANDING_SERIES_SERIES_H

#include <jansson.h>
#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"
#include "host/sim/scene/scene.h"

#define SERIES_LANDINGS_MAX 200
#define SERIES_SEEDS_MAX    10000
#define SERIES_PROFILE_MAX  16
#define SERIES_STATIONS_MAX 64
#define SERIES_FAILURES_MAX 8
/* of a landing that does not say */
#define SERIES_TOUCHDOWN_FT 3.0
#define SERIES_SPEED_FT_S   28.0

/* auto: the chain always; the planar engine where the chain's compression could raise a wave. */
enum series_engine { SERIES_AUTO, SERIES_CHAIN, SERIES_PLANAR };

struct series_range {
    double low, high; /* uniform between them */
};

struct series_knot {
    double station_ft, deceleration_ft_s2;
};

/* A landing as the file says it. */
struct series_landing {
    struct series_range touchdown_ft;
    struct series_range speed_ft_s;
    /* drawn anew in every landing; when there is no profile */
    struct series_range deceleration_ft_s2;
    /* linear between stations, constant beyond the ends */
    struct series_knot profile[SERIES_PROFILE_MAX];
    size_t profile_count;
    /* above 0: no landing, but a model towed with locked wheels: constant speed, this thrust on the
     * strip */
    double tow_lb;
    /* as the runway is then: the file's scene with what has been applied; model and path unset */
    struct sim_scene scene;
    double times;  /* so many alike */
    bool modified; /* a modification was applied before this landing */
};

struct landing_series {
    char name[80];
    struct series_landing *landings;
    size_t landing_count;
    uint64_t first_seed;
    size_t seeds;
    enum series_engine engine;
    unsigned ground; /* 1: elastic */
    /* runway */
    struct series_range gap_in, closing_lb, irregularity_in;
    double strength_lb_in; /* of a joint in tension, per inch of width */
    double strip_ft;       /* width that a mat of the scene stands for */
    double unhinge_deg;    /* unhinging: a joint that turns by more comes apart */
    bool press_flat;       /* waves that a landing leaves, before the next */
    double wave_in;        /* a rise above this is a wave, */
    double buckle_in;      /* above this a buckle */
    /* aircraft */
    double weight_lb, axles, onset_s, dwell_s;
    /* engines */
    double chain_dt_s, planar_dt_s; /* 0: half the stability limit, a quarter of it */
    /* of the weight that a joint must carry before the planar engine is asked */
    double skip_share;
    double stations_ft[SERIES_STATIONS_MAX];
    size_t station_count;
    /* what was seen, for the scoreboard; texts, "" when absent */
    char observed[240];
    /* where the parameters come from: calibrated on this series, predicted, assumed */
    char basis[400];
    char afterwards[240]; /* what was put in after its row had been seen: no prediction any more */
};

/* The keys of a study's sections, as a file has them; series_key_count of them, section by
 * section. */
enum series_key_kind { SERIES_NUMBER, SERIES_RANGE, SERIES_CHOICE, SERIES_TEXT, SERIES_FLAG };
struct series_key {
    const char *section, *name; /* its unit is what the name ends with */
    enum series_key_kind kind;
    size_t offset; /* in struct series */
    double low, high;
    const char *const *choices; /* ends with NULL */
};
extern const struct series_key series_keys[];
extern const size_t series_key_count;
/* A number, [from, to] or a word; the caller's. */
json_t *series_key_json(const struct series_key *key, const struct landing_series *series);

/* Read a study file. MR_MALFORMED names the key; MR_IO, MR_TRUNCATED as scenes. Nothing is left
 * to free then. */
enum mr_status series_load(struct landing_series *series, const char *path, struct error *error);
/* The same from what a file holds. `where` begins its errors; a scene that is a name is looked for
 * beside the file `where`. */
enum mr_status series_from_json(struct landing_series *series, const char *where,
                                const json_t *root, struct error *error);
/* The same on this ground, "weightless" or "elastic"; NULL: the file's. */
enum mr_status series_load_on(struct landing_series *series, const char *path, const char *ground,
                              struct error *error);
void series_free(struct landing_series *series);
/* The object of a JSON file; `name` is looked for beside `file` (NULL: as it is). `what` names it
 * in errors. A new reference; NULL: MR_IO, MR_TRUNCATED, MR_MALFORMED. */
json_t *series_json(const char *file, const char *name, const char *what, struct error *error);
/* Where that is. */
void series_beside(const char *file, const char *name, char path[PATH_MAX]);
/* The scene of a series that was read from `file`: what it holds, or what the file holds that it
 * names beside itself; on elastic ground with that ground's keys. The caller owns the reference;
 * NULL: absent, or as the error says. */
json_t *series_scene_json(const char *file, const json_t *root, struct error *error);
/* Likewise the scene keys that elastic ground adds. */
json_t *series_elastic_json(const char *file, const json_t *root, struct error *error);

/* Which ground the first landing is on, in words for one line. */
void series_ground_text(const struct landing_series *series, char *text, size_t size);

#endif
