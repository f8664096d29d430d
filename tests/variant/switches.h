/* A rig of switches alone, without a black box: the speed needs nothing else. */
#include "firmware/builtin.h"

#undef BUILTIN_TRANSDUCERS
#define BUILTIN_TRANSDUCERS(X)
#undef BUILTIN_GAGES
#define BUILTIN_GAGES(X)
#undef BUILTIN_BLACK_BOX
#define BUILTIN_BLACK_BOX 0
