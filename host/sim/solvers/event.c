#include <math.h>

#include "host/base/elementary.h"
#include "host/sim/solvers/stepper.h"

/* event: Dormand and Prince's method of order 8 with embedded orders 5 and 3 and dense output of
 * order 7 (E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, II.5 and
 * II.6). */

#define STAGE_COUNT      16 /* 12 stages, the new point, 3 stages for the dense output */
#define DENSE_TERM_COUNT 7

static const double stage_nodes[STAGE_COUNT] = {0.0,
                                                0.526001519587677318785587544488e-1,
                                                0.789002279381515978178381316732e-1,
                                                0.118350341907227396726757197510,
                                                0.281649658092772603273242802490,
                                                1.0 / 3.0,
                                                0.25,
                                                4.0 / 13.0,
                                                127.0 / 195.0,
                                                0.6,
                                                6.0 / 7.0,
                                                1.0,
                                                1.0,
                                                0.1,
                                                0.2,
                                                7.0 / 9.0};

static const double stage_weights[STAGE_COUNT][STAGE_COUNT - 1] = {
    [1] = {5.26001519587677318785587544488e-2},
    [2] = {1.97250569845378994544595329183e-2, 5.91751709536136983633785987549e-2},
    [3] = {2.95875854768068491816892993775e-2, 0, 8.87627564304205475450678981324e-2},
    [4] = {2.41365134159266685502369798665e-1, 0, -8.84549479328286085344864962717e-1,
           9.24834003261792003115737966543e-1},
    [5] = {1.0 / 27.0, 0, 0, 1.70828608729473871279604482173e-1,
           1.25467687566822425016691814123e-1},
    [6] = {3.7109375e-2, 0, 0, 1.70252211019544039314978060272e-1,
           6.02165389804559606850219397283e-2, -1.7578125e-2},
    [7] = {3.70920001185047927108779319836e-2, 0, 0, 1.70383925712239993810214054705e-1,
           1.07262030446373284651809199168e-1, -1.53194377486244017527936158236e-2,
           8.27378916381402288758473766002e-3},
    [8] = {6.24110958716075717114429577812e-1, 0, 0, -3.36089262944694129406857109825,
           -8.68219346841726006818189891453e-1, 2.75920996994467083049415600797e1,
           2.01540675504778934086186788979e1, -4.34898841810699588477366255144e1},
    [9] = {4.77662536438264365890433908527e-1, 0, 0, -2.48811461997166764192642586468,
           -5.90290826836842996371446475743e-1, 2.12300514481811942347288949897e1,
           1.52792336328824235832596922938e1, -3.32882109689848629194453265587e1,
           -2.03312017085086261358222928593e-2},
    [10] = {-9.3714243008598732571704021658e-1, 0, 0, 5.18637242884406370830023853209,
            1.09143734899672957818500254654, -8.14978701074692612513997267357,
            -1.85200656599969598641566180701e1, 2.27394870993505042818970056734e1,
            2.49360555267965238987089396762, -3.0467644718982195003823669022},
    [11] = {2.27331014751653820792359768449, 0, 0, -1.05344954667372501984066689879e1,
            -2.00087205822486249909675718444, -1.79589318631187989172765950534e1,
            2.79488845294199600508499808837e1, -2.85899827713502369474065508674,
            -8.87285693353062954433549289258, 1.23605671757943030647266201528e1,
            6.43392746015763530355970484046e-1},
    [12] = {5.42937341165687622380535766363e-2, 0, 0, 0, 0, 4.45031289275240888144113950566,
            1.89151789931450038304281599044, -5.8012039600105847814672114227,
            3.1116436695781989440891606237e-1, -1.52160949662516078556178806805e-1,
            2.01365400804030348374776537501e-1, 4.47106157277725905176885569043e-2},
    [13] = {5.61675022830479523392909219681e-2, 0, 0, 0, 0, 0, 2.53500210216624811088794765333e-1,
            -2.46239037470802489917441475441e-1, -1.24191423263816360469010140626e-1,
            1.5329179827876569731206322685e-1, 8.20105229563468988491666602057e-3,
            7.56789766054569976138603589584e-3, -8.298e-3},
    [14] = {3.18346481635021405060768473261e-2, 0, 0, 0, 0, 2.83009096723667755288322961402e-2,
            5.35419883074385676223797384372e-2, -5.49237485713909884646569340306e-2, 0, 0,
            -1.08347328697249322858509316994e-4, 3.82571090835658412954920192323e-4,
            -3.40465008687404560802977114492e-4, 1.41312443674632500278074618366e-1},
    [15] = {-4.28896301583791923408573538692e-1, 0, 0, 0, 0, -4.69762141536116384314449447206,
            7.68342119606259904184240953878, 4.06898981839711007970213554331,
            3.56727187455281109270669543021e-1, 0, 0, 0, -1.39902416515901462129418009734e-3,
            2.9475147891527723389556272149, -9.15095847217987001081870187138},
};

/* Weights of order 3 minus weights of order 8, for stages 0, 8 and 11. */
#define THIRD_ORDER_0  0.244094488188976377952755905512
#define THIRD_ORDER_8  0.733846688281611857341361741547
#define THIRD_ORDER_11 0.220588235294117647058823529412e-1

static const double fifth_order_errors[12] = {0.1312004499419488073250102996e-1,
                                              0,
                                              0,
                                              0,
                                              0,
                                              -0.1225156446376204440720569753e1,
                                              -0.4957589496572501915214079952,
                                              0.1664377182454986536961530415e1,
                                              -0.3503288487499736816886487290,
                                              0.3341791187130174790297318841,
                                              0.8192320648511571246570742613e-1,
                                              -0.2235530786388629525884427845e-1};

static const double dense_term_weights[DENSE_TERM_COUNT - 3][STAGE_COUNT] = {
    {-0.84289382761090128651353491142e1, 0, 0, 0, 0, 0.56671495351937776962531783590,
     -0.30689499459498916912797304727e1, 0.23846676565120698287728149680e1,
     0.21170345824450282767155149946e1, -0.87139158377797299206789907490,
     0.22404374302607882758541771650e1, 0.63157877876946881815570249290,
     -0.88990336451333310820698117400e-1, 0.18148505520854727256656404962e2,
     -0.91946323924783554000451984436e1, -0.44360363875948939664310572000e1},
    {0.10427508642579134603413151009e2, 0, 0, 0, 0, 0.24228349177525818288430175319e3,
     0.16520045171727028198505394887e3, -0.37454675472269020279518312152e3,
     -0.22113666853125306036270938578e2, 0.77334326684722638389603898808e1,
     -0.30674084731089398182061213626e2, -0.93321305264302278729567221706e1,
     0.15697238121770843886131091075e2, -0.31139403219565177677282850411e2,
     -0.93529243588444783865713862664e1, 0.35816841486394083752465898540e2},
    {0.19985053242002433820987653617e2, 0, 0, 0, 0, -0.38703730874935176555105901742e3,
     -0.18917813819516756882830838328e3, 0.52780815920542364900561016686e3,
     -0.11573902539959630126141871134e2, 0.68812326946963000169666922661e1,
     -0.10006050966910838403183860980e1, 0.77771377980534432092869265740,
     -0.27782057523535084065932004339e1, -0.60196695231264120758267380846e2,
     0.84320405506677161018159903784e2, 0.11992291136182789328035130030e2},
    {-0.25693933462703749003312586129e2, 0, 0, 0, 0, -0.15418974869023643374053993627e3,
     -0.23152937917604549567536039109e3, 0.35763911791061412078285349910e3,
     0.93405324183624310003907691704e2, -0.37458323136251633156875139351e2,
     0.10409964950896230045147246184e3, 0.29840293426660503123344363579e2,
     -0.43533456590011143754432175058e2, 0.96324553959188282948394950600e2,
     -0.39177261675615439165231486172e2, -0.14972683625798562581422125276e3},
};

struct event_work {
    double *rate[STAGE_COUNT];             /* 2 size values in each array */
    double *stage_state;                   /* state at which a stage is evaluated */
    double *dense_terms[DENSE_TERM_COUNT]; /* terms of the dense output */
    bool has_start_rate;                   /* true: rate[0] is the rate at (t, z) */
    bool has_dense_terms;                  /* true: `dense_terms` belong to the last step */
    double last_h_s;                       /* size of the last step */
};

static void restart(struct stepper *s)
{
    struct event_work *w = s->work;
    w->has_start_rate = w->has_dense_terms = false;
}

/* Computes the state of stage i: z plus h times the weighted rates, for both halves of the
 * state. */
TARGET_CLONES static void compute_stage_state(const struct stepper *s, int i, double h, double *to)
{
    const struct event_work *w = s->work;
    int low = stepper_first_index(s), high = stepper_end_index(s),
        size = s->model->coordinate_count;
    const double *row = stage_weights[i];
    for (int half = 0; half < 2; half++) {
        int from = half * size + low, end = half * size + high;
        const double *first = w->rate[0];
        double scale = h * row[0];
        for (int k = from; k < end; k++)
            to[k] = s->z[k] + scale * first[k];
        for (int j = 1; j < i; j++) {
            if (row[j] == 0.0)
                continue;
            const double *rate = w->rate[j];
            scale = h * row[j];
            for (int k = from; k < end; k++)
                to[k] += scale * rate[k];
        }
    }
}

/* Largest error / tolerance of the step in z_new. */
static double step_error(const struct stepper *s, double h)
{
    const struct event_work *w = s->work;
    int low = stepper_first_index(s), high = stepper_end_index(s),
        size = s->model->coordinate_count;
    double most5 = 0.0, most3 = 0.0;
    for (int half = 0; half < 2; half++) {
        double atol = half == 0 ? s->atol_ft : s->atol_ft_s;
        for (int k = half * size + low; k < half * size + high; k++) {
            double e5 = fifth_order_errors[0] * w->rate[0][k], e3;
            for (int j = 5; j < 12; j++)
                e5 += fifth_order_errors[j] * w->rate[j][k];
            e3 = (s->z_new[k] - s->z[k]) / h - THIRD_ORDER_0 * w->rate[0][k] -
                 THIRD_ORDER_8 * w->rate[8][k] - THIRD_ORDER_11 * w->rate[11][k];
            double scale = 1.0 / (atol + s->rtol * fmax(fabs(s->z[k]), fabs(s->z_new[k])));
            if (!(fabs(s->z_new[k]) < 1e300))
                return (double)NAN;
            most5 = fmax(most5, fabs(e5) * scale);
            most3 = fmax(most3, fabs(e3) * scale);
        }
    }
    if (most5 == 0.0)
        return 0.0;
    return h * most5 * most5 / sqrt(most5 * most5 + 0.01 * most3 * most3);
}

static bool advance(struct stepper *s, double limit_s)
{
    struct event_work *w = s->work;
    bool rejected = false;
    if (w->has_start_rate && s->t_s == s->t_new_s) {
        double *kept = w->rate[0];
        /* the rates at the end of the last step are those at the start of this one */
        stepper_copy(s, w->rate[12], kept);
    } else {
        stepper_rates(s, s->t_s, s->z, w->rate[0]);
    }
    for (;;) {
        double h;
        bool last;
        if (!stepper_choose_step(s, limit_s, &h, &last))
            return false;
        bool turns = stepper_end_at_reversal(s, w->rate[0], &h);
        last = last && !turns;
        for (int i = 1; i < 12; i++) {
            compute_stage_state(s, i, h, w->stage_state);
            stepper_rates(s, s->t_s + stage_nodes[i] * h, w->stage_state, w->rate[i]);
        }
        compute_stage_state(s, 12, h, s->z_new);
        double error = step_error(s, h);
        if (error <= 1.0) {
            double grow = error > 0.0 ? 0.9 * elementary_pow(error, -0.125) : 6.0;
            stepper_accept(s, h, last ? limit_s : s->t_s + h, last || turns,
                           fmin(rejected ? 1.0 : 6.0, fmax(0.333, grow)));
            stepper_rates(s, s->t_new_s, s->z_new, w->rate[12]);
            w->last_h_s = h;
            w->has_start_rate = true;
            w->has_dense_terms = false;
            s->rate = w->rate[0];
            s->rate_new = w->rate[12];
            return true;
        }
        rejected = true;
        stepper_reject(
            s, h * (isfinite(error) ? fmax(0.2, 0.9 * elementary_pow(error, -0.125)) : 0.2));
    }
}

static void prepare_dense_terms(struct stepper *s)
{
    struct event_work *w = s->work;
    int low = stepper_first_index(s), high = stepper_end_index(s),
        size = s->model->coordinate_count;
    double h = w->last_h_s;
    for (int i = 13; i < STAGE_COUNT; i++) {
        compute_stage_state(s, i, h, w->stage_state);
        stepper_rates(s, s->t_s + stage_nodes[i] * h, w->stage_state, w->rate[i]);
    }
    for (int half = 0; half < 2; half++) {
        for (int k = half * size + low; k < half * size + high; k++) {
            double change = s->z_new[k] - s->z[k];
            w->dense_terms[0][k] = change;
            w->dense_terms[1][k] = h * w->rate[0][k] - change;
            w->dense_terms[2][k] = 2.0 * change - h * (w->rate[12][k] + w->rate[0][k]);
            for (size_t d = 0; d < DENSE_TERM_COUNT - 3; d++) {
                double sum = dense_term_weights[d][0] * w->rate[0][k];
                for (int j = 5; j < STAGE_COUNT; j++)
                    sum += dense_term_weights[d][j] * w->rate[j][k];
                w->dense_terms[3 + d][k] = h * sum;
            }
        }
    }
    w->has_dense_terms = true;
}

TARGET_CLONES static void interpolate(struct stepper *s, double t_s, int low, int high, double *z)
{
    struct event_work *w = s->work;
    if (!w->has_dense_terms)
        prepare_dense_terms(s);
    double x = (t_s - s->t_s) / w->last_h_s;
    for (int half = 0; half < 2; half++) {
        for (int k = half * s->model->coordinate_count + low;
             k < half * s->model->coordinate_count + high; k++) {
            double sum = 0.0;
            for (size_t i = DENSE_TERM_COUNT; i-- > 0;)
                sum = (sum + w->dense_terms[i][k]) * (i % 2 == 0 ? x : 1.0 - x);
            z[k] = s->z[k] + sum;
        }
    }
}

const struct stepper_kind stepper_event = {
    .name = "event",
    .can_omit_mats = true,
    .has_long_steps = true,
    .reversal_speed_veps = 2.0,
    .rtol = 1e-8,
    .kind_for_loose_rtol = &stepper_event5,
    .loose_rtol = 9e-8,
    .description = "Dormand-Prince 8(5,3), every event located",
    .work_bytes = sizeof(struct event_work),
    .row_count = STAGE_COUNT + 1 + DENSE_TERM_COUNT,
    .restart = restart,
    .advance = advance,
    .interpolate = interpolate,
};

/* ---- order 5 ---- */

/* event at loose tolerances: Dormand and Prince's method of order 5 with embedded order 4 and dense
 * output of order 4, six evaluations per step (E. Hairer, S. P. Norsett, G. Wanner, Solving
 * Ordinary Differential Equations I, II.5 and II.6). Where the step is limited by stability and not
 * by accuracy, it needs half the evaluations of the order 8 method for steps of the same size. */

#define ORDER5_STAGE_COUNT 7 /* the last stage is the first stage of the next step */

static const double order5_nodes[ORDER5_STAGE_COUNT] = {0.0, 0.2, 0.3, 0.8, 8.0 / 9.0, 1.0, 1.0};
static const double order5_stage_weights[ORDER5_STAGE_COUNT][ORDER5_STAGE_COUNT - 1] = {
    [1] = {1.0 / 5.0},
    [2] = {3.0 / 40.0, 9.0 / 40.0},
    [3] = {44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0},
    [4] = {19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0},
    [5] = {9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0},
    [6] = {35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0},
};
static const double order5_fourth_errors[ORDER5_STAGE_COUNT] = {
    71.0 / 57600.0,      0.0,          -71.0 / 16695.0, 71.0 / 1920.0,
    -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0};
static const double order5_dense_term[ORDER5_STAGE_COUNT] = {
    -12715105075.0 / 11282082432.0,  0.0,
    87487479700.0 / 32700410799.0,   -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0};

struct order5_work {
    double *rate[ORDER5_STAGE_COUNT]; /* 2 size values in each array */
    double *stage_state;              /* state at which a stage is evaluated */
    bool has_start_rate;              /* true: rate[6] is the rate at the start of the next step */
    double last_error_ratio;          /* error / tolerance of the last accepted step */
    double last_h_s;                  /* size of the last step */
};

static void order5_restart(struct stepper *s)
{
    struct order5_work *w = s->work;
    w->has_start_rate = false;
    w->last_error_ratio = 1e-4;
}

TARGET_CLONES static void order5_compute_stage_state(const struct stepper *s, int i, double h,
                                                     double *to)
{
    const struct order5_work *w = s->work;
    const double *row = order5_stage_weights[i];
    double a[ORDER5_STAGE_COUNT - 1];
    for (int j = 0; j < ORDER5_STAGE_COUNT - 1; j++)
        a[j] = j < i ? h * row[j] : 0.0;
    for (int half = 0; half <= s->model->coordinate_count; half += s->model->coordinate_count) {
        int from = half + stepper_first_index(s), end = half + stepper_end_index(s);
        const double *z = s->z, *r0 = w->rate[0], *r1 = w->rate[1], *r2 = w->rate[2],
                     *r3 = w->rate[3], *r4 = w->rate[4], *r5 = w->rate[5];
        switch (i) {
        case 1:
            for (int k = from; k < end; k++)
                to[k] = z[k] + a[0] * r0[k];
            break;
        case 2:
            for (int k = from; k < end; k++)
                to[k] = z[k] + (a[0] * r0[k] + a[1] * r1[k]);
            break;
        case 3:
            for (int k = from; k < end; k++)
                to[k] = z[k] + (a[0] * r0[k] + a[1] * r1[k] + a[2] * r2[k]);
            break;
        case 4:
            for (int k = from; k < end; k++)
                to[k] = z[k] + (a[0] * r0[k] + a[1] * r1[k] + a[2] * r2[k] + a[3] * r3[k]);
            break;
        case 5:
            for (int k = from; k < end; k++)
                to[k] = z[k] +
                        (a[0] * r0[k] + a[1] * r1[k] + a[2] * r2[k] + a[3] * r3[k] + a[4] * r4[k]);
            break;
        default:
            for (int k = from; k < end; k++)
                to[k] = z[k] +
                        (a[0] * r0[k] + a[2] * r2[k] + a[3] * r3[k] + a[4] * r4[k] + a[5] * r5[k]);
            break;
        }
    }
}

/* Largest error / tolerance of the step in z_new. */
static double order5_step_error(const struct stepper *s, double h)
{
    const struct order5_work *w = s->work;
    double most = 0.0;
    for (int half = 0; half < 2; half++) {
        double atol = half == 0 ? s->atol_ft : s->atol_ft_s;
        int start = half * s->model->coordinate_count;
        for (int k = start + stepper_first_index(s); k < start + stepper_end_index(s); k++) {
            double e =
                order5_fourth_errors[0] * w->rate[0][k] + order5_fourth_errors[2] * w->rate[2][k] +
                order5_fourth_errors[3] * w->rate[3][k] + order5_fourth_errors[4] * w->rate[4][k] +
                order5_fourth_errors[5] * w->rate[5][k] + order5_fourth_errors[6] * w->rate[6][k];
            double old = fabs(s->z[k]), new = fabs(s->z_new[k]);
            double part = fabs(e) / (atol + s->rtol * (old > new ? old : new));
            if (!(new < 1e300))
                return (double)NAN;
            most = part > most ? part : most;
        }
    }
    return h * most;
}

static bool order5_advance(struct stepper *s, double limit_s)
{
    struct order5_work *w = s->work;
    bool rejected = false;
    if (w->has_start_rate && s->t_s == s->t_new_s) {
        double *first = w->rate[0];
        w->rate[0] = w->rate[6];
        w->rate[6] = first;
    } else {
        stepper_rates(s, s->t_s, s->z, w->rate[0]);
    }
    for (;;) {
        double h;
        bool last;
        if (!stepper_choose_step(s, limit_s, &h, &last))
            return false;
        bool turns = stepper_end_at_reversal(s, w->rate[0], &h);
        last = last && !turns;
        for (int i = 1; i < ORDER5_STAGE_COUNT; i++) {
            double *to = i < ORDER5_STAGE_COUNT - 1 ? w->stage_state : s->z_new;
            order5_compute_stage_state(s, i, h, to);
            stepper_rates(s, s->t_s + order5_nodes[i] * h, to, w->rate[i]);
        }
        double error = order5_step_error(s, h);
        if (error <= 1.0) {
            /* Step control that uses a power of the previous error, too. It converges to the
             * stability limit; without that factor, steps at the limit fail repeatedly. */
            double grow = error > 0.0 ? 0.9 * elementary_pow(error, -0.17) *
                                            elementary_pow(w->last_error_ratio, 0.04)
                                      : 6.0;
            w->last_error_ratio = fmax(error, 1e-4);
            stepper_accept(s, h, last ? limit_s : s->t_s + h, last || turns,
                           fmin(rejected ? 1.0 : 6.0, fmax(0.2, grow)));
            w->last_h_s = h;
            w->has_start_rate = true;
            s->rate = w->rate[0];
            s->rate_new = w->rate[6];
            return true;
        }
        rejected = true;
        stepper_reject(s,
                       h * (isfinite(error) ? fmax(0.2, 0.9 * elementary_pow(error, -0.2)) : 0.2));
    }
}

TARGET_CLONES static void order5_interpolate(struct stepper *s, double t_s, int low, int high,
                                             double *z)
{
    const struct order5_work *w = s->work;
    double h = w->last_h_s, x = (t_s - s->t_s) / h, y = 1.0 - x;
    for (int half = 0; half <= s->model->coordinate_count; half += s->model->coordinate_count) {
        for (int k = half + low; k < half + high; k++) {
            double change = s->z_new[k] - s->z[k];
            double c2 = h * w->rate[0][k] - change, c3 = change - h * w->rate[6][k] - c2;
            double c4 =
                h * (order5_dense_term[0] * w->rate[0][k] + order5_dense_term[2] * w->rate[2][k] +
                     order5_dense_term[3] * w->rate[3][k] + order5_dense_term[4] * w->rate[4][k] +
                     order5_dense_term[5] * w->rate[5][k] + order5_dense_term[6] * w->rate[6][k]);
            z[k] = s->z[k] + x * (change + y * (c2 + x * (c3 + y * c4)));
        }
    }
}

const struct stepper_kind stepper_event5 = {
    .name = "event",
    .can_omit_mats = true,
    .has_long_steps = true,
    .reversal_speed_veps = 6.0,
    .rtol = 1e-5,
    .description = "Dormand-Prince 5(4), every event located",
    .work_bytes = sizeof(struct order5_work),
    .row_count = ORDER5_STAGE_COUNT + 1,
    .restart = order5_restart,
    .advance = order5_advance,
    .interpolate = order5_interpolate,
};
