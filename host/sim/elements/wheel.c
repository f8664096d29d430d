#include "host/sim/elements/wheel.h"

#include <math.h>

#define EDGE  1e-12 /* README.md: a wheel at x = n L is on mat n + 1 */
#define INNER 1e-10 /* share of a station within which EDGE and roundings may count */

/* fmin and fmax are calls, for the sake of NaN. */
static inline double least(double a, double b)
{
    return a < b ? a : b;
}

static inline double most(double a, double b)
{
    return a > b ? a : b;
}

void sim_wheel_start(struct sim_wheel *wheel, const struct sim_scene *scene)
{
    double end_s = sim_scene_end_s(scene);
    wheel->straight[0] = (struct sim_path_row){0.0, scene->s0_ft, scene->force_lb};
    wheel->straight[1] = (struct sim_path_row){
        2.0 * end_s, scene->s0_ft + scene->vac_ft_s * 2.0 * end_s, scene->force_lb};
    wheel->rows = scene->path_count > 0 ? scene->path : wheel->straight;
    wheel->count = scene->path_count > 0 ? scene->path_count : 2;
    wheel->cursor = 0;
    wheel->at_s = (double)NAN;
    wheel->mat = 0;
    wheel->from_ft = wheel->to_ft = 0.0;
    wheel->length_ft = scene->length_ft;
    wheel->mats = scene->mats;
    wheel->force_stop_s = scene->force_stop_s;
    wheel->thrust = scene->thrust;
    wheel->from_s = wheel->rows[0].t_s;
    wheel->instead = NULL;
    wheel->rider = NULL;
}

void sim_wheel_yield(struct sim_wheel *wheel, sim_wheel_span_fn *instead, void *rider)
{
    wheel->from_s = (double)INFINITY;
    wheel->instead = instead;
    wheel->rider = rider;
}

/* Row c such that t is within row c..c+1; moves forward only. */
static size_t seek(struct sim_wheel *wheel, double t_s)
{
    while (wheel->cursor + 2 < wheel->count && t_s >= wheel->rows[wheel->cursor + 1].t_s)
        wheel->cursor++;
    return wheel->cursor;
}

static double along(const struct sim_path_row *row, double t_s, double from, double to)
{
    double length_s = row[1].t_s - row[0].t_s;
    if (length_s <= 0.0 || t_s >= row[1].t_s)
        return to;
    return from + (to - from) * ((t_s - row[0].t_s) / length_s);
}

static double impulse_lb_s(const struct sim_wheel *wheel, size_t c, double t0_s, double t1_s)
{
    const struct sim_path_row *only = &wheel->rows[c];
    double sum = 0.0;
    t1_s = least(t1_s, wheel->force_stop_s);
    if (t0_s >= only[0].t_s && t1_s > t0_s && t1_s < only[1].t_s)
        return (t1_s - t0_s) * along(only, 0.5 * (t0_s + t1_s), only[0].force_lb, only[1].force_lb);
    for (; c + 1 < wheel->count && wheel->rows[c].t_s < t1_s; c++) {
        const struct sim_path_row *row = &wheel->rows[c];
        double from_s = most(t0_s, row[0].t_s);
        double to_s = least(t1_s, row[1].t_s);
        if (to_s > from_s) {
            double middle_s = 0.5 * (from_s + to_s); /* of a line: its mean */
            sum += (to_s - from_s) * along(row, middle_s, row[0].force_lb, row[1].force_lb);
        }
    }
    return sum;
}

/* 0 before the runway, mats + 1 behind it. Mostly the one of last time. */
static int mat_at(struct sim_wheel *wheel, double x_ft)
{
    if (x_ft > wheel->from_ft && x_ft < wheel->to_ft)
        return wheel->mat;
    double mat = floor(x_ft / wheel->length_ft + EDGE) + 1.0;
    if (mat < 1.0)
        return 0;
    if (mat > wheel->mats)
        return wheel->mats + 1;
    wheel->mat = (int)mat;
    wheel->from_ft = (mat - 1.0) * wheel->length_ft * (1.0 + INNER);
    wheel->to_ft = mat * wheel->length_ft * (1.0 - INNER);
    return wheel->mat;
}

static int add(const struct sim_wheel *wheel, struct sim_touch *touch, int count, int mat,
               double thrust_lb, double share)
{
    if (mat < 1 || mat > wheel->mats)
        return count;
    touch[count] = (struct sim_touch){mat, thrust_lb, share};
    return count + 1;
}

int sim_wheel_span(struct sim_wheel *wheel, double t0_s, double t1_s, struct sim_touch *touch)
{
    if (t1_s <= wheel->from_s)
        return wheel->instead ? wheel->instead(wheel, t0_s, t1_s, touch) : 0;
    size_t c0 = seek(wheel, t0_s);
    const struct sim_path_row *first = &wheel->rows[c0];
    double x0_ft = t0_s == wheel->at_s
                     ? wheel->at_ft
                     : along(first, most(t0_s, first->t_s), first[0].x_ft, first[1].x_ft);
    double force_lb = impulse_lb_s(wheel, c0, t0_s, t1_s) / (t1_s - t0_s);
    const struct sim_path_row *last = &wheel->rows[seek(wheel, t1_s)];
    double x1_ft = along(last, t1_s, last[0].x_ft, last[1].x_ft);
    wheel->at_s = t1_s; /* where the next span begins */
    wheel->at_ft = x1_ft;

    double low_ft = least(x0_ft, x1_ft);
    double high_ft = most(x0_ft, x1_ft);
    int low = mat_at(wheel, low_ft);
    int high = mat_at(wheel, high_ft);
    bool jump = wheel->thrust == SIM_JUMP;
    int count = 0;
    if (low == high) {
        count = add(wheel, touch, count, low, jump ? force_lb : 0.0, 1.0);
    } else {
        double share =
            least(1.0, most(0.0, ((high - 1) * wheel->length_ft - low_ft) / (high_ft - low_ft)));
        count = add(wheel, touch, count, low, jump ? force_lb * share : 0.0, share);
        count = add(wheel, touch, count, high, jump ? force_lb * (1.0 - share) : 0.0, 1.0 - share);
    }
    if (jump)
        return count;
    double middle_ft = 0.5 * (low_ft + high_ft);
    int middle = mat_at(wheel, middle_ft);
    if (middle >= 1 && middle <= wheel->mats) {
        double w = middle_ft / wheel->length_ft - 0.5;
        double i = floor(w);
        double r = w - i;
        if (i < 0.0) {
            count = add(wheel, touch, count, 1, force_lb, 0.0);
        } else {
            count = add(wheel, touch, count, (int)i + 1, force_lb * (1.0 - r), 0.0);
            count = add(wheel, touch, count, (int)i + 2, force_lb * r, 0.0);
        }
    }
    return count;
}

bool sim_wheel_is_over(const struct sim_wheel *wheel, double t_s)
{
    return t_s >= wheel->rows[wheel->count - 1].t_s;
}

double sim_wheel_fastest_ft_s(const struct sim_wheel *wheel)
{
    double fastest = 0.0;
    for (size_t i = 0; i + 1 < wheel->count; i++) {
        const struct sim_path_row *row = &wheel->rows[i];
        double way_ft = fabs(row[1].x_ft - row[0].x_ft);
        if (way_ft > 0.0)
            /* a jump: division by 0, INFINITY */
            fastest = most(fastest, way_ft / (row[1].t_s - row[0].t_s));
    }
    return fastest;
}

int sim_wheel_first_mat(const struct sim_wheel *wheel)
{
    struct sim_wheel fresh = *wheel;
    int mat = mat_at(&fresh, wheel->rows[0].x_ft);
    return mat < 1 ? 1 : mat > wheel->mats ? wheel->mats : mat;
}
