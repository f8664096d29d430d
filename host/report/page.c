#include "host/report/page.h"

#include <stdlib.h>
#include <string.h>

#include "host/base/html.h"
#include "host/report/closer.h"

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
    answer_html(answer, out);
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

/* Its section, and its name for the contents. */
static enum mr_status write_section(const struct report *report, const struct section *section,
                                    FILE *contents, FILE *body, struct error *error)
{
    char *text = NULL;
    size_t size = 0;
    FILE *into = open_memstream(&text, &size);
    if (!into)
        abort();
    enum mr_status status = section->write(report, into, error);
    text = collected(into, &text, &size);
    if (text) {
        fprintf(contents, "<li><a href=\"#%s\">%s</a></li>\n", section->id, section->title);
        fprintf(body, "<section id=\"%s\"><h2>%s</h2>\n%s</section>\n", section->id, section->title,
                text);
    }
    free(text);
    return status;
}

static enum mr_status write_sections(const struct report *report, FILE *contents, FILE *body,
                                     struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < sizeof sections / sizeof sections[0] && status == MR_OK; i++) {
        if (report->landings >= sections[i].least)
            status = write_section(report, &sections[i], contents, body, error);
    }
    return status;
}

/* Every landing in turn, each freed before the next is read. */
static enum mr_status write_landings(struct report *report, FILE *body, struct error *error)
{
    struct report_landing *landing = malloc(sizeof *landing);
    enum mr_status status = MR_OK;
    if (!landing)
        abort();
    for (size_t i = 0; i < report->landings && status == MR_OK; i++) {
        status = report_landing_load(report, i, landing, error);
        if (status == MR_OK)
            status = write_landing(report, landing, body, error);
        report_landing_free(landing);
    }
    free(landing);
    return status;
}

static void landing_contents(const struct report *report, FILE *contents)
{
    for (size_t i = 0; i < report->landings; i++) {
        fprintf(contents, "<li><a href=\"#run%lld\">RUN %lld: landing %lld</a></li>\n",
                (long long)report->row[i].id, (long long)report->row[i].id,
                (long long)report->row[i].board_landing);
    }
}

/* Hatching for what must be seen without colour too; one for all pictures of the page (style.c
 * fills with it). */
static const char hatch[] =
    "<svg class=\"none\" aria-hidden=\"true\"><defs><pattern id=\"hatch\" width=\"5\" height=\"5\" "
    "patternUnits=\"userSpaceOnUse\" "
    "patternTransform=\"rotate(45)\"><path class=\"hatch\" d=\"M0 0V5\"/></pattern></defs></svg>\n";

static const char *name_of(const struct report *report)
{
    return strrchr(report->path, '/') ? strrchr(report->path, '/') + 1 : report->path;
}

/* What a page is put together from. */
struct page {
    char *text[3]; /* contents, sections, calibrations */
    size_t size[3];
    FILE *contents, *body, *calibrations;
};

static void begin(struct page *page)
{
    FILE **file[] = {&page->contents, &page->body, &page->calibrations};
    for (int i = 0; i < 3; i++) {
        page->text[i] = NULL;
        *file[i] = open_memstream(&page->text[i], &page->size[i]);
        if (!*file[i])
            abort();
    }
}

static void end_parts(struct page *page)
{
    fclose(page->contents);
    fclose(page->body);
    fclose(page->calibrations);
}

static void free_parts(struct page *page)
{
    for (int i = 0; i < 3; i++)
        free(page->text[i]);
}

/* Hash of the provenance reaches from <main> to </main>, both with it. */
static enum mr_status put_together(const struct report *report, const struct page *page,
                                   char **text, size_t *length, struct error *error)
{
    FILE *out = open_memstream(text, length);
    if (!out)
        abort();
    page_head(out, name_of(report));
    fputs(hatch, out);
    fputs("<main>", out);
    enum mr_status status = cover_write(report, out, error);
    fprintf(out,
            "<nav aria-label=\"contents\"><ul>\n%s<li><a "
            "href=\"#provenance\">Provenance</a></li>\n</ul></nav>\n%s<p>Lines are thinned to what "
            "can be seen: of a column of at most 5/1040 of a picture's width the least and the "
            "greatest value stay, drawn where they were measured.</p>\n</main>",
            page->text[0], page->text[1]);
    fflush(out);
    provenance_write(report, *text, *length, page->size[2] ? page->text[2] : NULL, out);
    closer_write(out);
    fputs("</body></html>\n", out);
    fclose(out);
    return status;
}

enum mr_status page_write(struct report *report, char **text, size_t *length, struct error *error)
{
    struct page page;
    FILE *landings;
    char *written = NULL;
    size_t size = 0;
    *text = NULL;
    begin(&page);
    if (!(landings = open_memstream(&written, &size)))
        abort();
    report->calibrations = page.calibrations;
    enum mr_status status = write_landings(report, landings, error);
    fclose(landings);
    if (status == MR_OK && !report->run)
        status = record_end(report->store, &report->record, error);
    if (status == MR_OK)
        status = write_sections(report, page.contents, page.body, error);
    landing_contents(report, page.contents);
    fputs(written, page.body);
    free(written);
    end_parts(&page);
    if (status == MR_OK)
        status = put_together(report, &page, text, length, error);
    free_parts(&page);
    report->calibrations = NULL;
    return status;
}
