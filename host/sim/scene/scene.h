/* Scene: one description of a simulation, for all models and solvers (README.md, "Scene keys").
 *
 * Units are ft, lb and s. Stations are measured from the left edge of mat 1, downfield positive.
 * Mats 1..N, joints 1..N+1 (joint j is the left end of mat j). A scene is read from a file
 * (sim_scene_load) or made in memory: sim_scene_set_defaults, then set fields and lists. sim_run
 * checks every scene again, so a scene made in memory is refused with the same errors as a file.
 *
 * Ownership: the scene owns its lists; sim_scene_set_* copy their arguments; sim_scene_free
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

/* Quantities that may vary along the runway. The first four have a value per joint or node (N + 1),
 * the others per mat (N). */
enum sim_varied {
    SIM_VARIED_KV,
    SIM_VARIED_CV,
    SIM_VARIED_KL,
    SIM_VARIED_KT,
    SIM_VARIED_W,
    SIM_VARIED_V0,
    SIM_VARIED_COUNT
};

enum sim_model { SIM_MODEL_REPORT, SIM_MODEL_CONSISTENT, SIM_MODEL_CHAIN };
enum sim_tad_mode { SIM_TAD_DEADBAND, SIM_TAD_SWITCHED };
enum sim_profile { SIM_PROFILE_LOW, SIM_PROFILE_FULL };
enum sim_end { SIM_END_FREE, SIM_END_FIXED, SIM_END_SPRING, SIM_END_LOADED };
enum sim_thrust { SIM_THRUST_JUMP, SIM_THRUST_LINEAR };
enum sim_friction { SIM_FRICTION_STICK, SIM_FRICTION_TANH, SIM_FRICTION_SIGN, SIM_FRICTION_NONE };
enum sim_normal { SIM_NORMAL_WEIGHT, SIM_NORMAL_SOIL };
enum sim_band_over { SIM_BAND_OVER_JOINTS, SIM_BAND_OVER_RIVETS };
enum sim_lift_shear { SIM_SHEAR_RISING, SIM_SHEAR_NONE, SIM_SHEAR_FOLLOWING, SIM_SHEAR_BOTH };

struct sim_list {
    double *values; /* NULL if the list is empty */
    size_t count;
};

struct sim_path_row {
    double t_s;
    double x_ft;
    double force_lb; /* force on the mats, downfield positive */
};

#define SIM_BAND_GROUPS 2

/* A group of identical bands. The other group may have a different section, tension and rivets. */
struct sim_bands {
    double count;    /* number of bands across the mat strip; 0: none */
    double area_ft2; /* cross-section of one band */
    double e_lb_ft2;
    /* first and last riveted mat; 0: the first multiple of `spacing`, the last mat */
    int spacing, first_mat, last_mat;
    /* Initial tension T of a band: one value, or one per segment. Negative: the segment is slack by
     * the length -T l/(A E). */
    struct sim_list initial_tension_lb;
    double k_lb_ft; /* stiffness of the spring at each anchor; INFINITY: rigid */
    /* Largest force that a connection holds before the band slips through it; INFINITY: it never
     * slips. */
    double grip_lb;
    /* vertical force that pulls a rivet out; INFINITY: rivets cannot be pulled out */
    double rivet_pull_lb;
    /* slip at which the hole of a rivet is worn through; INFINITY: holes do not wear */
    double hole_wear_ft;
    double mat_tilt_rad; /* angle by which the wheel turns a riveted mat against the band */
    double thermal_expansion_per_degf; /* thermal expansion, 1/degree Fahrenheit */
    /* temperature of the band minus the temperature at which its tension was T, degrees
     * Fahrenheit */
    double temperature_rise_degf;
    enum sim_band_over acts_on;
    struct sim_list slipped_ft; /* slip of each connection at the start; empty: 0 */
    struct sim_list pulled;     /* numbers of the mats whose rivets are pulled out */
};

/* A kind of springs with dampers at every n-th mat or joint (elements/mods.h). Anchors hold mats
 * along the runway, tie-downs hold mats on the ground, and shock absorbers act across joints. */
enum sim_restraint_kind { SIM_ANCHORS, SIM_TIE_DOWNS, SIM_ABSORBERS, SIM_RESTRAINT_KIND_COUNT };

struct sim_restraint {
    /* mats or joints `first_place`, `first_place` + `spacing`, ...; spacing 0: none; first_place 0:
     * the first multiple of `spacing` */
    int spacing, first_place;
    double k_lb_ft, c_lb_s_ft;
    /* largest force of a restraint; a larger force pulls anchors and tie-downs out */
    double grip_lb;
    /* For each restraint: position of its mat (anchor), rise (tie-down) or opening (absorber) at
     * which the spring exerts no force. Empty: 0, for an absorber gap0. */
    struct sim_list zero_ft;
};

/* Modifications of a runway that reduce movement and waves (MODIFICATIONS.md). By default there are
 * none. */
struct sim_mods {
    struct sim_bands band[SIM_BAND_GROUPS];
    /* mats with cleats: cleat_every 0: none; cleat_first 0: the first multiple of cleat_every */
    int cleat_every, cleat_first;
    double cleat_hold_lb; /* holding force of a new cleat */
    /* movement of a mat that reduces the hold to 1/e; INFINITY: the hold is constant */
    double cleat_travel_ft;
    /* planar model: rise of a mat at which its cleat is out of the ground */
    double cleat_depth_ft;
    /* The hold of a raised cleat is proportional to this power of its depth in the ground. 0: the
     * power is 2, and the hold of the part that was out of the ground is lost permanently. */
    double cleat_exponent;
    /* a cleat that is bent at its root by less than this angle springs back */
    double cleat_spring_deg;
    /* for each cleat: share of its hold that remains at the start; empty: 1 */
    struct sim_list cleat_remaining_share;
    int stiffener_span_mats;   /* number of mats that one stiffener connects; 0: none */
    int stiffener_free_joints; /* number of joints between two stiffeners of the same line */
    int stiffener_line_count, stiffener_first_mat;
    /* stiffness along the runway, and largest force, of one stiffener line at a joint that it
     * crosses */
    double stiffener_k_lb_ft, stiffener_grip_lb;
    /* stiffness and yield moment of one line in bending at a joint */
    double stiffener_kt_lb_ft_rad, stiffener_yield_lb_ft;
    /* Joint openings at which the stiffeners exert no force; empty: gap0. */
    struct sim_list stiffener_gap0_ft;
    double lay_deg, lay_slide_lb, lay_mu;
    struct sim_restraint restraint[SIM_RESTRAINT_KIND_COUNT];
    double tear_lb; /* tension that tears a joint; INFINITY: joints do not tear */
    struct sim_list torn;
};

/* Parameters of the gear on elastic ground (elements/gear.h). The stiffness of the ground is the
 * parameter of the element. */
struct sim_gear {
    double damping; /* damping of a loaded mat as a fraction of critical damping */
    /* rho: fraction of the displacement that springs back when the load is removed */
    double recovered_share;
    /* the stiffness is proportional to this power of the number of axles on a mat */
    double axle_exponent;
    double axle_length_ft; /* length along the runway that an axle loads uniformly */
    /* distances of the axle lines behind the lead axle; empty: only the lead axle */
    struct sim_list line_setbacks_ft;
    struct sim_list axle_counts; /* number of axles of each line; empty: one */
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
    enum sim_end left_end;
    enum sim_end right_end;
    enum sim_end left_torsion;
    enum sim_end right_torsion;
    double end_k_lb_ft[2]; /* stiffness of the springs at the left and right end of the runway */
    double end_load_lb[2]; /* additional weight on the first and last mat */
    double force_lb;
    double vac_ft_s;
    double start_ft;
    double force_stop_s; /* time at which the thrust stops; INFINITY: never */
    enum sim_thrust thrust;
    double wheel_load_lb;
    double friction;
    enum sim_friction friction_law;
    double veps_ft_s;
    enum sim_normal friction_normal;
    double lift_shear_lb;
    enum sim_lift_shear lift_shear;
    double q1_lb;
    int bump_first;
    struct sim_list bump_ft;
    double v0_ft_s;
    int v0_mat; /* mat with the initial speed v0; 0: the mat under the wheel at t = 0 */
    double mats_crossed;
    double t_end_s; /* end of the run; 0: determined by mats_crossed, or by path and t_dwell */
    struct sim_list t_out_s;     /* times of the outputs; empty: only the end */
    struct sim_list output_mats; /* numbers of the mats in the output; empty: all */
    /* motion and thrust of the aircraft over time; NULL: Vac, s0 and F are used instead */
    struct sim_path_row *path;
    size_t path_count;
    /* initial opening of the joints: empty: 0; one value for every joint; or N+1 values */
    struct sim_list gap0_ft;
    /* grit resistance of the joints: empty, one value or N+1 values, as gap0_ft */
    struct sim_list grit_lb;
    /* Height of the ground under each node, N+1 values, positive up, constant in the run. Empty:
     * level ground. */
    struct sim_list ground_ft;
    double t_dwell_s; /* duration of the run after the stop; negative: not given */
    struct sim_mods mods;
    struct sim_gear gear;
    /* Parameter of each element, by index in elements/element.h. 0: the scene does not have the
     * element. */
    double element_values[SIM_ELEMENTS_MAX];
    /* Values along the runway, by enum sim_varied. Empty: every mat has the value of the field
     * above. If W varies, inertia and friction of each mat are proportional to its weight. V0
     * replaces v0_ft_s and v0_mat. */
    struct sim_list varied[SIM_VARIED_COUNT];
};

/* Sets every key to its default. The lists are empty. */
void sim_scene_set_defaults(struct sim_scene *scene);

/* Reads a scene file. MR_MALFORMED with the key: unknown key, wrong type, value out of range, list
 * of the wrong length. MR_MALFORMED or MR_TRUNCATED with line and column: not JSON. MR_IO: the file
 * cannot be read. After a failure there is nothing to free. */
enum mr_status sim_scene_load(struct sim_scene *scene, const char *path, struct error *error);
/* As sim_scene_load, for a text in memory. `where` replaces the path in error messages. */
enum mr_status sim_scene_parse(struct sim_scene *scene, const char *where, const char *text,
                               size_t length, struct error *error);

/* As sim_scene_load, for a JSON object. `where` begins the error message. After a failure there is
 * nothing to free. */
struct json_t;
enum mr_status sim_scene_from_json(struct sim_scene *scene, const char *where, struct json_t *root,
                                   struct error *error);

/* Checks ranges and list lengths of all keys, and contradictions between keys. `where` begins the
 * error message, such as "scene.json". */
enum mr_status sim_scene_check(const struct sim_scene *scene, const char *where,
                               struct error *error);

/* Replaces a list by a copy of the values. */
void sim_scene_set_list(struct sim_list *list, const double *values, size_t count);
void sim_scene_set_path(struct sim_scene *scene, const struct sim_path_row *rows, size_t count);

/* Time at which the run ends: tend if it is given. Otherwise t_dwell (if given) after the aircraft
 * stops or leaves the runway; or the last row of the path; or the time in which the aircraft
 * crosses mats_crossed at Vac. INFINITY if nothing ends the run. */
double sim_scene_end_s(const struct sim_scene *scene);

/* Time at which the run starts. Normally 0, with the aircraft in the air until the first row of the
 * path. It is the time of the first row if nothing moves before this row. It is also the time of
 * the first row if that time is later than SIM_CLOCK_S, because the times of the path are then
 * probably seconds since an epoch; v0, bumps and other actions then begin with the first row. */
#define SIM_CLOCK_S 86400.0 /* s; one day */
double sim_scene_start_s(const struct sim_scene *scene);

/* Makes a copy of the scene, for the engines, whose times are relative to the start of the run,
 * because small times have a finer resolution than large ones. The copy shares all other lists with
 * the scene. A t_out before the start becomes 0; nothing moves before the start. */
void sim_scene_shift_times(struct sim_scene *shifted, const struct sim_scene *scene);
void sim_scene_shift_times_free(struct sim_scene *shifted, const struct sim_scene *scene);

/* Returns the shortest time that a fixed step must resolve: during which the thrust exceeds the
 * limit of friction, or in which a mat comes to rest again. INFINITY without friction. */
double sim_scene_shortest_time_s(const struct sim_scene *scene);

/* Returns the value of a list by joint for joint 1..N+1. */
double sim_scene_joint_value(const struct sim_list *list, int joint);
/* True if a quantity of `along` differs along the runway, or if there is a weight on an end. Such a
 * scene needs a solver with fixed steps. */
bool sim_scene_is_varied(const struct sim_scene *scene);
/* Value of a quantity at a joint, node or mat (from 1). If the scene has no list of the quantity,
 * returns `everywhere`. */
double sim_scene_local_value(const struct sim_scene *scene, enum sim_varied which,
                             double everywhere, int at);
/* Weight of mat 1..N, including a weight on the end of the runway. */
double sim_scene_weight_lb(const struct sim_scene *scene, int mat);
/* The value of a quantity that makes the stable step shortest: the largest stiffness or damping, or
 * the smallest weight. */
double sim_scene_step_limiting_value(const struct sim_scene *scene, enum sim_varied which,
                                     double everywhere);
/* Depth of node 1..N+1 at which the soil carries the weight of the node's mats. */
double sim_scene_settlement_ft(const struct sim_scene *scene, int node);

void sim_scene_free(struct sim_scene *scene);

const char *sim_model_name(enum sim_model model);
/* Title of the scene; "scene" if it has none. */
const char *sim_scene_name(const struct sim_scene *scene);

/* The part of a scene that describes the modifications of the runway: defaults, checks that need
 * the whole scene, and the positions of the modifications. elements/mods.h declares the forces.
 * Mats are counted from 1, connections and cleats from 0. The scene owns its lists. */

/* mods_free_lists releases all lists of the modifications. mods_collect_lists writes the addresses
 * of the lists. */
void mods_free_lists(struct sim_mods *mods);
#define MODS_LIST_COUNT (3 * SIM_BAND_GROUPS + 3 + SIM_RESTRAINT_KIND_COUNT)
/* writes the addresses of all lists of the modifications */
void mods_collect_lists(struct sim_mods *mods, struct sim_list *lists[MODS_LIST_COUNT]);
/* True if the scene has any modification. */
bool mods_are_present(const struct sim_scene *scene);

/* The i-th (from 0) of the mats or joints `first` (0: `every`), `first` + `every`, ... */
int mods_nth_place(int first, int every, int i);
/* Number of connections (riveted mats) of a group of bands, of cleats, and of restraints of a kind.
 * A group has one segment more than connections, or none. */
int mods_connection_count(const struct sim_scene *scene, int group);
int mods_cleat_count(const struct sim_scene *scene);
int mods_restraint_count(const struct sim_scene *scene, int kind);
/* Name of the kind in keys. */
const char *mods_restraint_name(int kind);

/* The keys of a scene: name in the file, offset in struct sim_scene, unit, allowed values. One
 * table is used to read, check and explain scenes. The file of an element defines its key
 * (elements/element.h). Each key has its unit in ft, lb, s and slug; a value may be a text with any
 * unit of the same kind (host/base/quantity.h). */
enum sim_key_kind {
    SIM_KEY_TEXT,
    SIM_KEY_REAL,
    SIM_KEY_INTEGER,
    SIM_KEY_CHOICE, /* an enum with the size of an int; `choices` are in the order of its values */
    SIM_KEY_LIST,   /* a list of real numbers */
    /* a real number; a list of N+1; or a real number with rows [first, last, number] */
    SIM_KEY_JOINTS,
    /* a real number, or a list with one value per place of a modification (mods_check) */
    SIM_KEY_PARTS,
    SIM_KEY_PATH /* rows of three real numbers */
};

struct sim_key {
    const char *name;
    enum sim_key_kind kind;
    size_t offset;
    double min; /* smallest and largest allowed value; for a list, of each of its values */
    double max;
    bool excludes_min;          /* true: the value must be above `min` */
    const char *const *choices; /* allowed words; NULL ends the list */
    const char *unit;           /* "lb s/ft"; "" for a number without dimension or a name */
    const char *meaning;        /* description of the key, in one line */
    /* SIM_KEY_REAL: offset of the list that is set if the value is an array; 0: arrays are not
     * allowed. */
    size_t list_offset;
};

#define SIM_VALUE_MAX 1e15 /* keeps products of values finite */

/* Keys of the elements (elements/element.c). */
extern const struct sim_key *const sim_element_keys[];
extern const size_t sim_element_key_count;

/* sim_key_at returns the key with index i, or NULL if i is too large. sim_key_find finds a key by
 * name, or returns NULL. */
const struct sim_key *sim_key_at(size_t i);
const struct sim_key *sim_key_find(const char *name);

/* sim_key_default returns the default of a key as JSON, or NULL if a file cannot contain the
 * default (infinity, a list). sim_scene_keys_to_json returns an object of all keys with default,
 * unit, meaning and choices. The caller owns both. */
struct json_t *sim_key_default(const struct sim_key *key);
struct json_t *sim_scene_keys_to_json(void);
/* Prints one line per key: name, default, unit, meaning. */
void sim_scene_print_keys(FILE *to);

#endif
