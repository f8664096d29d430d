/* What a survey answers (host/base/answer.h). */
#ifndef MATRIG_HOST_SURVEY_SURVEY_ANSWER_H
#define MATRIG_HOST_SURVEY_SURVEY_ANSWER_H

#include "host/base/answer.h"
#include "host/survey/survey.h"

void survey_answer(const struct survey *survey, const struct survey_found *found,
                   struct answer *answer);
/* "within", "perhaps beyond" (its 95 % interval reaches over it), "beyond", "not known" */
const char *survey_bow_verdict(const struct survey_found *found);
/* "2026-11-22 01:48 UTC" */
void survey_time_text(int64_t host_us, char *out, size_t size);

#endif
