/* The command line of matrig-board: what was asked, and whether that can be. */
#ifndef MATRIG_HIL_ARGUMENTS_H
#define MATRIG_HIL_ARGUMENTS_H

#include <stdbool.h>

#include "common/status.h"
#include "hil/periph/options.h"

#define HIL_FOREVER_S 100000.0

/* What --help prints. */
void hil_arguments_help(void);

/* The texts are those of argv. */
struct hil_arguments {
    const char *elf, *can, *serial, *rig, *replay, *flash, *nor, *faults, *gdb, *vcd, *profile,
        *margins;
    bool board_given, trace;
    unsigned parity;              /* place of the option's word */
    unsigned speed;               /* 0: max, 1: real */
    double for_s;                 /* 0: not given */
    double stall_s, wall_limit_s; /* wall_limit_s 0: none; negative: not given */
    struct hil_options options;
};

/* One line on stderr, with the program's name. */
__attribute__((format(printf, 1, 2))) void hil_complain(const char *format, ...);

/* MR_USAGE: cannot be; stderr says why. */
enum mr_status hil_arguments_parse(struct hil_arguments *a, int argc, char **argv);
/* Once it is known which board it is. MR_USAGE: it cannot do what was asked. */
enum mr_status hil_arguments_check_board(const struct hil_arguments *a);
/* What is written must not be what is read or written elsewhere; devices may be. A record takes the
 * place of no campaign and no program. MR_USAGE. */
enum mr_status hil_arguments_check_paths(const struct hil_arguments *a);

#endif
