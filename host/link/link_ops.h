/* Functions that each kind of link implements. Only host/link/ includes this file. */
#ifndef MATRIG_HOST_LINK_LINK_OPS_H
#define MATRIG_HOST_LINK_LINK_OPS_H

#include <pthread.h>
#include <stdbool.h>
#include <sys/types.h>

#include "host/base/error.h"
#include "host/link/candump.h"

struct link;

struct link_ops {
    unsigned supported_kinds; /* bit mask of the data that it can carry: 1 << enum link_kind */
    bool is_device;           /* the link is a device: if it disappears, wait for its return */
    bool blocks_sender;       /* the sender waits until its data is read */
    bool is_from_recording;   /* a recording: data arrives as fast as it is read */
    enum mr_status (*open)(struct link *link, const char *path, struct error *error);
    enum mr_status (*receive_frame)(struct link *link, struct link_frame *frame,
                                    struct error *error);
    enum mr_status (*send)(struct link *link, const uint8_t *bytes, size_t length,
                           struct error *error);
    /* all functions below may be NULL */
    /* like read(2); NULL: read(2) from fd */
    ssize_t (*read)(struct link *link, uint8_t *bytes, size_t size);
    void (*service)(struct link *link); /* periodic work, called about once a second */
    enum mr_status (*set_baud)(struct link *link, int baud, struct error *error);
    void (*close)(struct link *link); /* NULL: close(2) of fd */
};

/* option of file: that names the CAN interface in a log */
#define LINK_INTERFACE_OPTION ",interface="

#define LINK_BUFFER_SIZE 65536u
#define USB_TEXT_SIZE    160u

struct tty;

struct link {
    const struct link_ops *ops;
    const char *syntax; /* form of the LINK for messages: "unix:PATH" */
    enum link_kind kind;
    int fd;
    char *name;    /* LINK text given when the link was opened, without the option base= */
    char *spec;    /* LINK text with the option base= */
    uint16_t base; /* base of its board on CAN */
    struct link_counters counters;
    /* Protects the counters and absence_reason: one thread may diagnose a link while a second
     * thread reads it. */
    pthread_mutex_t counters_lock;
    /* Held while the device is opened, closed or written to: one thread may read a link while a
     * second thread sends. */
    pthread_mutex_t device_lock;
    /* bytes read from fd that the caller has not received yet: from buffer_start to buffer_end */
    uint8_t buffer[LINK_BUFFER_SIZE];
    size_t buffer_start;
    size_t buffer_end;
    uint64_t read_us; /* Unix time at which the newest of these bytes were read */
    /* the next two fields are for file: links that carry CAN */
    struct candump_log log;
    /* the bus is not known yet: it will be the first one on which a board sends a hello */
    bool is_bus_unknown;
    const char *text; /* log in memory; NULL: the log is read from fd */
    size_t text_length, text_position;

    struct error absence_reason; /* why the device is away; MR_OK: the device is present */
    uint64_t absence_max_us;     /* how long to wait for the device */
    /* absent_since_us, next_reopen_us and next_service_us are times of the monotonic clock */
    uint64_t absent_since_us;
    uint64_t next_reopen_us;
    uint64_t next_service_us;
    uint32_t kernel_lost_count; /* counter of the kernel, only for can: */
    struct tty *tty;            /* open port, only for serial: */
    /* only for serial: text that identifies the adapter that was opened first. After a
     * disconnection only this adapter is opened again. "": any adapter at the port */
    char adapter[USB_TEXT_SIZE];
};

#define LINK_TRANSPORT(name, syntax, text) extern const struct link_ops link_##name##_ops;
#include "host/link/kinds.def"

/* Reads more bytes into the buffer. MR_OK: there are new bytes. MR_TOO_FEW: none at present.
 * MR_CLOSED: end of file. MR_IO: reading failed. */
enum mr_status link_fill_buffer(struct link *link, struct error *error);

/* Writes all bytes to a socket or a terminal; waits at most 1 s for room. */
enum mr_status link_write(struct link *link, const uint8_t *bytes, size_t length,
                          struct error *error);

void link_count_event(struct link *link, enum link_fault fault, uint64_t count);
/* Restarts the counting of received data. `baud`: rate of the serial line; 0: the link has none. */
void link_restart_counting(struct link *link, int baud);
/* Copies the counters, and why the device is away. Any thread may call it. */

#endif
