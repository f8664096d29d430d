#include "host/sim/models/strips.h"

#include <stdlib.h>

enum mr_status strips_make(struct strips **made, struct chain *first, const struct sim_scene *scene,
                           struct error *error)
{
    *made = NULL;
    if (!scene->beside)
        return MR_OK;
    struct strips *strips = calloc(1, sizeof *strips);
    if (!strips)
        return error_set(error, MR_FULL, "out of memory: the strip beside; use a smaller N");
    strips->scene = scene->beside;
    sim_wheel_start(&strips->wheel, strips->scene);
    if (ties_make(&strips->ties, scene, error) != MR_OK ||
        chain_make(&strips->chain, strips->scene, sim_wheel_first_mat(&strips->wheel), error) !=
            MR_OK) {
        ties_free(strips->ties);
        free(strips);
        return error->status;
    }
    first->tied_lb_ft = strips->chain.tied_lb_ft = ties_row_lb_ft(strips->ties);
    *made = strips;
    return MR_OK;
}

void strips_free(struct strips *strips)
{
    if (!strips)
        return;
    ties_free(strips->ties);
    chain_free(&strips->chain);
    free(strips);
}

/* What the ties pull mats from..to with, into both chains. */
static void pass_on(struct strips *strips, struct chain *first, int from, int to)
{
    for (int n = from; n <= to; n++) {
        first->thrust_lb[n] = -strips->ties->lb[n];
        strips->chain.thrust_lb[n] = strips->ties->lb[n];
    }
}

void strips_start(struct strips *strips, struct chain *first, double h_s)
{
    chain_reset(&strips->chain, strips->scene);
    sim_wheel_start(&strips->wheel, strips->scene);
    strips->count = 0;
    if (strips->chain.gear)
        chain_mount(&strips->chain, &strips->wheel, h_s);
    if (!strips->ties)
        return;
    ties_reset(strips->ties);
    pass_on(strips, first, 1, first->mats);
}

void strips_release(struct strips *strips, struct chain *first, const struct sim_touch *touch,
                    int count)
{
    chain_release(&strips->chain, strips->touch, strips->count);
    for (int i = 0; strips->ties && i < count; i++)
        pass_on(strips, first, touch[i].mat, touch[i].mat);
    for (int i = 0; strips->ties && i < strips->count; i++)
        pass_on(strips, first, strips->touch[i].mat, strips->touch[i].mat);
}

void strips_span(struct strips *strips, double from_s, double to_s)
{
    strips->count = sim_wheel_span(&strips->wheel, from_s, to_s, strips->touch);
}

static struct ties_view view_of(const struct chain *chain)
{
    return (struct ties_view){chain->u_ft, 1, 0};
}

void strips_tie(struct strips *strips, struct chain *first, int from_mat, int to_mat)
{
    if (!strips->ties)
        return;
    ties_pull(strips->ties, view_of(first), view_of(&strips->chain), from_mat, to_mat);
    pass_on(strips, first, from_mat, to_mat);
}

double strips_energy_lb_ft(const struct strips *strips, int first, int last)
{
    return chain_energy_lb_ft(&strips->chain, first, last) +
           (strips->ties ? ties_energy_lb_ft(strips->ties) : 0.0);
}

double *strips_stretch_ft(const struct strips *strips, const struct chain *first)
{
    return ties_stretch_ft(strips->ties, view_of(first), view_of(&strips->chain));
}
