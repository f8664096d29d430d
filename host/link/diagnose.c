#include "host/link/diagnose.h"

#include <math.h>
#include <stdio.h>

#include "host/link/link_ops.h"
#include "host/base/steady.h"

const char *diagnosis_word(enum diagnosis diagnosis)
{
    static const char *const words[] = {"silent", "garbled", "bus-errors", "no-hello"};
    return words[diagnosis];
}

/* "460800 or 500000": the usual rates that fit what came; how many. */
static unsigned name_usual(const struct hearing *hearing, double slower, char *out, size_t size)
{
    int bauds[HEARING_USUAL];
    unsigned count = hearing_usual_near(hearing->baud, slower, bauds);
    size_t used = 0;
    out[0] = '\0';
    for (unsigned i = 0; i < count && used < size; i++)
        used += (size_t)snprintf(out + used, size - used, "%s%d", i ? " or " : "", bauds[i]);
    return count;
}

/* What the sender of a line that does not decode may have for a rate, and what to try. */
static void guess_rate(const struct hearing *hearing, char *out, size_t size)
{
    double slower = hearing_times_slower(hearing);
    char usual[60];
    unsigned usuals = slower > 1.0 && !isinf(slower)
                        ? name_usual(hearing, slower, usual, sizeof usual)
                        : 0;
    if (hearing->baud == 0)
        snprintf(out, size, "is this the board's serial output?");
    else if (isinf(slower))
        snprintf(out, size,
                 "the sender is more than 8 times slower than %d baud: give its rate, or try them "
                 "with serial:TTY:find",
                 hearing->baud);
    else if (usuals == 1)
        snprintf(out, size, "the sender probably has %s baud, not %d: give it as serial:TTY:%s",
                 usual, hearing->baud, usual);
    else if (usuals > 1)
        snprintf(out, size,
                 "the sender probably has %s baud, not %d: try them with serial:TTY:find", usual,
                 hearing->baud);
    else if (slower > 1.0)
        snprintf(out, size,
                 "the sender has about %.0f baud, not %d: try the usual rates with serial:TTY:find",
                 (double)hearing->baud / slower, hearing->baud);
    else if (slower > 0.0 && hearing->baud < LINK_BOARD_BAUD)
        snprintf(out, size,
                 "the sender is as fast as %d baud or faster, and the board has %d: give it as "
                 "serial:TTY:%d",
                 hearing->baud, LINK_BOARD_BAUD, LINK_BOARD_BAUD);
    else
        snprintf(out, size, "is %d baud its rate? try the others with serial:TTY:find",
                 hearing->baud);
}

static enum diagnosis of_serial(const struct link *link, const struct link_counters *counters,
                                double since_s, char text[DIAGNOSIS_TEXT])
{
    const struct hearing *hearing = &counters->hearing;
    char errors[60] = "", rate[200];
    if (hearing->bytes == 0) {
        snprintf(text, DIAGNOSIS_TEXT,
                 LINK_NO_HELLO ": %s; not a byte came in %.1f s: is the board on, the cable in?",
                 link->spec, since_s);
        return DIAGNOSIS_SILENT;
    }
    if (hearing->frames > 0) {
        snprintf(text, DIAGNOSIS_TEXT,
                 LINK_NO_HELLO ": %s; frames came: is this the board's serial output?", link->spec);
        return DIAGNOSIS_NO_HELLO;
    }
    if (counters->trouble[LINK_UART_LINE])
        snprintf(errors, sizeof errors, ", %llu framing errors",
                 (unsigned long long)counters->trouble[LINK_UART_LINE]);
    guess_rate(hearing, rate, sizeof rate);
    snprintf(text, DIAGNOSIS_TEXT,
             LINK_NO_HELLO ": %s; %.0f bytes/s came%s, %llu ends of frames, not one whole: %s",
             link->spec, (double)hearing->bytes / fmax(since_s, 0.001), errors,
             (unsigned long long)hearing->bad, rate);
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
                 LINK_NO_HELLO ": %s; %llu frames came: is the board on this bus?", link->spec,
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
    double since_s = (double)(steady_us() - counters.hearing.begun_us) / 1e6;
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
