/* Giving a board the slack of a survey (command `survey`, common/command.h), and reading back what
 * it holds then. */
#ifndef MATRIG_HOST_SURVEY_SURVEY_CLIENT_H
#define MATRIG_HOST_SURVEY_SURVEY_CLIENT_H

#include "host/survey/survey.h"

struct survey_loaded {
    unsigned sent;                 /* segments */
    double board_in[SURVEY_SPANS]; /* what it says it holds; NaN: not surveyed */
    unsigned different;            /* of those sent */
    /* segments that it holds and this survey has not: of an earlier one */
    unsigned older;
};

/* Over one LINK, the other one NULL. MR_NOT_NOW: a landing is armed or going on; else as
 * host/board/dialogue.h has it. */
enum mr_status survey_load(const char *can, const char *serial, const struct survey_slack *slack,
                           struct survey_loaded *loaded, struct error *error);

#endif
