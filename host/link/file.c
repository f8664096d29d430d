/* The link kind file:PATH: a recording (a `candump -L` log or serial bytes), or a pipe that another
 * program fills. file:PATH,interface=can1 selects one bus of a log with several. */
#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "common/catalogue.h"
#include "host/link/candump.h"
#include "host/link/link_ops.h"

/* Checks that a log is text, or that serial bytes are not. Otherwise the error message names the
 * kind that was probably meant. */
static enum mr_status check_file_content(struct link *link, struct error *error)
{
    char head[65] = "";
    ssize_t length = pread(link->fd, head, sizeof head - 1, 0);
    bool log = length > 4 && head[0] == '(' && isdigit((unsigned char)head[1]) &&
               strstr(head, ") ") && strchr(head, '#');
    bool bytes = length > 0 && memchr(head, 0, (size_t)length) && !log;
    if (link->kind == LINK_SERIAL && log)
        return error_set(error, MR_MALFORMED,
                         "the file is a candump log, not serial data: %s; give the file with --can",
                         link->spec);
    if (link->kind == LINK_CAN && bytes)
        return error_set(
            error, MR_MALFORMED,
            "the file is serial data, not a candump log: %s; give the file with --serial",
            link->spec);
    return MR_OK;
}

/* ---- boards on the interfaces of a log ---- */

#define BUSES_MAX 16u
struct buses {
    struct bus {
        char name[CANDUMP_INTERFACE_SIZE];
        uint64_t hello_count;
        bool has_matching_layout; /* a hello of this layout was received on the bus */
    } bus[BUSES_MAX];             /* buses in order of appearance */
    size_t count;
};

static struct bus *find_bus(struct buses *buses, const struct candump_line *line)
{
    for (size_t i = 0; i < buses->count; i++) {
        if (candump_is_from_interface(line, buses->bus[i].name))
            return &buses->bus[i];
    }
    if (buses->count == BUSES_MAX || line->interface_length >= CANDUMP_INTERFACE_SIZE)
        return NULL;
    struct bus *bus = &buses->bus[buses->count++];
    *bus = (struct bus){0};
    memcpy(bus->name, line->interface, line->interface_length);
    return bus;
}

/* Adds a line to the counts of its bus. Returns false if there are too many buses. */
static bool count_bus_line(struct buses *buses, const struct candump_line *line, uint16_t base)
{
    const struct link_frame *frame = &line->frame;
    struct bus *bus = find_bus(buses, line);
    struct mr_message message;
    if (!bus)
        return false;
    if (link_id_from_bus(frame->id, base) == MR_ID_HELLO &&
        mr_message_decode(&message, MR_ID_HELLO, frame->data, frame->length) == MR_OK) {
        bus->hello_count++;
        bus->has_matching_layout |= message.as.hello.layout == MR_LAYOUT;
    }
    return true;
}

/* Returns 2 if a board of this layout is on the bus, 1 for another board, 0 for none. */
static unsigned compute_bus_rank(const struct bus *bus)
{
    return bus->has_matching_layout ? 2 : bus->hello_count > 0;
}

/* Lists all buses of at least the rank `least`: "can0, can1 and can2". */
static void list_buses(const struct buses *buses, unsigned least, char *out, size_t size)
{
    size_t of = 0, used = 0, k = 0;
    for (size_t i = 0; i < buses->count; i++)
        of += compute_bus_rank(&buses->bus[i]) >= least;
    out[0] = '\0';
    for (size_t i = 0; i < buses->count && used < size; i++) {
        if (compute_bus_rank(&buses->bus[i]) < least)
            continue;
        k++;
        used += (size_t)snprintf(out + used, size - used, "%s%s",
                                 k == 1    ? ""
                                 : k == of ? " and "
                                           : ", ",
                                 buses->bus[i].name);
    }
}

/* Selects the bus `named`; NULL: the bus on which a board sends, or the first bus if there is no
 * board. MR_USAGE: there are boards on several buses, or no bus has that name. */
static enum mr_status select_bus(const struct buses *buses, const char *named, const char *where,
                                 char interface[CANDUMP_INTERFACE_SIZE], struct error *error)
{
    char names[300];
    size_t best = 0, as_good = 0;
    interface[0] = '\0';
    for (size_t i = 0; i < buses->count; i++) {
        const struct bus *bus = &buses->bus[i];
        if (named && strcmp(named, bus->name) == 0) {
            memcpy(interface, bus->name, CANDUMP_INTERFACE_SIZE);
            return MR_OK;
        }
        if (compute_bus_rank(bus) > compute_bus_rank(&buses->bus[best]))
            best = i;
    }
    if (buses->count == 0)
        return MR_OK;
    unsigned least = compute_bus_rank(&buses->bus[best]);
    if (named) {
        list_buses(buses, 0, names, sizeof names);
        return error_set(
            error, MR_USAGE,
            "the log has no frame of interface %s: %s; give one of its interfaces (%s)", named,
            where, names);
    }
    for (size_t i = 0; i < buses->count; i++)
        as_good += compute_bus_rank(&buses->bus[i]) == least;
    if (least > 0 && as_good > 1) {
        list_buses(buses, least, names, sizeof names);
        return error_set(error, MR_USAGE,
                         "several buses in the log have a board (%s): %s; select one bus with "
                         "file:PATH,interface=%s, or matrig import --interface %s",
                         names, where, buses->bus[best].name, buses->bus[best].name);
    }
    memcpy(interface, buses->bus[best].name, CANDUMP_INTERFACE_SIZE);
    return MR_OK;
}

/* ---- the link ---- */

/* after this many invalid lines without a frame, the file is not accepted as a log */
#define BAD_LINES_MAX  1000u
/* after this many bytes without a newline, the file is not accepted as a log */
#define LINE_BYTES_MAX 100000000u

/* Removes the next line from the buffer; `*length` excludes the newline. `*whole` is false if the
 * file ends before the newline. A very long line is truncated. MR_MALFORMED: LINE_BYTES_MAX bytes
 * without a newline. */
static enum mr_status read_line(struct link *link, const char **line, size_t *length, bool *whole,
                                struct error *error)
{
    size_t searched = 0, cut = 0;
    for (;;) {
        const uint8_t *from = link->buffer + link->buffer_start;
        const uint8_t *newline = memchr(from + searched, '\n',
                                        link->buffer_end - link->buffer_start - searched);
        *line = (const char *)from;
        *whole = newline != NULL;
        if (newline) {
            *length = (size_t)(newline - from);
            link->buffer_start += *length + 1;
            return MR_OK;
        }
        searched = link->buffer_end - link->buffer_start;
        if (searched > CANDUMP_LINE_SIZE) {
            cut += searched - CANDUMP_LINE_SIZE;
            if (cut > LINE_BYTES_MAX)
                return error_set(error, MR_MALFORMED,
                                 "the file has no end of line in %u bytes: %s; give a log that "
                                 "`candump -L` wrote",
                                 LINE_BYTES_MAX, link->spec);
            searched = CANDUMP_LINE_SIZE;
            link->buffer_end = link->buffer_start + searched;
        }
        enum mr_status status = link_fill_buffer(link, error);
        if (status == MR_CLOSED && searched > 0) {
            *line = (const char *)link->buffer + link->buffer_start;
            *length = searched;
            link->buffer_start = link->buffer_end;
            return MR_OK;
        }
        if (status != MR_OK)
            return status;
    }
}

#define PRINTABLE_CHARS_MAX 40u
/* Copies an invalid line and makes it printable. */
static void make_printable(const char *text, size_t length, char seen[PRINTABLE_CHARS_MAX + 1])
{
    size_t i = 0;
    for (; i < length && i < PRINTABLE_CHARS_MAX; i++)
        seen[i] = (char)(text[i] < ' ' || text[i] > '~' ? '?' : text[i]);
    seen[i] = '\0';
}

/* Selects the bus of a log. A log in a regular file is searched for boards first. */
static enum mr_status detect_bus(struct link *link, const char *named, struct error *error)
{
    struct buses *buses = calloc(1, sizeof *buses);
    struct candump_log log = {0};
    struct candump_line line;
    const char *text;
    size_t length;
    bool whole, room = buses != NULL;
    char seen[PRINTABLE_CHARS_MAX + 1] = "";
    enum mr_status status = MR_OK;
    while (room && (status = read_line(link, &text, &length, &whole, error)) == MR_OK) {
        if (candump_log_parse_line(&log, text, length, whole, &line))
            room = count_bus_line(buses, &line, link->base);
        else if (!seen[0])
            make_printable(text, length, seen);
    }
    if (!buses)
        status = error_set(error, MR_FULL,
                           "out of memory while reading link %s; close other programs", link->spec);
    else if (!room)
        status = error_set(error, MR_LIMIT,
                           "frames of more than %u buses, or a bus name that is too long: %s line "
                           "%zu; extract the frames of one bus (grep \" can0 \")",
                           BUSES_MAX, link->spec, log.line_number);
    else if (status == MR_CLOSED && buses->count == 0 && log.result.status != MR_OK)
        status = error_set(error, MR_MALFORMED,
                           "not a CAN frame: %s line %zu, column %zu: '%s'; give a log that "
                           "`candump -L` wrote (for tables use matrig import --map)",
                           link->spec, log.result.line, log.result.column, seen);
    else if (status == MR_CLOSED)
        status = select_bus(buses, named, link->spec, link->log.interface, error);
    free(buses);
    link->buffer_start = link->buffer_end = link->text_position = 0;
    if (status == MR_OK && !link->text && lseek(link->fd, 0, SEEK_SET) != 0)
        return error_set(error, MR_IO, "cannot read again (%s): %s; check the file",
                         strerror(errno), link->spec);
    return status;
}

static enum mr_status file_open(struct link *link, const char *spec_text, struct error *error)
{
    struct stat info;
    char path[LINK_SPEC_SIZE];
    snprintf(path, sizeof path, "%s", spec_text);
    char *named = strrchr(path, ',');
    if (link->kind != LINK_CAN || !named ||
        strncmp(named, LINK_INTERFACE_OPTION, sizeof LINK_INTERFACE_OPTION - 1) != 0) {
        named = NULL;
    } else {
        *named = '\0';
        named += sizeof LINK_INTERFACE_OPTION - 1;
    }
    if (named && (!*named || strlen(named) >= CANDUMP_INTERFACE_SIZE))
        return error_set(error, MR_USAGE,
                         "missing interface: '%s' of %s; write file:PATH,interface=can0", named,
                         link->spec);
    if (link->text)
        return detect_bus(link, named, error);
    /* With O_NONBLOCK, open does not wait for the writer of a named pipe; such a wait could not be
     * interrupted by signals. */
    link->fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (link->fd < 0)
        return error_set(error, MR_IO, "cannot open (%s): %s; check the path", strerror(errno),
                         link->spec);
    if (fstat(link->fd, &info) == 0 && S_ISDIR(info.st_mode))
        return error_set(error, MR_IO, "the path is a directory: %s; give the name of a file",
                         link->spec);
    if (S_ISREG(info.st_mode) && check_file_content(link, error) != MR_OK)
        return error->status;
    if (named)
        strcpy(link->log.interface, named);
    if (link->kind == LINK_CAN && S_ISREG(info.st_mode))
        return detect_bus(link, named, error);
    link->is_bus_unknown = link->kind == LINK_CAN && !named;
    /* Reading a pipe must not block while its writer is still running. */
    if (fcntl(link->fd, F_SETFL, O_NONBLOCK) != 0)
        return error_set(error, MR_IO, "cannot set up (%s): %s; try again", strerror(errno),
                         link->spec);
    return MR_OK;
}

/* True for a named pipe to which no program has written since it was opened. */
static bool is_waiting_for_writer(const struct link *link)
{
    struct stat info;
    struct pollfd end = {.fd = link->fd, .events = POLLIN};
    return fstat(link->fd, &info) == 0 && S_ISFIFO(info.st_mode) && poll(&end, 1, 0) == 0;
}

static ssize_t file_read(struct link *link, uint8_t *bytes, size_t size)
{
    if (!link->text) {
        ssize_t count = read(link->fd, bytes, size);
        if (count != 0 || !is_waiting_for_writer(link))
            return count;
        errno = EAGAIN;
        return -1;
    }
    size_t left = link->text_length - link->text_position, count = left < size ? left : size;
    memcpy(bytes, link->text + link->text_position, count);
    link->text_position += count;
    return (ssize_t)count;
}

/* Follows the bus with the board in a pipe. The first bus is read until a board sends a hello on
 * another bus. */
static void update_board_bus(struct link *link, const struct candump_line *line)
{
    struct buses buses = {.count = 0};
    if (!link->is_bus_unknown || !count_bus_line(&buses, line, link->base))
        return;
    if (buses.bus[0].hello_count > 0 || !link->log.interface[0])
        memcpy(link->log.interface, buses.bus[0].name, CANDUMP_INTERFACE_SIZE);
    link->is_bus_unknown = buses.bus[0].hello_count == 0;
}

static enum mr_status file_receive_frame(struct link *link, struct link_frame *frame,
                                         struct error *error)
{
    struct candump_log *log = &link->log;
    struct candump_line line;
    const char *text;
    size_t length;
    bool whole, has_frame = false;
    char verdict[300];
    while (!has_frame) {
        enum mr_status status = read_line(link, &text, &length, &whole, error);
        if (status == MR_CLOSED && log->result.status != MR_OK) {
            parse_result_text(&log->result, verdict, sizeof verdict);
            return error_set(error, log->result.status, "%s: %s; the valid part was stored",
                             verdict, link->spec);
        }
        if (status != MR_OK)
            return status;
        uint64_t elsewhere = log->other_interface_frames;
        has_frame = candump_log_parse_line(log, text, length, whole, &line);
        if (link->is_bus_unknown && (has_frame || log->other_interface_frames != elsewhere)) {
            update_board_bus(link, &line);
            has_frame = candump_is_from_interface(&line, log->interface);
            log->other_interface_frames = elsewhere + !has_frame;
        }
        link->counters.bad_lines = log->result.bad_lines;
        link->counters.other_interface_frames = log->other_interface_frames;
        const struct link_counters *c = &link->counters;
        if (!has_frame && c->received_count + c->error_frames + c->other_interface_frames == 0 &&
            c->bad_lines >= BAD_LINES_MAX)
            return error_set(
                error, MR_MALFORMED,
                "the first %zu lines contain no CAN frame: %s; give a log that `candump -L` wrote",
                log->line_number, link->spec);
    }
    *frame = line.frame;
    return MR_OK;
}

static enum mr_status file_send(struct link *link, const uint8_t *bytes, size_t length,
                                struct error *error)
{
    (void)bytes;
    (void)length;
    return error_set(error, MR_NOT_NOW,
                     "cannot send commands to a recorded file: %s; use a live link", link->spec);
}

const struct link_ops link_file_ops = {
    .supported_kinds = 1u << LINK_CAN | 1u << LINK_SERIAL,
    .blocks_sender = true,
    .is_from_recording = true,
    .open = file_open,
    .receive_frame = file_receive_frame,
    .read = file_read,
    .send = file_send,
};
