/* `make bench`, the simulation: see bench.h. */
#include "tests/bench/bench.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

double bench_clock_ms(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e3 * (double)now.tv_sec + 1e-6 * (double)now.tv_nsec;
}

static int by_value(const void *a, const void *b)
{
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

double bench_median(double *values, size_t count)
{
    qsort(values, count, sizeof *values, by_value);
    return 0.5 * (values[(count - 1) / 2] + values[count / 2]);
}

void bench_line(const char *what, double measured, const char *unit, bool at_most, double wanted)
{
    bool met = at_most ? measured <= wanted : measured >= wanted;
    printf("  %-58s %10.4g %-5s wanted %s %-8.4g %s\n", what, measured, unit,
           at_most ? "<=" : ">=", wanted, met ? "met" : "missed");
    fflush(stdout);
}

bool bench_load(struct sim_scene *scene, const char *file, bool own_times)
{
    struct error error = {0};
    char path[256];
    snprintf(path, sizeof path, "host/scenes/%s", file);
    if (sim_scene_load(scene, path, &error) != MR_OK) {
        printf("  %s\n", error.text);
        return false;
    }
    size_t own = own_times ? scene->t_out_s.count : 0;
    double *times = malloc((BENCH_EVEN_TIMES + own) * sizeof *times);
    bool ok = times != NULL;
    if (ok) {
        memcpy(times, scene->t_out_s.values, own * sizeof *times);
        for (int i = 0; i < BENCH_EVEN_TIMES; i++)
            times[own + (size_t)i] = sim_scene_end_s(scene) * (i + 1) / BENCH_EVEN_TIMES;
        qsort(times, BENCH_EVEN_TIMES + own, sizeof *times, by_value);
        sim_scene_set_list(&scene->t_out_s, times, BENCH_EVEN_TIMES + own);
    }
    free(times);
    if (!ok)
        sim_scene_free(scene);
    return ok;
}

bool bench_run(const struct sim_scene *scene, const struct sim_options *options,
               struct sim_result *result, const char *what)
{
    struct error error = {0};
    if (sim_run(scene, options, result, &error) == MR_OK)
        return true;
    if (what)
        printf("  %s: %s\n", what, error.text);
    return false;
}

int main(void)
{
    if (access("host/scenes", R_OK) != 0) {
        fprintf(stderr, "no scenes: host/scenes; run from the top of the sources\n");
        return 2;
    }
    bench_growth();
    bench_pruning();
    bench_landings();
    bench_ensemble();
    return 0;
}
