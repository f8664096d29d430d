/* What each transducer and gage read, as tables. */
#include <math.h>

#include "host/analyse/summary_missing.h"
#include "host/report/report.h"

/* What was measured, and what the newest comparison simulated. */
static void movements_answer(const struct report_landing *landing, struct answer *answer)
{
    const struct measured *measured = &landing->summary.measured;
    summary_missing_answer(measured, MR_KIND_DISPLACEMENT, answer);
    answer_table(answer, NULL, "");
    for (unsigned number = 1; number <= MR_TRANSDUCERS; number++) {
        int c = measured_find(measured, MR_KIND_DISPLACEMENT, number);
        const struct store_simulation none = {.peak_simulated_in = (double)NAN,
                                              .end_simulated_in = (double)NAN,
                                              .rms_in = (double)NAN};
        const struct store_simulation *row = &none;
        for (size_t i = 0; i < landing->simulations; i++)
            row = landing->simulation[i].number == number ? &landing->simulation[i] : row;
        if (c < 0)
            continue;
        answer_row(answer);
        summary_channel_answer(measured, &measured->channel[c], answer);
        answer_estimate(answer, NULL, "peak simulated", UNIT_DISPLACEMENT, row->peak_simulated_in,
                        row->peak_simulated_error_in, 4);
        answer_value(answer, NULL, "rms difference", UNIT_DISPLACEMENT, row->rms_in, 4);
        answer_value(answer, NULL, "end simulated", UNIT_DISPLACEMENT, row->end_simulated_in, 4);
    }
    answer_close(answer);
}

enum mr_status landing_channels(const struct report *report, const struct report_landing *landing,
                                FILE *out, struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    struct answer *answer = answer_new(report->si);
    (void)error;
    if (measured->samples > 0) {
        movements_answer(landing, answer);
        answer_sentence(answer, NULL,
                        "Peaks are extremes of an %d ms moving mean; \xc2\xb1 is one standard "
                        "error, calibration and noise together, or the "
                        "simulation's own estimate%s.",
                        MEASURED_WINDOW,
                        landing->simulations ? "" : ". No comparison has been run: matrig compare");
        summary_channels_answer(measured, MR_KIND_TENSION, "", answer);
    }
    report_answer(answer, out);
    return MR_OK;
}
