#include "host/sim/scene/scene.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "host/base/output.h"
#include "host/base/quantity.h"
#include "host/base/xmalloc.h"

static const char *const model_names[] = {"report", "consistent", "chain", NULL};
static const char *const tad_mode_names[] = {"deadband", "switched", NULL};
static const char *const profile_names[] = {"low", "full", NULL};
static const char *const end_names[] = {"free", "fixed", "spring", "weight", NULL};
static const char *const end_torsion_names[] = {"free", "fixed", NULL};
static const char *const thrust_names[] = {"jump", "linear", NULL};
static const char *const friction_names[] = {"stick", "tanh", "sign", "none", NULL};
static const char *const friction_normal_names[] = {"weight", "soil", NULL};
static const char *const band_over_names[] = {"joints", "rivets", NULL};
static const char *const lift_shear_names[] = {"rising", "none", "following", "both", NULL};

#define SCENE_OFFSET(field) offsetof(struct sim_scene, field)
#define RANGE_KEY(name, field, low, high, above, unit, meaning)                           \
    {                                                                                     \
        name, SIM_KEY_REAL, SCENE_OFFSET(field), low, high, above, NULL, unit, meaning, 0 \
    }
#define REAL_KEY(name, field, unit, meaning) \
    RANGE_KEY(name, field, -SIM_VALUE_MAX, SIM_VALUE_MAX, false, unit, meaning)
#define NOT_NEGATIVE_KEY(name, field, unit, meaning) \
    RANGE_KEY(name, field, 0.0, SIM_VALUE_MAX, false, unit, meaning)
#define POSITIVE_KEY(name, field, unit, meaning) \
    RANGE_KEY(name, field, 0.0, SIM_VALUE_MAX, true, unit, meaning)
#define LIMIT_KEY(name, field, unit, meaning) \
    RANGE_KEY(name, field, 0.0, (double)INFINITY, false, unit, meaning)
#define INT_KEY(name, field, low, high, unit, meaning)                                       \
    {                                                                                        \
        name, SIM_KEY_INTEGER, SCENE_OFFSET(field), low, high, false, NULL, unit, meaning, 0 \
    }
#define CHOICE_KEY(name, field, choices, meaning)                                           \
    {                                                                                       \
        name, SIM_KEY_CHOICE, SCENE_OFFSET(field), 0.0, 0.0, false, choices, "", meaning, 0 \
    }
#define LIST_KEY(name, field, kind, low, high, unit, meaning)                     \
    {                                                                             \
        name, kind, SCENE_OFFSET(field), low, high, false, NULL, unit, meaning, 0 \
    }

/* A key whose value is one number or a list of values along the runway. */
#define VARIED_KEY(name, field, which, low, above, unit, meaning)                                \
    {                                                                                            \
        name, SIM_KEY_REAL, SCENE_OFFSET(field), low, SIM_VALUE_MAX, above, NULL, unit, meaning, \
            SCENE_OFFSET(varied[which])                                                          \
    }

#define BAND_KEYS(name, prefix, i)                                                              \
    NOT_NEGATIVE_KEY(name, mods.band[i].count, "", "number of bands on the strip"),             \
        POSITIVE_KEY(prefix "area", mods.band[i].area_ft2, "ft2", "cross section of one band"), \
        POSITIVE_KEY(prefix "E", mods.band[i].e_lb_ft2, "lb/ft2", "Young's modulus"),           \
        INT_KEY(prefix "every", mods.band[i].spacing, 1, SIM_MATS_MAX, "mats",                  \
                "spacing of the rivets along the runway"),                                      \
        INT_KEY(prefix "first", mods.band[i].first_mat, 0, SIM_MATS_MAX, "mat",                 \
                "first riveted mat"),                                                           \
        INT_KEY(prefix "last", mods.band[i].last_mat, 0, SIM_MATS_MAX, "mat",                   \
                "last mat that may be riveted"),                                                \
        LIST_KEY(prefix "T0", mods.band[i].initial_tension_lb, SIM_KEY_PARTS, -SIM_VALUE_MAX,   \
                 SIM_VALUE_MAX, "lb", "initial tension of a band"),                             \
        RANGE_KEY(prefix "K", mods.band[i].k_lb_ft, 0.0, (double)INFINITY, true, "lb/ft",       \
                  "stiffness of each anchor"),                                                  \
        LIMIT_KEY(prefix "grip", mods.band[i].grip_lb, "lb",                                    \
                  "force at which a connection of band and mat slips"),                         \
        LIMIT_KEY(prefix "pull", mods.band[i].rivet_pull_lb, "lb",                              \
                  "force perpendicular to the mat that pulls a rivet out"),                     \
        RANGE_KEY(prefix "wear", mods.band[i].hole_wear_ft, 0.0, (double)INFINITY, true, "ft",  \
                  "slip after which a rivet hole is worn out"),                                 \
        RANGE_KEY(prefix "tilt", mods.band[i].mat_tilt_rad, 0.0, 1.0, false, "rad",             \
                  "rotation of a riveted mat under the wheel"),                                 \
        NOT_NEGATIVE_KEY(prefix "alpha", mods.band[i].thermal_expansion_per_degf, "1/F",        \
                         "coefficient of thermal expansion"),                                   \
        REAL_KEY(prefix "dT", mods.band[i].temperature_rise_degf, "F",                          \
                 "temperature rise since the band had the tension band_T0"),                    \
        CHOICE_KEY(prefix "over", mods.band[i].acts_on, band_over_names,                        \
                   "where the band acts: on all joints, or on the rivets only"),                \
        LIST_KEY(prefix "slipped", mods.band[i].slipped_ft, SIM_KEY_PARTS, 0.0, SIM_VALUE_MAX,  \
                 "ft", "initial slip of each riveted mat"),                                     \
        LIST_KEY(prefix "pulled", mods.band[i].pulled, SIM_KEY_LIST, 1, SIM_MATS_MAX, "mat",    \
                 "mats whose rivets are pulled out at the start")

#define RESTRAINT_KEYS(prefix, i, place, force)                                           \
    INT_KEY(prefix "every", mods.restraint[i].spacing, 0, SIM_MATS_MAX, place "s",        \
            "spacing of the " force "; 0: none"),                                         \
        INT_KEY(prefix "first", mods.restraint[i].first_place, 0, SIM_MATS_MAX, place,    \
                "first " place " with this restraint"),                                   \
        NOT_NEGATIVE_KEY(prefix "K", mods.restraint[i].k_lb_ft, "lb/ft",                  \
                         "stiffness of the spring"),                                      \
        NOT_NEGATIVE_KEY(prefix "C", mods.restraint[i].c_lb_s_ft, "lb s/ft", "damping"),  \
        LIMIT_KEY(prefix "grip", mods.restraint[i].grip_lb, "lb", "largest force"),       \
        LIST_KEY(prefix "zero", mods.restraint[i].zero_ft, SIM_KEY_PARTS, -SIM_VALUE_MAX, \
                 SIM_VALUE_MAX, "ft",                                                     \
                 "position of each restraint at which its spring exerts no force")

static const struct sim_key keys[] = {
    {"name", SIM_KEY_TEXT, SCENE_OFFSET(name), 0.0, 0.0, false, NULL, "", "title", 0},
    CHOICE_KEY("model", model, model_names, "model equations"),
    INT_KEY("N", mats, 1, SIM_MATS_MAX, "", "number of mats"),
    POSITIVE_KEY("L", length_ft, "ft", "length of a mat along the runway"),
    VARIED_KEY("W", weight_lb, SIM_VARIED_W, 0.0, true, "lb",
               "weight of a mat: number or list by mat"),
    POSITIVE_KEY("g", g_ft_s2, "ft/s2", "gravity"),
    POSITIVE_KEY("I", inertia_slug_ft2, "slug ft2", "inertia of a mat about its long axis"),
    VARIED_KEY(
        "KV", kv_lb_ft, SIM_VARIED_KV, 0.0, false, "lb/ft",
        "stiffness of the soil under a node (report) or mat end (consistent): number or list "
        "by node"),
    VARIED_KEY("CV", cv_lb_s_ft, SIM_VARIED_CV, 0.0, false, "lb s/ft",
               "damping of the soil under a node or mat end: number or list by node"),
    VARIED_KEY("KL", kl_lb_ft, SIM_VARIED_KL, 0.0, true, "lb/ft",
               "stiffness of a joint along the runway: number or list by joint"),
    NOT_NEGATIVE_KEY("CL", cl_lb_s_ft, "lb s/ft", "damping of a joint along the runway"),
    VARIED_KEY("KT", kt_lb_ft_rad, SIM_VARIED_KT, 0.0, false, "ft lb/rad",
               "stiffness of a joint in torsion: number or list by joint"),
    NOT_NEGATIVE_KEY("CT", ct_lb_ft_s_rad, "ft lb s/rad", "damping of a joint in torsion"),
    RANGE_KEY("TAD_deg", tad_deg, 0.0, 180.0, false, "deg", "free rotation of a joint"),
    CHOICE_KEY("tad_mode", tad_mode, tad_mode_names,
               "moment beyond TAD_deg, which rises from zero (deadband) or jumps (switched)"),
    CHOICE_KEY("profile", profile, profile_names,
               "opening of a joint caused by rotation: neglected (low) or included (full)"),
    NOT_NEGATIVE_KEY("slack", slack_ft, "ft", "free travel of a joint"),
    CHOICE_KEY("left", left_end, end_names, "boundary condition at mat 1, along the runway"),
    CHOICE_KEY("right", right_end, end_names, "boundary condition at mat N, along the runway"),
    CHOICE_KEY("left_torsion", left_torsion, end_torsion_names,
               "boundary condition at mat 1, in torsion"),
    CHOICE_KEY("right_torsion", right_torsion, end_torsion_names,
               "boundary condition at mat N, in torsion"),
    NOT_NEGATIVE_KEY("left_K", end_k_lb_ft[0], "lb/ft",
                     "stiffness of the left spring, used if `left` is `spring`"),
    NOT_NEGATIVE_KEY("right_K", end_k_lb_ft[1], "lb/ft",
                     "stiffness of the right spring, used if `right` is `spring`"),
    NOT_NEGATIVE_KEY("left_weight", end_load_lb[0], "lb",
                     "weight on mat 1; used if `left` is `weight`"),
    NOT_NEGATIVE_KEY("right_weight", end_load_lb[1], "lb",
                     "weight on mat N; used if `right` is `weight`"),
    REAL_KEY("F", force_lb, "lb", "thrust"),
    NOT_NEGATIVE_KEY("Vac", vac_ft_s, "ft/s", "speed of the aircraft"),
    REAL_KEY("s0", start_ft, "ft", "station of the aircraft at the start"),
    RANGE_KEY("F_tstop", force_stop_s, 0.0, (double)INFINITY, false, "s",
              "time at which the thrust ends"),
    CHOICE_KEY("thrust", thrust, thrust_names,
               "thrust acts on the mat under the wheel (jump) or is shared by two mats (linear)"),
    NOT_NEGATIVE_KEY(
        "wheel_load", wheel_load_lb, "lb",
        "load on the mat under the wheel; it increases the mat's friction and, in model "
        "`consistent`, presses the mat down"),
    NOT_NEGATIVE_KEY("f", friction, "", "coefficient of friction"),
    CHOICE_KEY("friction", friction_law, friction_names, "friction law"),
    POSITIVE_KEY("veps", veps_ft_s, "ft/s", "speed scale of the tanh friction law"),
    CHOICE_KEY("friction_normal", friction_normal, friction_normal_names,
               "normal force for friction (soil: consistent model only)"),
    REAL_KEY("V", lift_shear_lb, "lb", "report model: lift shear"),
    CHOICE_KEY("lift_shear", lift_shear, lift_shear_names,
               "mats on which the lift shear acts (report model)"),
    REAL_KEY("Q1", q1_lb, "lb", "report model: vertical force on mat 1"),
    INT_KEY("bump_first", bump_first, 1, SIM_MATS_MAX + 1, "node",
            "node of the first value of bump"),
    LIST_KEY("bump", bump_ft, SIM_KEY_LIST, -SIM_VALUE_MAX, SIM_VALUE_MAX, "ft",
             "initial heights of the nodes, starting at bump_first"),
    VARIED_KEY("v0", v0_ft_s, SIM_VARIED_V0, -SIM_VALUE_MAX, false, "ft/s",
               "initial speed of mat v0_mat: number or list by mat"),
    INT_KEY("v0_mat", v0_mat, 0, SIM_MATS_MAX, "mat",
            "mat that has the initial speed v0; 0: the mat under the wheel"),
    POSITIVE_KEY("mats_crossed", mats_crossed, "mats",
                 "duration of the run: number of mats that the wheel crosses at speed Vac"),
    NOT_NEGATIVE_KEY("tend", t_end_s, "s",
                     "time at which the run ends; 0: set by t_dwell, path or mats_crossed"),
    LIST_KEY("t_out", t_out_s, SIM_KEY_LIST, 0.0, SIM_VALUE_MAX, "s", "times of the output"),
    LIST_KEY("u_mats", output_mats, SIM_KEY_LIST, 1, SIM_MATS_MAX, "mat",
             "mats for which the output contains the movement u"),
    LIST_KEY("path", path, SIM_KEY_PATH, -SIM_VALUE_MAX, SIM_VALUE_MAX, "s, ft, lb",
             "rows [time, station, thrust] that replace Vac, s0 and F"),
    LIST_KEY("gap0", gap0_ft, SIM_KEY_JOINTS, -SIM_VALUE_MAX, SIM_VALUE_MAX, "ft",
             "initial opening of each joint"),
    LIST_KEY("grit", grit_lb, SIM_KEY_JOINTS, 0.0, SIM_VALUE_MAX, "lb",
             "grit: compression up to which each open joint resists closing (models chain and "
             "consistent)"),
    LIST_KEY("ground", ground_ft, SIM_KEY_LIST, -SIM_VALUE_MAX, SIM_VALUE_MAX, "ft",
             "consistent model: heights of the ground under the nodes"),
    RANGE_KEY("t_dwell", t_dwell_s, -1.0, SIM_VALUE_MAX, false, "s",
              "time for which the run continues after the aircraft has stopped or left"),
    BAND_KEYS("bands", "band_", 0),
    BAND_KEYS("bands2", "band2_", 1),
    INT_KEY("cleat_every", mods.cleat_every, 0, SIM_MATS_MAX, "mats",
            "spacing of the cleats; 0: no cleats"),
    INT_KEY("cleat_first", mods.cleat_first, 0, SIM_MATS_MAX, "mat", "first mat with a cleat"),
    NOT_NEGATIVE_KEY("cleat_hold", mods.cleat_hold_lb, "lb", "holding force of a new cleat"),
    RANGE_KEY("cleat_travel", mods.cleat_travel_ft, 0.0, (double)INFINITY, true, "ft",
              "movement over which the holding force falls to 1/e"),
    POSITIVE_KEY("cleat_depth", mods.cleat_depth_ft, "ft", "depth of a cleat"),
    RANGE_KEY("cleat_power", mods.cleat_exponent, 0.0, 2.0, false, "",
              "exponent p: the holding force of a raised or bent cleat is proportional to (depth "
              "in the soil)^p. 0 selects p = 2 for a raised cleat and p = 1 for a bent one"),
    RANGE_KEY("cleat_spring_deg", mods.cleat_spring_deg, 0.0, 90.0, false, "deg",
              "bending up to this angle springs back; needs cleat_power"),
    LIST_KEY("cleat_left", mods.cleat_remaining_share, SIM_KEY_PARTS, 0.0, 1.0, "",
             "share of cleat_hold that each cleat still has at the start"),
    INT_KEY("stiff_span", mods.stiffener_span_mats, 0, SIM_MATS_MAX, "mats",
            "number of mats tied by one stiffener"),
    INT_KEY("stiff_free", mods.stiffener_free_joints, 0, SIM_MATS_MAX, "joints",
            "number of free joints between stiffeners"),
    INT_KEY("stiff_lines", mods.stiffener_line_count, 1, 100, "", "number of lines of stiffeners"),
    INT_KEY("stiff_first", mods.stiffener_first_mat, 1, SIM_MATS_MAX, "mat",
            "first mat of the first line of stiffeners"),
    NOT_NEGATIVE_KEY("stiff_K", mods.stiffener_k_lb_ft, "lb/ft",
                     "stiffness of one line at a joint"),
    LIMIT_KEY("stiff_grip", mods.stiffener_grip_lb, "lb", "largest force of one line"),
    NOT_NEGATIVE_KEY("stiff_KT", mods.stiffener_kt_lb_ft_rad, "ft lb/rad",
                     "bending stiffness of one line"),
    LIMIT_KEY("stiff_yield", mods.stiffener_yield_lb_ft, "ft lb", "yield moment of one line"),
    LIST_KEY("stiff_gap0", mods.stiffener_gap0_ft, SIM_KEY_JOINTS, -SIM_VALUE_MAX, SIM_VALUE_MAX,
             "ft", "opening of each joint at which the stiffener force is zero"),
    RANGE_KEY("lay_deg", mods.lay_deg, 0.0, 80.0, false, "deg", "angle of the diagonal pattern"),
    NOT_NEGATIVE_KEY("lay_slide", mods.lay_slide_lb, "lb",
                     "friction force along an unloaded diagonal joint"),
    RANGE_KEY("lay_mu", mods.lay_mu, 0.0, 10.0, false, "",
              "friction coefficient along a diagonal joint"),
    RESTRAINT_KEYS("anchor_", SIM_ANCHORS, "mat",
                   "anchors, which resist movement along the runway"),
    RESTRAINT_KEYS("tie_", SIM_TIE_DOWNS, "mat", "tie-downs, which hold mats on the ground"),
    RESTRAINT_KEYS("absorber_", SIM_ABSORBERS, "joint", "shock absorbers across joints"),
    RANGE_KEY("tear", mods.tear_lb, 0.0, (double)INFINITY, true, "lb",
              "tension at which a joint tears"),
    NOT_NEGATIVE_KEY(
        "gear_damping", gear.damping, "",
        "damping of a mat under the gear on elastic ground, as a fraction of critical damping"),
    RANGE_KEY("gear_unloading", gear.recovered_share, 0.0, 1.0, true, "",
              "share of the displacement that the elastic ground recovers while unloading"),
    RANGE_KEY(
        "gear_axle_law", gear.axle_exponent, 0.0, 2.0, false, "",
        "exponent of the ground stiffness under a mat against the number of axles on the mat"),
    NOT_NEGATIVE_KEY("gear_foot_ft", gear.axle_length_ft, "ft",
                     "length over which an axle presses uniformly, at most 4 mats; 0: only the mat "
                     "under the axle"),
    LIST_KEY("gear_lines_ft", gear.line_setbacks_ft, SIM_KEY_LIST, 0.0, SIM_VALUE_MAX, "ft",
             "distances of the axle lines behind the lead axle; default: one line"),
    LIST_KEY("gear_axles", gear.axle_counts, SIM_KEY_LIST, 0.0, 1e6, "",
             "number of axles on each line; each axle has wheel_load and thrust"),
    LIST_KEY("torn", mods.torn, SIM_KEY_LIST, 1, SIM_MATS_MAX + 1, "joint",
             "numbers of the joints that are torn at the start"),
};
#define KEY_COUNT (sizeof keys / sizeof keys[0])

const struct sim_key *sim_key_at(size_t i)
{
    return i < KEY_COUNT                         ? &keys[i]
         : i - KEY_COUNT < sim_element_key_count ? sim_element_keys[i - KEY_COUNT]
                                                 : NULL;
}

const struct sim_key *sim_key_find(const char *name)
{
    for (size_t i = 0; sim_key_at(i); i++) {
        if (strcmp(sim_key_at(i)->name, name) == 0)
            return sim_key_at(i);
    }
    return NULL;
}

/* ---- a scene in memory ---- */

/* Sets the defaults of the modifications. Sections of the report: bands 5.1.2.1 (3/8 x 0.020 in,
 * steel), deflection under the wheel 2.6 (0.050 in over a mat of 24/7 in), cleats 5.5. */
static void mods_set_defaults(struct sim_mods *mods)
{
    *mods = (struct sim_mods){
        .cleat_travel_ft = (double)INFINITY,
        .cleat_depth_ft = 0.75 / 12.0,
        .stiffener_free_joints = 1,
        .stiffener_line_count = 1,
        .stiffener_first_mat = 1,
        .stiffener_grip_lb = (double)INFINITY,
        .stiffener_yield_lb_ft = (double)INFINITY,
        .tear_lb = (double)INFINITY,
    };
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; k++)
        mods->restraint[k].grip_lb = (double)INFINITY;
    for (int g = 0; g < SIM_BAND_GROUPS; g++)
        mods->band[g] = (struct sim_bands){
            .area_ft2 = 0.375 * 0.020 / 144.0,
            .e_lb_ft2 = 29e6 * 144.0,
            .spacing = 20,
            .k_lb_ft = (double)INFINITY,
            .grip_lb = (double)INFINITY,
            .rivet_pull_lb = (double)INFINITY,
            .hole_wear_ft = (double)INFINITY,
            .mat_tilt_rad = 0.050 / (24.0 / 7.0),
            .thermal_expansion_per_degf = 6.5e-6,
        };
}

void sim_scene_set_defaults(struct sim_scene *scene)
{
    *scene = (struct sim_scene){
        .mats = 53,
        .length_ft = 2.0,
        .weight_lb = 160.0,
        .g_ft_s2 = 32.174,
        .inertia_slug_ft2 = 2.0,
        .kv_lb_ft = 1e7,
        .cv_lb_s_ft = 2e4,
        .kl_lb_ft = 8e6,
        .cl_lb_s_ft = 50.0,
        .kt_lb_ft_rad = 1e5,
        .ct_lb_ft_s_rad = 1.0,
        .tad_deg = 10.0,
        .left_end = SIM_END_FREE,
        .right_end = SIM_END_FIXED,
        .force_lb = 12000.0,
        .vac_ft_s = 90.0,
        .force_stop_s = (double)INFINITY,
        .friction = 0.5,
        .veps_ft_s = 1e-3,
        .lift_shear_lb = 120.0,
        .bump_first = 5,
        .v0_ft_s = 2.0,
        .mats_crossed = 3.0,
        .t_dwell_s = -1.0,
        .gear = {.damping = 0.5, .recovered_share = 1.0, .axle_exponent = 1.0},
    };
    mods_set_defaults(&scene->mods);
}

void sim_scene_free(struct sim_scene *scene)
{
    const struct sim_key *key;
    for (size_t i = 0; (key = sim_key_at(i)); i++) {
        if (key->kind == SIM_KEY_LIST || key->kind == SIM_KEY_JOINTS || key->kind == SIM_KEY_PARTS)
            free(((struct sim_list *)((char *)scene + key->offset))->values);
    }
    for (size_t i = 0; i < SIM_VARIED_COUNT; i++)
        free(scene->varied[i].values);
    free(scene->path);
    sim_scene_set_defaults(scene);
}

static void copy_array(void *to, const void *from, size_t count, size_t size)
{
    void **array = to, *copy = NULL;
    if (count > 0) {
        copy = xcalloc(count, size);
        memcpy(copy, from, count * size);
    }
    free(*array);
    *array = copy;
}

void sim_scene_set_list(struct sim_list *list, const double *values, size_t count)
{
    copy_array(&list->values, values, count, sizeof *values);
    list->count = count;
}

void sim_scene_set_path(struct sim_scene *scene, const struct sim_path_row *rows, size_t count)
{
    copy_array(&scene->path, rows, count, sizeof *rows);
    scene->path_count = count;
}

/* ---- reading a scene ---- */

/* Reads a number, or a text "NUMBER UNIT", and converts it to the unit of the key. Returns false
 * for a value of another type, a text without unit, or a unit where the key has none. */
static bool read_quantity(const struct sim_key *key, const json_t *value, double *number,
                          struct quantity_error *wrong)
{
    return quantity_read_json(value, quantity_kind_find(key->unit) ? key->unit : "", number, wrong);
}

static const char *type_name(const json_t *value)
{
    switch (json_typeof(value)) {
    case JSON_OBJECT: return "an object";
    case JSON_ARRAY: return "a list";
    case JSON_STRING: return "text";
    case JSON_INTEGER: return "a number";
    case JSON_REAL: return "a number with a point or exponent";
    case JSON_TRUE:
    case JSON_FALSE: return "true or false";
    case JSON_NULL: break;
    }
    return "null";
}

static enum mr_status refuse_type(const char *path, const char *key, const json_t *value,
                                  const char *wanted, struct error *error)
{
    return error_set(error, MR_MALFORMED, "wrong type: %s: %s is %s; give %s", path, key,
                     type_name(value), wanted);
}

/* Reports a value that is not a number. `at`: index in a list; -1: the value is not in a list. */
static enum mr_status refuse_number(const char *path, const struct sim_key *key,
                                    const json_t *value, int at, const struct quantity_error *wrong,
                                    struct error *error)
{
    char place[60] = "";
    if (at >= 0)
        snprintf(place, sizeof place, "[%d]", at);
    if (json_is_string(value) && quantity_kind_find(key->unit))
        return error_set(error, MR_MALFORMED, "%s: %s: %s%s is \"%s\"; %s", wrong->what, path,
                         key->name, place, json_string_value(value), wrong->advice);
    return error_set(error, MR_MALFORMED, "wrong type: %s: %s%s is %s; give a number%s%s", path,
                     key->name, place, type_name(value), *key->unit ? " in " : "", key->unit);
}

static enum mr_status read_choice(void *field, const struct sim_key *key, const char *path,
                                  const json_t *value, struct error *error)
{
    char names[160] = "";
    for (unsigned i = 0; key->choices[i]; i++) {
        if (json_is_string(value) && strcmp(json_string_value(value), key->choices[i]) == 0) {
            /* valid because each of these enums has the size of an unsigned int */
            memcpy(field, &i, sizeof i);
            return MR_OK;
        }
        if (i > 0)
            /* no overflow is possible, because the names in the table are short */
            strcat(names, ", ");
        strcat(names, key->choices[i]);
    }
    if (json_is_string(value))
        return error_set(error, MR_MALFORMED, "unknown choice: %s: %s is \"%s\"; give one of %s",
                         path, key->name, json_string_value(value), names);
    return error_set(error, MR_MALFORMED, "wrong type: %s: %s; give one of %s, as text", path,
                     key->name, names);
}

static enum mr_status read_list(struct sim_list *list, const struct sim_key *key, const char *path,
                                const json_t *value, struct error *error)
{
    size_t count = json_array_size(value);
    double *values = xcalloc(count + 1, sizeof *values);
    struct quantity_error wrong;
    for (size_t i = 0; i < count; i++) {
        const json_t *entry = json_array_get(value, i);
        if (!read_quantity(key, entry, &values[i], &wrong)) {
            free(values);
            return refuse_number(path, key, entry, (int)i, &wrong, error);
        }
    }
    *list = (struct sim_list){values, count};
    return MR_OK;
}

/* Reads a row [first, last, value], which sets the value of joints, nodes or mats first..last. */
static enum mr_status read_value_row(double *values, size_t count, const struct sim_key *key,
                                     const char *path, size_t at, const json_t *row,
                                     struct error *error)
{
    long long first = json_integer_value(json_array_get(row, 0)),
              last = json_integer_value(json_array_get(row, 1));
    double value;
    struct quantity_error wrong;
    if (json_array_size(row) != 3 || first < 1 || last < first || last > (long long)count)
        return error_set(error, MR_MALFORMED,
                         "not a range: %s: %s[%zu]; give a number, then rows [first, last, value] "
                         "with whole numbers first and last from 1 to %zu",
                         path, key->name, at, count);
    if (!read_quantity(key, json_array_get(row, 2), &value, &wrong))
        return refuse_number(path, key, json_array_get(row, 2), (int)at, &wrong, error);
    for (long long i = first; i <= last; i++)
        values[i - 1] = value;
    return MR_OK;
}

/* Reads values along the runway: a list, or one number for all places and rows for others. */
static enum mr_status read_varied(struct sim_list *list, size_t count, const struct sim_key *key,
                                  const char *path, const json_t *value, struct error *error)
{
    double number;
    struct quantity_error wrong;
    if (!json_is_array(json_array_get(value, 1)))
        return read_list(list, key, path, value, error);
    if (!read_quantity(key, json_array_get(value, 0), &number, &wrong))
        return refuse_number(path, key, json_array_get(value, 0), 0, &wrong, error);
    double *values = xcalloc(count, sizeof *values);
    for (size_t i = 0; i < count; i++)
        values[i] = number;
    for (size_t i = 1; i < json_array_size(value) && error->status == MR_OK; i++)
        read_value_row(values, count, key, path, i, json_array_get(value, i), error);
    *list = (struct sim_list){values, count};
    return error->status;
}

/* Number of values that a list along the runway must have: the number of mats or of joints. */
static size_t varied_list_length(const struct sim_scene *scene, const struct sim_key *key)
{
    bool mats = key->list_offset == SCENE_OFFSET(varied[SIM_VARIED_W]) ||
                key->list_offset == SCENE_OFFSET(varied[SIM_VARIED_V0]);
    return (size_t)scene->mats + !mats;
}

static enum mr_status read_path(struct sim_scene *scene, const char *path, const json_t *value,
                                struct error *error)
{
    size_t count = json_array_size(value);
    scene->path = xcalloc(count + 1, sizeof *scene->path);
    scene->path_count = count;
    for (size_t i = 0; i < count; i++) {
        const json_t *row = json_array_get(value, i);
        static const char *const units[] = {"s", "ft", "lb"};
        struct quantity_error wrong;
        double number[3];
        for (size_t k = 0; k < 3; k++) {
            const json_t *entry = json_array_get(row, k);
            if (json_array_size(row) == 3 && json_is_string(entry) &&
                !quantity_read_json(entry, units[k], &number[k], &wrong))
                return error_set(error, MR_MALFORMED, "%s: %s: path row %zu: \"%s\"; %s",
                                 wrong.what, path, i, json_string_value(entry), wrong.advice);
            if (json_array_size(row) != 3 ||
                !quantity_read_json(entry, units[k], &number[k], &wrong))
                return error_set(
                    error, MR_MALFORMED,
                    "wrong type: %s: row %zu of path; give three numbers, [t_s, x_ft, F_lb]", path,
                    i);
        }
        scene->path[i] = (struct sim_path_row){number[0], number[1], number[2]};
    }
    if (count == 0)
        return error_set(
            error, MR_MALFORMED,
            "list too short: %s: path has no rows; give at least two rows, or leave path out",
            path);
    return MR_OK;
}

/* Reads a number, or text with a unit. */
static enum mr_status read_real(double *field, const struct sim_key *key, const char *path,
                                const json_t *value, struct error *error)
{
    double number;
    struct quantity_error wrong;
    if (!read_quantity(key, value, &number, &wrong))
        return refuse_number(path, key, value, -1, &wrong, error);
    if (key->offset == offsetof(struct sim_scene, t_dwell_s) && number < 0.0)
        return error_set(error, MR_MALFORMED,
                         "value out of range: %s: t_dwell is %g; give 0 or more", path, number);
    *field = number;
    return MR_OK;
}

static enum mr_status read_key(struct sim_scene *scene, const struct sim_key *key, const char *path,
                               const json_t *value, struct error *error)
{
    void *field = (char *)scene + key->offset;
    switch (key->kind) {
    case SIM_KEY_TEXT:
        if (!json_is_string(value))
            return refuse_type(path, key->name, value, "text", error);
        snprintf(field, sizeof scene->name, "%s", json_string_value(value));
        return MR_OK;
    case SIM_KEY_REAL:
        if (key->list_offset && json_array_size(value) > 0) {
            struct sim_list *list = (struct sim_list *)((char *)scene + key->list_offset);
            enum mr_status status = read_varied(list, varied_list_length(scene, key), key, path,
                                                value, error);
            if (status == MR_OK)
                *(double *)field = list->values[0];
            return status;
        }
        return read_real(field, key, path, value, error);
    case SIM_KEY_INTEGER:
        if (!json_is_integer(value))
            return refuse_type(path, key->name, value, "a whole number", error);
        if (llabs(json_integer_value(value)) > 10ll * SIM_MATS_MAX)
            return error_set(error, MR_MALFORMED,
                             "value out of range: %s: %s is %lld; give %g to %g", path, key->name,
                             (long long)json_integer_value(value), key->min, key->max);
        *(int *)field = (int)json_integer_value(value);
        return MR_OK;
    case SIM_KEY_CHOICE: return read_choice(field, key, path, value, error);
    case SIM_KEY_JOINTS:
    case SIM_KEY_PARTS:
        if (json_is_number(value) || json_is_string(value)) {
            double one;
            enum mr_status status = read_real(&one, key, path, value, error);
            if (status == MR_OK)
                sim_scene_set_list(field, &one, 1);
            return status;
        }
        if (!json_is_array(value))
            return refuse_type(path, key->name, value,
                               key->kind == SIM_KEY_JOINTS
                                   ? "a number, or a list with one per joint"
                                   : "a number, or a list with one per part",
                               error);
        if (key->kind == SIM_KEY_JOINTS)
            return read_varied(field, varied_list_length(scene, key), key, path, value, error);
        return read_list(field, key, path, value, error);
    case SIM_KEY_LIST:
        if (!json_is_array(value))
            return refuse_type(path, key->name, value, "a list of numbers", error);
        return read_list(field, key, path, value, error);
    case SIM_KEY_PATH:
        if (!json_is_array(value))
            return refuse_type(path, key->name, value, "a list of rows [t_s, x_ft, F_lb]", error);
        return read_path(scene, path, value, error);
    }
    return MR_OK;
}

/* Reports an unknown key. If only the case is wrong, the error suggests the right spelling. */
static enum mr_status refuse_key(const char *path, const char *name, struct error *error)
{
    for (size_t i = 0; sim_key_at(i); i++) {
        if (strcasecmp(name, sim_key_at(i)->name) == 0)
            return error_set(error, MR_MALFORMED,
                             "unknown key: %s: \"%s\"; write \"%s\", or _%s for a comment", path,
                             name, sim_key_at(i)->name, name);
    }
    return error_set(error, MR_MALFORMED,
                     "unknown key: %s: \"%s\"; correct the key (matrig sim --keys lists the keys), "
                     "or write _%s for a comment",
                     path, name, name);
}

static enum mr_status read_object(struct sim_scene *scene, const char *path, json_t *root,
                                  struct error *error)
{
    const char *name;
    json_t *value;
    if (!json_is_object(root))
        return error_set(error, MR_MALFORMED,
                         "not a scene: %s: the file is not a JSON object; begin with {", path);
    /* list lengths depend on N; the check below refuses an invalid N */
    json_int_t mats = json_integer_value(json_object_get(root, "N"));
    if (mats >= 1 && mats <= SIM_MATS_MAX)
        scene->mats = (int)mats;
    json_object_foreach(root, name, value)
    {
        if (name[0] == '_')
            continue; /* a key for comments */
        const struct sim_key *key = sim_key_find(name);
        if (!key)
            return refuse_key(path, name, error);
        enum mr_status status = read_key(scene, key, path, value, error);
        if (status != MR_OK)
            return status;
    }
    return sim_scene_check(scene, path, error);
}

/* Makes a scene from a parsed JSON value. */
static enum mr_status read_scene(struct sim_scene *scene, const char *path, json_t *root,
                                 const json_error_t *where, struct error *error)
{
    if (!root) {
        if (output_check_file_format(path, "scene", error) != MR_OK)
            return error->status;
        bool cut = json_error_code(where) == json_error_premature_end_of_input;
        return error_set(error, cut ? MR_TRUNCATED : MR_MALFORMED,
                         "%s: %s line %d column %d: %s; correct that line",
                         cut ? "scene ends too early" : "malformed JSON", path, where->line,
                         where->column, where->text);
    }
    sim_scene_from_json(scene, path, root, error);
    json_decref(root);
    return error->status;
}

enum mr_status sim_scene_parse(struct sim_scene *scene, const char *where, const char *text,
                               size_t length, struct error *error)
{
    json_error_t at;
    sim_scene_set_defaults(scene);
    return read_scene(scene, where, json_loadb(text, length, JSON_REJECT_DUPLICATES, &at), &at,
                      error);
}

enum mr_status sim_scene_from_json(struct sim_scene *scene, const char *where, json_t *root,
                                   struct error *error)
{
    sim_scene_set_defaults(scene);
    enum mr_status status = read_object(scene, where, root, error);
    if (status != MR_OK)
        sim_scene_free(scene);
    return status;
}

enum mr_status sim_scene_load(struct sim_scene *scene, const char *path, struct error *error)
{
    json_error_t at;
    FILE *file = fopen(path, "rb");
    sim_scene_set_defaults(scene);
    if (!file)
        return error_set(error, MR_IO, "cannot open scene: %s: %s; check the path", path,
                         strerror(errno));
    json_t *root = json_loadf(file, JSON_REJECT_DUPLICATES, &at);
    int failed = ferror(file) ? errno : 0;
    fclose(file);
    if (failed == 0)
        return read_scene(scene, path, root, &at, error);
    json_decref(root);
    return error_set(error, MR_IO, "cannot read scene: %s: %s; check the path", path,
                     strerror(failed));
}

/* ---- checking a scene ---- */

const char *sim_scene_name(const struct sim_scene *scene)
{
    return scene->name[0] ? scene->name : "scene";
}

const char *sim_model_name(enum sim_model model)
{
    return model_names[model];
}

static enum mr_status check_list_length(const struct sim_list *list, int wanted, const char *key,
                                        const char *part, const char *where, struct error *error)
{
    if (list->count <= 1 || list->count == (size_t)wanted)
        return MR_OK;
    return error_set(
        error, MR_MALFORMED,
        "list of the wrong length: %s: %s has %zu values; give one number or %d, one per %s", where,
        key, list->count, wanted, part);
}

static enum mr_status check_bands(const struct sim_scene *scene, int group, const char *where,
                                  struct error *error)
{
    static const char *const t0_names[] = {"band_T0", "band2_T0"}, *const slip_names[] = {
                                                                       "band_slipped",
                                                                       "band2_slipped"};
    static const char *const prefixes[] = {"band", "band2"};
    const struct sim_bands *b = &scene->mods.band[group];
    int connections = mods_connection_count(scene, group),
        first = mods_nth_place(b->first_mat, b->spacing, 0);
    if (!(b->count > 0.0))
        return MR_OK;
    if (connections == 0)
        return error_set(error, MR_MALFORMED,
                         "bands without rivets: %s: the first riveted mat is %d, but the runway "
                         "has %d mats (%s_first, %s_every); give a smaller number",
                         where, first, scene->mats, prefixes[group], prefixes[group]);
    if (check_list_length(&b->initial_tension_lb, connections + 1, t0_names[group],
                          "segment (riveted mats + 1)", where, error) != MR_OK ||
        check_list_length(&b->slipped_ft, connections, slip_names[group], "riveted mat", where,
                          error) != MR_OK)
        return error->status;
    for (size_t i = 0; i < b->pulled.count; i++) {
        double at = (b->pulled.values[i] - first) / b->spacing;
        if (!(at >= 0.0 && at < connections && at == floor(at)))
            return error_set(error, MR_MALFORMED,
                             "not a riveted mat: %s: %s_pulled[%zu] is %g; rivets are in every "
                             "%dth mat from %d on",
                             where, prefixes[group], i, b->pulled.values[i], b->spacing, first);
    }
    return MR_OK;
}

static enum mr_status mods_check(const struct sim_scene *scene, const char *where,
                                 struct error *error)
{
    const struct sim_mods *m = &scene->mods;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        if (check_bands(scene, g, where, error) != MR_OK)
            return error->status;
    }
    if (m->cleat_every > 0 && check_list_length(&m->cleat_remaining_share, mods_cleat_count(scene),
                                                "cleat_left", "cleated mat", where, error) != MR_OK)
        return error->status;
    for (int k = 0; k < SIM_RESTRAINT_KIND_COUNT; k++) {
        char key[24];
        snprintf(key, sizeof key, "%s_zero", mods_restraint_name(k));
        if (m->restraint[k].spacing > 0 &&
            check_list_length(&m->restraint[k].zero_ft, mods_restraint_count(scene, k), key,
                              "restraint", where, error) != MR_OK)
            return error->status;
        if (m->restraint[k].spacing > 0 && !(m->restraint[k].k_lb_ft > 0.0))
            return error_set(
                error, MR_MALFORMED,
                "no stiffness: %s: %s_every is given without %s_K; give this stiffness", where,
                mods_restraint_name(k), mods_restraint_name(k));
    }
    if (m->stiffener_span_mats > 1 && m->lay_deg > 0.0)
        return error_set(
            error, MR_MALFORMED,
            "stiffeners on a diagonal pattern: %s; give only one of stiff_span and lay_deg", where);
    if (m->lay_deg > 0.0 && !(scene->slack_ft > 0.0) && m->lay_slide_lb == 0.0 && m->lay_mu == 0.0)
        return error_set(error, MR_MALFORMED,
                         "diagonal joints cannot slide: %s: lay_deg is given without lay_slide, "
                         "lay_mu or slack; give at least one of them",
                         where);
    for (size_t i = 0; i < m->torn.count; i++) {
        if (m->torn.values[i] > scene->mats + 1 || m->torn.values[i] != floor(m->torn.values[i]))
            return error_set(error, MR_MALFORMED,
                             "no such joint: %s: torn[%zu] is %g; give a joint from 1 to %d", where,
                             i, m->torn.values[i], scene->mats + 1);
    }
    return MR_OK;
}

static enum mr_status refuse_range(const struct sim_key *key, const char *where, double value,
                                   size_t index, bool listed, struct error *error)
{
    char entry[32] = "";
    if (listed)
        snprintf(entry, sizeof entry, "[%zu]", index);
    if (key->max == SIM_VALUE_MAX && value > key->max)
        return error_set(error, MR_MALFORMED, "value out of range: %s: %s%s is %g; give at most %g",
                         where, key->name, entry, value, key->max);
    if (key->max >= SIM_VALUE_MAX)
        return error_set(error, MR_MALFORMED, "value out of range: %s: %s%s is %g; give %s %g",
                         where, key->name, entry, value,
                         key->excludes_min ? "a number above" : "a finite number from", key->min);
    return error_set(error, MR_MALFORMED, "value out of range: %s: %s%s is %g; give %g to %g",
                     where, key->name, entry, value, key->min, key->max);
}

static bool is_value_allowed(const struct sim_key *key, double value)
{
    return value >= key->min && value <= key->max && !(key->excludes_min && value == key->min);
}

/* Checks the values of a list. If a list has one value per joint or mat, also checks its length. */
static enum mr_status check_list(const struct sim_scene *scene, const struct sim_key *key,
                                 const struct sim_list *list, const char *where,
                                 struct error *error)
{
    size_t wanted = varied_list_length(scene, key);
    for (size_t i = 0; i < list->count; i++) {
        if (!is_value_allowed(key, list->values[i]))
            return refuse_range(key, where, list->values[i], i, true, error);
    }
    if ((key->kind == SIM_KEY_JOINTS || key->list_offset) && list->count > 1 &&
        list->count != wanted)
        return error_set(error, MR_MALFORMED,
                         "list of the wrong length: %s: %s has %zu values; give one number or %zu, "
                         "one per %s",
                         where, key->name, list->count, wanted,
                         wanted > (size_t)scene->mats ? "joint (N + 1)" : "mat (N)");
    return MR_OK;
}

static enum mr_status check_key(const struct sim_scene *scene, const struct sim_key *key,
                                const char *where, struct error *error)
{
    const void *field = (const char *)scene + key->offset;
    double value;
    switch (key->kind) {
    case SIM_KEY_TEXT:
    case SIM_KEY_PATH: return MR_OK;
    case SIM_KEY_CHOICE: {
        unsigned choice;
        size_t count = 0;
        memcpy(&choice, field, sizeof choice);
        while (key->choices[count])
            count++;
        if (choice >= count)
            return error_set(error, MR_MALFORMED, "value out of range: %s: %s is choice %u of %zu",
                             where, key->name, choice, count);
        return MR_OK;
    }
    case SIM_KEY_REAL:
        value = *(const double *)field;
        if (!is_value_allowed(key, value))
            return refuse_range(key, where, value, 0, false, error);
        field = key->list_offset ? (const char *)scene + key->list_offset : NULL;
        return field ? check_list(scene, key, field, where, error) : MR_OK;
    case SIM_KEY_INTEGER:
        value = *(const int *)field;
        return is_value_allowed(key, value) ? MR_OK
                                            : refuse_range(key, where, value, 0, false, error);
    case SIM_KEY_LIST:
    case SIM_KEY_JOINTS:
    case SIM_KEY_PARTS: break;
    }
    return check_list(scene, key, field, where, error);
}

/* True if the ground under the gear has a stiffness. The stiffness is the parameter of a table
 * element, so it is found by the name of its key. */
static bool has_elastic_ground(const struct sim_scene *scene)
{
    const struct sim_key *key = sim_key_find("gear_k_lb_ft");
    return key && *(const double *)((const char *)scene + key->offset) > 0.0;
}

static enum mr_status check_gear(const struct sim_scene *scene, const char *where,
                                 struct error *error)
{
    const struct sim_list *lines = &scene->gear.line_setbacks_ft, *axles = &scene->gear.axle_counts;
    size_t count = lines->count > 0 ? lines->count : 1;
    if (count > SIM_GEAR_LINES_MAX)
        return error_set(error, MR_MALFORMED,
                         "list too long: %s: gear_lines_ft has %zu axle lines; give at most %d",
                         where, count, SIM_GEAR_LINES_MAX);
    if (axles->count > 0 && axles->count != count)
        return error_set(error, MR_MALFORMED,
                         "list of the wrong length: %s: gear_axles has %zu values; give %zu, one "
                         "per axle line",
                         where, axles->count, count);
    if (scene->gear.axle_length_ft > 4.0 * scene->length_ft)
        return error_set(error, MR_MALFORMED,
                         "value out of range: %s: gear_foot_ft is %g; give at most 4 mats, %g ft",
                         where, scene->gear.axle_length_ft, 4.0 * scene->length_ft);
    if ((lines->count > 0 || axles->count > 0) && !has_elastic_ground(scene))
        return error_set(
            error, MR_MALFORMED,
            "axle lines without ground: %s: gear_lines_ft or gear_axles is given without "
            "gear_k_lb_ft; give the stiffness of the ground, or leave the axle lines out",
            where);
    return MR_OK;
}

static enum mr_status check_path(const struct sim_scene *scene, const char *where,
                                 struct error *error)
{
    for (size_t i = 0; i < scene->path_count; i++) {
        const struct sim_path_row *row = &scene->path[i];
        const double numbers[] = {row->t_s, row->x_ft, row->force_lb};
        static const char *const names[] = {"t_s", "x_ft", "F_lb"};
        for (size_t k = 0; k < 3; k++) {
            if (!(fabs(numbers[k]) <= SIM_VALUE_MAX))
                return error_set(error, MR_MALFORMED,
                                 "value out of range: %s: row %zu of path: %s is %g; give %g to %g",
                                 where, i, names[k], numbers[k], -SIM_VALUE_MAX, SIM_VALUE_MAX);
        }
        if (row->t_s < 0.0 || (i > 0 && row->t_s < row[-1].t_s))
            return error_set(error, MR_MALFORMED,
                             "times out of order: %s: row %zu of path is at %.12g s; give rows in "
                             "order of time from 0 s on (equal times: a jump of F)",
                             where, i, row->t_s);
        if (i > 0 && row->t_s == row[-1].t_s && row->x_ft != row[-1].x_ft)
            return error_set(error, MR_MALFORMED,
                             "aircraft jumps: %s: row %zu of path has the time of the previous row "
                             "but a different x; give this row a later time",
                             where, i);
    }
    if (scene->path_count == 1)
        return error_set(error, MR_MALFORMED,
                         "list too short: %s: path has one row; give at least two rows", where);
    return MR_OK;
}

enum mr_status sim_scene_check(const struct sim_scene *scene, const char *where,
                               struct error *error)
{
    const struct sim_key *key;
    for (size_t i = 0; (key = sim_key_at(i)); i++) {
        if (check_key(scene, key, where, error) != MR_OK)
            return error->status;
    }
    if (check_path(scene, where, error) != MR_OK)
        return error->status;
    for (size_t i = 0; i < scene->output_mats.count; i++) {
        double mat = scene->output_mats.values[i];
        if (mat > scene->mats || mat != floor(mat))
            return error_set(
                error, MR_MALFORMED,
                "no such mat: %s: u_mats[%zu] is %g; give a whole number from 1 to %d (N)", where,
                i, mat, scene->mats);
    }
    if (scene->v0_mat > scene->mats)
        return error_set(error, MR_MALFORMED, "no such mat: %s: v0_mat is %d; give at most %d (N)",
                         where, scene->v0_mat, scene->mats);
    if (scene->bump_ft.count > 0 &&
        (size_t)scene->bump_first + scene->bump_ft.count > (size_t)scene->mats + 2)
        return error_set(
            error, MR_MALFORMED,
            "no such node: %s: bump ends at node %zu; give values up to node %d (N + 1)", where,
            (size_t)scene->bump_first + scene->bump_ft.count - 1, scene->mats + 1);
    if (scene->ground_ft.count > 0 && scene->ground_ft.count != (size_t)scene->mats + 1)
        return error_set(
            error, MR_MALFORMED,
            "list of the wrong length: %s: ground has %zu values; give %d, one per node (N + 1)",
            where, scene->ground_ft.count, scene->mats + 1);
    if (mods_check(scene, where, error) != MR_OK || check_gear(scene, where, error) != MR_OK)
        return error->status;
    double end_s = sim_scene_end_s(scene);
    if (!(end_s > 0.0 && end_s <= SIM_VALUE_MAX))
        return error_set(error, MR_MALFORMED, "the scene gives no end of the run: %s; give tend",
                         where);
    if (scene->path_count > 0 && scene->path[0].t_s > SIM_CLOCK_S && !(end_s > scene->path[0].t_s))
        return error_set(error, MR_MALFORMED,
                         "the run ends before it begins: %s: it ends at %.12g s, but the path "
                         "begins at %.12g s; give tend and t_out in the time of the path",
                         where, end_s, scene->path[0].t_s);
    for (size_t i = 0; i < scene->t_out_s.count; i++) {
        if (scene->t_out_s.values[i] > end_s)
            return error_set(error, MR_MALFORMED,
                             "output after the end: %s: t_out[%zu] is %.12g s, but the run ends at "
                             "%.12g s; give a later tend",
                             where, i, scene->t_out_s.values[i], end_s);
    }
    return MR_OK;
}
