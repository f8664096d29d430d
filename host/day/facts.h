/* What a campaign tells of the day: which steps are done. */
#ifndef MATRIG_HOST_DAY_FACTS_H
#define MATRIG_HOST_DAY_FACTS_H

#include "host/day/steps.h"
#include "host/store/store.h"

/* All but `logging`, which stays. MR_IO, MR_MALFORMED: of the store. */
enum mr_status day_facts_read(struct store *store, int64_t now_us, struct day_facts *facts,
                              struct error *error);

/* Something that was said, for the landing to come. MR_IO. */
enum mr_status day_say(struct store *store, const struct day_facts *facts, const char *who,
                       const char *word, const char *value, struct error *error);

#endif
