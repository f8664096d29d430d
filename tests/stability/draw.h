/* Draw: the scenes of the stability study, a Latin hypercube. README.md. */
#ifndef MATRIG_TESTS_STABILITY_DRAW_H
#define MATRIG_TESTS_STABILITY_DRAW_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "host/sim/scene/scene.h"

#define DRAW_DECADES 6.0
#define DRAW_OUTPUTS 16

enum draw_key { DRAW_KV, DRAW_CV, DRAW_KL, DRAW_CL, DRAW_KT, DRAW_CT, DRAW_W, DRAW_I, DRAW_KEYS };

/* A number of 0..1, and one of 0..count-1, from a seed that moves on. */
double draw_uniform(uint64_t *state);
size_t draw_below(uint64_t *state, size_t count);

extern const char *const draw_key_names[DRAW_KEYS];

/* Exponents of the eight keys, count rows: factor 10^exponent on the standard scene's value, within
 * +-3 decades, each of the `count` equal parts of that range met exactly once by every key.
 * Allocated; NULL when memory is short. */
double (*draw_table(size_t count, uint64_t seed))[DRAW_KEYS];

/* Scene `index` of a table. The caller frees the scene. MR_FULL when memory is short. */
enum mr_status draw_scene(struct sim_scene *scene, const double exponents[DRAW_KEYS], size_t index,
                          uint64_t seed, struct error *error);

/* The same for the landing engine: model consistent with exact sticking or without friction, every
 * wheel load, and in half of them a path. */
enum mr_status draw_landing_path(struct sim_scene *scene, const double exponents[DRAW_KEYS],
                                 size_t index, uint64_t seed, struct error *error);

/* A scene's columns of a table: its number, its exponents, what else was drawn. */
void draw_head(FILE *table);
void draw_row(FILE *table, size_t index, const double exponents[DRAW_KEYS],
              const struct sim_scene *scene);

#endif
