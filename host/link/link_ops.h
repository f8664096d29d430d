/* What a kind of link implements. Only host/link/ includes this. */
#ifndef MATRIG_HOST_LINK_LINK_OPS_H
#define MATRIG_HOST_LINK_LINK_OPS_H

#include <pthread.h>
#include <stdbool.h>
#include <sys/types.h>

#include "host/base/error.h"
#include "host/link/candump.h"

struct link;

struct link_ops {
    unsigned kinds;  /* 1 << enum link_kind of each that it carries */
    bool comes_back; /* a device: when it goes away, wait for it */
    bool waits;      /* who sends waits until it is read */
    bool recorded;   /* earlier: reading decides how fast it goes */
    enum mr_status (*open)(struct link *link, const char *path, struct error *error);
    enum mr_status (*receive_frame)(struct link *link, struct link_frame *frame,
                                    struct error *error);
    enum mr_status (*send)(struct link *link, const uint8_t *bytes, size_t length,
                           struct error *error);
    /* Those below may be NULL. */
    /* as read(2); NULL: read(2) of fd */
    ssize_t (*read)(struct link *link, uint8_t *bytes, size_t size);
    void (*service)(struct link *link); /* about once a second */
    enum mr_status (*line)(struct link *link, int baud, struct error *error);
    void (*close)(struct link *link); /* NULL: close(2) of fd */
};

#define LINK_INTERFACE_OPTION ",interface=" /* of file: */

#define LINK_BUFFER 65536u
#define USB_TEXT    160u

struct tty;

struct link {
    const struct link_ops *ops;
    const char *form; /* "unix:PATH", as people write it */
    enum link_kind kind;
    int fd;
    char *name;    /* of which it was opened, without the base */
    char *spec;    /* with it */
    uint16_t base; /* of its board on CAN */
    struct link_counters counters;
    /* the counters and `away`: one thread may diagnose a link while another one reads it */
    pthread_mutex_t heard;
    /* is opened, closed or written to: one thread may read a link while another one sends */
    pthread_mutex_t device;
    uint8_t buffer[LINK_BUFFER]; /* read from fd and not yet given on: from `start` to `end` */
    size_t start;
    size_t end;
    uint64_t read_us; /* when the newest of them was read, Unix time */
    /* file: of CAN */
    struct candump_log log;
    bool follows;     /* the bus on which a board says hello: which one is not known yet */
    const char *text; /* read from memory; NULL: from fd */
    size_t text_length, text_at;

    struct error away;      /* why the device is away; MR_OK: it is there */
    uint64_t away_most_us;  /* how long it is waited for */
    uint64_t away_since_us; /* these three monotonic */
    uint64_t retry_us;
    uint64_t service_us;
    uint32_t queue_lost; /* can: the kernel's counter */
    struct tty *tty;     /* serial: */
    /* serial: the adapter that was opened first and is waited for, as text; empty: any there */
    char usb[USB_TEXT];
};

#define LINK_OF(name, form, text) extern const struct link_ops link_##name##_ops;
#include "host/link/kinds.def"

/* Read more into the buffer. MR_OK: there is more; MR_TOO_FEW: none now; MR_CLOSED: end of file;
 * MR_IO. */
enum mr_status link_fill(struct link *link, struct error *error);

/* All of it to a socket or a terminal; waits at most 1 s for room. */
enum mr_status link_write(struct link *link, const uint8_t *bytes, size_t length,
                          struct error *error);

/* Count a trouble. */
void link_trouble(struct link *link, enum link_trouble trouble, uint64_t count);
/* What it hears is counted from now on; `baud`: of the line, 0: it has none. */
void link_hear_anew(struct link *link, int baud);
/* What was counted until now, but for what was sent, and why the device is away. By any thread. */

#endif
