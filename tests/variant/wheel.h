/* A rig with the edge of its brake and a pick-up of eight pulses at a wheel. */
#include "firmware/builtin.h"

#undef BUILTIN_WHEEL_PULSES
#define BUILTIN_WHEEL_PULSES 8
