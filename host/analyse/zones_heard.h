/* Whether a record has all that the board said of zones. The board says it 20 times a second from
 * arming until the landing is over; where nothing was heard for longer, a warning may have come. */
#ifndef MATRIG_HOST_ANALYSE_ZONES_HEARD_H
#define MATRIG_HOST_ANALYSE_ZONES_HEARD_H

#include "host/analyse/measured.h"

/* Times as t_s of the landing. */
struct zones_heard {
    bool any;   /* statements came */
    bool late;  /* the first of them did not: the record begins after arming */
    bool ended; /* the board said that the landing is over */
    double first_s, last_s;
    double pause_from_s, pause_to_s; /* the longest between two statements; NaN: none */
    bool since_touchdown;            /* else t_s counts from the first switch or arming */
};

/* `row`: in order of time. */
struct zones_heard zones_heard(const struct measured *measured, const struct store_zone *row,
                               size_t count);

#define ZONES_HEARD_TEXT 300
/* Why a warning before `before_s` may not have been heard (INFINITY: any warning). False: there is
 * no reason. */
bool zones_heard_doubt(const struct zones_heard *heard, double before_s,
                       char out[ZONES_HEARD_TEXT]);

#endif
