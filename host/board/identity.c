#include "host/board/identity.h"

#include <stdio.h>

static void take_image(struct identity *identity, const uint8_t *bytes, size_t length)
{
    struct mr_board_image image;
    if (!identity->hello_known || mr_board_image_get(&image, bytes, length) != MR_OK)
        return;
    identity->uid[2] = image.uid2;
    identity->image_crc = image.image_crc;
    identity->image_known = true;
}

void identity_take(struct identity *identity, uint32_t id, const uint8_t *bytes, size_t length)
{
    struct mr_board_uid uid;
    struct mr_config_state state;
    switch (id) {
    case MR_ID_HELLO:
        identity->hello_known |= mr_hello_get(&identity->hello, bytes, length) == MR_OK;
        break;
    case MR_ID_BOARD_UID:
        if (mr_board_uid_get(&uid, bytes, length) == MR_OK) {
            identity->uid[0] = uid.uid0;
            identity->uid[1] = uid.uid1;
        }
        break;
    case MR_ID_BOARD_IMAGE: take_image(identity, bytes, length); break;
    case MR_ID_IMAGE_COMMIT: (void)mr_image_commit_get(&identity->commit, bytes, length); break;
    case MR_ID_IMAGE_HEADER: /* the last of them */
        identity->commit_known |= identity->image_known &&
                                  mr_image_header_get(&identity->header, bytes, length) == MR_OK;
        break;
    case MR_ID_CONFIG_STATE:
        if (mr_config_state_get(&state, bytes, length) == MR_OK) {
            identity->board = state.board;
            identity->board_known = true;
        }
        break;
    default: break;
    }
}

enum mr_status identity_speaks(const struct identity *identity, const char *spec,
                               struct error *error)
{
    if (identity->hello.layout == MR_LAYOUT)
        return MR_OK;
    return error_set(
        error, MR_VERSION,
        "board speaks layout %u, this matrig layout %u: %s; use the matrig of its firmware",
        identity->hello.layout, MR_LAYOUT, spec);
}

void identity_uid_text(const struct identity *identity, char out[IDENTITY_UID_TEXT])
{
    snprintf(out, IDENTITY_UID_TEXT, "%08X%08X%08X", (unsigned)identity->uid[0],
             (unsigned)identity->uid[1], (unsigned)identity->uid[2]);
}

bool identity_runs(const struct identity *identity, const struct mr_image *image, char *why,
                   size_t size)
{
    char runs[MR_IMAGE_COMMIT_TEXT], file[MR_IMAGE_COMMIT_TEXT];
    if (!identity->commit_known || identity->commit.state != MR_IMAGE_GOOD) {
        snprintf(why, size, "the board's image: %s",
                 identity->commit_known ? mr_image_state_text(identity->commit.state)
                                        : "no header");
        return false;
    }
    mr_image_commit_text(identity->commit.commit, identity->commit.commit_more,
                         identity->commit.changed != 0, runs);
    mr_image_commit_text(image->commit, image->commit_more, image->changed, file);
    if (identity->image_crc != image->program_crc)
        snprintf(why, size, "program %08x, not %08x (commit %s, not %s)",
                 (unsigned)identity->image_crc, (unsigned)image->program_crc, runs, file);
    else if (identity->header.header_crc != image->header_crc)
        snprintf(why, size, "the same program, another header or other vectors (commit %s, not %s)",
                 runs, file);
    else
        return true;
    return false;
}
