#include "host/base/data_dir.h"

#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const struct {
    const char *built;  /* relative to the folder of the program */
    const char *shared; /* below share/matrig; NULL: not installed */
} files[] = {
    [DATA_BOARD] = {"matrig-board", NULL},
    [DATA_FIRMWARE] = {"firmware/matrig.elf", "matrig.elf"},
    [DATA_RUNS] = {"../tests/runs", "runs"},
    [PLACE_DEMO] = {"../host/demo.sh", "demo.sh"},
    [DATA_RUNWAY] = {"../host/scenes/model_runway.json", "scenes/model_runway.json"},
};

static const char *program; /* NULL: the running program */

void data_dir_set_program(const char *path)
{
    program = path;
}

void data_dir_program(char *path, size_t size)
{
    ssize_t length = program ? -1 : readlink("/proc/self/exe", path, size - 1);
    if (length > 0)
        path[length] = '\0';
    else
        snprintf(path, size, "%s", program ? program : "matrig");
}

static void program_folder(char *folder, size_t size)
{
    data_dir_program(folder, size);
    char *slash = strrchr(folder, '/');
    if (slash)
        *slash = '\0';
    else
        snprintf(folder, size, ".");
}

/* True: the file is readable; `path` is then its resolved path. */
static bool try(char *path, size_t size, const char *folder, const char *below, const char *name)
{
    char candidate[PATH_MAX];
    int need = snprintf(candidate, sizeof candidate, "%s%s%s", folder, below, name);
    if (need >= (int)sizeof candidate || (size_t)need >= size || access(candidate, R_OK) != 0)
        return false;
    char *real = realpath(candidate, NULL);
    snprintf(path, size, "%s", real && strlen(real) < size ? real : candidate);
    free(real);
    return true;
}

static void find(const char *built, const char *shared, char *path, size_t size)
{
    char folder[PATH_MAX - 80];
    program_folder(folder, sizeof folder);
    if (try(path, size, folder, "/", built) ||
        (shared && try(path, size, folder, "/../share/matrig/", shared)))
        return;
    snprintf(path, size, "%s/%s", folder, built);
}

void data_dir_find(enum data_file what, char *path, size_t size)
{
    find(files[what].built, files[what].shared, path, size);
}

void data_dir_find_firmware(const char *board, char *path, size_t size)
{
    char built[60], shared[60];
    snprintf(built, sizeof built, "firmware/%s/matrig.elf", board);
    snprintf(shared, sizeof shared, "%s/matrig.elf", board);
    if (strcmp(board, "zg") == 0)
        data_dir_find(DATA_FIRMWARE, path, size);
    else
        find(built, shared, path, size);
}
