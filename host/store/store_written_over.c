/* Whether what is in the campaign's file is what was logged into it.
 *
 * With a journal (WAL), only a checkpoint writes into the file itself, and the index of the journal
 * says of each checkpoint, before it writes, up to where it goes
 * (https://sqlite.org/walformat.html, 2.4). So a file that has changed while neither the log nor
 * the index knows of a checkpoint was written by somebody who went past SQLite: cp over it, dd, a
 * truncation. It keeps its inode, and SQLite would go on as if nothing had happened: pages of two
 * campaigns in one file. What somebody replaces by SQLite (.restore) is found by what was logged
 * and is not there.
 *
 * The descriptor that keeps other logs out is read: opening and closing another one would take
 * SQLite's locks away from this process. */
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/store/store_log.h"
#include "host/store/store_sql.h"

#define CHECKPOINT_PAGES 1000  /* of the journal, as SQLite's own */
#define INDEX_BYTES      32768 /* of its first part */
enum { INDEX_SALT = 32 / 4, INDEX_DONE = 96 / 4, INDEX_BEGUN = 128 / 4 }; /* where its words are */

static struct store_checkpoints checkpoints_of(const struct store_file_look *look)
{
    struct store_checkpoints known = {.begun = 0};
    const volatile uint32_t *index = look->index;
    if (index)
        known = (struct store_checkpoints){index[INDEX_SALT], index[INDEX_DONE],
                                           index[INDEX_BEGUN]};
    return known;
}

static size_t read_first_page(const struct store *store, uint8_t page[STORE_FIRST_PAGE])
{
    ssize_t length = pread(store->alone, page, STORE_FIRST_PAGE, 0);
    return length > 0 ? (size_t)length : 0;
}

static void remember(struct store *store, const struct stat *info, struct store_checkpoints known)
{
    struct store_file_look *look = &store->look;
    look->bytes = info->st_size;
    look->written = info->st_mtim;
    look->known = known;
    look->first_page_bytes = read_first_page(store, look->first_page);
}

static bool as_before(const struct store_file_look *look, const struct stat *info)
{
    return info->st_size == look->bytes && info->st_mtim.tv_sec == look->written.tv_sec &&
           info->st_mtim.tv_nsec == look->written.tv_nsec;
}

bool store_written_over(struct store *store)
{
    struct store_file_look *look = &store->look;
    struct stat info;
    int code = sqlite3_errcode(store->database) & 0xff;
    /* It was whole when it was opened. A copy that lands in a checkpoint of our own passes for one;
     * what is read of it then is no campaign. */
    look->written_over |= look->on && (code == SQLITE_CORRUPT || code == SQLITE_NOTADB);
    if (!look->on || look->written_over || fstat(store->alone, &info) != 0)
        return look->written_over;
    /* after the file: a checkpoint is told before it writes */
    struct store_checkpoints now = checkpoints_of(look), known = look->known;
    bool by_sqlite = now.salt != known.salt || now.done != known.done || now.begun != known.begun ||
                     now.done < now.begun;
    if (as_before(look, &info))
        look->known = now;
    else if (by_sqlite)
        remember(store, &info, now);
    else
        look->written_over = true;
    return look->written_over;
}

/* In place of SQLite's own: the file is looked at before, and what the checkpoint makes of it is
 * known. */
static int after_commit(void *context, sqlite3 *database, const char *name, int pages)
{
    struct store *store = context;
    struct stat info;
    if (pages < CHECKPOINT_PAGES || store_written_over(store))
        return SQLITE_OK;
    /* what fails is done by the next one */
    sqlite3_wal_checkpoint_v2(database, name, SQLITE_CHECKPOINT_PASSIVE, NULL, NULL);
    if (fstat(store->alone, &info) == 0)
        remember(store, &info, checkpoints_of(&store->look));
    return SQLITE_OK;
}

/* The index as SQLite has mapped it. */
static const volatile uint32_t *index_of(sqlite3 *database)
{
    sqlite3_file *file = NULL;
    void volatile *index = NULL;
    if (sqlite3_file_control(database, "main", SQLITE_FCNTL_FILE_POINTER, &file) != SQLITE_OK ||
        !file || !file->pMethods || file->pMethods->iVersion < 2 ||
        file->pMethods->xShmMap(file, 0, INDEX_BYTES, 0, &index) != SQLITE_OK)
        return NULL;
    return index;
}

/* A file system without shared memory has none. */
static bool has_journal(sqlite3 *database)
{
    sqlite3_stmt *s = NULL;
    bool wal = sqlite3_prepare_v2(database, "PRAGMA journal_mode", -1, &s, NULL) == SQLITE_OK &&
               sqlite3_step(s) == SQLITE_ROW &&
               strcmp((const char *)sqlite3_column_text(s, 0), "wal") == 0;
    sqlite3_finalize(s);
    /* which opens it */
    return wal && sqlite3_exec(database, "SELECT count(*) FROM sqlite_schema", NULL, NULL, NULL) ==
                      SQLITE_OK;
}

void store_watch_file(struct store *store)
{
    struct store_file_look *look = &store->look;
    struct stat info;
    if (!store->alone || !has_journal(store->database))
        return;
    look->index = index_of(store->database);
    if (!look->index || fstat(store->alone, &info) != 0)
        return;
    remember(store, &info, checkpoints_of(look));
    look->on = true;
    sqlite3_wal_hook(store->database, after_commit, store);
}

bool store_is_anothers(const struct store *store)
{
    uint8_t page[STORE_FIRST_PAGE];
    const struct store_file_look *look = &store->look;
    return look->on && (read_first_page(store, page) != look->first_page_bytes ||
                        memcmp(page, look->first_page, look->first_page_bytes) != 0);
}

void store_journal_aside(const char *path, const char *kept)
{
    char journal[4200], index[4200];
    snprintf(journal, sizeof journal, "%s-wal", path);
    snprintf(index, sizeof index, "%s-shm", path);
    if (link(journal, kept) == 0 || access(journal, F_OK) != 0)
        unlink(journal);
    else
        rename(journal, kept); /* a file system without links */
    unlink(index);
}

/* ---- what was logged ---- */

enum mr_status store_note_newest(struct store *store, int64_t session, struct error *error)
{
    struct store_newest *next = &store->look.next;
    struct store_newest_frame frame;
    enum mr_status status = store_frames_flush(store, error);
    *next = store->look.newest;
    next->session = session;
    if (status == MR_OK)
        status = STORE_ONE(store, error, FRAME_LAST, &frame);
    if (status == MR_OK && frame.session == session)
        next->frame = frame.id;
    return status == MR_TOO_FEW ? MR_OK : status;
}

void store_newest_committed(struct store *store)
{
    store->look.newest = store->look.next;
}

#define NEWEST_THERE                                                                              \
    "SELECT EXISTS(SELECT 1 FROM sessions WHERE id=?1) AND (?2=0 OR EXISTS(SELECT 1 FROM frames " \
    "WHERE id=?2 AND session=?1))"

/* SQLite's code of the query; SQLITE_ROW with `*there`. */
static int ask(sqlite3 *database, const struct store_newest *newest, bool *there)
{
    sqlite3_stmt *s = NULL;
    int code = sqlite3_prepare_v2(database, NEWEST_THERE, -1, &s, NULL);
    if (code == SQLITE_OK) {
        sqlite3_bind_int64(s, 1, newest->session);
        sqlite3_bind_int64(s, 2, newest->frame);
        code = sqlite3_step(s);
        *there = code == SQLITE_ROW && sqlite3_column_int(s, 0) != 0;
    }
    sqlite3_finalize(s);
    return code & 0xff;
}

enum mr_status store_session_there(struct store *store, bool *there, struct error *error)
{
    struct store_file_look *look = &store->look;
    int64_t version = 0;
    *there = true;
    enum mr_status status = STORE_NUMBER(store, error, DATA_VERSION, &version);
    if (status != MR_OK || version == look->version || look->newest.session == 0)
        look->version = status == MR_OK ? version : look->version;
    else if (ask(store->database, &look->newest, there) != SQLITE_ROW)
        status = store_failed(store, "read", error);
    else
        look->version = *there ? version : look->version;
    return status;
}

bool store_session_there_afresh(struct store *store)
{
    sqlite3 *fresh = NULL;
    bool there = false;
    int code = sqlite3_open_v2(store->path, &fresh, SQLITE_OPEN_READONLY, NULL);
    sqlite3_busy_timeout(fresh, 5000);
    if (code == SQLITE_OK)
        code = ask(fresh, &store->look.newest, &there);
    sqlite3_close(fresh);
    return there || (code != SQLITE_ROW && code != SQLITE_CORRUPT && code != SQLITE_NOTADB &&
                     code != SQLITE_ERROR);
}
