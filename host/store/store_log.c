#include "host/store/store_log.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/store/store_sql.h"

#define JOURNAL   "-wal"
#define PATH_MOST 4096

void store_patience(struct store *store, int wait_ms)
{
    sqlite3_busy_timeout(store->database, wait_ms);
}

enum store_refusal store_refusal_of(int sqlite_code)
{
    switch (sqlite_code) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED: return STORE_LOCKED;
    case SQLITE_FULL: return STORE_FULL;
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
    case SQLITE_READONLY:
    case SQLITE_PROTOCOL: return STORE_FAILS;
    default: return STORE_TAKES;
    }
}

enum store_refusal store_take_refusal(struct store *store)
{
    enum store_refusal refused = (enum store_refusal)store->refused;
    store->refused = STORE_TAKES;
    return refused;
}

void store_roll_back(struct store *store)
{
    store->waiting_count = 0;
    store_each_statement(store, sqlite3_reset);
    if (!sqlite3_get_autocommit(store->database))
        sqlite3_exec(store->database, "ROLLBACK", NULL, NULL, NULL);
}

static bool stat_of(const char *path, const char *suffix, struct stat *info)
{
    char name[PATH_MOST];
    int length = snprintf(name, sizeof name, "%s%s", path, suffix);
    return length > 0 && (size_t)length < sizeof name && stat(name, info) == 0;
}

void store_identify(const char *path, struct store_identity *identity)
{
    struct stat info;
    *identity = (struct store_identity){0};
    if (stat_of(path, "", &info)) {
        identity->device = info.st_dev;
        identity->file = info.st_ino;
    }
    if (stat_of(path, JOURNAL, &info)) {
        identity->journal_device = info.st_dev;
        identity->journal = info.st_ino;
    }
}

enum store_place store_find(const char *path, const struct store_identity *identity)
{
    struct stat info;
    if (!stat_of(path, "", &info))
        /* one that cannot be asked may still be there */
        return errno == ENOENT || errno == ENOTDIR ? STORE_MISSING : STORE_IN_PLACE;
    if (info.st_ino != identity->file || info.st_dev != identity->device)
        return STORE_REPLACED;
    if (identity->journal == 0)
        return STORE_IN_PLACE;
    if (!stat_of(path, JOURNAL, &info))
        return errno == ENOENT ? STORE_NO_JOURNAL : STORE_IN_PLACE;
    return info.st_ino != identity->journal || info.st_dev != identity->journal_device
             ? STORE_NO_JOURNAL
             : STORE_IN_PLACE;
}

/* Of the file's header (https://sqlite.org/fileformat2.html, 1.3). */
enum { HEADER = 100, AT_PAGE_SIZE = 16, AT_COUNTER = 24, AT_PAGES = 28, AT_COOKIE = 40 };
enum { AT_VERSION = 60, AT_APPLICATION = 68 };
#define COOKIES 1000u /* a VACUUM adds 1 */

static uint32_t big_endian(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

/* MR_IO: the disk does not answer; MR_MALFORMED: no campaign. The descriptor that keeps other logs
 * out is read: opening and closing another one would take SQLite's locks from this process. */
static enum mr_status read_header(const struct store *store, struct store_header *header,
                                  uint32_t *page_bytes)
{
    uint8_t bytes[HEADER] = {0};
    struct stat info;
    if (fstat(store->alone, &info) != 0 || pread(store->alone, bytes, sizeof bytes, 0) < 0)
        return MR_IO;
    *header = (struct store_header){.counter = big_endian(bytes + AT_COUNTER),
                                    .pages = big_endian(bytes + AT_PAGES),
                                    .cookie = big_endian(bytes + AT_COOKIE),
                                    .bytes = info.st_size};
    *page_bytes = big_endian(bytes + AT_PAGE_SIZE) >> 16;
    return memcmp(bytes, "SQLite format 3", 16) == 0 &&
                   big_endian(bytes + AT_VERSION) == STORE_VERSION &&
                   big_endian(bytes + AT_APPLICATION) == STORE_APPLICATION
             ? MR_OK
             : MR_MALFORMED;
}

void store_watch_file(struct store *store)
{
    uint32_t page_bytes;
    if (!store->alone || read_header(store, &store->header, &page_bytes) != MR_OK)
        store->header.bytes = 0;
}

bool store_overwritten(struct store *store)
{
    const struct store_header known = store->header;
    struct store_header now;
    uint32_t page_bytes;
    int code = sqlite3_errcode(store->database) & 0xff;
    if (known.bytes == 0 || store->overwritten)
        return store->overwritten;
    enum mr_status status = read_header(store, &now, &page_bytes);
    int64_t least = (int64_t)now.pages * page_bytes;
    /* the file of a checkpoint grows behind its header; an older copy has a lower counter */
    store->overwritten = code == SQLITE_CORRUPT || code == SQLITE_NOTADB ||
                         status == MR_MALFORMED ||
                         (status == MR_OK && (now.cookie - known.cookie > COOKIES ||
                                              now.counter - known.counter > INT32_MAX ||
                                              (now.bytes < least && now.bytes < known.bytes)));
    if (status == MR_OK)
        store->header = now;
    return store->overwritten;
}

enum mr_status store_note_logged(struct store *store, int64_t session, struct error *error)
{
    enum mr_status status = store_frames_flush(store, error);
    store->session = session;
    return status == MR_OK ? STORE_ONE(store, error, LOGGED, &store->next, BIND(session)) : status;
}

void store_logged_committed(struct store *store)
{
    store->committed = store->next;
}

enum mr_status store_session_there(struct store *store, bool *there, struct error *error)
{
    int64_t version = 0;
    struct store_logged now = {0};
    *there = true;
    enum mr_status status = STORE_NUMBER(store, error, DATA_VERSION, &version);
    if (status != MR_OK || version == store->version || store->committed.newest == 0)
        return status;
    status = STORE_ONE(store, error, LOGGED, &now, BIND(store->session));
    *there = status == MR_OK && now.started_us == store->committed.started_us &&
             now.newest >= store->committed.newest;
    store->version = *there ? version : store->version;
    return status == MR_TOO_FEW ? MR_OK : status;
}

void store_journal_aside(const char *path, const char *kept)
{
    char journal[PATH_MOST], index[PATH_MOST];
    snprintf(journal, sizeof journal, "%s" JOURNAL, path);
    snprintf(index, sizeof index, "%s-shm", path);
    rename(journal, kept);
    unlink(index);
}

static enum mr_status copy_pages(struct store *store, sqlite3 *copy, const char *path,
                                 struct error *error)
{
    sqlite3_backup *backup = sqlite3_backup_init(copy, "main", store->database, "main");
    if (backup) {
        sqlite3_backup_step(backup, -1);
        sqlite3_backup_finish(backup);
    }
    if (sqlite3_errcode(copy) != SQLITE_OK)
        return error_set(error, MR_IO, "cannot save the campaign (%s): %s; make room on the disk",
                         sqlite3_errmsg(copy), path);
    return MR_OK;
}

enum mr_status store_copy_to(struct store *store, const char *path, struct error *error)
{
    sqlite3 *copy = NULL;
    struct store *check = NULL;
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0)
        return error_set(error, MR_IO, "cannot save the campaign (%s): %s; check path and rights",
                         strerror(errno), path);
    close(fd);
    enum mr_status status = MR_OK;
    if (sqlite3_open_v2(path, &copy, SQLITE_OPEN_READWRITE, NULL) != SQLITE_OK)
        status = error_set(error, MR_IO, "cannot save the campaign (%s): %s; check path and rights",
                           sqlite3_errmsg(copy), path);
    if (status == MR_OK)
        status = copy_pages(store, copy, path, error);
    sqlite3_close(copy);
    if (status == MR_OK)
        status = store_open(path, STORE_READ, &check, error);
    store_close(check);
    if (status != MR_OK)
        unlink(path); /* it was made here, and is not whole */
    return status;
}

void store_whereabouts(const struct store *store, char *out, size_t size)
{
    char link[40];
    static const char deleted[] = " (deleted)";
    snprintf(link, sizeof link, "/proc/self/fd/%d", store->alone);
    ssize_t length = store->alone && size > 0 ? readlink(link, out, size - 1) : -1;
    out[length > 0 ? length : 0] = '\0';
    size_t tail = sizeof deleted - 1;
    if ((size_t)length > tail && length > 0 && strcmp(out + length - tail, deleted) == 0)
        out[0] = '\0';
}

void store_leave(struct store *store, bool moved)
{
    if (moved) /* so that the file is whole, wherever it is */
        sqlite3_wal_checkpoint_v2(store->database, "main", SQLITE_CHECKPOINT_TRUNCATE, NULL, NULL);
    /* Closing would else write the journal back, and delete by its path what may be another
     * campaign's. */
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL);
    store_close(store);
}

void store_journal_remove(const char *path, const struct store_identity *identity)
{
    char name[PATH_MOST];
    struct stat info;
    if (!stat_of(path, JOURNAL, &info) || info.st_ino != identity->journal ||
        info.st_dev != identity->journal_device)
        return;
    snprintf(name, sizeof name, "%s" JOURNAL, path);
    unlink(name);
    snprintf(name, sizeof name, "%s-shm", path);
    unlink(name);
}
