/* A file of push tests: a mat under the load of an axle is pushed along the runway, and what it
 * moved is read at each force, on the way up and on the way down (docs/howto/push-test.md).
 *
 *     test,load (lb),force (lb),displacement (in)
 *     A,108,0,0
 *     A,108,10,0.016
 *     B,216,0,0.0005
 *
 * The first line names the columns: load, force and displacement (or dial) with their units, as
 * calibrate reads them (host/calibrate/points.h: lb, N, kN, kg; in, mm, cm, m, ft), and test, which
 * may be missing. They may stand in any order. A value may have a unit of its own behind it. Rows
 * stand in the order in which they were read. A new test, or another load, is a series of its own:
 * its ground is fresh and its dial has a zero of its own. An empty load or test is that of the row
 * before. Empty lines and lines that begin with # are passed over. */
#ifndef MATRIG_HOST_PUSH_READINGS_H
#define MATRIG_HOST_PUSH_READINGS_H

#include <stddef.h>

#include "host/base/error.h"

#define PUSH_SERIES_MAX   40u
#define PUSH_READINGS_MAX 60u /* of a series: 0.3 s each */
#define PUSH_NAME         24u
#define PUSH_MOST_LB      1e7 /* a load or a force; a displacement */
#define PUSH_MOST_IN      1e4

struct push_series {
    const char *path;     /* of the file, for errors; the caller's */
    char name[PUSH_NAME]; /* of its test, or its number in the file */
    double load_lb;
    size_t count;
    double force_lb[PUSH_READINGS_MAX], moved_in[PUSH_READINGS_MAX];
};

struct push_readings {
    struct push_series *series; /* allocated */
    size_t count;
};

/* Frees what was read when it fails, too. MR_IO; MR_MALFORMED, naming file, line and column;
 * MR_TOO_LONG. */
enum mr_status push_readings_load(const char *path, struct push_readings *readings,
                                  struct error *error);
void push_readings_free(struct push_readings *readings);

#endif
