/* Scene: one description of what is simulated, whatever the model and the solver (README.md, "Scene
 * keys").
 *
 * Units ft, lb, s. Stations from the left edge of mat 1, downfield positive. Mats 1..N, joints
 * 1..N+1 (joint j is the left end of mat j). A scene comes from a file (sim_scene_load) or from
 * memory: sim_scene_defaults, then set fields and lists. Either way sim_run checks it again, so a
 * scene made in memory can be as wrong as a file and is refused as clearly.
 *
 * Ownership: the scene owns its lists; sim_scene_set_* copy what they are given; sim_scene_free
 * releases everything. */
#ifndef MATRIG_HOST_SIM_SCENE_SCENE_H
#define MATRIG_HOST_SIM_SCENE_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "common/status.h"
#include "host/base/error.h"

#define SIM_MATS_MAX       100000
#define SIM_ELEMENTS_MAX   8
#define SIM_GEAR_LINES_MAX 8

enum sim_model { SIM_REPORT, SIM_CONSISTENT, SIM_CHAIN };
enum sim_tad_mode { SIM_DEADBAND, SIM_SWITCHED };
enum sim_profile { SIM_LOW, SIM_FULL };
enum sim_end { SIM_FREE, SIM_FIXED };
enum sim_thrust { SIM_JUMP, SIM_LINEAR };
enum sim_friction { SIM_STICK, SIM_TANH, SIM_SIGN, SIM_NONE };
enum sim_normal { SIM_WEIGHT, SIM_SOIL };
enum sim_band_over { SIM_OVER_JOINTS, SIM_OVER_RIVETS };
enum sim_lift_shear { SIM_RISING, SIM_NO_SHEAR, SIM_FOLLOWING, SIM_BOTH };

struct sim_list {
    double *values; /* NULL when empty */
    size_t count;
};

struct sim_path_row {
    double t_s;
    double x_ft;
    double force_lb; /* on the mats, downfield positive */
};

#define SIM_BAND_GROUPS 2

/* Bands that are alike; those of the other group may have another section, tension and rivets. */
struct sim_bands {
    double count;    /* on the strip; 0: none */
    double area_ft2; /* of one */
    double e_lb_ft2;
    int every, first, last; /* riveted mats; 0: the first of `every`, the last mat */
    /* per band: one value, or one per segment; negative: slack by T l/(A E) */
    struct sim_list t0_lb;
    double k_lb_ft; /* spring at either anchor; INFINITY: rigid */
    /* what a connection holds before the band slips through; INFINITY: all */
    double grip_lb;
    double pull_lb;  /* vertical force that pulls a rivet out; INFINITY: none */
    double wear_ft;  /* slip that wears a rivet's hole to nothing; INFINITY: never */
    double tilt_rad; /* how far the wheel turns a riveted mat */
    double alpha_f;  /* thermal expansion, 1/degree F */
    double dt_f;     /* how much warmer the band is than when it had its T0, degrees F */
    enum sim_band_over over;
    struct sim_list slipped_ft; /* per connection, so far; empty: 0 */
    struct sim_list pulled;     /* mats whose rivets are out */
};

/* What was done to a runway against movement and waves (MODIFICATIONS.md). All of it is absent by
 * default. */
struct sim_mods {
    struct sim_bands band[SIM_BAND_GROUPS];
    /* cleats */
    int cleat_every, cleat_first; /* 0: none; the first of `every` */
    double cleat_hold_lb;         /* a fresh one */
    /* movement in which the hold falls to 1/e; INFINITY: it does not */
    double cleat_travel_ft;
    double cleat_depth_ft; /* planar: out of the ground when the mat has risen so far */
    /* hold goes with depth to this power; 0: with its square while raised, and what was out is lost
     */
    double cleat_power;
    double cleat_spring_deg;    /* turned by less at its root it springs back */
    struct sim_list cleat_left; /* share that each still has; empty: 1 */
    /* stiffeners */
    int stiff_span; /* mats that one ties together; 0: none */
    int stiff_free; /* joints between one and the next of its line */
    int stiff_lines, stiff_first;
    /* of one line at a joint it crosses, along the runway */
    double stiff_k_lb_ft, stiff_grip_lb;
    double stiff_kt_lb_ft_rad, stiff_yield_lb_ft; /* and in bending */
    /* openings at which the lines pull nothing; empty: gap0 */
    struct sim_list stiff_gap0_ft;
    /* diagonal lay */
    double lay_deg, lay_slide_lb, lay_mu;
    /* joints torn in tension */
    double tear_lb; /* INFINITY: none */
    struct sim_list torn;
};

/* How the gear stands on an elastic ground (elements/gear.h); its stiffness is the element's. */
struct sim_gear {
    double damping;           /* of a loaded mat, share of critical */
    double unloading;         /* rho: share of the way that springs back */
    double axle_law;          /* stiffness grows with axles to this power */
    double foot_ft;           /* length along the runway that an axle presses evenly */
    struct sim_list lines_ft; /* behind the lead axle; empty: that one alone */
    struct sim_list axles;    /* on each line; empty: one */
};

struct sim_scene {
    char name[80];
    enum sim_model model;
    int mats;
    double length_ft;
    double weight_lb;
    double g_ft_s2;
    double inertia_slug_ft2;
    double kv_lb_ft;
    double cv_lb_s_ft;
    double kl_lb_ft;
    double cl_lb_s_ft;
    double kt_lb_ft_rad;
    double ct_lb_ft_s_rad;
    double tad_deg;
    enum sim_tad_mode tad_mode;
    enum sim_profile profile;
    double slack_ft;
    enum sim_end left;
    enum sim_end right;
    enum sim_end left_torsion;
    enum sim_end right_torsion;
    double force_lb;
    double vac_ft_s;
    double s0_ft;
    double force_stop_s; /* INFINITY: never */
    enum sim_thrust thrust;
    double wheel_load_lb;
    double friction;
    enum sim_friction friction_law;
    double veps_ft_s;
    enum sim_normal friction_normal;
    double shear_lb;
    enum sim_lift_shear lift_shear;
    double q1_lb;
    int bump_first;
    struct sim_list bump_ft;
    double v0_ft_s;
    int v0_mat; /* 0: the mat under the wheel at t = 0 */
    double mats_crossed;
    double t_end_s;          /* 0: from mats_crossed, or from path and t_dwell */
    struct sim_list t_out_s; /* empty: the end */
    struct sim_list u_mats;  /* mat numbers; empty: all */
    /* whole landings */
    struct sim_path_row *path; /* NULL: Vac, s0 and F; else it replaces those three */
    size_t path_count;
    struct sim_list gap0_ft; /* empty: 0; one value for every joint; or N+1 */
    struct sim_list grit_lb; /* likewise */
    /* empty: level; or N+1 heights (up) on which the nodes rest, for the whole run */
    struct sim_list ground_ft;
    double t_dwell_s; /* negative: not given */
    struct sim_mods mods;
    struct sim_gear gear;
    /* by place in elements/element.h: parameter of each element; 0: absent */
    double element[SIM_ELEMENTS_MAX];
};

/* Every key at its default, no lists. */
void sim_scene_defaults(struct sim_scene *scene);

/* Read a scene file. Unknown key, wrong type, value out of range, list of the wrong length:
 * MR_MALFORMED naming the key; no JSON: MR_MALFORMED or MR_TRUNCATED with line and column; not
 * readable: MR_IO. On failure nothing is left to free. */
enum mr_status sim_scene_load(struct sim_scene *scene, const char *path, struct error *error);
/* The same from text in memory; `where` begins its errors in place of a path. */
enum mr_status sim_scene_parse(struct sim_scene *scene, const char *where, const char *text,
                               size_t length, struct error *error);

/* The same from an object that has been read already; `where` begins the error. On failure nothing
 * is left to free. */
struct json_t;
enum mr_status sim_scene_from_json(struct sim_scene *scene, const char *where, struct json_t *root,
                                   struct error *error);

/* Ranges and lengths of everything, and what contradicts itself. `where` begins the error
 * ("scene.json" or the like). */
enum mr_status sim_scene_check(const struct sim_scene *scene, const char *where,
                               struct error *error);

/* Replace a list of the scene by a copy. */
void sim_scene_set_list(struct sim_list *list, const double *values, size_t count);
void sim_scene_set_path(struct sim_scene *scene, const struct sim_path_row *rows, size_t count);

/* When the run ends: tend; else, with t_dwell, that long after the aircraft stops or leaves; else
 * the path's last row, or mats_crossed at Vac. INFINITY when nothing ends it. */
double sim_scene_end_s(const struct sim_scene *scene);

/* When the run begins. At 0, with the aircraft in the air until the path's first row; but with that
 * row where nothing moves before it, and where it is so late that the path has a clock of its own
 * (seconds of the epoch): there v0, bumps and the like begin with it. */
#define SIM_CLOCK_S 86400.0 /* a day */
double sim_scene_start_s(const struct sim_scene *scene);

/* The scene with all its times counted from there, for engines, which begin at 0: so their clock is
 * as fine as the run asks. It shares the other lists of the scene. A t_out before the start becomes
 * 0: until then nothing has moved. */
void sim_scene_from_start(struct sim_scene *counted, const struct sim_scene *scene);
void sim_scene_from_start_free(struct sim_scene *counted, const struct sim_scene *scene);

/* The shortest time that a fixed step must not pass over: in which thrust is beyond what friction
 * holds, or in which a mat that is thrown comes to rest. INFINITY without friction. */
double sim_scene_shortest_s(const struct sim_scene *scene);

/* Value of a per-joint list for joint 1..N+1. */
double sim_scene_joint(const struct sim_list *list, int joint);

void sim_scene_free(struct sim_scene *scene);

const char *sim_model_name(enum sim_model model);
/* Its title; "scene" without one. */
const char *sim_scene_name(const struct sim_scene *scene);

/* The part of a scene that says how the runway is modified: defaults, ranges that need the whole
 * scene, and which mats have what. elements/mods.h has the forces. Mats count from 1, connections
 * and cleats from 0. The scene owns its lists. */

/* Defaults, and release of lists. */
void mods_free_lists(struct sim_mods *mods);
#define MODS_LISTS (3 * SIM_BAND_GROUPS + 3)
void mods_lists(struct sim_mods *mods, struct sim_list *lists[MODS_LISTS]); /* all that it owns */
/* MR_MALFORMED: the error names the key. */
bool mods_any(const struct sim_scene *scene);

/* How many connections (riveted mats) a group of bands and how many cleats a scene has, and the mat
 * of the i-th from 0. A group has one segment more than connections, or none. */
int mods_connections(const struct sim_scene *scene, int group);
int mods_connection_mat(const struct sim_scene *scene, int group, int i);
int mods_cleats(const struct sim_scene *scene);
int mods_cleat_mat(const struct sim_scene *scene, int i);

/* The keys of a scene: name in the file, place in struct sim_scene, unit, what is allowed. One
 * table reads, checks and explains them. An element that is a file of its own brings its key along
 * (elements/element.h). Each key has its unit in ft, lb, s, slug; a value may be text with any unit
 * of its kind (host/base/quantity.h). */
enum sim_key_kind {
    SIM_KEY_TEXT,
    SIM_KEY_REAL,
    SIM_KEY_INTEGER,
    SIM_KEY_CHOICE, /* an int-sized enum; `choices` in its order */
    SIM_KEY_LIST,   /* of reals */
    SIM_KEY_JOINTS, /* one real, or a list of N+1 */
    SIM_KEY_PARTS,  /* one real, or a list with one per part of a modification (mods_check) */
    SIM_KEY_PATH    /* rows of three reals */
};

struct sim_key {
    const char *name;
    enum sim_key_kind kind;
    size_t offset;
    double low; /* of the value, or of each value of a list */
    double high;
    bool above;                 /* low itself is not allowed */
    const char *const *choices; /* ends with NULL */
    const char *unit;           /* "lb s/ft"; "" for a pure number or a name */
    const char *meaning;        /* one line for people */
};

#define SIM_LARGEST 1e15 /* of no physical meaning: keeps products of values finite */

/* Keys of elements; elements/element.c. */
extern const struct sim_key *const sim_element_keys[];
extern const size_t sim_element_key_count;

/* All keys, in order; NULL beyond the last. The key with this name, or NULL. */
const struct sim_key *sim_key_at(size_t i);
const struct sim_key *sim_key_find(const char *name);

/* A default that a file can hold: no infinity, no list. NULL: none. The caller's, as is the object
 * of all keys: default, unit, meaning, choices of each. */
struct json_t *sim_key_default(const struct sim_key *key);
struct json_t *sim_scene_keys(void);
/* One line per key: name, default, unit, meaning. */
void sim_scene_print_keys(FILE *to);

#endif
