#include "host/day/logging.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "host/base/steady.h"

#define POLL_NS 20000000

static int open_in(const struct day_logging *logging, const char *name, int flags)
{
    char path[DAY_PATH + 16];
    snprintf(path, sizeof path, "%s/%s", logging->folder, name);
    return open(path, flags | O_CLOEXEC, 0644);
}

static enum mr_status failed(const struct day_logging *logging, const char *doing,
                             struct error *error)
{
    return error_set(error, MR_IO, "cannot %s (%s): %.200s; is the disk full, or not yours?", doing,
                     strerror(errno), logging->folder);
}

/* The log holds the lock of its file for as long as it runs, and its number stands in it. */
static void find(struct day_logging *logging)
{
    long pid = 0;
    long long before = 0;
    char text[48] = "";
    int lock = open_in(logging, "log.lock", O_RDONLY);
    logging->pid = 0;
    if (lock < 0)
        return;
    if (flock(lock, LOCK_SH | LOCK_NB) != 0 && errno == EWOULDBLOCK &&
        read(lock, text, sizeof text - 1) > 0 && sscanf(text, "%ld %lld", &pid, &before) == 2 &&
        pid > 1) {
        logging->pid = (pid_t)pid;
        logging->before = before;
    }
    close(lock);
}

enum mr_status day_logging_begin(struct day_logging *logging, const char *db, struct error *error)
{
    char path[PATH_MAX];
    *logging = (struct day_logging){0};
    /* by whatever name it is called */
    if (snprintf(logging->folder, sizeof logging->folder, "%s-day",
                 realpath(db, path) ? path : db) >= (int)sizeof logging->folder)
        return error_set(error, MR_TOO_LONG, "path too long: %.200s; at most %d characters", db,
                         DAY_PATH - 8);
    find(logging);
    return MR_OK;
}

enum mr_status day_logging_folder(const struct day_logging *logging, struct error *error)
{
    struct stat there;
    if (mkdir(logging->folder, 0755) != 0 &&
        (errno != EEXIST || stat(logging->folder, &there) != 0 || !S_ISDIR(there.st_mode)))
        return failed(logging, "make the day's folder", error);
    return MR_OK;
}

/* In the child: a session of its own, so that neither the terminal nor the day ends it. */
static void become(const char *const words[], int64_t before, int orders, int said, int lock)
{
    char text[48];
    sigset_t none;
    int length = snprintf(text, sizeof text, "%ld %lld\n", (long)getpid(), (long long)before);
    if (setsid() < 0 || ftruncate(lock, 0) != 0 || write(lock, text, (size_t)length) != length ||
        fcntl(lock, F_SETFD, 0) < 0 || dup2(orders, 0) < 0 || dup2(said, 1) < 0 ||
        dup2(said, 2) < 0)
        _exit(126);
    signal(SIGINT, SIG_DFL); /* what came since the fork is for the log */
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
    execv(words[0], (char *const *)words);
    _exit(127);
}

enum mr_status day_logging_start(struct day_logging *logging, const char *const words[],
                                 int64_t before, struct error *error)
{
    sigset_t interrupt, was;
    char path[DAY_PATH + 16];
    snprintf(path, sizeof path, "%s/orders", logging->folder);
    unlink(path); /* nobody reads it: no log runs */
    if (mkfifo(path, 0600) != 0)
        return failed(logging, "make the way for orders", error);
    /* both ends: a day that is gone is no end of the orders */
    int orders = open(path, O_RDWR | O_CLOEXEC),
        said = open_in(logging, "log.txt", O_WRONLY | O_CREAT | O_TRUNC | O_APPEND),
        lock = open_in(logging, "log.lock", O_RDWR | O_CREAT);
    bool good = orders >= 0 && said >= 0 && lock >= 0 && flock(lock, LOCK_EX | LOCK_NB) == 0;
    logging->shown = 0;
    logging->before = before;
    sigemptyset(&interrupt);
    sigaddset(&interrupt, SIGINT);
    sigprocmask(SIG_BLOCK, &interrupt, &was);
    logging->pid = good ? fork() : -1;
    if (logging->pid == 0)
        become(words, before, orders, said, lock);
    sigprocmask(SIG_SETMASK, &was, NULL);
    if (logging->pid < 0)
        failed(logging, "start the log", error);
    if (orders >= 0)
        close(orders);
    if (said >= 0)
        close(said);
    if (lock >= 0)
        close(lock);
    if (logging->pid < 0)
        logging->pid = 0;
    return error->status;
}

bool day_logging_runs(struct day_logging *logging)
{
    int status;
    pid_t ended = logging->pid ? waitpid(logging->pid, &status, WNOHANG) : -1;
    if (ended == logging->pid)
        logging->pid = 0;
    else if (ended < 0) /* no child of this day */
        find(logging);
    return logging->pid != 0;
}

bool day_logging_order(const struct day_logging *logging, const char *line)
{
    int orders = open_in(logging, "orders", O_WRONLY | O_NONBLOCK);
    size_t length = strlen(line);
    bool good = orders >= 0 && write(orders, line, length) == (ssize_t)length &&
                write(orders, "\n", 1) == 1;
    if (orders >= 0)
        close(orders);
    return good;
}

bool day_logging_show(struct day_logging *logging, FILE *out)
{
    char text[4096];
    ssize_t length;
    bool any = false;
    int said = open_in(logging, "log.txt", O_RDONLY);
    if (said < 0)
        return false;
    while ((length = pread(said, text, sizeof text, logging->shown)) > 0) {
        fwrite(text, 1, (size_t)length, out);
        logging->shown += (long)length;
        any = true;
    }
    close(said);
    fflush(out);
    return any;
}

bool day_logging_stop(struct day_logging *logging, double limit_s)
{
    double until_s = steady_s() + limit_s;
    if (day_logging_runs(logging))
        kill(logging->pid, SIGINT);
    while (day_logging_runs(logging) && steady_s() < until_s)
        nanosleep(&(struct timespec){.tv_nsec = POLL_NS}, NULL);
    return !logging->pid;
}
