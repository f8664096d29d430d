#include "host/board/buslisten.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <string.h>

#include "host/base/monotonic_clock.h"
#include "host/link/rx_diagnostics.h"

#define FRAMES_A_TURN 64
#define WAIT_S        0.1

/* What waits to be read. MR_TOO_FEW: no more now; MR_CLOSED: the end of the log, or of its time. */
static enum mr_status receive(struct link *link, double for_s, struct busscan *scan,
                              struct error *error)
{
    struct link_frame frame;
    enum mr_status status = MR_OK;
    for (int i = 0; status == MR_OK && i < FRAMES_A_TURN; i++) {
        status = link_receive_frame(link, &frame, error);
        if (status != MR_OK)
            break;
        if (link_recorded(link) && scan->frames > 0 && frame.host_us > scan->first_us &&
            (double)(frame.host_us - scan->first_us) > 1e6 * for_s)
            return MR_CLOSED;
        busscan_frame(scan, &frame);
    }
    return status;
}

enum mr_status buslisten(struct link *link, double for_s, struct busscan *scan, double *heard_s,
                         struct error *error)
{
    double begun_s = monotonic_s();
    enum mr_status status = MR_OK;
    while (status == MR_OK) {
        double left_s = begun_s + for_s - monotonic_s();
        struct error away = {0};
        status = receive(link, for_s, scan, error);
        bool waits = status == MR_TOO_FEW;
        if (waits)
            status = link_service(link, &away);
        if (status == MR_TOO_FEW)
            status = MR_OK;
        else if (away.status != MR_OK)
            status = error_set(error, away.status, "%s", away.text);
        /* a log is read to its end or its time, however long that takes */
        if (status == MR_OK && left_s <= 0.0 && (waits || !link_recorded(link)))
            status = MR_CLOSED;
        struct pollfd ready = {.fd = link_fd(link), .events = POLLIN};
        if (status == MR_OK && waits &&
            poll(&ready, 1, (int)ceil(1000.0 * fmin(fmax(left_s, 0.0), WAIT_S))) < 0 &&
            errno != EINTR)
            status = error_set(error, MR_IO, "cannot wait (%s): %s; try again", strerror(errno),
                               link_spec(link));
    }
    *heard_s = link_recorded(link) ? busscan_heard_s(scan) : monotonic_s() - begun_s;
    return error->status; /* MR_OK: the time is over, or what was recorded */
}

enum mr_status buslisten_silent(const struct link *link, struct error *error)
{
    char text[DIAGNOSIS_TEXT];
    return link_fd(link) >= 0 && link_diagnose(link, text) == DIAGNOSIS_SILENT
             ? MR_OK
             : link_no_board(link, error);
}
