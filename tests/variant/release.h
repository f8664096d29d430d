/* A rig whose brake can be released. */
#include "firmware/builtin.h"

#undef BUILTIN_RELEASE
#define BUILTIN_RELEASE 1
