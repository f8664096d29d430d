#include "hil/core/wall.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <string.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static volatile int *limit_stop_flag;
static volatile sig_atomic_t alarm_count;

double hil_wall_clock_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int64_t hil_wall_clock_ms(void)
{
    return (int64_t)(1e3 * hil_wall_clock_s());
}

void hil_pace_wait(const struct hil_pace *pace, uint64_t t_ps, const volatile int *stop)
{
    double t_s = pace->start_s + (double)t_ps * 1e-12;
    struct timespec t = {.tv_sec = (time_t)t_s};
    t.tv_nsec = (long)((t_s - (double)t.tv_sec) * 1e9);
    while (!*stop && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR)
        continue;
}

void hil_pace_record(struct hil_pace *pace, uint64_t t_ps)
{
    double late_s = hil_wall_clock_s() - pace->start_s - (double)t_ps * 1e-12;
    if (late_s > pace->max_delay_s)
        pace->max_delay_s = late_s;
    if (late_s > pace->max_delay_after_start_s && (double)t_ps * 1e-12 > HIL_PACE_START_S)
        pace->max_delay_after_start_s = late_s;
}

static void on_alarm(int number)
{
    static const char text[] =
        "matrig-board: the run continues several seconds after the wall-clock limit, because a "
        "link or a file blocks or the emulator hangs; check the programs that read the links\n";
    (void)number;
    *limit_stop_flag = HIL_STOP_BY_WALL_LIMIT;
    if (alarm_count++) {
        ssize_t ignored = write(STDERR_FILENO, text, sizeof text - 1);
        (void)ignored;
        _exit(3);
    }
}

void hil_wall_clock_set_limit(double limit_s, volatile int *stop)
{
    struct sigaction action = {.sa_handler = on_alarm};
    if (limit_s <= 0)
        return;
    limit_stop_flag = stop;
    sigaction(SIGALRM, &action, NULL);
    struct itimerval timer = {.it_interval = {.tv_sec = HIL_WALL_GRACE_S}};
    timer.it_value.tv_sec = (time_t)floor(limit_s);
    timer.it_value.tv_usec = (suseconds_t)((limit_s - floor(limit_s)) * 1e6);
    setitimer(ITIMER_REAL, &timer, NULL);
}
