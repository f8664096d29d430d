#include <math.h>
#include <stdio.h>
#include <string.h>

#include "common/channels.h"
#include "common/gain.h"
#include "host/base/units.h"
#include "host/board/ready_parts.h"
#include "host/calibrate/jump.h"
#include "host/calibrate/mistake.h"

void ready_channel_name(const struct mr_channel_config *channel, char *out, size_t size)
{
    if (channel->kind == MR_KIND_DISPLACEMENT)
        snprintf(out, size, "transducer %u", channel->number);
    else if (channel->kind == MR_KIND_TENSION)
        snprintf(out, size, "gage %u", channel->number);
    else
        snprintf(out, size, "%s", channel->kind == MR_KIND_STAIRCASE ? "staircase" : "reference");
}

static void judge_days(const struct ready_facts *f, struct ready_report *report)
{
    unsigned never = 0, sensors = 0, expired = 0;
    char text[120] = "", name[20];
    for (unsigned i = 0; i < MR_CHANNELS; i++) {
        const struct mr_channel_config *channel = &f->config.channel[i];
        if (!mr_channel_measures(channel))
            continue;
        sensors++;
        never += channel->calibrated_day == 0;
        if (!channel->expires_day || channel->expires_day > f->today_day)
            continue;
        ready_channel_name(channel, name, sizeof name);
        size_t at = strlen(text);
        snprintf(text + at, sizeof text - at, "%s%s", expired++ ? ", " : "", name);
    }
    if (sensors == 0)
        return;
    if (expired) {
        struct ready_check *c = ready_add(report, READY_NO_GO, "calibration", "expired: %s", text);
        limit(c, "expires_day after today");
        advise(c, "calibrate, then matrig board config set with the new values and dates");
    } else if (never) {
        advise(ready_add(report, READY_NOT_DONE, "calibration",
                         "%u of %u sensors have no date of calibration", never, sensors),
               "put calibrated_day and expires_day into the configuration");
    } else {
        limit(ready_add(report, READY_GO, "calibration", "%u sensors, none expired", sensors),
              "expires_day after today");
    }
}

static void judge_jump(const struct ready_facts *f, unsigned i, const struct jump *jump,
                       struct ready_report *report)
{
    char name[20], channel[8], what[120], since[40] = "the last check";
    jump_channel(i, channel);
    snprintf(name, sizeof name, "calibration %s", channel);
    jump_text(jump, &f->config.channel[i], what, sizeof what);
    if (f->past.run[i])
        snprintf(since, sizeof since, "RUN %lld", (long long)f->past.run[i]);
    struct ready_check *c = ready_add(report, READY_NO_GO, name, "%s since %s", what, since);
    snprintf(c->limit, sizeof c->limit, "%.3g times, zero %g %s", jump->most, jump->shift_most,
             f->config.channel[i].kind == MR_KIND_DISPLACEMENT ? "in" : "lb");
    snprintf(c->advice, sizeof c->advice,
             "a wrong unit, or was something changed? then say so: matrig ready DB --serial LINK "
             "--changed '%s: NOTE'",
             channel);
}

/* A board of an older firmware may hold a gain that is refused today. */
static void judge_possible(const struct ready_facts *f, struct ready_report *report)
{
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        const struct mr_channel_config *channel = &f->config.channel[i];
        char name[20], input[8], mistake[80];
        if (!mr_channel_measures(channel) || channel->unit_per_code == 0.0f ||
            mr_gain_check(channel) == MR_RULE_NONE)
            continue;
        jump_channel(i, input);
        snprintf(name, sizeof name, "calibration %s", input);
        mistake_text(channel, mistake, sizeof mistake);
        struct ready_check *c = ready_add(
            report, READY_NO_GO, name, "%.4g %s per code: no sensor of the rig has such a gain%s",
            (double)mr_channel_gain(channel), i < MR_TRANSDUCERS ? "in" : "lb", mistake);
        advise(c, "matrig board config get and check say more; calibrate the channel anew");
    }
}

/* Each channel against what the campaign knows of it. Says nothing when that is nothing. */
static void judge_past(const struct ready_facts *f, struct ready_report *report)
{
    unsigned known = 0, jumped = 0;
    double most = 0.0;
    char worst[8] = "";
    for (unsigned i = 0; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        struct jump jump;
        const struct mr_channel_config *was = &f->past.channel[i], *is = &f->config.channel[i];
        if (was->kind == MR_KIND_NONE || !mr_channel_measures(is))
            continue;
        bool jumps = jump_find(was, is, &jump);
        known += jump.ratio > 0.0; /* 0: the input has another number now */
        if (jumps) {
            judge_jump(f, i, &jump, report);
            jumped++;
        } else if (jump.ratio > 0.0 && fabs(log(jump.ratio)) > most) {
            most = fabs(log(jump.ratio));
            jump_channel(i, worst);
        }
    }
    if (known && !jumped && worst[0])
        ready_add(report, READY_GO, "calibration kept",
                  "%u channels follow from what the campaign knows; most of all the gain of %s, by "
                  "%.2g %%",
                  known, worst, 100.0 * (exp(most) - 1.0));
    else if (known && !jumped)
        ready_add(report, READY_GO, "calibration kept",
                  "%u channels have the gains that the campaign knows", known);
}

void ready_judge_calibration(const struct ready_facts *f, struct ready_report *report)
{
    judge_days(f, report);
    judge_possible(f, report);
    judge_past(f, report);
    if (f->changed[0])
        ready_add(report, READY_GO, "change said", "%.150s", f->changed);
}

/* A bridge's zero holds for the temperature and the trim it was set at; before a landing somebody
 * measures it with the bands slack. */
void ready_judge_zeros(const struct ready_facts *f, struct ready_report *report)
{
    char is[UNIT_TEXT];
    unsigned gages = 0, measured = 0;
    float worst_lb = 0.0f;
    for (unsigned i = MR_TRANSDUCERS; i < MR_TRANSDUCERS + MR_GAGES; i++) {
        if (f->config.channel[i].kind != MR_KIND_TENSION || !(f->zero_told >> i & 1u))
            continue;
        gages++;
        if (f->zero_measured >> i & 1u)
            measured++;
        else
            worst_lb = fmaxf(worst_lb, f->config.channel[i].zero_error);
    }
    if (!gages)
        return;
    if (measured == gages) {
        ready_add(report, READY_GO, "gage zeros", "all %u measured since reset", gages);
        return;
    }
    struct ready_check *c =
        ready_add(report, READY_NOT_DONE, "gage zeros",
                  "%u of %u not measured since reset: as configured, +- %s", gages - measured,
                  gages, unit_value_text(UNIT_TENSION, f->si, (double)worst_lb, 1, is));
    advise(c, "that holds where bridges are trimmed; with the bands slack: matrig gages zero 2");
}
