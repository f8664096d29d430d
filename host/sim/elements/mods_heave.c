/* Where mats rise: bands over a wave, stiffeners that bend, cleats that leave the ground.
 * MODIFICATIONS.md. */
#include <math.h>

#include "host/sim/elements/mods_view.h"

#define RADIANS (3.14159265358979323846 / 180.0)

/* Mats and nodes count from 0 here, as in the planar model; Y is down. A mat outside the heaving
 * part lies on the ground. */
static double slope(const struct mods_heave *h, int n)
{
    if (n < 0 || n >= h->mats)
        return 0.0;
    double tilt_ft = h->tilt_ft ? h->tilt_ft[n] : 0.0;
    return ((n < h->first || n > h->last ? 0.0 : h->z[2 * n + 2] - h->z[2 * n]) + tilt_ft) /
           h->length_ft;
}

static double all_lb(const struct mods_bands *b, int segment)
{
    return b->made->count * taut_lb(b->lb[segment]);
}

/* The segment that passes over node j, between mats j and j + 1 of those counted from 1. */
static int segment_over(const struct mods_bands *b, int j)
{
    int first = b->mat[0], every = b->made->every;
    int before = j < first ? 0 : (j - first) / every + 1; /* rivets in mats 1..j */
    return before < b->segments ? before : b->segments - 1;
}

/* A band that follows the mats bears on every crest with T times its angle: 2 T h/L on a vee. */
static void press_crests(const struct mods_bands *b, const struct mods_heave *h)
{
    for (int j = h->first + 1; j <= h->last; j++) {
        double kink = slope(h, j) - slope(h, j - 1);
        if (kink > 0.0)
            h->down_lb[j] += all_lb(b, segment_over(b, j)) * kink;
    }
}

static double node_height_ft(const struct mods_heave *h, int node)
{
    double ground_ft = h->ground_ft ? h->ground_ft[node] : 0.0;
    return ground_ft - (node < h->first || node > h->last + 1 ? h->rest_y_ft : h->z[2 * node]);
}

/* Height of a point of the band in mats from the left end: of a node, or of the middle of a riveted
 * mat. */
static double height_ft(const struct mods_heave *h, double at)
{
    int node = (int)floor(at);
    double left_ft = node_height_ft(h, node);
    return at > node ? 0.5 * (left_ft + node_height_ft(h, node + 1)) : left_ft;
}

static void press(const struct mods_heave *h, double at, double down_lb)
{
    int node = (int)floor(at);
    bool middle = at > node;
    for (int j = node; j <= node + middle; j++) {
        if (j >= h->first && j <= h->last + 1)
            h->down_lb[j] += middle ? 0.5 * down_lb : down_lb;
    }
}

static double rise(const struct mods_heave *h, double from, double to)
{
    return (height_ft(h, to) - height_ft(h, from)) / ((to - from) * h->length_ft);
}

/* A band that is free between its rivets is the tightest line over the nodes from one to the
 * next. */
static void press_hull(const struct mods *m, const struct mods_bands *b, const struct mods_heave *h,
                       int segment)
{
    double t_lb = all_lb(b, segment), *line = m->hull;
    double from = segment > 0 ? b->mat[segment - 1] - 0.5 : 0.0;
    double to = segment < b->segments - 1 ? b->mat[segment] - 0.5 : m->mats;
    int count = 1;
    if (!(t_lb > 0.0) || to <= h->first || from >= h->last + 1 || !(to > from))
        return;
    line[0] = from;
    for (int j = (int)floor(from) + 1; j < to + 1.0; j++) {
        double at = j < to ? j : to;
        while (count > 1 &&
               rise(h, line[count - 2], line[count - 1]) <= rise(h, line[count - 1], at))
            count--;
        line[count++] = at;
        if (at == to)
            break;
    }
    for (int i = 0; i + 1 < count; i++) {
        double pulled_lb = t_lb * rise(h, line[i], line[i + 1]);
        press(h, line[i], -pulled_lb);
        press(h, line[i + 1], pulled_lb);
    }
}

void mods_brace_heave(struct mods *m, const struct mods_heave *h)
{
    for (int j = h->first; j <= h->last + 1; j++) {
        h->down_lb[j] = 0.0;
        h->moment_lb_ft[j] =
            m->stiffened ? mods_moment_lb_ft(m, j + 1, asin(slope(h, j)) - asin(slope(h, j - 1)))
                         : 0.0;
    }
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        const struct mods_bands *b = &m->band[g];
        if (b->segments > 0 && b->made->over == SIM_OVER_JOINTS)
            press_crests(b, h);
        for (int i = 0; i < b->segments && b->made->over == SIM_OVER_RIVETS; i++)
            press_hull(m, b, h, i);
    }
}

double mods_rate2(const struct mods *m, double mass_slug, double inertia)
{
    double length_ft = m->scene->length_ft, turn = 0.0, pull_lb = 0.0;
    double lightest = fmin(mass_slug, 4.0 * inertia / (length_ft * length_ft));
    for (int j = 1; m->stiffened && j <= m->mats + 1; j++)
        turn = fmax(turn, m->turn_lb_ft_rad[j]);
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        double most_lb = 0.0;
        for (int i = 0; i < m->band[g].segments; i++)
            most_lb = fmax(most_lb, all_lb(&m->band[g], i));
        pull_lb += most_lb;
    }
    return mods_stiffness_lb_ft(m) / mass_slug + 4.0 * turn / inertia +
           2.0 * pull_lb * 4.0 / (length_ft * lightest);
}

/* Share of its hold at a share of its depth. Passive earth pressure goes with the depth squared,
 * cohesion with the depth. */
static double share_at(const struct sim_mods *s, double depth)
{
    return pow(depth, s->cleat_power);
}

/* Share that is left when the wheel presses a cleat back of whose depth `out` was out. Its tip
 * stays where it is in the soil, so that it turns at its root: cos turn = 1 - out. A part of that
 * springs back. */
static double share_pressed(const struct sim_mods *s, double out)
{
    if (!(s->cleat_power > 0.0))
        return 1.0 - out;
    double bent = acos(1.0 - out) - s->cleat_spring_deg * RADIANS;
    return bent > 0.0 ? share_at(s, cos(bent)) : 1.0;
}

double mods_raised_cleat_lb(struct mods *m, int mat, double left_y_ft, double right_y_ft)
{
    int cleat = mods_cleat_of(m, mat);
    if (cleat < 0)
        return 0.0;
    const struct sim_mods *s = &m->scene->mods;
    double raised_ft = -0.5 * (left_y_ft + right_y_ft);
    raised_ft = raised_ft > 0.0 ? fmin(raised_ft, s->cleat_depth_ft) : 0.0;
    double in = 1.0 - raised_ft / s->cleat_depth_ft;
    m->raised_ft[cleat] = fmax(m->raised_ft[cleat], raised_ft);
    double whole_lb = s->cleat_hold_lb * m->state->cleat_left[cleat];
    return s->cleat_power > 0.0 ? whole_lb * share_at(s, in) : whole_lb * in * in;
}

/* The wheel presses a cleat that had come out back onto the soil: what was out bends. */
void mods_press_cleats(struct mods *m, const struct sim_touch *touch, int count)
{
    for (int i = 0; i < count; i++) {
        int cleat = mods_cleat_of(m, touch[i].mat);
        if (cleat < 0 || !(m->raised_ft[cleat] > 0.0))
            continue;
        const struct sim_mods *s = &m->scene->mods;
        m->state->cleat_left[cleat] *= share_pressed(s, m->raised_ft[cleat] / s->cleat_depth_ft);
        m->raised_ft[cleat] = 0.0;
    }
}
