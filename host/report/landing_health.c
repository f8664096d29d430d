/* Was the instrument well, and is anything missing? */
#include <ctype.h>
#include <math.h>
#include <stdlib.h>

#include "common/fault.h"
#include "host/link/timemap.h"
#include "host/base/html.h"
#include "host/report/report.h"

static void losses(FILE *out, const struct summary *summary)
{
    html_table(out, (const char *const[]){"link", "frames received", "lost", "not sent by the board", NULL});
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        const struct summary_link *link = &summary->link[kind];
        fputs("<tr>", out);
        html_cell(out, "%s", summary_link_name(kind));
        if (link->used) {
            html_cell(out, "%lld", (long long)link->received);
            html_cell(out, "%lld%s", (long long)link->lost, link->silent ? ", silent in part" : "");
            html_cell(out, "%lld", (long long)link->dropped);
        } else {
            fputs("<td colspan=\"3\">not used</td>", out);
        }
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n", out);
    for (size_t i = 0; i < summary->gaps; i++) {
        char line[160];
        summary_gap(&summary->gap[i], line, sizeof line);
        fputs("<p class=\"say\">Gap: ", out);
        html_text(out, line);
        fputs(".</p>\n", out);
    }
    if (summary->gaps == 0)
        fputs("<p>No gaps.</p>\n", out);
    const struct measured_check *check = &summary->measured.check;
    if (check->compared)
        fprintf(out,
                "<p>%zu values that came over CAN were held against the serial block records: %zu differ by "
                "more than a"
                " digit of the wire.</p>\n",
                check->compared, check->different);
    if (summary->faults == 0)
        fputs("<p>No faults were reported.</p>\n", out);
    for (size_t i = 0; i < summary->faults; i++) {
        fputs("<p class=\"say\">Fault: ", out);
        html_text(out, mr_fault_text((unsigned)summary->fault[i].code));
        fprintf(out, " [%lld], %lld times.</p>\n", (long long)summary->fault[i].detail,
                (long long)summary->fault[i].count);
    }
}

/* What had been looked at before the landing. */
static void readiness(FILE *out, const struct summary *summary)
{
    char text[460];
    for (int kind = 0; kind < SUMMARY_READY_KINDS; kind++) {
        if (!summary->ready[kind].known)
            continue;
        summary_ready_text(&summary->ready[kind], text, sizeof text);
        fprintf(out, "<p%s>%s: ", summary->ready[kind].go ? "" : " class=\"say\"", kind == 0 ? "Ready" : "Walk test");
        html_text(out, text);
        fputs(".</p>\n", out);
    }
}

/* Each mean of what the board told again and again. */
static void means(FILE *out, const struct summary *summary)
{
    char text[SUMMARY_MEAN_TEXT];
    for (unsigned i = 0; i < MR_QUANTITIES; i++) {
        const struct mr_quantity_info *quantity = mr_quantity_at(i);
        const struct store_mean *mean = &summary->mean[i];
        if (!mean->told)
            continue;
        fprintf(out, "<p>%c%s: ", toupper(quantity->words[0]), quantity->words + 1);
        summary_mean_text(i, mean, false, text);
        if (mean->readings)
            fprintf(out, "%s (%lld readings in %lld s).</p>\n", text, (long long)mean->readings,
                    (long long)mean->told * mr_message_find(quantity->id)->every_ms / 1000);
        else
            fprintf(out, "none of %lld readings came; %s.</p>\n", (long long)mean->told, quantity->why);
    }
}

/* Clock, and what the links themselves saw. */
static void surroundings(FILE *out, const struct summary *summary)
{
    const struct store_time_map *clock = &summary->clock;
    char text[300];
    if (summary->clock_known && clock->refusal == TIMEMAP_GOOD)
        fprintf(out, "<p>Clock of the board: %.2f &plusmn; %.2f ppm %s against this computer's; times of day within %.2f ms (95 %%).</p>\n",
                fabs(clock->fast_ppm), clock->fast_half_ppm, clock->fast_ppm < 0.0 ? "slow" : "fast", clock->host_half_us / 1e3);
    else if (summary->clock_known)
        fprintf(out, "<p>Clock of the board: no times of day: %s.</p>\n", timemap_refusal_text((unsigned)clock->refusal));
    for (int kind = 0; kind < LINK_KINDS; kind++) {
        summary_troubles(summary->link[kind].trouble, text, sizeof text);
        if (!text[0])
            continue;
        fprintf(out, "<p class=\"say\">Troubles of %s: ", summary_link_name(kind));
        html_text(out, text);
        fputs(".</p>\n", out);
    }
}

enum mr_status landing_health(const struct report *report, const struct report_landing *landing, FILE *out, struct error *error)
{
    struct store_backlog *backlog = NULL;
    size_t backlogs = 0;
    int64_t most = 0;
    readiness(out, &landing->summary);
    means(out, &landing->summary);
    surroundings(out, &landing->summary);
    losses(out, &landing->summary);
    enum mr_status status = store_backlogs(report->store, landing->summary.measured.landing.id, &backlog, &backlogs, error);
    for (size_t i = 0; i < backlogs; i++)
        most = backlog[i].waiting > most ? backlog[i].waiting : most;
    if (backlogs)
        fprintf(out, "<p class=\"say\">The predictor held up others in %zu blocks, at most %lld blocks' work.</p>\n", backlogs, (long long)most);
    free(backlog);
    return status;
}
