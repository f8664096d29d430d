#include "host/base/data_dir.h"

#include <limits.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const struct {
    const char *build_path; /* relative to the folder of the program */
    const char *share_path; /* relative to share/matrig; NULL: the file is not installed */
} data_files[] = {
    [DATA_BOARD_PROGRAM] = {"matrig-board", NULL},
    [DATA_FIRMWARE] = {"firmware/matrig.elf", "matrig.elf"},
    [DATA_RECORDED_LANDINGS] = {"../tests/runs", "runs"},
    [DATA_DEMO_SCRIPT] = {"../host/demo.sh", "demo.sh"},
    [DATA_RUNWAY_SCENE] = {"../host/scenes/model_runway.json", "scenes/model_runway.json"},
};

static const char *program_path; /* NULL: matrig is the running program */

void data_dir_set_program(const char *path)
{
    program_path = path;
}

void data_dir_program_path(char *path, size_t size)
{
    ssize_t length = program_path ? -1 : readlink("/proc/self/exe", path, size - 1);
    if (length > 0)
        path[length] = '\0';
    else
        snprintf(path, size, "%s", program_path ? program_path : "matrig");
}

static void get_program_folder(char *folder, size_t size)
{
    data_dir_program_path(folder, size);
    char *slash = strrchr(folder, '/');
    if (slash)
        *slash = '\0';
    else
        snprintf(folder, size, ".");
}

/* Makes the path of a file and returns true if the file is readable. */
static bool find_readable_path(char *path, size_t size, const char *folder, const char *below,
                               const char *name)
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

static void find_installed_file(const char *built, const char *shared, char *path, size_t size)
{
    char folder[PATH_MAX - 80];
    get_program_folder(folder, sizeof folder);
    if (find_readable_path(path, size, folder, "/", built) ||
        (shared && find_readable_path(path, size, folder, "/../share/matrig/", shared)))
        return;
    snprintf(path, size, "%s/%s", folder, built);
}

void data_dir_find(enum data_file what, char *path, size_t size)
{
    find_installed_file(data_files[what].build_path, data_files[what].share_path, path, size);
}

void data_dir_find_firmware(const char *board, char *path, size_t size)
{
    char built[60], shared[60];
    snprintf(built, sizeof built, "firmware/%s/matrig.elf", board);
    snprintf(shared, sizeof shared, "%s/matrig.elf", board);
    if (strcmp(board, "zg") == 0)
        data_dir_find(DATA_FIRMWARE, path, size);
    else
        find_installed_file(built, shared, path, size);
}
