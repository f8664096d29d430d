#include "host/collect/quicklook.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define PAGE_MS 60000
#define LOOK_MS 20

extern char **environ;

bool quicklook_silent(struct quicklook_silence *silence, const struct collector_progress *progress,
                      uint64_t now_us)
{
    if (progress->block != silence->block || silence->since_us == 0) {
        silence->block = progress->block;
        silence->since_us = now_us;
    }
    if (!progress->run || progress->edges == 0 || progress->run == silence->told_run ||
        now_us - silence->since_us < QUICKLOOK_SILENT_US)
        return false;
    silence->told_run = progress->run;
    return true;
}

static void spawn(struct quicklook *look)
{
    char *words[10];
    int n = 0;
    posix_spawnattr_t how;
    posix_spawn_file_actions_t files;
    sigset_t none, pipe_signal;
    words[n++] = (char *)"matrig";
    words[n++] = (char *)"--quiet";
    if (look->si)
        words[n++] = (char *)"--si";
    words[n++] = (char *)"report";
    words[n++] = (char *)look->db;
    words[n++] = (char *)"-o";
    words[n++] = (char *)look->page;
    words[n] = NULL;
    sigemptyset(&none);
    sigemptyset(&pipe_signal);
    sigaddset(&pipe_signal, SIGPIPE);
    posix_spawnattr_init(&how);
    posix_spawnattr_setsigmask(&how, &none); /* the log has some blocked, and ignores SIGPIPE */
    posix_spawnattr_setsigdefault(&how, &pipe_signal);
    posix_spawnattr_setflags(&how, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    if (posix_spawn(&look->child, "/proc/self/exe", &files, &how, words, environ) != 0)
        look->child = 0; /* the summary is printed in any case */
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&how);
    look->again = false;
}

void quicklook_write(struct quicklook *look)
{
    if (look->page && look->child)
        look->again = true;
    else if (look->page)
        spawn(look);
}

void quicklook_service(struct quicklook *look, bool end)
{
    const struct timespec pause = {0, LOOK_MS * 1000000};
    for (int waited_ms = 0; look->child; waited_ms += LOOK_MS) {
        if (waitpid(look->child, NULL, WNOHANG) != 0) {
            look->child = 0;
            if (look->again)
                spawn(look);
            continue;
        }
        if (!end)
            return;
        if (waited_ms >= PAGE_MS) {
            kill(look->child, SIGKILL);
            waitpid(look->child, NULL, 0);
            look->child = 0;
            return;
        }
        nanosleep(&pause, NULL);
    }
}
