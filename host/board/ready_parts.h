/* What the parts of ready.h share. */
#ifndef MATRIG_HOST_READY_PARTS_H
#define MATRIG_HOST_READY_PARTS_H

#include <stdio.h>

#include "host/board/ready.h"

static inline void limit(struct ready_check *check, const char *text)
{
    snprintf(check->limit, sizeof check->limit, "%s", text);
}

/* What to do about it, unless it is go. */
static inline void advise(struct ready_check *check, const char *text)
{
    if (check->verdict != READY_GO)
        snprintf(check->advice, sizeof check->advice, "%s", text);
}

/* "transducer 3", "gage 12"; of others "staircase" and "reference". */
void ready_channel_name(const struct mr_channel_config *channel, char *out, size_t size);
/* Expired, never done, or another than the campaign knows. */
void ready_judge_calibration(const struct ready_facts *f, struct ready_report *report);
/* Whether the certificate of each sensor holds, where there is one. */
void ready_judge_certificates(const struct ready_facts *f, struct ready_report *report);
/* Whether the gages' zeros were measured, where the board told of them. */
void ready_judge_zeros(const struct ready_facts *f, struct ready_report *report);

#endif
