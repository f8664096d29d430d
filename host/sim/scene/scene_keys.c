#include "host/sim/scene/scene_keys.h"

#include <math.h>
#include <string.h>

const char *const sim_models[] = {"report", "consistent", "chain", NULL};
static const char *const tad_modes[] = {"deadband", "switched", NULL};
static const char *const profiles[] = {"low", "full", NULL};
static const char *const ends[] = {"free", "fixed", NULL};
static const char *const thrusts[] = {"jump", "linear", NULL};
static const char *const frictions[] = {"stick", "tanh", "sign", "none", NULL};
static const char *const normals[] = {"weight", "soil", NULL};
static const char *const overs[] = {"joints", "rivets", NULL};
static const char *const shears[] = {"rising", "none", "following", "both", NULL};

#define FIELD(field) offsetof(struct sim_scene, field)
#define RANGE(name, field, low, high, above, unit, meaning)                        \
    {                                                                              \
        name, SIM_KEY_REAL, FIELD(field), low, high, above, NULL, unit, meaning, 0 \
    }
#define ANY(name, field, unit, meaning) \
    RANGE(name, field, -SIM_LARGEST, SIM_LARGEST, false, unit, meaning)
#define NOT_NEGATIVE(name, field, unit, meaning) \
    RANGE(name, field, 0.0, SIM_LARGEST, false, unit, meaning)
#define POSITIVE(name, field, unit, meaning) \
    RANGE(name, field, 0.0, SIM_LARGEST, true, unit, meaning)
#define LIMIT(name, field, unit, meaning) \
    RANGE(name, field, 0.0, (double)INFINITY, false, unit, meaning)
#define INTEGER(name, field, low, high, unit, meaning)                                \
    {                                                                                 \
        name, SIM_KEY_INTEGER, FIELD(field), low, high, false, NULL, unit, meaning, 0 \
    }
#define CHOICE(name, field, choices, meaning)                                        \
    {                                                                                \
        name, SIM_KEY_CHOICE, FIELD(field), 0.0, 0.0, false, choices, "", meaning, 0 \
    }
#define LIST(name, field, kind, low, high, unit, meaning)                  \
    {                                                                      \
        name, kind, FIELD(field), low, high, false, NULL, unit, meaning, 0 \
    }

#define BANDS(name, prefix, i)                                                                  \
    NOT_NEGATIVE(name, mods.band[i].count, "", "bands on the strip"),                           \
        POSITIVE(prefix "area", mods.band[i].area_ft2, "ft2", "section of one"),                \
        POSITIVE(prefix "E", mods.band[i].e_lb_ft2, "lb/ft2", "modulus"),                       \
        INTEGER(prefix "every", mods.band[i].every, 1, SIM_MATS_MAX, "mats",                    \
                "from rivet to rivet"),                                                         \
        INTEGER(prefix "first", mods.band[i].first, 0, SIM_MATS_MAX, "mat", "first riveted"),   \
        INTEGER(prefix "last", mods.band[i].last, 0, SIM_MATS_MAX, "mat",                       \
                "last that may be riveted"),                                                    \
        LIST(prefix "T0", mods.band[i].t0_lb, SIM_KEY_PARTS, -SIM_LARGEST, SIM_LARGEST, "lb",   \
             "tension of one at the start"),                                                    \
        RANGE(prefix "K", mods.band[i].k_lb_ft, 0.0, (double)INFINITY, true, "lb/ft",           \
              "spring at either anchor"),                                                       \
        LIMIT(prefix "grip", mods.band[i].grip_lb, "lb", "what a connection holds"),            \
        LIMIT(prefix "pull", mods.band[i].pull_lb, "lb",                                        \
              "force across the mat that pulls a rivet out"),                                   \
        RANGE(prefix "wear", mods.band[i].wear_ft, 0.0, (double)INFINITY, true, "ft",           \
              "slip that wears a hole to nothing"),                                             \
        RANGE(prefix "tilt", mods.band[i].tilt_rad, 0.0, 1.0, false, "rad",                     \
              "how far the wheel turns a riveted mat"),                                         \
        NOT_NEGATIVE(prefix "alpha", mods.band[i].alpha_f, "1/F", "thermal expansion"),         \
        ANY(prefix "dT", mods.band[i].dt_f, "F", "how much warmer than when it had its T0"),    \
        CHOICE(prefix "over", mods.band[i].over, overs, "bears on joints, or on rivets alone"), \
        LIST(prefix "slipped", mods.band[i].slipped_ft, SIM_KEY_PARTS, 0.0, SIM_LARGEST, "ft",  \
             "slid so far, per riveted mat"),                                                   \
        LIST(prefix "pulled", mods.band[i].pulled, SIM_KEY_MATS, 1, SIM_MATS_MAX, "mat",        \
             "whose rivets are out")

static const struct sim_key keys[] = {
    {"name", SIM_KEY_TEXT, FIELD(name), 0.0, 0.0, false, NULL, "", "title", 0},
    CHOICE("model", model, sim_models, "equations: of the report, consistent, or of the chain"),
    INTEGER("N", mats, 1, SIM_MATS_MAX, "", "mats"),
    POSITIVE("L", length_ft, "ft", "length of a mat along the runway"),
    POSITIVE("W", weight_lb, "lb", "weight of a mat"),
    POSITIVE("g", g_ft_s2, "ft/s2", "gravity"),
    POSITIVE("I", inertia_slug_ft2, "slug ft2", "inertia of a mat about its long axis"),
    NOT_NEGATIVE("KV", kv_lb_ft, "lb/ft",
                 "soil under a node (report model) or a mat end (consistent)"),
    NOT_NEGATIVE("CV", cv_lb_s_ft, "lb s/ft", "its damper"),
    POSITIVE("KL", kl_lb_ft, "lb/ft", "joint along the runway"),
    NOT_NEGATIVE("CL", cl_lb_s_ft, "lb s/ft", "its damper"),
    NOT_NEGATIVE("KT", kt_lb_ft_rad, "ft lb/rad", "joint in torsion"),
    NOT_NEGATIVE("CT", ct_lb_ft_s_rad, "ft lb s/rad", "its damper"),
    RANGE("TAD_deg", tad_deg, 0.0, 180.0, false, "deg", "free rotation of a joint"),
    CHOICE("tad_mode", tad_mode, tad_modes, "moment beyond it: from zero, or with a jump"),
    CHOICE("profile", profile, profiles,
           "low drops what turning does to the opening of a joint, full keeps it"),
    NOT_NEGATIVE("slack", slack_ft, "ft", "free play of a joint"),
    CHOICE("left", left, ends, "end of the runway at mat 1, along the runway"),
    CHOICE("right", right, ends, "end at mat N"),
    CHOICE("left_torsion", left_torsion, ends, "end at mat 1, in torsion"),
    CHOICE("right_torsion", right_torsion, ends, "end at mat N"),
    ANY("F", force_lb, "lb", "thrust"),
    NOT_NEGATIVE("Vac", vac_ft_s, "ft/s", "speed of the aircraft"),
    ANY("s0", s0_ft, "ft", "where the aircraft begins"),
    RANGE("F_tstop", force_stop_s, 0.0, (double)INFINITY, false, "s", "end of the thrust"),
    CHOICE("thrust", thrust, thrusts, "on the mat under the wheel, or shared by two"),
    NOT_NEGATIVE("wheel_load", wheel_load_lb, "lb",
                 "on the mat under the wheel: in its friction, and pressing it down in the "
                 "consistent model"),
    NOT_NEGATIVE("f", friction, "", "coefficient of friction"),
    CHOICE("friction", friction_law, frictions, "law of friction"),
    POSITIVE("veps", veps_ft_s, "ft/s", "of friction tanh"),
    CHOICE("friction_normal", friction_normal, normals,
           "what friction is a share of; soil: consistent model"),
    ANY("V", shear_lb, "lb", "report model: lift shear"),
    CHOICE("lift_shear", lift_shear, shears, "report model: which mats it lifts"),
    ANY("Q1", q1_lb, "lb", "report model: vertical force on mat 1"),
    INTEGER("bump_first", bump_first, 1, SIM_MATS_MAX + 1, "node", "where bump begins"),
    LIST("bump", bump_ft, SIM_KEY_LIST, -SIM_LARGEST, SIM_LARGEST, "ft",
         "heights (up) of nodes at the start"),
    ANY("v0", v0_ft_s, "ft/s", "first speed of the mat under the wheel, or of v0_mat"),
    INTEGER("v0_mat", v0_mat, 0, SIM_MATS_MAX, "mat", "0: the mat under the wheel"),
    POSITIVE("mats_crossed", mats_crossed, "mats", "end of the run, at Vac"),
    NOT_NEGATIVE("tend", t_end_s, "s", "end of the run"),
    LIST("t_out", t_out_s, SIM_KEY_LIST, 0.0, SIM_LARGEST, "s", "times shown"),
    LIST("u_mats", u_mats, SIM_KEY_MATS, 1, SIM_MATS_MAX, "mat", "mats shown"),
    LIST("path", path, SIM_KEY_PATH, -SIM_LARGEST, SIM_LARGEST, "s, ft, lb",
         "rows [t, x, F] instead of Vac, s0 and F"),
    LIST("gap0", gap0_ft, SIM_KEY_JOINTS, -SIM_LARGEST, SIM_LARGEST, "ft",
         "opening of each joint at the start"),
    LIST("grit", grit_lb, SIM_KEY_JOINTS, 0.0, SIM_LARGEST, "lb",
         "chain and consistent: compression that an open joint holds"),
    LIST("ground", ground_ft, SIM_KEY_LIST, -SIM_LARGEST, SIM_LARGEST, "ft",
         "consistent: heights (up) on which the nodes rest"),
    RANGE("t_dwell", t_dwell_s, -1.0, SIM_LARGEST, false, "s",
          "end of the run, after the aircraft has gone"),
    BANDS("bands", "band_", 0),
    BANDS("bands2", "band2_", 1),
    INTEGER("cleat_every", mods.cleat_every, 0, SIM_MATS_MAX, "mats", "from cleat to cleat"),
    INTEGER("cleat_first", mods.cleat_first, 0, SIM_MATS_MAX, "mat", "first with a cleat"),
    NOT_NEGATIVE("cleat_hold", mods.cleat_hold_lb, "lb", "hold of a fresh cleat"),
    RANGE("cleat_travel", mods.cleat_travel_ft, 0.0, (double)INFINITY, true, "ft",
          "movement in which the hold falls to 1/e"),
    POSITIVE("cleat_depth", mods.cleat_depth_ft, "ft", "depth of a cleat"),
    RANGE("cleat_power", mods.cleat_power, 0.0, 2.0, false, "",
          "hold of a raised or bent cleat goes with its depth to this power; 0: the older law"),
    RANGE("cleat_spring_deg", mods.cleat_spring_deg, 0.0, 90.0, false, "deg",
          "turn from which a cleat springs back; with cleat_power"),
    LIST("cleat_left", mods.cleat_left, SIM_KEY_PARTS, 0.0, 1.0, "",
         "share of its hold that each cleat still has"),
    INTEGER("stiff_span", mods.stiff_span, 0, SIM_MATS_MAX, "mats", "tied together by a stiffener"),
    INTEGER("stiff_free", mods.stiff_free, 0, SIM_MATS_MAX, "joints",
            "between a stiffener and the next"),
    INTEGER("stiff_lines", mods.stiff_lines, 1, 100, "", "lines of stiffeners"),
    INTEGER("stiff_first", mods.stiff_first, 1, SIM_MATS_MAX, "mat", "first of the first line"),
    NOT_NEGATIVE("stiff_K", mods.stiff_k_lb_ft, "lb/ft", "of one line at a joint"),
    LIMIT("stiff_grip", mods.stiff_grip_lb, "lb", "what it carries at most"),
    NOT_NEGATIVE("stiff_KT", mods.stiff_kt_lb_ft_rad, "ft lb/rad", "of one line in bending"),
    LIMIT("stiff_yield", mods.stiff_yield_lb_ft, "ft lb", "where it stays bent"),
    LIST("stiff_gap0", mods.stiff_gap0_ft, SIM_KEY_JOINTS, -SIM_LARGEST, SIM_LARGEST, "ft",
         "openings at which it pulls nothing"),
    RANGE("lay_deg", mods.lay_deg, 0.0, 80.0, false, "deg", "angle of the diagonal pattern"),
    NOT_NEGATIVE("lay_slide", mods.lay_slide_lb, "lb",
                 "sliding along a diagonal joint without load"),
    RANGE("lay_mu", mods.lay_mu, 0.0, 10.0, false, "", "and by the load on it"),
    RANGE("tear", mods.tear_lb, 0.0, (double)INFINITY, true, "lb",
          "tension at which a joint tears"),
    RANGE("unhinge_deg", mods.unhinge_deg, 0.0, (double)INFINITY, true, "deg",
          "turn downwards at which a joint comes apart; planar"),
    POSITIVE("unhinge_lap", mods.unhinge_lap_ft, "ft",
             "height between ends that came apart from which they pass over each other"),
    NOT_NEGATIVE("gear_damping", gear.damping, "",
                 "of a mat under the gear on elastic ground, share of critical"),
    RANGE("gear_unloading", gear.unloading, 0.0, 1.0, true, "",
          "share of its way that the elastic ground springs back"),
    RANGE("gear_axle_law", gear.axle_law, 0.0, 2.0, false, "",
          "stiffness under a mat grows with its axles to this power"),
    NOT_NEGATIVE("gear_foot_ft", gear.foot_ft, "ft",
                 "length that an axle presses evenly, at most 4 mats; 0: the mat under it"),
    LIST("gear_lines_ft", gear.lines_ft, SIM_KEY_LIST, 0.0, SIM_LARGEST, "ft",
         "axle lines behind the lead axle; none: that one alone"),
    LIST("gear_axles", gear.axles, SIM_KEY_LIST, 0.0, 1e6, "",
         "axles on each line, with a wheel_load and a thrust each"),
    LIST("torn", mods.torn, SIM_KEY_LIST, 1, SIM_MATS_MAX + 1, "joint",
         "joints torn from the start"),
};
#define KEYS (sizeof keys / sizeof keys[0])

const struct sim_key *sim_key_at(size_t i)
{
    return i < KEYS                         ? &keys[i]
         : i - KEYS < sim_element_key_count ? sim_element_keys[i - KEYS]
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
