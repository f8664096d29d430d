#define real     double
#define RUN      chain_reference_run
#define ROUNDING 2e-16

#include "tests/stability/chain_reference_kernel.h"
