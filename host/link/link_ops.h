/* What a kind of link implements. Only host/link/ includes this. */
#ifndef MATRIG_HOST_LINK_LINK_OPS_H
#define MATRIG_HOST_LINK_LINK_OPS_H

#include "host/link/link.h"

struct link_ops {
    const char *prefix; /* "unix:" */
    enum mr_status (*open)(struct link *link, const char *path, struct error *error);
    enum mr_status (*receive_frame)(struct link *link, struct link_frame *frame, struct error *error);
    enum mr_status (*send)(struct link *link, const uint8_t *bytes, size_t length, struct error *error);
};

#define LINK_BUFFER 65536u

struct link {
    const struct link_ops *ops;
    enum link_kind kind;
    int fd;
    char *spec;
    struct link_counters counters;
    uint8_t buffer[LINK_BUFFER]; /* read from fd and not yet given on: from `start` to `end` */
    size_t start;
    size_t end;
    uint64_t read_us;   /* when the newest of them was read */
    unsigned long line; /* file: lines given on */
};

extern const struct link_ops link_unix_ops;
extern const struct link_ops link_file_ops;

/* Read more into the buffer. MR_OK: there is more; MR_TOO_FEW: none now; MR_CLOSED: end of file; MR_IO. */
enum mr_status link_fill(struct link *link, struct error *error);

#endif
