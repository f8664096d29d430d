#include "host/link/rx_diagnostics.h"

#include <math.h>
#include <stdio.h>

#include "host/link/link_ops.h"
#include "host/base/monotonic_clock.h"

const char *diagnosis_word(enum diagnosis diagnosis)
{
    static const char *const words[] = {"silent", "garbled", "bus-errors", "no-hello"};
    return words[diagnosis];
}

static enum diagnosis of_serial(const struct link *link, const struct link_counters *counters,
                                double since_s, char text[DIAGNOSIS_TEXT])
{
    const struct link_rx *rx = &counters->rx;
    char errors[60] = "", rate[80];
    if (rx->bytes == 0) {
        snprintf(text, DIAGNOSIS_TEXT,
                 LINK_NO_HELLO ": %s; no byte received in %.1f s: is the board on, the cable in?",
                 link->spec, since_s);
        return DIAGNOSIS_SILENT;
    }
    if (rx->frames > 0) {
        snprintf(text, DIAGNOSIS_TEXT,
                 LINK_NO_HELLO ": %s; frames received: is this the board's serial output?",
                 link->spec);
        return DIAGNOSIS_NO_HELLO;
    }
    if (counters->trouble[LINK_UART_LINE])
        snprintf(errors, sizeof errors, ", %llu framing errors",
                 (unsigned long long)counters->trouble[LINK_UART_LINE]);
    if (rx->baud == 0)
        snprintf(rate, sizeof rate, "is this the board's serial output?");
    else
        snprintf(rate, sizeof rate, "is %d baud its rate? serial:TTY:find finds it", rx->baud);
    snprintf(text, DIAGNOSIS_TEXT,
             LINK_NO_HELLO ": %s; %.0f bytes/s received%s, %llu frame ends, no whole frame: %s",
             link->spec, (double)rx->bytes / fmax(since_s, 0.001), errors,
             (unsigned long long)rx->bad, rate);
    return DIAGNOSIS_GARBLED;
}

/* What the error frames tell most. */
static const char *commonest(const struct link_counters *counters)
{
    unsigned most = 0;
    for (unsigned i = 0; i < LINK_QUEUE_LOST; i++)
        most = counters->trouble[i] > counters->trouble[most] ? i : most;
    return link_trouble_text(most);
}

static enum diagnosis of_can(const struct link *link, const struct link_counters *counters,
                             double since_s, char text[DIAGNOSIS_TEXT])
{
    if (counters->received > 0) {
        snprintf(text, DIAGNOSIS_TEXT,
                 LINK_NO_HELLO ": %s; %llu frames received: is the board on this bus?", link->spec,
                 (unsigned long long)counters->received);
        return DIAGNOSIS_NO_HELLO;
    }
    if (counters->error_frames > 0) {
        snprintf(text, DIAGNOSIS_TEXT,
                 LINK_NO_HELLO ": %s; error frames only, %llu, most of them %s: is the bit rate 1 "
                               "Mbit/s, is the bus terminated at both ends?",
                 link->spec, (unsigned long long)counters->error_frames, commonest(counters));
        return DIAGNOSIS_BUS_ERRORS;
    }
    snprintf(text, DIAGNOSIS_TEXT,
             LINK_NO_HELLO ": %s; no frame at all in %.1f s: is the board on, and on this bus?",
             link->spec, since_s);
    return DIAGNOSIS_SILENT;
}

enum diagnosis link_diagnose(const struct link *link, char text[DIAGNOSIS_TEXT])
{
    struct link_counters counters;
    struct error away;
    link_heard(link, &counters, &away);
    double since_s = (double)(monotonic_us() - counters.rx.begun_us) / 1e6;
    if (away.status != MR_OK) {
        snprintf(text, DIAGNOSIS_TEXT, LINK_NO_HELLO ": %s; %.300s", link->spec, away.text);
        return DIAGNOSIS_SILENT;
    }
    return link->kind == LINK_CAN ? of_can(link, &counters, since_s, text)
                                  : of_serial(link, &counters, since_s, text);
}

enum mr_status link_no_board(const struct link *link, struct error *error)
{
    char text[DIAGNOSIS_TEXT];
    enum diagnosis diagnosis = link_diagnose(link, text);
    return error_set(error,
                     diagnosis == DIAGNOSIS_SILENT || diagnosis == DIAGNOSIS_NO_HELLO ? MR_TIMEOUT
                                                                                      : MR_IO,
                     "%s", text);
}
