#include "host/sim/models/model.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/elementary.h"
#include "host/base/xmalloc.h"
#include "host/sim/elements/mods.h"

#define DEG_PER_RAD          (180.0 / 3.14159265358979323846)
#define START_EDGE_TOLERANCE 1e-12

static enum mr_status refuse_feature(const char *what, const char *instead,
                                     const struct sim_scene *scene, struct error *error)
{
    return error_set(error, MR_USAGE, "feature not available in the model: %s: %s in model %s; %s",
                     sim_scene_name(scene), what, sim_model_name(scene->model), instead);
}

static bool has_grit(const struct sim_scene *scene)
{
    for (size_t i = 0; i < scene->grit_lb.count; i++) {
        if (scene->grit_lb.values[i] > 0.0)
            return true;
    }
    return false;
}

static enum mr_status check_scene(const struct sim_scene *scene, bool grit, struct error *error)
{
    bool report = scene->model == SIM_MODEL_REPORT;
    const struct {
        bool is_present;
        const char *what, *models;
    } fixed_only[] = {
        {has_grit(scene), "grit", "chain or consistent"},
        {sim_scene_is_varied(scene), "a list of KV, CV, KL, KT, W or v0, or an end weight",
         "chain or consistent"},
        {mods_are_present(scene), "a modified runway (bands, cleats and others)",
         "chain or consistent"},
        {scene->element_values[ELEMENT_gear_ground] > 0.0, "gear_k_lb_ft", "chain or consistent"},
        {scene->ground_ft.count > 0, "ground", "consistent"},
    };
    for (size_t i = 0; i < sizeof fixed_only / sizeof fixed_only[0] && !grit; i++) {
        if (fixed_only[i].is_present)
            return error_set(error, MR_USAGE,
                             "feature not available in the model: %s: %s%s in model %s; leave the "
                             "feature out, or give %s %s",
                             sim_scene_name(scene), fixed_only[i].what,
                             report ? "" : " with a solver that chooses its step",
                             sim_model_name(scene->model), report ? "model" : "solver",
                             report ? fixed_only[i].models : "staggered");
    }
    if (report && scene->friction_normal == SIM_NORMAL_SOIL &&
        scene->friction_law != SIM_FRICTION_NONE)
        return refuse_feature("friction_normal soil",
                              "give friction_normal weight, or model consistent", scene, error);
    for (size_t i = 1; i < scene->ground_ft.count; i++) {
        if (!(fabs(scene->ground_ft.values[i] - scene->ground_ft.values[i - 1]) <
              0.5 * scene->length_ft))
            return refuse_feature("ground steeper than 30 degrees", "give lower heights", scene,
                                  error);
    }
    if (!report && scene->q1_lb != 0.0)
        return refuse_feature("Q1", "leave Q1 out, or give model report", scene, error);
    if (!report && !(scene->kv_lb_ft > 0.0))
        return refuse_feature("KV 0 (the mats would fall)", "give a stiffness", scene, error);
    double inertia = scene->inertia_slug_ft2;
    if (!(inertia > 0.0))
        return refuse_feature("I 0", "give an inertia", scene, error);
    for (size_t i = 1; i < scene->bump_ft.count; i++) {
        if (!(fabs(scene->bump_ft.values[i] - scene->bump_ft.values[i - 1]) <
              0.99 * scene->length_ft))
            return refuse_feature(
                "a bump that changes by more than 0.99 of a mat's length from one "
                "node to the next",
                "give lower heights", scene, error);
    }
    size_t count = scene->bump_ft.count;
    if (count > 0 && !(fmax(fabs(scene->bump_ft.values[0]),
                            fabs(scene->bump_ft.values[count - 1])) < 0.99 * scene->length_ft))
        return refuse_feature("a bump whose first or last height exceeds 0.99 of a mat's length",
                              "give lower heights", scene, error);
    return MR_OK;
}

/* Number of mats on which a load acts at once through the mass matrix. From mat to mat the effect
 * falls by the ratio (D - sqrt(D^2 - 4 B^2))/(2 |B|), where D is the diagonal element of the matrix
 * and B the element beside it. This gives 12 mats for the mats of the report, and many if I is far
 * above m L^2/4. */
static int compute_load_tail_mats(const struct model *m)
{
    double quarter = 0.25 * m->mass_slug,
           turn = m->inertia_slug_ft2 / (m->length_ft * m->length_ft);
    double diagonal = 2.0 * (quarter + turn), beside = fabs(quarter - turn);
    double ratio = 2.0 * beside / (diagonal + sqrt(diagonal * diagonal - 4.0 * beside * beside));
    if (!m->is_consistent || !(ratio > 0.0))
        return 1;
    double mats = ceil(elementary_log(MODEL_TAIL_RATIO) / elementary_log(ratio));
    return mats < m->mats ? (int)mats : m->mats;
}

enum mr_status model_make(struct model *m, const struct sim_scene *s, bool grit,
                          struct error *error)
{
    size_t nodes = (size_t)s->mats + 1;
    *m = (struct model){
        .scene = s,
        .is_consistent = s->model == SIM_MODEL_CONSISTENT,
        .mats = s->mats,
        .coordinate_count = 2 * s->mats + 1,
        .length_ft = s->length_ft,
        .half_ft = 0.5 * s->length_ft,
        .mass_slug = s->weight_lb / s->g_ft_s2,
        .inertia_slug_ft2 = s->inertia_slug_ft2,
        .weight_lb = s->weight_lb,
        .wheel_load_lb = s->wheel_load_lb,
        .kv_lb_ft = s->kv_lb_ft,
        .cv_lb_s_ft = s->cv_lb_s_ft,
        .kl_lb_ft = s->kl_lb_ft,
        .cl_lb_s_ft = s->cl_lb_s_ft,
        .kt_lb_ft_rad = s->kt_lb_ft_rad,
        .ct_lb_ft_s_rad = s->ct_lb_ft_s_rad,
        .tad_rad = s->tad_deg / DEG_PER_RAD,
        .slack_ft = s->slack_ft,
        .friction_coefficient = s->friction,
        .weight_friction_lb = s->friction * s->weight_lb,
        .veps_ft_s = s->veps_ft_s,
        .lift_shear_lb = s->lift_shear_lb,
        .q1_lb = s->q1_lb,
        .has_full_profile = s->profile == SIM_PROFILE_FULL,
        .has_torsion_jump = s->tad_mode == SIM_TAD_SWITCHED,
        .is_left_free = s->left_end != SIM_END_FIXED,
        .is_right_free = s->right_end != SIM_END_FIXED,
        .has_left_torsion = s->left_torsion == SIM_END_FREE,
        .has_right_torsion = s->right_torsion == SIM_END_FREE,
        .friction_law = s->friction > 0.0 ? s->friction_law : SIM_FRICTION_NONE,
        .elements = element_set_from_scene(s),
        .lift_shear = s->lift_shear_lb == 0.0 || s->model == SIM_MODEL_CONSISTENT ? SIM_SHEAR_NONE
                                                                                  : s->lift_shear,
        .held_node = -1,
        .last_mat = s->mats - 1,
        .rest_y_ft = s->model == SIM_MODEL_CONSISTENT ? 0.5 * s->weight_lb / s->kv_lb_ft : 0.0,
    };
    m->has_soil_normal = m->friction_law != SIM_FRICTION_NONE &&
                         s->friction_normal == SIM_NORMAL_SOIL;
    if (check_scene(s, grit, error) != MR_OK)
        return error->status;
    m->load_tail_mats = compute_load_tail_mats(m);
    m->storage = xcalloc(5 * (nodes + 1), sizeof *m->storage);
    m->contact = xcalloc(5 * (nodes + 1), sizeof *m->contact);
    m->mass_upper = m->storage;
    m->rest_u_ft = m->storage + nodes + 1;
    m->scratch = m->storage + 2 * (nodes + 1);
    m->friction_tanh = m->storage + 4 * (nodes + 1);
    m->torsion = m->contact + nodes + 1;
    m->joint_mode = m->torsion + nodes + 1;
    m->slide_direction = m->joint_mode + nodes + 1;
    m->lift_shear_sign = m->slide_direction + nodes + 1;
    if (span_list_make(&m->spans, s, error) != MR_OK)
        model_free(m);
    return error->status;
}

void model_free(struct model *m)
{
    free(m->storage);
    free(m->contact);
    span_list_free(&m->spans);
    m->storage = NULL;
    m->contact = NULL;
}

void model_start(struct model *m, double *z)
{
    const struct sim_scene *s = m->scene;
    memset(z, 0, 2 * (size_t)m->coordinate_count * sizeof *z);
    m->first_mat = 0;
    m->held_node = -1;
    m->last_mat = m->mats - 1;
    for (int j = 0; j <= m->mats; j++) {
        z[2 * j] = m->rest_y_ft;
        size_t i = (size_t)(j + 1 - s->bump_first);
        if (j + 1 >= s->bump_first && i < s->bump_ft.count)
            z[2 * j] -= s->bump_ft.values[i];
    }
    double x = s->path_count > 0 ? s->path[0].x_ft : s->start_ft;
    double under = floor(x / s->length_ft + START_EDGE_TOLERANCE);
    int mat = s->v0_mat > 0    ? s->v0_mat - 1
            : under < 0.0      ? 0
            : under >= m->mats ? m->mats - 1
                               : (int)under;
    z[m->coordinate_count + 2 * mat + 1] = s->v0_ft_s;
    m->span = m->spans.spans[0];
    m->rest_steps = 0;
    model_sample_modes(m, 0.0, z);
    model_choose_window(m, 0.0, z);
    model_sample_modes(m, 0.0, z);
}

void model_enter_span(struct model *m, size_t at, double *z)
{
    m->span = m->spans.spans[at];
    model_update_window(m, z);
    model_update_modes(m, m->span.t0_s, z);
}

struct element_mat model_element_mat(const struct model *m, const double *z, int n)
{
    return (struct element_mat){z[m->coordinate_count + 2 * n + 1],
                                m->contact[n] || m->contact[n + 1]};
}

/* Adds the forces of the elements. The mass matrices of both models are diagonal along the runway,
 * so each mat can be computed separately. */
static __attribute__((noinline)) void add_elements(const struct model *m, const double *z,
                                                   double *accel)
{
    for (int n = m->first_mat; n <= m->last_mat; n++) {
        if (m->friction_law != SIM_FRICTION_STICK || m->slide_direction[n] != 0)
            accel[2 * n + 1] += element_force_lb(&m->elements, model_element_mat(m, z, n)) /
                                m->mass_slug;
    }
}

void model_rates(struct model *m, double t_s, const double *z, double *accel)
{
    m->evaluations++;
    if (m->is_consistent)
        consistent_rates(m, t_s, z, accel);
    else
        report_rates(m, t_s, z, accel);
    if (m->elements.count > 0)
        add_elements(m, z, accel);
}

double model_lift_ft(const struct model *m, const double *z, int *node_from_1)
{
    int apex = m->first_mat;
    for (int j = m->first_mat; j <= m->last_mat + 1; j++) {
        if (z[2 * j] < z[2 * apex])
            apex = j;
    }
    *node_from_1 = apex + 1;
    return z[2 * apex] < -SOIL_TOUCH_FT ? -z[2 * apex] : 0.0;
}

double model_largest_angle_deg(const struct model *m, const double *z, int *mat_from_1)
{
    double worst = 0.0;
    *mat_from_1 = 1;
    for (int n = m->first_mat; n <= m->last_mat; n++) {
        double s = fabs(z[2 * n + 2] - z[2 * n]);
        if (!(s <= worst)) {
            worst = s;
            *mat_from_1 = n + 1;
        }
    }
    worst /= m->length_ft;
    return worst < 1.0 ? elementary_asin(worst) * DEG_PER_RAD : 90.0;
}

#define POWER_ITERATIONS 300
/* This number of mats is sufficient, because all mats have the same parameters. */
#define RATE_MATS_MAX    64

double model_fastest_rate(struct model *m, const double *z, enum model_rate_kind steps)
{
    int mats = m->mats < RATE_MATS_MAX ? m->mats : RATE_MATS_MAX, last = m->last_mat;
    size_t size = 2 * (size_t)mats + 1, length = (size_t)m->coordinate_count;
    double *work = xcalloc(size * (3 * MODEL_ROW_LENGTH + BANDED_ROW_LENGTH + 5) + length,
                           sizeof *work);
    int *pivot = xcalloc(size, sizeof *pivot);
    /* copy of the modes of contact and torsion */
    signed char *kept = xmalloc(2 * ((size_t)mats + 1));
    double rate = 0.0;
    double *mass = work, *by_p = mass + size * MODEL_ROW_LENGTH,
           *by_v = by_p + size * MODEL_ROW_LENGTH;
    double *lu = by_v + size * MODEL_ROW_LENGTH, *drift = lu + size * BANDED_ROW_LENGTH;
    double *x = drift + size, *accel = x + 4 * size, *y = x + 2 * size;
    size_t nodes = (size_t)mats + 1;
    enum sim_friction law = m->friction_law;
    const double cv = m->cv_lb_s_ft, cl = m->cl_lb_s_ft, ct = m->ct_lb_ft_s_rad,
                 slack_ft = m->slack_ft, tad_rad = m->tad_rad;
    int elements = m->elements.count;
    m->last_mat = mats - 1;
    if (steps == MODEL_RATE_STAGGERED) {
        m->cv_lb_s_ft = 0.0;
        m->elements.count = 0;
    }
    memcpy(kept, m->contact, nodes);
    memcpy(kept + nodes, m->torsion, nodes);
    memset(m->contact, 1, nodes);
    if (steps == MODEL_RATE_SPRINGS_ONLY) {
        m->cv_lb_s_ft = m->cl_lb_s_ft = m->ct_lb_ft_s_rad = m->slack_ft = m->tad_rad = 0.0;
        m->elements.count = 0;
        /* excludes the joints at the ends, which may transmit no moment */
        memset(m->torsion + 1, 1, nodes - 2);
    }
    if (law == SIM_FRICTION_STICK || law == SIM_FRICTION_SIGN)
        /* assume that all mats slide: their friction is then constant */
        m->friction_law = SIM_FRICTION_NONE;
    model_rates(m, m->span.t0_s, z, accel);
    model_linearise(m, m->span.t0_s, z, accel, mass, by_p, by_v, drift);
    memcpy(m->contact, kept, nodes);
    memcpy(m->torsion, kept + nodes, nodes);
    m->friction_law = law;
    m->cv_lb_s_ft = cv;
    m->cl_lb_s_ft = cl;
    m->ct_lb_ft_s_rad = ct;
    m->slack_ft = slack_ft;
    m->tad_rad = tad_rad;
    m->last_mat = last;
    banded_combine((int)size, 1.0, mass, 0.0, by_p, 0.0, by_v, lu);
    if (banded_factor((int)size, lu, pivot)) {
        double growth = 0.0;
        /* the start vector of the power iteration must have a component in every direction */
        for (size_t i = 0; i < 2 * size; i++)
            x[i] = 1.0 + 0.5 * (double)((i * 7919) % 101) / 101.0 - (double)(i % 2);
        for (int k = 0; k < POWER_ITERATIONS; k++) {
            double norm = 0.0;
            /* scale the heights so that both halves of the vector have equal weight */
            banded_multiply((int)size, by_p, x, y + size);
            banded_multiply((int)size, by_v, x + size, y);
            for (size_t i = 0; i < size; i++)
                y[size + i] += y[i];
            banded_solve((int)size, lu, pivot, y + size);
            memcpy(y, x + size, size * sizeof *y);
            for (size_t i = 0; i < size; i++)
                norm = fmax(norm, fabs(y[size + i]));
            double before = 0.0;
            for (size_t i = 0; i < size; i++)
                before = fmax(before, fabs(x[size + i]));
            if (!(norm > 0.0 && before > 0.0 && isfinite(norm)))
                break;
            if (k >= POWER_ITERATIONS / 2)
                growth += elementary_log(norm / before);
            for (size_t i = 0; i < 2 * size; i++)
                x[i] = y[i] / norm;
            rate = k >= POWER_ITERATIONS / 2
                     ? elementary_exp(growth / (k - POWER_ITERATIONS / 2 + 1))
                     : 0.0;
        }
    }
    if (m->elements.count > 0) /* a bound that holds for any state */
        rate = fmax(rate, element_rate_bound(&m->elements, m->mass_slug).damping);
    m->elements.count = elements;
    free(work);
    free(pivot);
    free(kept);
    return rate;
}

void model_describe(const struct model *m, struct sim_result *result)
{
    if (m->friction_law == SIM_FRICTION_NONE)
        sim_result_add_omitted_effect(result, "friction (none)");
    if (m->slack_ft > 0.0 && has_grit(m->scene))
        sim_result_add_note(
            result, "grit: a joint opens freely, but must overcome its grit each time it closes");
    if (m->slack_ft <= 0.0)
        sim_result_add_omitted_effect(result, "slack (0)");
    if (!m->has_full_profile)
        sim_result_add_omitted_effect(result, "shortening of tilted mats (profile low)");
    if (!m->is_consistent && m->lift_shear == SIM_SHEAR_NONE)
        sim_result_add_omitted_effect(result, "lift shear (none)");
    if (m->wheel_load_lb == 0.0)
        sim_result_add_omitted_effect(result, "wheel load (0)");
    if (m->is_consistent && m->scene->lift_shear_lb != 0.0)
        sim_result_add_note(
            result,
            "V has no effect in the model `consistent`: there, mats lift because of their inertia");
    if (m->scene->path_count > 0)
        sim_result_add_note(result, "path replaces Vac, s0 and F");
    element_describe(m->scene, result);
}

/* Update of the window, the range of mats that are integrated. PLANAR.md, "Active window".
 *
 * A mat outside the window is flat and at rest, and its displacement is constant. Omitting it is
 * exact if the laws keep it at rest: exact sticking holds a mat until the push exceeds its limit,
 * and the report's equations give a flat mat no moment until the free rotation of a joint is
 * exceeded or the lift shear acts on it. At that moment the window grows. With other laws, every
 * mat moves at once, by an amount that decreases faster than exponentially with the distance. The
 * window then grows while any of its GUARD_MATS outermost mats moves by more than
 * REST_TOLERANCE. */

#define GUARD_MATS             4
#define WINDOW_GROWTH_MATS_MIN 8 /* smallest number of mats by which the window grows */
/* limit of rest, times L for heights, times sqrt(g L) for speeds */
#define REST_TOLERANCE         1e-13
/* number of steps between attempts to make the window smaller */
#define STEPS_PER_SHRINK       16
/* The window is made smaller only by at least this number of mats, because it requires a restart of
 * the stepper. */
#define MIN_SHRINK_MATS        4

static bool is_sticking_exact(const struct model *m)
{
    return m->friction_law == SIM_FRICTION_STICK &&
           (m->elements.count == 0 || element_allows_rest(&m->elements));
}

/* True if flat mats stay flat until a switch, as in the report model. */
static bool are_flat_mats_stable(const struct model *m)
{
    return !m->is_consistent &&
           (m->tad_rad > 0.0 || (m->kt_lb_ft_rad == 0.0 && m->ct_lb_ft_s_rad == 0.0));
}

/* Number of mats by which the window grows. In the consistent model a load acts at once on all mats
 * that the mass matrix couples. */
static int window_growth_mats(const struct model *m)
{
    return m->load_tail_mats > GUARD_MATS + WINDOW_GROWTH_MATS_MIN ? m->load_tail_mats - GUARD_MATS
                                                                   : WINDOW_GROWTH_MATS_MIN;
}

static double rest_height_limit_ft(const struct model *m)
{
    return REST_TOLERANCE * m->length_ft;
}

static double rest_speed_limit_ft_s(const struct model *m)
{
    return REST_TOLERANCE * sqrt(m->scene->g_ft_s2 * m->length_ft);
}

/* True if a mat is as flat as a mat outside the window. */
static bool is_mat_flat(const struct model *m, const double *z, int n)
{
    const double *v = z + m->coordinate_count;
    if (are_flat_mats_stable(m))
        return z[2 * n] == z[2 * n + 2] && v[2 * n] == v[2 * n + 2];
    if (!m->is_consistent)
        return fabs(z[2 * n + 2] - z[2 * n]) <= rest_height_limit_ft(m) &&
               fabs(v[2 * n + 2] - v[2 * n]) <= rest_speed_limit_ft_s(m);
    return fabs(z[2 * n] - m->rest_y_ft) <= rest_height_limit_ft(m) &&
           fabs(z[2 * n + 2] - m->rest_y_ft) <= rest_height_limit_ft(m) &&
           fabs(v[2 * n]) <= rest_speed_limit_ft_s(m) &&
           fabs(v[2 * n + 2]) <= rest_speed_limit_ft_s(m);
}

static bool is_mat_at_rest(const struct model *m, const double *z, int n)
{
    double v = z[m->coordinate_count + 2 * n + 1];
    return is_sticking_exact(m) ? v == 0.0 && m->slide_direction[n] == 0
                                : fabs(v) <= rest_speed_limit_ft_s(m);
}

/* Finds the range of mats that the aircraft touches in this span. Returns false if there are
 * none. */
static bool find_loaded_mats(const struct model *m, int *low, int *high)
{
    const struct span *span = &m->span;
    if (span->mat < 0)
        return false;
    *low = *high = span->mat;
    if (span->first_sharing_mat != -2) {
        *low = span->first_sharing_mat < *low ? span->first_sharing_mat : *low;
        *high = span->first_sharing_mat + 1 > *high ? span->first_sharing_mat + 1 : *high;
    }
    int more = m->is_consistent     ? (m->wheel_load_lb > 0.0 ? m->load_tail_mats : GUARD_MATS)
             : is_sticking_exact(m) ? 0
                                    : 1;
    *low -= more;
    *high += more;
    return true;
}

static void clip_to_runway(const struct model *m, int *first, int *last)
{
    if (*first < 0)
        *first = 0;
    if (*last > m->mats - 1)
        *last = m->mats - 1;
}

void model_fill_outside_window(const struct model *m, double *z)
{
    double *v = z + m->coordinate_count;
    for (int n = 0; n < m->mats; n++) {
        if (n >= m->first_mat && n <= m->last_mat)
            continue;
        int edge = n < m->first_mat ? m->first_mat : m->last_mat + 1,
            node = n < m->first_mat ? n : n + 1;
        z[2 * n + 1] = m->rest_u_ft[n];
        v[2 * n + 1] = 0.0;
        z[2 * node] = m->is_consistent ? m->rest_y_ft : z[2 * edge];
        v[2 * node] = m->is_consistent ? 0.0 : v[2 * edge];
    }
}

static void widen_window(struct model *m, double *z, int first, int last)
{
    int was_first = m->first_mat, was_last = m->last_mat;
    clip_to_runway(m, &first, &last);
    for (int n = first; n <= last; n++) {
        if (n >= was_first && n <= was_last)
            continue;
        int edge = n < was_first ? was_first : was_last + 1, node = n < was_first ? n : n + 1;
        int joint = n < was_first ? n : n + 1;
        z[2 * n + 1] = m->rest_u_ft[n];
        z[m->coordinate_count + 2 * n + 1] = 0.0;
        z[2 * node] = m->is_consistent ? m->rest_y_ft : z[2 * edge];
        z[m->coordinate_count + 2 * node] = m->is_consistent ? 0.0
                                                             : z[m->coordinate_count + 2 * edge];
        m->contact[node] = m->is_consistent ? 1 : m->contact[edge];
        m->torsion[joint] = !(m->tad_rad > 0.0) &&
                            (m->kt_lb_ft_rad > 0.0 || m->ct_lb_ft_s_rad > 0.0) &&
                            !(joint == m->mats && m->has_right_torsion) &&
                            !(joint == 0 && m->has_left_torsion);
        m->lift_shear_sign[n] = 0;
    }
    m->first_mat = first;
    m->last_mat = last;
}

static void narrow_window(struct model *m, double *z, int first, int last)
{
    for (int n = m->first_mat; n <= m->last_mat; n++) {
        if (n < first || n > last)
            m->rest_u_ft[n] = z[2 * n + 1];
    }
    m->first_mat = first;
    m->last_mat = last;
    if (m->is_consistent) { /* the outermost nodes are held at rest */
        for (int node = first; node <= last + 1; node += last + 1 - first) {
            if ((node == first && first > 0) || (node == last + 1 && last < m->mats - 1)) {
                z[2 * node] = m->rest_y_ft;
                z[m->coordinate_count + 2 * node] = 0.0;
            }
        }
    }
}

/* Finds the range that the window must have, from the motion at its edges. */
static void find_required_window(const struct model *m, const double *z, int *first, int *last)
{
    int low, high;
    *first = m->first_mat;
    *last = m->last_mat;
    if (find_loaded_mats(m, &low, &high)) {
        *first = low < *first ? low : *first;
        *last = high > *last ? high : *last;
    }
    if (m->first_mat > 0) {
        if (m->slide_direction[m->first_mat - 1] != 0 ||
            (are_flat_mats_stable(m) && m->torsion[m->first_mat] != 0))
            *first = m->first_mat - 1 < *first ? m->first_mat - 1 : *first;
        if (!m->is_consistent && !m->contact[m->first_mat])
            *first = 0; /* the highest node can be any node up to m->first */
    }
    if (m->last_mat < m->mats - 1) {
        if (m->slide_direction[m->last_mat + 1] != 0 ||
            (are_flat_mats_stable(m) && m->torsion[m->last_mat + 1] != 0))
            *last = m->last_mat + 1 > *last ? m->last_mat + 1 : *last;
        if (m->lift_shear != SIM_SHEAR_NONE && m->lifted_nodes > 0 && m->apex_node + 1 > *last)
            *last = m->apex_node + 1;
    }
    if (is_sticking_exact(m) && are_flat_mats_stable(m))
        return;
    for (int k = 0; k < GUARD_MATS && m->first_mat > 0; k++) {
        int n = m->first_mat + k;
        if (n <= m->last_mat && ((!is_sticking_exact(m) && !is_mat_at_rest(m, z, n)) ||
                                 (!are_flat_mats_stable(m) && !is_mat_flat(m, z, n))))
            *first = m->first_mat - window_growth_mats(m) < *first
                       ? m->first_mat - window_growth_mats(m)
                       : *first;
    }
    for (int k = 0; k < GUARD_MATS && m->last_mat < m->mats - 1; k++) {
        int n = m->last_mat - k;
        if (n >= m->first_mat && ((!is_sticking_exact(m) && !is_mat_at_rest(m, z, n)) ||
                                  (!are_flat_mats_stable(m) && !is_mat_flat(m, z, n))))
            *last = m->last_mat + window_growth_mats(m) > *last
                      ? m->last_mat + window_growth_mats(m)
                      : *last;
    }
}

/* Returns the number of mats that can leave the window at one end: the mats at rest, minus a
 * margin. */
static int count_removable_mats(const struct model *m, const double *z, bool at_first)
{
    int count = 0, low = 0, high = 0;
    bool any = find_loaded_mats(m, &low, &high);
    for (; count < m->last_mat - m->first_mat; count++) {
        int n = at_first ? m->first_mat + count : m->last_mat - count;
        if ((any && n >= low && n <= high) || !is_mat_at_rest(m, z, n) || !is_mat_flat(m, z, n) ||
            (are_flat_mats_stable(m) &&
             (m->torsion[n] || m->torsion[n + 1] || !m->contact[n] || !m->contact[n + 1])))
            break;
    }
    if (!at_first && m->lift_shear != SIM_SHEAR_NONE && m->lifted_nodes > 0 &&
        m->last_mat - count < m->apex_node + 1)
        count = m->last_mat - m->apex_node - 1;
    return count - (is_sticking_exact(m) && are_flat_mats_stable(m) ? 1 : window_growth_mats(m));
}

bool model_update_window(struct model *m, double *z)
{
    int first, last;
    if (!m->can_omit_mats)
        return false;
    find_required_window(m, z, &first, &last);
    clip_to_runway(m, &first, &last);
    if (first != m->first_mat || last != m->last_mat) {
        widen_window(m, z, first, last);
        return true;
    }
    if (++m->rest_steps < STEPS_PER_SHRINK)
        return false;
    m->rest_steps = 0;
    int at_first = count_removable_mats(m, z, true), at_last = count_removable_mats(m, z, false);
    at_first = at_first >= MIN_SHRINK_MATS ? at_first : 0;
    at_last = at_last >= MIN_SHRINK_MATS ? at_last : 0;
    if (at_first + at_last == 0 || at_first + at_last > m->last_mat - m->first_mat)
        return false;
    narrow_window(m, z, m->first_mat + at_first, m->last_mat - at_last);
    return true;
}

void model_choose_window(struct model *m, double t_s, const double *z)
{
    int first = m->mats, last = -1, low, high;
    if (!m->can_omit_mats)
        return;
    for (int n = 0; n < m->mats; n++) {
        bool pushed = is_sticking_exact(m) ? m->slide_direction[n] != 0
                                           : model_driving_force_lb(m, t_s, z, n) != 0.0;
        m->rest_u_ft[n] = z[2 * n + 1];
        if (pushed || !is_mat_at_rest(m, z, n) || !is_mat_flat(m, z, n) ||
            (!m->is_consistent && (!m->contact[n] || !m->contact[n + 1]))) {
            first = n < first ? n : first;
            last = n;
        }
    }
    if (find_loaded_mats(m, &low, &high)) {
        first = low < first ? low : first;
        last = high > last ? high : last;
    }
    if (last < 0)
        first = last = 0;
    if (!is_sticking_exact(m) || !are_flat_mats_stable(m)) {
        first -= window_growth_mats(m);
        last += window_growth_mats(m);
    }
    clip_to_runway(m, &first, &last);
    m->first_mat = first;
    m->last_mat = last;
}
