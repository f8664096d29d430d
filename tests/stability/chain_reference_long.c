#pragma GCC diagnostic ignored "-Wdouble-promotion" /* the scene's doubles become long here */

#define real     long double
#define RUN      chain_reference_run_long
#define ROUNDING 1e-19L

#include "tests/stability/chain_reference_kernel.h"
