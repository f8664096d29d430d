/* Bands: MODIFICATIONS.md, "Bands". All bands of the strip are alike; tensions are those of one. */
#include <math.h>

#include "host/sim/mods_view.h"

#define SWEEPS 200       /* of slip through the connections until nothing moves any more, at the start */
#define SETTLED 1e-12    /* of the stiffness' reach: less slip than that is none */

static int left_mat(const struct mods *m, int segment)
{
    return segment > 0 ? m->mat[segment - 1] : 0;
}

static int right_mat(const struct mods *m, int segment)
{
    return segment < m->segments - 1 ? m->mat[segment] : m->mats + 1;
}

double mods_band_raw_lb(const struct mods *m, const struct mods_view *view, int segment)
{
    double longer_ft = view_u_ft(view, m->mats, right_mat(m, segment)) - view_u_ft(view, m->mats, left_mat(m, segment));
    return m->k_lb_ft[segment] * (m->stretch_ft[segment] + longer_ft);
}

static double taut_lb(double raw_lb)
{
    return raw_lb > 0.0 ? raw_lb : 0.0;
}

static double grip_lb(const struct mods *m, int connection)
{
    return m->state->band_out[connection] != 0.0 ? 0.0 : m->scene->mods.band_grip_lb;
}

/* What has to go from segment `from` to segment `to`, ft, so that from - to = grip: the band slides through. A slack
 * segment takes up length before it pulls. */
static double slid_ft(const struct mods *m, int from, int to, double grip)
{
    double a = m->band_lb[from], b = m->band_lb[to];
    double ka = m->k_lb_ft[from], kb = m->k_lb_ft[to];
    double to_limit_ft = (a - grip) / ka; /* while the other stays slack */
    return b + kb * to_limit_ft <= 0.0 ? to_limit_ft : (a - b - grip) / (ka + kb);
}

/* One connection; returns the slip. */
static double slide(struct mods *m, int c)
{
    double grip = grip_lb(m, c);
    double difference = taut_lb(m->band_lb[c + 1]) - taut_lb(m->band_lb[c]);
    if (!(fabs(difference) > grip))
        return 0.0;
    int from = difference > 0.0 ? c + 1 : c, to = difference > 0.0 ? c : c + 1;
    double s = slid_ft(m, from, to, grip);
    m->stretch_ft[from] -= s;
    m->stretch_ft[to] += s;
    m->band_lb[from] -= m->k_lb_ft[from] * s;
    m->band_lb[to] += m->k_lb_ft[to] * s;
    m->state->band_slip_ft[c] += s;
    return s;
}

/* Slip at one connection loads the next: there and back, until nothing slides any more. */
static void slide_all(struct mods *m)
{
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double most_ft = 0.0;
        for (int i = 0; i < m->segments - 1; i++)
            most_ft = fmax(most_ft, slide(m, sweep % 2 ? m->segments - 2 - i : i));
        if (!(most_ft > SETTLED * m->scene->length_ft))
            return;
    }
}

/* The wheel turns a riveted mat by band_tilt against the band on both sides: the rivets feel a part across the mat. A
 * hole that slip has worn holds less. */
static void pull_rivets(struct mods *m, const struct sim_touch *touch, int count)
{
    const struct sim_mods *s = &m->scene->mods;
    int first = m->mat[0], every = s->band_every;
    for (int i = 0; i < count; i++) {
        int c = (touch[i].mat - first) / every;
        if (touch[i].mat < first || (touch[i].mat - first) % every != 0 || c >= m->segments - 1)
            continue;
        double across_lb = s->band_tilt_rad * (taut_lb(m->band_lb[c]) + taut_lb(m->band_lb[c + 1]));
        double worn = m->state->band_slip_ft[c] / s->band_wear_ft;
        if (across_lb > s->band_pull_lb * (worn < 1.0 ? 1.0 - worn : 0.0))
            m->state->band_out[c] = 1.0;
    }
}

static void note_extremes(struct mods *m)
{
    struct mods_state *s = m->state;
    for (int i = 0; i < m->segments; i++) {
        s->band_least_lb[i] = m->band_lb[i] < s->band_least_lb[i] ? m->band_lb[i] : s->band_least_lb[i];
        s->band_most_lb[i] = m->band_lb[i] > s->band_most_lb[i] ? m->band_lb[i] : s->band_most_lb[i];
    }
    for (int c = 0; c < m->segments - 1; c++) {
        double carried_lb = taut_lb(m->band_lb[c + 1]) - taut_lb(m->band_lb[c]);
        if (fabs(carried_lb) > s->band_load_lb[c])
            s->band_load_lb[c] = fabs(carried_lb);
        m->carried_lb[c] = m->scene->mods.bands * carried_lb;
    }
}

void mods_pull_bands(struct mods *m, const struct mods_view *view, const struct sim_touch *touch, int count)
{
    for (int i = 0; i < m->segments; i++)
        m->band_lb[i] = mods_band_raw_lb(m, view, i);
    if (m->scene->mods.band_pull_lb < HUGE_VAL)
        pull_rivets(m, touch, count);
    slide_all(m);
    note_extremes(m);
}

/* A segment's ends are the middles of its mats; the outer ones end at the springs of the anchors, at the runway's ends. */
void mods_reset_bands(struct mods *m)
{
    const struct sim_scene *scene = m->scene;
    const struct sim_mods *s = &scene->mods;
    double ea_lb = s->band_area_ft2 * s->band_e_lb_ft2;
    for (int c = 0; c < m->segments - 1; c++) {
        m->state->band_slip_ft[c] = s->band_slipped_ft.count ? sim_scene_joint(&s->band_slipped_ft, c + 1) : 0.0;
        m->state->band_out[c] = 0.0;
        m->state->band_load_lb[c] = 0.0;
        m->state->band_mat[c] = m->mat[c];
        for (size_t i = 0; i < s->band_pulled.count; i++)
            m->state->band_out[c] = s->band_pulled.values[i] == m->mat[c] ? 1.0 : m->state->band_out[c];
    }
    for (int i = 0; i < m->segments; i++) {
        double from_ft = i > 0 ? (m->mat[i - 1] - 0.5) * scene->length_ft : 0.0;
        double to_ft = i < m->segments - 1 ? (m->mat[i] - 0.5) * scene->length_ft : m->mats * scene->length_ft;
        double give_ft_lb = (to_ft - from_ft) / ea_lb;
        if (i == 0 || i == m->segments - 1)
            give_ft_lb += 1.0 / s->band_k_lb_ft;
        m->k_lb_ft[i] = 1.0 / give_ft_lb;
        m->stretch_ft[i] = sim_scene_joint(&s->band_t0_lb, i + 1) * give_ft_lb -
                           s->band_alpha_f * s->band_dt_f * (to_ft - from_ft);
        m->band_lb[i] = m->k_lb_ft[i] * m->stretch_ft[i];
        m->state->band_least_lb[i] = INFINITY;
        m->state->band_most_lb[i] = -INFINITY;
    }
    slide_all(m);
    note_extremes(m);
}

double mods_band_energy_lb_ft(const struct mods *m, const struct mods_view *view)
{
    double energy = 0.0;
    for (int i = 0; i < m->segments; i++) {
        double t_lb = taut_lb(mods_band_raw_lb(m, view, i));
        energy += 0.5 * t_lb * t_lb / m->k_lb_ft[i];
    }
    return m->scene->mods.bands * energy;
}
