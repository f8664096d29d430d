/* Element: a force on single mats along the runway that depends on how a mat moves. One file per
 * element and one row in table.h: the scene reads its key, every engine adds its force, and the
 * step limits, the window of mats that are integrated and the Jacobians follow. What a scene does
 * not have costs one test per evaluation of all mats.
 *
 * Laws that every scene needs (law.h) and the modifications with
 * their memory (mods.h) are not in the table: they are inlined, or called, where engines have their
 * loops. law.h says what all of them have in common.
 *
 * An element has no state but its parameter, or it `remembers`: then its row brings its key and its
 * place in the engines' loops, and the memory is a file's beside it. Engines of fixed steps
 * integrate one without state exactly where it is linear in the speed (element_kick), so it sets
 * them no step limit. Units ft, lb, s, slug. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_ELEMENT_H
#define MATRIG_HOST_SIM_ELEMENTS_ELEMENT_H

#include <stdbool.h>
#include <stddef.h>

#include "host/sim/elements/law.h"
#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* The elements: one row each. A row gives the element its place in a scene
 * (sim_scene.element[ELEMENT_name]), its key in scene files, and its part in every engine. */
#define ELEMENT_TABLE(ROW) ROW(ground_damping) ROW(gear_ground)

#define ELEMENT_PLACE(name) ELEMENT_##name,
enum element_place { ELEMENT_TABLE(ELEMENT_PLACE) ELEMENTS };
_Static_assert(ELEMENTS <= SIM_ELEMENTS_MAX, "a scene has room for every element");

/* What an element sees of a mat. */
struct element_mat {
    double v_ft_s;
    bool grounded; /* the soil acts on one of its ends; in model chain always */
};

/* `value` is the element's parameter, above 0. */
struct element {
    struct sim_key key; /* its field is ELEMENT_FIELD(name); 0 is its default and means absent */
    double (*force_lb)(double value, struct element_mat mat); /* downfield positive */
    /* of the force by the mat's speed: Jacobian; never above 0 */
    double (*slope_lb_s_ft)(double value, struct element_mat mat);
    /* largest -slope that any state has: the bound of its rate, times the mass */
    double (*steepest_lb_s_ft)(double value);
    /* most that it pushes a mat at rest with: what eats up the margin by which friction holds the
     * mat. 0: a mat at rest may be left out of a scene */
    double (*push_at_rest_lb)(double value);
    void (*describe)(double value, struct sim_result *result); /* for people */
    /* it has a memory, which a file of its own steps (gear.h): it is in no set and has none of the
     * four above, and engines that choose their steps refuse it */
    bool remembers;
};

#define ELEMENT_FIELD(name) (offsetof(struct sim_scene, element) + ELEMENT_##name * sizeof(double))

/* Those of a scene that do not remember. */
struct element_set {
    int count; /* 0: none, and nothing else is looked at */
    const struct element *at[SIM_ELEMENTS_MAX];
    double value[SIM_ELEMENTS_MAX];
};

struct element_set element_set_of(const struct sim_scene *scene);
/* Sums over a set. */
double element_force_lb(const struct element_set *set, struct element_mat mat);
double element_slope_lb_s_ft(const struct element_set *set, struct element_mat mat);
struct law_bound element_bound(const struct element_set *set, double mass_slug);
/* Whether mats at rest stay so as far as the set goes. */
bool element_rests(const struct element_set *set);
/* Of all that a scene has. */
void element_describe(const struct sim_scene *scene, struct sim_result *result);

/* A step of h_s under forces x that are constant otherwise: first the speed is multiplied by
 * `keep`, then x + push_lb acts for as_if_s. So dry friction over the rest of the step stays exact
 * too: v = keep v + as_if_s/m (x + push_lb), with keep = exp(-k), as_if_s = h (1 - exp(-k))/k, k =
 * -slope h/m; the time that a mat needs to stop and the time left after that transform alike. */
struct element_step {
    double keep, as_if_s, push_lb;
};
struct element_step element_step(const struct element_set *set, struct element_mat mat, double h_s,
                                 double mass_slug);

#endif
