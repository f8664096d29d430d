#include "host/link/link.h"

#include <ctype.h>
#include <errno.h>
#include <linux/can/error.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "common/canbase.h"
#include "common/framing.h"
#include "common/wire.h"
#include "host/base/monotonic_clock.h"
#include "host/link/link_ops.h"

#define REOPEN_PERIOD_US        250000u
#define DEVICE_ABSENCE_MAX_US   10000000u
#define SERVICE_PERIOD_US       1000000u
#define SEND_TIMEOUT_MS         1000 /* longest time to wait for room when sending, ms */
/* A reading of both clocks that took longer than this was interrupted and is repeated. */
#define CLOCK_READING_MAX_US    50
#define CLOCK_READING_TRIES_MAX 10

static const struct transport {
    const char *prefix, *syntax;
    const struct link_ops *ops;
} transports[] = {
#define LINK_TRANSPORT(name, syntax, text) {#name ":", syntax, &link_##name##_ops},
#include "host/link/kinds.def"
};
#define TRANSPORT_COUNT (sizeof transports / sizeof transports[0])

#define BASE_OPTION ",base="

static const struct transport *find_transport(const char *spec)
{
    for (size_t i = 0; i < TRANSPORT_COUNT; i++) {
        if (strncmp(spec, transports[i].prefix, strlen(transports[i].prefix)) == 0)
            return &transports[i];
    }
    return NULL;
}

/* size of a list of link forms, such as "unix:PATH, file:PATH or pty:PATH" */
#define LINK_SYNTAX_LIST_SIZE 200u
static void list_link_syntaxes(char out[LINK_SYNTAX_LIST_SIZE])
{
    size_t n = 0;
    for (size_t i = 0; i < TRANSPORT_COUNT && n < LINK_SYNTAX_LIST_SIZE; i++)
        n += (size_t)snprintf(out + n, LINK_SYNTAX_LIST_SIZE - n, "%s%s",
                              i == 0                    ? ""
                              : i + 1 < TRANSPORT_COUNT ? ", "
                                                        : " or ",
                              transports[i].syntax);
}

enum mr_status link_check(const char *spec, struct error *error)
{
    char forms[LINK_SYNTAX_LIST_SIZE];
    if (find_transport(spec))
        return MR_OK;
    struct stat file;
    const char *ending = strrchr(spec, '.');
    if (ending && strcmp(ending, ".log") == 0 && stat(spec, &file) == 0 && S_ISREG(file.st_mode))
        return error_set(error, MR_USAGE, "not a link: '%s'; give a recorded file as file:%s", spec,
                         spec);
    list_link_syntaxes(forms);
    return error_set(error, MR_USAGE, "not a link: '%s'; write %s", spec, forms);
}

enum mr_status link_parse_base_number(const char *text, const char *where, uint16_t *base,
                                      struct error *error)
{
    bool hex = text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
    const char *digits = text + (hex ? 2 : 0);
    char *end;
    unsigned long value = strtoul(digits, &end, hex ? 16 : 10);
    if (!isxdigit((unsigned char)*digits) || *end || strlen(digits) > 8)
        return error_set(error, MR_USAGE,
                         "not a base of CAN identifiers: '%s' of %s; write a number such as 0x190",
                         text, where);
    if (value > MR_CAN_BASE_MAX)
        return error_set(error, MR_USAGE,
                         "base 0x%03lx is too large: %s; give at most 0x%03x, so that no "
                         "identifier exceeds 0x%x",
                         value, where, MR_CAN_BASE_MAX, MR_CAN_ID_MAX);
    *base = (uint16_t)value;
    return MR_OK;
}

enum mr_status link_split_base(char *spec, uint16_t *base, struct error *error)
{
    char whole[LINK_SPEC_SIZE];
    char *at = strrchr(spec, ',');
    *base = 0;
    if (!at || strncmp(at, BASE_OPTION, sizeof BASE_OPTION - 1) != 0)
        return MR_OK;
    snprintf(whole, sizeof whole, "%s", spec);
    *at = '\0';
    return link_parse_base_number(at + sizeof BASE_OPTION - 1, whole, base, error);
}

bool link_is_can(const char *spec)
{
    return strncmp(spec, "can:", 4) == 0;
}

bool link_is_device(const char *spec)
{
    const struct transport *kind = find_transport(spec);
    return kind && kind->ops->is_device;
}

/* ---- links ---- */

const char *link_fault_text(unsigned fault)
{
    static const char *const texts[] = {
#define LINK_FAULT_TEXT(name, text) text,
        LINK_FAULT_TABLE(LINK_FAULT_TEXT)
#undef LINK_FAULT_TEXT
    };
    return fault < LINK_FAULT_COUNT ? texts[fault] : "unknown trouble";
}

/* Counts received bytes and frames, until the first valid frame. */
static void count_received_bytes(struct link_rx *rx, const uint8_t *bytes, size_t length)
{
    rx->bytes += length;
    for (size_t i = 0; i < length && rx->valid_frames == 0; i++) {
        struct mr_frame frame;
        enum mr_status status = mr_deframer_push(&rx->deframer, bytes[i], &frame);
        rx->valid_frames += status == MR_OK;
        rx->bad_frames += status != MR_OK && status != MR_TOO_FEW;
    }
}

/* Returns the path of a link: the text after the name of the kind. */
static const char *get_spec_path(const char *spec)
{
    return strchr(spec, ':') + 1;
}

/* Closes the device, but not the link. */
static void close_handle(struct link *link)
{
    if (link->ops->close)
        link->ops->close(link);
    else if (link->fd >= 0)
        close(link->fd);
    link->fd = -1;
}

static void format_spec(struct link *link)
{
    if (link->base)
        sprintf(link->spec, "%s" BASE_OPTION "0x%03x", link->name, link->base);
    else
        strcpy(link->spec, link->name);
}

/* Opens the link `spec`. If `text` is not NULL, reads this text instead of the device or file. */
static enum mr_status open_spec(const char *spec, enum link_kind kind, uint16_t base,
                                const char *text, size_t length, struct link **link,
                                struct error *error)
{
    if (link_check(spec, error) != MR_OK)
        return error->status;
    const struct transport *found = find_transport(spec);
    const char *path = get_spec_path(spec);
    if (!*path)
        return error_set(error, MR_USAGE, "link without a path: '%s'; write %s", spec,
                         found->syntax);
    if (!(found->ops->supported_kinds & 1u << kind))
        return error_set(error, MR_USAGE, "%s cannot carry %s: %s; give the link with %s",
                         found->syntax, kind == LINK_CAN ? "CAN frames" : "serial bytes", spec,
                         kind == LINK_CAN ? "--serial" : "--can");

    struct link *made = calloc(1, sizeof *made);
    char *name = strdup(spec), *whole = malloc(strlen(spec) + sizeof BASE_OPTION "0x190");
    if (!made || !name || !whole) {
        free(made);
        free(name);
        free(whole);
        return error_set(error, MR_FULL,
                         "out of memory while opening link %s; close other programs", spec);
    }
    made->ops = found->ops;
    made->syntax = found->syntax;
    made->kind = kind;
    made->fd = -1;
    made->name = name;
    made->spec = whole;
    made->base = base;
    made->text = text;
    made->text_length = length;
    format_spec(made);
    made->absence_max_us = DEVICE_ABSENCE_MAX_US;
    pthread_mutex_init(&made->device_lock, NULL);
    pthread_mutex_init(&made->counters_lock, NULL);
    link_restart_counting(made, 0);
    enum mr_status status = made->ops->open(made, path, error);
    if (status != MR_OK) {
        link_close(made);
        return status;
    }
    *link = made;
    return MR_OK;
}

enum mr_status link_open(const char *text, enum link_kind kind, struct link **link,
                         struct error *error)
{
    char spec[LINK_SPEC_SIZE];
    uint16_t base = 0;
    snprintf(spec, sizeof spec, "%s", text);
    if (kind == LINK_CAN && link_split_base(spec, &base, error) != MR_OK)
        return error->status;
    return open_spec(spec, kind, base, NULL, 0, link, error);
}

enum mr_status link_open_text(const char *text, size_t length, const char *path, uint16_t base,
                              const char *interface, struct link **link, struct error *error)
{
    char spec[LINK_SPEC_SIZE];
    snprintf(spec, sizeof spec, "file:%s%s%s", path, interface ? LINK_INTERFACE_OPTION : "",
             interface ? interface : "");
    return open_spec(spec, LINK_CAN, base, text, length, link, error);
}

const struct candump_log *link_candump(const struct link *link)
{
    return &link->log;
}

void link_close(struct link *link)
{
    if (!link)
        return;
    close_handle(link);
    pthread_mutex_destroy(&link->device_lock);
    pthread_mutex_destroy(&link->counters_lock);
    free(link->name);
    free(link->spec);
    free(link);
}

void link_set_absence_limit(struct link *link, double seconds)
{
    link->absence_max_us = (uint64_t)(seconds * 1e6);
}

bool link_blocks_sender(const struct link *link)
{
    return link->ops->blocks_sender;
}

bool link_is_from_recording(const struct link *link)
{
    return link->ops->is_from_recording;
}

uint16_t link_base(const struct link *link)
{
    return link->base;
}

void link_set_base(struct link *link, uint16_t base)
{
    link->base = base;
    format_spec(link);
}

int link_fd(const struct link *link)
{
    return link->fd;
}

const char *link_get_spec(const struct link *link)
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

uint64_t link_wall_clock_offset_us(void)
{
    uint64_t ahead_us = 0, least_us = UINT64_MAX;
    for (int i = 0; i < CLOCK_READING_TRIES_MAX && least_us > CLOCK_READING_MAX_US; i++) {
        uint64_t before_us = monotonic_us(), now_us = link_now_us(),
                 width_us = monotonic_us() - before_us;
        if (width_us < least_us) {
            least_us = width_us;
            ahead_us = now_us - before_us - width_us / 2;
        }
    }
    return ahead_us;
}

void link_count_event(struct link *link, enum link_fault fault, uint64_t count)
{
    pthread_mutex_lock(&link->counters_lock);
    link->counters.fault_count[fault] += count;
    link->counters.fault_total += count;
    pthread_mutex_unlock(&link->counters_lock);
}

void link_restart_counting(struct link *link, int baud)
{
    pthread_mutex_lock(&link->counters_lock);
    link->counters.rx = (struct link_rx){.start_us = monotonic_us(), .baud = baud};
    mr_deframer_init(&link->counters.rx.deframer);
    pthread_mutex_unlock(&link->counters_lock);
}

static void copy_counters(const struct link *link, struct link_counters *counters,
                          struct error *away)
{
    pthread_mutex_t *lock = (pthread_mutex_t *)&link->counters_lock;
    pthread_mutex_lock(lock);
    counters->received_count = link->counters.received_count;
    counters->error_frames = link->counters.error_frames;
    counters->rx = link->counters.rx;
    memcpy(counters->fault_count, link->counters.fault_count, sizeof counters->fault_count);
    *away = link->absence_reason;
    pthread_mutex_unlock(lock);
}

static void set_device_absent(struct link *link, const struct error *why)
{
    pthread_mutex_lock(&link->counters_lock);
    link->absence_reason = *why;
    pthread_mutex_unlock(&link->counters_lock);
}

/* Closes a device that has disappeared, stores the reason, and starts waiting for its return. */
static void close_device(struct link *link, const struct error *why)
{
    pthread_mutex_lock(&link->device_lock);
    close_handle(link);
    set_device_absent(link, why);
    pthread_mutex_unlock(&link->device_lock);
    link->absent_since_us = monotonic_us();
    link->next_reopen_us = link->absent_since_us + REOPEN_PERIOD_US;
    link->buffer_start = link->buffer_end = 0;
    link_count_event(link, LINK_AWAY, 1);
}

static enum mr_status reopen_device(struct link *link, uint64_t now_us, struct error *error)
{
    struct error why = {0};
    if (now_us < link->next_reopen_us)
        return MR_TOO_FEW;
    link->next_reopen_us = now_us + REOPEN_PERIOD_US;
    pthread_mutex_lock(&link->device_lock);
    bool back = link->ops->open(link, get_spec_path(link->name), &why) == MR_OK;
    if (back)
        set_device_absent(link, &(struct error){0});
    else
        close_handle(link);
    pthread_mutex_unlock(&link->device_lock);
    if (back) {
        link_count_event(link, LINK_BACK, 1);
        return MR_OK;
    }
    if (now_us - link->absent_since_us < link->absence_max_us)
        return MR_TOO_FEW;
    return error_set(error, link->absence_reason.status,
                     "%.400s (waited %.3g s for the device; now: %.400s)",
                     link->absence_reason.text, (double)link->absence_max_us / 1e6, why.text);
}

enum mr_status link_service(struct link *link, struct error *error)
{
    uint64_t now_us = monotonic_us();
    if (link->absence_reason.status != MR_OK)
        return reopen_device(link, now_us, error);
    /* Sending may hold the lock for up to a second. Receiving does not wait for the lock; only
     * `service` does. */
    if (link->ops->service && now_us >= link->next_service_us &&
        pthread_mutex_trylock(&link->device_lock) == 0) {
        link->next_service_us = now_us + SERVICE_PERIOD_US;
        link->ops->service(link);
        pthread_mutex_unlock(&link->device_lock);
    }
    return MR_OK;
}

/* Returns the status of a reception to the caller. A device that broke but may return is reported
 * as absent, which is not an error yet. */
static enum mr_status handle_receive_status(struct link *link, enum mr_status status,
                                            const struct error *found, struct error *error)
{
    if (status == MR_IO && link->ops->is_device) {
        close_device(link, found);
        return MR_TOO_FEW;
    }
    if (status != MR_OK && status != MR_TOO_FEW && status != MR_CLOSED)
        error_set(error, status, "%s", found->text);
    return status;
}

static ssize_t read_bytes(struct link *link, uint8_t *bytes, size_t size)
{
    return link->ops->read ? link->ops->read(link, bytes, size) : read(link->fd, bytes, size);
}

enum mr_status link_fill_buffer(struct link *link, struct error *error)
{
    if (link->buffer_start > 0) {
        memmove(link->buffer, link->buffer + link->buffer_start,
                link->buffer_end - link->buffer_start);
        link->buffer_end -= link->buffer_start;
        link->buffer_start = 0;
    }
    ssize_t count = read_bytes(link, link->buffer + link->buffer_end,
                               sizeof link->buffer - link->buffer_end);
    if (count > 0) {
        link->buffer_end += (size_t)count;
        link->read_us = link_now_us();
        return MR_OK;
    }
    /* A reset means the end too: the socket reports it if the other side ends without having read
     * all bytes of this link. */
    if (count == 0 || errno == ECONNRESET)
        return MR_CLOSED;
    if (errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR)
        return MR_TOO_FEW;
    if (errno == ENODEV)
        return error_set(error, MR_IO, "the device was disconnected: %s; plug it in again",
                         link->spec);
    return error_set(error, MR_IO, "cannot read (%s): %s; check the device or file",
                     strerror(errno), link->spec);
}

/* ---- error frames, as SocketCAN makes them: the class of the error in the identifier, details in
 * the data (linux/can/error.h) ---- */

static uint32_t get_controller_faults(uint8_t state)
{
    uint32_t faults = 0;
    if (state & CAN_ERR_CRTL_RX_OVERFLOW)
        faults |= 1u << LINK_RX_OVERFLOW;
    if (state & CAN_ERR_CRTL_TX_OVERFLOW)
        faults |= 1u << LINK_TX_OVERFLOW;
    if (state & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING))
        faults |= 1u << LINK_ERROR_WARNING;
    if (state & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE))
        faults |= 1u << LINK_ERROR_PASSIVE;
    if (state & CAN_ERR_CRTL_ACTIVE)
        faults |= 1u << LINK_ERROR_ACTIVE;
    return faults;
}

/* Returns bit 1 << enum link_fault for each fault in an error frame; at least one is set. */
static uint32_t get_error_frame_faults(const struct link_frame *frame)
{
    static const struct {
        uint32_t class_bit;
        enum link_fault fault;
    } classes[] = {
        {CAN_ERR_BUSOFF, LINK_BUS_OFF},
        {CAN_ERR_RESTARTED, LINK_RESTARTED},
        {CAN_ERR_ACK, LINK_NO_ACK},
        {CAN_ERR_LOSTARB, LINK_ARBITRATION_LOST},
        {CAN_ERR_PROT, LINK_PROTOCOL_ERROR},
        {CAN_ERR_BUSERROR, LINK_BUS_ERROR},
        {CAN_ERR_TX_TIMEOUT, LINK_TX_TIMEOUT},
        {CAN_ERR_TRX, LINK_TRANSCEIVER},
    };
    uint32_t faults = 0;
    for (size_t i = 0; i < sizeof classes / sizeof classes[0]; i++) {
        if (frame->id & classes[i].class_bit)
            faults |= 1u << classes[i].fault;
    }
    if (frame->id & CAN_ERR_CRTL)
        faults |= get_controller_faults(frame->data[1]);
    return faults ? faults : 1u << LINK_OTHER_ERROR;
}

static void count_link_faults(struct link *link, uint32_t faults)
{
    for (unsigned i = 0; i < LINK_FAULT_COUNT; i++) {
        if (faults & 1u << i)
            link_count_event(link, (enum link_fault)i, 1);
    }
}

enum mr_status link_receive_frame(struct link *link, struct link_frame *frame, struct error *error)
{
    struct error found = {0};
    if (link->absence_reason.status != MR_OK)
        return MR_TOO_FEW;
    enum mr_status status = link->ops->receive_frame(link, frame, &found);
    if (status == MR_OK) {
        bool error_frame = frame->id & LINK_ID_ERROR;
        pthread_mutex_lock(&link->counters_lock);
        *(error_frame ? &link->counters.error_frames : &link->counters.received_count) += 1;
        pthread_mutex_unlock(&link->counters_lock);
        if (error_frame)
            count_link_faults(link, get_error_frame_faults(frame));
    }
    return handle_receive_status(link, status, &found, error);
}

enum mr_status link_receive_bytes(struct link *link, uint8_t *bytes, size_t size, size_t *length,
                                  uint64_t *host_us, struct error *error)
{
    if (link->absence_reason.status != MR_OK)
        return MR_TOO_FEW;
    if (link->buffer_start == link->buffer_end) {
        struct error found = {0};
        enum mr_status status = link_fill_buffer(link, &found);
        if (status != MR_OK)
            return handle_receive_status(link, status, &found, error);
    }
    size_t count = link->buffer_end - link->buffer_start;
    if (count > size)
        count = size;
    memcpy(bytes, link->buffer + link->buffer_start, count);
    link->buffer_start += count;
    pthread_mutex_lock(&link->counters_lock);
    count_received_bytes(&link->counters.rx, bytes, count);
    link->counters.received_count += count;
    pthread_mutex_unlock(&link->counters_lock);
    *length = count;
    *host_us = link->read_us;
    return MR_OK;
}

/* Locks the device for sending. The device may be absent, or the receiving thread may be opening it
 * again. */
static enum mr_status lock_device(struct link *link, struct error *error)
{
    bool is_locked = false;
    for (int waited_ms = 0; !(is_locked = pthread_mutex_trylock(&link->device_lock) == 0) &&
                            waited_ms < SEND_TIMEOUT_MS;
         waited_ms++)
        poll(NULL, 0, 1);
    if (is_locked && link->absence_reason.status == MR_OK)
        return MR_OK;
    if (is_locked)
        pthread_mutex_unlock(&link->device_lock);
    return error_set(error, MR_IO, "the device is disconnected: %s; plug it in again", link->spec);
}

/* Sends bytes and adds `counts` to the counter of sent data. */
static enum mr_status send_and_count(struct link *link, const uint8_t *bytes, size_t length,
                                     size_t counts, struct error *error)
{
    enum mr_status status = lock_device(link, error);
    if (status != MR_OK)
        return status;
    status = link->ops->send(link, bytes, length, error);
    if (status == MR_OK)
        link->counters.sent_count += counts;
    pthread_mutex_unlock(&link->device_lock);
    return status;
}

enum mr_status link_send_frame(struct link *link, const struct link_frame *frame,
                               struct error *error)
{
    uint8_t bytes[16] = {0};
    mr_put_u32(bytes, frame->id);
    bytes[4] = frame->length;
    memcpy(bytes + 8, frame->data, frame->length);
    return send_and_count(link, bytes, sizeof bytes, 1, error);
}

enum mr_status link_send_bytes(struct link *link, const uint8_t *bytes, size_t length,
                               struct error *error)
{
    return send_and_count(link, bytes, length, length, error);
}

enum mr_status link_send_message(struct link *link, uint16_t base, uint16_t seq, uint16_t id,
                                 const uint8_t *payload, size_t length, struct error *error)
{
    uint8_t bytes[MR_FRAME_BYTES_MAX];
    struct link_frame frame = {.id = mr_can_id_to_bus(id, base), .length = (uint8_t)length};
    if (link->kind == LINK_SERIAL)
        return link_send_bytes(link, bytes, mr_frame_encode(seq, id, payload, length, bytes),
                               error);
    memcpy(frame.data, payload, length);
    return link_send_frame(link, &frame, error);
}

enum mr_status link_set_baud(struct link *link, int baud, struct error *error)
{
    link->buffer_start = link->buffer_end = 0;
    link_restart_counting(link, link->counters.rx.baud ? baud : 0);
    return link->ops->set_baud ? link->ops->set_baud(link, baud, error) : MR_OK;
}

/* ---- diagnosis of a link without a board ---- */

const char *diagnosis_name(enum diagnosis diagnosis)
{
    static const char *const words[] = {"silent", "garbled", "bus-errors", "no-hello"};
    return words[diagnosis];
}

static enum diagnosis diagnose_serial(const struct link *link, const struct link_counters *counters,
                                      double since_s, char text[DIAGNOSIS_TEXT_SIZE])
{
    const struct link_rx *rx = &counters->rx;
    char errors[60] = "", rate[80];
    if (rx->bytes == 0) {
        snprintf(text, DIAGNOSIS_TEXT_SIZE,
                 LINK_NO_HELLO ": %s; no byte received in %.1f s: check that the board is on and "
                               "the cable is connected",
                 link->spec, since_s);
        return DIAGNOSIS_SILENT;
    }
    if (rx->valid_frames > 0) {
        snprintf(
            text, DIAGNOSIS_TEXT_SIZE,
            LINK_NO_HELLO
            ": %s; frames were received: check that the link is the serial output of the board",
            link->spec);
        return DIAGNOSIS_NO_HELLO;
    }
    if (counters->fault_count[LINK_UART_LINE])
        snprintf(errors, sizeof errors, ", %llu framing errors",
                 (unsigned long long)counters->fault_count[LINK_UART_LINE]);
    if (rx->baud == 0)
        snprintf(rate, sizeof rate, "check that the link is the serial output of the board");
    else
        snprintf(rate, sizeof rate, "check that the board sends at %d baud", rx->baud);
    snprintf(text, DIAGNOSIS_TEXT_SIZE,
             LINK_NO_HELLO
             ": %s; received %.0f bytes/s%s and %llu ends of frames, but no complete frame: %s",
             link->spec, (double)rx->bytes / fmax(since_s, 0.001), errors,
             (unsigned long long)rx->bad_frames, rate);
    return DIAGNOSIS_GARBLED;
}

/* Returns the most frequent fault in the error frames. */
static const char *find_most_common_error(const struct link_counters *counters)
{
    unsigned most = 0;
    for (unsigned i = 0; i < LINK_QUEUE_LOST; i++)
        most = counters->fault_count[i] > counters->fault_count[most] ? i : most;
    return link_fault_text(most);
}

static enum diagnosis diagnose_can(const struct link *link, const struct link_counters *counters,
                                   double since_s, char text[DIAGNOSIS_TEXT_SIZE])
{
    if (counters->received_count > 0) {
        snprintf(text, DIAGNOSIS_TEXT_SIZE,
                 LINK_NO_HELLO ": %s; %llu frames received: check that the board is on this bus",
                 link->spec, (unsigned long long)counters->received_count);
        return DIAGNOSIS_NO_HELLO;
    }
    if (counters->error_frames > 0) {
        snprintf(text, DIAGNOSIS_TEXT_SIZE,
                 LINK_NO_HELLO
                 ": %s; only error frames received (%llu), most of them %s: check that the bit "
                 "rate is 1 Mbit/s and both ends of the bus are terminated",
                 link->spec, (unsigned long long)counters->error_frames,
                 find_most_common_error(counters));
        return DIAGNOSIS_BUS_ERRORS;
    }
    snprintf(text, DIAGNOSIS_TEXT_SIZE,
             LINK_NO_HELLO
             ": %s; no frame in %.1f s: check that the board is on and connected to this bus",
             link->spec, since_s);
    return DIAGNOSIS_SILENT;
}

enum diagnosis link_diagnose(const struct link *link, char text[DIAGNOSIS_TEXT_SIZE])
{
    struct link_counters counters;
    struct error away;
    copy_counters(link, &counters, &away);
    double since_s = (double)(monotonic_us() - counters.rx.start_us) / 1e6;
    if (away.status != MR_OK) {
        snprintf(text, DIAGNOSIS_TEXT_SIZE, LINK_NO_HELLO ": %s; %.300s", link->spec, away.text);
        return DIAGNOSIS_SILENT;
    }
    return link->kind == LINK_CAN ? diagnose_can(link, &counters, since_s, text)
                                  : diagnose_serial(link, &counters, since_s, text);
}

enum mr_status link_set_no_board_error(const struct link *link, struct error *error)
{
    char text[DIAGNOSIS_TEXT_SIZE];
    enum diagnosis diagnosis = link_diagnose(link, text);
    return error_set(error,
                     diagnosis == DIAGNOSIS_SILENT || diagnosis == DIAGNOSIS_NO_HELLO ? MR_TIMEOUT
                                                                                      : MR_IO,
                     "%s", text);
}
