#include "tests/board/truth_run.h"

#include <math.h>

#define SEGMENTS                42
#define SURVEY_READING_ERROR_IN 0.005

void truth_run_switches(struct syn_run *run, const struct score_landing *landing)
{
    for (unsigned i = 0; i < SCORE_SWITCHES; i++) {
        double at_ft = -2.5 + 5.0 * i, t_s = (double)NAN;
        for (unsigned k = 0; k < landing->edges; k++) {
            if (fabs((double)landing->edge_ft[k] - at_ft) < 0.1)
                t_s = TRUTH_BEGIN_S + (double)landing->edge_s[k];
        }
        syn_run_add(run, "switch %u %.1f %.6f ", i + 1, at_ft, at_ft);
        if (isnan(t_s))
            syn_run_add(run, "-\n");
        else
            syn_run_add(run, "%.9f\n", t_s);
    }
}

void truth_run_survey(struct syn_run *run, const struct score_landing *landing, uint64_t *state)
{
    for (unsigned s = 0; s < SEGMENTS; s++) {
        double sum_in = SURVEY_READING_ERROR_IN * score_normal(state);
        for (unsigned j = 0; j < 10; j++)
            sum_in += (double)landing->gap_in[10 * s + j];
        syn_run_add(run, "command %.3f serial survey %u %.3f\n", 0.300 + 0.002 * s, s,
                    fmax(0.0, sum_in));
    }
}

void truth_run_samples(struct syn_run *run, const struct score_landing *landing, unsigned first)
{
    unsigned still = (unsigned)(TRUTH_BEGIN_S * TRUTH_RATE_HZ + 0.5);
    syn_run_add(run, "samples %u %d\n", still + landing->rows, TRUTH_RATE_HZ);
    for (unsigned k = 0; k < still + landing->rows; k++) {
        long row[SYN_SAMPLE_CHANNELS];
        for (unsigned i = 0; i < SYN_SAMPLE_CHANNELS; i++)
            row[i] = 10000; /* bands that nothing pulls at: 100 lb */
        for (unsigned i = 0; i < TRUTH_TRANSDUCERS; i++)
            row[i] = k < still ? 0 : lround((double)landing->u_in[k - still][first - 1 + i] * 1e5);
        syn_run_sample(run, row);
    }
}
