/* A landing's newest comparison that the campaign keeps: table, zones and picture. */
#include <math.h>

#include "host/compare/agree.h"
#include "host/compare/picture.h"
#include "host/compare/show.h"
#include "host/base/html.h"
#include "host/report/report.h"
#include "host/base/units.h"

#define DRAWN_MOST 4u /* transducers of a picture: half a page of paper */

/* As `matrig compare` has them. */
static bool tables(const struct compare_figures *figures, bool si, FILE *out)
{
    struct answer *answer = answer_new(si);
    compare_channels_answer(figures, answer);
    compare_zones_answer(&figures->zones, answer);
    bool made = answer_html(answer, out);
    answer_free(answer);
    return made;
}

static void words(FILE *out, const struct compare_figures *figures, bool si)
{
    const struct unit *length = unit_of(UNIT_DISPLACEMENT, si);
    fputs("<p class=\"say\">", out);
    if (figures->against[0]) {
        fputs("Against ", out);
        html_text(out, figures->against);
        fputs(": ", out);
    }
    if (figures->seeds > 1)
        fprintf(out, "%lld runways, ", (long long)figures->seeds);
    if (!isnan(figures->run_ms))
        fprintf(out, "simulated in %.0f ms, ", figures->run_ms);
    if (!isnan(figures->error_in))
        fprintf(out, "the simulation's own error estimate %.*f %s, ", si ? 2 : 4,
                figures->error_in * length->factor, length->text);
    if (figures->edges > 0)
        fprintf(out, "aligned on %lld switch edges, ", (long long)figures->edges);
    fprintf(out, "%zu of %u segments surveyed.</p>\n", figures->surveyed, MR_SEGMENTS);
}

/* From what is measured now: a calibration may have changed since. */
bool landing_compared(const struct report_landing *landing, struct compare_figures *figures,
                      struct error *error)
{
    const struct measured *measured = &landing->summary.measured;
    const struct compare_said said = {.zone = landing->summary.zones.row,
                                      .zones = landing->summary.zones.count};
    return landing->simulations > 0 && measured->fit_status == MR_OK && measured->samples > 0 &&
           compare_figures(measured, &landing->survey, &said, &landing->head, landing->simulation,
                           landing->simulations, figures, error) == MR_OK;
}

enum mr_status landing_compare(const struct report *report, const struct report_landing *landing,
                               FILE *out, struct error *error)
{
    const bool si = report->si;
    const struct measured *measured = &landing->summary.measured;
    struct compare_figures figures;
    struct compare_agreement agreement;
    char sentence[COMPARE_SENTENCE];
    if (!landing_compared(landing, &figures, error))
        return error->status;
    words(out, &figures, si);
    compare_agreement(&figures, &agreement);
    compare_sentence(&agreement, si, sentence);
    fputs("<p class=\"say\"><strong>", out);
    html_text(out, sentence);
    fputs(".</strong></p>\n", out);
    if (!tables(&figures, si, out))
        return error_set(error, MR_FULL,
                         "no memory: the comparison of RUN %lld; close other programs",
                         (long long)landing->summary.measured.landing.id);
    for (size_t i = 0; i < landing->simulations && error->status == MR_OK; i += DRAWN_MOST) {
        size_t left = landing->simulations - i, count = left < DRAWN_MOST ? left : DRAWN_MOST;
        fputs("<figure>", out);
        compare_draw(out, measured, &landing->head, landing->simulation + i, count, false, si,
                     error);
        if (count == left)
            fputs("<figcaption>Movement against time, each with its 95 % band.</figcaption>", out);
        fputs("</figure>\n", out);
    }
    return error->status;
}
