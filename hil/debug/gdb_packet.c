#include "hil/debug/gdb_packet.h"

#include <errno.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "hil/core/wall.h"

#define SEND_MS 10000
#define POLL_MS 50

/* --- hexadecimal --- */

static int digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0'
         : c >= 'a' && c <= 'f' ? c - 'a' + 10
         : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                : -1;
}

/* Bytes from pairs of digits; how many there were. */
size_t hil_gdb_from_hex(const char *text, uint8_t *bytes, size_t room)
{
    size_t n = 0;
    while (n < room && digit(text[0]) >= 0 && digit(text[1]) >= 0) {
        bytes[n++] = (uint8_t)(digit(text[0]) << 4 | digit(text[1]));
        text += 2;
    }
    return n;
}

char *hil_gdb_to_hex(char *text, const void *bytes, size_t n)
{
    static const char digits[] = "0123456789abcdef";
    const uint8_t *p = bytes;
    for (size_t i = 0; i < n; i++) {
        *text++ = digits[p[i] >> 4];
        *text++ = digits[p[i] & 15u];
    }
    *text = '\0';
    return text;
}

/* --- the connection --- */

void hil_gdb_lose(struct hil_gdb_line *line)
{
    if (line->fd >= 0)
        close(line->fd);
    line->fd = -1;
    line->in_size = 0;
    hil_call(&line->lost);
}

static void send_all(struct hil_gdb_line *line, const char *bytes, size_t n)
{
    int64_t until = hil_wall_ms() + SEND_MS;
    while (n && line->fd >= 0) {
        ssize_t sent = send(line->fd, bytes, n, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent > 0) {
            bytes += sent;
            n -= (size_t)sent;
            continue;
        }
        struct pollfd wait = {.fd = line->fd, .events = POLLOUT};
        if ((errno != EAGAIN && errno != EINTR) || hil_wall_ms() > until)
            hil_gdb_lose(line);
        else
            poll(&wait, 1, POLL_MS);
    }
}

void hil_gdb_put_packet(struct hil_gdb_line *line, const char *text)
{
    char packet[2 * HIL_GDB_PACKET + 8];
    uint8_t sum = 0;
    size_t n = strlen(text);
    for (size_t i = 0; i < n; i++)
        sum = (uint8_t)(sum + (uint8_t)text[i]);
    int length = snprintf(packet, sizeof packet, "$%s#%02x", text, sum);
    send_all(line, packet, (size_t)length);
}

void hil_gdb_put_console(struct hil_gdb_line *line, const char *text)
{
    char packet[2 * HIL_GDB_PACKET] = "O";
    size_t n = strlen(text);
    hil_gdb_to_hex(packet + 1, text, n < HIL_GDB_PACKET - 2 ? n : HIL_GDB_PACKET - 2);
    hil_gdb_put_packet(line, packet);
}

bool hil_gdb_receive(struct hil_gdb_line *line, int timeout_ms)
{
    struct pollfd wait = {.fd = line->fd, .events = POLLIN};
    if (line->in_size == sizeof line->in)
        line->in_size = 0; /* longer than any packet: none */
    if (line->fd < 0 || poll(&wait, 1, timeout_ms) <= 0)
        return line->fd >= 0;
    ssize_t n = recv(line->fd, line->in + line->in_size, sizeof line->in - line->in_size,
                     MSG_DONTWAIT);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) {
        hil_gdb_lose(line);
        return false;
    }
    if (n > 0)
        line->in_size += (size_t)n;
    return true;
}

static void drop(struct hil_gdb_line *line, size_t n)
{
    memmove(line->in, line->in + n, line->in_size - n);
    line->in_size -= n;
}

int hil_gdb_take_packet(struct hil_gdb_line *line, char *packet, bool *interrupt)
{
    *interrupt = false;
    while (line->in_size && line->in[0] != '$') {
        *interrupt = line->in[0] == 3;
        drop(line, 1);
        if (*interrupt)
            return -1;
    }
    const char *hash = line->in_size ? memchr(line->in, '#', line->in_size) : NULL;
    if (!hash || line->in_size - (size_t)(hash - line->in) < 3)
        return -1;
    uint8_t sum = 0;
    int n = 0;
    for (const char *p = line->in + 1; p < hash; p++) {
        sum = (uint8_t)(sum + (uint8_t)*p);
        if (*p == '}' && p + 1 < hash) {
            sum = (uint8_t)(sum + (uint8_t)p[1]);
            packet[n++] = (char)(*++p ^ 0x20);
        } else {
            packet[n++] = *p;
        }
    }
    packet[n] = '\0';
    bool good = digit(hash[1]) >= 0 && digit(hash[2]) >= 0 &&
                sum == (digit(hash[1]) << 4 | digit(hash[2]));
    drop(line, (size_t)(hash - line->in) + 3);
    if (line->acknowledges)
        send_all(line, good ? "+" : "-", 1);
    return good && (line->fd >= 0 || strcmp(packet, "k") == 0) ? n : -1;
}
