#include "host/push/ground.h"
#include "host/base/xmalloc.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/gates.h"

/* ---- push answer ---- */

#define IN_PER_FT           12.0
/* the ground cannot spring back by more than its displacement */
#define UNLOADING_RATIO_MAX 1.0

/* Returns "elastic", "rigid" or "undecided". */
static const char *get_law_name(enum push_law law)
{
    static const char *const names[] = {"undecided", "elastic", "rigid"};
    return names[law];
}

static void add_law(struct answer *answer, const struct push_ground *ground)
{
    double ln = ground->log_odds;
    /* do not show larger odds: they would depend on rare gage errors, which may not be normally
     * distributed */
    char times[32] = "over a million";
    if (fabs(ln) < log(1e6))
        snprintf(times, sizeof times, "%.3g", exp(fabs(ln)));
    answer_add_text(answer, "law", NULL, "%s", get_law_name(ground->law));
    answer_add_value(answer, "log_odds", NULL, UNIT_NUMBER, ln, 1);
    switch (ground->law) {
    case PUSH_ELASTIC:
        answer_add_sentence(answer, NULL,
                            "Elastic ground: mats move before they slide. The readings are %s "
                            "times as likely with this law as with Coulomb's rigid law.",
                            times);
        break;
    case PUSH_RIGID:
        answer_add_sentence(answer, NULL,
                            "Coulomb's rigid law: the mat does not move before it slides. The "
                            "readings are %s times as likely with this law as with elastic ground "
                            "of %.0f to %.0f lb/ft per mat. The scene gets no gear_ key.",
                            times, PUSH_EXPECTED_STIFFNESS_LB_FT * pow(10.0, -PUSH_PRIOR_DECADES),
                            PUSH_EXPECTED_STIFFNESS_LB_FT * pow(10.0, PUSH_PRIOR_DECADES));
        break;
    default:
        answer_add_sentence(answer, NULL,
                            "Elastic ground cannot be distinguished from Coulomb's rigid law: the "
                            "readings are %s times as likely with %s as with the other law, but a "
                            "decision needs a factor of %.0f. Push harder (to 0.8 of the sliding "
                            "force), or take more readings. The scene gets no gear_ key.",
                            times, ln > 0.0 ? "elastic ground" : "the rigid law", PUSH_ODDS_MIN);
    }
}

/* Adds a parameter that is not determined. `kept`: value that a scene should use instead; NULL:
 * none. */
static void add_undetermined_parameter(struct answer *answer, const char *name,
                                       const struct push_parameter *parameter, const char *kept)
{
    if (!isnan(parameter->interval.value))
        return;
    answer_add_text(answer, NULL, name, "undetermined: %s", parameter->reason);
    if (kept)
        answer_append_remark(answer, "; a scene uses %s", kept);
}

static void add_bounds(struct answer *answer, const struct push_ground *ground)
{
    add_undetermined_parameter(answer, "gear_k_lb_ft", &ground->k_lb_ft, NULL);
    if (isnan(ground->k_lb_ft.interval.value) && ground->k_lb_ft.interval.low > 0.0) {
        answer_append_remark(answer, "; at least %.0f lb/ft", ground->k_lb_ft.interval.low);
        answer_add_value(answer, "k_at_least_lb_ft", NULL, UNIT_NUMBER,
                         ground->k_lb_ft.interval.low, 0);
    }
    add_undetermined_parameter(answer, "gear_unloading", &ground->unloading_ratio, "1");
    add_undetermined_parameter(answer, "gear_axle_law", &ground->axle_law, "1");
    add_undetermined_parameter(answer, "f", &ground->friction, NULL);
    if (isnan(ground->friction.interval.value)) {
        answer_append_remark(answer, "; at least %.3f", ground->friction.interval.low);
        answer_add_value(answer, "f_at_least", NULL, UNIT_NUMBER, ground->friction.interval.low, 3);
    }
    answer_add_text(answer, NULL, "gear_damping",
                    "not determined by readings at rest; a scene uses 0.5 of critical damping");
}

static void add_warnings(struct answer *answer, const struct push_ground *ground)
{
    const struct push_interval *rho = &ground->unloading_ratio.interval;
    if (ground->has_excess_scatter)
        answer_add_sentence(
            answer, NULL,
            "Neither law fits well: the readings scatter %.1f times as much as their stated "
            "errors, which happens by chance once in 1,000 tests. The intervals are wider by this "
            "factor. Check the curves for a bend, a drift, or a rod that makes contact late.",
            ground->scatter);
    if (!isnan(rho->value) && rho->low > UNLOADING_RATIO_MAX)
        answer_add_sentence(
            answer, NULL,
            "The mat moved back further than it had moved forward (ratio %.2f, lower bound %.2f): "
            "check the zero of the dial and the load. gear_unloading is set to 1.",
            rho->value, rho->low);
    if (ground->law == PUSH_ELASTIC && ground->undetermined_count > 0)
        answer_add_sentence(answer, NULL,
                            "Left out: %zu test%s in which the mat moved too little to give a "
                            "stiffness. The results therefore underrepresent stiff places.",
                            ground->undetermined_count, ground->undetermined_count == 1 ? "" : "s");
}

void push_add_law(struct answer *answer, const struct push_ground *ground,
                  const struct push_setting *setting)
{
    const struct push_interval *k = &ground->k_lb_ft.interval;
    add_law(answer, ground);
    add_warnings(answer, ground);
    if (!isnan(k->value))
        answer_add_sentence(
            answer, NULL,
            "In these tests, %.4g lb pressed %u mat%s, which moved as one (--mats). Their total "
            "stiffness is %.4g lb/in; gear_k_lb_ft is the stiffness of one mat in lb/ft: 12 times "
            "the total, divided by %u. A contact area of a different length gives another value.",
            ground->axle_load_lb, setting->mat_count, setting->mat_count == 1 ? "" : "s",
            k->value * setting->mat_count / IN_PER_FT, setting->mat_count);
    if (!isnan(k->value) && setting->mat_count == 1)
        answer_add_sentence(answer, NULL,
                            "A wheel with a contact as long as a mat nearly always presses two "
                            "mats. For such a wheel, test over a joint and give --mats 2.");
    answer_add_value(answer, "axle_load_lb", NULL, UNIT_NUMBER, ground->axle_load_lb, 1);
    answer_add_count(answer, "mats", NULL, (int64_t)setting->mat_count);
    answer_add_value(answer, "scatter", "scatter / stated error", UNIT_NUMBER, ground->scatter, 2);
    if (!isnan(ground->spread))
        answer_add_value(answer, "spread",
                         "variation of k between places, standard deviation of ln k", UNIT_NUMBER,
                         ground->spread, 2);
    add_bounds(answer, ground);
}

static void add_interval(struct answer *answer, const char *name, const char *label,
                         const struct push_interval *of, int decimals)
{
    char low[32], high[32];
    snprintf(low, sizeof low, "%s_low", name);
    snprintf(high, sizeof high, "%s_high", name);
    answer_add_value(answer, name, NULL, UNIT_NUMBER, of->value, decimals);
    answer_add_value(answer, low, NULL, UNIT_NUMBER, of->low, decimals);
    answer_add_value(answer, high, NULL, UNIT_NUMBER, of->high, decimals);
    if (!isnan(of->value))
        answer_add_text(answer, NULL, label, "%.*f (%.*f to %.*f)", decimals, of->value, decimals,
                        of->low, decimals, of->high);
    else if (isfinite(of->low))
        answer_add_text(answer, NULL, label, "above %.*f", decimals, of->low);
    else
        answer_add_text(answer, NULL, label, "-");
}

void push_add_tests(struct answer *answer, const struct push_readings *readings,
                    const struct push_ground *ground)
{
    answer_open_table(answer, "tests", "Tests");
    for (size_t i = 0; i < readings->count; i++) {
        const struct push_series *series = &readings->series[i];
        const struct push_fit *fit = &ground->fit[i];
        answer_open_row(answer);
        answer_add_text(answer, "test", "test", "%s", series->name);
        answer_add_value(answer, "load_lb", "load, lb", UNIT_NUMBER, series->load_lb, 1);
        answer_add_count(answer, "readings", "readings", (int64_t)series->count);
        answer_add_value(answer, "most_lb", "most|force, lb", UNIT_NUMBER, fit->max_force_lb, 1);
        add_interval(answer, "k_lb_in", "all mats,|lb/in (95 %)", &fit->k_lb_in, 0);
        add_interval(answer, "unloading", "springs back|(95 %)", &fit->unloading_ratio, 2);
        answer_add_value(answer, "slid_lb", "sliding|force, lb", UNIT_NUMBER, fit->slide_force_lb,
                         1);
        answer_add_value(answer, "chi_square", NULL, UNIT_NUMBER, fit->chi_square, 1);
        answer_add_value(answer, "rigid_chi_square", NULL, UNIT_NUMBER, fit->rigid_chi_square, 1);
        answer_add_count(answer, "freedom", NULL, (int64_t)fit->degrees_of_freedom);
        answer_add_text(answer, NULL, "chi2 elastic,|rigid (freedom)", "%.0f, %.0f (%zu)",
                        fit->chi_square, fit->rigid_chi_square, fit->degrees_of_freedom);
    }
    answer_close_group(answer);
}

/* ---- ground ---- */

#define Z_95                     1.96
#define CHI_SQUARE_95_ONE_DEGREE 3.84
#define LOAD_RELATIVE_TOLERANCE  0.02 /* loads that differ by less than this count as equal */
#define BISECTION_COUNT          60
#define LN_K_SPREAD_MAX          10.0

/* Fit of y = coefficient[0] + coefficient[1] x with weights 1/(error^2 + spread^2); `term_count`:
 * number of coefficients. */
struct weighted_fit {
    double y[PUSH_SERIES_MAX], error[PUSH_SERIES_MAX], x[PUSH_SERIES_MAX];
    size_t count, term_count;
    /* half_width_in_errors: half width of a 95 % interval, in standard errors */
    double coefficient[2], coefficient_error[2], spread, half_width_in_errors;
};

/* Fits with a given spread; returns the weighted sum of squared residuals. */
static double fit_with_spread(struct weighted_fit *p, double spread)
{
    double s = 0.0, sx = 0.0, sxx = 0.0, sy = 0.0, sxy = 0.0, left = 0.0;
    for (size_t i = 0; i < p->count; i++) {
        double weight = 1.0 / (p->error[i] * p->error[i] + spread * spread);
        s += weight;
        sx += weight * p->x[i];
        sxx += weight * p->x[i] * p->x[i];
        sy += weight * p->y[i];
        sxy += weight * p->x[i] * p->y[i];
    }
    double whole = s * sxx - sx * sx;
    bool line = p->term_count == 2;
    p->coefficient[0] = line ? (sxx * sy - sx * sxy) / whole : sy / s;
    p->coefficient[1] = line ? (s * sxy - sx * sy) / whole : 0.0;
    p->coefficient_error[0] = sqrt(line ? sxx / whole : 1.0 / s);
    p->coefficient_error[1] = line ? sqrt(s / whole) : 0.0;
    for (size_t i = 0; i < p->count; i++) {
        double off = p->y[i] - p->coefficient[0] - p->coefficient[1] * p->x[i];
        left += off * off / (p->error[i] * p->error[i] + spread * spread);
    }
    return left;
}

static void fit_with_best_spread(struct weighted_fit *p)
{
    size_t more = p->count > p->term_count ? p->count - p->term_count : 0;
    double left = fit_with_spread(p, 0.0), low = 0.0, high = LN_K_SPREAD_MAX;
    p->spread = 0.0;
    p->half_width_in_errors = Z_95;
    if (more == 0 || (more == 1 && left <= CHI_SQUARE_95_ONE_DEGREE))
        return;
    if (left > (double)more) {
        for (int i = 0; i < BISECTION_COUNT; i++) {
            double middle = 0.5 * (low + high);
            if (fit_with_spread(p, middle) > (double)more)
                low = middle;
            else
                high = middle;
        }
        p->spread = high;
        left = fit_with_spread(p, p->spread);
    }
    double scatter = sqrt(left / (double)more) * mr_gates_student_factor((unsigned)more);
    p->half_width_in_errors = Z_95 * fmax(1.0, scatter);
}

static struct push_interval make_interval(const struct weighted_fit *p, size_t term)
{
    double half = p->half_width_in_errors * p->coefficient_error[term];
    return (struct push_interval){p->coefficient[term], p->coefficient[term] - half,
                                  p->coefficient[term] + half};
}

static void set_undetermined(struct push_parameter *parameter, const char *reason)
{
    parameter->interval = (struct push_interval){(double)NAN, -(double)INFINITY, (double)INFINITY};
    snprintf(parameter->reason, sizeof parameter->reason, "%s", reason);
}

static size_t count_fit_terms(const struct push_readings *readings)
{
    double low = HUGE_VAL, high = 0.0;
    for (size_t i = 0; i < readings->count; i++) {
        low = fmin(low, readings->series[i].load_lb);
        high = fmax(high, readings->series[i].load_lb);
    }
    return high > low * (1.0 + LOAD_RELATIVE_TOLERANCE) ? 2 : 1;
}

/* Computes the logarithm of the stiffness under one mat from one test, with its standard error.
 * Returns false if the test gives only bounds. */
static bool get_stiffness(const struct push_fit *fit, const struct push_setting *setting,
                          double *ln, double *error)
{
    const struct push_interval *k = &fit->k_lb_in;
    if (!isfinite(k->high) || !(k->low > 0.0))
        return false;
    *ln = log(IN_PER_FT * k->value / setting->mat_count);
    *error = fmax(log(k->high / k->value), log(k->value / k->low)) / Z_95;
    return true;
}

/* Computes a lower bound if all tests give only bounds. Each bound is valid only at the place of
 * its test, so the smallest is reported. */
static void bound_stiffness(const struct push_setting *setting, size_t count,
                            struct push_ground *ground)
{
    double least = HUGE_VAL;
    for (size_t i = 0; i < count; i++)
        least = fmin(least, IN_PER_FT * ground->fit[i].k_lb_in.low / setting->mat_count);
    set_undetermined(&ground->k_lb_ft,
                     "in every test, the mat moved by less than the errors of the gages");
    ground->k_lb_ft.interval.low = fmax(0.0, least);
}

static void find_stiffness(const struct push_readings *readings, const struct push_setting *setting,
                           struct push_ground *ground)
{
    struct weighted_fit p = {.term_count = count_fit_terms(readings)};
    double low = HUGE_VAL, high = 0.0;
    for (size_t i = 0; i < readings->count; i++) {
        if (!get_stiffness(&ground->fit[i], setting, &p.y[p.count], &p.error[p.count]))
            continue;
        p.x[p.count++] = log(readings->series[i].load_lb / ground->axle_load_lb);
        low = fmin(low, readings->series[i].load_lb);
        high = fmax(high, readings->series[i].load_lb);
    }
    ground->undetermined_count = readings->count - p.count;
    if (p.count == 0) {
        bound_stiffness(setting, readings->count, ground);
        set_undetermined(&ground->axle_law, ground->k_lb_ft.reason);
        return;
    }
    bool two = p.term_count == 2 && high > low * (1.0 + LOAD_RELATIVE_TOLERANCE);
    p.term_count = two ? 2 : 1;
    if (!two && fabs(log(low / ground->axle_load_lb)) > LOAD_RELATIVE_TOLERANCE) {
        char why[PUSH_REASON_SIZE];
        snprintf(why, sizeof why,
                 "the tests used %.4g lb, but an axle has %.4g lb: to find how stiffness depends "
                 "on load, test under a second load",
                 low, ground->axle_load_lb);
        set_undetermined(&ground->k_lb_ft, why);
        set_undetermined(&ground->axle_law,
                         "the tests used only one load: test also under twice the load of an axle");
        return;
    }
    fit_with_best_spread(&p);
    struct push_interval ln = make_interval(&p, 0);
    size_t more = p.count - p.term_count;
    ground->k_lb_ft.interval = (struct push_interval){exp(ln.value), exp(ln.low), exp(ln.high)};
    snprintf(ground->k_lb_ft.reason, PUSH_REASON_SIZE, "%zu push test%s, %s", p.count,
             p.count == 1 ? "" : "s",
             more >= 2      ? "which includes the variation between places"
             : p.spread > 0 ? "which contradict each other"
                            : "valid only for the tested places; three or more tests are needed to "
                              "estimate the variation between places");
    if (more >= 2)
        ground->spread = p.spread;
    if (!two) {
        set_undetermined(&ground->axle_law,
                         "the tests used only one load: test also under twice the load of an axle");
        return;
    }
    ground->axle_law.interval = make_interval(&p, 1);
    snprintf(ground->axle_law.reason, PUSH_REASON_SIZE,
             "stiffness under %.4g lb compared with %.4g lb", high, low);
}

static void find_unloading_ratio(const struct push_readings *readings, struct push_ground *ground)
{
    struct weighted_fit p = {.term_count = 1};
    size_t falling = 0;
    for (size_t i = 0; i < readings->count; i++) {
        const struct push_interval *rho = &ground->fit[i].unloading_ratio;
        falling += ground->fit[i].unloading_count;
        if (isnan(rho->value) || !isfinite(rho->high - rho->low))
            continue;
        p.y[p.count] = rho->value;
        p.error[p.count++] = fmax(rho->high - rho->value, rho->value - rho->low) / Z_95;
    }
    if (p.count == 0) {
        set_undetermined(&ground->unloading_ratio,
                         falling == 0 ? "no readings while unloading: read also while unloading"
                                      : "the stiffness is not determined either");
        return;
    }
    fit_with_best_spread(&p);
    ground->unloading_ratio.interval = make_interval(&p, 0);
    snprintf(ground->unloading_ratio.reason, PUSH_REASON_SIZE,
             "readings while unloading, from %zu push test%s", p.count, p.count == 1 ? "" : "s");
}

static double compute_normal_force_lb(const struct push_setting *setting, double load_lb)
{
    return load_lb + setting->mat_count * setting->mat_weight_lb;
}

static void find_friction(const struct push_readings *readings, const struct push_setting *setting,
                          struct push_ground *ground)
{
    struct weighted_fit p = {.term_count = 1};
    double held = 0.0;
    for (size_t i = 0; i < readings->count; i++) {
        const struct push_fit *fit = &ground->fit[i];
        double pressing = compute_normal_force_lb(setting, readings->series[i].load_lb);
        held = fmax(held,
                    (fit->slid_count ? fabs(fit->slide_force_lb) : fit->max_force_lb) / pressing);
        if (fit->slid_count == 0)
            continue;
        p.y[p.count] = fabs(fit->slide_force_lb) / pressing;
        p.error[p.count++] = ground->interval_factor * setting->gage_errors.force_lb /
                             sqrt((double)fit->slid_count) / pressing;
    }
    if (p.count == 0) {
        set_undetermined(&ground->friction,
                         "no mat slid: push until a mat slides, or pull a mat without load");
        ground->friction.interval.low = held;
        return;
    }
    fit_with_best_spread(&p);
    ground->friction.interval = make_interval(&p, 0);
    snprintf(ground->friction.reason, PUSH_REASON_SIZE,
             "from %zu push test%s in which the mat slid", p.count, p.count == 1 ? "" : "s");
}

/* Finds the scatter of the readings of all tests, relative to the stated errors of the gages. All
 * tests use the same pair of gages. */
static void find_scatter(size_t count, struct push_ground *ground)
{
    double squares = 0.0;
    size_t freedom = 0;
    for (size_t i = 0; i < count; i++) {
        squares += ground->fit[i].chi_square;
        freedom += ground->fit[i].degrees_of_freedom;
    }
    ground->scatter = (double)NAN;
    ground->interval_factor = 1.0;
    if (freedom == 0)
        return;
    ground->scatter = sqrt(squares / (double)freedom);
    ground->has_excess_scatter = squares >
                                 mr_chi_square_limit((unsigned)freedom, MR_SIGMA_1_IN_1000);
    ground->interval_factor = fmax(1.0,
                                   ground->scatter * mr_gates_student_factor((unsigned)freedom));
}

static enum mr_status fit_all_tests(const struct push_readings *readings,
                                    const struct push_setting *setting, double stretch,
                                    struct push_ground *ground, struct error *error)
{
    double expected_lb_in = PUSH_EXPECTED_STIFFNESS_LB_FT * setting->mat_count / IN_PER_FT;
    ground->log_odds = 0.0;
    for (size_t i = 0; i < readings->count; i++) {
        if (push_fit(&readings->series[i], setting->gage_errors, expected_lb_in, stretch,
                     &ground->fit[i], error) != MR_OK)
            return error->status;
        ground->log_odds += ground->fit[i].log_odds;
    }
    return MR_OK;
}

enum mr_status push_ground_estimate(const struct push_readings *readings,
                                    const struct push_setting *setting, struct push_ground *ground,
                                    struct error *error)
{
    double load_lb = HUGE_VAL;
    *ground = (struct push_ground){.spread = (double)NAN};
    ground->fit = xcalloc(readings->count, sizeof *ground->fit);
    for (size_t i = 0; i < readings->count; i++)
        load_lb = fmin(load_lb, readings->series[i].load_lb);
    ground->axle_load_lb = setting->axle_load_lb > 0.0 ? setting->axle_load_lb : load_lb;
    if (fit_all_tests(readings, setting, 1.0, ground, error) != MR_OK)
        return error->status;
    find_scatter(readings->count, ground);
    if (ground->interval_factor > 1.0 &&
        fit_all_tests(readings, setting, ground->interval_factor, ground, error) != MR_OK)
        return error->status;
    if (!isfinite(ground->log_odds))
        return error_set(error, MR_NUMERICS,
                         "no law fits the readings, because %s is not a finite number; check the "
                         "units of the readings and the errors of the gages",
                         readings->series[0].path);
    find_stiffness(readings, setting, ground);
    find_unloading_ratio(readings, ground);
    find_friction(readings, setting, ground);
    if (ground->log_odds > log(PUSH_ODDS_MIN) && ground->undetermined_count < readings->count)
        ground->law = PUSH_ELASTIC;
    else if (ground->log_odds < -log(PUSH_ODDS_MIN))
        ground->law = PUSH_RIGID;
    return MR_OK;
}

void push_ground_free(struct push_ground *ground)
{
    free(ground->fit);
    *ground = (struct push_ground){0};
}
