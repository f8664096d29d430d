#include "host/commands/studies.h"
#include "host/base/xmalloc.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/version.h"
#include "host/base/command.h"
#include "host/base/data_dir.h"
#include "host/commands/program.h"

#define NAME "matrig-study"

static bool try(char *path, size_t size, const char *folder, size_t length, const char *below)
{
    struct stat file;
    int need = snprintf(path, size, "%.*s%s" NAME, (int)length, folder, below);
    return need > 0 && (size_t)need < size && stat(path, &file) == 0 && S_ISREG(file.st_mode) &&
           access(path, X_OK) == 0;
}

/* Where matrig-study is: beside the matrig of this path, else in ../libexec/matrig from there, else
 * in the first folder of `search` that has it (as PATH; empty ones are left out; NULL: none).
 * False: nowhere. */
static bool study_find(const char *matrig, const char *search, char *path, size_t size)
{
    const char *slash = strrchr(matrig, '/');
    size_t length = slash ? (size_t)(slash - matrig) : 0;
    if (slash && (try(path, size, matrig, length, "/") ||
                  try(path, size, matrig, length, "/../libexec/matrig/")))
        return true;
    while (search && *search) {
        length = strcspn(search, ":");
        if (length > 0 && try(path, size, search, length, "/"))
            return true;
        search += length + (search[length] == ':');
    }
    return false;
}

static int fail(const char *command, const char *why)
{
    struct error error = {0};
    error_set(&error, MR_IO,
              "cannot start " NAME ", which runs matrig %s: %s; make all builds it, make install "
              "or the package matrig-study puts it where matrig "
              "looks",
              command, why);
    return cli_fail(&error);
}

int study_start(int argc, char **argv, const struct cli *cli)
{
    char matrig[PATH_MAX], path[PATH_MAX], why[PATH_MAX + 100];
    char **words = xcalloc(4 + command_matrig.count + (size_t)argc + 1, sizeof *words);
    size_t count = 0;
    data_dir_program(matrig, sizeof matrig);
    if (!study_find(matrig, getenv("PATH"), path, sizeof path)) {
        free(words);
        snprintf(why, sizeof why, "not beside %s, not in ../libexec/matrig from there, not on PATH",
                 matrig);
        return fail(argv[0], why);
    }
    words[count++] = NAME;
    words[count++] = STUDY_STARTED_BY;
    words[count++] = (char *)VERSION_TEXT;
    words[count++] = matrig;
    count += program_options((const char **)words + count, cli);
    memcpy(words + count, argv, (size_t)argc * sizeof *argv);
    fflush(NULL);
    execv(path, words);
    snprintf(why, sizeof why, "%s (%s)", path, strerror(errno));
    free(words);
    return fail(argv[0], why);
}
