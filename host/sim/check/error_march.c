#include "host/sim/check/error_march.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"
#include "host/sim/elements/wheel.h"
#include "host/sim/scene/scene_keys.h"

#define LOCATE_S   1e-9
#define STALLS     20000
#define JOINT_SLOP 1e-13 /* ft or ft/s: rounding, not a switch */
#define MAT_SLOP   1e-12 /* lb or ft/s */
#define STAGES     4

enum joint_mode { HOOKED, OPEN, HELD, YIELDING, PRESSED };

/* Mats 1..N with the ground at 0 and N+1; joint j between mats j-1 and j. */
struct march {
    const struct sim_scene *scene;
    int mats;
    double mass_slug, kl, cl, slack_ft, limit_lb, load_lb;
    bool sticks, left_free, right_free;
    struct span span;
    int first, last; /* mats that are integrated */
    double *u, *v, *u_to, *v_to, *u_at, *v_at, *a[STAGES], *reach, *gap0, *grit_lb;
    signed char *joint, *slide;
    double *storage;
    signed char *modes;
    uint64_t rhs;
};

static double opening_ft(const struct march *g, int j, const double *u)
{
    return g->gap0[j] + (u[j] - u[j - 1]);
}

static bool transmits(const struct march *g, int j)
{
    return !(j == 1 && g->left_free) && !(j == g->mats + 1 && g->right_free);
}

static double tension_lb(const struct march *g, int j, const double *u, const double *v)
{
    if (!transmits(g, j))
        return 0.0;
    double open = opening_ft(g, j, u), damper = g->cl * (v[j] - v[j - 1]);
    switch ((enum joint_mode)g->joint[j]) {
    case HOOKED: return g->kl * (open - g->slack_ft) + damper;
    case OPEN: return 0.0;
    case HELD: return fmin(0.0, fmax(-g->grit_lb[j], g->kl * (open - g->reach[j]) + damper));
    case YIELDING: return -g->grit_lb[j];
    case PRESSED: break;
    }
    return g->kl * open + damper;
}

static double thrust_lb(const struct march *g, double t_s, int mat)
{
    double rate;
    return g->span.mat < 0 ? 0.0
                           : span_thrust_lb(&g->span, g->scene->length_ft, t_s, mat - 1, &rate);
}

static double limit_lb(const struct march *g, int mat)
{
    return g->limit_lb + (g->span.mat == mat - 1 ? g->load_lb : 0.0);
}

static double push_lb(const struct march *g, double t_s, int mat, const double *u, const double *v)
{
    return tension_lb(g, mat + 1, u, v) - tension_lb(g, mat, u, v) + thrust_lb(g, t_s, mat);
}

static void rates(struct march *g, double t_s, const double *u, const double *v, double *a)
{
    double left = tension_lb(g, g->first, u, v);
    int under = g->span.share >= -1 && g->span.mat >= 0 ? g->span.share + 1 : g->span.mat + 1;
    g->rhs++;
    for (int n = g->first; n <= g->last; n++) {
        double right = tension_lb(g, n + 1, u, v), x = right - left;
        left = right;
        if (g->slide[n] == 0) {
            a[n] = 0.0;
            continue;
        }
        if (n >= under && n <= under + 1)
            x += thrust_lb(g, t_s, n);
        a[n] = (x - (g->sticks ? g->slide[n] * limit_lb(g, n) : 0.0)) / g->mass_slug;
    }
}

static void step(struct march *g, double t_s, double h)
{
    static const double part[STAGES] = {0.0, 0.5, 0.5, 1.0};
    const double *before_v = g->v;
    memcpy(g->u_at + g->first - 1, g->u + g->first - 1,
           (size_t)(g->last - g->first + 3) * sizeof *g->u);
    memcpy(g->v_at + g->first - 1, g->v + g->first - 1,
           (size_t)(g->last - g->first + 3) * sizeof *g->v);
    memcpy(g->u_to + g->first - 1, g->u + g->first - 1,
           (size_t)(g->last - g->first + 3) * sizeof *g->u);
    memcpy(g->v_to + g->first - 1, g->v + g->first - 1,
           (size_t)(g->last - g->first + 3) * sizeof *g->v);
    for (int i = 0; i < STAGES; i++) {
        double share = h * (i == 0 || i == 3 ? 1.0 : 2.0) / 6.0;
        double to = i < 3 ? h * part[i + 1] : 0.0;
        rates(g, t_s + part[i] * h, g->u_at, g->v_at, g->a[i]);
        for (int n = g->first; n <= g->last; n++) {
            double v = g->v_at[n];
            g->u_to[n] += share * v;
            g->v_to[n] += share * g->a[i][n];
            g->u_at[n] = g->u[n] + to * v;
            g->v_at[n] = before_v[n] + to * g->a[i][n];
        }
    }
}

/* Negative when the joint's mode does not fit. A mode can end in one of two ways; the nearer one
 * counts. */
static double joint_margin(const struct march *g, int j, const double *u, const double *v)
{
    if (!transmits(g, j))
        return 1.0;
    double open = opening_ft(g, j, u), rate = v[j] - v[j - 1];
    switch ((enum joint_mode)g->joint[j]) {
    case HOOKED: return open - g->slack_ft;
    case OPEN: return fmin(g->slack_ft - open, rate);
    case HELD: return fmin(g->reach[j] - open, open - g->reach[j] + g->grit_lb[j] / g->kl);
    case YIELDING: return fmin(-rate, open + g->grit_lb[j] / g->kl);
    case PRESSED: break;
    }
    return -open;
}

static void change_joint(struct march *g, int j, const double *u, const double *v)
{
    double open = opening_ft(g, j, u), rate = v[j] - v[j - 1], give = g->grit_lb[j] / g->kl;
    switch ((enum joint_mode)g->joint[j]) {
    case HOOKED:
        g->reach[j] = g->slack_ft;
        g->joint[j] = g->grit_lb[j] > 0.0 ? HELD : YIELDING;
        break;
    case OPEN:
        if (open > g->slack_ft) {
            g->joint[j] = HOOKED;
        } else {
            g->reach[j] = fmax(0.0, open);
            g->joint[j] = open <= 0.0 ? PRESSED : g->grit_lb[j] > 0.0 ? HELD : YIELDING;
        }
        break;
    case HELD: g->joint[j] = open >= g->reach[j] ? OPEN : YIELDING; break;
    case YIELDING:
        if (open + give <= 0.0) {
            g->reach[j] = 0.0;
            g->joint[j] = PRESSED;
        } else {
            g->reach[j] = open + give;
            g->joint[j] = g->grit_lb[j] > 0.0 || rate <= 0.0 ? HELD : OPEN;
        }
        break;
    case PRESSED: g->joint[j] = OPEN; break;
    }
}

static double mat_margin(const struct march *g, double t_s, int n, const double *u, const double *v)
{
    if (!g->sticks)
        return 1.0;
    if (g->slide[n] != 0)
        return g->slide[n] * v[n];
    return limit_lb(g, n) - fabs(push_lb(g, t_s, n, u, v));
}

static void change_mat(struct march *g, double t_s, int n, const double *u, double *v)
{
    v[n] = 0.0;
    double x = push_lb(g, t_s, n, u, v);
    g->slide[n] = fabs(x) <= limit_lb(g, n) ? 0 : x > 0.0 ? 1 : -1;
}

/* When the first mode stops fitting, as if margins were straight between the start and h; INFINITY:
 * all fit. */
static double first_miss_s(const struct march *g, double t_s, double h)
{
    double first = (double)INFINITY;
    for (int j = g->first; j <= g->last + 1; j++) {
        double after = joint_margin(g, j, g->u_to, g->v_to);
        if (after < -JOINT_SLOP) {
            double before = fmax(0.0, joint_margin(g, j, g->u, g->v));
            first = fmin(first, h * before / (before - after));
        }
    }
    for (int n = g->first; n <= g->last; n++) {
        double after = mat_margin(g, t_s + h, n, g->u_to, g->v_to);
        if (after < -MAT_SLOP) {
            double before = fmax(0.0, mat_margin(g, t_s, n, g->u, g->v));
            first = fmin(first, h * before / (before - after));
        }
    }
    return first;
}

/* Mats under the wheel and one beyond the outermost moving ones. */
static void choose_range(struct march *g)
{
    if (!g->sticks)
        return;
    int low = g->mats, high = 1;
    for (int n = g->first; n <= g->last; n++) {
        if (g->slide[n] != 0) {
            low = n < low ? n : low;
            high = n > high ? n : high;
        }
    }
    if (g->span.mat >= 0) {
        /* with shared thrust one of them has a part */
        int left = g->span.mat, right = g->span.mat + 2;
        low = left < low ? left : low;
        high = right > high ? right : high;
    }
    if (low > high)
        low = high = g->first;
    g->first = low > 2 ? low - 1 : 1;
    g->last = high < g->mats ? high + 1 : g->mats;
}

/* Modes that do not fit the present state: after a switch, or a hop of the wheel, those of others
 * may not. */
static void settle(struct march *g, double t_s)
{
    bool changed = true;
    for (int round = 0; changed && round < 8; round++) {
        changed = false;
        for (int j = g->first; j <= g->last + 1; j++) {
            if (joint_margin(g, j, g->u, g->v) < -JOINT_SLOP) {
                change_joint(g, j, g->u, g->v);
                changed = true;
            }
        }
        for (int n = g->first; n <= g->last; n++) {
            if (mat_margin(g, t_s, n, g->u, g->v) < -MAT_SLOP) {
                change_mat(g, t_s, n, g->u, g->v);
                changed = true;
            }
        }
        choose_range(g);
    }
}

/* The state after the step becomes the present one; mats outside the range are as they were. */
static void accept(struct march *g)
{
    size_t bytes = (size_t)(g->last - g->first + 1) * sizeof *g->u;
    memcpy(g->u + g->first, g->u_to + g->first, bytes);
    memcpy(g->v + g->first, g->v_to + g->first, bytes);
}

/* One step of at most h, ended at the first switch; returns its length. */
static double advance(struct march *g, double t_s, double h, bool *event)
{
    double fits = 0.0, misses = h;
    step(g, t_s, h);
    double miss = first_miss_s(g, t_s, h);
    *event = isfinite(miss);
    for (int i = 0;
         isfinite(miss) && misses - fits > LOCATE_S && misses - miss > LOCATE_S && i < 60; i++) {
        double at = i % 6 == 5 ? 0.5 * (fits + misses)
                               : fmin(fmax(miss, fits) + 0.5 * LOCATE_S, misses);
        step(g, t_s, at);
        double next = first_miss_s(g, t_s, at);
        if (isfinite(next)) {
            misses = at;
            miss = next;
        } else {
            fits = at;
            /* margins are curved: it is later than thought */
            miss = fmax(miss, fits + 0.05 * (misses - fits));
        }
    }
    if (*event) {
        step(g, t_s, misses);
        h = misses;
    }
    accept(g);
    if (!*event)
        return h;
    settle(g, t_s + h);
    return h;
}

static void start(struct march *g, int first_mat)
{
    const struct sim_scene *s = g->scene;
    for (int j = 1; j <= g->mats + 1; j++) {
        g->gap0[j] = sim_scene_joint(&s->gap0_ft, j);
        g->grit_lb[j] = sim_scene_joint(&s->grit_lb, j);
        g->reach[j] = fmin(fmax(g->gap0[j], 0.0), g->slack_ft);
        g->joint[j] = (signed char)(g->gap0[j] > g->slack_ft ? HOOKED
                                    : g->gap0[j] < 0.0       ? PRESSED
                                                             : OPEN);
    }
    g->first = 1;
    g->last = g->mats;
    if (!g->sticks)
        memset(g->slide, 1, (size_t)g->mats + 2);
    int pushed = s->v0_mat > 0 ? s->v0_mat : first_mat;
    g->v[pushed] = s->v0_ft_s;
    if (s->v0_ft_s != 0.0)
        g->slide[pushed] = s->v0_ft_s > 0.0 ? 1 : -1;
}

static void run(struct march *g, const struct span_list *spans, struct sim_record *record,
                struct march_cost *cost, double dt_s)
{
    double t_s = 0.0;
    int stalls = 0;
    for (size_t i = 0; i < spans->count; i++) {
        g->span = spans->spans[i];
        int first = g->first, last = g->last;
        choose_range(g);
        g->first = first < g->first ? first : g->first;
        g->last = last > g->last ? last : g->last;
        settle(g, t_s);
        while (t_s < g->span.t1_s) {
            bool event;
            double until = fmin(g->span.t1_s, record->next_s);
            double left = until - t_s, h = left <= 1.000001 * dt_s ? left : dt_s;
            double done = advance(g, t_s, h, &event);
            cost->steps++;
            cost->events += event;
            stalls = event && done < 2.0 * LOCATE_S ? stalls + 1 : 0;
            t_s = !event && h == left ? until : t_s + done;
            if (record->next_s <= t_s)
                sim_record_take(record, t_s, g->u, g->v);
            if (stalls > STALLS) {
                cost->stalled = true;
                cost->t_s = t_s;
                return;
            }
        }
    }
    sim_record_take(record, t_s * (1.0 + 1e-11), g->u, g->v);
}

static enum mr_status make(struct march *g, const struct sim_scene *scene, struct error *error)
{
    size_t length = (size_t)scene->mats + 3;
    double **const arrays[] = {&g->u,     &g->v,    &g->u_to,   &g->v_to, &g->u_at,
                               &g->v_at,  &g->a[0], &g->a[1],   &g->a[2], &g->a[3],
                               &g->reach, &g->gap0, &g->grit_lb};
    const size_t count = sizeof arrays / sizeof arrays[0];
    *g = (struct march){
        .scene = scene,
        .mats = scene->mats,
        .mass_slug = scene->weight_lb / scene->g_ft_s2,
        .kl = scene->kl_lb_ft,
        .cl = scene->cl_lb_s_ft,
        .slack_ft = scene->slack_ft,
        .limit_lb = scene->friction * scene->weight_lb,
        .load_lb = scene->friction * scene->wheel_load_lb,
        .sticks = scene->friction > 0.0 && scene->friction_law != SIM_NONE,
        .left_free = scene->left == SIM_FREE,
        .right_free = scene->right == SIM_FREE,
    };
    if (g->sticks && scene->friction_law != SIM_STICK)
        return error_set(
            error, MR_USAGE,
            "no second method: %s: grit with this friction; give friction stick or none",
            scene->name[0] ? scene->name : "scene");
    for (int i = 0; i < SIM_ELEMENTS_MAX; i++) {
        if (scene->element[i] != 0.0)
            return error_set(error, MR_USAGE,
                             "no second method: %s: %s in a chain with grit; leave one of them out",
                             scene->name[0] ? scene->name : "scene", sim_element_keys[i]->name);
    }
    g->storage = xcalloc(count * length, sizeof *g->storage);
    g->modes = xcalloc(2 * length, sizeof *g->modes);
    for (size_t i = 0; i < count; i++)
        *arrays[i] = g->storage + i * length;
    g->joint = g->modes;
    g->slide = g->modes + length;
    return MR_OK;
}

enum mr_status march_run(struct sim_record *record, struct march_cost *cost,
                         const struct sim_scene *scene, double dt_s, struct error *error)
{
    struct march g;
    struct span_list spans = {0};
    const struct sim_options options = {0};
    double begin_s = monotonic_s();
    *record = (struct sim_record){0};
    *cost = (struct march_cost){0};
    if (make(&g, scene, error) == MR_OK && span_list_make(&spans, scene, error) == MR_OK) {
        sim_record_make(record, scene, &options);
        start(&g, spans.count > 0 && spans.spans[0].mat >= 0 ? spans.spans[0].mat + 1 : 1);
        run(&g, &spans, record, cost, dt_s);
        cost->rhs = g.rhs;
        cost->ms = 1e3 * (monotonic_s() - begin_s);
    }
    span_list_free(&spans);
    free(g.storage);
    free(g.modes);
    return error->status;
}
