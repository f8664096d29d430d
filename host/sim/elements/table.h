/* The table of elements that are files of their own: one row each. A row gives the element its
 * place in a scene (sim_scene.element[ELEMENT_name]), its key in scene files, and its part in every
 * engine. */
#ifndef MATRIG_HOST_SIM_ELEMENTS_TABLE_H
#define MATRIG_HOST_SIM_ELEMENTS_TABLE_H

#define ELEMENT_TABLE(ROW) ROW(ground_damping) ROW(gear_ground)

#endif
