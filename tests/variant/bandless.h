/* A rig without bands: no gages. */
#include "firmware/builtin.h"

#undef BUILTIN_GAGES
#define BUILTIN_GAGES(X)
