/* What matrig log, which must not lose what comes, needs of the store beyond writing: to know
 * whether waiting helps, to write a transaction again, and to go on elsewhere when somebody has
 * taken the file away. Conventions as in store.h. */
#ifndef MATRIG_HOST_STORE_STORE_LOG_H
#define MATRIG_HOST_STORE_STORE_LOG_H

#include <sys/types.h>

#include "host/store/store.h"

/* Why writing failed, where it may succeed later. */
enum store_refusal {
    STORE_TAKES,  /* nothing failed, or waiting does not help */
    STORE_LOCKED, /* another program is writing */
    STORE_FULL,   /* no room on the disk */
    STORE_FAILS,  /* the disk or the file system says so */
};

/* Another program that writes is waited for so long in each call; else 30 s. */
void store_patience(struct store *store, int wait_ms);
/* Of the last call that failed, and forgets it. */
enum store_refusal store_take_refusal(struct store *store);
enum store_refusal store_refusal_of(int sqlite_code);
/* Takes back what was put since store_begin. Without a transaction nothing happens. */
void store_roll_back(struct store *store);

/* Where the file is, by its path, and what the store has open. */
enum store_place {
    STORE_IN_PLACE,
    STORE_MISSING,
    STORE_REPLACED,
    STORE_NO_JOURNAL,
    STORE_OVERWRITTEN,
    STORE_EMPTIED
};
struct store_identity {
    dev_t device, journal_device;
    ino_t file, journal;
};
/* Of what is at the path just after opening and store_take_alone. */
void store_identify(const char *path, struct store_identity *identity);
enum store_place store_find(const char *path, const struct store_identity *identity);

/* Copies all that is committed, from the open file wherever it is, into the new file at `path`, and
 * opens that to check it. MR_IO: also when something is there already. */
enum mr_status store_copy_to(struct store *store, const char *path, struct error *error);
/* The path where the open file is now, as far as the system knows; "": deleted. */
void store_whereabouts(const struct store *store, char *out, size_t size);
/* As store_close, of a store whose file was taken away: what is at its path belongs to somebody
 * else, and is not touched. `moved`: the open file itself is the log's: the journal is written back
 * into it. */
void store_leave(struct store *store, bool moved);
/* After it: the file's journal at the old path, which SQLite would write into whatever is put
 * there. One of another file stays. */
void store_journal_remove(const char *path, const struct store_identity *identity);

/* ---- whether the file is what was logged ---- */

/* Looked at from now on; after store_take_alone. */
void store_watch_file(struct store *store);
/* Somebody overwrote the file past SQLite (cp) or made it shorter: by its header and size, or
 * SQLite finds it damaged. Once true, it stays so. */
bool store_overwritten(struct store *store);
/* Before a commit: what is the newest of the session now. After it. */
enum mr_status store_note_logged(struct store *store, int64_t session, struct error *error);
void store_logged_committed(struct store *store);
/* In a transaction, when another program has committed since the last one: `*there` false: what was
 * committed of the session is no longer in the campaign. */
enum mr_status store_session_there(struct store *store, bool *there, struct error *error);
/* After store_leave of such a file: its journal gets the name `kept`, because SQLite would write it
 * into what is in the file now. */
void store_journal_aside(const char *path, const char *kept);

#endif
