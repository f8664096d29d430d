/* Element: a force on single mats along the runway that depends on the motion of the mat. Each
 * element has one file and one row in the table below. An element needs no other code: the scene
 * reads its key and every engine uses its force and derivatives through the table. Elements that a
 * scene does not use cost one test per evaluation of all mats.
 *
 * Laws that every scene needs (law.h) and the modifications with their memory (mods.h) are not in
 * the table; the engines call or inline them in their loops. law.h describes what all laws have in
 * common.
 *
 * An element has no state except its parameter, unless it has a memory (has_memory). The row of an
 * element with memory has only its key and its position in the engines' loops, and a separate file
 * has the memory. Engines with fixed steps integrate an element without state exactly if it is
 * linear in the speed (element_make_step), so it does not limit their step. Units are ft, lb, s and
 * slug. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_ELEMENT_H
#define MATRIG_HOST_SIM_ELEMENTS_ELEMENT_H

#include <stdbool.h>
#include <stddef.h>

#include "host/sim/elements/law.h"
#include "host/sim/scene/result.h"
#include "host/sim/scene/scene.h"

/* The table of the elements. The row of an element defines its index in a scene
 * (sim_scene.element[ELEMENT_name]), its key in scene files, and its functions. */
#define ELEMENT_TABLE(ROW) ROW(ground_damping) ROW(gear_ground)

#define ELEMENT_INDEX(name) ELEMENT_##name,
enum element_index { ELEMENT_TABLE(ELEMENT_INDEX) ELEMENT_COUNT };
_Static_assert(ELEMENT_COUNT <= SIM_ELEMENTS_MAX, "struct sim_scene has a value for every element");

/* The state of a mat on which an element's force depends. */
struct element_mat {
    double v_ft_s;
    /* the soil supports at least one end of the mat; always true in model chain */
    bool is_grounded;
};

/* Functions of an element. `value` is the parameter of the element and is above 0. */
struct element {
    /* key of the element; its field is ELEMENT_FIELD(name), and the default 0 means absent */
    struct sim_key key;
    /* force on the mat, positive downfield */
    double (*force_lb)(double value, struct element_mat mat);
    /* Derivative of the force with respect to the mat's speed, for the Jacobian; never above 0. */
    double (*slope_lb_s_ft)(double value, struct element_mat mat);
    /* Largest magnitude of the slope in any state. Divided by the mass of a mat it bounds the decay
     * rate. */
    double (*max_slope_lb_s_ft)(double value);
    /* Largest force that the element exerts on a mat at rest, which counts against the limit of
     * friction. 0: mats at rest need not be integrated. */
    double (*max_force_at_rest_lb)(double value);
    /* Adds a description of the element to the result. */
    void (*describe)(double value, struct sim_result *result);
    /* The element has a memory, which a separate file updates in each step (gear.h). It is then not
     * part of an element_set, and the four functions above are NULL. Engines that choose their step
     * size refuse such an element. */
    bool has_memory;
};

#define ELEMENT_FIELD(name) \
    (offsetof(struct sim_scene, element_values) + ELEMENT_##name * sizeof(double))

/* The elements of a scene, except those with a memory. */
struct element_set {
    int count; /* number of elements; if it is 0, the other fields are not used */
    const struct element *element[SIM_ELEMENTS_MAX];
    double value[SIM_ELEMENTS_MAX];
};

struct element_set element_set_from_scene(const struct sim_scene *scene);
/* Sum of the forces of all elements of a set. */
double element_force_lb(const struct element_set *set, struct element_mat mat);
double element_slope_lb_s_ft(const struct element_set *set, struct element_mat mat);
struct law_rate_bound element_rate_bound(const struct element_set *set, double mass_slug);
/* Returns true if mats at rest stay at rest with this set. */
bool element_allows_rest(const struct element_set *set);
/* Adds descriptions of all elements of a scene to the result. */
void element_describe(const struct sim_scene *scene, struct sim_result *result);

/* The factors of a step of h_s in which all other forces x are constant. The speed v is first
 * multiplied by f (speed_factor), then x + push_lb acts for the time T (equivalent_s): the new
 * speed is f v + T/m (x + push_lb), with f = exp(-k), T = h (1 - exp(-k))/k, k = -slope h/m. The
 * same factors apply to the time until a mat stops and to the time after it, so dry friction
 * remains exact. */
struct element_step {
    double speed_factor, equivalent_s, push_lb;
};
struct element_step element_make_step(const struct element_set *set, struct element_mat mat,
                                      double h_s, double mass_slug);

#endif
