/* The window: which mats are integrated. PLANAR.md, "What is left out".
 *
 * A mat outside is flat, at rest, and its displacement constant. Where the laws keep it so, leaving
 * it out is exact: exact sticking holds a mat until the push on it exceeds its limit, and the
 * report's equations give a flat mat no turning moment until a joint's free rotation is used up or
 * the lift shear takes it. There the window grows when that happens. Elsewhere the motion arrives
 * as a tail that falls off faster than exponentially ahead of the wave: the window grows while any
 * of its GUARD outermost mats moves by more than QUIET. */
#include <math.h>
#include <string.h>

#include "host/sim/models/kernel.h"

#define GUARD         4
#define CHUNK         8     /* mats taken in at once when the guard is reached, at least */
#define QUIET         1e-13 /* of L for heights, of sqrt(g L) for speeds */
#define PATIENCE      16    /* steps between attempts to leave mats behind */
#define WORTH_LEAVING 4     /* mats; fewer are not worth a restart */

static bool exact_push(const struct model *m)
{
    return m->law == SIM_STICK && (m->elements.count == 0 || element_rests(&m->elements));
}

/* Flat mats of the report model stay flat until a switch says otherwise. */
static bool exact_shape(const struct model *m)
{
    return !m->consistent && (m->tad_rad > 0.0 || (m->kt == 0.0 && m->ct == 0.0));
}

/* Mats taken in at once. In the consistent model a load is felt at once as far as the mass matrix
 * carries it. */
static int chunk(const struct model *m)
{
    return m->tail > GUARD + CHUNK ? m->tail - GUARD : CHUNK;
}

static double quiet_ft(const struct model *m)
{
    return QUIET * m->length_ft;
}

static double quiet_ft_s(const struct model *m)
{
    return QUIET * sqrt(m->scene->g_ft_s2 * m->length_ft);
}

/* A mat whose shape is as a mat outside has it. */
static bool lies_flat(const struct model *m, const double *z, int n)
{
    const double *v = z + m->size;
    if (exact_shape(m))
        return z[2 * n] == z[2 * n + 2] && v[2 * n] == v[2 * n + 2];
    if (!m->consistent)
        return fabs(z[2 * n + 2] - z[2 * n]) <= quiet_ft(m) &&
               fabs(v[2 * n + 2] - v[2 * n]) <= quiet_ft_s(m);
    return fabs(z[2 * n] - m->rest_y_ft) <= quiet_ft(m) &&
           fabs(z[2 * n + 2] - m->rest_y_ft) <= quiet_ft(m) && fabs(v[2 * n]) <= quiet_ft_s(m) &&
           fabs(v[2 * n + 2]) <= quiet_ft_s(m);
}

static bool lies_still(const struct model *m, const double *z, int n)
{
    double v = z[m->size + 2 * n + 1];
    return exact_push(m) ? v == 0.0 && m->slide[n] == 0 : fabs(v) <= quiet_ft_s(m);
}

/* The mats that the aircraft touches in this span; false when it touches none. */
static bool touched(const struct model *m, int *low, int *high)
{
    const struct span *span = &m->span;
    if (span->mat < 0)
        return false;
    *low = *high = span->mat;
    if (span->share != -2) {
        *low = span->share < *low ? span->share : *low;
        *high = span->share + 1 > *high ? span->share + 1 : *high;
    }
    int more = m->consistent ? (m->wheel_load_lb > 0.0 ? m->tail : GUARD) : exact_push(m) ? 0 : 1;
    *low -= more;
    *high += more;
    return true;
}

static void clip(const struct model *m, int *first, int *last)
{
    if (*first < 0)
        *first = 0;
    if (*last > m->mats - 1)
        *last = m->mats - 1;
}

void model_fill(const struct model *m, double *z)
{
    double *v = z + m->size;
    for (int n = 0; n < m->mats; n++) {
        if (n >= m->first && n <= m->last)
            continue;
        int edge = n < m->first ? m->first : m->last + 1, node = n < m->first ? n : n + 1;
        z[2 * n + 1] = m->rest_u_ft[n];
        v[2 * n + 1] = 0.0;
        z[2 * node] = m->consistent ? m->rest_y_ft : z[2 * edge];
        v[2 * node] = m->consistent ? 0.0 : v[2 * edge];
    }
}

static void widen(struct model *m, double *z, int first, int last)
{
    int was_first = m->first, was_last = m->last;
    clip(m, &first, &last);
    for (int n = first; n <= last; n++) {
        if (n >= was_first && n <= was_last)
            continue;
        int edge = n < was_first ? was_first : was_last + 1, node = n < was_first ? n : n + 1;
        int joint = n < was_first ? n : n + 1;
        z[2 * n + 1] = m->rest_u_ft[n];
        z[m->size + 2 * n + 1] = 0.0;
        z[2 * node] = m->consistent ? m->rest_y_ft : z[2 * edge];
        z[m->size + 2 * node] = m->consistent ? 0.0 : z[m->size + 2 * edge];
        m->contact[node] = m->consistent ? 1 : m->contact[edge];
        m->torsion[joint] = !(m->tad_rad > 0.0) && (m->kt > 0.0 || m->ct > 0.0) &&
                            !(joint == m->mats && m->right_turns) && !(joint == 0 && m->left_turns);
        m->lift[n] = 0;
    }
    m->first = first;
    m->last = last;
}

static void narrow(struct model *m, double *z, int first, int last)
{
    for (int n = m->first; n <= m->last; n++) {
        if (n < first || n > last)
            m->rest_u_ft[n] = z[2 * n + 1];
    }
    m->first = first;
    m->last = last;
    if (m->consistent) { /* the outermost nodes are held at rest */
        for (int node = first; node <= last + 1; node += last + 1 - first) {
            if ((node == first && first > 0) || (node == last + 1 && last < m->mats - 1)) {
                z[2 * node] = m->rest_y_ft;
                z[m->size + 2 * node] = 0.0;
            }
        }
    }
}

/* Where the window has to begin and end, as far as its edges tell. */
static void wanted(const struct model *m, const double *z, int *first, int *last)
{
    int low, high;
    *first = m->first;
    *last = m->last;
    if (touched(m, &low, &high)) {
        *first = low < *first ? low : *first;
        *last = high > *last ? high : *last;
    }
    if (m->first > 0) {
        if (m->slide[m->first - 1] != 0 || (exact_shape(m) && m->torsion[m->first] != 0))
            *first = m->first - 1 < *first ? m->first - 1 : *first;
        if (!m->consistent && !m->contact[m->first])
            *first = 0; /* the apex may be any of the nodes before it */
    }
    if (m->last < m->mats - 1) {
        if (m->slide[m->last + 1] != 0 || (exact_shape(m) && m->torsion[m->last + 1] != 0))
            *last = m->last + 1 > *last ? m->last + 1 : *last;
        if (m->shear != SIM_NO_SHEAR && m->lifted > 0 && m->apex + 1 > *last)
            *last = m->apex + 1;
    }
    if (exact_push(m) && exact_shape(m))
        return;
    for (int k = 0; k < GUARD && m->first > 0; k++) {
        int n = m->first + k;
        if (n <= m->last &&
            ((!exact_push(m) && !lies_still(m, z, n)) || (!exact_shape(m) && !lies_flat(m, z, n))))
            *first = m->first - chunk(m) < *first ? m->first - chunk(m) : *first;
    }
    for (int k = 0; k < GUARD && m->last < m->mats - 1; k++) {
        int n = m->last - k;
        if (n >= m->first &&
            ((!exact_push(m) && !lies_still(m, z, n)) || (!exact_shape(m) && !lies_flat(m, z, n))))
            *last = m->last + chunk(m) > *last ? m->last + chunk(m) : *last;
    }
}

/* How many mats could be left behind at an end: those at rest, less a margin. */
static int idle(const struct model *m, const double *z, bool at_first)
{
    int count = 0, low = 0, high = 0;
    bool any = touched(m, &low, &high);
    for (; count < m->last - m->first; count++) {
        int n = at_first ? m->first + count : m->last - count;
        if ((any && n >= low && n <= high) || !lies_still(m, z, n) || !lies_flat(m, z, n) ||
            (exact_shape(m) &&
             (m->torsion[n] || m->torsion[n + 1] || !m->contact[n] || !m->contact[n + 1])))
            break;
    }
    if (!at_first && m->shear != SIM_NO_SHEAR && m->lifted > 0 && m->last - count < m->apex + 1)
        count = m->last - m->apex - 1;
    return count - (exact_push(m) && exact_shape(m) ? 1 : chunk(m));
}

bool model_follow(struct model *m, double *z)
{
    int first, last;
    if (!m->prunes)
        return false;
    wanted(m, z, &first, &last);
    clip(m, &first, &last);
    if (first != m->first || last != m->last) {
        widen(m, z, first, last);
        return true;
    }
    if (++m->quiet_steps < PATIENCE)
        return false;
    m->quiet_steps = 0;
    int at_first = idle(m, z, true), at_last = idle(m, z, false);
    at_first = at_first >= WORTH_LEAVING ? at_first : 0;
    at_last = at_last >= WORTH_LEAVING ? at_last : 0;
    if (at_first + at_last == 0 || at_first + at_last > m->last - m->first)
        return false;
    narrow(m, z, m->first + at_first, m->last - at_last);
    return true;
}

void model_prune(struct model *m, double t_s, const double *z)
{
    int first = m->mats, last = -1, low, high;
    if (!m->prunes)
        return;
    for (int n = 0; n < m->mats; n++) {
        bool pushed = exact_push(m) ? m->slide[n] != 0 : model_push_lb(m, t_s, z, n) != 0.0;
        m->rest_u_ft[n] = z[2 * n + 1];
        if (pushed || !lies_still(m, z, n) || !lies_flat(m, z, n) ||
            (!m->consistent && (!m->contact[n] || !m->contact[n + 1]))) {
            first = n < first ? n : first;
            last = n;
        }
    }
    if (touched(m, &low, &high)) {
        first = low < first ? low : first;
        last = high > last ? high : last;
    }
    if (last < 0)
        first = last = 0;
    if (!exact_push(m) || !exact_shape(m)) {
        first -= chunk(m);
        last += chunk(m);
    }
    clip(m, &first, &last);
    m->first = first;
    m->last = last;
}
