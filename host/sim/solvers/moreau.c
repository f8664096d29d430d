/* moreau: a time-stepping method for the velocities that solves all switches together with the
 * step, after Moreau (1988) and Jean (1999); V. Acary, B. Brogliato, Numerical Methods for
 * Nonsmooth Dynamical Systems, 2008, chapter 10. No switch is located, so a step can contain any
 * number of them.
 *
 *     M (v1 - v0)/h = force(p_m, v1) + switching laws     p_m = p0 + h (v0 + v1)/4
 *     p1 = p0 + h (v0 + v1)/2
 *
 * The forces of springs are those in the middle of the step, which conserves energy. Dampers and
 * switching laws use the speeds at its end. Newton's method finds v1, with one banded factorisation
 * per iteration. The switches are solved in the same iterations:
 *   - Friction. On a sliding mat the Coulomb limit C acts against its motion. A mat whose
 *     speed would change sign has v1 = 0 and a force of at most C. Mats change between these two
 *     modes until all fit (pivoting).
 *   - Contact, torsion, slack and the apex have the mode of (p_m, v1). If each of on and off
 *     drives a switch to the other mode, the switch gets a share s of its force, 0 < s < 1,
 *     that keeps it at its edge, sigma = 0 (a foot that hovers). s = 0 where sigma < 0, s = 1
 *     where sigma > 0. Projected Gauss-Seidel finds all shares of a step from the effect of
 *     each share on every sigma. */
#include <math.h>
#include <string.h>

#include "host/sim/models/model.h"
#include "host/sim/solvers/stepper.h"

/* largest number of switches that have a share (see above) at the same time */
#define SHARED_SWITCHES_MAX 32
#define SOLVE_ROUNDS_MAX    40
/* Largest number of halvings of a step that does not converge. The last step is accepted even if it
 * does not converge. */
#define STEP_HALVINGS_MAX   5
#define FLIPS_BEFORE_SHARE \
    3 /* number of changes of a switch in one step after which it gets a share */
#define FLIPS_BEFORE_FIXED_SLIDE \
    10 /* number of changes of a mat's mode in one step after which the mode is fixed */
#define GAUSS_SEIDEL_SWEEPS_MAX 100 /* largest number of Gauss-Seidel passes */
/* limit of convergence / largest of the speeds and sqrt(g L) */
#define CONVERGENCE_LIMIT       1e-11
#define CONVERGED_SHARE_CHANGE  1e-9
#define SHARE_DIFFERENCE        1e-4

struct partial_switch {
    struct model_switch id;
    int on_mode, off_mode; /* the two modes of the switch */
    double share, change, sigma;
    double sigma_slopes
        [SHARED_SWITCHES_MAX]; /* derivative of sigma of this switch with respect to each share */
    double *accel; /* accelerations due to this share; later the change of v1 due to it */
};

struct moreau_work {
    double *middle_state;  /* the state (p_m, v1) */
    double *shifted_state; /* the state after a change of one share */
    /* accelerations in the present modes; later those with one switch turned on */
    double *accel;
    double *share_accel[SHARED_SWITCHES_MAX];
    double *mass, *dr_dp, *dr_dv, *dr_dp_on, *dr_dv_on, *dr_dp_off, *dr_dv_off, *lu, *dr_dt,
        *newton_step;
    int *pivot;
    signed char *modes_before,
        *flip_counts; /* modes before an update; number of changes in this step */
    int apex_flip_count;
    struct partial_switch partial_switch[SHARED_SWITCHES_MAX];
    int partial_switch_count;
};

/* Number of modes in the model's mode arrays, contact to lift, which are contiguous in memory. */
static size_t mode_count(const struct model *m)
{
    return (size_t)(m->lift_shear_sign - m->contact) + (size_t)m->mats + 2;
}

static void make(struct stepper *s, double *more)
{
    struct moreau_work *w = s->work;
    size_t size = (size_t)s->model->coordinate_count;
    w->mass = more;
    w->dr_dp = w->mass + MODEL_ROW_LENGTH * size;
    w->dr_dv = w->dr_dp + MODEL_ROW_LENGTH * size;
    w->dr_dp_on = w->dr_dv + MODEL_ROW_LENGTH * size;
    w->dr_dv_on = w->dr_dp_on + MODEL_ROW_LENGTH * size;
    w->dr_dp_off = w->dr_dv_on + MODEL_ROW_LENGTH * size;
    w->dr_dv_off = w->dr_dp_off + MODEL_ROW_LENGTH * size;
    w->lu = w->dr_dv_off + MODEL_ROW_LENGTH * size;
    w->dr_dt = w->lu + BANDED_ROW_LENGTH * size;
    w->newton_step = w->dr_dt + size;
    w->pivot = (int *)(w->newton_step + size);
    w->modes_before = (signed char *)(w->pivot + 2 * size);
    w->flip_counts = w->modes_before + 4 * sizeof(double) * size;
}

static void restart(struct stepper *s)
{
    ((struct moreau_work *)s->work)->partial_switch_count = 0;
}

static signed char *switch_mode(const struct model *m, struct model_switch which)
{
    return which.kind == MODEL_CONTACT ? &m->contact[which.index]
         : which.kind == MODEL_TORSION ? &m->torsion[which.index]
                                       : &m->joint_mode[which.index];
}

/* Sets a mode and updates everything that depends on it, except which mats slide. */
static void set_switch_mode(struct stepper *s, struct model_switch which, int mode, double t_s)
{
    struct model *m = s->model;
    struct moreau_work *w = s->work;
    if (which.kind == MODEL_APEX)
        m->apex_node = mode;
    else
        *switch_mode(m, which) = (signed char)mode;
    if (which.kind != MODEL_CONTACT && which.kind != MODEL_APEX)
        return;
    signed char *slide = w->modes_before + (m->slide_direction - m->contact);
    memcpy(slide, m->slide_direction, (size_t)m->mats);
    model_update_modes(m, t_s, w->middle_state);
    memcpy(m->slide_direction, slide, (size_t)m->mats);
}

static void set_positions(const struct stepper *s, double h, const double *v1, double scale,
                          const double *more, double *at)
{
    int size = s->model->coordinate_count;
    for (int i = 0; i < size; i++) {
        double v = v1[i] + (more ? scale * more[i] : 0.0);
        at[i] = s->z[i] + 0.25 * h * (s->z[size + i] + v);
        at[size + i] = v;
    }
}

static struct partial_switch *find_partial_switch(struct moreau_work *w,
                                                  enum model_switch_kind kind, int index)
{
    for (int k = 0; k < w->partial_switch_count; k++) {
        if (w->partial_switch[k].id.kind == kind && w->partial_switch[k].id.index == index)
            return &w->partial_switch[k];
    }
    return NULL;
}

static void add_partial_switch(struct stepper *s, enum model_switch_kind kind, int index, int on,
                               int off)
{
    struct moreau_work *w = s->work;
    if (w->partial_switch_count < SHARED_SWITCHES_MAX && on != off)
        w->partial_switch[w->partial_switch_count++] = (struct partial_switch){
            .id = {kind, index}, .on_mode = on, .off_mode = off, .share = 0.5};
}

/* Updates the modes from the state `at`. Switches with a share remain off. Returns the number of
 * modes that changed. */
static int update_modes(struct stepper *s, double t_s)
{
    struct model *m = s->model;
    struct moreau_work *w = s->work;
    const struct {
        enum model_switch_kind kind;
        signed char *modes;
    } kinds[] = {
        {MODEL_CONTACT, m->contact}, {MODEL_TORSION, m->torsion}, {MODEL_SLACK, m->joint_mode}};
    int changed = 0, apex = m->apex_node;
    memcpy(w->modes_before, m->contact, mode_count(m));
    model_sample_shape_modes(m, w->middle_state);
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
        signed char *mode = kinds[k].modes, *was = w->modes_before + (mode - m->contact),
                    *flips = w->flip_counts + (mode - m->contact);
        for (int j = 0; j <= m->mats; j++) {
            if (mode[j] == was[j])
                continue;
            if (find_partial_switch(w, kinds[k].kind, j)) {
                mode[j] = was[j];
                continue;
            }
            changed++;
            if (++flips[j] > FLIPS_BEFORE_SHARE && mode[j] * was[j] == 0) {
                add_partial_switch(s, kinds[k].kind, j, mode[j] ? mode[j] : was[j], 0);
                mode[j] = 0;
            }
        }
    }
    /* turn off switches that have a share, which the sampling may have turned on */
    for (int k = 0; k < w->partial_switch_count; k++) {
        if (w->partial_switch[k].id.kind != MODEL_APEX)
            *switch_mode(m, w->partial_switch[k].id) = (signed char)w->partial_switch[k].off_mode;
    }
    if (m->lift_shear != SIM_SHEAR_NONE && m->apex_node != apex && m->lifted_nodes > 0) {
        bool has = false;
        for (int k = 0; k < w->partial_switch_count; k++)
            has = has || w->partial_switch[k].id.kind == MODEL_APEX;
        if (!has && ++w->apex_flip_count > FLIPS_BEFORE_SHARE)
            add_partial_switch(s, MODEL_APEX, m->apex_node, m->apex_node, apex);
        changed += !has;
        if (has || w->apex_flip_count > FLIPS_BEFORE_SHARE)
            m->apex_node = apex;
    }
    if (w->partial_switch_count > 0 && m->lift_shear != SIM_SHEAR_NONE)
        set_switch_mode(s, (struct model_switch){MODEL_APEX, m->apex_node}, m->apex_node, t_s);
    return changed;
}

/* Computes push and friction limit of a mat, including the shares of the switches at its ends. */
static void compute_mat_forces(struct stepper *s, double t_s, int mat, double *push_lb,
                               double *limit_lb)
{
    struct model *m = s->model;
    struct moreau_work *w = s->work;
    *push_lb = model_driving_force_lb(m, t_s, w->middle_state, mat);
    *limit_lb = model_friction_limit_lb(m, w->middle_state, mat);
    double push = *push_lb, limit = *limit_lb;
    for (int k = 0; k < w->partial_switch_count; k++) {
        struct partial_switch *one = &w->partial_switch[k];
        bool beside = one->id.index == mat || one->id.index == mat + 1;
        if (!beside || (one->id.kind != MODEL_CONTACT && one->id.kind != MODEL_SLACK))
            continue;
        *switch_mode(m, one->id) = (signed char)one->on_mode;
        *push_lb += one->share * (model_driving_force_lb(m, t_s, w->middle_state, mat) - push);
        *limit_lb += one->share * (model_friction_limit_lb(m, w->middle_state, mat) - limit);
        *switch_mode(m, one->id) = (signed char)one->off_mode;
    }
}

/* Stops mats whose speed would change sign, and releases mats whose push exceeds their limit.
 * Returns the number of mats that changed. */
static int update_mat_modes(struct stepper *s, double h, double t_s)
{
    struct model *m = s->model;
    struct moreau_work *w = s->work;
    signed char *flips = w->flip_counts + (m->slide_direction - m->contact);
    int changed = 0;
    if (m->friction_law != SIM_FRICTION_STICK)
        return 0;
    for (int n = 0; n < m->mats; n++) {
        double v0 = s->z[m->coordinate_count + 2 * n + 1],
               v1 = w->middle_state[m->coordinate_count + 2 * n + 1];
        signed char way = m->slide_direction[n];
        if (way != 0 && way * v1 < 0.0) {
            m->slide_direction[n] = 0;
        } else if (way == 0) {
            double push, limit;
            compute_mat_forces(s, t_s, n, &push, &limit);
            push += m->mass_slug * v0 / h;
            if (fabs(push) > limit)
                m->slide_direction[n] = push > 0.0 ? 1 : -1;
        }
        if (m->slide_direction[n] == way)
            continue;
        if (flips[n] >= FLIPS_BEFORE_FIXED_SLIDE) {
            m->slide_direction[n] = way;
        } else {
            flips[n]++;
            changed++;
        }
    }
    return changed;
}

/* Does one Newton iteration for v1. Writes the change to w->step, and computes the accelerations
 * due to each share. Returns false if the matrix is singular. */
static bool solve_newton_step(struct stepper *s, double h, double t_s, const double *v1)
{
    struct model *m = s->model;
    struct moreau_work *w = s->work;
    int size = m->coordinate_count;
    double *left = w->shifted_state;
    model_rates(m, t_s, w->middle_state, w->accel);
    for (int i = 0; i < size; i++)
        w->dr_dt[i] = (v1[i] - s->z[size + i]) / h;
    double *slope = w->shifted_state + size; /* dR/dt is not needed here */
    model_linearise(m, t_s, w->middle_state, w->dr_dt, w->mass, w->dr_dp, w->dr_dv, slope);
    memcpy(left, w->accel, (size_t)size * sizeof *left);
    if (w->partial_switch_count > 0) {
        memcpy(w->dr_dp_off, w->dr_dp, (size_t)size * MODEL_ROW_LENGTH * sizeof *w->dr_dp_off);
        memcpy(w->dr_dv_off, w->dr_dv, (size_t)size * MODEL_ROW_LENGTH * sizeof *w->dr_dv_off);
    }
    for (int k = 0; k < w->partial_switch_count; k++) {
        struct partial_switch *one = &w->partial_switch[k];
        one->accel = w->share_accel[k];
        set_switch_mode(s, one->id, one->on_mode, t_s);
        model_rates(m, t_s, w->middle_state, one->accel);
        model_linearise(m, t_s, w->middle_state, w->dr_dt, w->mass, w->dr_dp_on, w->dr_dv_on,
                        slope);
        set_switch_mode(s, one->id, one->off_mode, t_s);
        for (int i = 0; i < size; i++) {
            one->accel[i] -= w->accel[i];
            left[i] += one->share * one->accel[i];
        }
        /* The Jacobian is the sum of the slopes in the present modes and, for each switch with a
         * share, the share times its slope. */
        for (int i = 0; i < size * MODEL_ROW_LENGTH; i++) {
            w->dr_dp[i] += one->share * (w->dr_dp_on[i] - w->dr_dp_off[i]);
            w->dr_dv[i] += one->share * (w->dr_dv_on[i] - w->dr_dv_off[i]);
        }
    }
    for (int i = 0; i < size; i++)
        left[i] -= w->dr_dt[i];
    banded_multiply(size, w->mass, left, w->newton_step);
    banded_combine(size, 1.0 / h, w->mass, -0.25 * h, w->dr_dp, -1.0, w->dr_dv, w->lu);
    for (int n = 0; n < m->mats && m->friction_law == SIM_FRICTION_STICK; n++) {
        if (m->slide_direction[n] == 0) /* the equation of a mat at rest is v1/h = 0 */
            w->newton_step[2 * n + 1] = -v1[2 * n + 1] / h;
    }
    if (!banded_factor(size, w->lu, w->pivot))
        return false;
    banded_solve(size, w->lu, w->pivot, w->newton_step);
    for (int k = 0; k < w->partial_switch_count; k++) {
        double *push = w->partial_switch[k].accel;
        for (int n = 0; n < m->mats && m->friction_law == SIM_FRICTION_STICK; n++)
            push[2 * n + 1] = m->slide_direction[n] == 0 ? 0.0 : push[2 * n + 1];
        banded_multiply(size, w->mass, push, push + size);
        banded_solve(size, w->lu, w->pivot, push + size);
    }
    return true;
}

/* Finds shares with which every sigma satisfies its condition, where sigma is linearised in the
 * shares. Returns the largest change of a share. */
static double solve_shares(struct stepper *s, double h, double t_s, double *v1)
{
    struct model *m = s->model;
    struct moreau_work *w = s->work;
    double most = 0.0;
    set_positions(s, h, v1, 0.0, NULL, w->shifted_state);
    for (int j = 0; j < w->partial_switch_count; j++) {
        w->partial_switch[j].sigma = -model_margin(m, t_s, w->shifted_state,
                                                   w->partial_switch[j].id);
        w->partial_switch[j].change = 0.0;
    }
    for (int k = 0; k < w->partial_switch_count; k++) {
        /* sigma has a kink, so use its slope on the side of 0 */
        double part = copysign(SHARE_DIFFERENCE, w->partial_switch[k].sigma);
        set_positions(s, h, v1, part, w->partial_switch[k].accel + m->coordinate_count,
                      w->shifted_state);
        for (int j = 0; j < w->partial_switch_count; j++)
            w->partial_switch[j].sigma_slopes[k] =
                (-model_margin(m, t_s, w->shifted_state, w->partial_switch[j].id) -
                 w->partial_switch[j].sigma) /
                part;
    }
    for (int sweep = 0; sweep < GAUSS_SEIDEL_SWEEPS_MAX; sweep++) {
        double moved = 0.0;
        for (int j = 0; j < w->partial_switch_count; j++) {
            struct partial_switch *one = &w->partial_switch[j];
            double sigma = one->sigma;
            for (int k = 0; k < w->partial_switch_count; k++)
                sigma += one->sigma_slopes[k] * w->partial_switch[k].change;
            /* a share of 0 or 1 means that the switch is off or on */
            double share = one->share + one->change;
            double to = one->sigma_slopes[j] < 0.0  ? share - sigma / one->sigma_slopes[j]
                      : one->sigma_slopes[j] == 0.0 ? share
                      : sigma > 0.0                 ? 1.0
                                                    : 0.0;
            to = fmin(fmax(to, 0.0), 1.0);
            moved = fmax(moved, fabs(to - share));
            one->change = to - one->share;
        }
        if (moved < 0.1 * CONVERGED_SHARE_CHANGE)
            break;
    }
    for (int k = 0; k < w->partial_switch_count; k++) {
        struct partial_switch *one = &w->partial_switch[k];
        for (int i = 0; i < m->coordinate_count; i++)
            v1[i] += one->change * one->accel[m->coordinate_count + i];
        one->share += one->change;
        most = fmax(most, fabs(one->change));
    }
    return most;
}

/* Solves for v1 (second half of z_new) over a step of h. Returns false if it has not converged
 * after SOLVE_ROUNDS_MAX iterations. */
static bool solve_step(struct stepper *s, double h)
{
    struct model *m = s->model;
    struct moreau_work *w = s->work;
    int size = m->coordinate_count;
    double t_s = s->t_s + 0.5 * h, scale = sqrt(m->scene->g_ft_s2 * m->length_ft);
    double *v1 = s->z_new + size;
    memcpy(v1, s->z + size, (size_t)size * sizeof *v1);
    memset(w->flip_counts, 0, mode_count(m));
    w->apex_flip_count = 0;
    set_positions(s, h, v1, 0.0, NULL, w->middle_state);
    update_modes(s, t_s);
    for (int round = 0; round < SOLVE_ROUNDS_MAX; round++) {
        if (!solve_newton_step(s, h, t_s, v1))
            return false;
        double most = 0.0, speed = scale;
        for (int i = 0; i < size; i++) {
            v1[i] += w->newton_step[i];
            most = fmax(most, fabs(w->newton_step[i]));
            speed = fmax(speed, fabs(v1[i]));
        }
        if (!isfinite(most))
            return false;
        double changed = w->partial_switch_count > 0 ? solve_shares(s, h, t_s, v1) : 0.0;
        set_positions(s, h, v1, 0.0, NULL, w->middle_state);
        int flipped = update_modes(s, t_s);
        flipped += update_mat_modes(s, h, t_s);
        if (flipped == 0 && most <= CONVERGENCE_LIMIT * speed && changed <= CONVERGED_SHARE_CHANGE)
            return true;
    }
    return false;
}

/* Replaces shares of 0 and 1 by the modes off and on. */
static void replace_full_shares(struct stepper *s, double t_s)
{
    struct moreau_work *w = s->work;
    int kept = 0;
    for (int k = 0; k < w->partial_switch_count; k++) {
        struct partial_switch one = w->partial_switch[k];
        if (one.share > 0.0 && one.share < 1.0)
            w->partial_switch[kept++] = one;
        else
            set_switch_mode(s, one.id, one.share > 0.0 ? one.on_mode : one.off_mode, t_s);
    }
    w->partial_switch_count = kept;
}

static bool advance(struct stepper *s, double limit_s)
{
    struct model *m = s->model;
    double h = s->dt_s;
    bool last = s->t_s + h * (1.0 + 1e-9) >= limit_s;
    if (last)
        h = limit_s - s->t_s;
    for (int half = 0; !solve_step(s, h) && half < STEP_HALVINGS_MAX; half++) {
        stepper_reject(s, s->h_s);
        restart(s);
        h *= 0.5;
        last = false;
    }
    for (int i = 0; i < m->coordinate_count; i++)
        s->z_new[i] = s->z[i] +
                      0.5 * h * (s->z[m->coordinate_count + i] + s->z_new[m->coordinate_count + i]);
    s->t_new_s = last ? limit_s : s->t_s + h;
    replace_full_shares(s, s->t_new_s);
    return true;
}

static void interpolate(struct stepper *s, double t_s, int low, int high, double *z)
{
    double h = s->t_new_s - s->t_s, part = (t_s - s->t_s) / h;
    int size = s->model->coordinate_count;
    for (int i = low; i < high; i++) {
        double v0 = s->z[size + i], more = s->z_new[size + i] - v0;
        z[i] = s->z[i] + part * h * (v0 + 0.5 * part * more);
        z[size + i] = v0 + part * more;
    }
}

const struct stepper_kind stepper_moreau = {
    .name = "moreau",
    .samples_switches = true,
    .finds_stops_in_step = true,
    .has_fixed_step = true,
    .description = "Moreau and Jean, fixed step, all events solved within the step",
    .work_bytes = sizeof(struct moreau_work),
    .row_count = 3 + SHARED_SWITCHES_MAX,
    .extra_value_rows = 7 * MODEL_ROW_LENGTH + BANDED_ROW_LENGTH + 12,
    .make = make,
    .restart = restart,
    .advance = advance,
    .interpolate = interpolate,
};
