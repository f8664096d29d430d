/* A transducer gives 0.51 V/in, not 0.5: the same codes are other inches, and replay has to say
 * so. */
#include "firmware/builtin.h"

#undef BUILTIN_TRANSDUCER_V_PER_IN
#define BUILTIN_TRANSDUCER_V_PER_IN 0.51f
