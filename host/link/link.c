#include "host/link/link.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "common/wire.h"
#include "host/link/link_ops.h"

static const struct link_ops *const kinds[] = {&link_unix_ops, &link_file_ops};
static const char *const later[] = {"can:", "slcan:", "serial:"};

static bool starts_with(const char *text, const char *prefix)
{
    return strncmp(text, prefix, strlen(prefix)) == 0;
}

static const struct link_ops *find_kind(const char *spec)
{
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        if (starts_with(spec, kinds[i]->prefix))
            return kinds[i];
    }
    return NULL;
}

enum mr_status link_open(const char *spec, enum link_kind kind, struct link **link, struct error *error)
{
    for (size_t i = 0; i < sizeof later / sizeof later[0]; i++) {
        if (starts_with(spec, later[i]))
            return error_set(error, MR_USAGE,
                             "%s links come with a later version: %s; use unix:PATH or file:PATH", later[i],
                             spec);
    }
    const struct link_ops *ops = find_kind(spec);
    if (!ops)
        return error_set(error, MR_USAGE, "not a link: '%s'; write unix:PATH or file:PATH", spec);
    const char *path = spec + strlen(ops->prefix);
    if (!*path)
        return error_set(error, MR_USAGE, "link without a path: '%s'; write %sPATH", spec, ops->prefix);

    struct link *made = calloc(1, sizeof *made);
    char *copy = strdup(spec);
    if (!made || !copy) {
        free(made);
        free(copy);
        return error_set(error, MR_FULL, "no memory: link %s; close other programs", spec);
    }
    made->ops = ops;
    made->kind = kind;
    made->fd = -1;
    made->spec = copy;
    enum mr_status status = ops->open(made, path, error);
    if (status != MR_OK) {
        link_close(made);
        return status;
    }
    *link = made;
    return MR_OK;
}

void link_close(struct link *link)
{
    if (!link)
        return;
    if (link->fd >= 0)
        close(link->fd);
    free(link->spec);
    free(link);
}

int link_fd(const struct link *link)
{
    return link->fd;
}

const char *link_spec(const struct link *link)
{
    return link->spec;
}

const struct link_counters *link_counters(const struct link *link)
{
    return &link->counters;
}

uint64_t link_now_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    return (uint64_t)now.tv_sec * 1000000u + (uint64_t)now.tv_nsec / 1000u;
}

enum mr_status link_fill(struct link *link, struct error *error)
{
    if (link->start > 0) {
        memmove(link->buffer, link->buffer + link->start, link->end - link->start);
        link->end -= link->start;
        link->start = 0;
    }
    ssize_t count = read(link->fd, link->buffer + link->end, sizeof link->buffer - link->end);
    if (count > 0) {
        link->end += (size_t)count;
        link->read_us = link_now_us();
        return MR_OK;
    }
    /* A socket whose other side ended while it had unread bytes of ours says so as a reset: to us it is the
     * end. */
    if (count == 0 || errno == ECONNRESET)
        return MR_CLOSED;
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)
        return MR_TOO_FEW;
    return error_set(error, MR_IO, "cannot read (%s): %s; check the device or file", strerror(errno),
                     link->spec);
}

enum mr_status link_receive_frame(struct link *link, struct link_frame *frame, struct error *error)
{
    enum mr_status status = link->ops->receive_frame(link, frame, error);
    if (status == MR_OK)
        link->counters.received++;
    return status;
}

enum mr_status link_receive_bytes(struct link *link, uint8_t *bytes, size_t size, size_t *length,
                                  uint64_t *host_us, struct error *error)
{
    if (link->start == link->end) {
        enum mr_status status = link_fill(link, error);
        if (status != MR_OK)
            return status;
    }
    size_t count = link->end - link->start;
    if (count > size)
        count = size;
    memcpy(bytes, link->buffer + link->start, count);
    link->start += count;
    link->counters.received += count;
    *length = count;
    *host_us = link->read_us;
    return MR_OK;
}

enum mr_status link_send_frame(struct link *link, const struct link_frame *frame, struct error *error)
{
    uint8_t bytes[16] = {0};
    mr_put_u32(bytes, frame->id);
    bytes[4] = frame->length;
    memcpy(bytes + 8, frame->data, frame->length);
    enum mr_status status = link->ops->send(link, bytes, sizeof bytes, error);
    if (status == MR_OK)
        link->counters.sent++;
    return status;
}

enum mr_status link_send_bytes(struct link *link, const uint8_t *bytes, size_t length, struct error *error)
{
    enum mr_status status = link->ops->send(link, bytes, length, error);
    if (status == MR_OK)
        link->counters.sent += length;
    return status;
}
