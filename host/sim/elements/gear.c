#include "host/sim/elements/gear.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/elementary.h"
#include "host/base/xmalloc.h"
#include "host/sim/elements/element.h"

static double get_ground_stiffness_lb_ft(const struct sim_scene *scene)
{
    return scene->element_values[ELEMENT_gear_ground];
}

struct gear *gear_make(const struct sim_scene *scene)
{
    const struct sim_list *lines = &scene->gear.line_setbacks_ft, *axles = &scene->gear.axle_counts;
    size_t mats = (size_t)scene->mats + 2;
    if (!(get_ground_stiffness_lb_ft(scene) > 0.0))
        return NULL;
    struct gear *gear = xmalloc(sizeof *gear);
    double *storage = xcalloc(3 * mats, sizeof *storage);
    size_t count = lines->count > 0 ? lines->count : 1;
    struct sim_path_row *rows = xcalloc(count * (scene->path_count + 1), sizeof *rows);
    *gear = (struct gear){.scene = scene,
                          .mass_slug = scene->weight_lb / scene->g_ft_s2,
                          .line_count = (int)count,
                          .rows = rows,
                          .storage = storage,
                          .load_share = storage,
                          .touching_axles = storage + mats,
                          .ground_force_lb = storage + 2 * mats};
    for (size_t i = 0; i < count; i++)
        gear->axle_counts[i] = axles->count > 0 ? axles->values[i] : 1.0;
    return gear;
}

void gear_free(struct gear *gear)
{
    if (!gear)
        return;
    free(gear->rows);
    free(gear->storage);
    free(gear);
}

void gear_reset(struct gear *gear, double drift_s)
{
    const struct sim_scene *scene = gear->scene;
    gear->drift_s = drift_s;
    gear->loaded_count = gear->lead_mat = 0;
    memset(gear->storage, 0, 3 * ((size_t)scene->mats + 2) * sizeof *gear->storage);
    for (int i = 0; i < gear->line_count; i++) {
        struct sim_wheel *line = &gear->line[i];
        double behind_ft = scene->gear.line_setbacks_ft.count > 0
                             ? scene->gear.line_setbacks_ft.values[i]
                             : 0.0;
        struct sim_path_row *rows = gear->rows + (size_t)i * scene->path_count;
        sim_wheel_start(line, scene);
        for (size_t r = 0; r < 2; r++)
            line->straight_path[r].x_ft -= behind_ft;
        for (size_t r = 0; r < scene->path_count; r++) {
            rows[r] = scene->path[r];
            rows[r].x_ft -= behind_ft;
        }
        if (scene->path_count > 0)
            line->rows = rows;
    }
}

double gear_stiffness_lb_ft(const struct sim_scene *scene, double touching)
{
    double power = scene->gear.axle_exponent, k_lb_ft = get_ground_stiffness_lb_ft(scene);
    if (touching == 1.0 || power == 0.0)
        return touching > 0.0 ? k_lb_ft : 0.0;
    return k_lb_ft * (power == 1.0 ? touching : elementary_pow(touching, power));
}

void gear_set_touching_axles(struct gear *gear, int mat, double touching)
{
    double before = gear->touching_axles[mat];
    if (touching < before)
        gear->ground_force_lb[mat] *= gear_stiffness_lb_ft(gear->scene, touching) /
                                      gear_stiffness_lb_ft(gear->scene, before);
    gear->touching_axles[mat] = touching;
}

/* Distributes the thrust of one axle, given in `parts`, over the axle's contact length
 * (gear_foot_ft), whose middle is at x_ft. Returns the number of mats that it touches. */
static int distribute_axle_load(const struct gear *gear, double x_ft, struct sim_touch *touch,
                                int parts)
{
    double length_ft = gear->scene->length_ft, foot_ft = gear->scene->gear.axle_length_ft,
           thrust_lb = 0.0;
    double from_ft = x_ft - 0.5 * foot_ft, to_ft = x_ft + 0.5 * foot_ft;
    int count = 0, mats = gear->scene->mats;
    for (int i = 0; i < parts; i++)
        thrust_lb += touch[i].thrust_lb;
    int first = (int)fmax(1.0, floor(from_ft / length_ft) + 1.0);
    for (int n = first; parts > 0 && n <= mats && (n - 1) * length_ft < to_ft; n++) {
        double part = (fmin(to_ft, n * length_ft) - fmax(from_ft, (n - 1) * length_ft)) / foot_ft;
        if (part > 0.0 && count < SIM_WHEEL_TOUCHES_MAX)
            touch[count++] = (struct sim_touch){n, part * thrust_lb, part};
    }
    return count;
}

/* Computes the forces of one axle line on the mats: those of one axle, times the number of
 * axles. */
static int compute_axle_line_action(struct gear *gear, int i, double t0_s, double t1_s,
                                    struct sim_touch *touch)
{
    struct sim_wheel *line = &gear->line[i];
    double x0_ft = line->span_end_ft, foot_ft = gear->scene->gear.axle_length_ft;
    bool follows = line->span_end_s == t0_s;
    int parts = sim_wheel_compute_action(line, t0_s, t1_s, touch);
    if (foot_ft > 0.0)
        parts = distribute_axle_load(
            gear, follows ? 0.5 * (x0_ft + line->span_end_ft) : line->span_end_ft, touch, parts);
    for (int k = 0; k < parts; k++) {
        touch[k].thrust_lb *= gear->axle_counts[i];
        touch[k].load_share *= gear->axle_counts[i];
    }
    return parts;
}

/* A mat under the gear: number of axles that touch it, and the sum of their load shares. */
struct loaded_mat {
    int mat;
    double share, touching;
};

static int add_loaded_mat(struct loaded_mat *loaded_mat, int found, const struct sim_touch *touch,
                          double touching)
{
    int at = 0;
    if (!(touch->load_share > 0.0))
        return found;
    while (at < found && loaded_mat[at].mat != touch->mat)
        at++;
    if (at == found)
        loaded_mat[at] = (struct loaded_mat){touch->mat, 0.0, 0.0};
    loaded_mat[at].share += touch->load_share;
    loaded_mat[at].touching += touching;
    return at == found ? found + 1 : found;
}

static void set_loaded_mats(struct gear *gear, const struct loaded_mat *loaded_mat, int found)
{
    for (int k = 0; k < gear->loaded_count; k++) {
        int at = 0;
        while (at < found && loaded_mat[at].mat != gear->loaded_mats[k])
            at++;
        if (at < found)
            continue;
        gear_set_touching_axles(gear, gear->loaded_mats[k], 0.0);
        gear->load_share[gear->loaded_mats[k]] = 0.0;
    }
    for (int at = 0; at < found; at++) {
        gear_set_touching_axles(gear, loaded_mat[at].mat, loaded_mat[at].touching);
        gear->load_share[loaded_mat[at].mat] = loaded_mat[at].share;
        gear->loaded_mats[at] = loaded_mat[at].mat;
    }
    gear->loaded_count = found;
}

int gear_compute_action(struct gear *gear, double t0_s, double t1_s, struct sim_touch *touch)
{
    struct loaded_mat loaded_mat[SIM_TOUCH_MAX];
    bool foot = gear->scene->gear.axle_length_ft > 0.0;
    int count = 0, found = 0;
    double most = 0.0;
    gear->lead_mat = 0;
    for (int i = 0; i < gear->line_count; i++) {
        int parts = compute_axle_line_action(gear, i, t0_s, t1_s, touch + count);
        for (int k = count; k < count + parts; k++) {
            found = add_loaded_mat(loaded_mat, found, &touch[k],
                                   foot ? gear->axle_counts[i] : touch[k].load_share);
            if (i == 0 && touch[k].load_share > most) {
                most = touch[k].load_share;
                gear->lead_mat = touch[k].mat;
            }
        }
        count += parts;
    }
    set_loaded_mats(gear, loaded_mat, found);
    return count;
}

/* Speed at the end of a step and ground force q at that speed, for one linear piece of the law of
 * the ground, q = at + slope v. */
struct ground_solution {
    double v_ft_s, ground_force_lb;
};

static struct ground_solution solve_ground_branch(double free_ft_s, double step_per_mass,
                                                  double damping, double at_lb,
                                                  double slope_lb_s_ft)
{
    double v = (free_ft_s - step_per_mass * at_lb) /
               (1.0 + damping + step_per_mass * slope_lb_s_ft);
    return (struct ground_solution){v, at_lb + slope_lb_s_ft * v};
}

double gear_solve_mat_speed_ft_s(struct gear *gear, int mat, double v_ft_s, double x_lb,
                                 double limit_lb, double equivalent_s)
{
    double rho = gear->scene->gear.recovered_share,
           k = gear_stiffness_lb_ft(gear->scene, gear->touching_axles[mat]);
    double step_per_mass = equivalent_s / gear->mass_slug;
    double damping = step_per_mass * 2.0 * gear->scene->gear.damping * sqrt(k * gear->mass_slug);
    double load = k * gear->drift_s, q = gear->ground_force_lb[mat];
    /* speed that the mat would have without the ground */
    double free_ft_s = v_ft_s + step_per_mass * x_lb;
    if (fabs(q) > limit_lb)
        q = copysign(limit_lb, q);
    /* q(v) is piecewise linear; the sign of the speed at the present q selects the piece */
    bool loads = (free_ft_s - step_per_mass * q) * q >= 0.0;
    struct ground_solution end = solve_ground_branch(free_ft_s, step_per_mass, damping, q,
                                                     loads ? load : load / rho);
    /* q passes through 0; from there on it increases in the other direction */
    if (!loads && end.ground_force_lb * q < 0.0)
        end = solve_ground_branch(free_ft_s, step_per_mass, damping, rho * q, load);
    if (fabs(end.ground_force_lb) > limit_lb)
        end = solve_ground_branch(free_ft_s, step_per_mass, damping,
                                  copysign(limit_lb, end.ground_force_lb), 0.0);
    gear->ground_force_lb[mat] = end.ground_force_lb;
    return end.v_ft_s;
}

/* Writes the description of the element for the result: the ground under the gear. Its law is in
 * gear.h. */

static void describe(double k, struct sim_result *result)
{
    sim_result_add_note(result, "gear on elastic ground: %g lb/ft per mat with one axle", k);
}

extern const struct element element_gear_ground;
const struct element element_gear_ground = {
    .key = {.name = "gear_k_lb_ft",
            .kind = SIM_KEY_REAL,
            .offset = ELEMENT_FIELD(gear_ground),
            .max = SIM_VALUE_MAX,
            .unit = "lb/ft",
            .meaning =
                "stiffness, along the runway, of the elastic ground under a mat that carries "
                "one axle; 0: Coulomb friction, one axle"},
    .describe = describe,
    .has_memory = true,
};
