/* Readings that are missing where a peak may have been, in words above the tables of channels. */
#ifndef MATRIG_HOST_ANALYSE_SUMMARY_MISSING_H
#define MATRIG_HOST_ANALYSE_SUMMARY_MISSING_H

#include "host/analyse/measured.h"
#include "host/base/answer.h"

/* A sentence for each stretch that channels of this kind lack: each channel's longest. */
void summary_missing_answer(const struct measured *measured, enum mr_channel_kind kind,
                            struct answer *answer);

#endif
