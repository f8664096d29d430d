/* file:PATH, what was recorded earlier (a `candump -L` log, or serial bytes), or a pipe that
 * another program fills. */
#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/link/candump.h"
#include "host/link/link_ops.h"

/* A log is text, serial bytes are not: the one in the other's place is named. */
static enum mr_status check_kind(struct link *link, struct error *error)
{
    char head[65] = "";
    ssize_t length = pread(link->fd, head, sizeof head - 1, 0);
    bool log = length > 4 && head[0] == '(' && isdigit((unsigned char)head[1]) &&
               strstr(head, ") ") && strchr(head, '#');
    bool bytes = length > 0 && memchr(head, 0, (size_t)length) && !log;
    if (link->kind == LINK_SERIAL && log)
        return error_set(error, MR_MALFORMED,
                         "a candump log, no serial bytes: %s; give it as --can", link->spec);
    if (link->kind == LINK_CAN && bytes)
        return error_set(error, MR_MALFORMED,
                         "serial bytes, no candump log: %s; give it as --serial", link->spec);
    return MR_OK;
}

static enum mr_status file_open(struct link *link, const char *path, struct error *error)
{
    struct stat info;
    link->fd = open(path, O_RDONLY | O_CLOEXEC);
    if (link->fd < 0)
        return error_set(error, MR_IO, "cannot open (%s): %s; check the path", strerror(errno),
                         link->spec);
    if (fstat(link->fd, &info) == 0 && S_ISDIR(info.st_mode))
        return error_set(error, MR_IO, "cannot open (it is a directory): %s; name a file",
                         link->spec);
    if (S_ISREG(info.st_mode) && check_kind(link, error) != MR_OK)
        return error->status;
    /* A pipe that another program still writes to must not block us. */
    if (fcntl(link->fd, F_SETFL, O_NONBLOCK) != 0)
        return error_set(error, MR_IO, "cannot set up (%s): %s; try again", strerror(errno),
                         link->spec);
    return MR_OK;
}

/* Takes the next line out of the buffer; `*length` without the newline. `*complete` is false when
 * the file ended first. */
static enum mr_status take_line(struct link *link, const char **line, size_t *length,
                                bool *complete, struct error *error)
{
    size_t searched = 0;
    for (;;) {
        const uint8_t *from = link->buffer + link->start;
        const uint8_t *newline = memchr(from + searched, '\n', link->end - link->start - searched);
        *line = (const char *)from;
        if (newline) {
            *length = (size_t)(newline - from);
            *complete = true;
            link->start += *length + 1;
            link->line++;
            return MR_OK;
        }
        searched = link->end - link->start;
        if (searched > CANDUMP_LINE_MAX)
            return error_set(error, MR_MALFORMED,
                             "no candump line: %s line %lu; give a log that `candump -L` wrote",
                             link->spec, link->line + 1);
        enum mr_status status = link_fill(link, error);
        if (status == MR_CLOSED && searched > 0) {
            *line = (const char *)link->buffer + link->start;
            *length = searched;
            *complete = false;
            link->start = link->end;
            link->line++;
            return MR_OK;
        }
        if (status != MR_OK)
            return status;
    }
}

static enum mr_status file_receive_frame(struct link *link, struct link_frame *frame,
                                         struct error *error)
{
    const char *line;
    size_t length;
    bool complete;
    do {
        enum mr_status status = take_line(link, &line, &length, &complete, error);
        if (status != MR_OK)
            return status;
    } while (length == 0);
    enum mr_status status = candump_parse(line, length, frame);
    if (status == MR_OK && complete)
        return MR_OK;
    if (!complete)
        return error_set(error, MR_TRUNCATED,
                         "the log ends inside a line: %s line %lu; the frames before it are kept",
                         link->spec, link->line);
    return error_set(error, MR_MALFORMED,
                     "no candump line: %s line %lu; give a log that `candump -L` wrote", link->spec,
                     link->line);
}

static enum mr_status file_send(struct link *link, const uint8_t *bytes, size_t length,
                                struct error *error)
{
    (void)bytes;
    (void)length;
    return error_set(error, MR_NOT_NOW, "a recorded file takes no commands: %s; use a live link",
                     link->spec);
}

const struct link_ops link_file_ops = {
    .kinds = 1u << LINK_CAN | 1u << LINK_SERIAL,
    .waits = true,
    .recorded = true,
    .open = file_open,
    .receive_frame = file_receive_frame,
    .send = file_send,
};
