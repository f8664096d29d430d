/* Files that host tests make, below build/test-tmp. */
#ifndef MATRIG_TESTS_HOST_SCRATCH_H
#define MATRIG_TESTS_HOST_SCRATCH_H

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/base/error.h"
#include "tests/cmocka_all.h"

static inline void scratch_begin(void)
{
    mkdir("build", 0777);
    mkdir("build/test-tmp", 0777);
}

/* A fresh path: nothing is there, neither a database's journal. */
static inline const char *scratch_path(char *out, size_t size, const char *name)
{
    char journal[300];
    scratch_begin();
    snprintf(out, size, "build/test-tmp/%s", name);
    unlink(out);
    snprintf(journal, sizeof journal, "%s-wal", out);
    unlink(journal);
    snprintf(journal, sizeof journal, "%s-shm", out);
    unlink(journal);
    return out;
}

static inline void scratch_write(const char *path, const void *bytes, size_t length)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, length, file), length);
    assert_int_equal(fclose(file), 0);
}

/* The error is this status, in one line that names `what`. */
static inline void assert_error(const struct error *error, enum mr_status status, const char *what)
{
    if (error->status != status || !strstr(error->text, what) || strchr(error->text, '\n'))
        fail_msg("status %d, expected %d; '%s' should name '%s' in one line", error->status, status,
                 error->text, what);
}

static inline void assert_no_error(const struct error *error)
{
    if (error->status != MR_OK)
        fail_msg("%s", error->text);
}

#endif
