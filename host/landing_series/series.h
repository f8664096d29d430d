/* A landing series: one runway, the landings on it, and an ensemble of runways drawn from seeds.
 * README.md describes the file.
 *
 * The names of quantities in the file end with their units. The keys of scenes are those of
 * host/sim/README.md (ft, lb, s, slug). Stations are in feet from the runway's upfield edge. Mats
 * are numbered 1..N, joints and nodes 1..N+1; in arrays by joint, [0] is joint 1. series_load
 * allocates and series_free releases. A loaded series is not modified, so several threads may
 * simulate its runways at the same time. */
#ifndef MATRIG_HOST_LANDING_SERIES_SERIES_H
#define MATRIG_HOST_LANDING_SERIES_SERIES_H

#include <jansson.h>
#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"
#include "host/sim/scene/scene.h"

#define SERIES_LANDINGS_MAX         200
#define SERIES_SEEDS_MAX            10000
#define SERIES_PROFILE_MAX          16
#define SERIES_STATIONS_MAX         64
#define SERIES_FAILURES_MAX         8
/* Touchdown and speed of a landing, if the file does not give them. */
#define SERIES_DEFAULT_TOUCHDOWN_FT 3.0
#define SERIES_DEFAULT_SPEED_FT_S   28.0

/* Engines of the simulation. SERIES_ENGINE_AUTO: the chain is always simulated; the planar
 * engine is run if the chain's compression could raise a wave. */
enum series_engine { SERIES_ENGINE_AUTO, SERIES_ENGINE_CHAIN, SERIES_ENGINE_PLANAR };

struct series_range {
    double low, high; /* ends of the range, from which values are drawn uniformly */
};

struct series_knot {
    double station_ft, deceleration_ft_s2;
};

/* A landing as described in the file. */
struct series_landing {
    struct series_range touchdown_ft;
    struct series_range speed_ft_s;
    /* range from which each landing's deceleration is drawn if there is no profile */
    struct series_range deceleration_ft_s2;
    /* linear between stations, constant beyond the ends */
    struct series_knot profile[SERIES_PROFILE_MAX];
    size_t profile_count;
    /* Above 0: instead of a landing, a model with locked wheels is towed at constant speed and
     * exerts this thrust on the strip. */
    double tow_lb;
    /* The runway at this landing: the scene of the file with all modifications up to this landing.
     * Fields `model` and `path` are not set. */
    struct sim_scene scene;
    double repeat_count; /* number of identical landings that this entry stands for */
    bool is_modified;    /* a modification was applied before this landing */
};

struct landing_series {
    char name[80];
    struct series_landing *landings;
    size_t landing_count;
    uint64_t first_seed;
    size_t seed_count;
    enum series_engine engine;
    unsigned has_elastic_ground; /* 1: the ground is elastic */
    /* the next fields describe the runway */
    struct series_range gap_in, closing_lb, irregularity_in;
    double strength_lb_in; /* strength of a joint in tension, per inch of width */
    double strip_ft;       /* width that a mat of the scene represents */
    double unhinge_deg;    /* unhinging: a joint that turns by more than this angle comes apart */
    /* waves that remain after a landing are pressed flat before the next landing */
    bool flattens_waves;
    double wave_in;   /* a rise above this height is a wave */
    double buckle_in; /* a rise above this height is a buckle */
    /* the next fields describe the aircraft */
    double weight_lb, axles, onset_s, dwell_s;
    /* the next fields configure the engines */
    /* time steps; 0: half the stability limit for the chain, a quarter of it for the planar
     * engine */
    double chain_dt_s, planar_dt_s;
    /* the planar engine is run if the lift force on a joint is at least this fraction of a mat's
     * weight */
    double planar_min_lift_share;
    double stations_ft[SERIES_STATIONS_MAX];
    size_t station_count;
    /* observed outcome, for the scoreboard; "" if absent */
    char observed[240];
    /* origin of the parameters: calibrated on this series, predicted, or assumed */
    char basis[400];
    /* changes made after the outcome was known, which make the row no longer a prediction; "" if
     * none */
    char changes_after_outcome[240];
};

/* The keys of the sections of a study file: series_key_count keys, one section after another. */
enum series_key_kind {
    SERIES_KEY_NUMBER,
    SERIES_KEY_RANGE,
    SERIES_KEY_CHOICE,
    SERIES_KEY_TEXT,
    SERIES_KEY_FLAG
};
struct series_key {
    const char *section, *name; /* the name ends with its unit */
    enum series_key_kind kind;
    size_t offset; /* offset in struct landing_series */
    double low, high;
    const char *const *choices; /* allowed words, terminated by NULL */
};
extern const struct series_key series_keys[];
extern const size_t series_key_count;
/* Returns the value of a key as JSON: a number, [from, to] or a word. The caller owns it. */
json_t *series_key_to_json(const struct series_key *key, const struct landing_series *series);

/* Reads a study file. MR_MALFORMED: `error` names the key. MR_IO, MR_TRUNCATED: as for scenes.
 * After an error there is nothing to free. */
enum mr_status series_load(struct landing_series *series, const char *path, struct error *error);
/* Like series_load, from the JSON of a file. `where`: prefix of error messages. A scene given by
 * name is read from the folder of the file `where`. */
enum mr_status series_from_json(struct landing_series *series, const char *where,
                                const json_t *root, struct error *error);
/* As series_load, but with the ground set to "weightless" or "elastic"; NULL: the ground in the
 * file. */
enum mr_status series_load_on_ground(struct landing_series *series, const char *path,
                                     const char *ground, struct error *error);
void series_free(struct landing_series *series);
/* Reads a JSON object from a file. `name` is relative to the folder of `file` (NULL: to the working
 * directory). `what`: description of the file in error messages. Returns a new reference; NULL:
 * MR_IO, MR_TRUNCATED or MR_MALFORMED. */
json_t *series_read_json(const char *file, const char *name, const char *what, struct error *error);
/* Writes the path of the file `name` in the folder of `file`. */
void series_make_sibling_path(const char *file, const char *name, char path[PATH_MAX]);
/* Returns the scene of a series that was read from `file`: the object in that file, or the content
 * of the file that it names. On elastic ground it includes the keys of that ground. The caller owns
 * the reference. NULL: there is no scene, or `error` is set. */
json_t *series_get_scene_json(const char *file, const json_t *root, struct error *error);
/* Returns the scene keys that elastic ground adds. The caller owns the reference. NULL: there are
 * none, or `error` is set. */
json_t *series_get_elastic_ground_json(const char *file, const json_t *root, struct error *error);

/* Describes the ground of the first landing in one line. */
void series_describe_ground(const struct landing_series *series, char *text, size_t size);

#endif
