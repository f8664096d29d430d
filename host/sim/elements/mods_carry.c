/* What a landing leaves of the modifications, as the next one's scene. */
#include <math.h>
#include <stdlib.h>

#include "host/sim/elements/mods.h"
#include "host/sim/scene/result.h"

/* The numbers of those flagged. */
static enum mr_status set_flagged(struct sim_list *list, const double *flags, const double *numbers,
                                  size_t count, struct error *error)
{
    double *found = calloc(count + 1, sizeof *found);
    size_t n = 0;
    if (!found)
        return error_set(error, MR_FULL, "out of memory: %zu values; use a smaller scene", count);
    for (size_t i = 0; i < count; i++) {
        if (flags[i] != 0.0)
            found[n++] = numbers ? numbers[i] : (double)i;
    }
    enum mr_status status = sim_scene_set_list(list, found, n, error);
    free(found);
    return status;
}

enum mr_status mods_carry(struct sim_scene *scene, const struct sim_result *result,
                          struct error *error)
{
    const struct mods_state *s = result->mods;
    struct sim_mods *m = &scene->mods;
    size_t segment = 0, connection = 0;
    if (!s)
        return MR_OK;
    for (int g = 0; g < SIM_BAND_GROUPS; g++) {
        struct sim_bands *b = &m->band[g];
        size_t count = (size_t)mods_connections(scene, g);
        if (count == 0)
            continue;
        if (sim_scene_set_list(&b->t0_lb, s->band_lb + segment, count + 1, error) != MR_OK ||
            sim_scene_set_list(&b->slipped_ft, s->band_slip_ft + connection, count, error) !=
                MR_OK ||
            set_flagged(&b->pulled, s->band_out + connection, s->band_mat + connection, count,
                        error) != MR_OK)
            return error->status;
        b->dt_f = 0.0;
        segment += count + 1;
        connection += count;
    }
    if (m->cleat_every > 0 &&
        sim_scene_set_list(&m->cleat_left, s->cleat_left, s->cleats, error) != MR_OK)
        return error->status;
    if (m->stiff_span > 1 && sim_scene_set_list(&m->stiff_gap0_ft, s->stiff_gap_ft + 1,
                                                (size_t)scene->mats + 1, error) != MR_OK)
        return error->status;
    return m->tear_lb < HUGE_VAL || m->unhinge_deg < HUGE_VAL
             ? set_flagged(&m->torn, s->torn, NULL, s->joints + 1, error)
             : MR_OK;
}
