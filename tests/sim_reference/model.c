/* Kinematics as matrices, forces, friction and accelerations of both models. */
#include "tests/sim_reference/model.h"

#include <math.h>
#include <string.h>

#define CONTACT_FT (-1e-9) /* the report model's foot is down at or below this height */

static double sign_of(double x)
{
    return x > 0 ? 1 : x < 0 ? -1 : 0;
}

/* Joint j joins mats j-1 (l) and j (r): row of the difference matrix, +1 at r and -1 at l. */
static double difference(int joint, int mat)
{
    return mat == joint ? 1 : mat == joint - 1 ? -1 : 0;
}

static bool end_is_free(const struct ref_scene *s, int joint, bool torsion)
{
    if (joint == 0)
        return !(torsion ? s->left_torsion_fixed : s->left_fixed);
    if (joint == s->mats)
        return !(torsion ? s->right_torsion_fixed : s->right_fixed);
    return false;
}

void ref_angles(const struct ref_scene *s, const double *q, const double *v, double *th,
                double *rate)
{
    for (int n = 0; n < s->mats; n++) {
        if (s->model == REF_REPORT) {
            th[n] = q[s->mats + 1 + n];
            rate[n] = v[s->mats + 1 + n];
        } else {
            th[n] = asin((q[n + 1] - q[n]) / s->L);
            rate[n] = (v[n + 1] - v[n]) / (s->L * cos(th[n]));
        }
    }
}

/* Report: Y = q1 + H sin th with the (mats + 1) x mats matrix H; first column -h, h, h, ..., the
 * others 0 down to their mat's right end and L from there on. */
static double height_matrix(const struct ref_scene *s, int node, int mat)
{
    if (mat == 0)
        return node == 0 ? -s->L / 2 : s->L / 2;
    return node > mat ? s->L : 0;
}

void ref_heights(const struct ref_scene *s, const double *q, const double *v, double *y,
                 double *y_rate)
{
    double sine[REF_MATS], sine_rate[REF_MATS];
    for (int n = 0; s->model == REF_REPORT && n < s->mats; n++) {
        sine[n] = sin(q[s->mats + 1 + n]);
        sine_rate[n] = cos(q[s->mats + 1 + n]) * v[s->mats + 1 + n];
    }
    for (int j = 0; j <= s->mats; j++) {
        y[j] = q[s->model == REF_REPORT ? 0 : j];
        y_rate[j] = v[s->model == REF_REPORT ? 0 : j];
        for (int n = 0; s->model == REF_REPORT && n < s->mats; n++) {
            y[j] += height_matrix(s, j, n) * sine[n];
            y_rate[j] += height_matrix(s, j, n) * sine_rate[n];
        }
    }
}

/* Opening, relative angle and their rates of every joint. */
static void joint_motion(const struct ref_scene *s, const double *q, const double *v, double *gap,
                         double *gap_rate, double *angle, double *angle_rate)
{
    double th[REF_MATS], rate[REF_MATS], back[REF_MATS], back_rate[REF_MATS];
    ref_angles(s, q, v, th, rate);
    for (int n = 0; n < s->mats; n++) { /* a turned mat draws each end back by h (1 - cos th) */
        back[n] = s->full ? s->L / 2 * (1 - cos(th[n])) : 0;
        back_rate[n] = s->full ? s->L / 2 * sin(th[n]) * rate[n] : 0;
    }
    for (int j = 0; j <= s->mats; j++) {
        gap[j] = s->gap0[j];
        gap_rate[j] = angle[j] = angle_rate[j] = 0;
        for (int n = 0; n < s->mats; n++) {
            double d = difference(j, n);
            gap[j] += d * q[ref_u(s, n)];
            gap_rate[j] += d * v[ref_u(s, n)];
            angle[j] += d * th[n];
            angle_rate[j] += d * rate[n];
            gap[j] += fabs(d) * back[n];
            gap_rate[j] += fabs(d) * back_rate[n];
        }
    }
}

void ref_joints(const struct ref_scene *s, const struct ref_regime *regime, const double *q,
                const double *v, double *tension, double *moment)
{
    double gap[REF_NODES], gap_rate[REF_NODES], angle[REF_NODES], angle_rate[REF_NODES];
    joint_motion(s, q, v, gap, gap_rate, angle, angle_rate);
    for (int j = 0; j <= s->mats; j++) {
        bool joined = s->slack == 0 || regime->slack[j] != 0;
        double elastic = gap[j] - (regime->slack[j] > 0 ? s->slack : 0);
        tension[j] = end_is_free(s, j, false) || !joined ? 0
                                                         : s->KL * elastic + s->CL * gap_rate[j];
        double wound = angle[j] - (s->switched ? 0 : regime->tad[j] * s->TAD);
        moment[j] = end_is_free(s, j, true) || regime->tad[j] == 0
                      ? 0
                      : s->KT * wound + s->CT * angle_rate[j];
    }
}

/* Soil reaction of one mat end at each node: the report's node force, the consistent model's
 * share. */
static void soil(const struct ref_scene *s, const struct ref_regime *regime, const double *q,
                 const double *v, double *force)
{
    double y[REF_NODES], y_rate[REF_NODES];
    ref_heights(s, q, v, y, y_rate);
    for (int j = 0; j <= s->mats; j++) {
        bool presses = regime->contact[j] && (s->model == REF_REPORT || regime->pushes[j]);
        force[j] = presses ? s->KV * y[j] + s->CV * y_rate[j] : 0;
    }
}

static double thrust(const struct ref_scene *s, const struct ref_wheel *wheel, double t, int mat)
{
    if (!wheel->pushing)
        return 0;
    if (!s->linear)
        return mat == wheel->mat ? s->F : 0;
    double r = (s->s0 + s->Vac * t) / s->L - 0.5 - wheel->pair;
    if (wheel->pair < 0)
        return mat == 0 ? s->F : 0;
    return mat == wheel->pair ? s->F * (1 - r) : mat == wheel->pair + 1 ? s->F * r : 0;
}

void ref_pushes(const struct ref_scene *s, const struct ref_regime *regime,
                const struct ref_wheel *wheel, double t, const double *q, const double *v,
                double *x, double *limit)
{
    double tension[REF_NODES], moment[REF_NODES], r[REF_NODES];
    ref_joints(s, regime, q, v, tension, moment);
    soil(s, regime, q, v, r);
    for (int n = 0; n < s->mats; n++) {
        x[n] = thrust(s, wheel, t, n);
        for (int j = 0; j <= s->mats; j++)
            x[n] -= difference(j, n) * tension[j];
        double normal = s->soil_normal ? r[n] + r[n + 1]
                                       : s->W + (n == wheel->mat ? s->wheel_load : 0);
        limit[n] = s->f * normal;
    }
}

static void slide(const struct ref_scene *s, const struct ref_regime *regime,
                  const struct ref_wheel *wheel, double t, const double *q, const double *v,
                  double *a)
{
    double x[REF_MATS], limit[REF_MATS], mass = s->W / s->g;
    ref_pushes(s, regime, wheel, t, q, v, x, limit);
    for (int n = 0; n < s->mats; n++) {
        double speed = v[ref_u(s, n)], drag = 0;
        for (int j = n; j <= n + 1; j++) { /* viscous ground: whole, wherever the mat stands */
            if (regime->contact[j] && (s->model == REF_REPORT || regime->pushes[j]))
                drag = s->c * speed;
        }
        if (s->friction == REF_STICK)
            drag = regime->slip[n] == 0 ? x[n] : drag + regime->slip[n] * limit[n];
        else if (s->friction == REF_TANH)
            drag += limit[n] * tanh(speed / s->veps);
        a[ref_u(s, n)] = (x[n] - drag) / mass;
    }
}

/* Moment of the lift shear on a mat. */
static double lift_moment(const struct ref_scene *s, const struct ref_regime *regime, int n,
                          double th)
{
    bool left_down = regime->contact[n], right_down = regime->contact[n + 1];
    double arm = s->V * s->L / 2 * cos(th), sum = 0;
    if (s->shear == REF_FOLLOWING)
        return n == regime->apex + 1 && !left_down ? arm : 0; /* the second mat beyond the apex */
    if (s->shear == REF_RISING || s->shear == REF_BOTH) {
        if (left_down && !right_down)
            sum += arm;
        if (n == regime->apex + 1 && !left_down && !right_down)
            sum += arm;
    }
    if (s->shear == REF_BOTH && !left_down && right_down)
        sum -= arm;
    return sum;
}

static void turn_report(const struct ref_scene *s, const struct ref_regime *regime, const double *q,
                        const double *v, double *a)
{
    double tension[REF_NODES], moment[REF_NODES], r[REF_NODES], h = s->L / 2;
    ref_joints(s, regime, q, v, tension, moment);
    soil(s, regime, q, v, r);
    a[0] = (s->Q1 - r[0] - r[1]) / (s->W / s->g);
    for (int n = 0; n < s->mats; n++) {
        double th = q[s->mats + 1 + n];
        double sum = lift_moment(s, regime, n, th) + h * cos(th) * (r[n] - r[n + 1]);
        for (int j = n; j <= n + 1; j++) /* both pulls act along the runway at arms of h sin th */
            sum -= h * sin(th) * tension[j];
        for (int j = 0; j <= s->mats; j++)
            sum -= difference(j, n) * moment[j];
        a[s->mats + 1 + n] = sum / s->I;
    }
}

/* Solve matrix * x = right by elimination with row exchange; both are overwritten, x is in
 * right. */
static void solve(int size, double matrix[REF_NODES][REF_NODES], double *right)
{
    for (int c = 0; c < size; c++) {
        int pivot = c;
        for (int r = c + 1; r < size; r++) {
            if (fabs(matrix[r][c]) > fabs(matrix[pivot][c]))
                pivot = r;
        }
        for (int k = 0; k < size; k++) {
            double swap = matrix[c][k];
            matrix[c][k] = matrix[pivot][k];
            matrix[pivot][k] = swap;
        }
        double swap = right[c];
        right[c] = right[pivot];
        right[pivot] = swap;
        for (int r = c + 1; r < size; r++) {
            double factor = matrix[r][c] / matrix[c][c];
            for (int k = c; factor != 0 && k < size; k++)
                matrix[r][k] -= factor * matrix[c][k];
            right[r] -= factor * right[c];
        }
    }
    for (int c = size - 1; c >= 0; c--) {
        for (int k = c + 1; k < size; k++)
            right[c] -= matrix[c][k] * right[k];
        right[c] /= matrix[c][c];
    }
}

/* Each mat's centre height and angle as functions of the node heights: y = (Y_n + Y_n+1)/2 and th =
 * asin((Y_n+1 - Y_n)/L), with Jacobian rows jy and jt. Projecting Newton's and Euler's laws of the
 * free mats on the node heights: sum (m jy jy' + I jt jt') Y'' = sum jy W + jt (moments - I jt_dot
 * Y') + ... */
static void rise_consistent(const struct ref_scene *s, const struct ref_regime *regime,
                            const struct ref_wheel *wheel, const double *q, const double *v,
                            double *a)
{
    static double matrix[REF_NODES][REF_NODES];
    double tension[REF_NODES], moment[REF_NODES], r[REF_NODES], right[REF_NODES] = {0};
    double th[REF_MATS], rate[REF_MATS], mass = s->W / s->g;
    int nodes = s->mats + 1;
    ref_joints(s, regime, q, v, tension, moment);
    soil(s, regime, q, v, r);
    ref_angles(s, q, v, th, rate);
    memset(matrix, 0, sizeof matrix);
    for (int n = 0; n < s->mats; n++) {
        double jy[2] = {0.5, 0.5};
        double jt[2] = {-1 / (s->L * cos(th[n])), 1 / (s->L * cos(th[n]))};
        double jt_dot = sin(th[n]) * rate[n] / (s->L * cos(th[n]) * cos(th[n]));
        double turning = -s->I * jt_dot * (v[n + 1] - v[n]);
        turning -= s->L / 2 * sin(th[n]) * (tension[n] + tension[n + 1]);
        turning += moment[n + 1] - moment[n];
        double weight = s->W + (n == wheel->mat ? s->wheel_load : 0);
        for (int i = 0; i < 2; i++) {
            right[n + i] += jt[i] * turning + jy[i] * weight - r[n + i];
            for (int k = 0; k < 2; k++)
                matrix[n + i][n + k] += mass * jy[i] * jy[k] + s->I * jt[i] * jt[k];
        }
    }
    solve(nodes, matrix, right);
    memcpy(a, right, (size_t)nodes * sizeof *a);
}

void ref_accelerations(const struct ref_scene *s, const struct ref_regime *regime,
                       const struct ref_wheel *wheel, double t, const double *q, const double *v,
                       double *a)
{
    slide(s, regime, wheel, t, q, v, a);
    if (s->model == REF_REPORT)
        turn_report(s, regime, q, v, a);
    else
        rise_consistent(s, regime, wheel, q, v, a);
}

void ref_regime_of(const struct ref_scene *s, const struct ref_wheel *wheel, double t,
                   const double *q, const double *v, struct ref_regime *regime)
{
    double gap[REF_NODES], gap_rate[REF_NODES], angle[REF_NODES], angle_rate[REF_NODES];
    double y[REF_NODES], y_rate[REF_NODES], x[REF_MATS], limit[REF_MATS];
    joint_motion(s, q, v, gap, gap_rate, angle, angle_rate);
    ref_heights(s, q, v, y, y_rate);
    regime->apex = 0;
    for (int j = 0; j <= s->mats; j++) {
        regime->contact[j] = s->model == REF_REPORT ? y[j] >= CONTACT_FT : y[j] > 0;
        regime->pushes[j] = s->KV * y[j] + s->CV * y_rate[j] > 0;
        /* with TAD 0 both sides obey the same law: no switch */
        regime->tad[j] = (signed char)(s->TAD == 0               ? 1
                                       : fabs(angle[j]) > s->TAD ? sign_of(angle[j])
                                                                 : 0);
        regime->slack[j] = (signed char)(s->slack == 0       ? 0
                                         : gap[j] > s->slack ? 1
                                         : gap[j] < 0        ? -1
                                                             : 0);
        if (y[j] < y[regime->apex])
            regime->apex = j;
    }
    ref_pushes(s, regime, wheel, t, q, v, x, limit);
    for (int n = 0; n < s->mats; n++) {
        double speed = v[ref_u(s, n)];
        if (s->friction != REF_STICK)
            regime->slip[n] = 0;
        else if (speed != 0)
            regime->slip[n] = (signed char)sign_of(speed);
        else
            regime->slip[n] = (signed char)(fabs(x[n]) > limit[n] ? sign_of(x[n]) : 0);
    }
}
