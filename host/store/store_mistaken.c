/* What people name in a campaign's place. */
#include <ctype.h>
#include <dirent.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/base/near.h"
#include "host/store/store_sql.h"

/* "; did you mean spring.db?": of the files in its folder. */
static void find_near(const char *path, char out[static NEAR_TEXT])
{
    char *folder = strdup(path), *name = strdup(path), kept[256] = "";
    DIR *directory = folder && name ? opendir(dirname(folder)) : NULL;
    struct near near;
    struct dirent *entry;
    near_begin(&near, name ? basename(name) : "");
    while (directory && (entry = readdir(directory))) {
        const char *best = near.best;
        near_try(&near, entry->d_name);
        if (near.best != best)
            snprintf(kept, sizeof kept, "%s", entry->d_name);
        near.best = kept[0] ? kept : NULL;
    }
    near_text(&near, out);
    if (directory)
        closedir(directory);
    free(folder);
    free(name);
}

/* "(1795499961.967764) can0 1F0#04": a line of candump -L. */
static bool is_candump(const char *path)
{
    char head[40] = "";
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    ssize_t length = fd >= 0 ? read(fd, head, sizeof head - 1) : -1;
    if (fd >= 0)
        close(fd);
    return length > 4 && head[0] == '(' && isdigit((unsigned char)head[1]) && strstr(head, ") ");
}

enum mr_status store_mistaken(const char *path, bool made, struct error *error)
{
    struct stat info;
    char near[NEAR_TEXT] = "";
    if (stat(path, &info) != 0) {
        if (made)
            return MR_OK;
        find_near(path, near);
        return error_set(error, MR_IO,
                         "no such database: %s%s%s name a database that matrig log made", path,
                         near, near[0] ? "" : ";");
    }
    if (S_ISDIR(info.st_mode))
        return error_set(error, MR_IO, "a folder, no campaign database: %s; name a file in it",
                         path);
    if (S_ISREG(info.st_mode) && is_candump(path))
        return error_set(error, MR_MALFORMED,
                         "no campaign database, but a log: %s; matrig import DB %s takes it in",
                         path, path);
    return MR_OK;
}
