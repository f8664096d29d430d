/* Without the predictor: the same landing, and not a word, a warning, a page of memory or an
 * instruction of it. */
#include "firmware/builtin.h"

#undef BUILTIN_PREDICTOR
#define BUILTIN_PREDICTOR 0
