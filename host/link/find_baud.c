#include "host/link/find_baud.h"

#include <errno.h>
#include <poll.h>
#include <string.h>

#include "host/link/diagnose.h"
#include "host/link/hearing.h"
#include "host/link/link_ops.h"
#include "host/base/steady.h"

/* a clock every 0.1 s, and what is needed to find the beginning of a frame */
#define LISTEN_US 700000u

/* MR_OK: a frame was whole. */
static enum mr_status listen(struct tty *tty, int baud, uint64_t *heard, struct error *error)
{
    struct hearing hearing;
    uint8_t bytes[4096];
    uint64_t until_us = steady_us() + LISTEN_US;
    hearing_start(&hearing, 0, baud);
    while (hearing.frames == 0 && steady_us() < until_us) {
        struct pollfd ready = {.fd = tty_fd(tty), .events = POLLIN};
        uint64_t left_us = until_us - steady_us();
        if (poll(&ready, 1, left_us > LISTEN_US ? 0 : (int)(left_us / 1000 + 1)) <= 0)
            continue;
        ssize_t count = tty_read(tty, bytes, sizeof bytes);
        if (count < 0 && errno == ENODEV)
            return error_set(
                error, MR_IO,
                "the serial port went away while its rate was looked for; plug it in again");
        hearing_bytes(&hearing, bytes, count > 0 ? (size_t)count : 0);
    }
    *heard += hearing.bytes;
    return hearing.frames > 0 ? MR_OK : MR_TIMEOUT;
}

enum mr_status find_baud(struct tty *tty, const char *spec, int *baud, struct error *error)
{
    uint64_t heard = 0;
    for (const int *usual = hearing_usual_bauds(); *usual; usual++) {
        struct error cannot = {0};
        if (tty_line(tty, *usual, &cannot) != MR_OK)
            continue; /* a rate that this port does not do */
        *baud = *usual;
        enum mr_status status = listen(tty, *usual, &heard, error);
        if (status != MR_TIMEOUT)
            return status;
    }
    if (heard == 0)
        return error_set(error, MR_TIMEOUT,
                         LINK_NO_HELLO
                         ": %s; not a byte came at any usual rate: is the board on, the cable in?",
                         spec);
    return error_set(
        error, MR_IO,
        LINK_NO_HELLO
        ": %s; %llu bytes came at the usual rates, and no frame: is this the board's port?",
        spec, (unsigned long long)heard);
}
