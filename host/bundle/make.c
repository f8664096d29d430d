#include <errno.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include "host/bundle/bundle.h"
#include "host/bundle/digest.h"
#include "host/export/export_candump.h"
#include "host/flash/imagefile.h"
#include "host/link/link.h"
#include "host/base/output.h"
#include "host/report/page.h"
#include "host/store/store_guard.h"
#include "host/store/store_sql.h"

/* The digests are filled in when the tables are; their rows are made first, as long as they will
 * be, to lie before what they tell of. */
#define ZEROS       "0000000000000000000000000000000000000000000000000000000000000000"
#define PLAIN_FILE  "33188" /* 0100644 */
#define BYTES_LATER "1099511627776"

static const char tables_sql[] =
    "CREATE TABLE sqlar(name TEXT PRIMARY KEY, mode INT, mtime INT, sz INT, data BLOB);"
    "CREATE TABLE bundle_manifest(name TEXT PRIMARY KEY, kind TEXT NOT NULL, bytes INTEGER NOT "
    "NULL, what TEXT NOT NULL, sha256 TEXT NOT NULL);"
    "CREATE TABLE bundle_seal(text TEXT NOT NULL);"
    "INSERT INTO bundle_seal VALUES('" BUNDLE_SEAL ZEROS "');";
static const char promises_sql[] =
    "INSERT INTO bundle_manifest SELECT name, 'table', " BYTES_LATER ", '', '" ZEROS
    "' FROM sqlite_schema WHERE type='table'"
    " AND name NOT LIKE 'sql%' AND name NOT LIKE 'bundle%';"
    "INSERT INTO bundle_manifest VALUES('schema', 'schema', " BYTES_LATER
    ", 'tables, indices and triggers', '" ZEROS "');";

struct content {
    char *bytes;
    size_t size;
    char what[200];
    char why_not[120]; /* it is absent */
};

struct making {
    struct store *slice; /* the landing alone, RUN 1 */
    struct store_landing landing;
    const struct bundle_want *want;
    const char *path;
    char draft[1100];
    struct content content[BUNDLE_FILES];
    sqlite3 *database;
};

static enum mr_status failed(struct making *making, struct error *error)
{
    const char *text = making->database ? sqlite3_errmsg(making->database) : "no memory";
    return error_set(error, MR_IO, "cannot be written (%s): %s; is there room?", text,
                     making->draft);
}

/* ---- the files ---- */

static enum mr_status take_file(const char *path, struct content *content, struct error *error)
{
    FILE *file = fopen(path, "rb");
    content->bytes = malloc(BUNDLE_FILE_MAX + 1u);
    if (!content->bytes)
        abort();
    if (file)
        content->size = fread(content->bytes, 1, BUNDLE_FILE_MAX + 1u, file);
    bool bad = !file || ferror(file);
    int code = errno;
    if (file)
        fclose(file);
    if (bad)
        return error_set(error, MR_IO, "cannot be read (%s): %s; check path and rights",
                         strerror(code), path);
    if (content->size > BUNDLE_FILE_MAX)
        return error_set(error, MR_TOO_LONG,
                         "longer than the %u bytes of a file in a bundle: %s; give another one",
                         BUNDLE_FILE_MAX, path);
    return MR_OK;
}

/* "image 0340e33d, commit 4e4ed8e4e218" */
static void identity_text(char *text, size_t size, int64_t crc, const char *commit)
{
    snprintf(text, size, "image %08x%s%s", (unsigned)crc, commit[0] ? ", commit " : "", commit);
}

static enum mr_status take_firmware(struct making *making, struct content *content,
                                    struct error *error)
{
    const struct store_landing *landing = &making->landing;
    char recorded[80], given[80];
    struct imagefile image = {0};
    if (landing->image_crc == STORE_NONE) {
        snprintf(content->why_not, sizeof content->why_not,
                 "the board did not tell which image it ran");
        return MR_OK;
    }
    enum mr_status status = imagefile_read(making->want->elf, &image, error);
    bool same = status == MR_OK && image.stamped &&
                image.header.program_crc == (uint32_t)landing->image_crc;
    identity_text(recorded, sizeof recorded, landing->image_crc, landing->image_commit);
    if (status == MR_OK && !image.stamped)
        status = error_set(error, MR_USAGE,
                           "no image of matrig, without identity: %s; give the one that recorded "
                           "it (%s) with --elf, or "
                           "leave it out with --without firmware",
                           making->want->elf, recorded);
    if (status == MR_OK && !same) {
        char commit[MR_IMAGE_COMMIT_TEXT];
        mr_image_commit_text(image.header.commit, image.header.commit_more, image.header.changed,
                             commit);
        identity_text(given, sizeof given, image.header.program_crc, commit);
        status = error_set(error, MR_USAGE,
                           "not the image that recorded it (%s): %s is %s; give that one with "
                           "--elf, or leave it out with "
                           "--without firmware",
                           recorded, making->want->elf, given);
    }
    imagefile_free(&image);
    snprintf(content->what, sizeof content->what, "%s: firmware %s, %s",
             bundle_files[BUNDLE_FIRMWARE].what, landing->firmware, recorded);
    return status == MR_OK ? take_file(making->want->elf, content, error) : status;
}

/* A landing of which no page can be made is passed on all the same: that is when somebody else is
 * to look at it. */
static enum mr_status take_page(struct making *making, struct content *content, struct error *error)
{
    char name[60];
    struct error why = {0};
    struct report report = {.store = making->slice, .path = name};
    (void)error;
    snprintf(name, sizeof name, "landing %lld", (long long)making->landing.board_landing);
    if (report_begin(&report, true, &why) == MR_OK)
        page_write(&report, &content->bytes, &content->size, &why);
    report_free(&report);
    if (why.status != MR_OK) {
        free(content->bytes);
        *content = (struct content){.bytes = NULL};
        snprintf(content->why_not, sizeof content->why_not, "none can be made: %.*s",
                 (int)strcspn(why.text, ":"), why.text);
    }
    return MR_OK;
}

static enum mr_status take_candump(struct making *making, struct content *content,
                                   struct error *error)
{
    const struct cli quiet = {.quiet = true};
    int64_t frames;
    long rows = 0;
    enum mr_status status = store_frames_count(making->slice, 1, LINK_CAN, &frames, error);
    if (status == MR_OK && frames == 0)
        snprintf(content->why_not, sizeof content->why_not, "it was logged without a CAN link");
    if (status != MR_OK || frames == 0)
        return status;
    FILE *out = open_memstream(&content->bytes, &content->size);
    if (!out)
        abort();
    status = export_candump(making->slice, 1, out, &quiet, &rows, error);
    fclose(out);
    return status;
}

static enum mr_status take_configuration(struct making *making, struct content *content,
                                         struct error *error)
{
    int64_t crc = making->landing.config_crc;
    enum mr_status status = crc == STORE_NONE
                              ? MR_OK
                              : store_configuration_get(making->slice, (uint32_t)crc,
                                                        &content->bytes, error);
    if (status == MR_OK && content->bytes)
        content->size = strlen(content->bytes);
    else if (status == MR_OK)
        snprintf(content->why_not, sizeof content->why_not, "it was never read from the board");
    return status;
}

static enum mr_status take_scene(struct making *making, struct content *content,
                                 struct error *error)
{
    sqlite3_stmt *statement;
    if (sqlite3_prepare_v2(making->slice->database,
                           "SELECT scene FROM simulations ORDER BY id DESC LIMIT 1", -1, &statement,
                           NULL) != SQLITE_OK)
        return store_failed(making->slice, "read", error);
    if (sqlite3_step(statement) == SQLITE_ROW && sqlite3_column_text(statement, 0)) {
        content->bytes = strdup((const char *)sqlite3_column_text(statement, 0));
        content->size = strlen(content->bytes);
    }
    sqlite3_finalize(statement);
    if (content->bytes)
        return MR_OK;
    snprintf(content->what, sizeof content->what,
             "a mat scene to compare with; the landing was not compared");
    if (!making->want->scene)
        snprintf(content->why_not, sizeof content->why_not,
                 "the landing was not compared, and no scene came with matrig");
    return making->want->scene ? take_file(making->want->scene, content, error) : MR_OK;
}

static enum mr_status take_contents(struct making *making, struct error *error)
{
    static enum mr_status (*const takes[BUNDLE_FILES])(struct making *, struct content *,
                                                       struct error *) = {
        [BUNDLE_PAGE] = take_page,
        [BUNDLE_CANDUMP] = take_candump,
        [BUNDLE_CONFIGURATION] = take_configuration,
        [BUNDLE_SCENE] = take_scene,
        [BUNDLE_FIRMWARE] = take_firmware};
    enum mr_status status = MR_OK;
    for (int i = 0; i < BUNDLE_FILES && status == MR_OK; i++) {
        struct content *content = &making->content[i];
        snprintf(content->what, sizeof content->what, "%s", bundle_files[i].what);
        if (making->want->without[i])
            snprintf(content->why_not, sizeof content->why_not, "left out");
        else
            status = takes[i](making, content, error);
    }
    return status;
}

/* ---- the database ---- */

static enum mr_status execute(struct making *making, const char *sql, struct error *error)
{
    return sqlite3_exec(making->database, sql, NULL, NULL, NULL) == SQLITE_OK
             ? MR_OK
             : failed(making, error);
}

/* One row; `blob` NULL or the fifth column's bytes. */
static enum mr_status put_row(struct making *making, const char *sql, const char *name,
                              int64_t second, int64_t third, const char *text, const void *blob,
                              size_t size, const char *hex, struct error *error)
{
    sqlite3_stmt *row = NULL;
    bool done = sqlite3_prepare_v2(making->database, sql, -1, &row, NULL) == SQLITE_OK;
    if (done) {
        sqlite3_bind_text(row, 1, name, -1, SQLITE_STATIC);
        sqlite3_bind_int64(row, 2, second);
        sqlite3_bind_int64(row, 3, third);
        sqlite3_bind_text(row, 4, text, -1, SQLITE_STATIC);
        sqlite3_bind_blob64(row, 5, blob, size, SQLITE_STATIC);
        sqlite3_bind_text(row, 6, hex, -1, SQLITE_STATIC);
        done = sqlite3_step(row) == SQLITE_DONE;
    }
    enum mr_status status = done ? MR_OK : failed(making, error);
    sqlite3_finalize(row);
    return status;
}

static enum mr_status promise_file(struct making *making, enum bundle_file file,
                                   struct error *error)
{
    const struct content *content = &making->content[file];
    char hex[BUNDLE_DIGEST];
    digest_bytes(content->bytes, content->size, hex);
    return put_row(making, "INSERT INTO bundle_manifest VALUES(?1, 'file', ?2, ?4, ?6)",
                   bundle_files[file].name, (int64_t)content->size, 0, content->what, NULL, 0, hex,
                   error);
}

static enum mr_status put_file(struct making *making, enum bundle_file file, struct error *error)
{
    const struct content *content = &making->content[file];
    uLongf packed_size = compressBound(content->size);
    uint8_t *packed = malloc(packed_size);
    if (!packed || compress2(packed, &packed_size, (const Bytef *)content->bytes, content->size,
                             Z_BEST_COMPRESSION) != Z_OK)
        abort(); /* no memory: the room is what zlib asks for */
    /* the archive's rule: as long as sz means as it is */
    bool shorter = packed_size < content->size;
    enum mr_status status =
        put_row(making, "INSERT INTO sqlar VALUES(?1, " PLAIN_FILE ", ?3, ?2, ?5)",
                bundle_files[file].name, (int64_t)content->size, making->landing.armed_us / 1000000,
                NULL, shorter ? packed : (const void *)content->bytes,
                shorter ? packed_size : content->size, NULL, error);
    free(packed);
    return status;
}

static enum mr_status open_draft(struct making *making, struct error *error)
{
    bool opened = sqlite3_open_v2(making->draft, &making->database, SQLITE_OPEN_READWRITE, NULL) ==
                  SQLITE_OK;
    store_guard_settings(making->database);
    return opened ? MR_OK : failed(making, error);
}

static void close_draft(struct making *making)
{
    sqlite3_close(making->database);
    making->database = NULL;
}

static enum mr_status put_files(struct making *making, struct error *error)
{
    struct store *empty = NULL;
    enum mr_status status = store_open(making->draft, STORE_CREATE, &empty, error);
    store_close(empty);
    if (status == MR_OK)
        status = open_draft(making, error);
    if (status == MR_OK)
        status = execute(making, "BEGIN", error);
    if (status == MR_OK)
        status = execute(making, tables_sql, error);
    for (int i = 0; i < BUNDLE_FILES && status == MR_OK; i++) {
        if (making->content[i].bytes)
            status = promise_file(making, (enum bundle_file)i, error);
    }
    if (status == MR_OK)
        status = execute(making, promises_sql, error);
    for (int i = 0; i < BUNDLE_FILES && status == MR_OK; i++) {
        if (making->content[i].bytes)
            status = put_file(making, (enum bundle_file)i, error);
    }
    if (status == MR_OK)
        status = execute(making, "COMMIT", error);
    close_draft(making);
    return status;
}

/* Digests of the tables as they are now. */
static enum mr_status put_digests(struct making *making, struct error *error)
{
    sqlite3_stmt *names = NULL, *update = NULL;
    enum mr_status status = open_draft(making, error);
    if (status == MR_OK)
        status = execute(making, "PRAGMA journal_mode=DELETE; BEGIN", error);
    if (status == MR_OK &&
        (sqlite3_prepare_v2(making->database,
                            "SELECT name, kind FROM bundle_manifest WHERE kind<>'file'", -1, &names,
                            NULL) != SQLITE_OK ||
         sqlite3_prepare_v2(
             making->database,
             "UPDATE bundle_manifest SET bytes=?, what=what || ?, sha256=? WHERE name=?", -1,
             &update, NULL) != SQLITE_OK))
        status = failed(making, error);
    while (status == MR_OK && sqlite3_step(names) == SQLITE_ROW) {
        struct digest_sum sum;
        char rows[40] = "";
        bool table = strcmp((const char *)sqlite3_column_text(names, 1), "table") == 0;
        if (digest_table(making->database,
                         table ? (const char *)sqlite3_column_text(names, 0) : NULL,
                         BUNDLE_READ_MAX, &sum) != SQLITE_OK)
            status = failed(making, error);
        if (table)
            snprintf(rows, sizeof rows, "%lld rows", (long long)sum.rows);
        sqlite3_bind_int64(update, 1, sum.bytes);
        sqlite3_bind_text(update, 2, rows, -1, SQLITE_STATIC);
        sqlite3_bind_text(update, 3, sum.hex, -1, SQLITE_STATIC);
        sqlite3_bind_value(update, 4, sqlite3_column_value(names, 0));
        if (status == MR_OK && sqlite3_step(update) != SQLITE_DONE)
            status = failed(making, error);
        sqlite3_reset(update);
    }
    sqlite3_finalize(names);
    sqlite3_finalize(update);
    if (status == MR_OK)
        status = execute(making, "COMMIT", error);
    close_draft(making);
    return status;
}

/* ---- size and seal ---- */

/* The file in it that takes the most room, when any does; else the frames, which only another
 * landing has fewer of. */
static enum mr_status too_long(struct making *making, size_t size, struct error *error)
{
    sqlite3_stmt *statement = NULL;
    char name[BUNDLE_NAME] = "?", hint[80] = "the landing itself is too long";
    long long largest = 0;
    static const char sql[] =
        "SELECT name, length(data) FROM sqlar UNION ALL"
        " SELECT 'table frames', (SELECT sum(length(data)) FROM frames) UNION ALL"
        " SELECT 'table blocks', (SELECT sum(length(record)) FROM blocks) ORDER BY 2 DESC LIMIT 1";
    if (open_draft(making, error) == MR_OK &&
        sqlite3_prepare_v2(making->database, sql, -1, &statement, NULL) == SQLITE_OK &&
        sqlite3_step(statement) == SQLITE_ROW) {
        snprintf(name, sizeof name, "%s", (const char *)sqlite3_column_text(statement, 0));
        largest = sqlite3_column_int64(statement, 1);
    }
    sqlite3_finalize(statement);
    close_draft(making);
    for (int i = 0; i < BUNDLE_FILES; i++) {
        if (strcmp(name, bundle_files[i].name) == 0)
            snprintf(hint, sizeof hint, "leave it out with --without %s", bundle_files[i].option);
    }
    return error_set(
        error, MR_TOO_LONG,
        "%zu bytes, a bundle has at most %u: %s; its largest part is %s with %lld bytes: %s", size,
        BUNDLE_BYTES_MAX, making->path, name, largest, hint);
}

static enum mr_status seal(struct making *making, struct bundle_made *made, struct error *error)
{
    struct content whole = {0};
    struct stat info;
    size_t at;
    if (stat(making->draft, &info) == 0 && info.st_size > (off_t)BUNDLE_BYTES_MAX)
        return too_long(making, (size_t)info.st_size, error);
    enum mr_status status = take_file(making->draft, &whole, error);
    made->bytes = whole.size;
    if (status == MR_OK) {
        digest_sealed((const uint8_t *)whole.bytes, whole.size, made->digest, &at);
        FILE *file = at ? fopen(making->draft, "r+b") : NULL;
        bool done = file && fseek(file, (long)at, SEEK_SET) == 0 &&
                    fwrite(made->digest, BUNDLE_DIGEST - 1u, 1, file) == 1 && fflush(file) == 0 &&
                    fsync(fileno(file)) == 0;
        if ((file && fclose(file) != 0) || !done)
            status = failed(making, error);
    }
    free(whole.bytes);
    return status;
}

/* --force is for bundles: a campaign cannot be made again. */
static enum mr_status refuse_campaign(const char *path, bool force, struct error *error)
{
    struct error why = {0};
    struct bundle *bundle = NULL;
    static struct bundle_check check;
    if (!force || !output_is_database(path))
        return MR_OK;
    bool is_bundle = bundle_open(path, &bundle, &check, &why) == MR_OK;
    bundle_close(bundle);
    return is_bundle
             ? MR_OK
             : error_set(error, MR_USAGE,
                         "would overwrite a database: %s; give another file for the bundle", path);
}

/* ---- all of it ---- */

static enum mr_status make_slice(struct making *making, struct store *store, int64_t run,
                                 const char *path, struct error *error)
{
    struct store *empty = NULL;
    enum mr_status status = store_open(path, STORE_CREATE, &empty, error);
    store_close(empty);
    if (status == MR_OK)
        status = store_slice(store, run, path, error);
    if (status == MR_OK)
        /* what reads only cannot be copied from by SQLite */
        status = store_open(path, STORE_OPEN, &making->slice, error);
    return status == MR_OK ? store_landing_get(making->slice, 1, &making->landing, error) : status;
}

static void remove_database(const char *path)
{
    char beside[1200];
    static const char *const tails[] = {"", "-wal", "-shm", "-journal"};
    for (size_t i = 0; i < sizeof tails / sizeof tails[0]; i++) {
        snprintf(beside, sizeof beside, "%s%s", path, tails[i]);
        unlink(beside);
    }
}

enum mr_status bundle_make(struct store *store, int64_t run, const struct bundle_want *want,
                           const char *path, struct bundle_made *made, struct error *error)
{
    struct making making = {.want = want, .path = path};
    char slice[1100];
    struct store_landing landing;
    *made = (struct bundle_made){0};
    enum mr_status status = store_landing_get(store, run, &landing, error);
    if (status != MR_OK)
        return status;
    if (strlen(path) > 1000)
        return error_set(error, MR_USAGE, "path too long: %.40s...; give a shorter one", path);
    if (refuse_campaign(path, want->force, error) != MR_OK ||
        output_check_database(path, want->force, error) != MR_OK)
        return error->status;
    /* Drafts of this process: what another one left is not touched. */
    snprintf(making.draft, sizeof making.draft, "%s.making-%ld", path, (long)getpid());
    snprintf(slice, sizeof slice, "%s.slice-%ld", path, (long)getpid());
    status = make_slice(&making, store, run, slice, error);
    if (status == MR_OK)
        status = take_contents(&making, error);
    if (status == MR_OK)
        status = put_files(&making, error);
    if (status == MR_OK)
        status = store_slice(making.slice, 1, making.draft, error);
    if (status == MR_OK)
        status = put_digests(&making, error);
    if (status == MR_OK)
        status = seal(&making, made, error);
    if (status == MR_OK)
        status = output_place_database(making.draft, path, want->force, error);
    store_close(making.slice);
    remove_database(slice);
    remove_database(making.draft);
    for (int i = 0; i < BUNDLE_FILES; i++) {
        made->file_bytes[i] = making.content[i].size;
        memcpy(made->why_not[i], making.content[i].why_not, sizeof made->why_not[i]);
        free(making.content[i].bytes);
    }
    return status;
}
