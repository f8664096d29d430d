#include "host/sim/elements/mods.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/elements/mods_view.h"
#include "host/sim/scene/result.h"

#define RADIANS (3.14159265358979323846 / 180.0)

/* --- state --- */

static void place_state(struct mods_state *s)
{
    double *at = s->values;
    double **per_segment[] = {&s->band_lb, &s->band_least_lb, &s->band_most_lb};
    double **per_connection[] = {&s->band_slip_ft, &s->band_load_lb, &s->band_out, &s->band_mat};
    double **per_cleat[] = {&s->cleat_left, &s->cleat_mat};
    double **per_joint[] = {&s->stiff_gap_ft, &s->torn, &s->unhinged_s};
    for (size_t i = 0; i < 3; i++, at += s->segments)
        *per_segment[i] = at;
    for (size_t i = 0; i < 4; i++, at += s->connections)
        *per_connection[i] = at;
    for (size_t i = 0; i < 2; i++, at += s->cleats)
        *per_cleat[i] = at;
    for (size_t i = 0; i < 3; i++, at += s->joints + 1)
        *per_joint[i] = at;
    s->count = (size_t)(at - s->values);
}

static struct mods_state *make_state(const struct sim_scene *scene)
{
    size_t connections = 0, segments = 0, cleats = (size_t)mods_cleats(scene),
           joints = (size_t)scene->mats + 1;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        size_t of_group = (size_t)mods_connections(scene, g);
        connections += of_group;
        segments += of_group > 0 ? of_group + 1 : 0;
    }
    size_t count = 3 * segments + 4 * connections + 2 * cleats + 3 * (joints + 1);
    struct mods_state *s = calloc(1, sizeof *s + count * sizeof s->values[0]);
    if (!s)
        return NULL;
    s->segments = segments;
    s->connections = connections;
    s->cleats = cleats;
    s->joints = joints;
    place_state(s);
    return s;
}

struct mods_state *mods_finish(struct mods *m, const struct mods_view *view)
{
    const struct mods_state *from = m->state;
    size_t size = sizeof *from + from->count * sizeof from->values[0];
    if (m->banded)
        mods_pull_bands(m, view, NULL, 0);
    for (size_t i = 0; i < from->segments; i++)
        from->band_lb[i] = m->band_lb[i];
    for (int j = 1; m->stiffened && j <= m->mats + 1; j++)
        from->stiff_gap_ft[j] = m->spring_gap_ft[j];
    struct mods_state *copy = malloc(size);
    if (!copy)
        return NULL;
    memcpy(copy, from, size);
    place_state(copy);
    return copy;
}

double mods_difference_lb(const struct mods_state *a, const struct mods_state *b)
{
    double most = 0.0;
    for (size_t i = 0; i < 3 * a->segments; i++) /* the first three arrays: tension, least, most */
        most = fmax(most, fabs(a->values[i] - b->values[i]));
    return most;
}

/* --- making --- */

static void lay_out(struct mods *m)
{
    size_t joints = (size_t)m->mats + 2;
    double *at = m->storage;
    double **per_joint[] = {&m->spring_lb_ft,     &m->spring_gap_ft, &m->cap_lb, &m->turn_lb_ft_rad,
                            &m->turn_yield_lb_ft, &m->turn_rad,      &m->hull,   &m->raised_ft};
    for (size_t i = 0; i < 8; i++, at += joints)
        *per_joint[i] = at;
    if (m->banded)
        mods_place_bands(m, at);
}

enum mr_status mods_make(struct mods **mods, const struct sim_scene *scene, struct error *error)
{
    const struct sim_mods *s = &scene->mods;
    *mods = NULL;
    if (!mods_any(scene))
        return MR_OK;
    struct mods *m = calloc(1, sizeof *m);
    if (m) {
        *m = (struct mods){
            .scene = scene,
            .banded = s->band[0].count > 0.0 || s->band[1].count > 0.0,
            .cleated = mods_cleats(scene) > 0 && s->cleat_hold_lb > 0.0,
            .stiffened = s->stiff_span > 1,
            .laid = s->lay_deg > 0.0 && (s->lay_slide_lb > 0.0 || s->lay_mu > 0.0),
            .tears = s->tear_lb < HUGE_VAL || s->torn.count > 0 || s->unhinge_deg < HUGE_VAL,
            .mats = scene->mats,
            .cleats = mods_cleats(scene),
            .state = make_state(scene),
        };
        m->jointed = m->stiffened || m->laid || m->tears;
    }
    if (m && m->state) {
        size_t bands = 3 * m->state->segments + 5 * m->state->connections;
        m->storage = calloc(bands + 8 * ((size_t)m->mats + 2), sizeof(double));
    }
    if (!m || !m->state || !m->storage) {
        mods_free(m);
        return error_set(error, MR_FULL, "out of memory: %d mats; use a smaller N", scene->mats);
    }
    lay_out(m);
    mods_reset(m);
    *mods = m;
    return MR_OK;
}

void mods_free(struct mods *m)
{
    if (!m)
        return;
    free(m->state);
    free(m->storage);
    free(m);
}

/* A line ties mats first + k period .. first + k period + span - 1; lines of a strip are staggered
 * evenly. */
static int lines_across(const struct sim_mods *s, int joint)
{
    int period = s->stiff_span - 1 + (s->stiff_free > 0 ? s->stiff_free : 1), lines = 0;
    for (int line = 0; line < s->stiff_lines; line++) {
        /* of the mat on its left */
        int at = joint - 1 - (s->stiff_first + line * period / s->stiff_lines);
        lines += at >= 0 && at % period < s->stiff_span - 1;
    }
    return lines;
}

/* Turn of a joint as the mats lie on the ground. */
static double laid_turn_rad(const struct sim_scene *scene, int joint)
{
    const double *ground_ft = scene->ground_ft.values;
    if (!ground_ft || joint < 2 || joint > scene->mats)
        return 0.0;
    double left = (ground_ft[joint - 2] - ground_ft[joint - 1]) / scene->length_ft;
    double right = (ground_ft[joint - 1] - ground_ft[joint]) / scene->length_ft;
    return asin(right) - asin(left);
}

static void reset_joints(struct mods *m)
{
    const struct sim_mods *s = &m->scene->mods;
    double tangent = tan(s->lay_deg * RADIANS);
    for (int j = 1; j <= m->mats + 1; j++) {
        bool inner = j > 1 && j <= m->mats; /* the ground is not tied to */
        m->spring_gap_ft[j] = sim_scene_joint(&m->scene->gap0_ft, j);
        if (m->stiffened && inner) {
            int lines = lines_across(s, j);
            m->spring_lb_ft[j] = lines * s->stiff_k_lb_ft;
            m->cap_lb[j] = lines > 0 ? lines * s->stiff_grip_lb : 0.0;
            m->turn_lb_ft_rad[j] = lines * s->stiff_kt_lb_ft_rad;
            m->turn_yield_lb_ft[j] = lines > 0 ? lines * s->stiff_yield_lb_ft : 0.0;
            if (s->stiff_gap0_ft.count > 0)
                m->spring_gap_ft[j] = sim_scene_joint(&s->stiff_gap0_ft, j);
        } else if (m->laid && inner) {
            m->spring_lb_ft[j] = m->scene->kl_lb_ft * tangent * tangent;
            m->cap_lb[j] = s->lay_slide_lb * sin(s->lay_deg * RADIANS);
        }
        m->turn_rad[j] = laid_turn_rad(m->scene, j);
        m->state->torn[j] = m->state->unhinged_s[j] = 0.0;
    }
    for (size_t i = 0; i < s->torn.count; i++)
        m->state->torn[(int)s->torn.values[i]] = 1.0;
}

void mods_reset(struct mods *m)
{
    const struct sim_mods *s = &m->scene->mods;
    for (int i = 0; i < m->cleats; i++) {
        m->state->cleat_left[i] = s->cleat_left.count ? sim_scene_joint(&s->cleat_left, i + 1)
                                                      : 1.0;
        m->state->cleat_mat[i] = mods_cleat_mat(m->scene, i);
        m->raised_ft[i] = 0.0;
    }
    if (m->jointed)
        reset_joints(m);
    if (m->banded)
        mods_reset_bands(m);
}

/* --- cleats --- */

int mods_cleat_of(const struct mods *m, int mat)
{
    if (!m->cleated)
        return -1;
    int first = mods_cleat_mat(m->scene, 0), every = m->scene->mods.cleat_every;
    return mat >= first && (mat - first) % every == 0 ? (mat - first) / every : -1;
}

double mods_cleat_lb(const struct mods *m, int mat)
{
    int cleat = mods_cleat_of(m, mat);
    return cleat < 0 ? 0.0 : m->scene->mods.cleat_hold_lb * m->state->cleat_left[cleat];
}

/* The soil behind a cleat that moves gives way, and the cleat bends. */
void mods_wear_cleats(struct mods *m, const struct mods_view *view, double h_s, int first, int last)
{
    const struct sim_mods *s = &m->scene->mods;
    int begin = mods_cleat_mat(m->scene, 0), every = s->cleat_every;
    int from = first > begin ? (first - begin + every - 1) / every : 0;
    for (int i = from; i < m->cleats && begin + i * every <= last; i++) {
        double moved_ft = fabs(view_v_ft_s(view, m->mats, begin + i * every)) * h_s;
        if (moved_ft > 0.0)
            m->state->cleat_left[i] *= exp(-moved_ft / s->cleat_travel_ft);
    }
}

/* --- joints --- */

/* What an elastic-plastic element carries when stretched by `stretch` from `*zero`, which yielding
 * moves. */
static double carried(double stiffness, double cap, double stretch, double *zero)
{
    double load = stiffness * (stretch - *zero);
    if (!(fabs(load) > cap))
        return load;
    load = copysign(cap, load);
    *zero = stretch - load / stiffness;
    return load;
}

void mods_pull_joints(struct mods *m, const struct mods_view *view, int first, int last)
{
    const struct sim_mods *s = &m->scene->mods;
    double tangent = m->laid ? tan(s->lay_deg * RADIANS) : 0.0;
    for (int j = first < 1 ? 1 : first; j <= last && j <= m->mats + 1; j++) {
        double *tension_lb = &view->tension_lb[j - view->joint_offset];
        double own_lb = *tension_lb;
        if (m->tears && own_lb > s->tear_lb)
            m->state->torn[j] = 1.0;
        if (m->tears && m->state->torn[j] != 0.0 && own_lb > 0.0)
            *tension_lb = own_lb = 0.0;
        if (m->spring_lb_ft[j] > 0.0) {
            double g_ft = sim_scene_joint(&m->scene->gap0_ft, j) + view_u_ft(view, m->mats, j) -
                          view_u_ft(view, m->mats, j - 1);
            double cap_lb = m->cap_lb[j] + s->lay_mu * tangent * fabs(own_lb);
            *tension_lb += carried(m->spring_lb_ft[j], cap_lb, g_ft, &m->spring_gap_ft[j]);
        }
    }
}

bool mods_is_torn(const struct mods *m, int joint)
{
    return m->tears && m->state->torn[joint] != 0.0;
}

double mods_moment_lb_ft(struct mods *m, int joint, double turn_rad)
{
    if (!(m->turn_lb_ft_rad[joint] > 0.0))
        return 0.0;
    return carried(m->turn_lb_ft_rad[joint], m->turn_yield_lb_ft[joint], turn_rad,
                   &m->turn_rad[joint]);
}

/* --- the whole --- */

double mods_energy_lb_ft(const struct mods *m, const struct mods_view *view)
{
    double energy = m->banded ? mods_band_energy_lb_ft(m, view) : 0.0;
    for (int j = 2; m->jointed && j <= m->mats; j++) {
        double g_ft = sim_scene_joint(&m->scene->gap0_ft, j) + view_u_ft(view, m->mats, j) -
                      view_u_ft(view, m->mats, j - 1) - m->spring_gap_ft[j];
        energy += 0.5 * m->spring_lb_ft[j] * g_ft * g_ft;
    }
    return energy;
}

double mods_stiffness_lb_ft(const struct mods *m)
{
    double spring = 0.0, bands = 0.0;
    for (int j = 2; m->jointed && j <= m->mats; j++)
        spring = fmax(spring, m->spring_lb_ft[j]);
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        const struct mods_bands *b = &m->band[g];
        double most = 0.0;
        for (int i = 0; i < b->segments - 1; i++)
            most = fmax(most, b->k_lb_ft[i] + b->k_lb_ft[i + 1]);
        bands += most > 0.0 ? 2.0 * b->made->count * most : 0.0;
    }
    return 4.0 * spring + bands;
}

void mods_describe(const struct mods *m, struct sim_result *result)
{
    const struct sim_mods *s = &m->scene->mods;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        const struct mods_bands *b = &m->band[g];
        if (b->segments > 0)
            sim_result_note(result,
                            "bands: %g on the strip, riveted to %d mats, %.4g lb/ft between two",
                            b->made->count, b->segments - 1, b->k_lb_ft[b->segments / 2]);
    }
    if (m->cleated)
        sim_result_note(result, "cleats: %d, each worth %g lb when fresh (a mat's friction: %g lb)",
                        m->cleats, s->cleat_hold_lb, m->scene->friction * m->scene->weight_lb);
    if (m->stiffened)
        sim_result_note(result, "stiffeners: %d line(s) over %d mats each; model %s",
                        s->stiff_lines, s->stiff_span,
                        m->scene->model == SIM_CHAIN ? "chain has their stretch, not their bending"
                                                     : "consistent");
    if (m->laid)
        sim_result_note(result, "joints at %g degrees slide at %g lb + %g of their load",
                        s->lay_deg, s->lay_slide_lb, s->lay_mu);
}
