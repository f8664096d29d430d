#include "host/sim/elements/parting.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"
#define RADIANS (3.14159265358979323846 / 180.0)

struct parting *parting_make(const struct sim_scene *scene)
{
    size_t joints = (size_t)scene->mats + 2;
    if (!(scene->mods.unhinge_deg < HUGE_VAL))
        return NULL;
    struct parting *p = xmalloc(sizeof *p);
    *p = (struct parting){.joints = joints,
                          .unhinge_rad = scene->mods.unhinge_deg * RADIANS,
                          .lap_ft = scene->mods.unhinge_lap_ft,
                          .joint = xcalloc(joints, sizeof *p->joint),
                          .apart = xcalloc(4 * joints, sizeof *p->apart),
                          .storage = xcalloc(4 * joints, sizeof *p->storage)};
    p->lapped = p->apart + joints;
    p->contact = p->lapped + joints;
    p->gone = p->contact + joints;
    p->y_ft = p->storage;
    p->v_ft_s = p->y_ft + joints;
    p->accel = p->v_ft_s + joints;
    p->down_lb = p->accel + joints;
    return p;
}

void parting_free(struct parting *p)
{
    if (!p)
        return;
    free(p->joint);
    free(p->apart);
    free(p->storage);
    free(p);
}

void parting_reset(struct parting *p)
{
    for (int i = 0; i < p->count; i++)
        p->apart[p->joint[i]] = false;
    memset(p->gone, 0, p->joints * sizeof *p->gone);
    p->count = 0;
}

void parting_part(struct parting *p, int joint, double y_ft, double v_ft_s)
{
    if (p->apart[joint])
        return;
    p->joint[p->count++] = joint;
    p->apart[joint] = true;
    p->lapped[joint] = p->gone[joint] = false;
    p->contact[joint] = y_ft > 0.0;
    p->y_ft[joint] = y_ft;
    p->v_ft_s[joint] = v_ft_s;
    p->accel[joint] = p->down_lb[joint] = 0.0;
}

bool parting_abuts(struct parting *p, int joint, double g_ft, double y_ft)
{
    if (g_ft > 0.0)
        p->lapped[joint] = false;
    else if (fabs(p->y_ft[joint] - y_ft) > p->lap_ft)
        p->lapped[joint] = true;
    return !p->lapped[joint];
}
