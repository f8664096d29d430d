/* What a board says about itself and its image: hello and what follows it, once a second. */
#ifndef MATRIG_HOST_BOARD_IDENTITY_H
#define MATRIG_HOST_BOARD_IDENTITY_H

#include <stdbool.h>

#include "common/catalogue.h"
#include "common/image.h"
#include "host/base/error.h"

#define IDENTITY_UID_TEXT 25 /* 24 hexadecimal digits */

struct identity {
    bool hello_known;
    struct mr_hello hello;
    uint32_t uid[3];
    bool image_known;   /* the last word of uid, and the next */
    uint32_t image_crc; /* of the program, as the board computed it at start */
    bool commit_known;  /* it told these two as well */
    struct mr_image_commit commit;
    struct mr_image_header header;
    bool board_known;
    uint8_t board; /* common/boards.def; told a little later than the rest */
};

/* Takes a message in; those of other kinds change nothing. */
void identity_take(struct identity *identity, uint32_t id, const uint8_t *bytes, size_t length);
/* MR_OK: the board speaks this matrig's layout; else MR_VERSION. `spec`: its link. */
enum mr_status identity_speaks(const struct identity *identity, const char *spec,
                               struct error *error);
void identity_uid_text(const struct identity *identity, char out[IDENTITY_UID_TEXT]);
/* Does the board run this image, whole? Else `why` says in what they differ. */
bool identity_runs(const struct identity *identity, const struct mr_image *image, char *why,
                   size_t size);

#endif
