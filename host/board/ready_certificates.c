#include <stdio.h>
#include <string.h>

#include "common/channels.h"
#include "host/board/ready_parts.h"
#include "host/calibrate/jump.h"

static void judge_one(const struct ready_facts *f, unsigned i, struct ready_report *report)
{
    static const struct {
        enum ready_verdict verdict;
        const char *advice;
    } by_state[] = {
        [CERTIFICATE_VALID] = {READY_GO, ""},
        [CERTIFICATE_DUE_NOW] = {READY_NOT_DONE, "by the time zone: look at the calendar"},
        [CERTIFICATE_OVERDUE] = {READY_NO_GO,
                                 "have the sensor calibrated, then enter its new certificate: "
                                 "matrig certificate DB %s --number N ..."},
        [CERTIFICATE_AHEAD] = {READY_NO_GO, "set this computer's clock, or correct the date: "
                                            "matrig certificate DB %s ..."},
        [CERTIFICATE_ANOTHER] = {READY_NO_GO,
                                 "enter the certificate of the sensor that is fitted, or put its "
                                 "serial number into the configuration of %s"},
    };
    char channel[8], name[20], text[CERTIFICATES_TEXT];
    const struct store_certificate *certificate = &f->certificates.of[i];
    enum certificate_state state = certificates_state(certificate, &f->config.channel[i], f->now_s);
    jump_channel(i, channel);
    snprintf(name, sizeof name, "certificate %s", channel);
    certificates_text(certificate, state, &f->config.channel[i], text);
    struct ready_check *c = ready_add(report, by_state[state].verdict, name, "%s: No. %s%s%s", text,
                                      certificate->number, certificate->laboratory[0] ? ", " : "",
                                      certificate->laboratory);
    const char *advice = by_state[state].advice, *at = strstr(advice, "%s");
    if (at)
        snprintf(c->advice, sizeof c->advice, "%.*s%s%s", (int)(at - advice), advice, channel,
                 at + 2);
    else
        advise(c, advice);
}

void ready_judge_certificates(const struct ready_facts *f, struct ready_report *report)
{
    unsigned without = 0, sensors = 0;
    char text[200] = "", name[8];
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (!mr_channel_measures(&f->config.channel[i]))
            continue;
        sensors++;
        if (f->certificates.known[i]) {
            judge_one(f, i, report);
            continue;
        }
        jump_channel(i, name);
        size_t at = strlen(text);
        snprintf(text + at, sizeof text - at, "%s%s", without++ ? ", " : "", name);
    }
    if (!without)
        return;
    bool required = f->certificates.required;
    struct ready_check *c = ready_add(report, required ? READY_NO_GO : READY_TOLD, "certificates",
                                      "none is entered of %s%s",
                                      without == sensors ? "any sensor" : text,
                                      required ? ", and this campaign requires them" : "");
    if (required)
        advise(c, "enter them: matrig certificate DB CHANNEL --number N ...; or require none: "
                  "matrig certificate DB --required no");
}
