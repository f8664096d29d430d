/* Access to an engine's arrays; private to mods*.c. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_MODS_VIEW_H
#define MATRIG_HOST_SIM_ELEMENTS_MODS_VIEW_H

#include "host/sim/elements/mods.h"

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
void mods_place_bands(struct mods *mods, double *storage); /* 3 a segment, 5 a connection */
void mods_reset_bands(struct mods *mods);
double mods_band_energy_lb_ft(const struct mods *mods, const struct mods_view *view);

/* What a segment pulls with; a slack one nothing. */
static inline double taut_lb(double raw_lb)
{
    return raw_lb > 0.0 ? raw_lb : 0.0;
}

#endif
