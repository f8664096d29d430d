/* Stepper: one way to move a model forward, step by step. PLANAR.md, "Solvers".
 *
 * The driver (planar.c) owns time, modes, events and outputs; a stepper only steps. advance goes
 * from (t, z) to (t_new, z_new) with t_new <= limit; dense gives the state within that step. The
 * driver then either accepts the whole step (t, z become t_new, z_new) or goes on from a point
 * within (an event, then restart). */
#ifndef MATRIG_HOST_SIM_SOLVERS_STEPPER_H
#define MATRIG_HOST_SIM_SOLVERS_STEPPER_H

#include "host/sim/models/model.h"

struct stepper;

struct stepper_kind {
    const char *name;
    bool samples;       /* switches are looked up at every evaluation instead of located */
    bool samples_shape; /* that, but stick-slip is located */
    bool settles;       /* samples, and finds within the step who stops */
    bool fixed;         /* the step is given (dt), not chosen */
    bool prunes;        /* may leave out mats at rest */
    bool long_steps;    /* long enough for a mat to slip and stick within one */
    double turn_veps;   /* friction tanh turns over within so many veps of rest; 0: not asked */
    double rtol;        /* default tolerance */
    const struct stepper_kind *looser; /* does better at looser_rtol and above; NULL: none does */
    double looser_rtol;
    const char *method; /* one line for people */
    /* The kind's own: so many bytes, all 0, which begin with so many pointers to rows of 2 size
     * values; and so many times size values more, for `make`. */
    size_t work_bytes, rows, more;
    /* The rest, from `more` on; NULL: there is no rest. */
    void (*make)(struct stepper *stepper, double *more);
    void (*free)(struct stepper *stepper);    /* what `make` did; NULL: nothing */
    void (*restart)(struct stepper *stepper); /* modes or state have changed: forget the past */
    bool (*advance)(struct stepper *stepper, double limit_s); /* false: the step became too small */
    /* Components low..high-1 of p and of v at t within the last step. */
    void (*dense)(struct stepper *stepper, double t_s, int low, int high, double *z);
};

struct stepper {
    const struct stepper_kind *kind;
    struct model *model;
    double rtol;
    double atol_ft, atol_ft_s; /* absolute parts of the tolerance */
    double dt_s;               /* fixed step */
    double h_s;                /* next step */
    double least_s;            /* steps below this are given up */
    double t_s, t_new_s;
    double *z, *z_new; /* 2 size values */
    /* rates (v, p'') at both ends of the last step; NULL: not known */
    const double *rate, *rate_new;
    uint64_t rejected;
    void *work;      /* the kind's own, and */
    double *storage; /* what it keeps there; both are stepper_make's */
};

extern const struct stepper_kind stepper_rk4, stepper_event, stepper_event5, stepper_implicit,
    stepper_rkgs, stepper_hamming, stepper_moreau;
/* SUNDIALS': only matrig-study links it. Weak: its address is NULL elsewhere. */
extern const struct stepper_kind stepper_cvode __attribute__((weak));

/* The kind of that name, or NULL. */
const struct stepper_kind *stepper_find(const char *name);

/* Room for the kind's work, and what it has to make. */
void stepper_make(struct stepper *stepper);
void stepper_free(struct stepper *stepper);

/* The range of p that the model integrates. */
static inline int stepper_low(const struct stepper *s)
{
    return 2 * s->model->first;
}
static inline int stepper_high(const struct stepper *s)
{
    return 2 * s->model->last + 3;
}

/* The step to try now: h_s, or up to the limit when that is no more than 1 % further (`last`).
 * False: h_s has become too small. */
bool stepper_try(const struct stepper *stepper, double limit_s, double *h_s, bool *last);

/* Friction tanh turns over where a mat's speed passes through 0, within a few veps: for a step much
 * longer than that it is a jump, which costs a method its order and which the estimate of its error
 * may miss. True: the step is cut so that it ends where that begins, and over it two steps go. From
 * the rates at the start of the step. */
bool stepper_turns(const struct stepper *stepper, const double *rate, double *h_s);

/* The step h_s to t_new_s holds; the next is `grow` times as long, or as long as was meant before
 * the limit, or friction that turns over, cut this one (`last`). */
void stepper_accept(struct stepper *stepper, double h_s, double t_new_s, bool last, double grow);
/* It does not; the next try is with next_s. */
void stepper_reject(struct stepper *stepper, double next_s);

/* Error of z_new, of a method of order 4, over the tolerance: a fifteenth of what `whole`, the same
 * with steps of double size, differs by, the largest of all. NaN: a state that has grown beyond
 * numbers. */
double stepper_halves_error(const struct stepper *stepper, const double *whole);

/* The state of the mats that the model integrates. */
void stepper_copy(const struct stepper *stepper, const double *from, double *to);

/* Rates (v, p'') of a state. Sampling steppers bring the modes up to date first. */
void stepper_rates(struct stepper *stepper, double t_s, const double *z, double *rate);

/* Cubic between two states and their rates, for steppers without a dense output of their own. */
void stepper_cubic(const struct stepper *stepper, const double *z0, const double *rate0,
                   const double *z1, const double *rate1, double t_s, int low, int high, double *z);

/* The same over the last step; the rates at its ends are worked out into rate0 and rate1. */
void stepper_cubic_anew(struct stepper *stepper, double *rate0, double *rate1, double t_s, int low,
                        int high, double *z);

#endif
