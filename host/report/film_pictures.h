/* Pictures of a film that somebody scanned: files in a folder, the last number in a name is the
 * frame's. */
#ifndef MATRIG_HOST_REPORT_FILM_PICTURES_H
#define MATRIG_HOST_REPORT_FILM_PICTURES_H

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

#include "host/base/error.h"

#define FILM_PICTURE_BYTES (4u * 1024u * 1024u) /* a larger one is refused */

struct film_pictures {
    struct film_picture {
        int64_t number;
        char *path;
    } * picture; /* by rising number */
    size_t count;
};

/* Of `folder`/`run`, or of `folder` itself when it has no such folder and `alone` is set. Without
 * either folder there are none. MR_IO: cannot be read. The caller releases it with
 * film_pictures_free, also after an error. */
enum mr_status film_pictures_list(const char *folder, int64_t run, bool alone,
                                  struct film_pictures *pictures, struct error *error);
void film_pictures_free(struct film_pictures *pictures);

/* The picture of a frame; NULL: there is none. */
const struct film_picture *film_pictures_find(const struct film_pictures *pictures, int64_t number);
/* <img> with the picture in it. MR_MALFORMED: no JPEG and no PNG; MR_LIMIT: too large. */
enum mr_status film_picture_write(const struct film_picture *picture, FILE *out,
                                  struct error *error);

#endif
