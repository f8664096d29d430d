/* Landings of which a campaign has a part twice. Conventions as in store.h. */
#ifndef MATRIG_HOST_STORE_STORE_SAME_H
#define MATRIG_HOST_STORE_STORE_SAME_H

#include "host/store/store.h"

struct store_same {
    int64_t cut; /* RUN of the landing that was cut off; 0: none */
    /* the other one has all of it, and the one that was cut off is void now; else that one goes on
     * with it, and a note at each says so */
    bool whole;
};

/* Of the landing `run`: whether an earlier session was ended in the middle of it. `now_us`: Unix
 * time, of what is said of that in the journal. */
enum mr_status store_find_same(struct store *store, int64_t run, int64_t now_us,
                               struct store_same *same, struct error *error);

/* The earliest RUN before `run` that is the same landing: logged or imported twice, or read by
 * another instrument, and not void; 0: none. */
enum mr_status store_find_twin(struct store *store, int64_t run, int64_t *twin,
                               struct error *error);
/* Board (another instrument's readings have none), number and the captures of switches agree: of
 * the edges that both have, two at least, each is the same. */
bool store_same_landing(const struct store_landing *a, const struct store_edge *a_edge,
                        size_t a_edges, const struct store_landing *b,
                        const struct store_edge *b_edge, size_t b_edges);

#endif
