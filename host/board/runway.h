/* Words for what the predictor says (common/catalogue.def, messages verdict and runway_store). Static storage. */
#ifndef MATRIG_HOST_RUNWAY_H
#define MATRIG_HOST_RUNWAY_H

const char *runway_source_text(unsigned source);
const char *runway_verdict_text(unsigned verdict);
/* Why a verdict is not quiet. */
const char *runway_reason_text(unsigned reason);
const char *runway_level_text(unsigned level);
const char *runway_doubt_text(unsigned doubt);

#endif
