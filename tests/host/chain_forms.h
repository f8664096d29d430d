/* Motions of the chain that formulas give: scenes of one or two mats of 160 lb, and where mat 1 is
 * at a time. Units ft, lb, s. */
#ifndef MATRIG_TESTS_HOST_CHAIN_FORMS_H
#define MATRIG_TESTS_HOST_CHAIN_FORMS_H

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "host/sim/elements/element.h"
#include "host/sim/scene/scene.h"

#define FORM_G     32.174
#define FORM_W     160.0
#define FORM_M     (FORM_W / FORM_G)
#define FORM_F     0.5
#define FORM_HOLD  (FORM_F * FORM_W)
#define FORM_TIMES 40
#define FORM_PI    3.14159265358979323846

/* Numbers of one motion; what they are, its `set` and `at` know. */
struct form {
    const char *name;
    void (*set)(const struct form *form, struct sim_scene *scene);
    double (*at)(const struct form *form, double t_s);
    double end_s, a, b, c, d;
};

/* One free mat on dry ground, the wheel standing on it without thrust. */
static inline void form_mat(struct sim_scene *scene)
{
    scene->model = SIM_MODEL_CHAIN;
    scene->mats = 1;
    scene->g_ft_s2 = FORM_G;
    scene->weight_lb = FORM_W;
    scene->cl_lb_s_ft = 0.0;
    scene->left_end = scene->right_end = SIM_END_FREE;
    scene->force_lb = scene->vac_ft_s = scene->v0_ft_s = 0.0;
    scene->start_ft = 1.0;
    scene->friction = FORM_F;
    scene->friction_law = SIM_FRICTION_STICK;
}

/* a: its first speed. It slides v0^2/(2 f g) and rests. */
static inline void form_thrown(const struct form *form, struct sim_scene *scene)
{
    scene->v0_ft_s = form->a;
}

static inline double form_thrown_at(const struct form *form, double t_s)
{
    double slows = FORM_F * FORM_G, slides_s = fmin(t_s, form->a / slows);
    return form->a * slides_s - 0.5 * slows * slides_s * slides_s;
}

/* a: force, from b on, for c. */
static inline void form_pushed(const struct form *form, struct sim_scene *scene)
{
    double begin_s = form->b, end_s = begin_s + form->c;
    const struct sim_path_row rows[] = {{0.0, 1.0, 0.0},         {begin_s, 1.0, 0.0},
                                        {begin_s, 1.0, form->a}, {end_s, 1.0, form->a},
                                        {end_s, 1.0, 0.0},       {form->end_s, 1.0, 0.0}};
    sim_scene_set_path(scene, rows, 6);
}

static inline double form_pushed_at(const struct form *form, double t_s)
{
    double gains = (form->a - FORM_HOLD) / FORM_M, slows = FORM_F * FORM_G;
    double end_s = form->b + form->c, long_s = end_s - form->b; /* as the path's rows round it */
    double pushed_s = fmax(0.0, fmin(long_s, t_s - form->b)), v = gains * pushed_s;
    double after_s = fmax(0.0, fmin(t_s - end_s, v / slows));
    return 0.5 * gains * pushed_s * pushed_s + v * after_s - 0.5 * slows * after_s * after_s;
}

/* Thrust of exactly f W: from rest it stays, at speed a it goes on at that speed. */
static inline void form_at_limit(const struct form *form, struct sim_scene *scene)
{
    scene->force_lb = FORM_HOLD;
    scene->v0_ft_s = form->a;
}

static inline double form_at_limit_at(const struct form *form, double t_s)
{
    return form->a * t_s;
}

/* a: first speed of mat 1, tied by b lb/ft to mat 2, which its friction holds. It stops, and its
 * own friction holds it there. */
static inline void form_tied(const struct form *form, struct sim_scene *scene)
{
    scene->mats = 2;
    scene->v0_ft_s = form->a;
    scene->v0_mat = 1;
    scene->kl_lb_ft = form->b;
}

static inline double form_tied_at(const struct form *form, double t_s)
{
    double w = sqrt(form->b / FORM_M), middle = -FORM_HOLD / form->b;
    double stops_s = atan2(form->a / w, -middle) / w, t = fmin(t_s, stops_s);
    return middle - middle * cos(w * t) + form->a / w * sin(w * t);
}

/* Between walls, without losses: a: stiffness, b: speed, c and d: room to the left and right. */
static inline void form_box(const struct form *form, struct sim_scene *scene)
{
    scene->left_end = scene->right_end = SIM_END_FIXED;
    scene->friction_law = SIM_FRICTION_NONE;
    scene->slack_ft = 1.0;
    scene->kl_lb_ft = form->a;
    scene->v0_ft_s = form->b;
    sim_scene_set_list(&scene->gap0_ft, (double[]){form->c, form->d}, 2);
}

static inline double form_box_at(const struct form *form, double t_s)
{
    double v = form->b, left = form->c, right = form->d, w = sqrt(form->a / FORM_M);
    double touch_s = FORM_PI / w, cross_s = (left + right) / v;
    double t = fmod(t_s, 2.0 * (touch_s + cross_s));
    if (t < right / v)
        return v * t;
    t -= right / v;
    if (t < touch_s)
        return right + v / w * sin(w * t);
    t -= touch_s;
    if (t < cross_s)
        return right - v * t;
    t -= cross_s;
    if (t < touch_s)
        return -left - v / w * sin(w * t);
    return -left + v * (t - touch_s);
}

/* Without friction into a joint with grit, its opening more than it closes: a: speed, b: stiffness,
 * c: grit. The grit gives elastically, is compacted by what speed is left, and gives back. */
static inline void form_grit(const struct form *form, struct sim_scene *scene)
{
    scene->right_end = SIM_END_FIXED;
    scene->friction_law = SIM_FRICTION_NONE;
    scene->slack_ft = 1.0;
    scene->v0_ft_s = form->a;
    scene->kl_lb_ft = form->b;
    sim_scene_set_list(&scene->gap0_ft, (double[]){0.0, 0.9}, 2);
    sim_scene_set_list(&scene->grit_lb, (double[]){0.0, form->c}, 2);
}

static inline double form_grit_at(const struct form *form, double t_s)
{
    double v0 = form->a, w = sqrt(form->b / FORM_M), give = form->c / form->b;
    double slows = form->c / FORM_M, held_s = asin(give * w / v0) / w, v1 = v0 * cos(w * held_s);
    double yields_s = v1 / slows, back_s = 0.5 * FORM_PI / w;
    if (t_s < held_s)
        return v0 / w * sin(w * t_s);
    t_s -= held_s;
    if (t_s < yields_s)
        return give + v1 * t_s - 0.5 * slows * t_s * t_s;
    double top = give + 0.5 * v1 * yields_s;
    t_s -= yields_s;
    if (t_s < back_s)
        return top - give + give * cos(w * t_s);
    return top - give - give * w * (t_s - back_s);
}

/* Under a gear on elastic ground, critically damped: a: thrust, b: stiffness. */
static inline void form_gear(const struct form *form, struct sim_scene *scene)
{
    scene->force_lb = form->a;
    scene->element_values[ELEMENT_gear_ground] = form->b;
    scene->gear.damping = 1.0;
}

static inline double form_gear_at(const struct form *form, double t_s)
{
    double w = sqrt(form->b / FORM_M);
    return form->a / form->b * (1.0 - (1.0 + w * t_s) * exp(-w * t_s));
}

/* The same pushed until d, at rest by then; c: unloading, which the damping makes critical. */
static inline void form_spring_back(const struct form *form, struct sim_scene *scene)
{
    form_gear(form, scene);
    scene->gear.recovered_share = form->c;
    scene->gear.damping = 1.0 / sqrt(form->c);
    scene->force_stop_s = form->d;
}

static inline double form_spring_back_at(const struct form *form, double t_s)
{
    double w = sqrt(form->b / FORM_M), rho = form->c, zeta = 1.0 / sqrt(rho);
    double most = -w * (zeta + sqrt(zeta * zeta - 1.0)), least = w * w / most;
    if (t_s < form->d)
        return form->a / form->b *
               (1.0 - (least * exp(most * t_s) - most * exp(least * t_s)) / (least - most));
    double back = w / sqrt(rho) * (t_s - form->d);
    return form->a / form->b * (1.0 - rho + rho * (1.0 + back) * exp(-back));
}

/* Two mats without friction, mat 1 thrown at a; b: stiffness, c: damper. */
static inline void form_swing(const struct form *form, struct sim_scene *scene)
{
    scene->mats = 2;
    scene->friction_law = SIM_FRICTION_NONE;
    scene->v0_ft_s = form->a;
    scene->v0_mat = 1;
    scene->kl_lb_ft = form->b;
    scene->cl_lb_s_ft = form->c;
}

static inline double form_swing_at(const struct form *form, double t_s)
{
    double d = form->c / FORM_M, w = sqrt(2.0 * form->b / FORM_M - d * d);
    return 0.5 * form->a * (t_s + exp(-d * t_s) * sin(w * t_s) / w);
}

#define FORM_ROW(kind, ...)                               \
    {                                                     \
#kind, form_##kind, form_##kind##_at, __VA_ARGS__ \
    }
/* name, end, a, b, c, d */
static const struct form forms[] = {
    FORM_ROW(thrown, 10.0, 0.5, 0.0, 0.0, 0.0),
    FORM_ROW(thrown, 60.0, 2.0, 0.0, 0.0, 0.0),
    FORM_ROW(thrown, 1000.0, 5.0, 0.0, 0.0, 0.0),
    FORM_ROW(pushed, 1.0, 8000.0, 0.5, 1e-3, 0.0),
    FORM_ROW(pushed, 100.0, 8000.0, 50.0, 1e-3, 0.0),
    FORM_ROW(pushed, 300.0, 4000.0, 150.0, 1e-2, 0.0),
    FORM_ROW(pushed, 1000.0, 8e4, 500.0, 1e-3, 0.0),
    FORM_ROW(pushed, 1001.0, 160.0, 1000.0, 0.1, 0.0),
    FORM_ROW(at_limit, 10.0, 0.0, 0.0, 0.0, 0.0),
    FORM_ROW(at_limit, 10.0, 1.0, 0.0, 0.0, 0.0),
    FORM_ROW(tied, 10.0, 0.2, 100.0, 0.0, 0.0),
    FORM_ROW(box, 24.2274542614587, 40525.02, 0.924017883, 0.18585824, 0.1489985),
    FORM_ROW(box, 1.3, 1e7, 2.5, 0.05, 0.2),
    FORM_ROW(box, 31.7, 3e5, 1.1, 0.1, 0.12),
    FORM_ROW(box, 228.536, 6625439.4, 0.9914744885, 0.192520378, 0.182328463),
    FORM_ROW(grit, 0.2, 3.0, 1e6, 1000.0, 0.0),
    FORM_ROW(gear, 1.0, 60.0, 1e4, 0.0, 0.0),
    FORM_ROW(spring_back, 4.0, 60.0, 1e4, 0.5, 3.0),
    FORM_ROW(swing, 1.0, 2.0, 2e5, 0.0, 0.0),
    FORM_ROW(swing, 1.0, 2.0, 2e5, 150.0, 0.0),
};
#define FORMS (sizeof forms / sizeof forms[0])

static inline void form_scene(const struct form *form, struct sim_scene *scene)
{
    double times[FORM_TIMES];
    sim_scene_set_defaults(scene);
    form_mat(scene);
    scene->t_end_s = form->end_s;
    form->set(form, scene);
    for (int i = 0; i < FORM_TIMES; i++)
        times[i] = form->end_s * (i + 1) / FORM_TIMES;
    sim_scene_set_list(&scene->t_out_s, times, FORM_TIMES);
}

#endif
