#include "host/report/folder.h"

#include <errno.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/base/output.h"
#include "host/base/written.h"
#include "host/report/film_pictures.h"
#include "host/report/kept.h"
#include "host/report/page.h"
#include "host/store/store_digest.h"

#define PATH_MOST  4200
#define SAVE_EVERY 50u /* pages: so many are made again after an interruption */

struct work {
    struct report *report;
    const char *folder;
    bool force;
    struct kept before, now;
    bool *due; /* for each landing of the report: its page is to be made */
};

bool folder_meant(const char *path)
{
    struct stat info;
    size_t length = strlen(path);
    return (length > 0 && path[length - 1] == '/') ||
           (stat(path, &info) == 0 && S_ISDIR(info.st_mode));
}

static void path_of(const struct work *work, int64_t run, char path[PATH_MOST])
{
    char name[REPORT_LINK] = "index.html";
    if (run)
        report_link(work->report, run, name);
    snprintf(path, PATH_MOST, "%s/%s", work->folder, name);
}

/* ---- what a page rests on ---- */

static void add_text(SHA2_CTX *hash, const char *text)
{
    SHA256Update(hash, (const uint8_t *)text, strlen(text) + 1);
}

static enum mr_status add_film(const struct report *report, int64_t run, SHA2_CTX *hash,
                               struct error *error)
{
    struct film_pictures pictures = {0};
    enum mr_status status = film_pictures_list(report->film, run, false, &pictures, error);
    for (size_t i = 0; i < pictures.count; i++) {
        struct kept_file file = kept_file_at(pictures.picture[i].path);
        add_text(hash, pictures.picture[i].path);
        SHA256Update(hash, (const uint8_t *)&file, sizeof file);
    }
    film_pictures_free(&pictures);
    return status;
}

static enum mr_status digest_of(const struct work *work, size_t at, SHA2_CTX *hash,
                                char digest[REPORT_HASH], struct error *error)
{
    const struct report *report = work->report;
    const char *slash = strrchr(report->path, '/');
    const int64_t beside[] = {at > 0 ? report->row[at - 1].id : 0,
                              at + 1 < report->landings ? report->row[at + 1].id : 0, report->si};
    enum mr_status status = MR_OK;
    add_text(hash, work->now.program);
    add_text(hash, slash ? slash + 1 : report->path);
    SHA256Update(hash, (const uint8_t *)beside, sizeof beside);
    if (report->film)
        status = add_film(report, report->row[at].id, hash, error);
    SHA256End(hash, digest);
    return status;
}

/* ---- what is due ---- */

/* A page that is as it was left, of what has not changed. */
static bool is_fresh(const struct work *work, const struct kept_page *page, const char *digest)
{
    char path[PATH_MOST];
    path_of(work, page->run, path);
    return strcmp(page->digest, digest) == 0 && kept_same_file(page->file, kept_file_at(path));
}

/* What was kept takes the landing's place. */
static void restore(struct report *report, size_t at, const struct report_facts *kept)
{
    struct report_facts *facts = &report->facts[at];
    struct record_row *row = record_find(&report->record, report->row[at].id);
    *facts = *kept;
    facts->why[sizeof facts->why - 1] = '\0';
    facts->record.why = facts->why;
    facts->record.outcome.why = facts->why;
    if (row)
        *row = facts->record;
}

static enum mr_status look(struct work *work, size_t at, struct store_digest *digest,
                           size_t digests, struct error *error)
{
    struct report *report = work->report;
    struct kept_page *page = &work->now.page[at];
    const struct kept_page *before = kept_find(&work->before, report->row[at].id);
    struct store_digest *own = store_digest_find(digest, digests, report->row[at].id);
    char path[PATH_MOST];
    page->run = report->row[at].id;
    if (!own)
        return error_set(error, MR_MALFORMED, "no RUN %lld: %s; make the report again",
                         (long long)page->run, report->path);
    if (digest_of(work, at, &own->hash, page->digest, error) != MR_OK)
        return error->status;
    work->due[at] = !before || !is_fresh(work, before, page->digest);
    path_of(work, page->run, path);
    if (work->due[at])
        return output_check(path, work->force, report->path, error);
    restore(report, at, &work->before.facts[before - work->before.page]);
    page->file = before->file;
    return MR_OK;
}

static enum mr_status look_at_all(struct work *work, struct error *error)
{
    struct report *report = work->report;
    struct store_digest *digest = NULL;
    size_t digests = 0;
    char path[PATH_MOST];
    enum mr_status status = store_digests(report->store, &digest, &digests, error);
    for (size_t i = 0; i < report->landings && status == MR_OK; i++)
        status = look(work, i, digest, digests, error);
    free(digest);
    path_of(work, 0, path);
    if (status == MR_OK)
        status = output_check(path, work->force, report->path, error);
    snprintf(path, sizeof path, "%s/" KEPT_FILE, work->folder);
    return status == MR_OK ? output_check(path, work->force, report->path, error) : status;
}

/* ---- pages ---- */

static enum mr_status make_page(struct work *work, size_t at, struct error *error)
{
    struct kept_page *page = &work->now.page[at];
    char path[PATH_MOST], *text = NULL;
    size_t length = 0;
    enum mr_status status = page_of_landing(work->report, at, &text, &length, error);
    path_of(work, page->run, path);
    if (status == MR_OK)
        status = output_bytes(path, work->force, text, length, error);
    free(text);
    if (status != MR_OK)
        return status;
    page->file = kept_file_at(path);
    return MR_OK;
}

static enum mr_status make_pages(struct work *work, struct folder_made *made, struct error *error)
{
    enum mr_status status = MR_OK;
    for (size_t i = 0; i < work->report->landings && status == MR_OK; i++) {
        bool due = work->due[i];
        if (due)
            status = make_page(work, i, error);
        *(due ? &made->made : &made->left) += 1;
        if (due && status == MR_OK && made->made % SAVE_EVERY == 0)
            status = kept_save(&work->now, work->folder, work->force, error);
    }
    return status;
}

static void hash_drawn(const char *text, size_t length, char hash[REPORT_HASH])
{
    const char *from = memmem(text, length, "<main>", 6), *to = memmem(text, length, "</main>", 7);
    SHA256Data((const uint8_t *)(from ? from : text), from && to ? (size_t)(to - from) : length,
               hash);
}

/* Left where it says the same already. */
static enum mr_status make_front(struct work *work, bool changed, struct error *error)
{
    const struct kept_front *before = &work->before.front;
    struct kept_front *front = &work->now.front;
    char path[PATH_MOST], *text = NULL;
    size_t length = 0;
    path_of(work, 0, path);
    enum mr_status status = page_front(work->report, &text, &length, error);
    if (status == MR_OK)
        hash_drawn(text, length, front->drawn);
    bool left = status == MR_OK && !changed && strcmp(before->drawn, front->drawn) == 0 &&
                kept_same_file(before->file, kept_file_at(path));
    if (status == MR_OK && !left)
        status = output_bytes(path, work->force, text, length, error);
    front->file = kept_file_at(path);
    free(text);
    return status;
}

/* Pages that matrig made of landings which the report leaves out by now, as voided ones. */
static void remove_others(struct work *work, struct folder_made *made)
{
    for (size_t i = 0; i < work->before.pages; i++) {
        const struct kept_page *page = &work->before.page[i];
        char path[PATH_MOST], whole[PATH_MAX];
        if (kept_find(&work->now, page->run))
            continue;
        path_of(work, page->run, path);
        if (kept_same_file(page->file, kept_file_at(path)) && realpath(path, whole) &&
            written_state(whole) == WRITTEN_HERE && unlink(whole) == 0)
            made->removed++;
    }
}

/* ---- all of it ---- */

static enum mr_status make_folder(const char *path, struct error *error)
{
    if (mkdir(path, 0777) == 0 || (errno == EEXIST && folder_meant(path)))
        return MR_OK;
    return error_set(error, MR_IO, "cannot make the folder (%s): %s; check path and rights",
                     strerror(errno), path);
}

enum mr_status folder_write(struct report *report, const char *path, bool force,
                            struct folder_made *made, struct error *error)
{
    char folder[PATH_MAX];
    struct work work = {.report = report, .folder = folder, .force = force};
    *made = (struct folder_made){0};
    if (snprintf(folder, sizeof folder, "%s", path) >= (int)sizeof folder)
        return error_set(error, MR_TOO_LONG, "path too long: %.60s...; give another folder", path);
    for (size_t at = strlen(folder); at > 1 && folder[at - 1] == '/'; at--)
        folder[at - 1] = '\0';
    enum mr_status status = make_folder(folder, error);
    if (status != MR_OK)
        return status;
    kept_load(&work.before, folder);
    memcpy(work.now.program, work.before.program, sizeof work.now.program);
    work.now.pages = report->landings;
    work.now.page = calloc(report->landings + 1, sizeof *work.now.page);
    work.now.facts = report->facts;
    work.due = calloc(report->landings + 1, sizeof *work.due);
    if (!work.now.page || !work.due)
        status = error_set(error, MR_FULL, "no memory: %zu landings; close other programs",
                           report->landings);
    if (status == MR_OK)
        status = look_at_all(&work, error);
    free(work.before.facts);
    work.before.facts = NULL;
    if (status == MR_OK)
        status = make_pages(&work, made, error);
    if (status == MR_OK)
        status = make_front(&work, made->made > 0, error);
    if (status == MR_OK)
        remove_others(&work, made);
    if (status == MR_OK)
        status = kept_save(&work.now, folder, force, error);
    work.now.facts = NULL; /* the report's */
    kept_free(&work.before);
    kept_free(&work.now);
    free(work.due);
    return status;
}
