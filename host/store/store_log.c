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

enum mr_status store_held_get(struct store *store, int64_t run, struct store_held *held,
                              struct error *error)
{
    sqlite3_stmt *s;
    struct store_held_part row;
    *held = (struct store_held){.permille = 0};
    enum mr_status status = STORE_QUERY(store, error, HELD, &s, BIND(run));
    while (status == MR_OK && (status = STORE_NEXT(store, error, HELD, s, &row)) == MR_OK) {
        if (row.cause >= 0 && row.cause < STORE_HELD_CAUSES)
            held->us[row.cause] = row.us;
        held->permille = row.permille > held->permille ? row.permille : held->permille;
    }
    return status == MR_TOO_FEW ? MR_OK : status;
}

const char *store_held_text(enum store_held_cause cause)
{
    static const char *const texts[STORE_HELD_CAUSES] = {"another program held the campaign",
                                                         "the disk was slow", "the disk was full",
                                                         "the disk took nothing"};
    return cause < STORE_HELD_CAUSES ? texts[cause] : "unknown";
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

void store_leave(struct store *store)
{
    /* Closing would else write the journal back, and delete by its path what may be another
     * campaign's. */
    if (store)
        sqlite3_db_config(store->database, SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1, NULL);
    store_close(store);
}

void store_journal_away(const char *path, const char *now, const struct store_identity *identity)
{
    char journal[PATH_MOST], index[PATH_MOST], moved[PATH_MOST];
    struct stat info;
    bool ours = stat_of(path, JOURNAL, &info) && info.st_ino == identity->journal &&
                info.st_dev == identity->journal_device;
    if (!ours || (stat_of(path, "", &info) && info.st_ino == identity->file &&
                  info.st_dev == identity->device))
        return;
    if (snprintf(journal, sizeof journal, "%s" JOURNAL, path) >= PATH_MOST ||
        snprintf(index, sizeof index, "%s-shm", path) >= PATH_MOST ||
        snprintf(moved, sizeof moved, "%s" JOURNAL, now) >= PATH_MOST)
        return;
    if (now[0])
        (void)link(journal, moved); /* never over one that is there */
    unlink(journal);
    unlink(index);
}
