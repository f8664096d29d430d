/* Lanes: what is computed for many mats at once, in vector instructions where the machine has them;
 * the same bits with and without. */
#ifndef MATRIG_HOST_SIM_MODELS_LANES_H
#define MATRIG_HOST_SIM_MODELS_LANES_H

/* to[i] = tanh(scale * from[2 i]), i = 0..count-1, to 4e-16 absolute. */
void lanes_tanh(const double *from, double scale, double *to, int count);

#endif
