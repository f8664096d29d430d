/* Vector instructions where the machine has them; the results have the same bits without. */
#ifndef MATRIG_HOST_SIM_MODELS_VECTOR_H
#define MATRIG_HOST_SIM_MODELS_VECTOR_H

/* A function that is compiled twice; the processor decides which is called. */
#if defined __x86_64__ && !defined __clang__ /* clang 14 gives clones a name that nobody links to */
#define VECTOR __attribute__((target_clones("avx2", "default")))
#else
#define VECTOR
#endif

/* to[i] = tanh(scale * from[2 i]), i = 0..count-1, to 4e-16 absolute. */
void vector_tanh(const double *from, double scale, double *to, int count);

#endif
