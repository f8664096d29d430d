/* The part of a scene that says how the runway is modified: defaults, ranges that need the whole
 * scene, and which mats have what. elements/mods.h has the forces. Mats count from 1, connections
 * and cleats from 0. The scene owns its lists. */
#ifndef MATRIG_HOST_SIM_SCENE_MODS_SCENE_H
#define MATRIG_HOST_SIM_SCENE_MODS_SCENE_H

#include "host/sim/scene/scene.h"

/* Defaults, and release of lists. */
void mods_defaults(struct sim_mods *mods);
void mods_free_lists(struct sim_mods *mods);
#define MODS_LISTS (3 * SIM_BAND_GROUPS + 3)
void mods_lists(struct sim_mods *mods, struct sim_list *lists[MODS_LISTS]); /* all that it owns */
/* MR_MALFORMED: the error names the key. */
enum mr_status mods_check(const struct sim_scene *scene, const char *where, struct error *error);
bool mods_any(const struct sim_scene *scene);

/* How many connections (riveted mats) a group of bands and how many cleats a scene has, and the mat
 * of the i-th from 0. A group has one segment more than connections, or none. */
int mods_connections(const struct sim_scene *scene, int group);
int mods_connection_mat(const struct sim_scene *scene, int group, int i);
int mods_cleats(const struct sim_scene *scene);
int mods_cleat_mat(const struct sim_scene *scene, int i);

#endif
