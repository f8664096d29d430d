/* matrig board health | self-test | reset */
#ifndef MATRIG_HOST_BOARD_HEALTH_H
#define MATRIG_HOST_BOARD_HEALTH_H

#include "host/base/cli.h"

/* One of the verbs of board_health.c? */
bool board_health_verb(const char *word);
/* Exit code; 1: the board found a fault in itself. `elf` names functions, or NULL. */
int board_health(const char *serial, const char *verb, const char *elf, const struct cli *cli);

#endif
