/* A rig with transducers 1 to 4 alone, and no gages: what is not fitted is neither converted, told
 * nor stored. */
#include "firmware/builtin.h"

#undef BUILTIN_TRANSDUCERS
#define BUILTIN_TRANSDUCERS(X) X(1, 40.0f) X(2, 50.0f) X(3, 60.0f) X(4, 70.0f)
#undef BUILTIN_GAGES
#define BUILTIN_GAGES(X)
