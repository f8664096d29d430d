/* Where on a CAN bus boards are (common/canbase.h), as people write it behind a LINK: can0@0x190 is
 * the board at base 0x190 on can0, can0@0,0x190 two boards. Pure, but for asking whether a file has
 * that name. */
#ifndef MATRIG_HOST_LINK_BASES_H
#define MATRIG_HOST_LINK_BASES_H

#include <stdbool.h>
#include <stdint.h>

#include "common/canbase.h"
#include "host/base/error.h"

#define LINK_BOARDS 4u

struct link_bases {
    uint16_t base[LINK_BOARDS]; /* in the order given */
    unsigned count;             /* 1 to LINK_BOARDS */
    bool given;                 /* else: one, of 0 */
};

/* Takes @BASE off a LINK that carries CAN, in place. A file that has the whole name keeps it.
 * MR_USAGE: no base, or boards that would share an identifier. */
enum mr_status link_take_bases(char *spec, struct link_bases *bases, struct error *error);

/* How many boards a LINK names. Errors as link_take_bases. */
enum mr_status link_count_boards(const char *spec, unsigned *boards, struct error *error);

/* A base as people write it, decimal or 0x190, all of `text`. MR_USAGE: none; `where` names the
 * text's place. */
enum mr_status link_read_base(const char *text, const char *where, uint16_t *base,
                              struct error *error);

/* "@0x190", "@0x000,0x190"; "" when none was given. */
#define LINK_BASES_TEXT 32u
void link_bases_text(const struct link_bases *bases, char out[LINK_BASES_TEXT]);

/* A message of a board at `one` and one of a board at `other` share an identifier: the first such,
 * as it is on the bus, in `id`. False: none do. */
bool link_bases_meet(uint16_t one, uint16_t other, uint16_t *id);

#endif
