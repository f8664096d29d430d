#include "host/study/fit/ensemble.h"

#include <gsl/gsl_cdf.h>
#include <gsl/gsl_qrng.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/monotonic_clock.h"

#define THREADS_MAX  64u
#define FAILED_SHARE 0.1

struct work {
    const struct fit_model *model;
    const struct ensemble_place *place;
    const struct fit_options *options;
    struct ensemble *ensemble;
    unsigned round;
    double until_s;
    bool *good;
    atomic_size_t next, done;
    atomic_bool stop;
};

void ensemble_at(const struct ensemble_place *place, const double *w, double *z)
{
    for (size_t i = 0; i < place->parameters; i++) {
        z[i] = place->middle[i];
        for (size_t k = 0; k <= i; k++)
            z[i] += place->spread[i][k] * w[k];
    }
}

/* Number of a draw: apart for every seed, round and place in the ensemble. */
static uint64_t draw_number(const struct work *work, size_t i)
{
    uint64_t x = work->options->seed * 0x9E3779B97F4A7C15u + ((uint64_t)work->round << 40) + i + 1;
    x = (x ^ x >> 30) * 0xBF58476D1CE4E5B9u;
    x = (x ^ x >> 27) * 0x94D049BB133111EBu;
    return x ^ x >> 31;
}

static void simulate_rows(const struct work *work, size_t from, size_t count)
{
    const struct fit_model *model = work->model;
    struct ensemble *ensemble = work->ensemble;
    double z[FIT_SOME * FIT_PARAMETERS_MAX];
    uint64_t draw[FIT_SOME];
    for (size_t k = 0; k < count; k++) {
        ensemble_at(work->place, ensemble->w + (from + k) * ensemble->parameters,
                    z + k * ensemble->parameters);
        draw[k] = ensemble->draw[from + k] = draw_number(work, from + k);
    }
    double *statistic = ensemble->statistic + from * ensemble->statistics;
    if (model->simulate_some)
        model->simulate_some(model->context, count, z, draw, statistic, work->good + from);
    else
        work->good[from] = model->simulate(model->context, z, draw[0], statistic);
}

static void simulate_share(struct work *work, bool first)
{
    struct ensemble *ensemble = work->ensemble;
    const struct fit_options *options = work->options;
    size_t some = work->model->simulate_some ? FIT_SOME : 1;
    for (;;) {
        size_t i = some * atomic_fetch_add(&work->next, 1);
        if (i >= ensemble->draws || atomic_load(&work->stop))
            return;
        size_t count = ensemble->draws - i < some ? ensemble->draws - i : some;
        simulate_rows(work, i, count);
        size_t done = atomic_fetch_add(&work->done, count) + count;
        if (monotonic_s() > work->until_s ||
            (first && options->go_on &&
             !options->go_on(options->go_on_context, work->round, done, ensemble->draws)))
            atomic_store(&work->stop, true);
    }
}

static void *helper(void *context)
{
    simulate_share(context, false);
    return NULL;
}

static void simulate_all(struct work *work)
{
    pthread_t thread[THREADS_MAX];
    unsigned wanted = work->options->threads, running = 0;
    if (wanted == 0)
        wanted = (unsigned)fmax(1.0, (double)sysconf(_SC_NPROCESSORS_ONLN));
    while (running + 1 < wanted && running < THREADS_MAX &&
           pthread_create(&thread[running], NULL, helper, work) == 0)
        running++;
    simulate_share(work, true);
    while (running > 0)
        pthread_join(thread[--running], NULL);
}

/* Sobol's points, shifted by a draw of the round and taken modulo 1: even, and different from round
 * to round. */
static bool spread_evenly(const struct work *work)
{
    struct ensemble *ensemble = work->ensemble;
    gsl_qrng *sequence = gsl_qrng_alloc(gsl_qrng_sobol, (unsigned)ensemble->parameters);
    if (!sequence)
        return false;
    for (size_t i = 0; i < ensemble->draws; i++) {
        double *w = ensemble->w + i * ensemble->parameters;
        gsl_qrng_get(sequence, w);
        for (size_t k = 0; k < ensemble->parameters; k++) {
            double shift = (double)(draw_number(work, ((size_t)1 << 32) + k) >> 11) * 0x1p-53;
            double even = fmod(w[k] + shift, 1.0);
            w[k] = work->place->normal ? gsl_cdf_ugaussian_Pinv(fmin(fmax(even, 1e-4), 1.0 - 1e-4))
                                       : ENSEMBLE_REACH * (2.0 * even - 1.0);
        }
    }
    gsl_qrng_free(sequence);
    return true;
}

/* Leaves out what failed or is no number. */
static void close_ranks(struct ensemble *ensemble, const bool *good)
{
    size_t kept = 0, q = ensemble->parameters, p = ensemble->statistics;
    for (size_t i = 0; i < ensemble->draws; i++) {
        bool keep = good[i];
        for (size_t s = 0; s < p; s++)
            keep = keep && isfinite(ensemble->statistic[i * p + s]);
        if (!keep)
            continue;
        memmove(ensemble->w + kept * q, ensemble->w + i * q, q * sizeof(double));
        ensemble->draw[kept] = ensemble->draw[i];
        memmove(ensemble->statistic + kept * p, ensemble->statistic + i * p, p * sizeof(double));
        kept++;
    }
    ensemble->failed = ensemble->draws - kept;
    ensemble->draws = kept;
}

enum mr_status ensemble_make(const struct fit_model *model, const struct ensemble_place *place,
                             const struct fit_options *options, unsigned round, double until_s,
                             struct ensemble *ensemble, struct error *error)
{
    *ensemble = (struct ensemble){
        .draws = options->draws, .parameters = model->parameters, .statistics = model->statistics};
    ensemble->w = calloc(ensemble->draws * ensemble->parameters, sizeof(double));
    ensemble->statistic = calloc(ensemble->draws * ensemble->statistics, sizeof(double));
    ensemble->draw = calloc(ensemble->draws, sizeof *ensemble->draw);
    bool *good = calloc(ensemble->draws, sizeof *good);
    struct work work = {.model = model,
                        .place = place,
                        .options = options,
                        .ensemble = ensemble,
                        .round = round,
                        .until_s = until_s,
                        .good = good};
    if (!good || !ensemble->w || !ensemble->statistic || !ensemble->draw || !spread_evenly(&work)) {
        free(good);
        return error_set(error, MR_FULL, "no memory: %zu draws of %zu statistics; use fewer draws",
                         options->draws, model->statistics);
    }
    simulate_all(&work);
    if (atomic_load(&work.stop)) {
        error_set(error, MR_TIMEOUT,
                  "stopped after %zu of %zu simulated data sets: round %u; allow more time, or "
                  "fewer draws",
                  atomic_load(&work.done), options->draws, round + 1);
    } else {
        close_ranks(ensemble, good);
        if ((double)ensemble->failed > FAILED_SHARE * (double)options->draws)
            error_set(error, MR_NUMERICS,
                      "%zu of %zu simulations failed: round %u; narrow the priors, or check the "
                      "scene with matrig sim",
                      ensemble->failed, options->draws, round + 1);
    }
    free(good);
    return error->status;
}

void ensemble_free(struct ensemble *ensemble)
{
    free(ensemble->w);
    free(ensemble->statistic);
    free(ensemble->draw);
    *ensemble = (struct ensemble){0};
}
