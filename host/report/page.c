#include "host/report/page.h"

#include <sha2.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/assets.h"
#include "host/base/html.h"
#include "host/base/xmalloc.h"

#define COPIED_BYTES 65536u

/* ---- any page ---- */

static const char *const scripts[] = {"/dygraph.js", "/charts.js"};

static void put_asset(FILE *out, const char *path)
{
    const struct asset *asset = asset_find(path);
    fwrite(asset->bytes, 1, (size_t)(asset->end - asset->bytes), out);
}

/* Nothing is loaded, and no script runs but the page's own. */
static void put_policy(FILE *out)
{
    SHA2_CTX hash;
    uint8_t sum[SHA256_DIGEST_LENGTH];
    SHA256Init(&hash);
    for (size_t i = 0; i < sizeof scripts / sizeof *scripts; i++) {
        const struct asset *asset = asset_find(scripts[i]);
        SHA256Update(&hash, (const uint8_t *)asset->bytes, (size_t)(asset->end - asset->bytes));
    }
    SHA256Final(sum, &hash);
    fputs(
        "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src "
        "'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; script-src 'sha256-",
        out);
    html_base64(out, sum, sizeof sum);
    fputs("'\">", out);
}

void page_head(FILE *out, const char *title)
{
    fputs("<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
          "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
          "<meta name=\"color-scheme\" content=\"light dark\">",
          out);
    put_policy(out);
    fputs("<title>", out);
    html_text(out, title);
    fputs("</title>\n<style>", out);
    put_asset(out, "/dygraph.css");
    put_asset(out, "/report.css");
    fputs("</style></head>\n<body>", out);
}

void page_foot(FILE *out, bool plots)
{
    if (plots) {
        fputs("<script>", out);
        for (size_t i = 0; i < sizeof scripts / sizeof *scripts; i++)
            put_asset(out, scripts[i]);
        fputs("</script>\n", out);
    }
    fputs("</body></html>\n", out);
}

void report_answer(struct answer *answer, FILE *out)
{
    answer_html(answer, out);
    answer_free(answer);
}

/* ---- of a report ---- */

/* What was written into memory; NULL: nothing. The caller frees it. */
static char *collected(FILE *into, char **text, const size_t *size)
{
    fclose(into);
    if (*size)
        return *text;
    free(*text);
    return NULL;
}

static enum mr_status write_landing(const struct report *report,
                                    const struct report_landing *landing, FILE *out,
                                    struct error *error)
{
    enum mr_status status = MR_OK;
    char heading[SUMMARY_HEADING];
    summary_heading(&landing->summary, heading);
    fprintf(out, "<section id=\"run%lld\" class=\"landing\"><h2>%s</h2>\n",
            (long long)landing->summary.measured.landing.id, heading);
    for (const struct report_part *part = report_parts; part->write && status == MR_OK; part++) {
        char *text = NULL;
        size_t size = 0;
        FILE *into = xopen_memstream(&text, &size);
        status = part->write(report, landing, into, error);
        text = collected(into, &text, &size);
        if (text && part->title)
            fprintf(out, "<h3>%s</h3>\n", part->title);
        fputs(text ? text : "", out);
        free(text);
    }
    fputs("</section>\n", out);
    return status;
}

/* Every landing in turn, each freed before the next is read. */
static enum mr_status write_landings(struct report *report, FILE *out, struct error *error)
{
    struct report_landing *landing = xmalloc(sizeof *landing);
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < report->landings && status == MR_OK; i++) {
        status = report_landing_load(report, i, landing, error);
        if (status == MR_OK)
            status = write_landing(report, landing, out, error);
        report_landing_free(landing);
    }
    free(landing);
    return status;
}

/* Sections of the campaign, and their names for the contents. */
static enum mr_status write_sections(const struct report *report, FILE *contents, FILE *body,
                                     struct error *error)
{
    enum mr_status status = MR_OK;
    for (const struct report_section *s = report_sections; s->write && status == MR_OK; s++) {
        char *text = NULL;
        size_t size = 0;
        if (report->landings < s->least)
            continue;
        FILE *into = xopen_memstream(&text, &size);
        status = s->write(report, into, error);
        text = collected(into, &text, &size);
        if (text) {
            fprintf(contents, "<li><a href=\"#%s\">%s</a></li>\n", s->id, s->title);
            fprintf(body, "<section id=\"%s\"><h2>%s</h2>\n%s</section>\n", s->id, s->title, text);
        }
        free(text);
    }
    for (size_t i = 0; i < report->landings; i++)
        fprintf(contents, "<li><a href=\"#run%lld\">RUN %lld: landing %lld</a></li>\n",
                (long long)report->row[i].id, (long long)report->row[i].id,
                (long long)report->row[i].board_landing);
    return status;
}

static const char *name_of(const struct report *report)
{
    return strrchr(report->path, '/') ? strrchr(report->path, '/') + 1 : report->path;
}

/* The front: all of <main> before the landings. The caller frees it. */
static enum mr_status make_front(const struct report *report, char **text, size_t *length,
                                 struct error *error)
{
    char *contents = NULL, *body = NULL;
    size_t contents_size = 0, body_size = 0;
    FILE *out = xopen_memstream(text, length), *list = xopen_memstream(&contents, &contents_size),
         *sections = xopen_memstream(&body, &body_size);
    fputs("<main>", out);
    cover_write(report, out);
    enum mr_status status = write_sections(report, list, sections, error);
    fclose(list);
    fclose(sections);
    fprintf(out,
            "<noscript><style>.plots{min-height:0!important}</style><p class=\"say\">The plots "
            "need a script; the tables stand without it."
            "</p></noscript>\n<nav aria-label=\"contents\"><ul>\n%s<li><a "
            "href=\"#provenance\">Provenance</a></li>\n</ul></nav>\n%s",
            contents, body);
    fclose(out);
    free(contents);
    free(body);
    return status;
}

static void put_hashed(FILE *out, SHA2_CTX *hash, const char *bytes, size_t count)
{
    SHA256Update(hash, (const uint8_t *)bytes, count);
    fwrite(bytes, 1, count, out);
}

/* <main> to </main>, with its hash. */
static void put_main(FILE *out, const char *front, size_t length, FILE *landings,
                     char drawn[SHA256_DIGEST_STRING_LENGTH])
{
    static const char end[] =
        "<p>Lines are thinned to what can be seen: of each column of a plot the least and the "
        "greatest value stay, where they were measured.</p>\n</main>";
    char *bytes = xmalloc(COPIED_BYTES);
    SHA2_CTX hash;
    SHA256Init(&hash);
    put_hashed(out, &hash, front, length);
    rewind(landings);
    for (size_t count; (count = fread(bytes, 1, COPIED_BYTES, landings)) > 0;)
        put_hashed(out, &hash, bytes, count);
    put_hashed(out, &hash, end, sizeof end - 1);
    SHA256End(&hash, drawn);
    free(bytes);
}

enum mr_status page_write(struct report *report, FILE *out, struct error *error)
{
    char *front = NULL, *calibrations = NULL, drawn[SHA256_DIGEST_STRING_LENGTH];
    size_t length = 0, size = 0;
    FILE *landings = tmpfile(); /* what they say is in the front, which stands before them */
    if (!landings)
        return error_set(error, MR_IO, "cannot write a temporary file; TMPDIR names a folder");
    report->calibrations = xopen_memstream(&calibrations, &size);
    enum mr_status status = write_landings(report, landings, error);
    if (status == MR_OK && !report->run)
        status = record_end(report->store, &report->record, error);
    if (status == MR_OK)
        status = make_front(report, &front, &length, error);
    fclose(report->calibrations);
    report->calibrations = NULL;
    if (status == MR_OK) {
        page_head(out, name_of(report));
        put_main(out, front, length, landings, drawn);
        provenance_write(report, drawn, calibrations, out);
        page_foot(out, true);
    }
    fclose(landings);
    free(front);
    free(calibrations);
    return status;
}
