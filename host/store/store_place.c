/* Checks of a campaign's file system, and reading of a campaign that SQLite cannot open in the
 * normal way: on read-only media, in another user's folder, in a snapshot, on a network drive
 * without locks. */
#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <limits.h>
#include <mntent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/store/store.h"
#include "host/store/table.h"

#define PROBE_MAPPING_BYTES 4096
#define COPY_BUFFER_BYTES   (1024 * 1024)

static void get_folder(const char *path, char folder[PATH_MAX])
{
    snprintf(folder, PATH_MAX, "%s", path);
    char *name = dirname(folder);
    if (name != folder)
        memmove(folder, name, strlen(name) + 1);
}

void store_describe_file_system(const char *path, char out[STORE_TEXT_SIZE])
{
    char folder[PATH_MAX], real[PATH_MAX];
    size_t longest = 0;
    struct mntent *mount;
    FILE *mounts = setmntent("/proc/self/mounts", "r");
    get_folder(path, folder);
    snprintf(out, STORE_TEXT_SIZE, "file system unknown");
    while (mounts && realpath(folder, real) && (mount = getmntent(mounts))) {
        size_t length = strcmp(mount->mnt_dir, "/") == 0 ? 0 : strlen(mount->mnt_dir);
        if (length < longest || strncmp(real, mount->mnt_dir, length) != 0 ||
            (real[length] != '/' && real[length] != '\0'))
            continue;
        longest = length;
        snprintf(out, STORE_TEXT_SIZE, "%.60s at %.120s", mount->mnt_type, mount->mnt_dir);
    }
    if (mounts)
        endmntent(mounts);
}

/* Finds the process that has locked a file for writing, from /proc/locks; 0: none. */
static int find_lock_holder(ino_t file)
{
    char line[200], kind[16];
    int holder = 0;
    FILE *locks = fopen("/proc/locks", "r");
    while (locks && holder == 0 && fgets(line, sizeof line, locks)) {
        int pid;
        unsigned major, minor;
        unsigned long inode;
        if (sscanf(line, "%*d: %*s %*s %15s %d %x:%x:%lu", kind, &pid, &major, &minor, &inode) ==
                5 &&
            inode == file && strcmp(kind, "WRITE") == 0 && pid > 0 && pid != getpid())
            holder = pid;
    }
    if (locks)
        fclose(locks);
    return holder;
}

void store_describe_lock_holder(const char *path, char out[STORE_TEXT_SIZE])
{
    static const char *const locked[] = {"-shm", ""};
    char name[PATH_MAX];
    struct stat info;
    int pid = 0;
    for (unsigned i = 0; i < 2 && pid == 0; i++) {
        snprintf(name, sizeof name, "%s%s", path, locked[i]);
        pid = stat(name, &info) == 0 ? find_lock_holder(info.st_ino) : 0;
    }
    snprintf(out, STORE_TEXT_SIZE, "another program is writing to the campaign");
    if (pid == 0)
        return;
    char command[40] = "";
    snprintf(name, sizeof name, "/proc/%d/comm", pid);
    FILE *file = fopen(name, "r");
    if (file) {
        if (fgets(command, sizeof command, file))
            command[strcspn(command, "\n")] = '\0';
        fclose(file);
    }
    snprintf(out, STORE_TEXT_SIZE, "process %d%s%s has locked the campaign", pid,
             command[0] ? ", " : "", command);
}

/* Checks whether the file system has the two functions that SQLite needs, locks and shared memory.
 * Returns the name of the missing one (NULL: none), and its error number. */
static const char *probe_file_system(int fd, int *number)
{
    struct flock lock = {.l_type = F_WRLCK, .l_whence = SEEK_SET, .l_len = 1};
    *number = 0;
    if (fcntl(fd, F_SETLK, &lock) != 0 && errno != EAGAIN && errno != EACCES) {
        *number = errno;
        return "locks";
    }
    void *shared = MAP_FAILED;
    if (ftruncate(fd, PROBE_MAPPING_BYTES) == 0) {
        shared = mmap(NULL, PROBE_MAPPING_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
        /* ignore ENOMEM, which is not an error of the file system */
        *number = shared == MAP_FAILED && errno != ENOMEM ? errno : 0;
    }
    if (shared != MAP_FAILED)
        munmap(shared, PROBE_MAPPING_BYTES);
    return *number ? "shared memory" : NULL;
}

enum mr_status store_check_writable(const char *path, struct error *error)
{
    char folder[PATH_MAX], name[PATH_MAX + 40], system[STORE_TEXT_SIZE];
    int number = 0;
    get_folder(path, folder);
    bool exists = access(path, F_OK) == 0;
    if ((exists && access(path, W_OK) != 0) || access(folder, W_OK | X_OK) != 0) {
        number = errno;
        store_describe_file_system(path, system);
        return error_set(error, MR_IO, "cannot write (%s; %s): %s; %s", strerror(number), system,
                         path,
                         exists ? "matrig show, report and export can read the campaign; to write "
                                  "to the campaign, copy it to a writable folder"
                                : "give a writable folder");
    }
    snprintf(name, sizeof name, "%s/.matrig-probe-%ld", folder, (long)getpid());
    int fd = open(name, O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0)
        return MR_OK; /* without a known reason: SQLite reports the error later */
    const char *lacks = probe_file_system(fd, &number);
    close(fd);
    unlink(name);
    if (!lacks)
        return MR_OK;
    store_describe_file_system(path, system);
    return error_set(error, MR_IO,
                     "a campaign needs %s, which this file system does not provide (%s; %s): %s; "
                     "log to a local disk and copy the campaign afterwards",
                     lacks, strerror(number), system, path);
}

bool store_has_file_locks(const char *path)
{
    struct flock lock = {.l_type = F_RDLCK, .l_whence = SEEK_SET, .l_len = 1};
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    bool locks = fd < 0 || fcntl(fd, F_GETLK, &lock) == 0;
    if (fd >= 0)
        close(fd);
    return locks;
}

/* ---- reading without locks, or from a copy ---- */

static bool has_content(const char *path, const char *suffix)
{
    char name[PATH_MAX];
    struct stat info;
    snprintf(name, sizeof name, "%s%s", path, suffix);
    return stat(name, &info) == 0 && info.st_size > 0;
}

static int copy_file(const char *path, const char *suffix, const char *folder, int *number)
{
    char from[PATH_MAX], to[PATH_MAX];
    snprintf(from, sizeof from, "%s%s", path, suffix);
    snprintf(to, sizeof to, "%s/copy%s", folder, suffix);
    int in = open(from, O_RDONLY | O_CLOEXEC), out = -1;
    char *bytes = malloc(COPY_BUFFER_BYTES);
    ssize_t length = -1;
    if (in >= 0 && bytes)
        out = open(to, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    while (out >= 0 && (length = read(in, bytes, COPY_BUFFER_BYTES)) > 0) {
        if (write(out, bytes, (size_t)length) != length) {
            length = -1;
            break;
        }
    }
    *number = length == 0 ? 0 : errno;
    free(bytes);
    if (in >= 0)
        close(in);
    if (out >= 0)
        close(out);
    return *number == 0;
}

static const char *const copied_suffixes[] = {"", "-wal", "-journal", "-shm"};

/* Copies the campaign with its journal into a new temporary folder. */
static enum mr_status copy_to_temporary(const char *path, char folder[STORE_TEXT_SIZE],
                                        struct error *error)
{
    const char *temporary = getenv("TMPDIR");
    int number = 0;
    snprintf(folder, STORE_TEXT_SIZE, "%.150s/matrig-read-XXXXXX", temporary ? temporary : "/tmp");
    if (!mkdtemp(folder))
        return error_set(
            error, MR_IO,
            "cannot create a folder for a copy (%s): %s; set TMPDIR to a writable folder",
            strerror(errno), folder);
    for (unsigned i = 0; i < 3; i++) {
        if ((i == 0 || has_content(path, copied_suffixes[i])) &&
            !copy_file(path, copied_suffixes[i], folder, &number))
            return error_set(error, MR_IO,
                             "cannot be copied for reading (%s): %s; free space in %s",
                             strerror(number), path, folder);
    }
    return MR_OK;
}

void store_remove_read_copy(const char folder[STORE_TEXT_SIZE])
{
    char name[PATH_MAX];
    for (unsigned i = 0; folder[0] && i < sizeof copied_suffixes / sizeof copied_suffixes[0]; i++) {
        snprintf(name, sizeof name, "%s/copy%s", folder, copied_suffixes[i]);
        unlink(name);
    }
    if (folder[0])
        rmdir(folder);
}

enum mr_status store_make_read_uri(const char *path, char uri[STORE_URI_SIZE],
                                   char folder[STORE_TEXT_SIZE], struct error *error)
{
    char real[PATH_MAX], copy[STORE_TEXT_SIZE + 8];
    const char *at = realpath(path, real);
    bool journal = has_content(path, "-wal") || has_content(path, "-journal");
    folder[0] = '\0';
    if (!at)
        return error_set(error, MR_IO, "cannot open (%s): %s; check the path", strerror(errno),
                         path);
    if (journal && copy_to_temporary(path, folder, error) != MR_OK)
        return error->status;
    if (journal) {
        snprintf(copy, sizeof copy, "%s/copy", folder);
        at = copy;
    }
    size_t used = (size_t)snprintf(uri, STORE_URI_SIZE, "file:");
    for (; *at; at++)
        used += (size_t)snprintf(uri + used, STORE_URI_SIZE - used,
                                 strchr("%?#", *at) ? "%%%02X" : "%c", (unsigned char)*at);
    snprintf(uri + used, STORE_URI_SIZE - used, "%s", journal ? "" : "?immutable=1");
    return MR_OK;
}
