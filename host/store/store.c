#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "host/store/store.h"
#include "common/version.h"
#include "host/base/output.h"
#include "host/base/spell_suggest.h"
#include "host/store/table.h"

/* Time to wait while another program writes, ms. Received data is buffered in the meantime. */
#define BUSY_TIMEOUT_MS       30000
#define SET_UP_RETRY_MS       20
#define FIRST_READ_TIMEOUT_MS 500

/* limit for one value; the largest value that matrig writes is an imported channel of 18 h at 1
 * kHz */
#define VALUE_BYTES_MAX 268435456

/* Applies the settings of every connection to a campaign. The settings make SQLite distrust the
 * schema, because another program may have written it. `database` may be NULL. */
static void apply_safe_settings(sqlite3 *database)
{
    if (!database)
        return;
    sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, VALUE_BYTES_MAX);
}

static enum mr_status read_pragma(struct store *store, const char *sql, int64_t *value,
                                  struct error *error)
{
    sqlite3_stmt *statement;
    if (sqlite3_prepare_v2(store->database, sql, -1, &statement, NULL) != SQLITE_OK)
        return store_set_error(store, "read", error);
    int code = sqlite3_step(statement);
    *value = code == SQLITE_ROW ? sqlite3_column_int64(statement, 0) : 0;
    enum mr_status status = code == SQLITE_ROW ? MR_OK : store_set_error(store, "read", error);
    sqlite3_finalize(statement);
    return status;
}

/* Sets up a new, empty file in one transaction, so that no process sees an incomplete schema. If
 * two processes do this at the same time, the second one finds a complete schema. */
static enum mr_status create_tables(struct store *store, struct error *error)
{
    char numbers[160];
    int64_t tables = 0;
    uint32_t own = 0; /* random schema cookie, by which matrig log recognises its file */
    if (getrandom(&own, sizeof own, 0) != (ssize_t)sizeof own)
        own = (uint32_t)time(NULL);
    snprintf(numbers, sizeof numbers,
             "PRAGMA application_id=%d; PRAGMA user_version=%d; PRAGMA schema_version=%u;",
             STORE_APPLICATION_ID, STORE_VERSION, own >> 1);
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_DEFENSIVE, 0, NULL);
    enum mr_status status = store_execute(store, "BEGIN IMMEDIATE", "set up", error);
    if (status == MR_OK)
        status = read_pragma(store, "SELECT count(*) FROM sqlite_schema", &tables, error);
    if (status == MR_OK && tables == 0)
        status = store_create_tables(store->database, false) == SQLITE_OK
                   ? MR_OK
                   : store_set_error(store, "set up", error);
    if (status == MR_OK && tables == 0)
        status = store_execute(store, numbers, "set up", error);
    if (status == MR_OK)
        status = store_execute(store, "COMMIT", "set up", error);
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    return status;
}

#define SELECT_OBJECTS "SELECT type, name, tbl_name, sql FROM main.sqlite_schema"

/* Binds the first four columns of `row` to a statement and runs it. Returns the number of rows that
 * it changed. */
static int execute_with_row(sqlite3 *database, const char *sql, sqlite3_stmt *row)
{
    sqlite3_stmt *s = NULL;
    sqlite3_prepare_v2(database, sql, -1, &s, NULL);
    for (int i = 0; i < 4; i++)
        sqlite3_bind_value(s, i + 1, sqlite3_column_value(row, i));
    bool done = sqlite3_step(s) == SQLITE_DONE;
    sqlite3_finalize(s);
    return done ? sqlite3_changes(database) : 0;
}

/* True if a campaign has exactly the schema of a new one. A schema can contain programs, such as a
 * view that never ends or a trigger that runs at every row, so any difference is refused. `what` is
 * set to the first object that only one of the two schemas has. */
static bool has_expected_schema(sqlite3 *database, char what[STORE_TEXT_SIZE])
{
    sqlite3 *fresh = NULL;
    sqlite3_stmt *row = NULL;
    int code = sqlite3_open(":memory:", &fresh) | store_create_tables(fresh, false);
    if (store_has_on_demand_tables(database))
        code |= store_create_tables(fresh, true);
    code |= sqlite3_exec(fresh, "ANALYZE; CREATE TEMP TABLE known AS " SELECT_OBJECTS, NULL, NULL,
                         NULL) |
            sqlite3_prepare_v2(database, SELECT_OBJECTS " ORDER BY type DESC", -1, &row, NULL);
    bool same = code == SQLITE_OK;
    while (same && (code = sqlite3_step(row)) == SQLITE_ROW)
        same = execute_with_row(
                   fresh, "DELETE FROM known WHERE type=? AND name=? AND tbl_name=? AND sql IS ?",
                   row) == 1;
    if (code == SQLITE_DONE) {
        sqlite3_finalize(row);
        sqlite3_prepare_v2(fresh,
                           "SELECT 'no '||type, name FROM known WHERE name NOT LIKE 'sqlite_stat%'",
                           -1, &row, NULL);
        same = (code = sqlite3_step(row)) == SQLITE_DONE;
    }
    if (code == SQLITE_ROW) {
        char type[40], name[100];
        store_copy_text(row, 0, type, sizeof type);
        store_copy_text(row, 1, name, sizeof name);
        snprintf(what, STORE_TEXT_SIZE, "%s %s", type, name);
    } else {
        snprintf(what, STORE_TEXT_SIZE, "%s", sqlite3_errmsg(database));
    }
    sqlite3_finalize(row);
    sqlite3_close(fresh);
    return same;
}

/* Refuses a file whose schema is not that of a campaign. Call it before any table of the file is
 * used. */
static enum mr_status check_schema(struct store *store, struct error *error)
{
    char what[STORE_TEXT_SIZE];
    if (has_expected_schema(store->database, what))
        return MR_OK;
    return error_set(error, MR_MALFORMED,
                     "the campaign has tables that matrig did not create (%s): %s; remove these "
                     "tables with sqlite3, or use an earlier copy",
                     what, store->path);
}

/* Fields by which a file is recognised as a campaign. */
struct schema_id {
    int64_t application_id, version, object_count;
};

/* Reads all fields in one transaction: another log may be setting up the file. */
static enum mr_status read_schema_id(struct store *store, struct schema_id *id, struct error *error)
{
    enum mr_status status = store_execute(store, "BEGIN", "read", error);
    if (status != MR_OK)
        return status;
    status = read_pragma(store, "PRAGMA application_id", &id->application_id, error);
    if (status == MR_OK)
        status = read_pragma(store, "PRAGMA user_version", &id->version, error);
    if (status == MR_OK)
        status = read_pragma(store, "SELECT count(*) FROM sqlite_schema", &id->object_count, error);
    /* the transaction only reads, so there is nothing to commit */
    sqlite3_exec(store->database, "ROLLBACK", NULL, NULL, NULL);
    return status;
}

/* Reports which matrig version wrote the file. Every version has the column sessions.matrig. */
static enum mr_status report_version(struct store *store, int64_t version, struct error *error)
{
    sqlite3_stmt *statement = NULL;
    char by[40] = "(unknown)";
    if (sqlite3_prepare_v2(store->database, "SELECT matrig FROM sessions ORDER BY id DESC LIMIT 1",
                           -1, &statement, NULL) == SQLITE_OK &&
        sqlite3_step(statement) == SQLITE_ROW)
        store_copy_text(statement, 0, by, sizeof by);
    sqlite3_finalize(statement);
    return error_set(
        error, MR_VERSION,
        "campaign database of version %lld, written by matrig %s; this is matrig " VERSION_TEXT
        " and reads version %d: %s; use the matrig version that wrote it",
        (long long)version, by, STORE_VERSION, store->path);
}

static enum mr_status check_version(struct store *store, enum store_mode mode, struct error *error)
{
    struct schema_id id;
    enum mr_status status = read_schema_id(store, &id, error);
    if (status != MR_OK)
        return status;
    if (mode == STORE_CREATE && id.application_id == 0 && id.version == 0 && id.object_count == 0) {
        status = create_tables(store, error);
        return status == MR_OK ? check_version(store, STORE_OPEN, error) : status;
    }
    if (id.application_id != STORE_APPLICATION_ID)
        return error_set(error, MR_MALFORMED,
                         "not a campaign database: %s; give a database that matrig log created",
                         store->path);
    if (id.version != STORE_VERSION)
        return report_version(store, id.version, error);
    return check_schema(store, error);
}

static enum mr_status open_file(struct store *store, const char *name, int flags,
                                enum store_mode mode, struct error *error)
{
    if (sqlite3_open_v2(name, &store->database, flags, NULL) != SQLITE_OK)
        return store_set_error(store, "open", error);
    /* On a file system without locks every file seems to be locked, so the first attempt waits only
     * briefly. */
    bool first_try = (mode == STORE_READ || mode == STORE_READ_FOR_BUNDLE) && !store->is_retry;
    sqlite3_busy_timeout(store->database, first_try ? FIRST_READ_TIMEOUT_MS : BUSY_TIMEOUT_MS);
    apply_safe_settings(store->database);
    store_limit_sql_steps(store);
    /* do not write back the journal of a database that is not a campaign */
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL);
    enum mr_status status = check_version(store, mode, error);
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, status != MR_OK, NULL);
    sqlite3_busy_timeout(store->database, BUSY_TIMEOUT_MS);
    return status;
}

/* Opens a campaign for reading after the first attempt failed. SQLite normally locks the file and
 * creates files in its folder. If it cannot, the campaign is read without locks, or from a copy. */
static enum mr_status retry_open(struct store *store, enum store_mode mode,
                                 const struct error *first, struct error *error)
{
    char uri[STORE_URI_SIZE];
    const char *name = store->path;
    int refused = store->last_failed_code, flags = SQLITE_OPEN_READWRITE;
    if (refused != SQLITE_CANTOPEN && refused != SQLITE_READONLY && refused != SQLITE_IOERR &&
        refused != SQLITE_PROTOCOL && refused != SQLITE_BUSY && refused != SQLITE_FULL)
        return error_set(error, first->status, "%s", first->text);
    sqlite3_close(store->database);
    store->database = NULL;
    if (refused != SQLITE_BUSY || !store_has_file_locks(store->path)) {
        if (store_make_read_uri(store->path, uri, store->copy_folder, error) != MR_OK)
            return error->status;
        name = uri;
        flags |= SQLITE_OPEN_URI;
    }
    store->is_retry = true;
    return open_file(store, name, flags, mode, error);
}

/* Locks the campaign against other logs, before anything is read or created. Uses flock(2), which
 * is independent of SQLite's locks. The descriptor stays open until the database is closed, because
 * closing any descriptor of the file releases SQLite's locks in this process. */
static enum mr_status lock_for_log(struct store *store, struct error *error)
{
    store->lock_fd = open(store->path, O_RDONLY | O_CREAT | O_CLOEXEC, 0644);
    if (store->lock_fd < 0) {
        store->lock_fd = 0;
        return error_set(error, MR_IO, "cannot open (%s): %s; check the path and the permissions",
                         strerror(errno), store->path);
    }
    if (flock(store->lock_fd, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return error_set(error, MR_IO,
                         "another program writes to this campaign (matrig log): %s; end that "
                         "program first, or give a different database",
                         store->path);
    return MR_OK;
}

/* Switches to a WAL journal, and to commits that wait until the data is on disk. SQLite does not
 * wait for locks during the switch, so it is retried while another program creates the same
 * campaign. */
static enum mr_status set_wal_journal(struct store *store, struct error *error)
{
    const char sql[] = "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;";
    for (int ms = 0; ms < BUSY_TIMEOUT_MS; ms += SET_UP_RETRY_MS) {
        struct error busy = {0};
        if (store_execute(store, sql, "set up", &busy) == MR_OK)
            return MR_OK;
        if (store->last_failed_code != SQLITE_BUSY)
            break;
        nanosleep(&(const struct timespec){.tv_nsec = SET_UP_RETRY_MS * 1000000l}, NULL);
    }
    return store_execute(store, sql, "set up", error);
}

/* Reports a missing database, and names one in the same folder: the one with the most similar name,
 * otherwise the first one. */
static enum mr_status report_missing_file(const char *path, struct error *error)
{
    char folder[STORE_TEXT_SIZE], best[NAME_MAX + 1] = "";
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    struct spell_suggest near;
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1,
             slash ? path : ".");
    DIR *directory = opendir(folder);
    spell_suggest_begin(&near, name);
    for (const struct dirent *entry; directory && (entry = readdir(directory));) {
        const char *ending = strrchr(entry->d_name, '.');
        if (!ending || strcmp(ending, ".db") != 0)
            continue;
        bool known = near.best;
        spell_suggest_add(&near, entry->d_name);
        if (near.best == entry->d_name || (!known && !best[0]))
            snprintf(best, sizeof best, "%s", entry->d_name);
        if (near.best)
            near.best = best;
    }
    if (directory)
        closedir(directory);
    return error_set(error, MR_IO, "no such database: %s; %s%s%s%s", path,
                     best[0] ? "the folder has " : "give a database that matrig log created",
                     best[0] && slash ? folder : "", best,
                     best[0] && !near.best ? ", check the folder too" : "");
}

enum mr_status store_open(const char *path, enum store_mode mode, struct store **store,
                          struct error *error)
{
    struct stat info;
    const bool create = mode == STORE_CREATE || mode == STORE_LOG;
    if (!create && stat(path, &info) != 0)
        return report_missing_file(path, error);
    struct error other = {0};
    /* check the kind of the file first: a database may be empty while another program creates it */
    if (output_check_file_format(path, "campaign database", &other) != MR_OK &&
        !output_is_database(path))
        return error_set(error, other.status, "%s", other.text);
    struct store *opened = calloc(1, sizeof *opened);
    char *copy = strdup(path);
    if (!opened || !copy) {
        free(opened);
        free(copy);
        return error_set(error, MR_FULL, "out of memory, opening %s; close other programs", path);
    }
    opened->path = copy;
    /* `error` is set only after store_close, because setting it may end the program */
    struct error first = {0}, failed = {0};
    enum mr_status status = MR_OK;
    int flags = SQLITE_OPEN_READWRITE | (create ? SQLITE_OPEN_CREATE : 0);
    if (mode == STORE_OPEN || (create && strcmp(path, ":memory:") != 0))
        status = store_check_writable(path, &failed);
    if (status == MR_OK && mode == STORE_LOG)
        status = lock_for_log(opened, &failed);
    mode = create ? STORE_CREATE : mode;
    if (status == MR_OK && (mode == STORE_READ || mode == STORE_READ_FOR_BUNDLE)) {
        status = open_file(opened, path, flags, mode, &first);
        if (status != MR_OK)
            status = retry_open(opened, mode, &first, &failed);
    } else if (status == MR_OK) {
        status = open_file(opened, path, flags, mode, &failed);
    }
    if (status == MR_OK && mode == STORE_READ)
        status = store_execute(opened, "PRAGMA query_only=1", "open", &failed);
    if (status == MR_OK && mode == STORE_CREATE)
        status = set_wal_journal(opened, &failed);
    opened->checkpoint_at_close = status == MR_OK && mode == STORE_CREATE;
    if (status != MR_OK) {
        store_close(opened);
        return error_set(error, status, "%s", failed.text);
    }
    *store = opened;
    return MR_OK;
}

/* The descriptor stays open: closing it would release SQLite's locks (see lock_for_log). */
bool store_is_being_logged(struct store *store)
{
    if (!store->lock_fd)
        store->lock_fd = open(store->path, O_RDONLY | O_CLOEXEC);
    if (store->lock_fd <= 0) {
        store->lock_fd = 0;
        return false;
    }
    bool held = flock(store->lock_fd, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!held)
        flock(store->lock_fd, LOCK_UN);
    return held;
}

void store_close(struct store *store)
{
    if (!store)
        return;
    store_for_each_statement(store, sqlite3_finalize);
    /* also write the journal back, so that the file alone is complete when it is copied */
    if (store->checkpoint_at_close && !store->is_overwritten) {
        sqlite3_busy_timeout(store->database, 0);
        sqlite3_wal_checkpoint_v2(store->database, "main", SQLITE_CHECKPOINT_TRUNCATE, NULL, NULL);
    }
    sqlite3_close(store->database);
    if (store->lock_fd)
        close(store->lock_fd);
    store_remove_read_copy(store->copy_folder);
    free(store->path);
    free(store);
}

const char *store_path(const struct store *store)
{
    return store->path;
}

enum mr_status store_begin(struct store *store, struct error *error)
{
    return store_execute(store, "BEGIN IMMEDIATE", "write", error);
}

enum mr_status store_commit(struct store *store, struct error *error)
{
    enum mr_status status = store_frames_flush(store, error)
                              ?: store_execute(store, "COMMIT", "write", error);
    store->is_checkpointed &= status != MR_OK;
    return status;
}

bool store_checkpoint(struct store *store)
{
    int frames = 0, back = 0;
    bool first = !store->is_checkpointed;
    store->is_checkpointed = true;
    return first &&
           sqlite3_wal_checkpoint_v2(store->database, "main", SQLITE_CHECKPOINT_PASSIVE, &frames,
                                     &back) == SQLITE_OK &&
           frames > 0 && back == frames;
}

/* ---- for matrig log ---- */

#define JOURNAL_SUFFIX   "-wal"
#define WAL_INDEX_SUFFIX "-shm"
#define PATH_SIZE        4096

void store_set_wait_ms(struct store *store, int wait_ms)
{
    sqlite3_busy_timeout(store->database, wait_ms);
}

static enum store_refusal get_refusal(int code)
{
    switch (code) {
    case SQLITE_BUSY:
    case SQLITE_LOCKED: return STORE_LOCKED;
    case SQLITE_FULL: return STORE_DISK_FULL;
    case SQLITE_IOERR:
    case SQLITE_CANTOPEN:
    case SQLITE_READONLY:
    case SQLITE_PROTOCOL: return STORE_DISK_ERROR;
    default: return STORE_NO_RETRY;
    }
}

enum store_refusal store_refusal_pop(struct store *store)
{
    enum store_refusal refusal = store->size_limit_reached ? STORE_SIZE_LIMIT
                                                           : get_refusal(store->last_failed_code);
    store->last_failed_code = 0;
    store->size_limit_reached = false;
    return refusal;
}

void store_roll_back(struct store *store)
{
    store->buffered_frame_count = 0;
    store_for_each_statement(store, sqlite3_reset);
    if (!sqlite3_get_autocommit(store->database))
        sqlite3_exec(store->database, "ROLLBACK", NULL, NULL, NULL);
}

static bool stat_with_suffix(const char *path, const char *suffix, struct stat *info)
{
    char name[PATH_SIZE];
    int length = snprintf(name, sizeof name, "%s%s", path, suffix);
    return length > 0 && (size_t)length < sizeof name && stat(name, info) == 0;
}

void store_file_identity_get(const char *path, struct store_file_identity *identity)
{
    struct stat info;
    *identity = (struct store_file_identity){0};
    if (stat_with_suffix(path, "", &info)) {
        identity->file_device = info.st_dev;
        identity->file_inode = info.st_ino;
    }
    if (stat_with_suffix(path, JOURNAL_SUFFIX, &info)) {
        identity->journal_device = info.st_dev;
        identity->journal_inode = info.st_ino;
    }
    if (stat_with_suffix(path, WAL_INDEX_SUFFIX, &info))
        identity->index_inode = info.st_ino;
}

enum store_file_state store_check_file_identity(const char *path,
                                                const struct store_file_identity *identity)
{
    struct stat info;
    if (!stat_with_suffix(path, "", &info))
        /* after other errors it is unknown whether the file exists */
        return errno == ENOENT || errno == ENOTDIR ? STORE_FILE_MISSING : STORE_FILE_UNCHANGED;
    if (info.st_ino != identity->file_inode || info.st_dev != identity->file_device)
        return STORE_FILE_REPLACED;
    if (identity->journal_inode == 0)
        return STORE_FILE_UNCHANGED;
    if (!stat_with_suffix(path, JOURNAL_SUFFIX, &info))
        return errno == ENOENT ? STORE_FILE_NO_JOURNAL : STORE_FILE_UNCHANGED;
    if (info.st_ino != identity->journal_inode || info.st_dev != identity->journal_device)
        return STORE_FILE_NO_JOURNAL;
    bool index = stat_with_suffix(path, WAL_INDEX_SUFFIX, &info)
                   ? info.st_ino == identity->index_inode
                   : errno != ENOENT;
    return index || identity->index_inode == 0 ? STORE_FILE_UNCHANGED : STORE_FILE_NO_INDEX;
}

/* Offsets in the file's header (https://sqlite.org/fileformat2.html, 1.3). */
enum {
    FILE_HEADER_BYTES = 100,
    OFFSET_PAGE_SIZE = 16,
    OFFSET_CHANGE_COUNTER = 24,
    OFFSET_PAGE_COUNT = 28,
    OFFSET_SCHEMA_COOKIE = 40
};
enum { OFFSET_USER_VERSION = 60, OFFSET_APPLICATION_ID = 68 };
/* a larger change of the cookie means another file; a VACUUM adds 1 */
#define SCHEMA_COOKIE_STEP_MAX 1000u

static uint32_t read_big_endian(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

/* Reads the file's header. Returns MR_IO if the disk fails, MR_MALFORMED if it is not a campaign.
 * Uses lock_fd: closing another descriptor of the file would release SQLite's locks. */
static enum mr_status read_file_header(const struct store *store, struct store_file_header *header,
                                       uint32_t *page_bytes)
{
    uint8_t bytes[FILE_HEADER_BYTES] = {0};
    struct stat info;
    if (fstat(store->lock_fd, &info) != 0 || pread(store->lock_fd, bytes, sizeof bytes, 0) < 0)
        return MR_IO;
    *header =
        (struct store_file_header){.change_counter = read_big_endian(bytes + OFFSET_CHANGE_COUNTER),
                                   .page_count = read_big_endian(bytes + OFFSET_PAGE_COUNT),
                                   .schema_cookie = read_big_endian(bytes + OFFSET_SCHEMA_COOKIE),
                                   .file_bytes = info.st_size};
    *page_bytes = read_big_endian(bytes + OFFSET_PAGE_SIZE) >> 16;
    return memcmp(bytes, "SQLite format 3", 16) == 0 &&
                   read_big_endian(bytes + OFFSET_USER_VERSION) == STORE_VERSION &&
                   read_big_endian(bytes + OFFSET_APPLICATION_ID) == STORE_APPLICATION_ID
             ? MR_OK
             : MR_MALFORMED;
}

static int write_if_not_overwritten(sqlite3_file *file, const void *bytes, int length,
                                    sqlite3_int64 at)
{
    const struct store_write_guard *guard = (const struct store_write_guard *)file->pMethods;
    return store_is_overwritten(guard->store)
             ? SQLITE_IOERR_WRITE
             : guard->original_methods->xWrite(file, bytes, length, at);
}

static int truncate_if_not_overwritten(sqlite3_file *file, sqlite3_int64 length)
{
    const struct store_write_guard *guard = (const struct store_write_guard *)file->pMethods;
    return store_is_overwritten(guard->store) ? SQLITE_IOERR_TRUNCATE
                                              : guard->original_methods->xTruncate(file, length);
}

/* Makes SQLite check before every write whether the file was overwritten. Checking before each
 * transaction is not enough: a checkpoint can begin at any time and takes long. */
static void install_write_guard(struct store *store)
{
    sqlite3_file *file = NULL;
    if (store->guard.original_methods ||
        sqlite3_file_control(store->database, "main", SQLITE_FCNTL_FILE_POINTER, &file) !=
            SQLITE_OK ||
        !file || !file->pMethods)
        return;
    store->guard = (struct store_write_guard){*file->pMethods, file->pMethods, store};
    store->guard.methods.xWrite = write_if_not_overwritten;
    store->guard.methods.xTruncate = truncate_if_not_overwritten;
    file->pMethods = &store->guard.methods;
}

void store_watch_file(struct store *store)
{
    uint32_t page_bytes;
    if (!store->lock_fd || read_file_header(store, &store->header, &page_bytes) != MR_OK)
        store->header.file_bytes = 0;
    install_write_guard(store);
}

bool store_is_overwritten(struct store *store)
{
    const struct store_file_header known = store->header;
    struct store_file_header now;
    uint32_t page_bytes;
    int code = sqlite3_errcode(store->database) & 0xff;
    if (known.file_bytes == 0 || store->is_overwritten)
        return store->is_overwritten;
    enum mr_status status = read_file_header(store, &now, &page_bytes);
    int64_t size_min = (int64_t)now.page_count * page_bytes;
    /* The file is an older copy if its change counter is lower. It is truncated if it is shorter
     * than its header states and has become shorter; during a checkpoint it may be shorter for a
     * while. */
    store->is_overwritten =
        code == SQLITE_CORRUPT || code == SQLITE_NOTADB || status == MR_MALFORMED ||
        (status == MR_OK && (now.schema_cookie - known.schema_cookie > SCHEMA_COOKIE_STEP_MAX ||
                             now.change_counter - known.change_counter > INT32_MAX ||
                             (now.file_bytes < size_min && now.file_bytes < known.file_bytes)));
    if (status == MR_OK)
        store->header = now;
    return store->is_overwritten;
}

enum mr_status store_record_progress(struct store *store, int64_t session, struct error *error)
{
    enum mr_status status = store_frames_flush(store, error);
    store->session = session;
    return status == MR_OK ? STORE_READ_ONE(store, error, SESSION_PROGRESS,
                                            &store->pending_progress, STORE_BIND(session))
                           : status;
}

void store_confirm_progress(struct store *store)
{
    store->committed_progress = store->pending_progress;
}

enum mr_status store_has_session_data(struct store *store, bool *has, struct error *error)
{
    int64_t version = 0;
    struct store_session_progress now = {0};
    *has = true;
    enum mr_status status = STORE_READ_NUMBER(store, error, DATA_VERSION, &version);
    if (status != MR_OK || version == store->data_version || store->committed_progress.newest == 0)
        return status;
    status = STORE_READ_ONE(store, error, SESSION_PROGRESS, &now, STORE_BIND(store->session));
    *has = status == MR_OK && now.started_us == store->committed_progress.started_us &&
           now.newest >= store->committed_progress.newest;
    store->data_version = *has ? version : store->data_version;
    return status == MR_TOO_FEW ? MR_OK : status;
}

bool store_journal_rename(const char *path, const char *new_path)
{
    char journal[PATH_SIZE], index[PATH_SIZE];
    snprintf(journal, sizeof journal, "%s" JOURNAL_SUFFIX, path);
    snprintf(index, sizeof index, "%s" WAL_INDEX_SUFFIX, path);
    bool renamed = rename(journal, new_path) == 0;
    unlink(index);
    return renamed;
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
        return error_set(error, MR_IO, "cannot save the campaign (%s): %s; free space on the disk",
                         sqlite3_errmsg(copy), path);
    return MR_OK;
}

enum mr_status store_copy_to(struct store *store, const char *path, struct error *error)
{
    sqlite3 *copy = NULL;
    struct store *check = NULL;
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0)
        return error_set(error, MR_IO,
                         "cannot save the campaign (%s): %s; check the path and the permissions",
                         strerror(errno), path);
    close(fd);
    enum mr_status status = MR_OK;
    if (sqlite3_open_v2(path, &copy, SQLITE_OPEN_READWRITE, NULL) != SQLITE_OK)
        status = error_set(error, MR_IO,
                           "cannot save the campaign (%s): %s; check the path and the permissions",
                           sqlite3_errmsg(copy), path);
    if (status == MR_OK)
        status = copy_pages(store, copy, path, error);
    sqlite3_close(copy);
    if (status == MR_OK)
        status = store_open(path, STORE_READ, &check, error);
    store_close(check);
    if (status != MR_OK)
        unlink(path); /* remove the incomplete copy */
    return status;
}

void store_find_current_path(const struct store *store, char *out, size_t size)
{
    char link[40];
    static const char deleted[] = " (deleted)";
    snprintf(link, sizeof link, "/proc/self/fd/%d", store->lock_fd);
    ssize_t length = store->lock_fd && size > 0 ? readlink(link, out, size - 1) : -1;
    out[length > 0 ? length : 0] = '\0';
    size_t tail = sizeof deleted - 1;
    if ((size_t)length > tail && length > 0 && strcmp(out + length - tail, deleted) == 0)
        out[0] = '\0';
}

void store_close_detached(struct store *store, bool moved)
{
    if (moved) /* after a move, the file must be complete without its journal */
        sqlite3_wal_checkpoint_v2(store->database, "main", SQLITE_CHECKPOINT_TRUNCATE, NULL, NULL);
    /* prevent a checkpoint at closing: it would delete the journal at the old path, which may
     * belong to another campaign */
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL);
    store->checkpoint_at_close = false;
    store_close(store);
}

void store_journal_remove(const char *path, const struct store_file_identity *identity)
{
    char name[PATH_SIZE];
    struct stat info;
    if (!stat_with_suffix(path, JOURNAL_SUFFIX, &info) || info.st_ino != identity->journal_inode ||
        info.st_dev != identity->journal_device)
        return;
    snprintf(name, sizeof name, "%s" JOURNAL_SUFFIX, path);
    unlink(name);
    snprintf(name, sizeof name, "%s" WAL_INDEX_SUFFIX, path);
    unlink(name);
}
