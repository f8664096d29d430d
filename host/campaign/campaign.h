/* Campaign: one runway, a series of landings on it, and an ensemble of runways drawn from seeds.
 * README.md.
 *
 * The file's own quantities have their units in their names; scene keys are host/sim/README.md's
 * (ft, lb, s, slug). Stations are feet from the runway's upfield edge. Mats 1..N, joints and nodes
 * 1..N+1; in arrays by joint [0] is joint 1. One owner: campaign_load allocates, campaign_free
 * releases. A loaded campaign is only read: any number of threads may play runways of it at
 * once. */
#ifndef MATRIG_HOST_CAMPAIGN_H
#define MATRIG_HOST_CAMPAIGN_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/base/error.h"
#include "host/sim/scene/scene.h"

#define CAMPAIGN_LANDINGS_MAX 200
#define CAMPAIGN_SEEDS_MAX    10000
#define CAMPAIGN_PROFILE_MAX  16
#define CAMPAIGN_STATIONS_MAX 64
#define CAMPAIGN_WAVES_MAX    8
#define CAMPAIGN_FACTS_MAX    12
#define CAMPAIGN_FAILURES_MAX 8

/* auto: the chain always; the planar engine where the chain's compression could raise a wave. */
enum campaign_engine { CAMPAIGN_AUTO, CAMPAIGN_CHAIN, CAMPAIGN_PLANAR };
enum campaign_along { CAMPAIGN_MATS, CAMPAIGN_GROUND };
enum campaign_back { CAMPAIGN_PLYWOOD, CAMPAIGN_BARE };

struct campaign_range {
    double low, high; /* uniform between them */
};

struct campaign_knot {
    double station_ft, deceleration_ft_s2;
};

/* A landing as the file says it. */
struct campaign_landing {
    struct campaign_range touchdown_ft;
    struct campaign_range speed_ft_s;
    /* drawn anew in every landing; when there is no profile */
    struct campaign_range deceleration_ft_s2;
    /* linear between stations, constant beyond the ends */
    struct campaign_knot profile[CAMPAIGN_PROFILE_MAX];
    size_t profile_count;
    /* above 0: no landing, but a model towed with locked wheels: constant speed, this thrust on the
     * strip */
    double tow_lb;
    enum campaign_back back;
    /* as the runway is then: the file's scene with what has been applied; model and path unset */
    struct sim_scene scene;
    bool modified; /* a modification was applied or removed before this landing */
};

/* What else was seen than where the runway buckled: a quantity over some landings, and its
 * range. */
enum campaign_quantity {
    CAMPAIGN_MOVED_IN,  /* sum of the movements */
    CAMPAIGN_EACH_IN,   /* their mean */
    CAMPAIGN_MOST_IN,   /* their largest */
    CAMPAIGN_MEAN_IN,   /* their mean, of the mean over all stations */
    CAMPAIGN_ZONE_MATS, /* longest closed zone */
    CAMPAIGN_WAVES,     /* landings with a wave */
    CAMPAIGN_SLACK,     /* landings in which a band went slack */
    CAMPAIGN_TORN,      /* landings in which joints tore */
    CAMPAIGN_FAILURES,  /* most stations that one landing buckled at */
    /* from the first of them to the second, downfield; none where there is one */
    CAMPAIGN_APART_FT
};
enum campaign_when { CAMPAIGN_IN_LANDINGS, CAMPAIGN_BEFORE_BUCKLING, CAMPAIGN_AT_BUCKLING };

struct campaign_fact {
    char says[160];
    enum campaign_quantity quantity;
    enum campaign_when when;
    size_t first, last; /* landings, from 1 */
    /* the quantity is divided by what it is over these; 0: not */
    size_t against_first, against_last;
    double station_ft; /* of movements; NaN: wherever they are largest */
    double low, high;
    double needed; /* share of the runways that has to agree */
};

struct campaign {
    char name[80];
    struct campaign_landing *landings;
    size_t landing_count;
    uint64_t first_seed;
    size_t seeds;
    enum campaign_engine engine;
    /* runway */
    struct campaign_range gap_in, closing_lb, irregularity_in;
    enum campaign_along along;
    double strength_lb_in; /* of a joint in tension, per inch of width */
    double strip_ft;       /* width that a mat of the scene stands for */
    double unhinge_deg;    /* unhinging: a joint that turns by more comes apart */
    bool press_flat;       /* waves that a landing leaves, before the next; with parting always */
    bool parting;          /* during a landing; else it is told after it */
    double wave_in;        /* a rise above this is a wave, */
    double buckle_in;      /* above this a buckle */
    /* aircraft */
    double weight_lb, axles, onset_s, dwell_s;
    double back_ft_s, back_drag_ft_s2;
    /* engines */
    double chain_dt_s, planar_dt_s; /* 0: half the stability limit, a quarter of it */
    /* of the weight that a joint must carry before the planar engine is asked */
    double skip_share;
    double stations_ft[CAMPAIGN_STATIONS_MAX];
    size_t station_count;
    /* what was seen, for the scoreboard; texts, "" when absent */
    char observed[240], awaits[160];
    /* where the parameters come from: calibrated on this series, predicted, assumed */
    char basis[400];
    char afterwards[240]; /* what was put in after its row had been seen: no prediction any more */
    int observed_landing; /* 0: not stated; -1: never */
    int within;           /* landings: a runway that buckles so near to it agrees */
    double needed;        /* share of the runways that has to agree */
    struct campaign_fact facts[CAMPAIGN_FACTS_MAX];
    size_t fact_count;
};

/* The keys of a study's sections, as a file has them; campaign_key_count of them, section by
 * section. */
enum campaign_key_kind { CAMPAIGN_NUMBER, CAMPAIGN_RANGE, CAMPAIGN_CHOICE };
struct campaign_key {
    const char *section, *name; /* its unit is what the name ends with */
    enum campaign_key_kind kind;
    size_t offset; /* in struct campaign */
    double low, high;
    const char *const *choices; /* ends with NULL */
};
extern const struct campaign_key campaign_keys[];
extern const size_t campaign_key_count;
/* A number, [from, to] or a word; the caller's. */
json_t *campaign_key_json(const struct campaign_key *key, const struct campaign *campaign);
json_t *campaign_range_json(struct campaign_range range);

/* Read a campaign file. MR_MALFORMED names the key; MR_IO, MR_TRUNCATED as scenes. Nothing is left
 * to free then. */
enum mr_status campaign_load(struct campaign *campaign, const char *path, struct error *error);
/* The same from what a file holds. `where` begins its errors; a scene that is a name is looked for
 * beside the file `where`. */
enum mr_status campaign_from_json(struct campaign *campaign, const char *where, const json_t *root,
                                  struct error *error);
/* The same on this ground, "weightless" or "elastic"; NULL: the file's. */
enum mr_status campaign_load_on(struct campaign *campaign, const char *path, const char *ground,
                                struct error *error);
void campaign_free(struct campaign *campaign);
/* The scene of a campaign that was read from `file`: what it holds, or what the file holds that it
 * names beside itself; on elastic ground with that ground's keys. The caller owns the reference;
 * NULL: absent, or as the error says. */
json_t *campaign_scene_json(const char *file, const json_t *root, struct error *error);
/* Likewise the scene keys that elastic ground adds. */
json_t *campaign_elastic_json(const char *file, const json_t *root, struct error *error);

/* Which ground the first landing is on, in words for one line. */
void campaign_ground_text(const struct campaign *campaign, char *text, size_t size);

#endif
