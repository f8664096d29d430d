/* Which image a landing is replayed with. */
#ifndef MATRIG_HOST_REPLAY_IMAGE_H
#define MATRIG_HOST_REPLAY_IMAGE_H

#include "host/replay/answers.h"

/* The image that came with matrig for the board that recorded it. Of a record that does not tell
 * its board: zg's. */
void replay_image_of(const struct answers *recorded, char *path, size_t size);
/* The same, of a landing whose answers are not loaded. */
void replay_image_find(struct store *store, int64_t run, char *path, size_t size);
/* MR_VERSION: the image says that it is for another board than the one that recorded it. What is no
 * image of matrig, the board refuses by itself. */
enum mr_status replay_image_check(const char *path, const struct answers *recorded,
                                  struct error *error);

#endif
