/* Was the instrument well, and is anything missing? */
#include <stdlib.h>

#include "host/report/report.h"

enum mr_status landing_health(const struct report *report, const struct report_landing *landing,
                              FILE *out, struct error *error)
{
    struct store_backlog *backlog = NULL;
    size_t backlogs = 0;
    int64_t most = 0;
    struct answer *answer = answer_new(report->si);
    summary_health_answer(&landing->summary, answer);
    enum mr_status status = store_backlogs(report->store, landing->summary.measured.landing.id,
                                           &backlog, &backlogs, error);
    for (size_t i = 0; i < backlogs; i++)
        most = backlog[i].waiting > most ? backlog[i].waiting : most;
    if (backlogs)
        answer_sentence(answer, NULL,
                        "The predictor held up others in %zu blocks, at most %lld blocks' work.",
                        backlogs, (long long)most);
    report_answer(answer, out);
    free(backlog);
    return status;
}
