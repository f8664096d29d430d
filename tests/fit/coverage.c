/* Coverage of the fit's intervals: CASES synthetic landings whose parameters scatter as the priors
 * say, each fitted; how often the stated 95 % intervals hold, the mean error, and how much the
 * data narrowed the priors; and how often the right model is said to be impossible. Every other
 * landing is surveyed, and its gap then known from the survey. Gaps, resistances and noise of each
 * case come from a seed of its own; the parameters are spread evenly (a Kronecker sequence through
 * the normal distribution), as a thousand drawn ones alone would add half a percent to or take it
 * from what holds.
 *
 *   coverage [CASES [DRAWS [FIRST]]] */
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "host/base/statistics.h"
#include "host/study/fit/landings.h"
#include "tests/fit/cheap.h"

/* x^6 = x + 1: powers of its inverse are far from fractions with small denominators */
#define KRONECKER 1.1347241384015194

struct tally {
    unsigned held, below, above;
    double error, square, spread;
};

/* Errors are in units of the prior's standard deviation. */
static void print_tally(const char *name, const struct tally *tally, unsigned cases)
{
    double held = 100.0 * tally->held / cases;
    printf("  %-5s 95 %% intervals hold in %5.1f %% (missed above %u, below %u)  wanted 93.5 to "
           "96.5 %s;  mean error %+.3f, rms %.3f, stated "
           "%.3f\n",
           name, held, tally->below, tally->above, held >= 93.5 && held <= 96.5 ? "met" : "missed",
           tally->error / cases, sqrt(tally->square / cases), sqrt(tally->spread / cases));
}

int main(int argc, char **argv)
{
    size_t cases = argc > 1 ? strtoul(argv[1], NULL, 10) : 1000,
           draws = argc > 2 ? strtoul(argv[2], NULL, 10) : 300;
    uint64_t first = argc > 3 ? strtoul(argv[3], NULL, 10) : 1;
    struct tally tally[FIT_KEYS] = {{0}};
    unsigned fitted = 0, checked = 0, cannot = 0;
    double simulated = 0.0;
    for (size_t n = 0; n < cases; n++) {
        double z[FIT_KEYS];
        struct fit_landings list;
        struct error error = {0};
        struct fit_result answer = {0};
        for (int k = 0; k < FIT_KEYS; k++)
            z[k] = gsl_cdf_ugaussian_Pinv(
                fmod(0.5 + (double)(first + n) * pow(KRONECKER, -(k + 1)), 1.0));
        bool good = cheap_landing(z, first + n, (first + n) % 2 == 1, &list, &error);
        struct fit_model model = fit_landings_model(&list);
        struct fit_options options = {.draw_count = draws, .seed = first + n};
        if (good && fit_run(&model, list.measured, &options, &answer, &error) == MR_OK) {
            struct misfit misfit = misfit_check(&list, &answer, first + n);
            fitted++;
            checked += misfit.is_checked;
            cannot += misfit.is_rejected;
            simulated += (double)answer.simulated_draw_count;
            for (int k = 0; k < FIT_KEYS; k++) {
                double miss = answer.z[k] - z[k];
                tally[k].held += answer.low[k] <= z[k] && z[k] <= answer.high[k];
                tally[k].below += z[k] > answer.high[k];
                tally[k].above += z[k] < answer.low[k];
                tally[k].error += miss;
                tally[k].square += miss * miss;
                tally[k].spread += answer.covariance[k][k];
                if (getenv("FIT_ROWS"))
                    printf("%zu %s true %.3f est %.3f [%.3f, %.3f] bias %.3f sd %.3f rounds %u "
                           "share %.3f\n",
                           n, fit_parameter_names[k].key, z[k], answer.z[k], answer.low[k],
                           answer.high[k], answer.bias[k], sqrt(answer.covariance[k][k]),
                           answer.round_count, misfit.p_value);
            }
        } else {
            printf("case %zu: %s\n", n, error.text);
        }
        fit_free(&answer);
        fit_landings_free(&list);
    }
    struct proportion_interval proportion_interval = compute_proportion_interval(cannot, checked);
    printf(
        "the runway is 30 mats long and fitted by its own model: %u of %u checked are said to be "
        "impossible, %.1f to %.1f %% (5 wanted)\n",
        cannot, checked, 100.0 * proportion_interval.low, 100.0 * proportion_interval.high);
    printf("%u of %zu cases fitted, %.0f simulations each; errors in the "
           "prior's standard deviations:\n",
           fitted, cases, simulated / fitted);
    for (int k = 0; k < FIT_KEYS; k++)
        print_tally(fit_parameter_names[k].key, &tally[k], fitted);
    return 0;
}
