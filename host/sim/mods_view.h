/* Access to an engine's arrays; private to mods*.c. */
#ifndef MATRIG_HOST_SIM_MODS_VIEW_H
#define MATRIG_HOST_SIM_MODS_VIEW_H

#include "host/sim/mods.h"

/* The ground, mats 0 and N+1, does not move. */
static inline double view_u_ft(const struct mods_view *view, int mats, int mat)
{
    return mat < 1 || mat > mats ? 0.0 : view->u_ft[mat * view->stride + view->offset];
}

static inline double view_v_ft_s(const struct mods_view *view, int mats, int mat)
{
    return mat < 1 || mat > mats ? 0.0 : view->v_ft_s[mat * view->stride + view->offset];
}

/* mods_bands.c */
void mods_reset_bands(struct mods *mods);
double mods_band_energy_lb_ft(const struct mods *mods, const struct mods_view *view);
double mods_band_raw_lb(const struct mods *mods, const struct mods_view *view, int segment);

#endif
