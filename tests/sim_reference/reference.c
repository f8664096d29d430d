/* reference [-h STEP_S] SCENE...: run scenes with the plain models and print golden numbers.
 *
 * Every scene is run at the step and at half of it; what is printed is the finer run, `apart` is
 * how far the two differ (ft), over every u and lift printed. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/sim_reference/model.h"

static bool print_scene(const char *path, double h_s)
{
    static struct ref_scene scene;
    static struct ref_run coarse, fine;
    double apart = 0;
    if (!ref_load(&scene, path) || !ref_march(&scene, h_s, &coarse) ||
        !ref_march(&scene, h_s / 2, &fine))
        return false;
    for (int i = 0; i < scene.outputs; i++) {
        apart = fmax(apart, fabs(coarse.output[i].lift_ft - fine.output[i].lift_ft));
        for (int n = 0; n < scene.mats; n++)
            apart = fmax(apart, fabs(coarse.output[i].u_ft[n] - fine.output[i].u_ft[n]));
    }
    printf("scene %s\n", path);
    printf("run steps %lu switches %lu apart %.1e max_lift %.9g\n", fine.steps, fine.switches,
           apart, fine.max_lift_ft);
    for (int i = 0; i < scene.outputs; i++) {
        const struct ref_output *output = &fine.output[i];
        printf("at %.12g lift %.9g node %d u", output->t_s, output->lift_ft, output->lift_node);
        for (int n = 0; n < scene.mats; n++)
            printf(" %.9g", output->u_ft[n]);
        putchar('\n');
    }
    return fflush(stdout) == 0;
}

int main(int argc, char **argv)
{
    double h_s = 1e-6;
    int first = 1;
    if (argc > 2 && strcmp(argv[1], "-h") == 0) {
        h_s = strtod(argv[2], NULL);
        first = 3;
    }
    if (first >= argc || !(h_s > 0)) {
        fputs("usage: reference [-h STEP_S] SCENE...\n", stderr);
        return 2;
    }
    for (int i = first; i < argc; i++) {
        if (!print_scene(argv[i], h_s))
            return 1;
    }
    return 0;
}
