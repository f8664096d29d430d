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

/* another program may hold the file; received data waits in the links meanwhile */
#define BUSY_WAIT_MS 30000
#define SET_UP_MS    20
#define READ_WAIT_MS 500

/* the largest value that matrig writes is an imported channel: 18 h at 1 kHz */
#define VALUE_BYTES_MAX 268435456

/* Settings of every connection to a campaign: the schema may come from elsewhere, so it is not
 * trusted and cannot be edited as a table. NULL: no connection. */
static void guard_settings(sqlite3 *database)
{
    if (!database)
        return;
    sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, VALUE_BYTES_MAX);
}

static enum mr_status pragma(struct store *store, const char *sql, int64_t *value,
                             struct error *error)
{
    sqlite3_stmt *statement;
    if (sqlite3_prepare_v2(store->database, sql, -1, &statement, NULL) != SQLITE_OK)
        return store_failed(store, "read", error);
    int code = sqlite3_step(statement);
    *value = code == SQLITE_ROW ? sqlite3_column_int64(statement, 0) : 0;
    enum mr_status status = code == SQLITE_ROW ? MR_OK : store_failed(store, "read", error);
    sqlite3_finalize(statement);
    return status;
}

/* Set up a new, empty file in one transaction. Other processes never see half a schema. If two set
 * up the same file at once, the second one finds it complete. */
static enum mr_status create_tables(struct store *store, struct error *error)
{
    char numbers[160];
    int64_t tables = 0;
    uint32_t own = 0; /* identifies the file for matrig log */
    if (getrandom(&own, sizeof own, 0) != (ssize_t)sizeof own)
        own = (uint32_t)time(NULL);
    snprintf(numbers, sizeof numbers,
             "PRAGMA application_id=%d; PRAGMA user_version=%d; PRAGMA schema_version=%u;",
             STORE_APPLICATION, STORE_VERSION, own >> 1);
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_DEFENSIVE, 0, NULL);
    enum mr_status status = store_execute(store, "BEGIN IMMEDIATE", "set up", error);
    if (status == MR_OK)
        status = pragma(store, "SELECT count(*) FROM sqlite_schema", &tables, error);
    if (status == MR_OK && tables == 0)
        status = store_tables_make(store->database, false) == SQLITE_OK
                   ? MR_OK
                   : store_failed(store, "set up", error);
    if (status == MR_OK && tables == 0)
        status = store_execute(store, numbers, "set up", error);
    if (status == MR_OK)
        status = store_execute(store, "COMMIT", "set up", error);
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    return status;
}

#define OBJECTS "SELECT type, name, tbl_name, sql FROM main.sqlite_schema"

static int count_changes(sqlite3 *database, const char *sql, sqlite3_stmt *row)
{
    sqlite3_stmt *s = NULL;
    sqlite3_prepare_v2(database, sql, -1, &s, NULL);
    for (int i = 0; i < 4; i++)
        sqlite3_bind_value(s, i + 1, sqlite3_column_value(row, i));
    bool done = sqlite3_step(s) == SQLITE_DONE;
    sqlite3_finalize(s);
    return done ? sqlite3_changes(database) : 0;
}

/* A schema can contain programs (a view that never ends, a trigger that runs at every row). So a
 * campaign must have exactly the schema of a fresh one. `what`: the first object that only one of
 * the two has. */
static bool has_same_schema(sqlite3 *database, char what[STORE_TEXT])
{
    sqlite3 *fresh = NULL;
    sqlite3_stmt *row = NULL;
    int code = sqlite3_open(":memory:", &fresh) | store_tables_make(fresh, false);
    if (store_has_late(database))
        code |= store_tables_make(fresh, true);
    code |= sqlite3_exec(fresh, "ANALYZE; CREATE TEMP TABLE known AS " OBJECTS, NULL, NULL, NULL) |
            sqlite3_prepare_v2(database, OBJECTS " ORDER BY type DESC", -1, &row, NULL);
    bool same = code == SQLITE_OK;
    while (same && (code = sqlite3_step(row)) == SQLITE_ROW)
        same = count_changes(
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
        store_text(row, 0, type, sizeof type);
        store_text(row, 1, name, sizeof name);
        snprintf(what, STORE_TEXT, "%s %s", type, name);
    } else {
        snprintf(what, STORE_TEXT, "%s", sqlite3_errmsg(database));
    }
    sqlite3_finalize(row);
    sqlite3_close(fresh);
    return same;
}

/* Call before anything else in the file is used. */
static enum mr_status refuse_foreign(struct store *store, struct error *error)
{
    char what[STORE_TEXT];
    if (has_same_schema(store->database, what))
        return MR_OK;
    return error_set(error, MR_MALFORMED,
                     "the tables of the campaign are not those of matrig (%s): %s; drop the "
                     "foreign tables with sqlite3, or use an earlier copy",
                     what, store->path);
}

/* Identification in a file. */
struct header {
    int64_t application, version, tables;
};

/* One transaction: a setup by another log is seen complete or not at all. */
static enum mr_status read_header(struct store *store, struct header *header, struct error *error)
{
    enum mr_status status = store_execute(store, "BEGIN", "read", error);
    if (status != MR_OK)
        return status;
    status = pragma(store, "PRAGMA application_id", &header->application, error);
    if (status == MR_OK)
        status = pragma(store, "PRAGMA user_version", &header->version, error);
    if (status == MR_OK)
        status = pragma(store, "SELECT count(*) FROM sqlite_schema", &header->tables, error);
    sqlite3_exec(store->database, "ROLLBACK", NULL, NULL, NULL); /* nothing was written */
    return status;
}

/* Name the matrig version that wrote the file; every version has the column sessions.matrig. */
static enum mr_status refuse_version(struct store *store, int64_t version, struct error *error)
{
    sqlite3_stmt *statement = NULL;
    char by[40] = "(unknown)";
    if (sqlite3_prepare_v2(store->database, "SELECT matrig FROM sessions ORDER BY id DESC LIMIT 1",
                           -1, &statement, NULL) == SQLITE_OK &&
        sqlite3_step(statement) == SQLITE_ROW)
        store_text(statement, 0, by, sizeof by);
    sqlite3_finalize(statement);
    return error_set(
        error, MR_VERSION,
        "campaign database of version %lld, written by matrig %s; this is matrig " VERSION_TEXT
        " and reads version %d: %s; use the matrig that wrote it",
        (long long)version, by, STORE_VERSION, store->path);
}

static enum mr_status check_version(struct store *store, enum store_mode mode, struct error *error)
{
    struct header header;
    enum mr_status status = read_header(store, &header, error);
    if (status != MR_OK)
        return status;
    if (mode == STORE_CREATE && header.application == 0 && header.version == 0 &&
        header.tables == 0) {
        status = create_tables(store, error);
        return status == MR_OK ? check_version(store, STORE_OPEN, error) : status;
    }
    if (header.application != STORE_APPLICATION)
        return error_set(error, MR_MALFORMED,
                         "not a campaign database: %s; give a database that matrig log created",
                         store->path);
    if (header.version != STORE_VERSION)
        return refuse_version(store, header.version, error);
    return refuse_foreign(store, error);
}

static enum mr_status open_file(struct store *store, const char *name, int flags,
                                enum store_mode mode, struct error *error)
{
    if (sqlite3_open_v2(name, &store->database, flags, NULL) != SQLITE_OK)
        return store_failed(store, "open", error);
    /* without file locks every file looks locked: find out quickly */
    bool first = (mode == STORE_READ || mode == STORE_SOURCE) && !store->waits;
    sqlite3_busy_timeout(store->database, first ? READ_WAIT_MS : BUSY_WAIT_MS);
    guard_settings(store->database);
    store_limit_steps(store);
    /* if it is another program's database, leave its journal alone */
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL);
    enum mr_status status = check_version(store, mode, error);
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, status != MR_OK, NULL);
    sqlite3_busy_timeout(store->database, BUSY_WAIT_MS);
    return status;
}

/* To read a campaign, SQLite creates files beside it and locks it. Where that fails, read a copy or
 * without locks. */
static enum mr_status open_again(struct store *store, enum store_mode mode,
                                 const struct error *first, struct error *error)
{
    char uri[STORE_PLACE_URI];
    const char *name = store->path;
    int refused = store->refused, flags = SQLITE_OPEN_READWRITE;
    if (refused != SQLITE_CANTOPEN && refused != SQLITE_READONLY && refused != SQLITE_IOERR &&
        refused != SQLITE_PROTOCOL && refused != SQLITE_BUSY && refused != SQLITE_FULL)
        return error_set(error, first->status, "%s", first->text);
    sqlite3_close(store->database);
    store->database = NULL;
    if (refused != SQLITE_BUSY || !store_place_has_locks(store->path)) {
        if (store_place_to_read(store->path, uri, store->folder, error) != MR_OK)
            return error->status;
        name = uri;
        flags |= SQLITE_OPEN_URI;
    }
    store->waits = true;
    return open_file(store, name, flags, mode, error);
}

/* Keep other logs out before anything is read or created. Of two logs that start at once, one does
 * all of it. The lock of flock(2) is independent of SQLite's locks. But SQLite's locks belong to
 * the process, and closing any descriptor of the file drops them, so this descriptor is closed
 * after the database. */
static enum mr_status take_alone(struct store *store, struct error *error)
{
    store->alone = open(store->path, O_RDONLY | O_CREAT | O_CLOEXEC, 0644);
    if (store->alone < 0) {
        store->alone = 0;
        return error_set(error, MR_IO, "cannot open (%s): %s; check the path and the permissions",
                         strerror(errno), store->path);
    }
    if (flock(store->alone, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        return error_set(error, MR_IO,
                         "another matrig log writes to this campaign: %s; end it first, or give a "
                         "different database",
                         store->path);
    return MR_OK;
}

/* Switch to the WAL journal. SQLite does not wait for its locks during this change, and another
 * program may be creating the same campaign, so retry. */
static enum mr_status keep_journal(struct store *store, struct error *error)
{
    const char sql[] = "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL;";
    for (int ms = 0; ms < BUSY_WAIT_MS; ms += SET_UP_MS) {
        struct error busy = {0};
        if (store_execute(store, sql, "set up", &busy) == MR_OK)
            return MR_OK;
        if (store->refused != SQLITE_BUSY)
            break;
        nanosleep(&(const struct timespec){.tv_nsec = SET_UP_MS * 1000000l}, NULL);
    }
    return store_execute(store, sql, "set up", error);
}

/* Names a database in the same folder: one that is spelled alike, else the first one. */
static enum mr_status no_such(const char *path, struct error *error)
{
    char folder[STORE_TEXT], best[NAME_MAX + 1] = "";
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
        return no_such(path, error);
    if (!output_is_database(path) && output_check_kind(path, "campaign database", error) != MR_OK)
        return error->status;
    struct store *made = calloc(1, sizeof *made);
    char *copy = strdup(path);
    if (!made || !copy) {
        free(made);
        free(copy);
        return error_set(error, MR_FULL, "out of memory, opening %s; close other programs", path);
    }
    made->path = copy;
    struct error first = {0},
                 failed = {0}; /* setting `error` may end the program, so close the store first */
    enum mr_status status = MR_OK;
    int flags = SQLITE_OPEN_READWRITE | (create ? SQLITE_OPEN_CREATE : 0);
    if (mode == STORE_OPEN || (create && strcmp(path, ":memory:") != 0))
        status = store_place_to_write(path, &failed);
    if (status == MR_OK && mode == STORE_LOG)
        status = take_alone(made, &failed);
    mode = create ? STORE_CREATE : mode;
    if (status == MR_OK && (mode == STORE_READ || mode == STORE_SOURCE)) {
        status = open_file(made, path, flags, mode, &first);
        if (status != MR_OK)
            status = open_again(made, mode, &first, &failed);
    } else if (status == MR_OK) {
        status = open_file(made, path, flags, mode, &failed);
    }
    if (status == MR_OK && mode == STORE_READ)
        status = store_execute(made, "PRAGMA query_only=1", "open", &failed);
    /* FULL: when a commit returns, it is on disk, not only in the kernel. On a read-only file
     * system the journal mode stays unchanged and reading works. */
    if (status == MR_OK && mode == STORE_CREATE)
        status = keep_journal(made, &failed);
    made->writes = status == MR_OK && mode == STORE_CREATE;
    if (status != MR_OK) {
        store_close(made);
        return error_set(error, status, "%s", failed.text);
    }
    *store = made;
    return MR_OK;
}

/* The descriptor stays open: closing it would drop SQLite's locks (take_alone). */
bool store_is_logged(struct store *store)
{
    if (!store->alone)
        store->alone = open(store->path, O_RDONLY | O_CLOEXEC);
    if (store->alone <= 0) {
        store->alone = 0;
        return false;
    }
    bool held = flock(store->alone, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK;
    if (!held)
        flock(store->alone, LOCK_UN);
    return held;
}

void store_close(struct store *store)
{
    if (!store)
        return;
    store_each_statement(store, sqlite3_finalize);
    /* write the journal back, so that a copy of the file alone is complete */
    if (store->writes && !store->overwritten) {
        sqlite3_busy_timeout(store->database, 0);
        sqlite3_wal_checkpoint_v2(store->database, "main", SQLITE_CHECKPOINT_TRUNCATE, NULL, NULL);
    }
    sqlite3_close(store->database);
    if (store->alone)
        close(store->alone);
    store_place_release(store->folder);
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
    store->made_room &= status != MR_OK;
    return status;
}

bool store_make_room(struct store *store)
{
    int frames = 0, back = 0;
    bool first = !store->made_room;
    store->made_room = true;
    return first &&
           sqlite3_wal_checkpoint_v2(store->database, "main", SQLITE_CHECKPOINT_PASSIVE, &frames,
                                     &back) == SQLITE_OK &&
           frames > 0 && back == frames;
}

/* ---- for matrig log ---- */

#define JOURNAL   "-wal"
#define INDEX     "-shm"
#define PATH_MOST 4096

void store_patience(struct store *store, int wait_ms)
{
    sqlite3_busy_timeout(store->database, wait_ms);
}

/* Refusal for a code of SQLite. */
static enum store_refusal refusal_of(int code)
{
    switch (code) {
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
    enum store_refusal refusal = store->grown ? STORE_GROWN : refusal_of(store->refused);
    store->refused = 0;
    store->grown = false;
    return refusal;
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
    if (stat_of(path, INDEX, &info))
        identity->index = info.st_ino;
}

enum store_place store_find(const char *path, const struct store_identity *identity)
{
    struct stat info;
    if (!stat_of(path, "", &info))
        /* an error other than these leaves open whether the file is there */
        return errno == ENOENT || errno == ENOTDIR ? STORE_MISSING : STORE_IN_PLACE;
    if (info.st_ino != identity->file || info.st_dev != identity->device)
        return STORE_REPLACED;
    if (identity->journal == 0)
        return STORE_IN_PLACE;
    if (!stat_of(path, JOURNAL, &info))
        return errno == ENOENT ? STORE_NO_JOURNAL : STORE_IN_PLACE;
    if (info.st_ino != identity->journal || info.st_dev != identity->journal_device)
        return STORE_NO_JOURNAL;
    bool index = stat_of(path, INDEX, &info) ? info.st_ino == identity->index : errno != ENOENT;
    return index || identity->index == 0 ? STORE_IN_PLACE : STORE_NO_INDEX;
}

/* Offsets in the file's header (https://sqlite.org/fileformat2.html, 1.3). */
enum { HEADER = 100, AT_PAGE_SIZE = 16, AT_COUNTER = 24, AT_PAGES = 28, AT_COOKIE = 40 };
enum { AT_VERSION = 60, AT_APPLICATION = 68 };
#define COOKIES 1000u /* a larger change is not plausible; a VACUUM adds 1 */

static uint32_t big_endian(const uint8_t *at)
{
    return (uint32_t)at[0] << 24 | (uint32_t)at[1] << 16 | (uint32_t)at[2] << 8 | at[3];
}

/* MR_IO: the disk fails; MR_MALFORMED: not a campaign. Reads with the descriptor that keeps other
 * logs out: closing a second descriptor would drop SQLite's locks of this process. */
static enum mr_status read_file_header(const struct store *store, struct store_header *header,
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

static int guarded_write(sqlite3_file *file, const void *bytes, int length, sqlite3_int64 at)
{
    const struct store_guard *guard = (const struct store_guard *)file->pMethods;
    return store_overwritten(guard->store) ? SQLITE_IOERR_WRITE
                                           : guard->plain->xWrite(file, bytes, length, at);
}

static int guarded_truncate(sqlite3_file *file, sqlite3_int64 length)
{
    const struct store_guard *guard = (const struct store_guard *)file->pMethods;
    return store_overwritten(guard->store) ? SQLITE_IOERR_TRUNCATE
                                           : guard->plain->xTruncate(file, length);
}

/* Check every write of SQLite for an overwritten file: a checkpoint takes long and can begin at any
 * time. */
static void guard_file(struct store *store)
{
    sqlite3_file *file = NULL;
    if (store->guard.plain ||
        sqlite3_file_control(store->database, "main", SQLITE_FCNTL_FILE_POINTER, &file) !=
            SQLITE_OK ||
        !file || !file->pMethods)
        return;
    store->guard = (struct store_guard){*file->pMethods, file->pMethods, store};
    store->guard.methods.xWrite = guarded_write;
    store->guard.methods.xTruncate = guarded_truncate;
    file->pMethods = &store->guard.methods;
}

void store_watch_file(struct store *store)
{
    uint32_t page_bytes;
    if (!store->alone || read_file_header(store, &store->header, &page_bytes) != MR_OK)
        store->header.bytes = 0;
    guard_file(store);
}

bool store_overwritten(struct store *store)
{
    const struct store_header known = store->header;
    struct store_header now;
    uint32_t page_bytes;
    int code = sqlite3_errcode(store->database) & 0xff;
    if (known.bytes == 0 || store->overwritten)
        return store->overwritten;
    enum mr_status status = read_file_header(store, &now, &page_bytes);
    int64_t least = (int64_t)now.pages * page_bytes;
    /* during a checkpoint the file is shorter than its header states; an older copy has a lower
     * counter */
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

bool store_journal_set_aside(const char *path, const char *kept)
{
    char journal[PATH_MOST], index[PATH_MOST];
    snprintf(journal, sizeof journal, "%s" JOURNAL, path);
    snprintf(index, sizeof index, "%s" INDEX, path);
    bool aside = rename(journal, kept) == 0;
    unlink(index);
    return aside;
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
        unlink(path); /* created here, and incomplete */
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
    if (moved) /* write the journal back, so that the file is complete at its new place */
        sqlite3_wal_checkpoint_v2(store->database, "main", SQLITE_CHECKPOINT_TRUNCATE, NULL, NULL);
    /* Otherwise closing would write the journal back and delete, by path, the journal of what may
     * be another campaign. */
    sqlite3_db_config(store->database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL);
    store->writes = false;
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
    snprintf(name, sizeof name, "%s" INDEX, path);
    unlink(name);
}
