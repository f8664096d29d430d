#include "host/sim/elements/wheel.h"

#include <math.h>
#include <stdlib.h>

#include "host/base/xmalloc.h"
#include "host/sim/elements/law.h"

#define EDGE_TOLERANCE  1e-12 /* in mats; README.md: a wheel at x = n L is on mat n + 1 */
/* In mats. Farther than this from a mat's edge, neither EDGE_TOLERANCE nor rounding has an
 * effect. */
#define INNER_TOLERANCE 1e-10

void sim_wheel_start(struct sim_wheel *wheel, const struct sim_scene *scene)
{
    double end_s = sim_scene_end_s(scene);
    wheel->straight_path[0] = (struct sim_path_row){0.0, scene->start_ft, scene->force_lb};
    wheel->straight_path[1] = (struct sim_path_row){
        2.0 * end_s, scene->start_ft + scene->vac_ft_s * 2.0 * end_s, scene->force_lb};
    wheel->rows = scene->path_count > 0 ? scene->path : wheel->straight_path;
    wheel->row_count = scene->path_count > 0 ? scene->path_count : 2;
    wheel->cursor = 0;
    wheel->span_end_s = (double)NAN;
    wheel->mat = 0;
    wheel->from_ft = wheel->to_ft = 0.0;
    wheel->length_ft = scene->length_ft;
    wheel->mats = scene->mats;
    wheel->force_stop_s = scene->force_stop_s;
    wheel->thrust = scene->thrust;
    wheel->airborne_until_s = wheel->rows[0].t_s;
}

/* Finds the row c of the path whose interval c..c+1 contains t. The search starts at the row found
 * by the previous call. */
static size_t find_row(struct sim_wheel *wheel, double t_s)
{
    while (wheel->cursor + 2 < wheel->row_count && t_s >= wheel->rows[wheel->cursor + 1].t_s)
        wheel->cursor++;
    return wheel->cursor;
}

static double interpolate_path(const struct sim_path_row *row, double t_s, double from, double to)
{
    double length_s = row[1].t_s - row[0].t_s;
    if (length_s <= 0.0 || t_s >= row[1].t_s || from == to)
        return to;
    return from + (to - from) * ((t_s - row[0].t_s) / length_s);
}

/* Mean force over t0..t1, limited to the range of the force. This makes the mean of a constant
 * thrust exact, so that a thrust exactly at the limit of friction stays there. */
static double mean_force_lb(const struct sim_wheel *wheel, size_t c, double t0_s, double t1_s)
{
    const struct sim_path_row *only = &wheel->rows[c];
    double stop_s = law_min(t1_s, wheel->force_stop_s), length_s = t1_s - t0_s;
    if (t0_s >= only[0].t_s && stop_s > t0_s && stop_s < only[1].t_s) {
        double force_lb = interpolate_path(only, 0.5 * (t0_s + stop_s), only[0].force_lb,
                                           only[1].force_lb);
        return stop_s < t1_s ? force_lb * ((stop_s - t0_s) / length_s) : force_lb;
    }
    double sum = 0.0, low_lb = (double)INFINITY, high_lb = -(double)INFINITY;
    if (t0_s < only[0].t_s || stop_s < t1_s || t1_s > wheel->rows[wheel->row_count - 1].t_s)
        /* during a part of the time there is no force, so the range includes 0 */
        low_lb = high_lb = 0.0;
    for (; c + 1 < wheel->row_count && wheel->rows[c].t_s < stop_s; c++) {
        const struct sim_path_row *row = &wheel->rows[c];
        double from_s = law_max(t0_s, row[0].t_s);
        double to_s = law_min(stop_s, row[1].t_s);
        if (to_s > from_s) {
            /* the mean of a linear force is its value in the middle */
            double middle_s = 0.5 * (from_s + to_s);
            double force_lb = interpolate_path(row, middle_s, row[0].force_lb, row[1].force_lb);
            sum += (to_s - from_s) * force_lb;
            low_lb = law_min(low_lb, force_lb);
            high_lb = law_max(high_lb, force_lb);
        }
    }
    return law_min(high_lb, law_max(low_lb, sum / length_s));
}

/* Returns the mat at x: 0 upfield of the runway, mats + 1 beyond it. It is usually the mat of the
 * last call. */
static int find_mat(struct sim_wheel *wheel, double x_ft)
{
    if (x_ft > wheel->from_ft && x_ft < wheel->to_ft)
        return wheel->mat;
    double mat = floor(x_ft / wheel->length_ft + EDGE_TOLERANCE) + 1.0;
    if (mat < 1.0)
        return 0;
    if (mat > wheel->mats)
        return wheel->mats + 1;
    wheel->mat = (int)mat;
    wheel->from_ft = (mat - 1.0) * wheel->length_ft * (1.0 + INNER_TOLERANCE);
    wheel->to_ft = mat * wheel->length_ft * (1.0 - INNER_TOLERANCE);
    return wheel->mat;
}

static int add_touch(const struct sim_wheel *wheel, struct sim_touch *touch, int count, int mat,
                     double thrust_lb, double share)
{
    if (mat < 1 || mat > wheel->mats)
        return count;
    touch[count] = (struct sim_touch){mat, thrust_lb, share};
    return count + 1;
}

/* Computes the most common kind of span quickly: one that follows the previous span on the same row
 * of the path and the same mat. Returns false for any other span. */
static bool try_same_mat_span(struct sim_wheel *wheel, double t0_s, double t1_s,
                              struct sim_touch *touch)
{
    const struct sim_path_row *row = &wheel->rows[wheel->cursor];
    if (!(t0_s == wheel->span_end_s && t0_s >= row[0].t_s && t1_s < row[1].t_s && t1_s > t0_s &&
          t1_s <= wheel->force_stop_s && wheel->thrust == SIM_THRUST_JUMP &&
          wheel->span_end_ft > wheel->from_ft && wheel->span_end_ft < wheel->to_ft))
        return false;
    double x_ft = interpolate_path(row, t1_s, row[0].x_ft, row[1].x_ft);
    if (!(x_ft > wheel->from_ft && x_ft < wheel->to_ft))
        return false;
    wheel->span_end_s = t1_s;
    wheel->span_end_ft = x_ft;
    *touch = (struct sim_touch){
        wheel->mat, interpolate_path(row, 0.5 * (t0_s + t1_s), row[0].force_lb, row[1].force_lb),
        1.0};
    return true;
}

int sim_wheel_compute_action(struct sim_wheel *wheel, double t0_s, double t1_s,
                             struct sim_touch *touch)
{
    if (t1_s <= wheel->airborne_until_s)
        return 0;
    if (try_same_mat_span(wheel, t0_s, t1_s, touch))
        return 1;
    size_t c0 = find_row(wheel, t0_s);
    const struct sim_path_row *first = &wheel->rows[c0];
    double x0_ft = t0_s == wheel->span_end_s ? wheel->span_end_ft
                                             : interpolate_path(first, law_max(t0_s, first->t_s),
                                                                first[0].x_ft, first[1].x_ft);
    double force_lb = mean_force_lb(wheel, c0, t0_s, t1_s);
    const struct sim_path_row *last = &wheel->rows[find_row(wheel, t1_s)];
    double x1_ft = interpolate_path(last, t1_s, last[0].x_ft, last[1].x_ft);
    wheel->span_end_s = t1_s; /* the next span starts here */
    wheel->span_end_ft = x1_ft;

    double low_ft = law_min(x0_ft, x1_ft);
    double high_ft = law_max(x0_ft, x1_ft);
    int low = find_mat(wheel, low_ft);
    int high = find_mat(wheel, high_ft);
    bool jump = wheel->thrust == SIM_THRUST_JUMP;
    int count = 0;
    if (low == high) {
        count = add_touch(wheel, touch, count, low, jump ? force_lb : 0.0, 1.0);
    } else {
        double share = law_min(
            1.0, law_max(0.0, ((high - 1) * wheel->length_ft - low_ft) / (high_ft - low_ft)));
        count = add_touch(wheel, touch, count, low, jump ? force_lb * share : 0.0, share);
        count = add_touch(wheel, touch, count, high, jump ? force_lb * (1.0 - share) : 0.0,
                          1.0 - share);
    }
    if (jump)
        return count;
    double middle_ft = 0.5 * (low_ft + high_ft);
    int middle = find_mat(wheel, middle_ft);
    if (middle >= 1 && middle <= wheel->mats) {
        double w = middle_ft / wheel->length_ft - 0.5;
        double i = floor(w);
        double r = w - i;
        if (i < 0.0) {
            count = add_touch(wheel, touch, count, 1, force_lb, 0.0);
        } else {
            count = add_touch(wheel, touch, count, (int)i + 1, force_lb * (1.0 - r), 0.0);
            count = add_touch(wheel, touch, count, (int)i + 2, force_lb * r, 0.0);
        }
    }
    return count;
}

bool sim_wheel_is_past_path(const struct sim_wheel *wheel, double t_s)
{
    return t_s >= wheel->rows[wheel->row_count - 1].t_s;
}

double sim_wheel_max_speed_ft_s(const struct sim_wheel *wheel)
{
    double fastest = 0.0;
    for (size_t i = 0; i + 1 < wheel->row_count; i++) {
        const struct sim_path_row *row = &wheel->rows[i];
        double stopping_distance_ft = fabs(row[1].x_ft - row[0].x_ft);
        if (stopping_distance_ft > 0.0)
            /* if the two times are equal, the position jumps, and dividing by 0 gives INFINITY */
            fastest = law_max(fastest, stopping_distance_ft / (row[1].t_s - row[0].t_s));
    }
    return fastest;
}

int sim_wheel_first_mat(const struct sim_wheel *wheel)
{
    struct sim_wheel fresh = *wheel;
    int mat = find_mat(&fresh, wheel->rows[0].x_ft);
    return mat < 1 ? 1 : mat > wheel->mats ? wheel->mats : mat;
}

/* ---- spans ---- */

#define SPANS_MAX 1000000u

static enum mr_status append_span(struct span_list *list, const struct span *span,
                                  struct error *error)
{
    if (!(span->t1_s > span->t0_s))
        return MR_OK;
    if (list->count >= SPANS_MAX)
        return error_set(error, MR_USAGE,
                         "the aircraft crosses more than %u mats; give a smaller tend", SPANS_MAX);
    xlist_grow(&list->spans, list->count, sizeof *list->spans);
    list->spans[list->count++] = *span;
    return MR_OK;
}

/* Finds the next position after `x_ft`, in the direction of motion, at which the wheel reaches
 * another mat; with `shift` 0.5, at which it passes the middle of a mat. */
static double next_edge_ft(double x_ft, double speed, double length_ft, double shift)
{
    double w = x_ft / length_ft - shift;
    double edge = speed > 0.0 ? floor(w + EDGE_TOLERANCE) + 1.0 : ceil(w - EDGE_TOLERANCE) - 1.0;
    return (edge + shift) * length_ft;
}

/* Adds spans for a part of the path with constant speed and linear force, which is divided where
 * the wheel reaches another mat. */
static enum mr_status add_spans(struct span_list *list, const struct sim_scene *scene,
                                struct span whole, bool airborne, struct error *error)
{
    double length = scene->length_ft;
    while (whole.t1_s > whole.t0_s && error->status == MR_OK) {
        struct span part = whole;
        double speed = whole.speed_ft_s;
        double runway = scene->mats * length;
        if (speed != 0.0) {
            double edge = next_edge_ft(whole.x0_ft, speed, length, 0.0);
            if (scene->thrust == SIM_THRUST_LINEAR) {
                double other = next_edge_ft(whole.x0_ft, speed, length, 0.5);
                edge = speed > 0.0 ? fmin(edge, other) : fmax(edge, other);
            }
            if (speed > 0.0 && whole.x0_ft >= runway * (1.0 - EDGE_TOLERANCE))
                edge = (double)INFINITY; /* beyond the runway there is no further edge */
            if (speed < 0.0 && whole.x0_ft <= 0.0)
                edge = -(double)INFINITY;
            double t = whole.t0_s + (edge - whole.x0_ft) / speed;
            if (t < whole.t1_s) {
                part.t1_s = t;
                whole.x0_ft = edge;
            } else {
                whole.x0_ft += speed * (whole.t1_s - whole.t0_s);
            }
        }
        double middle = part.x0_ft + 0.5 * speed * (part.t1_s - part.t0_s);
        if (speed == 0.0)
            middle = part.x0_ft + EDGE_TOLERANCE * length;
        double mat = floor(middle / length);
        part.mat = airborne || mat < 0.0 || mat >= scene->mats ? -1 : (int)mat;
        part.first_sharing_mat = -2;
        if (scene->thrust == SIM_THRUST_LINEAR && part.mat >= 0)
            part.first_sharing_mat = (int)floor(middle / length - 0.5);
        whole.force_lb += whole.force_lb_per_s * (part.t1_s - part.t0_s);
        whole.t0_s = part.t1_s;
        append_span(list, &part, error);
    }
    return error->status;
}

/* Adds spans for a part of the path, which is divided where the thrust stops. */
static enum mr_status add_spans_until_stop(struct span_list *list, const struct sim_scene *scene,
                                           struct span whole, bool airborne, struct error *error)
{
    double stop = scene->force_stop_s;
    if (stop > whole.t0_s && stop < whole.t1_s) {
        struct span before = whole;
        before.t1_s = stop;
        add_spans(list, scene, before, airborne, error);
        whole.x0_ft += whole.speed_ft_s * (stop - whole.t0_s);
        whole.t0_s = stop;
    }
    if (stop <= whole.t0_s)
        whole.force_lb = whole.force_lb_per_s = 0.0;
    return add_spans(list, scene, whole, airborne, error);
}

enum mr_status span_list_make(struct span_list *list, const struct sim_scene *scene,
                              struct error *error)
{
    double end = sim_scene_end_s(scene);
    *list = (struct span_list){0};
    if (scene->path_count == 0) {
        struct span whole = {0.0, end, scene->start_ft, scene->vac_ft_s, scene->force_lb, 0.0,
                             -1,  -2};
        add_spans_until_stop(list, scene, whole, false, error);
    } else {
        const struct sim_path_row *row = scene->path;
        const struct sim_path_row *last = row + scene->path_count - 1;
        struct span air = {0.0, fmin(row->t_s, end), row->x_ft, 0.0, 0.0, 0.0, -1, -2};
        add_spans_until_stop(list, scene, air, true, error);
        for (; row < last && row->t_s < end; row++) {
            double length_s = row[1].t_s - row[0].t_s;
            if (length_s <= 0.0)
                continue;
            struct span part = {row[0].t_s,
                                fmin(row[1].t_s, end),
                                row[0].x_ft,
                                (row[1].x_ft - row[0].x_ft) / length_s,
                                row[0].force_lb,
                                (row[1].force_lb - row[0].force_lb) / length_s,
                                -1,
                                -2};
            add_spans_until_stop(list, scene, part, false, error);
        }
        struct span stands = {last->t_s, end, last->x_ft, 0.0, 0.0, 0.0, -1, -2};
        add_spans_until_stop(list, scene, stands, false, error);
    }
    if (error->status != MR_OK)
        span_list_free(list);
    return error->status;
}

void span_list_free(struct span_list *list)
{
    free(list->spans);
    *list = (struct span_list){0};
}
