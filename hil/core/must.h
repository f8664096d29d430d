/* A call of Unicorn that must not fail. */
#ifndef MATRIG_HIL_MUST_H
#define MATRIG_HIL_MUST_H

#include <stdio.h>
#include <stdlib.h>
#include <unicorn/unicorn.h>

static inline void hil_must(uc_err err, const char *what)
{
    if (err == UC_ERR_OK)
        return;
    fprintf(stderr, "matrig-board: the CPU emulator failed: %s: %s\n", what, uc_strerror(err));
    abort();
}

#endif
