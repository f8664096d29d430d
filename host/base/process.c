#include "host/base/process.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "host/base/monotonic_clock.h"

#define POLL_NS 5000000

/* Replaces the child process by the program; does not return. */
static void execute_program(const char *const words[], const int streams[3])
{
    sigset_t none;
    sigemptyset(&none);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    sigprocmask(SIG_SETMASK, &none, NULL); /* the program must not inherit blocked signals */
    signal(SIGPIPE, SIG_DFL);              /* the program must not inherit the ignored SIGPIPE */
    for (int i = 0; i < 3; i++) {
        if (streams[i] < 0)
            continue;
        /* dup2 to the same descriptor would keep its close-on-exec flag */
        if (streams[i] == i ? fcntl(i, F_SETFD, 0) < 0 : dup2(streams[i], i) < 0)
            _exit(126);
    }
    execvp(words[0], (char *const *)words);
    _exit(127);
}

enum mr_status process_start(const char *const words[], const int streams[3], pid_t *child,
                             struct error *error)
{
    *child = fork();
    if (*child == 0)
        execute_program(words, streams);
    return *child < 0 ? error_set(error, MR_IO, "cannot start (%s): %s; close other programs",
                                  strerror(errno), words[0])
                      : MR_OK;
}

bool process_wait(pid_t child, double limit_s, int *status)
{
    double until_s = monotonic_s() + limit_s;
    while (waitpid(child, status, WNOHANG) == 0) {
        if (monotonic_s() > until_s) {
            kill(child, SIGKILL);
            waitpid(child, status, 0);
            return false;
        }
        nanosleep(&(struct timespec){.tv_nsec = POLL_NS}, NULL);
    }
    return true;
}

void shell_quote(FILE *out, const char *text)
{
    fputc('\'', out);
    for (; *text; text++) {
        if (*text == '\'')
            fputs("'\\''", out);
        else
            fputc(*text, out);
    }
    fputc('\'', out);
}

enum mr_status temporary_folder_create(char path[TEMPORARY_FOLDER_SIZE], const char *name,
                                       struct error *error)
{
    const char *base = getenv("TMPDIR");
    snprintf(path, TEMPORARY_FOLDER_SIZE, "%s/matrig-%s.XXXXXX",
             base && *base && strlen(base) < 150 ? base : "/tmp", name);
    if (mkdtemp(path))
        return MR_OK;
    error_set(error, MR_IO,
              "cannot create a temporary directory (%s): %s; set TMPDIR to a writable directory",
              strerror(errno), path);
    path[0] = '\0';
    return error->status;
}

void temporary_folder_remove(const char *path, const char *const names[], size_t count)
{
    char file[TEMPORARY_FOLDER_SIZE + 40];
    if (!path[0])
        return;
    for (size_t i = 0; i < count; i++) {
        snprintf(file, sizeof file, "%s/%s", path, names[i]);
        unlink(file);
    }
    rmdir(path);
}
