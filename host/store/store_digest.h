/* Whether what is told of a landing may be another by now, without reading its series.
 *
 * A digest is SHA-256 over the rows of a landing and those around it that its report rests on:
 * channels, statements, events, what people said, its session's links, its series, the surveys
 * before and after it, advice, its neighbours. Blocks and frames, which only ever come to be more,
 * are counted. The same digest: the same report, by the same matrig. Another one: perhaps. */
#ifndef MATRIG_HOST_STORE_STORE_DIGEST_H
#define MATRIG_HOST_STORE_STORE_DIGEST_H

#include <sha2.h>

#include "host/store/store.h"

struct store_digest {
    int64_t run;
    SHA2_CTX hash; /* a caller adds what else it rests on */
};

/* Of all landings, by rising RUN. The caller frees *digest, also after an error. */
enum mr_status store_digests(struct store *store, struct store_digest **digest, size_t *count,
                             struct error *error);
/* NULL: there is no such landing. */
struct store_digest *store_digest_find(struct store_digest *digest, size_t count, int64_t run);

#endif
