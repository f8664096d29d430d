/* Band design: restraining bands by Appendix C of the report, and the same band in the chain model.
 *
 * Units lb, ft, s. C.3 is misprinted (N for W: R = (W a/g)(s/b)) and so is C.10 (n for n F': n F' =
 * A fy - R); the worked example settles both. */
#ifndef MATRIG_HOST_ANALYSE_BANDDESIGN_H
#define MATRIG_HOST_ANALYSE_BANDDESIGN_H

#include <stdbool.h>

#include "host/base/error.h"

struct band_design {
    /* given */
    double weight_lb, g_ft_s2, deceleration_ft_s2;
    double bands; /* that carry it together, N */
    double area_ft2, yield_lb_ft2, modulus_lb_ft2;
    double mat_lb, friction;
    double held;         /* mats that act against one connection */
    double every;        /* rows from one connection to the next */
    double row_ft;       /* length of a mat along the runway */
    double width_ft;     /* of influence of the gear, b; 0: not given */
    double length_ft;    /* of band between its springs; 0: as long as it may be */
    double spring_lb_ft; /* K at either end; 0: A E/L, as soft as dT = R/2 supposes */
    double at;           /* a': where R acts, fraction of the length */
    double tension_lb;   /* T0 chosen; 0: the design's */
    double grip_lb;      /* of a connection; INFINITY: holds all */
    double speed_ft_s;   /* at which the aircraft brakes along the band, in the model */
    int passes;
    /* worked out by band_design */
    double r_lb;          /* C.1 */
    double strength_lb;   /* A fy */
    double friction_lb;   /* most n F' that C.8 and C.9 leave room for, C.10 */
    double connection_lb; /* F' */
    double connections;   /* n: of the band as long as given, else the most */
    double most_connections;
    double longest_ft;
    double least_t0_lb, most_t0_lb; /* C.8, C.9 for n */
    double t0_lb;                   /* chosen, or in their middle */
    double spacing_ft;              /* C.2; 0: not known */
    double ahead_lb, behind_lb;     /* C.6, C.7: changes */
    double least_lb, most_lb;       /* tensions that follow: T0 - n F' - R/2, T0 + R/2 */
};

struct band_check {
    double least_lb, most_lb; /* in the band, all passes; least below 0: slack */
    int least_pass, most_pass;
    double least_ft, most_ft; /* where: middle of the segment */
    double slack_share;       /* of the segments */
    double load_lb;           /* most a connection carries */
    double load_ft;
    double slip_ft;
    double moved_ft;           /* largest movement of a mat in a pass */
    double residual_lb;        /* most tension that is missing after the last pass */
    double error_lb, error_ft; /* estimates of the model's own */
    int mats;
    double run_ms;
};

/* The worked example of Appendix C, as given. */
void band_design_defaults(struct band_design *design);

/* Work out the rest. MR_USAGE when no band can do it, saying why. */
enum mr_status band_design(struct band_design *design, struct error *error);

/* Lay the band on a strip of mats, one mat per row, in the chain model and let the aircraft brake
 * with R all along it, `passes` times, each beginning with what the one before left. MR_NUMERICS as
 * sim_run. */
enum mr_status band_check(const struct band_design *design, struct band_check *check,
                          struct error *error);

#endif
