#include "host/sim/landing.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/sim/kernel.h"
#include "host/sim/mods.h"
#include "host/sim/pass.h"
#include "host/sim/planar.h"
#include "host/sim/record.h"
#include "host/sim/slip.h"
#include "host/sim/wheel.h"

#define STEP_SHARE 0.25 /* of the stability limit, when the step is not given */
#define HOP_SHARE 0.25  /* of a mat the aircraft may cross in a step */
#define STABLE 1.8      /* the scheme's limit times the fastest rate; 2 for an oscillation, less with damping */
#define CALM 1e-6    /* of sqrt(g L): on uneven ground a node slower than that is at rest */
#define LEAST_STEPS 1000.0
#define MOST_STEPS 1e8
#define MOST_HALVINGS 4
#define MOST_CONTACTS 8 /* times that a step is taken again as the soil lets go of nodes or holds others */
#define DISAGREEMENT 0.2
#define CAUTION 2.0 /* times the difference of two marches: of first order the finer one's error is as large as that */
#define FOLDED_DEG 85.0
#define DEGREES (180.0 / 3.14159265358979323846)
#define OFF_WAVE_SHARE 0.5 /* of an overrun's rise: lower, the wheel has left that wave, and the next is another */
#define SLIGHT_TURN 0.01 /* of a joint, in sines: smaller ones are not worth an arc sine */
#define STEPS_BETWEEN_ASKING 1024 /* whether to go on */
#define LOOK_STEPS 4 /* between looks at the angles */
#define GUARD 4      /* mats at rest that the heaving part keeps at its ends */
#define CHUNK 8      /* mats that it grows by, at least */
#define PATIENCE 16  /* steps before a part may shrink */
#define SETTLING 3   /* steps before it leaves the next mat: one for its damper, one for the grit, one more */
#define QUIET 1e-13  /* of L for heights, of sqrt(g L) for their rates: at rest */

/* Mats first..last, from 0; empty when last < first. */
struct part {
    int first, last;
    int quiet_first, quiet_last; /* steps that its ends have been at rest */
};

struct landing {
    struct model model; /* its window is the part that heaves */
    const struct sim_scene *scene;
    double *z; /* every mat's, all the time */
    double *accel, *u, *v, *height;
    double *gap0_ft, *grit_lb, *reach_ft; /* per joint */
    double *tilt_ft, *rest_cos; /* per mat on uneven ground: model.h, and the cosine of its tilt */
    double *push_lb, *pull_lb, *rise_ft; /* per joint and node: most so far */
    double *tension_lb; /* per joint; between mats at rest that of the last step in which one of them moved */
    double slack_ft;
    bool gritty;
    struct part slides; /* mats that move along the runway, and one at rest on either side */
    struct part heaves; /* mats whose nodes are not at rest */
    struct mods *mods;  /* NULL when the scene has none */
};

struct march {
    uint64_t steps, done, events;
    double h_s, ms;
    enum sim_status status;
    int mat;
    double t_s;
    double max_lift_ft;
    double speed_end_ft_s;
    double crest_deg, sag_deg;
    int crest_joint, sag_joint;
    int overrun[SIM_OVERRUNS_MAX], overruns;
    bool on_wave; /* the wheel, since it met the last of them */
    int first_crest, first_crest_wheel;
    double awake_s;
    int mats_max;
    struct sim_record record;
    struct mods_state *mods; /* at its end; NULL without modifications */
    int number; /* of this march, for go_on */
};

static void take_in(struct part *part, const struct model *m, int low, int high)
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

/* --- along the runway --- */

static void follow_slides(struct landing *l, const struct sim_touch *touch, int count)
{
    struct part *s = &l->slides;
    const double *v = l->z + l->model.size;
    for (int i = 0; i < count; i++) {
        bool idle = s->last - s->first <= 2 && s->quiet_first >= PATIENCE && s->quiet_last >= PATIENCE;
        if (idle)
            s->last = s->first - 1; /* go there instead of stretching */
        take_in(s, &l->model, touch[i].mat - 2, touch[i].mat);
    }
    if (s->last < s->first)
        return;
    if (v[2 * s->first + 1] != 0.0 || v[2 * s->last + 1] != 0.0)
        take_in(s, &l->model, v[2 * s->first + 1] != 0.0 ? s->first - 1 : s->first,
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

/* Tension of a joint at opening g; the law of chain.h. */
static inline double joint_lb(struct landing *l, int j, double g_ft, double damper_lb)
{
    const struct model *m = &l->model;
    if (l->slack_ft <= 0.0)
        return m->kl * g_ft + damper_lb;
    if (g_ft > l->slack_ft) {
        l->reach_ft[j] = l->slack_ft;
        return m->kl * (g_ft - l->slack_ft) + damper_lb;
    }
    if (l->gritty) {
        double reach_ft = l->reach_ft[j], grit_lb = l->grit_lb[j];
        if (g_ft >= reach_ft) {
            l->reach_ft[j] = g_ft;
            return 0.0;
        }
        if (reach_ft > 0.0) {
            double held_lb = m->kl * (g_ft - reach_ft);
            if (held_lb >= -grit_lb) {
                double sum = held_lb + damper_lb;
                return sum > 0.0 ? 0.0 : sum < -grit_lb ? -grit_lb : sum;
            }
            reach_ft = g_ft + grit_lb / m->kl;
            l->reach_ft[j] = reach_ft = reach_ft > 0.0 ? reach_ft : 0.0;
            if (reach_ft > 0.0)
                return -grit_lb;
        }
    }
    return g_ft < 0.0 ? m->kl * g_ft + damper_lb : 0.0;
}

/* What a mat's turning takes from its length on either side, and its rate. */
struct shortening {
    double ft, ft_s;
};

static inline struct shortening shortening_of(const struct landing *l, int n)
{
    const struct model *m = &l->model;
    if (!m->full || n < l->heaves.first || n > l->heaves.last)
        return (struct shortening){0.0, 0.0};
    const double *p = l->z, *v = l->z + m->size;
    struct kernel_mat mat = m->tilt_ft ? kernel_tilted_mat(m, p, v, n, 1.0 / m->length_ft)
                                       : kernel_mat(p, v, n, 1.0 / m->length_ft);
    return (struct shortening){m->half_ft * (l->rest_cos[n] - mat.c), m->half_ft * mat.w * mat.s};
}

static void stretch_joints(struct landing *l)
{
    const struct model *m = &l->model;
    const double *p = l->z, *v = l->z + m->size;
    struct shortening left, right = shortening_of(l, l->slides.first - 1);
    for (int j = l->slides.first; j <= l->slides.last + 1; j++) {
        left = right; /* also past an end that pulls nothing */
        right = shortening_of(l, j);
        if ((j == 0 && m->left_free) || (j == m->mats && m->right_free)) {
            l->tension_lb[j] = 0.0;
            continue;
        }
        double u_l = j > 0 ? p[2 * j - 1] : 0.0, u_r = j < m->mats ? p[2 * j + 1] : 0.0;
        double v_l = j > 0 ? v[2 * j - 1] : 0.0, v_r = j < m->mats ? v[2 * j + 1] : 0.0;
        double g = l->gap0_ft[j] + (u_r - u_l) + left.ft + right.ft, rate = v_r - v_l + left.ft_s + right.ft_s;
        double t_lb = joint_lb(l, j, g, m->cl * rate);
        l->tension_lb[j] = t_lb;
        l->pull_lb[j] = t_lb > l->pull_lb[j] ? t_lb : l->pull_lb[j];
        l->push_lb[j] = -t_lb > l->push_lb[j] ? -t_lb : l->push_lb[j];
    }
    if (l->mods && l->mods->jointed) {
        struct mods_view view = {p, v, 2, -1, l->tension_lb, 1};
        mods_pull_joints(l->mods, &view, l->slides.first + 1, l->slides.last + 2);
    }
}

static struct mods_view view_of(const struct landing *l)
{
    return (struct mods_view){l->z, l->z + l->model.size, 2, -1, l->tension_lb, 1};
}

/* Bands and cleats before a kick; a riveted mat that its band moves is taken in. */
static void brace_slides(struct landing *l, const struct sim_touch *touch, int count, double h_s)
{
    struct mods *mods = l->mods;
    const struct model *m = &l->model;
    struct mods_view view = view_of(l);
    if (mods->cleated) {
        mods_press_cleats(mods, touch, count);
        mods_wear_cleats(mods, &view, h_s, l->slides.first + 1, l->slides.last + 1);
    }
    if (!mods->banded)
        return;
    mods_pull_bands(mods, &view, touch, count);
    for (int c = 0; c < mods->braces; c++) {
        int n = mods->brace_mat[c] - 1;
        double push_lb = l->tension_lb[n + 1] - l->tension_lb[n] + mods->carried_lb[c];
        double limit_lb = m->law == SIM_NONE ? 0.0 : m->weight_limit_lb + mods_cleat_lb(mods, n + 1);
        if ((n < l->slides.first || n > l->slides.last) && fabs(push_lb) > limit_lb)
            take_in(&l->slides, m, n - 1, n + 1);
    }
}

/* The bands hold waves down, and stiffeners bend: forces on nodes and moments on joints of the heaving part. */
static void brace_heaves(struct landing *l)
{
    const struct model *m = &l->model;
    struct mods_heave heave = {.z = l->z,
                               .tilt_ft = m->tilt_ft,
                               .ground_ft = l->scene->ground_ft.values,
                               .mats = m->mats,
                               .length_ft = m->length_ft,
                               .rest_y_ft = m->rest_y_ft,
                               .first = l->heaves.first,
                               .last = l->heaves.last,
                               .down_lb = m->brace_lb,
                               .moment_lb_ft = m->brace_lb_ft};
    mods_brace_heave(l->mods, &heave);
}

/* What the soil holds a heaving mat with: the reaction that its nodes have just been kicked with, dampers at the end of the
 * step. A foot that lands faster than the step can follow so rubs with the impulse it lands with. */
static double soil_limit_lb(const struct model *m, const double *z, int n)
{
    const double *v = z + m->size;
    return m->friction * (fmax(0.0, kernel_soil_lb(m, z, v, n)) + fmax(0.0, kernel_soil_lb(m, z, v, n + 1)));
}

KERNEL_INLINE unsigned kick(struct landing *l, const struct sim_touch *touch, int count, double h_s, bool cleated)
{
    const struct model *m = &l->model;
    double *v = l->z + m->size, *thrust = l->u; /* spare until outputs are taken */
    unsigned stops = 0;
    for (int n = l->slides.first; n <= l->slides.last; n++)
        thrust[n] = l->tension_lb[n + 1] - l->tension_lb[n];
    for (int i = 0; i < count; i++)
        thrust[touch[i].mat - 1] += touch[i].thrust_lb;
    for (int c = 0; l->mods && c < l->mods->braces; c++)
        thrust[l->mods->brace_mat[c] - 1] += l->mods->carried_lb[c]; /* those outside are not looked at */
    for (int n = l->slides.first; n <= l->slides.last; n++) {
        double limit = m->weight_limit_lb;
        if (m->soil_normal && n >= l->heaves.first && n <= l->heaves.last)
            limit = soil_limit_lb(m, l->z, n);
        for (int i = 0; i < count && !m->soil_normal && m->wheel_load_lb > 0.0; i++) {
            if (touch[i].mat - 1 == n)
                limit += m->friction * m->wheel_load_lb * touch[i].load_share;
        }
        if (cleated)
            limit += mods_raised_cleat_lb(l->mods, n + 1, l->z[2 * n], l->z[2 * n + 2]);
        if (m->law == SIM_NONE)
            limit = 0.0;
        v[2 * n + 1] = slip_speed_ft_s(v[2 * n + 1], thrust[n], limit, h_s, m->mass_slug, &stops);
    }
    return stops;
}

/* Runways without cleats get a loop without. */
static unsigned kick_slides(struct landing *l, const struct sim_touch *touch, int count, double h_s)
{
    return l->mods && l->mods->cleated ? kick(l, touch, count, h_s, true) : kick(l, touch, count, h_s, false);
}

/* --- up and down --- */

/* On uneven ground a node under compression comes to rest off its settled height. */
static bool node_rests(const struct landing *l, int node)
{
    const struct model *m = &l->model;
    if (m->tilt_ft)
        return fabs(l->z[m->size + 2 * node]) <= CALM * sqrt(m->scene->g_ft_s2 * m->length_ft);
    return fabs(l->z[2 * node] - m->rest_y_ft) <= QUIET * m->length_ft &&
           fabs(l->z[m->size + 2 * node]) <= QUIET * sqrt(m->scene->g_ft_s2 * m->length_ft);
}

static bool mat_rests(const struct landing *l, int n)
{
    return node_rests(l, n) && node_rests(l, n + 1);
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
        take_in(&l->heaves, &l->model, first - chunk, last + chunk);
}

/* Flat mats at rest stay so: the part that heaves begins with what is not, or carries the wheel, and keeps GUARD mats at
 * rest at its ends, so that what it holds back there is below QUIET. */
static void follow_heaves(struct landing *l)
{
    struct model *m = &l->model;
    struct part *h = &l->heaves;
    int chunk = m->tail > GUARD + CHUNK ? m->tail - GUARD : CHUNK; /* what is loaded at once: as window.c */
    if (m->wheel_load_lb > 0.0 && m->span.mat >= 0)
        take_in(h, m, m->span.mat - m->tail, m->span.mat + m->tail);
    if (m->tilt_ft)
        heave_what_slides(l, GUARD);
    if (h->last < h->first)
        return;
    bool first = h->first == 0, last = h->last == m->mats - 1;
    for (int k = 0; k < GUARD && !first; k++)
        first = h->first + k <= h->last && !mat_rests(l, h->first + k);
    for (int k = 0; k < GUARD && !last; k++)
        last = h->last - k >= h->first && !mat_rests(l, h->last - k);
    if (first && h->first > 0)
        take_in(h, m, h->first - chunk, h->last);
    if (last && h->last < m->mats - 1)
        take_in(h, m, h->first, h->last + chunk);
    if (++h->quiet_first >= PATIENCE) {
        h->quiet_first = 0;
        int low = h->first, high = h->last;
        while (low <= high && mat_rests(l, low))
            low++;
        while (high >= low && mat_rests(l, high))
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

/* Turning pulls at the joints of profile `full`, and heaving changes the soil's hold on the mats. */
static void slide_what_heaves(struct landing *l)
{
    const struct model *m = &l->model;
    if ((m->full || m->soil_normal) && l->heaves.last >= l->heaves.first)
        take_in(&l->slides, m, l->heaves.first - 1, l->heaves.last + 1);
}

/* The soil pushes and never pulls, at the end of the step: let go of nodes that it would pull, hold those that it would push.
 * True when a node has changed. */
static bool settle_contacts(struct landing *l, double h_s)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->size;
    bool changed = false;
    for (int j = m->first; j <= m->last + 1; j++) {
        double y_ft = l->z[2 * j];
        bool pushed = y_ft > 0.0 && m->kv * y_ft + m->cv * (v[2 * j] + h_s * l->accel[2 * j]) > 0.0;
        changed = changed || pushed != m->contact[j];
        m->contact[j] = pushed;
    }
    return changed;
}

static void kick_heaves(struct landing *l, double h_s)
{
    struct model *m = &l->model;
    double *v = l->z + m->size;
    m->step_s = h_s;
    consistent_heave(m, l->z, l->accel);
    for (int i = 0; i < MOST_CONTACTS && settle_contacts(l, h_s); i++)
        consistent_heave(m, l->z, l->accel);
    for (int j = m->first; j <= m->last + 1; j++)
        v[2 * j] += h_s * l->accel[2 * j];
}

/* --- a march through the landing --- */

static void place_wheel(struct model *m, const struct sim_touch *touch, int count)
{
    double most = 0.0;
    m->span = (struct span){.mat = -1, .share = -2};
    for (int i = 0; i < count; i++) {
        if (touch[i].load_share > most) {
            most = touch[i].load_share;
            m->span.mat = touch[i].mat - 1;
        }
    }
}

/* The largest lift `back_s` before the present step's end, and its node. */
static double lift_ft(const struct landing *l, double back_s, int *node_from_1)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->size;
    double most_ft = 0.0;
    *node_from_1 = 1;
    for (int j = l->heaves.first; j <= l->heaves.last + 1 && l->heaves.last >= l->heaves.first; j++) {
        double up_ft = v[2 * j] * back_s - l->z[2 * j];
        if (up_ft > most_ft && up_ft > MODEL_TOUCH_FT) {
            most_ft = up_ft;
            *node_from_1 = j + 1;
        }
    }
    return most_ft;
}

/* All that is wanted up to t_s, each at its own time: speeds are those of the step that ends at t_s. */
static void take(struct landing *l, struct march *march, double t_s)
{
    const struct model *m = &l->model;
    const double *v = l->z + m->size;
    while (march->record.next_s <= t_s) {
        double at_s = march->record.next_s, back_s = t_s - at_s;
        for (int n = 0; n < m->mats; n++) {
            l->v[n + 1] = v[2 * n + 1];
            l->u[n + 1] = l->z[2 * n + 1] - v[2 * n + 1] * back_s;
            l->height[n + 1] = v[2 * n] * back_s - l->z[2 * n];
        }
        march->record.height_ft = l->height;
        march->record.lift_ft = lift_ft(l, back_s, &march->record.lift_node);
        sim_record_take(&march->record, at_s, l->u, l->v);
    }
}

/* What each node and joint of the heaving part has come to. */
static void note_shape(struct landing *l, struct march *march)
{
    const struct model *m = &l->model;
    const double *p = l->z;
    double left = 0.0;
    for (int j = l->heaves.first; j <= l->heaves.last + 1; j++) {
        double tilt = j <= l->heaves.last && m->tilt_ft ? m->tilt_ft[j] : 0.0;
        double right = j <= l->heaves.last ? (p[2 * j + 2] - p[2 * j] + tilt) / m->length_ft : 0.0;
        l->rise_ft[j] = -p[2 * j] > l->rise_ft[j] ? -p[2 * j] : l->rise_ft[j];
        if (fabs(right - left) > SLIGHT_TURN && fabs(right) < 1.0 && fabs(left) < 1.0) {
            double turn_deg = (asin(right) - asin(left)) * DEGREES;
            if (turn_deg > march->crest_deg) {
                march->crest_deg = turn_deg;
                march->crest_joint = j + 1;
            }
            if (-turn_deg > march->sag_deg) {
                march->sag_deg = -turn_deg;
                march->sag_joint = j + 1;
            }
        }
        left = right;
    }
}

/* The highest node, when the first of them has risen so far. */
static void note_crest(const struct landing *l, struct march *march, double lift_ft)
{
    int highest = l->heaves.first;
    for (int j = l->heaves.first + 1; j <= l->heaves.last + 1 && j <= l->model.mats; j++)
        highest = l->z[2 * j] < l->z[2 * highest] ? j : highest;
    if (l->heaves.last >= l->heaves.first && -l->z[2 * highest] >= lift_ft) {
        march->first_crest = highest + 1;
        march->first_crest_wheel = l->model.span.mat + 1;
    }
}

/* The wheel at a wave that has risen too far to be pressed flat. */
static void note_overrun(const struct landing *l, struct march *march, double lift_ft)
{
    int mat = l->model.span.mat;
    if (march->first_crest == 0)
        note_crest(l, march, lift_ft);
    if (mat < 0)
        return;
    double left_ft = -l->z[2 * mat], right_ft = -l->z[2 * mat + 2];
    int node = (left_ft > right_ft ? mat : mat + 1) + 1;
    bool meets = fmax(left_ft, right_ft) >= lift_ft;
    if (meets && !march->on_wave && march->overruns < SIM_OVERRUNS_MAX)
        march->overrun[march->overruns++] = node;
    march->on_wave = meets || (march->on_wave && fmax(left_ft, right_ft) >= OFF_WAVE_SHARE * lift_ft);
}

static bool sound(struct landing *l, struct march *march, double t_s)
{
    const struct model *m = &l->model;
    int mat = l->slides.first + 1, node;
    double sum = 0.0;
    for (int n = l->slides.first; n <= l->slides.last; n++)
        sum += fabs(l->z[2 * n + 1]) + fabs(l->z[m->size + 2 * n + 1]);
    if (l->heaves.last >= l->heaves.first) {
        double angle = model_worst_angle_deg(m, l->z, &mat);
        march->max_lift_ft = fmax(march->max_lift_ft, model_lift_ft(m, l->z, &node));
        note_shape(l, march);
        if (angle > FOLDED_DEG)
            march->status = SIM_FOLDED;
        if (!isfinite(angle))
            march->status = SIM_UNSTABLE;
    }
    if (!(sum < 1e6 * m->mats * m->length_ft))
        march->status = SIM_UNSTABLE;
    march->mat = mat;
    march->t_s = t_s;
    return march->status == SIM_OK;
}

static void begin(struct landing *l, bool prunes)
{
    struct model *m = &l->model;
    m->prunes = false;
    model_start(m, l->z);
    l->slides = l->heaves = (struct part){0, m->mats - 1, 0, 0};
    for (int j = 0; j <= m->mats; j++)
        l->reach_ft[j] = fmin(fmax(l->gap0_ft[j], 0.0), l->slack_ft);
    memset(l->push_lb, 0, 3 * ((size_t)m->mats + 2) * sizeof *l->push_lb);
    if (l->mods)
        mods_reset(l->mods);
    if (!prunes)
        return;
    stretch_joints(l);
    l->slides.last = l->heaves.last = -1;
    for (int n = 0; n < m->mats; n++) {
        if (l->z[m->size + 2 * n + 1] != 0.0 ||
            fabs(l->tension_lb[n + 1] - l->tension_lb[n]) > (m->law == SIM_NONE ? 0.0 : m->weight_limit_lb))
            take_in(&l->slides, m, n - 1, n + 1);
        if (!mat_rests(l, n) || (m->tilt_ft && (l->tension_lb[n] != 0.0 || l->tension_lb[n + 1] != 0.0)))
            take_in(&l->heaves, m, n - m->tail, n + m->tail);
    }
}

static void run_march(struct landing *l, struct march *march, const struct sim_options *options)
{
    bool prunes = !options->no_prune;
    struct model *m = &l->model;
    struct sim_wheel wheel;
    struct sim_touch touch[SIM_TOUCH_MAX];
    double h = march->h_s, begin_ms = pass_clock_ms();
    double *p = l->z, *v = l->z + m->size;
    begin(l, prunes);
    sim_wheel_start(&wheel, l->scene);
    take(l, march, 0.0);
    for (uint64_t i = 0; i < march->steps; i++) {
        double from_s = i == 0 ? 0.0 : ((double)i - 0.5) * h, to_s = ((double)i + 0.5) * h;
        double t_s = (double)(i + 1) * h * (i + 1 == march->steps ? 1.0 + 1e-11 : 1.0);
        int count = sim_wheel_span(&wheel, from_s, to_s, touch);
        place_wheel(m, touch, count);
        if (prunes) {
            follow_slides(l, touch, count);
            follow_heaves(l);
            slide_what_heaves(l);
        }
        bool heaves = l->heaves.last >= l->heaves.first;
        if (l->mods)
            brace_slides(l, touch, count, to_s - from_s);
        stretch_joints(l);
        if (heaves) {
            m->first = l->heaves.first;
            m->last = l->heaves.last;
            model_sample_shape(m, l->z);
            if (m->brace_lb)
                brace_heaves(l);
        }
        if (heaves)
            kick_heaves(l, to_s - from_s);
        march->events += kick_slides(l, touch, count, to_s - from_s);
        for (int n = l->slides.first; n <= l->slides.last; n++)
            p[2 * n + 1] += h * v[2 * n + 1];
        for (int j = m->first; heaves && j <= m->last + 1; j++)
            p[2 * j] += h * v[2 * j];
        int live = l->slides.last - l->slides.first + 1;
        march->awake_s += live * h;
        march->mats_max = live > march->mats_max ? live : march->mats_max;
        march->done = i + 1;
        if (i % LOOK_STEPS == 0 && !sound(l, march, t_s))
            break;
        if (i % LOOK_STEPS == 0 && options->overrun_ft > 0.0)
            note_overrun(l, march, options->overrun_ft);
        if (march->record.next_s <= t_s)
            take(l, march, t_s);
        if (i % STEPS_BETWEEN_ASKING == 0 && options->go_on &&
            !options->go_on(options->go_on_ctx, march->number, (double)i / (double)march->steps)) {
            march->status = SIM_INTERRUPTED;
            march->mat = l->slides.first + 1;
            march->t_s = t_s;
            break;
        }
    }
    for (int n = l->slides.first; n <= l->slides.last; n++)
        march->speed_end_ft_s = fmax(march->speed_end_ft_s, fabs(v[2 * n + 1]));
    if (l->mods) {
        struct mods_view view = view_of(l);
        march->mods = mods_finish(l->mods, &view);
    }
    march->ms = pass_clock_ms() - begin_ms;
}

static enum mr_status start_march(struct landing *l, struct march *march, const struct sim_options *options,
                                  uint64_t steps, struct sim_result *result, struct error *error)
{
    *march = (struct march){.steps = steps, .h_s = sim_scene_end_s(l->scene) / (double)steps,
                             .number = ++result->passes};
    if (sim_record_make(&march->record, l->scene, options, error) != MR_OK)
        return error->status;
    run_march(l, march, options);
    if (l->mods && !march->mods)
        return error_set(error, MR_FULL, "out of memory: the modifications of %d mats; use a smaller N", l->model.mats);
    result->rhs += march->done;
    return MR_OK;
}

static enum mr_status keep_most(double **to, const double *from, size_t count, struct error *error)
{
    *to = calloc(count + 1, sizeof **to);
    if (!*to)
        return error_set(error, MR_FULL, "out of memory: the result of %zu mats; use a smaller N", count);
    memcpy(*to + 1, from, count * sizeof **to);
    return MR_OK;
}

static enum mr_status answer(struct landing *l, struct march *fine, const struct march *coarse,
                             struct sim_result *result, struct error *error)
{
    result->dt_s = fine->h_s;
    result->checked_dt_s = coarse->h_s;
    result->pass_ms = fine->ms;
    result->steps = fine->done;
    result->rejected = result->rhs - fine->done;
    result->events = fine->events;
    result->mats_max = fine->mats_max;
    result->mats_mean = fine->awake_s / ((double)fine->done * fine->h_s);
    result->crest_deg = fine->crest_deg;
    result->crest_joint = fine->crest_joint;
    result->sag_deg = fine->sag_deg;
    result->sag_joint = fine->sag_joint;
    result->overruns = fine->overruns;
    result->first_crest = fine->first_crest;
    result->first_crest_wheel = fine->first_crest_wheel;
    memcpy(result->overrun, fine->overrun, sizeof result->overrun);
    size_t joints = (size_t)l->model.mats + 1;
    if (keep_most(&result->push_lb, l->push_lb, joints, error) != MR_OK ||
        keep_most(&result->pull_lb, l->pull_lb, joints, error) != MR_OK ||
        keep_most(&result->rise_ft, l->rise_ft, joints, error) != MR_OK)
        return error->status;
    if (fine->mods && coarse->mods)
        fine->mods->error_lb = CAUTION * mods_difference_lb(fine->mods, coarse->mods);
    result->mods = fine->mods;
    fine->mods = NULL;
    return planar_deliver(&l->model, l->z, &fine->record, fine->max_lift_ft, fine->speed_end_ft_s, result, error);
}

/* How far two marches are apart. */
struct apart {
    struct sim_difference u;
    double lift_ft;
};

static struct apart apart_of(const struct march *a, const struct march *b)
{
    return (struct apart){sim_record_difference(&a->record, &b->record),
                          fmax(sim_record_lift_difference(&a->record, &b->record), fabs(a->max_lift_ft - b->max_lift_ft))};
}

/* Whether two complete marches say the same. */
static bool agree(const struct landing *l, const struct march *coarse, const struct march *fine, struct apart apart)
{
    double threshold = planar_bow_threshold_ft(l->scene), lift = fmin(coarse->max_lift_ft, fine->max_lift_ft);
    return apart.u.u_ft <= DISAGREEMENT * sim_record_peak(&fine->record).u_ft + 1e-9 * l->model.length_ft &&
           apart.lift_ft <= DISAGREEMENT * fmax(lift, threshold) &&
           (coarse->max_lift_ft > threshold) == (fine->max_lift_ft > threshold);
}

/* Sampled switches fall differently at every step, so two marches can be as close as they like by chance, twice as many
 * steps never are: where the march before those two says the same, its difference counts as well. */
static void state_error(const struct landing *l, const struct march *rough, const struct march *coarse, struct apart apart,
                        struct sim_result *result)
{
    result->error_u_ft = CAUTION * apart.u.u_ft;
    result->error_lift_ft = CAUTION * apart.lift_ft;
    if (rough->done == 0 || rough->status != SIM_OK)
        return;
    struct apart before = apart_of(rough, coarse);
    if (!agree(l, rough, coarse, before))
        return;
    result->error_u_ft = fmax(result->error_u_ft, before.u.u_ft);
    result->error_lift_ft = fmax(result->error_lift_ft, before.lift_ft);
}

static void fail(struct sim_result *result, enum sim_status status, int mat, double t_s)
{
    result->status = status;
    result->mat = mat;
    result->t_s = t_s;
}

static void drop(struct march *march)
{
    sim_record_free(&march->record);
    free(march->mods);
    *march = (struct march){0};
}

/* Marches at a step and at half of it until two say the same. `rough` has been run before them, or is empty. */
static enum mr_status run_pairs(struct landing *l, const struct sim_options *options, uint64_t steps, struct march *rough,
                                struct sim_result *result, struct error *error)
{
    struct march coarse = {0}, fine = {0};
    struct apart apart = {0};
    if (start_march(l, &coarse, options, steps, result, error) != MR_OK)
        return error->status;
    for (int halvings = 0;; halvings++) {
        if (coarse.status == SIM_INTERRUPTED) {
            fail(result, coarse.status, coarse.mat, coarse.t_s);
            fine = coarse;
            coarse.record = (struct sim_record){0};
            coarse.mods = NULL;
            break;
        }
        if (start_march(l, &fine, options, 2 * coarse.steps, result, error) != MR_OK)
            break;
        if (fine.status == SIM_INTERRUPTED) {
            fail(result, fine.status, fine.mat, fine.t_s);
            break;
        }
        const struct march *failed = fine.status != SIM_OK ? &fine : coarse.status != SIM_OK ? &coarse : NULL;
        if (fine.status != SIM_OK && fine.status == coarse.status) {
            fail(result, fine.status, fine.mat, fine.t_s);
            break;
        }
        apart = failed ? apart : apart_of(&coarse, &fine);
        if (!failed && agree(l, &coarse, &fine, apart)) {
            state_error(l, rough, &coarse, apart, result);
            break;
        }
        if (options->dt_s > 0.0 || halvings == MOST_HALVINGS || 4.0 * (double)coarse.steps > MOST_STEPS) {
            enum sim_status status = options->dt_s > 0.0 ? SIM_UNSTABLE : SIM_STEP_UNDERFLOW;
            fail(result, failed ? failed->status : status, failed ? failed->mat : apart.u.mat,
                 failed ? failed->t_s : apart.u.t_s);
            break;
        }
        drop(rough);
        *rough = coarse;
        coarse = fine;
        fine.record = (struct sim_record){0};
        fine.mods = NULL;
    }
    if (error->status == MR_OK)
        answer(l, &fine, &coarse, result, error);
    drop(&coarse);
    drop(&fine);
    return error->status;
}

/* The step, the steps twice and four times as long; the longest only where that is stable. */
static enum mr_status run_checked(struct landing *l, const struct sim_options *options, uint64_t steps,
                                  struct sim_result *result, struct error *error)
{
    struct march rough = {0};
    uint64_t fewest = (steps + 1) / 2;
    bool stable = sim_scene_end_s(l->scene) / (double)fewest <= result->dt_limit_s;
    if (!stable || start_march(l, &rough, options, fewest, result, error) == MR_OK) {
        if (rough.status == SIM_INTERRUPTED) {
            fail(result, rough.status, rough.mat, rough.t_s);
            answer(l, &rough, &rough, result, error);
        } else {
            run_pairs(l, options, steps, &rough, result, error);
        }
    }
    drop(&rough);
    return error->status;
}

/* The soil's dampers are implicit and set no limit. */
static double step_limit_s(struct landing *l, double hop_s)
{
    struct model *m = &l->model;
    double cv = m->cv;
    model_start(m, l->z);
    m->cv = 0.0;
    double rate = model_fastest_rate(m, l->z);
    m->cv = cv;
    if (l->mods)
        rate = sqrt(rate * rate + mods_rate2(l->mods, m->mass_slug, m->inertia));
    return fmin(rate > 0.0 ? STABLE / rate : HUGE_VAL, hop_s);
}

static enum mr_status run_with(struct landing *l, const struct sim_options *options, struct sim_result *result,
                               struct error *error)
{
    struct sim_wheel wheel;
    double end_s = sim_scene_end_s(l->scene);
    sim_wheel_start(&wheel, l->scene);
    double hop_s = l->scene->length_ft / sim_wheel_fastest_ft_s(&wheel); /* INFINITY for an aircraft that stands */
    result->dt_limit_s = step_limit_s(l, hop_s);
    double h = options->dt_s > 0.0 ? options->dt_s
                                   : fmin((options->single ? 2.0 : 1.0) * STEP_SHARE * result->dt_limit_s, fmin(HOP_SHARE * hop_s, end_s / LEAST_STEPS));
    double steps = ceil(end_s / h * (1.0 - 1e-12));
    if (h > result->dt_limit_s) {
        result->dt_s = h;
        fail(result, SIM_UNSTABLE, sim_wheel_first_mat(&wheel), 0.0);
        return MR_OK;
    }
    if (!(steps <= MOST_STEPS))
        return error_set(error, MR_USAGE, "too many steps: %s: %g s in steps of %g s; give a shorter tend, a larger dt or "
                                          "solver implicit",
                         l->scene->name[0] ? l->scene->name : "scene", end_s, h);
    if (options->single) {
        struct march only = {0};
        if (start_march(l, &only, options, (uint64_t)steps, result, error) != MR_OK)
            return error->status;
        result->first_crest = only.first_crest;
        result->first_crest_wheel = only.first_crest_wheel;
        if (only.status != SIM_OK)
            fail(result, only.status, only.mat, only.t_s);
        result->t_end_s = fmin(result->t_end_s, (double)only.done * only.h_s);
        answer(l, &only, &only, result, error);
        sim_record_free(&only.record);
        return error->status;
    }
    bool room = 2.0 * h <= result->dt_limit_s; /* the check at double the step is stable too */
    return run_checked(l, options, (uint64_t)ceil(room ? steps / 2.0 : steps), result, error);
}

static void lay_ground(struct landing *l)
{
    struct model *m = &l->model;
    const double *ground = l->scene->ground_ft.values;
    for (int n = 0; n < m->mats; n++) {
        l->tilt_ft[n] = ground ? ground[n] - ground[n + 1] : 0.0;
        double s = l->tilt_ft[n] / m->length_ft;
        l->rest_cos[n] = sqrt(1.0 - s * s);
        m->tilt_most_ft = fmax(m->tilt_most_ft, fabs(l->tilt_ft[n]));
    }
    if (m->tilt_most_ft > 0.0)
        m->tilt_ft = l->tilt_ft;
}

/* Arrays of a landing; the model is made. */
static enum mr_status lay_out(struct landing *l, struct error *error)
{
    struct model *m = &l->model;
    size_t length = 2 * (size_t)m->size, joints = (size_t)m->mats + 2;
    double *storage = calloc(2 * length + 14 * joints, sizeof *storage);
    if (!storage)
        return error_set(error, MR_FULL, "out of memory: %d mats; use a smaller N", m->mats);
    l->z = storage;
    l->accel = storage + length;
    l->u = storage + 2 * length;
    l->v = l->u + joints;
    l->gap0_ft = l->v + joints;
    l->grit_lb = l->gap0_ft + joints;
    l->reach_ft = l->grit_lb + joints;
    l->tension_lb = l->reach_ft + joints;
    l->height = l->tension_lb + joints;
    l->push_lb = l->height + joints;
    l->pull_lb = l->push_lb + joints;
    l->rise_ft = l->pull_lb + joints;
    l->tilt_ft = l->rise_ft + joints;
    l->rest_cos = l->tilt_ft + joints;
    lay_ground(l);
    m->given_lb = l->tension_lb;
    if (l->mods && (l->mods->banded || l->mods->stiffened)) {
        m->brace_lb = l->rest_cos + joints;
        m->brace_lb_ft = m->brace_lb + joints;
    }
    l->slack_ft = m->slack_ft;
    m->slack_ft = 0.0; /* the joints are this file's */
    for (int j = 0; j <= m->mats; j++) {
        l->gap0_ft[j] = sim_scene_joint(&l->scene->gap0_ft, j + 1);
        l->grit_lb[j] = sim_scene_joint(&l->scene->grit_lb, j + 1);
        l->gritty = l->gritty || l->grit_lb[j] > 0.0;
    }
    return MR_OK;
}

enum mr_status landing_run(const struct sim_scene *scene, const struct sim_options *options, struct sim_result *result,
                           struct error *error)
{
    struct landing l = {.scene = scene};
    double begin_ms = pass_clock_ms();
    if (scene->friction > 0.0 && (scene->friction_law == SIM_TANH || scene->friction_law == SIM_SIGN))
        return error_set(error, MR_USAGE, "not available: %s: friction tanh or sign with solver fixed; give stick, or "
                                          "solver event",
                         scene->name[0] ? scene->name : "scene");
    if (model_make(&l.model, scene, true, error) != MR_OK)
        return error->status;
    result->solver = "fixed";
    result->mats = scene->mats;
    result->t_end_s = sim_scene_end_s(scene);
    model_describe(&l.model, result);
    sim_result_note(result, "error estimate: the larger of twice the difference to the run at double the step and that run's difference to "
                            "the run at four times the step");
    if (mods_make(&l.mods, scene, error) == MR_OK && lay_out(&l, error) == MR_OK) {
        if (l.mods)
            mods_describe(l.mods, result);
        run_with(&l, options, result, error);
    }
    result->run_ms = pass_clock_ms() - begin_ms;
    mods_free(l.mods);
    model_free(&l.model);
    free(l.z);
    return error->status;
}
