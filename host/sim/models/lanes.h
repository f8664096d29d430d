/* Lanes: what is computed for many mats at once, in vector instructions where the machine has them;
 * the same bits with and without. */
#ifndef MATRIG_HOST_SIM_MODELS_LANES_H
#define MATRIG_HOST_SIM_MODELS_LANES_H

/* A function that is compiled twice, the processor decides which is called. */
#if defined __x86_64__ && !defined __clang__ /* clang 14 gives clones a name that nobody links to */
#define LANES __attribute__((target_clones("avx2", "default")))
#else
#define LANES
#endif

/* to[i] = tanh(scale * from[2 i]), i = 0..count-1, to 4e-16 absolute. */
void lanes_tanh(const double *from, double scale, double *to, int count);

#endif
