/* What came of a landing, by measurement: whether the wheel came to a zone of 50 closed mats before
 * it stopped. No predictor is asked: what judges a warning must not be what gave it.
 *
 * It rests, in this order, on
 *  - a wave or a break that a person saw in it; a two-panel wave that the gear crosses is no
 *    failure (report 2.1)
 *  - the survey before it and what the transducers saw since (common/closure.h): at each moment the
 *    longest closed run ahead of the wheel, from within OUTCOME_NEAR_FT of the wheel, for 0.1 s.
 *    Segments of ten mats make its length and its moment coarse (tests/score has by how much)
 *  - the survey after it: a closed run of that length which begins at the wheel where it stands.
 *    That can only say yes: joints open again behind the wheel.
 *
 * No is said where the stop is known, the survey before is of after the landing before, even the
 * segments that it leaves out could not make a zone, and transducers bound at least half of the way
 * from touchdown to 50 mats beyond the stop. Else nobody knows, and `why` says why. */
#ifndef MATRIG_HOST_ANALYSE_OUTCOME_H
#define MATRIG_HOST_ANALYSE_OUTCOME_H

#include "host/analyse/measured.h"
#include "host/analyse/zones.h"

#define OUTCOME_MATS    50  /* where buckling begins (report 6.1.4) */
#define OUTCOME_NEAR_FT 2.0 /* seven mats; as in tests/score */

enum outcome_came { OUTCOME_UNKNOWN, OUTCOME_CAME, OUTCOME_DID_NOT };
enum outcome_basis {
    OUTCOME_NOTHING,
    OUTCOME_SEEN,
    OUTCOME_TRANSDUCERS,
    OUTCOME_SURVEY_AFTER,
    OUTCOME_BASES
};

struct outcome {
    enum outcome_came came;
    enum outcome_basis basis;
    const char *why; /* nobody knows; static */
    /* the longest zone that the wheel came to by transducers and survey; STORE_NONE: not known */
    int64_t mats;
    double start_ft; /* of that one */
    double t_s; /* from when on the wheel was at one of 50 mats; NaN: it was not, or not known */
    double watched; /* share of its way that transducers bound */
    /* closed run at the wheel by the survey after it; STORE_NONE: none was read */
    int64_t left_mats;
    size_t waves, breaks; /* seen, and not withdrawn */
};

/* The landings of a campaign around it, of the same board; NULL: there is none. */
struct outcome_between {
    const struct store_landing *before, *after;
};

/* `measured`: with its series, measured_load. */
enum mr_status outcome_load(struct store *store, const struct measured *measured,
                            const struct outcome_between *between, struct outcome *outcome,
                            struct error *error);
/* "transducers and survey", for tables. Static storage. */
const char *outcome_basis_text(enum outcome_basis basis);

#endif
