/* The walk of `matrig ready --walk`: somebody trips, pushes and pulls along the rig while the board
 * tells it live; what answered is judged, or, with --learn, the steps of the switches become a
 * configuration. */
#ifndef MATRIG_HOST_COMMANDS_READY_WALK_H
#define MATRIG_HOST_COMMANDS_READY_WALK_H

#include "host/base/cli.h"
#include "host/board/ready.h"

enum walk_kind { WALK_SWITCHES, WALK_TRANSDUCERS, WALK_GAGES, WALK_KINDS };

struct ready_walk {
    const struct cli *cli;
    const char *db, *serial, *can;
    const char *learn; /* file for the configuration; NULL: nothing is learned */
    double for_s;      /* NaN: the usual time */
    bool wanted[WALK_KINDS];
};

/* Kinds by their names with commas between; NULL: all. MR_USAGE. */
enum mr_status ready_walk_kinds(const char *of, bool wanted[WALK_KINDS], struct error *error);
/* The walk; returns the exit code. `facts`: filled in by it. */
int ready_walk(const struct ready_walk *request, struct ready_facts *facts);
/* Prints a report, or as JSON; returns the exit code. */
int ready_tell(const struct cli *cli, const char *kind, const struct ready_report *report,
               const struct identity *identity, int64_t made_us, double took_s);

#endif
