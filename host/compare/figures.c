#include "host/compare/figures.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Movement, or spread, of a row at a time; linear between samples, at rest after the last one, NaN
 * before the first. */
static double at(const struct store_simulation *row, const float *values, double t_s)
{
    double k = (t_s - row->t0_s) / row->dt_s;
    if (!values || row->length == 0 || !(k >= 0.0))
        return (double)NAN;
    size_t i = (size_t)fmin(k, (double)row->length);
    if (i + 1 >= row->length)
        return (double)values[row->length - 1];
    return (double)values[i] + (k - (double)i) * (double)(values[i + 1] - values[i]);
}

static bool make_room(struct compare_curves *s, size_t n)
{
    s->storage = malloc(7 * n * sizeof *s->storage + 1);
    if (!s->storage)
        return false;
    double **arrays[] = {&s->t_s,          &s->measured_in,        &s->measured_error_in,
                         &s->simulated_in, &s->simulated_error_in, &s->time_error_s,
                         &s->alignment_in};
    for (size_t i = 0; i < 7; i++)
        *arrays[i] = s->storage + i * n;
    return true;
}

enum mr_status compare_curves(const struct measured *measured, const struct compare_clock *clock,
                              const struct measured_channel *channel,
                              const struct store_simulation *row, double solver_error_in,
                              struct compare_curves *s, struct error *error)
{
    double end_s = row->t0_s + (double)(row->length - 1) * row->dt_s;
    if (!make_room(s, measured->samples))
        return error_set(error, MR_FULL, "no memory: series of transducer %u; close other programs",
                         channel->config.number);
    for (size_t i = 0; i < measured->samples; i++) {
        double t_s = measured_time_s(measured, i);
        s->t_s[i] = t_s;
        bool outside = t_s < 0.0 || t_s > end_s;
        s->measured_in[i] = outside ? (double)NAN : measured_value(channel, i);
        s->simulated_in[i] = outside ? (double)NAN : at(row, row->series_in, t_s);
        s->time_error_s[i] = compare_time_error(clock, t_s);
        double before_in = at(row, row->series_in, fmax(t_s - s->time_error_s[i], row->t0_s));
        s->alignment_in[i] = 0.5 *
                             fabs(at(row, row->series_in, t_s + s->time_error_s[i]) - before_in);
        s->measured_error_in[i] = hypot(measured_error(measured, channel, s->measured_in[i], 1.0),
                                        s->alignment_in[i]);
        double spread_in = at(row, row->spread_in, t_s);
        s->simulated_error_in[i] = hypot(solver_error_in, isnan(spread_in) ? 0.0 : spread_in);
    }
    return MR_OK;
}

/* Over the last 0.2 s that both have. */
static void find_end(const struct measured *measured, const struct measured_channel *channel,
                     const struct compare_curves *s, struct compare_channel *out)
{
    double sum_m = 0.0, sum_s = 0.0, alignment = 0.0, simulated_error = 0.0;
    size_t count = 0;
    for (size_t i = measured->samples; i-- > 0 && count < MEASURED_END_BLOCKS;) {
        if (isnan(s->measured_in[i]) || isnan(s->simulated_in[i]))
            continue;
        sum_m += s->measured_in[i];
        sum_s += s->simulated_in[i];
        alignment += s->alignment_in[i];
        simulated_error += s->simulated_error_in[i];
        count++;
    }
    double n = (double)count;
    out->end_measured.value = sum_m / n;
    out->end_measured.error = hypot(measured_error(measured, channel, sum_m / n, n), alignment / n);
    out->end_simulated.value = sum_s / n;
    out->end_simulated.error = simulated_error / n;
    out->end_en = signal_en(out->end_measured.value, out->end_measured.error,
                            out->end_simulated.value, out->end_simulated.error);
}

static void find_figures(const struct measured *measured, const struct measured_channel *channel,
                         const struct compare_curves *s, struct compare_channel *out)
{
    const struct signal signal = {
        .count = measured->samples,
        .t0_s = measured_time_s(measured, 0),
        .dt_s = 0.001,
        .measured = s->measured_in,
        .simulated = s->simulated_in,
        .measured_error = s->measured_error_in,
        .simulated_error = s->simulated_error_in,
        .time_error_s = s->time_error_s,
        .noise = isnan(channel->noise) ? 0.0 : channel->noise,
    };
    struct signal_figures *f = &out->f;
    signal_compare(&signal, f);
    /* Free of what noise adds to a largest value (measured.h). */
    f->peak_measured.value = channel->peak;
    f->peak_measured.error = channel->error;
    find_end(measured, channel, s, out);
    out->bias_en = signal_en(f->bias, f->bias_error, 0.0, 0.0);
    out->peak_en = signal_en(f->peak_measured.value, f->peak_measured.error,
                             f->peak_simulated.value, f->peak_simulated.error);
    const struct signal_moment *m = &f->arrival_measured, *a = &f->arrival_simulated;
    out->arrival_en = signal_en(m->t_s, m->t_error_s, a->t_s, a->t_error_s);
    out->ahead_measured_ft = out->station_ft - measured_station_ft(measured, m->t_s);
    out->ahead_simulated_ft = out->station_ft - measured_station_ft(measured, a->t_s);
    for (size_t i = 0; i < measured->samples; i++)
        out->alignment_in = fmax(out->alignment_in, s->alignment_in[i]);
    if (f->flat_measured || f->flat_simulated)
        snprintf(out->why, sizeof out->why, "%s: no correlation",
                 !f->flat_simulated  ? "the measured is flat"
                 : !f->flat_measured ? "the simulated is flat"
                                     : "both are flat");
}

/* What most of its readings are that are not valid. */
static const char *most_often(const struct measured *measured,
                              const struct measured_channel *channel)
{
    size_t counts[256] = {0}, most = 0;
    for (size_t i = 0; i < measured->samples; i++)
        counts[channel->validity[i]]++;
    for (size_t v = 1; v < 256; v++)
        most = counts[v] > counts[most ? most : 1] || !most ? v : most;
    return most == MEASURED_LOST      ? "it did not come"
         : most == MEASURED_NOT_VALID ? "not valid"
                                      : mr_validity_text((unsigned)most);
}

static bool usable(const struct measured *measured, const struct measured_channel *channel,
                   const struct store_simulation *row, struct compare_channel *out)
{
    size_t of = 0, valid = 0;
    double end_s = row ? row->t0_s + (double)row->length * row->dt_s : 0.0;
    for (size_t i = 0; i < measured->samples && channel->raw; i++) {
        double t_s = measured_time_s(measured, i);
        of += t_s >= 0.0 && t_s <= end_s;
        valid += t_s >= 0.0 && t_s <= end_s && !isnan(measured_value(channel, i));
    }
    out->valid = of ? (double)valid / (double)of : 0.0;
    if (!row || row->length == 0)
        snprintf(out->why, sizeof out->why, "not simulated; compare the landing again");
    else if (!channel->raw || of == 0)
        snprintf(out->why, sizeof out->why, "no readings came");
    else if (isnan(channel->baseline))
        snprintf(out->why, sizeof out->why, "no reading at rest before the landing: %s",
                 most_often(measured, channel));
    else if (out->valid < COMPARE_LEAST_VALID)
        snprintf(out->why, sizeof out->why,
                 "%.0f %% of its readings are valid, half are needed: %s", 100.0 * out->valid,
                 most_often(measured, channel));
    else
        return true;
    return false;
}

static enum mr_status add_channel(const struct measured *measured,
                                  const struct compare_clock *clock,
                                  const struct measured_channel *channel,
                                  const struct store_simulation *row, double solver_error_in,
                                  struct compare_channel *out, struct error *error)
{
    const double nan = (double)NAN;
    struct compare_curves series;
    *out = (struct compare_channel){.number = channel->config.number,
                                    .station_ft = (double)channel->config.station_ft,
                                    .bias_en = nan,
                                    .peak_en = nan,
                                    .end_en = nan,
                                    .arrival_en = nan,
                                    .ahead_measured_ft = nan,
                                    .ahead_simulated_ft = nan,
                                    .end_measured = {nan, nan, nan, nan, nan},
                                    .end_simulated = {nan, nan, nan, nan, nan}};
    const struct signal empty = {.count = 0};
    signal_compare(&empty, &out->f); /* everything not known */
    out->compared = usable(measured, channel, row, out);
    if (!out->compared)
        return MR_OK;
    if (compare_curves(measured, clock, channel, row, solver_error_in, &series, error) != MR_OK)
        return error->status;
    find_figures(measured, channel, &series, out);
    free(series.storage);
    return MR_OK;
}

enum mr_status compare_figures(const struct measured *measured, const struct zones_closure *survey,
                               const struct compare_said *said,
                               const struct store_simulation_head *head,
                               const struct store_simulation *rows, size_t count,
                               struct compare_figures *figures, struct error *error)
{
    struct compare_clock clock;
    memset(figures, 0, sizeof *figures);
    figures->run = measured->landing.id;
    doubts_headline(&measured->doubts, figures->doubt);
    snprintf(figures->against, sizeof figures->against, "%s", head->file);
    figures->run_ms = head->run_ms;
    figures->error_in = head->error_in;
    figures->seeds = head->seeds;
    figures->edges = head->edges;
    figures->offset_s = head->offset_s;
    figures->scatter_s = head->scatter_s;
    figures->surveyed = survey->surveyed;
    compare_clock_make(measured, &clock);
    for (unsigned number = 1; number <= MR_TRANSDUCERS && error->status == MR_OK; number++) {
        int c = measured_find(measured, MR_KIND_DISPLACEMENT, number);
        const struct store_simulation *row = NULL;
        for (size_t i = 0; i < count; i++)
            row = rows[i].number == (int64_t)number ? &rows[i] : row;
        if (c < 0)
            continue;
        double solver_error_in = !isnan(head->error_in) ? head->error_in
                               : row                    ? row->peak_simulated_error_in
                                                        : 0.0;
        add_channel(measured, &clock, &measured->channel[c], row, solver_error_in,
                    &figures->channel[figures->channels++], error);
    }
    const struct compare_segments segments = {head->segments_in, head->segment_rows,
                                              head->segments_dt_s};
    if (error->status == MR_OK)
        compare_zones(measured, survey, said, &segments, &figures->zones);
    return error->status;
}

struct compare_mean compare_mean_of(const struct compare_figures *figures)
{
    struct compare_mean mean = {0};
    double sum = 0.0, squares = 0.0;
    for (size_t i = 0; i < figures->channels; i++) {
        const struct compare_channel *c = &figures->channel[i];
        if (!c->compared)
            continue;
        double n = (double)c->f.compared;
        mean.channels++;
        mean.samples += n;
        sum += n * c->f.bias;
        squares += n * c->f.rms * c->f.rms;
        mean.worst_rms_in = fmax(mean.worst_rms_in, c->f.rms);
        mean.peak_en = fmax(mean.peak_en, c->peak_en);
    }
    mean.bias_in = mean.samples > 0.0 ? sum / mean.samples : (double)NAN;
    mean.rms_in = mean.samples > 0.0 ? sqrt(squares / mean.samples) : (double)NAN;
    if (mean.channels == 0)
        mean.worst_rms_in = mean.peak_en = (double)NAN;
    return mean;
}
