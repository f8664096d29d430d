#include <math.h>

#include "host/sim/solvers/landing_engine.h"

#define CALM     1e-6 /* of sqrt(g L): on uneven ground a node slower than that is at rest */
#define GUARD    4    /* mats at rest that the heaving part keeps at its ends */
#define CHUNK    8    /* mats that it grows by, at least */
#define PATIENCE 16   /* steps before a part may shrink */
/* steps before it leaves the next mat: one for its damper, one for the grit, one more */
#define SETTLING 3
#define AIR      1e-3  /* of L: a node that is so high is held by its mats, not by the ground */
#define QUIET    1e-13 /* of L for heights, of sqrt(g L) for their rates: at rest */

void landing_take_in(struct part *part, const struct model *m, int low, int high)
{
    low = low < 0 ? 0 : low;
    high = high > m->mats - 1 ? m->mats - 1 : high;
    if (part->last < part->first)
        *part = (struct part){low, high, 0, 0};
    if (low < part->first) {
        part->first = low;
        part->quiet_first = 0;
    }
    if (high > part->last) {
        part->last = high;
        part->quiet_last = 0;
    }
}

void landing_follow_slides(struct landing *l, const struct sim_touch *touch, int count)
{
    struct part *s = &l->slides;
    const double *v = l->z + l->model.size;
    for (int i = 0; i < count; i++) {
        bool idle = s->last - s->first <= 2 && s->quiet_first >= PATIENCE &&
                    s->quiet_last >= PATIENCE;
        if (idle)
            s->last = s->first - 1; /* go there instead of stretching */
        landing_take_in(s, &l->model, touch[i].mat - 2, touch[i].mat);
    }
    if (s->last < s->first)
        return;
    if (v[2 * s->first + 1] != 0.0 || v[2 * s->last + 1] != 0.0)
        landing_take_in(s, &l->model, v[2 * s->first + 1] != 0.0 ? s->first - 1 : s->first,
                        v[2 * s->last + 1] != 0.0 ? s->last + 1 : s->last);
    bool still_first = v[2 * s->first + 1] == 0.0 && v[2 * s->first + 3] == 0.0;
    bool still_last = v[2 * s->last + 1] == 0.0 && s->last > 0 && v[2 * s->last - 1] == 0.0;
    s->quiet_first = still_first ? s->quiet_first + 1 : 0;
    s->quiet_last = still_last ? s->quiet_last + 1 : 0;
    if (s->quiet_first >= PATIENCE && s->last - s->first > 2) {
        s->first++;
        s->quiet_first = PATIENCE - SETTLING;
    }
    if (s->quiet_last >= PATIENCE && s->last - s->first > 2) {
        s->last--;
        s->quiet_last = PATIENCE - SETTLING;
    }
}

/* On uneven ground a node under compression comes to rest off its settled height. One in the air
 * stays with the part that heaves, however still it is: a wave that stands is as long as it is
 * because it stands, and outside mats count as flat. */
static bool node_rests(const struct landing *l, int node)
{
    const struct model *m = &l->model;
    if (m->tilt_ft)
        return fabs(l->z[m->size + 2 * node]) <= CALM * sqrt(m->scene->g_ft_s2 * m->length_ft) &&
               l->z[2 * node] >= -AIR * m->length_ft;
    return fabs(l->z[2 * node] - m->rest_y_ft) <= QUIET * m->length_ft &&
           fabs(l->z[m->size + 2 * node]) <= QUIET * sqrt(m->scene->g_ft_s2 * m->length_ft);
}

/* The end of a mat that came apart from the next. */
static bool end_rests(const struct landing *l, int joint)
{
    const struct model *m = &l->model;
    double still_ft_s = (m->tilt_ft ? CALM : QUIET) * sqrt(m->scene->g_ft_s2 * m->length_ft);
    return fabs(l->parting->v_ft_s[joint]) <= still_ft_s &&
           (m->tilt_ft ? l->parting->y_ft[joint] >= -AIR * m->length_ft
                       : fabs(l->parting->y_ft[joint] - m->rest_y_ft) <= QUIET * m->length_ft);
}

bool landing_mat_rests(const struct landing *l, int n)
{
    return node_rests(l, n) && node_rests(l, n + 1) &&
           (!l->parting || !l->parting->apart[n + 1] || end_rests(l, n + 1));
}

/* On uneven ground every joint whose force changes lifts or presses its mats. */
static void heave_what_slides(struct landing *l, int chunk)
{
    const double *v = l->z + l->model.size;
    int first = l->slides.first, last = l->slides.last;
    while (first <= last && v[2 * first + 1] == 0.0)
        first++;
    while (last > first && v[2 * last + 1] == 0.0)
        last--;
    if (first <= last)
        landing_take_in(&l->heaves, &l->model, first - chunk, last + chunk);
}

/* Flat mats at rest stay so: the part that heaves begins with what is not, or carries the wheel,
 * and keeps GUARD mats at rest at its ends, so that what it holds back there is below QUIET. */
void landing_follow_heaves(struct landing *l)
{
    struct model *m = &l->model;
    struct part *h = &l->heaves;
    /* what is loaded at once: as window.c */
    int chunk = m->tail > GUARD + CHUNK ? m->tail - GUARD : CHUNK;
    if (m->wheel_load_lb > 0.0 && m->span.mat >= 0)
        landing_take_in(h, m, m->span.mat - m->tail, m->span.mat + m->tail);
    if (m->tilt_ft)
        heave_what_slides(l, GUARD);
    if (h->last < h->first)
        return;
    bool first = h->first == 0, last = h->last == m->mats - 1;
    for (int k = 0; k < GUARD && !first; k++)
        first = h->first + k <= h->last && !landing_mat_rests(l, h->first + k);
    for (int k = 0; k < GUARD && !last; k++)
        last = h->last - k >= h->first && !landing_mat_rests(l, h->last - k);
    if (first && h->first > 0)
        landing_take_in(h, m, h->first - chunk, h->last);
    if (last && h->last < m->mats - 1)
        landing_take_in(h, m, h->first, h->last + chunk);
    if (++h->quiet_first >= PATIENCE) {
        h->quiet_first = 0;
        int low = h->first, high = h->last;
        while (low <= high && landing_mat_rests(l, low))
            low++;
        while (high >= low && landing_mat_rests(l, high))
            high--;
        bool loaded = m->wheel_load_lb > 0.0 && m->span.mat >= 0;
        if (low > high && !loaded)
            h->last = h->first - 1;
        else if (low <= high) {
            int from = low - chunk, to = high + chunk;
            if (loaded) {
                from = m->span.mat - m->tail < from ? m->span.mat - m->tail : from;
                to = m->span.mat + m->tail > to ? m->span.mat + m->tail : to;
            }
            h->first = from > h->first ? from : h->first;
            h->last = to < h->last ? to : h->last;
        }
    }
}

/* Turning pulls at the joints of profile `full`, and heaving changes the soil's hold on the
 * mats. */
void landing_slide_what_heaves(struct landing *l)
{
    const struct model *m = &l->model;
    if ((m->full || m->soil_normal) && l->heaves.last >= l->heaves.first)
        landing_take_in(&l->slides, m, l->heaves.first - 1, l->heaves.last + 1);
}
