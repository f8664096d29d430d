#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/bundle/bundle.h"
#include "host/bundle/digest.h"
#include "host/bundle/inside.h"
#include "host/store/store_guard.h"

/* The file's header, https://sqlite.org/fileformat2.html#the_database_header */
#define HEADER_BYTES         100u
#define HEADER_PAGE_SIZE     16u /* 2 bytes, high one first; 1: 65536 */
#define HEADER_WRITE_VERSION 18u
#define HEADER_READ_VERSION  19u
#define HEADER_PAGES         28u
#define VERSION_ROLLBACK     1u

/* Whatever the bytes are, reading them ends: an undamaged bundle of 10 MB takes a hundredth of
 * this. */
#define STEPS_MAX  40000000
#define STEPS_EACH 10000
#define HASHED_MAX 134217728

static int too_many_steps(void *context)
{
    struct bundle *bundle = context;
    return ++bundle->turns > STEPS_MAX / STEPS_EACH;
}

static void printable(char *to, size_t size, const void *text, size_t length)
{
    size_t n = length < size - 1 ? length : size - 1;
    for (size_t i = 0; i < n; i++) {
        char c = ((const char *)text)[i];
        to[i] = c >= ' ' && c <= '~' ? c : '?';
    }
    to[n] = '\0';
}

static void column(sqlite3_stmt *row, int number, char *to, size_t size)
{
    const void *text = sqlite3_column_blob(row, number);
    printable(to, size, text ? text : "", text ? (size_t)sqlite3_column_bytes(row, number) : 0);
}

static void judge(struct bundle_part *part, enum bundle_state state, const char *why)
{
    part->state = state;
    snprintf(part->why, sizeof part->why, "%s", why);
}

static struct bundle_part *add_part(struct bundle_check *check)
{
    struct bundle_part *part =
        &check->part[check->parts < BUNDLE_PARTS_MAX - 1 ? check->parts++ : BUNDLE_PARTS_MAX - 1];
    *part = (struct bundle_part){.kind = ""};
    check->parts += check->parts == BUNDLE_PARTS_MAX - 1 &&
                    part == &check->part[BUNDLE_PARTS_MAX - 1];
    return part;
}

/* ---- the bytes ---- */

static uint32_t page_bytes(const uint8_t *bytes)
{
    uint32_t size = (uint32_t)bytes[HEADER_PAGE_SIZE] << 8 | bytes[HEADER_PAGE_SIZE + 1];
    return size == 1 ? 65536 : size;
}

static void look_at_header(struct bundle *bundle, struct bundle_check *check)
{
    uint8_t *bytes = bundle->bytes;
    uint32_t page = page_bytes(bytes), pages = 0;
    char hex[BUNDLE_DIGEST];
    size_t at;
    for (unsigned i = 0; i < 4; i++)
        pages = pages << 8 | bytes[HEADER_PAGES + i];
    digest_sealed(bytes, bundle->size, hex, &at);
    check->sealed = at && memcmp(bytes + at, hex, BUNDLE_DIGEST - 1u) == 0;
    check->bytes = bundle->size;
    check->whole_bytes = (uint64_t)pages * page;
    check->truncated = bundle->size < check->whole_bytes;
    bytes[HEADER_WRITE_VERSION] = bytes[HEADER_READ_VERSION] = VERSION_ROLLBACK;
    pages = page ? (uint32_t)(bundle->size / page) : 0;
    for (unsigned i = 0; i < 4; i++)
        bytes[HEADER_PAGES + i] = (uint8_t)(pages >> (24 - 8 * i));
    if (check->truncated && page)
        bundle->size -= bundle->size % page;
}

static enum mr_status attach_bytes(struct bundle *bundle, const char *path, struct error *error)
{
    if (sqlite3_open_v2(":memory:", &bundle->database, SQLITE_OPEN_READWRITE, NULL) != SQLITE_OK ||
        sqlite3_deserialize(bundle->database, "main", bundle->bytes, (sqlite3_int64)bundle->size,
                            (sqlite3_int64)bundle->size, SQLITE_DESERIALIZE_READONLY) != SQLITE_OK)
        return error_set(error, MR_MALFORMED,
                         "no bundle (%s): %s; name a file that matrig bundle made",
                         bundle->database ? sqlite3_errmsg(bundle->database) : "no memory", path);
    store_guard_settings(bundle->database);
    sqlite3_limit(bundle->database, SQLITE_LIMIT_LENGTH, (int)BUNDLE_FILE_MAX);
    sqlite3_limit(bundle->database, SQLITE_LIMIT_ATTACHED, 0);
    sqlite3_progress_handler(bundle->database, STEPS_EACH, too_many_steps, bundle);
    return MR_OK;
}

/* Only plain tables: a view or a computed column could make reading take for ever. */
static enum mr_status check_schema(struct bundle *bundle, const char *path, struct error *error)
{
    sqlite3_stmt *row = NULL;
    static const char sql[] = "SELECT name, type FROM sqlite_schema AS s WHERE type='view' OR "
                              "(type='table' AND (rootpage=0 OR sql IS NULL OR"
                              " EXISTS(SELECT 1 FROM pragma_table_xinfo(s.name) WHERE hidden<>0)))";
    char name[BUNDLE_NAME], type[8];
    int code = sqlite3_prepare_v2(bundle->database, sql, -1, &row, NULL);
    if (code == SQLITE_OK)
        code = sqlite3_step(row);
    if (code == SQLITE_ROW) {
        column(row, 0, name, sizeof name);
        column(row, 1, type, sizeof type);
        error_set(
            error, MR_MALFORMED,
            "no bundle (%s %s is none that a bundle has): %s; name a file that matrig bundle made",
            type, name, path);
    } else if (code != SQLITE_DONE) {
        error_set(error, MR_MALFORMED,
                  "its tables cannot be told (%s): %s; name a file that matrig bundle made",
                  sqlite3_errmsg(bundle->database), path);
    }
    sqlite3_finalize(row);
    return error->status;
}

/* ---- the parts ---- */

static void check_file(struct bundle *bundle, struct bundle_part *part)
{
    char hex[BUNDLE_DIGEST], why[160];
    size_t size;
    if (bundle_known_file(part->name, strlen(part->name)) < 0) {
        judge(part, BUNDLE_FOREIGN, "no bundle has a file of this name");
        return;
    }
    uint8_t *bytes = bundle_unpack(bundle, part->name, &size, why, sizeof why);
    if (!bytes) {
        judge(part, BUNDLE_LOST, why);
        return;
    }
    digest_bytes(bytes, size, hex);
    free(bytes);
    if (strcmp(hex, part->digest) != 0 || (int64_t)size != part->bytes)
        judge(part, BUNDLE_CHANGED, "its SHA-256 is another");
}

static void check_table(struct bundle *bundle, struct bundle_part *part)
{
    struct digest_sum sum;
    bool schema = strcmp(part->kind, "schema") == 0;
    int code = digest_table(bundle->database, schema ? NULL : part->name,
                            HASHED_MAX - bundle->hashed, &sum);
    bundle->hashed += sum.bytes;
    part->rows = sum.rows;
    if (code == SQLITE_TOOBIG || code == SQLITE_INTERRUPT)
        judge(part, BUNDLE_LOST, "it is longer than any bundle is");
    else if (code != SQLITE_OK)
        judge(part, BUNDLE_LOST, sqlite3_errmsg(bundle->database));
    else if (strcmp(sum.hex, part->digest) != 0 || sum.bytes != part->bytes)
        judge(part, BUNDLE_CHANGED, "its SHA-256 is another");
}

static void read_part(sqlite3_stmt *row, struct bundle_part *part)
{
    column(row, 0, part->name, sizeof part->name);
    column(row, 1, part->kind, sizeof part->kind);
    part->bytes = sqlite3_column_int64(row, 2);
    column(row, 3, part->what, sizeof part->what);
    column(row, 4, part->digest, sizeof part->digest);
    if (sqlite3_column_bytes(row, 0) >= (int)BUNDLE_NAME)
        judge(part, BUNDLE_FOREIGN, "no bundle has a name so long");
    else if (sqlite3_column_text(row, 0) &&
             strlen((const char *)sqlite3_column_text(row, 0)) != strlen(part->name))
        judge(part, BUNDLE_FOREIGN, "a NUL in its name");
}

/* MR_MALFORMED: there is no manifest. One that breaks off is told as a part that is lost. */
static enum mr_status check_parts(struct bundle *bundle, struct bundle_check *check,
                                  struct error *error)
{
    sqlite3_stmt *row = NULL;
    if (sqlite3_prepare_v2(
            bundle->database,
            "SELECT name, kind, bytes, what, sha256 FROM bundle_manifest ORDER BY rowid", -1, &row,
            NULL) != SQLITE_OK)
        return error_set(error, MR_MALFORMED,
                         "no bundle (%s): %s; name a file that matrig bundle made, or give a RUN: "
                         "matrig replay DB RUN",
                         sqlite3_errmsg(bundle->database), check->path);
    int code;
    while ((code = sqlite3_step(row)) == SQLITE_ROW && check->parts < BUNDLE_PARTS_MAX - 1) {
        struct bundle_part *part = add_part(check);
        read_part(row, part);
        if (part->state != BUNDLE_WHOLE)
            continue;
        if (strcmp(part->kind, "file") == 0)
            check_file(bundle, part);
        else if (strcmp(part->kind, "table") == 0 || strcmp(part->kind, "schema") == 0)
            check_table(bundle, part);
        else
            judge(part, BUNDLE_FOREIGN, "no bundle has parts of this kind");
    }
    if (code != SQLITE_DONE || check->parts == 0) {
        struct bundle_part *part = add_part(check);
        snprintf(part->name, sizeof part->name, "bundle_manifest");
        snprintf(part->kind, sizeof part->kind, "table");
        judge(part, BUNDLE_LOST,
              code == SQLITE_ROW    ? "it has more parts than any bundle"
              : code == SQLITE_DONE ? "it is empty"
                                    : sqlite3_errmsg(bundle->database));
    }
    sqlite3_finalize(row);
    return MR_OK;
}

/* What lies in the file and is not in the manifest. */
static void find_foreign(struct bundle *bundle, struct bundle_check *check)
{
    static const char sql[] = "SELECT name, 'file' FROM sqlar WHERE name NOT IN (SELECT name FROM "
                              "bundle_manifest WHERE kind='file') OR name IS NULL UNION ALL"
                              " SELECT name, 'table' FROM sqlite_schema WHERE type='table' AND "
                              "name NOT IN (SELECT name FROM bundle_manifest WHERE kind='table')"
                              " AND name NOT IN ('sqlar', 'bundle_manifest', 'bundle_seal') AND "
                              "name NOT LIKE 'sqlite!_%' ESCAPE '!'";
    sqlite3_stmt *row = NULL;
    if (sqlite3_prepare_v2(bundle->database, sql, -1, &row, NULL) == SQLITE_OK) {
        while (sqlite3_step(row) == SQLITE_ROW && check->parts < BUNDLE_PARTS_MAX - 1) {
            struct bundle_part *part = add_part(check);
            column(row, 0, part->name, sizeof part->name);
            column(row, 1, part->kind, sizeof part->kind);
            judge(part, BUNDLE_FOREIGN, "the manifest does not have it");
        }
    }
    sqlite3_finalize(row);
}

/* ---- opening ---- */

enum mr_status bundle_open_bytes(const char *path, const uint8_t *bytes, size_t size,
                                 struct bundle **bundle, struct bundle_check *check,
                                 struct error *error)
{
    static const char magic[16] = "SQLite format 3";
    *check = (struct bundle_check){.path = path};
    *bundle = NULL;
    if (size < HEADER_BYTES || memcmp(bytes, magic, sizeof magic) != 0)
        return error_set(error, MR_MALFORMED,
                         "no bundle%s: %s; name a file that matrig bundle made",
                         size < HEADER_BYTES ? ", or cut off in its header" : "", path);
    struct bundle *made = calloc(1, sizeof *made);
    if (!made || !(made->bytes = malloc(size)))
        abort();
    memcpy(made->bytes, bytes, made->size = size);
    look_at_header(made, check);
    struct error why = {0};
    enum mr_status status = attach_bytes(made, path, &why);
    if (status == MR_OK)
        status = check_schema(made, path, &why);
    if (status == MR_OK)
        status = check_parts(made, check, &why);
    if (status != MR_OK && check->truncated)
        error_set(error, status = MR_TRUNCATED,
                  "truncated at byte %zu of %llu, before anything that could be saved: %s; get it "
                  "once more",
                  size, (unsigned long long)check->whole_bytes, path);
    else if (status != MR_OK)
        *error = why;
    if (status == MR_OK)
        find_foreign(made, check);
    for (size_t i = 0; i < check->parts; i++)
        check->bad += check->part[i].state != BUNDLE_WHOLE;
    if (status == MR_OK)
        *bundle = made;
    else
        bundle_close(made);
    return status;
}

static bool lies_beside(const char *path)
{
    static const char *const tails[] = {"-wal", "-journal"};
    char beside[4200];
    struct stat info;
    bool found = false;
    for (size_t i = 0; i < sizeof tails / sizeof tails[0]; i++) {
        snprintf(beside, sizeof beside, "%s%s", path, tails[i]);
        found |= stat(beside, &info) == 0 && info.st_size > 0;
    }
    return found;
}

enum mr_status bundle_open(const char *path, struct bundle **bundle, struct bundle_check *check,
                           struct error *error)
{
    struct stat info;
    *bundle = NULL;
    /* a pipe without a writer does not hold it up */
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (file < 0 || fstat(file, &info) != 0 || !S_ISREG(info.st_mode)) {
        enum mr_status status =
            error_set(error, MR_IO, "cannot be read (%s): %s; name a file that matrig bundle made",
                      file < 0 ? strerror(errno) : "no plain file", path);
        if (file >= 0)
            close(file);
        return status;
    }
    uint8_t *bytes = NULL;
    size_t size = 0;
    enum mr_status status = MR_OK;
    if (info.st_size > (off_t)BUNDLE_READ_MAX)
        status = error_set(error, MR_TOO_LONG,
                           "%lld bytes, no bundle has more than %u: %s; a campaign is replayed "
                           "with its RUN: matrig replay DB RUN",
                           (long long)info.st_size, BUNDLE_BYTES_MAX, path);
    if (status == MR_OK && !(bytes = malloc((size_t)info.st_size + 1u)))
        abort();
    while (status == MR_OK && size < (size_t)info.st_size) {
        ssize_t got = read(file, bytes + size, (size_t)info.st_size - size);
        if (got < 0)
            status = error_set(error, MR_IO, "cannot be read (%s): %s; check the disk",
                               strerror(errno), path);
        if (got <= 0)
            break;
        size += (size_t)got;
    }
    close(file);
    if (status == MR_OK)
        status = bundle_open_bytes(path, bytes, size, bundle, check, error);
    check->aside = status == MR_OK && lies_beside(path);
    free(bytes);
    return status;
}

void bundle_close(struct bundle *bundle)
{
    if (!bundle)
        return;
    sqlite3_close(bundle->database);
    free(bundle->bytes);
    free(bundle);
}
