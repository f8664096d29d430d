/* The same, of a gear that rolls on for long: no runway is long enough for it without brakes. */
#include "firmware/builtin.h"

#undef BUILTIN_RELEASE
#define BUILTIN_RELEASE 1
#undef BUILTIN_COASTING_FT_S2
#define BUILTIN_COASTING_FT_S2 0.5f
