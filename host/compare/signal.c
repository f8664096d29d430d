#include "host/compare/signal.h"

#include <math.h>

/* standard deviations: none of some thousand samples is so far off by chance */
#define FAR_FROM_NOISE 5.0
#define ROUNDING       1e-9

double signal_en(double measured, double measured_error, double simulated, double simulated_error)
{
    double error = hypot(measured_error, simulated_error), difference = fabs(measured - simulated);
    if (isnan(difference) || isnan(error))
        return (double)NAN;
    if (error > 0.0)
        return difference / (2.0 * error);
    return difference > 0.0 ? (double)INFINITY : 0.0;
}

static bool both(const struct signal *s, size_t i)
{
    return !isnan(s->measured[i]) && !isnan(s->simulated[i]);
}

/* Noise averages out over the samples; what else a sample's error has is taken as common to all of
 * them. */
static void find_differences(const struct signal *s, struct signal_figures *f)
{
    double sum = 0.0, squares = 0.0, chi = 0.0, common = 0.0;
    size_t inside = 0;
    for (size_t i = 0; i < s->count; i++) {
        if (!both(s, i))
            continue;
        double d = s->measured[i] - s->simulated[i],
               u = hypot(s->measured_error[i], s->simulated_error[i]);
        sum += d;
        squares += d * d;
        if (d != 0.0)
            chi += d * d / (u * u);
        inside += fabs(d) <= 2.0 * u;
        common += sqrt(fmax(u * u - s->noise * s->noise, 0.0));
        f->compared++;
    }
    double n = (double)f->compared;
    if (f->compared == 0)
        return;
    f->bias = sum / n;
    f->bias_error = hypot(common / n, s->noise / sqrt(n));
    f->rms = sqrt(squares / n);
    f->chi = sqrt(chi / n);
    f->inside = (double)inside / n;
}

/* Mean over SIGNAL_WINDOW samples around i of those that both have, so that both are smoothed
 * alike; NaN: none. */
static double smooth(const struct signal *s, const double *values, size_t i)
{
    size_t half = SIGNAL_WINDOW / 2, from = i > half ? i - half : 0,
           to = i + half < s->count ? i + half : s->count - 1;
    double sum = 0.0;
    size_t count = 0;
    for (size_t k = from; k <= to; k++) {
        if (!both(s, k))
            continue;
        sum += values[k];
        count++;
    }
    return count ? sum / (double)count : (double)NAN;
}

static double time_of(const struct signal *s, double i)
{
    return s->t0_s + i * s->dt_s;
}

/* Of one side. `noise`: of the mean over the window. */
static struct signal_moment find_peak(const struct signal *s, const double *values,
                                      const double *errors, double noise)
{
    struct signal_moment peak = {(double)NAN, (double)NAN, (double)NAN, (double)NAN, (double)NAN};
    size_t at = 0, first = 0, last = 0;
    for (size_t i = 0; i < s->count; i++) {
        double value = both(s, i) ? smooth(s, values, i) : (double)NAN;
        if (isnan(value) || fabs(value) <= fabs(peak.value))
            continue;
        peak.value = value;
        at = i;
    }
    if (isnan(peak.value))
        return peak;
    double near = fmax(SIGNAL_NEAR * fabs(peak.value), FAR_FROM_NOISE * noise);
    for (first = 0; !(fabs(peak.value - smooth(s, values, first)) <= near);)
        first++; /* at the peak at the latest */
    for (last = s->count - 1; !(fabs(peak.value - smooth(s, values, last)) <= near);)
        last--;
    peak.error = errors[at];
    peak.t_s = time_of(s, (double)first);
    peak.t_error_s = s->time_error_s[first];
    peak.lasts_s = (double)(last - first) * s->dt_s;
    return peak;
}

static struct signal_moment find_arrival(const struct signal *s, const double *values,
                                         const double *errors, double noise, double peak,
                                         bool measured)
{
    struct signal_moment arrival = {SIGNAL_ARRIVAL * peak, (double)NAN, (double)NAN, (double)NAN,
                                    (double)NAN};
    double threshold = fabs(arrival.value), before = (double)NAN;
    if (!(threshold > FAR_FROM_NOISE * noise) || threshold == 0.0)
        return arrival;
    for (size_t i = 0; i < s->count; i++) {
        double value = both(s, i) ? smooth(s, values, i) * (peak < 0.0 ? -1.0 : 1.0) : (double)NAN;
        if (isnan(value))
            continue;
        if (value < threshold) {
            before = value;
            continue;
        }
        if (isnan(before)) /* it was there from the beginning */
            return arrival;
        size_t half = SIGNAL_WINDOW / 2, from = i > half ? i - half : 0,
               to = i + half < s->count ? i + half : s->count - 1;
        double slope = fabs(smooth(s, values, to) - smooth(s, values, from)) /
                       ((double)(to - from) * s->dt_s);
        double u = errors[i];
        if (measured) /* of it the noise is that of a mean */
            u = sqrt(fmax(u * u - s->noise * s->noise, 0.0) + noise * noise);
        arrival.t_s = time_of(s, (double)i - (value - threshold) / (value - before));
        arrival.error = u;
        arrival.t_error_s = sqrt(u * u / (slope * slope) +
                                 (measured ? s->time_error_s[i] * s->time_error_s[i] : 0.0) +
                                 s->dt_s * s->dt_s / 12.0);
        return arrival;
    }
    return arrival;
}

static double correlate(const struct signal *s)
{
    double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, xy = 0.0;
    for (size_t i = 0; i < s->count; i++) {
        double m = s->measured[i], k = s->simulated[i];
        if (isnan(m) || isnan(k))
            continue;
        n += 1.0;
        x += m;
        y += k;
        xx += m * m;
        yy += k * k;
        xy += m * k;
    }
    double vx = xx - x * x / n, vy = yy - y * y / n;
    return vx > 0.0 && vy > 0.0 ? (xy - x * y / n) / sqrt(vx * vy) : (double)NAN;
}

/* It varies by no more than noise, or than rounding. */
static bool is_flat(const struct signal *s, const double *values)
{
    double sum = 0.0, squares = 0.0, n = 0.0, size = 0.0;
    for (size_t i = 0; i < s->count; i++) {
        if (!both(s, i))
            continue;
        sum += values[i];
        size = fmax(size, fabs(values[i]));
        n += 1.0;
    }
    for (size_t i = 0; i < s->count; i++) {
        if (both(s, i))
            squares += (values[i] - sum / n) * (values[i] - sum / n);
    }
    return !(n > 1.0 && sqrt(squares / (n - 1.0)) > fmax(2.0 * s->noise, ROUNDING * size));
}

void signal_compare(const struct signal *s, struct signal_figures *f)
{
    const struct signal_moment unknown = {(double)NAN, (double)NAN, (double)NAN, (double)NAN,
                                          (double)NAN};
    *f = (struct signal_figures){
        .bias = (double)NAN,
        .bias_error = (double)NAN,
        .rms = (double)NAN,
        .chi = (double)NAN,
        .inside = (double)NAN,
        .peak_measured = unknown,
        .peak_simulated = unknown,
        .arrival_measured = unknown,
        .arrival_simulated = unknown,
        .correlation = (double)NAN,
    };
    double noise = s->noise / sqrt(SIGNAL_WINDOW);
    find_differences(s, f);
    if (f->compared == 0)
        return;
    f->peak_measured = find_peak(s, s->measured, s->measured_error, noise);
    f->peak_simulated = find_peak(s, s->simulated, s->simulated_error, noise);
    f->arrival_measured = find_arrival(s, s->measured, s->measured_error, noise,
                                       f->peak_measured.value, true);
    f->arrival_simulated = find_arrival(s, s->simulated, s->simulated_error, noise,
                                        f->peak_simulated.value, false);
    f->flat_measured = is_flat(s, s->measured);
    f->flat_simulated = is_flat(s, s->simulated);
    if (!f->flat_measured && !f->flat_simulated)
        f->correlation = correlate(s);
}
