#include <stdio.h>
#include <string.h>

#include "common/channels.h"
#include "host/board/ready_parts.h"
#include "host/calibrate/jump.h"

static void judge_one(const struct ready_facts *f, unsigned i, const char *channel,
                      struct ready_report *report)
{
    char name[20], text[CERTIFICATES_TEXT];
    const struct store_certificate *certificate = &f->certificates.of[i];
    enum certificate_state state = certificates_state(certificate, &f->config.channel[i], f->now_s);
    certificates_text(certificate, state, &f->config.channel[i], text);
    snprintf(name, sizeof name, "certificate %s", channel);
    struct ready_check *c = ready_add(
        report, state == CERTIFICATE_VALID ? READY_GO : READY_NO_GO, name, "%s: No. %s%s%s", text,
        certificate->number, certificate->laboratory[0] ? ", " : "", certificate->laboratory);
    advise(c,
           state == CERTIFICATE_OVERDUE
               ? "have the sensor calibrated; matrig calibrate CHANNEL --db DB --certificate ... "
                 "enters its new certificate"
               : "enter the certificate of the sensor that is fitted, or put its serial number "
                 "into the configuration");
}

void ready_judge_certificates(const struct ready_facts *f, struct ready_report *report)
{
    unsigned without = 0, sensors = 0;
    char text[200] = "", name[8];
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (!mr_channel_measures(&f->config.channel[i]))
            continue;
        sensors++;
        jump_channel(i, name);
        if (f->certificates.known[i]) {
            judge_one(f, i, name, report);
            continue;
        }
        size_t at = strlen(text);
        snprintf(text + at, sizeof text - at, "%s%s", without++ ? ", " : "", name);
    }
    if (without)
        ready_add(report, READY_TOLD, "certificates", "none is entered of %s",
                  without == sensors ? "any sensor" : text);
}
