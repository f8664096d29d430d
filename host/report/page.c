#include "host/report/page.h"

#include <stdlib.h>
#include <string.h>

#include "host/base/html.h"

/* In the order of the page. */
static const struct section {
    const char *id, *title;
    report_section *write;
    size_t least; /* landings that it takes */
} sections[] = {
    {"summary", "Summary", campaign_summary, 1},
    {"cumulative", "Cumulative displacement", campaign_cumulative, 2},
    {"zones", "Zone map over the landings", campaign_zones, 2},
    {"tension", "Band tension against deceleration", campaign_tension, 2},
    {"advice", "Advice before the landings", campaign_advice, 0},
    {"record", "Warnings and what came of them", campaign_record, 0},
    {"predictor", "Verdicts of the predictor", campaign_predictor, 2},
    {"compared", "Measured against simulated", campaign_compared, 2},
    {"slow", "Between the landings", campaign_slow, 0},
    {"journal", "What was seen and said", campaign_journal, 0},
    {"survey", "Surveys of the mat", campaign_survey, 0},
};

/* Of each landing. */
static const struct part {
    const char *title; /* NULL: none of its own */
    report_part *write;
} parts[] = {
    {NULL, landing_facts},
    {"Speed and deceleration", landing_speed},
    {"Movement of the mat", landing_movement},
    {"Displacement against distance from the front wheel", landing_wheel},
    {"Zone map", landing_zones},
    {"What the predictor said", landing_predictor},
    {"Band tensions", landing_tensions},
    {"Tension change along the bands", landing_along},
    {"Bands", landing_bands},
    {"Film", landing_film},
    {"Transducers and gages", landing_channels},
    {"Measured against simulated", landing_compare},
    {"Health and losses", landing_health},
};

void report_answer(struct answer *answer, FILE *out)
{
    if (!answer_html(answer, out))
        abort();
    answer_free(answer);
}

/* What a section wrote; NULL: nothing. The caller frees it. */
static char *collected(FILE *into, char **text, const size_t *size)
{
    fclose(into);
    if (*size)
        return *text;
    free(*text);
    return NULL;
}

static enum mr_status write_part(const struct report *report, const struct report_landing *landing,
                                 const struct part *part, FILE *out, struct error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *into = open_memstream(&text, &size);
    if (!into)
        abort();
    enum mr_status status = part->write(report, landing, into, error);
    text = collected(into, &text, &size);
    if (text && part->title)
        fprintf(out, "<h3>%s</h3>\n", part->title);
    if (text)
        fputs(text, out);
    free(text);
    return status;
}

static enum mr_status write_landing(const struct report *report,
                                    const struct report_landing *landing, FILE *out,
                                    struct error *error)
{
    const struct store_landing *row = &landing->summary.measured.landing;
    enum mr_status status = MR_OK;
    char heading[SUMMARY_HEADING];
    summary_heading(&landing->summary, heading);
    fprintf(out, "<section id=\"run%lld\" class=\"landing\"><h2>%s</h2>\n", (long long)row->id,
            heading);
    for (size_t i = 0; i < sizeof parts / sizeof parts[0] && status == MR_OK; i++)
        status = write_part(report, landing, &parts[i], out, error);
    fputs("</section>\n", out);
    return status;
}

/* Sections into `body`, their names into `contents`. */
static enum mr_status write_sections(const struct report *report, FILE *contents, FILE *body,
                                     struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < sizeof sections / sizeof sections[0] && status == MR_OK; i++) {
        char *text = NULL;
        size_t size = 0;
        FILE *into = open_memstream(&text, &size);
        if (!into)
            abort();
        if (report->landings >= sections[i].least)
            status = sections[i].write(report, into, error);
        text = collected(into, &text, &size);
        if (!text)
            continue;
        fprintf(contents, "<li><a href=\"#%s\">%s</a></li>\n", sections[i].id, sections[i].title);
        fprintf(body, "<section id=\"%s\"><h2>%s</h2>\n%s</section>\n", sections[i].id,
                sections[i].title, text);
        free(text);
    }
    for (size_t i = 0; i < report->landings && status == MR_OK; i++) {
        const struct store_landing *row = &report->landing[i].summary.measured.landing;
        fprintf(contents, "<li><a href=\"#run%lld\">RUN %lld: landing %lld</a></li>\n",
                (long long)row->id, (long long)row->id, (long long)row->board_landing);
        status = write_landing(report, &report->landing[i], body, error);
    }
    return status;
}

/* Hatching for what must be seen without colour too; one for all pictures of the page (style.c
 * fills with it). */
static const char hatch[] =
    "<svg class=\"none\" aria-hidden=\"true\"><defs><pattern id=\"hatch\" width=\"5\" height=\"5\" "
    "patternUnits=\"userSpaceOnUse\" "
    "patternTransform=\"rotate(45)\"><path class=\"hatch\" d=\"M0 0V5\"/></pattern></defs></svg>\n";

/* How far the hash of the provenance reaches: <main> to </main>, both with it. */
static void write_main(const struct report *report, FILE *out, const char *contents,
                       const char *body)
{
    const char *name = strrchr(report->path, '/') ? strrchr(report->path, '/') + 1 : report->path;
    bool one = report->run != 0;
    fputs("<main><h1>", out);
    fputs(one ? "Landing report" : "Campaign report", out);
    fputs("</h1>\n<p>", out);
    html_text(out, name);
    fprintf(out, ": %zu landing%s on the model landing-mat runway", report->landings,
            report->landings == 1 ? "" : "s");
    if (report->voided)
        fprintf(out, "; %zu that %s void left out", report->voided,
                report->voided == 1 ? "is" : "are");
    fprintf(out,
            ".</p>\n<p>Lines are thinned to what can be seen: of a column of at most 5/1040 of a "
            "picture's width the least and the greatest value stay, drawn "
            "where they were measured.</p>\n<nav aria-label=\"contents\"><ul>\n%s<li><a "
            "href=\"#provenance\">Provenance</a></li>\n</ul></nav>\n",
            contents);
    fputs(body, out);
    fputs("</main>", out);
}

enum mr_status page_write(const struct report *report, char **text, size_t *length,
                          struct error *error)
{
    char *contents = NULL, *body = NULL;
    size_t contents_size = 0, body_size = 0;
    FILE *list = open_memstream(&contents, &contents_size),
         *into = open_memstream(&body, &body_size), *out = open_memstream(text, length);
    if (!list || !into || !out)
        abort();
    enum mr_status status = write_sections(report, list, into, error);
    fclose(list);
    fclose(into);
    page_head(out, strrchr(report->path, '/') ? strrchr(report->path, '/') + 1 : report->path);
    fputs(hatch, out);
    write_main(report, out, contents, body);
    fflush(out);
    if (status == MR_OK)
        status = provenance_write(report, *text, *length, out, error);
    fputs("</body></html>\n", out);
    fclose(out);
    free(contents);
    free(body);
    return status;
}
