/* A bundle: one landing with what it takes to replay it on a machine that has nothing but matrig
 * and matrig-board, in one file.
 *
 * The file is an SQLite database: a campaign in which the landing is RUN 1 (host/store/store.h),
 * and beside its tables
 *
 *     sqlar             the files of bundle_files, in SQLite's archive layout
 *                       (https://sqlite.org/sqlar.html): `sqlite3 F -Atv` lists them, `sqlite3 F
 *                       -Ax` extracts them; data is zlib's, or as it is where that is not shorter
 *     bundle_manifest   a row for each file, each table, and for the schema: name, kind (file,
 *                       table, schema), bytes, what it is, SHA-256
 *     bundle_seal       one row: BUNDLE_SEAL and 64 hexadecimal digits, the SHA-256 of the whole
 *                       file with these digits as zeros
 *
 * The files come first in it, the frames and blocks last, so that a file cut off still has page,
 * candump log and image. What is hashed of a table: for each column its name as a text, then for
 * each row in the order of the primary key each value: a letter N, I, R, T or B; for I its 8 bytes
 * and for R those of the double; for T and B its length in 8 bytes and its bytes; low byte first
 * throughout. Of the schema: name and SQL of every table, index and trigger, in order of type and
 * name, as texts. A bundle is checked against damage, not against forgery: whoever changes it can
 * also change the digests. */
#ifndef MATRIG_HOST_BUNDLE_BUNDLE_H
#define MATRIG_HOST_BUNDLE_BUNDLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "host/store/store.h"

#define BUNDLE_BYTES_MAX 10000000u /* of a bundle that is made */
#define BUNDLE_READ_MAX  67108864u /* of a file that is read as one */
#define BUNDLE_FILE_MAX  33554432u /* of a file in it, unpacked */
/* files, tables and schema; what is beyond them is told as too many */
#define BUNDLE_PARTS_MAX 160u
#define BUNDLE_NAME      64u
#define BUNDLE_DIGEST    65u /* hexadecimal digits of a SHA-256, and a NUL */
#define BUNDLE_SEAL      "SHA-256 of this file with these 64 digits as zeros: "

enum bundle_file {
    BUNDLE_PAGE,
    BUNDLE_CANDUMP,
    BUNDLE_CONFIGURATION,
    BUNDLE_SCENE,
    BUNDLE_FIRMWARE,
    BUNDLE_FILES
};

struct bundle_file_info {
    const char *name;   /* in the archive */
    const char *option; /* for --without */
    const char *what;
};
extern const struct bundle_file_info bundle_files[BUNDLE_FILES];

/* ---- making one ---- */

struct bundle_want {
    const char *elf; /* the image; must be the one that recorded the landing */
    /* used when the landing was not compared; then the scene of the newest comparison goes in */
    const char *scene;
    bool without[BUNDLE_FILES];
    bool force; /* in place of whatever bundle is there (host/base/output.h) */
};
struct bundle_made {
    size_t bytes;
    size_t file_bytes[BUNDLE_FILES]; /* unpacked; 0: not in it */
    char why_not[BUNDLE_FILES][120]; /* of those: the reason */
    char digest[BUNDLE_DIGEST];      /* of its seal */
};
/* Writes `path`, which must not be there yet; on failure nothing is. MR_USAGE: it is there, or no
 * such RUN, or the image is not the one that the board told when it was logged; MR_IO; MR_TOO_LONG:
 * over BUNDLE_BYTES_MAX, with the largest part and what to leave out. */
enum mr_status bundle_make(struct store *store, int64_t run, const struct bundle_want *want,
                           const char *path, struct bundle_made *made, struct error *error);

/* ---- reading one ---- */

enum bundle_state {
    BUNDLE_WHOLE,
    BUNDLE_CHANGED, /* its digest is another */
    BUNDLE_LOST,    /* in the manifest, not or not wholly in the file */
    BUNDLE_FOREIGN  /* in the file, not in the manifest, or not what a bundle may hold */
};
struct bundle_part {
    char name[BUNDLE_NAME]; /* printable */
    char kind[8];
    char what[200];
    char digest[BUNDLE_DIGEST]; /* as the manifest says */
    int64_t bytes;              /* hashed */
    int64_t rows;               /* of a table */
    enum bundle_state state;
    char why[160]; /* unless whole */
};
struct bundle; /* an opened one: in memory, nothing of it is on disk */

struct bundle_check {
    const char *path;
    size_t bytes;         /* of the file */
    uint64_t whole_bytes; /* that it had when it was made, as its header says */
    bool sealed;          /* every byte is as it was sealed */
    bool truncated;
    bool aside;        /* a journal of SQLite lies beside it: it was opened for writing */
    size_t parts, bad; /* `bad` of them are not whole */
    struct bundle_part part[BUNDLE_PARTS_MAX];
};

/* Reads the file and checks every part. MR_OK also when parts are damaged: `check` says which.
 * MR_IO; MR_TOO_LONG; MR_MALFORMED: no bundle, or nothing of it can be read; then `*bundle` is
 * NULL. */
enum mr_status bundle_open(const char *path, struct bundle **bundle, struct bundle_check *check,
                           struct error *error);
/* The same of bytes in memory, which are copied. */
enum mr_status bundle_open_bytes(const char *path, const uint8_t *bytes, size_t size,
                                 struct bundle **bundle, struct bundle_check *check,
                                 struct error *error);
void bundle_close(struct bundle *bundle);

/* True when every part is whole: it can be replayed. */
bool bundle_sound(const struct bundle_check *check);
/* One line: complete, truncated or changed, and where. */
void bundle_verdict(const struct bundle_check *check, char *text, size_t size);

/* Writes those files that are whole into a folder that is there; what is there already, and is not
 * what matrig wrote, only with `force`. `saved[i]`: it was. Only names of bundle_files are ever
 * written, never one from the archive. */
enum mr_status bundle_save(struct bundle *bundle, const struct bundle_check *check,
                           const char *folder, bool force, bool saved[BUNDLE_FILES],
                           struct error *error);
/* Writes one of them, or the whole database, as `path`, which must not be there. */
enum mr_status bundle_save_file(struct bundle *bundle, enum bundle_file file, const char *path,
                                struct error *error);
enum mr_status bundle_save_campaign(struct bundle *bundle, const char *path, struct error *error);

#endif
