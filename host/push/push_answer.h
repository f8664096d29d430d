/* What push tests say, for people, programs and pages (host/base/answer.h). */
#ifndef MATRIG_HOST_PUSH_PUSH_ANSWER_H
#define MATRIG_HOST_PUSH_PUSH_ANSWER_H

#include "host/base/answer.h"
#include "host/push/ground.h"

/* The law and what it rests on; what is not told, with the reason; for which rig it holds. */
void push_answer_law(struct answer *answer, const struct push_ground *ground,
                     const struct push_setting *setting);
/* A row for each test. */
void push_answer_tests(struct answer *answer, const struct push_readings *readings,
                       const struct push_ground *ground);
/* "elastic", "rigid", "cannot tell". */
const char *push_law_name(enum push_law law);

#endif
