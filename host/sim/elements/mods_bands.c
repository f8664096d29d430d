/* Bands: MODIFICATIONS.md, "Bands". Those of a group are alike; tensions are those of one. */
#include <math.h>

#include "host/sim/elements/mods_view.h"

/* of slip through the connections until nothing moves any more, at the start */
#define SWEEPS  200
#define SETTLED 1e-12 /* of the stiffness' reach: less slip than that is none */

/* Riveted mats of all groups in order; one that both are riveted to is braced once, by their
 * sum. */
static void find_braces(struct mods *m)
{
    int at[SIM_BAND_GROUPS] = {0};
    for (;;) {
        int next = m->mats + 1;
        for (int g = 0; g < SIM_BAND_GROUPS; g++) {
            if (at[g] < m->band[g].segments - 1 && m->band[g].mat[at[g]] < next)
                next = m->band[g].mat[at[g]];
        }
        if (next > m->mats)
            return;
        for (int g = 0; g < SIM_BAND_GROUPS; g++) {
            if (at[g] < m->band[g].segments - 1 && m->band[g].mat[at[g]] == next)
                m->band[g].brace[at[g]++] = m->braces;
        }
        m->brace_mat[m->braces++] = next;
    }
}

void mods_place_bands(struct mods *m, double *at)
{
    size_t segments = m->state->segments, connections = m->state->connections, segment = 0,
           connection = 0;
    double *k = at, *stretch = k + segments;
    m->band_lb = stretch + segments;
    m->carried_lb = m->band_lb + segments;
    m->saved_lb = m->carried_lb + connections;
    m->brace_mat = (int *)(m->saved_lb + connections);
    int *mat = m->brace_mat + connections, *brace = mat + connections;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        int count = mods_connections(m->scene, g);
        if (count == 0)
            continue;
        m->band[g] = (struct mods_bands){
            .made = &m->scene->mods.band[g],
            .segments = count + 1,
            .mat = mat + connection,
            .brace = brace + connection,
            .k_lb_ft = k + segment,
            .stretch_ft = stretch + segment,
            .lb = m->band_lb + segment,
            .least_lb = m->state->band_least_lb + segment,
            .most_lb = m->state->band_most_lb + segment,
            .slip_ft = m->state->band_slip_ft + connection,
            .load_lb = m->state->band_load_lb + connection,
            .out = m->state->band_out + connection,
            .riveted = m->state->band_mat + connection,
        };
        for (int c = 0; c < count; c++)
            m->band[g].mat[c] = mods_connection_mat(m->scene, g, c);
        segment += (size_t)count + 1;
        connection += (size_t)count;
    }
    find_braces(m);
}

static int left_mat(const struct mods_bands *b, int segment)
{
    return segment > 0 ? b->mat[segment - 1] : 0;
}

static double raw_lb(const struct mods *m, const struct mods_bands *b, const struct mods_view *view,
                     int segment)
{
    int right = segment < b->segments - 1 ? b->mat[segment] : m->mats + 1;
    double longer_ft = view_u_ft(view, m->mats, right) -
                       view_u_ft(view, m->mats, left_mat(b, segment));
    return b->k_lb_ft[segment] * (b->stretch_ft[segment] + longer_ft);
}

static double grip_lb(const struct mods_bands *b, int connection)
{
    return b->out[connection] != 0.0 ? 0.0 : b->made->grip_lb;
}

/* What has to go from segment `from` to segment `to`, ft, so that from - to = grip: the band slides
 * through. A slack segment takes up length before it pulls. */
static double slid_ft(const struct mods_bands *b, int from, int to, double grip)
{
    double t_from = b->lb[from], t_to = b->lb[to];
    double k_from = b->k_lb_ft[from], k_to = b->k_lb_ft[to];
    double to_limit_ft = (t_from - grip) / k_from; /* while the other stays slack */
    return t_to + k_to * to_limit_ft <= 0.0 ? to_limit_ft
                                            : (t_from - t_to - grip) / (k_from + k_to);
}

/* One connection; returns the slip. */
static double slide(struct mods_bands *b, int c)
{
    double grip = grip_lb(b, c);
    double difference = taut_lb(b->lb[c + 1]) - taut_lb(b->lb[c]);
    if (!(fabs(difference) > grip))
        return 0.0;
    int from = difference > 0.0 ? c + 1 : c, to = difference > 0.0 ? c : c + 1;
    double s = slid_ft(b, from, to, grip);
    b->stretch_ft[from] -= s;
    b->stretch_ft[to] += s;
    b->lb[from] -= b->k_lb_ft[from] * s;
    b->lb[to] += b->k_lb_ft[to] * s;
    b->slip_ft[c] += s;
    return s;
}

/* Slip at one connection loads the next: there and back, until nothing slides any more. */
static void slide_all(const struct mods *m, struct mods_bands *b)
{
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        double most_ft = 0.0;
        for (int i = 0; i < b->segments - 1; i++)
            most_ft = fmax(most_ft, slide(b, sweep % 2 ? b->segments - 2 - i : i));
        if (!(most_ft > SETTLED * m->scene->length_ft))
            return;
    }
}

/* The wheel turns a riveted mat by band_tilt against the band on both sides: the rivets feel a part
 * across the mat. A hole that slip has worn holds less. */
static void pull_rivets(struct mods_bands *b, const struct sim_touch *touch, int count)
{
    const struct sim_bands *s = b->made;
    int first = b->mat[0];
    for (int i = 0; i < count; i++) {
        int c = (touch[i].mat - first) / s->every;
        if (touch[i].mat < first || (touch[i].mat - first) % s->every != 0 || c >= b->segments - 1)
            continue;
        double across_lb = s->tilt_rad * (taut_lb(b->lb[c]) + taut_lb(b->lb[c + 1]));
        double worn = b->slip_ft[c] / s->wear_ft;
        if (across_lb > s->pull_lb * (worn < 1.0 ? 1.0 - worn : 0.0))
            b->out[c] = 1.0;
    }
}

/* Extremes, and what the group pushes its mats with. */
static void note(struct mods *m, const struct mods_bands *b)
{
    for (int i = 0; i < b->segments; i++) {
        b->least_lb[i] = b->lb[i] < b->least_lb[i] ? b->lb[i] : b->least_lb[i];
        b->most_lb[i] = b->lb[i] > b->most_lb[i] ? b->lb[i] : b->most_lb[i];
    }
    for (int c = 0; c < b->segments - 1; c++) {
        double carried_lb = taut_lb(b->lb[c + 1]) - taut_lb(b->lb[c]);
        if (fabs(carried_lb) > b->load_lb[c])
            b->load_lb[c] = fabs(carried_lb);
        m->carried_lb[b->brace[c]] += b->made->count * carried_lb;
    }
}

void mods_pull_bands(struct mods *m, const struct mods_view *view, const struct sim_touch *touch,
                     int count)
{
    for (int i = 0; i < m->braces; i++)
        m->carried_lb[i] = 0.0;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        struct mods_bands *b = &m->band[g];
        if (b->segments == 0)
            continue;
        for (int i = 0; i < b->segments; i++)
            b->lb[i] = raw_lb(m, b, view, i);
        if (b->made->pull_lb < HUGE_VAL)
            pull_rivets(b, touch, count);
        slide_all(m, b);
        note(m, b);
    }
}

/* A segment's ends are the middles of its mats; the outer ones end at the springs of the anchors,
 * at the runway's ends. */
static void reset_group(const struct mods *m, struct mods_bands *b)
{
    const struct sim_scene *scene = m->scene;
    const struct sim_bands *s = b->made;
    double ea_lb = s->area_ft2 * s->e_lb_ft2;
    for (int c = 0; c < b->segments - 1; c++) {
        b->slip_ft[c] = s->slipped_ft.count ? sim_scene_joint(&s->slipped_ft, c + 1) : 0.0;
        b->out[c] = 0.0;
        b->load_lb[c] = 0.0;
        b->riveted[c] = b->mat[c];
        for (size_t i = 0; i < s->pulled.count; i++)
            b->out[c] = s->pulled.values[i] == b->mat[c] ? 1.0 : b->out[c];
    }
    for (int i = 0; i < b->segments; i++) {
        double from_ft = i > 0 ? (b->mat[i - 1] - 0.5) * scene->length_ft : 0.0;
        double to_ft = i < b->segments - 1 ? (b->mat[i] - 0.5) * scene->length_ft
                                           : m->mats * scene->length_ft;
        double give_ft_lb = (to_ft - from_ft) / ea_lb;
        if (i == 0 || i == b->segments - 1)
            give_ft_lb += 1.0 / s->k_lb_ft;
        b->k_lb_ft[i] = 1.0 / give_ft_lb;
        b->stretch_ft[i] = sim_scene_joint(&s->t0_lb, i + 1) * give_ft_lb -
                           s->alpha_f * s->dt_f * (to_ft - from_ft);
        b->lb[i] = b->k_lb_ft[i] * b->stretch_ft[i];
        b->least_lb[i] = (double)INFINITY;
        b->most_lb[i] = -(double)INFINITY;
    }
}

void mods_reset_bands(struct mods *m)
{
    for (int i = 0; i < m->braces; i++)
        m->carried_lb[i] = 0.0;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        struct mods_bands *b = &m->band[g];
        if (b->segments == 0)
            continue;
        reset_group(m, b);
        slide_all(m, b);
        note(m, b);
    }
}

double mods_band_energy_lb_ft(const struct mods *m, const struct mods_view *view)
{
    double energy = 0.0;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        const struct mods_bands *b = &m->band[g];
        double of_one = 0.0;
        for (int i = 0; i < b->segments; i++) {
            double t_lb = taut_lb(raw_lb(m, b, view, i));
            of_one += 0.5 * t_lb * t_lb / b->k_lb_ft[i];
        }
        energy += b->segments > 0 ? b->made->count * of_one : 0.0;
    }
    return energy;
}
