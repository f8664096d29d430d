/* The predictor with a third of its budget: it has to go down to cheaper levels. */
#include "firmware/builtin.h"

#undef BUILTIN_UPDATES_PER_BLOCK
#define BUILTIN_UPDATES_PER_BLOCK 300
