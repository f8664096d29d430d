/* Paths of the command line: nothing that is read or written elsewhere is written over. */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "hil/arguments.h"
#include "hil/board/precious.h"

#define refuse(...) (hil_complain(__VA_ARGS__), MR_USAGE)

/* The path of a link or file with everything that can be resolved resolved; false: it has none. */
static bool canonical(const char *text, char *out)
{
    char folder[PATH_MAX], resolved[PATH_MAX];
    const char *path = !text || strcmp(text, "none") == 0                               ? NULL
                     : strncmp(text, "unix:", 5) == 0 || strncmp(text, "file:", 5) == 0 ? text + 5
                     : strncmp(text, "pty:", 4) == 0                                    ? text + 4
                                                                                        : text;
    if (!path || strlen(path) >= sizeof folder)
        return false;
    if (realpath(path, out))
        return true;
    const char *slash = strrchr(path, '/');
    snprintf(folder, sizeof folder, "%.*s", slash ? (int)(slash - path) + 1 : 1,
             slash ? path : ".");
    if (!realpath(folder, resolved))
        return false;
    return snprintf(out, PATH_MAX, "%s/%s", resolved, slash ? slash + 1 : path) < PATH_MAX;
}

/* By name, or as two names of one file. */
static bool same_file(const char *a, const char *b)
{
    struct stat one, other;
    return strcmp(a, b) == 0 || (stat(a, &one) == 0 && stat(b, &other) == 0 &&
                                 one.st_dev == other.st_dev && one.st_ino == other.st_ino);
}

/* A record takes the place of one of its kind only; what the first bytes of each are, the files say
 * that write them. */
static enum mr_status check_record(const struct hil_arguments *a, const char *option,
                                   const char *text, const char *path)
{
    const char *head = !text              ? NULL
                     : text == a->vcd     ? "$version matrig-board $end\n"
                     : text == a->profile ? "matrig-board profile: "
                     : text == a->margins ? "rule                  judged "
                                          : NULL;
    if (!head || !path[0])
        return MR_OK;
    if (hil_is_precious(path))
        return refuse("%s would overwrite a database or a program: %s; give another file", option,
                      path);
    if (!a->force && hil_is_another_file(path, head))
        return refuse("%s is there already, and is no record of this kind: %s; give another file, "
                      "or --force to lose this one",
                      option, path);
    return MR_OK;
}

struct named_path {
    const char *option, *text;
    char path[PATH_MAX];
};

/* The path itself, or none for what is not a file of its own. */
static void find_path(struct named_path *named)
{
    struct stat st;
    if (!canonical(named->text, named->path) ||
        (stat(named->path, &st) == 0 && S_ISCHR(st.st_mode)))
        named->path[0] = '\0';
}

enum { READ_ONLY = 4, PATHS = 12 }; /* read, and written too */

enum mr_status hil_arguments_check_paths(const struct hil_arguments *a)
{
    struct named_path given[PATHS] = {
        {"--elf", a->elf, ""},
        {"--rig", a->rig, ""},
        {"--replay", a->replay, ""},
        {"--faults", a->faults, ""},
        {"--can", a->can, ""},
        {"--serial", a->serial, ""},
        {"--gdb", a->gdb && strncmp(a->gdb, "unix:", 5) == 0 ? a->gdb : NULL, ""},
        {"--vcd", a->vcd, ""},
        {"--profile", a->profile, ""},
        {"--margins", a->margins, ""},
        {"--flash", a->flash, ""},
        {"--nor", a->nor, ""},
    };
    for (unsigned i = 0; i < PATHS; i++) {
        find_path(&given[i]);
        for (unsigned k = 0; i >= READ_ONLY && k < i; k++) {
            if (given[i].path[0] && given[k].path[0] && same_file(given[i].path, given[k].path))
                return refuse("%s and %s are both %s; give each its own", given[k].option,
                              given[i].option, given[i].path);
        }
        enum mr_status status = check_record(a, given[i].option, given[i].text, given[i].path);
        if (status != MR_OK)
            return status;
    }
    return MR_OK;
}
