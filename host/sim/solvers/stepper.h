/* Stepper: a method that advances a model step by step. PLANAR.md, "Solvers".
 *
 * The caller (pass.c) controls modes, events and outputs; a stepper only computes steps. `advance`
 * goes from (t, z) to (t_new, z_new) with t_new <= limit; `interpolate` gives the state within that
 * step. The caller then either accepts the whole step (t, z become t_new, z_new) or continues from
 * a point within it (an event, then restart). */
#ifndef MATRIG_HOST_SIM_SOLVERS_STEPPER_H
#define MATRIG_HOST_SIM_SOLVERS_STEPPER_H

#include "host/sim/models/model.h"

struct stepper;

struct stepper_kind {
    const char *name;
    /* modes are updated at every evaluation; switches are not located in time */
    bool samples_switches;
    /* as `samples_switches`, but the times at which mats stick or slip are located */
    bool samples_shape_switches;
    /* as `samples_switches`, but determines within the step which mats stop */
    bool finds_stops_in_step;
    bool has_fixed_step; /* the step size is given (dt) */
    bool can_omit_mats;  /* mats at rest may be omitted */
    bool has_long_steps; /* steps can be so long that a mat slips and sticks within one */
    /* speed, in veps, within which the friction law tanh reverses; 0: not considered */
    double reversal_speed_veps;
    double rtol; /* default tolerance */
    /* other stepper that is faster at tolerances of loose_rtol and above; NULL: none */
    const struct stepper_kind *kind_for_loose_rtol;
    double loose_rtol;
    const char *description; /* description for users, one line */
    /* Memory of the stepper: work_bytes bytes, all 0, which begin with `row_count` pointers to rows
     * of 2 size values; and `extra_value_rows` times size further values, which are passed to
     * `make`. */
    size_t work_bytes, row_count, extra_value_rows;
    /* Prepares the values `extra_values`; NULL: nothing to prepare. */
    void (*make)(struct stepper *stepper, double *extra_values);
    /* releases the memory that `make` allocated; NULL: nothing */
    void (*free)(struct stepper *stepper);
    /* discards the history, because modes or state have changed */
    void (*restart)(struct stepper *stepper);
    /* returns false if the step became too small */
    bool (*advance)(struct stepper *stepper, double limit_s);
    /* Computes the state at t within the last step: components low..high-1 of p and of v. */
    void (*interpolate)(struct stepper *stepper, double t_s, int low, int high, double *z);
};

struct stepper {
    const struct stepper_kind *kind;
    struct model *model;
    double rtol;
    double atol_ft, atol_ft_s; /* absolute tolerances of positions and rates */
    double dt_s;               /* step size dt, if it is given */
    double h_s;                /* size of the next step */
    double min_step_s;         /* a smaller step is a failure */
    double t_s, t_new_s;
    double *z, *z_new; /* state before and after the step: 2 size values each */
    /* Rates (v, p'') at both ends of the last step; NULL: not known. */
    const double *rate, *rate_new;
    uint64_t rejected_steps;
    void *work;      /* memory of this kind of stepper */
    double *storage; /* the values to which `work` points; stepper_make allocates both */
};

extern const struct stepper_kind stepper_rk4, stepper_event, stepper_event5, stepper_implicit,
    stepper_rkgs, stepper_hamming, stepper_moreau;
/* The solver of SUNDIALS, linked only into matrig-study. Weak, so its address is NULL in other
 * programs. */
extern const struct stepper_kind stepper_cvode __attribute__((weak));

/* Finds a kind by name. NULL: there is none. */
const struct stepper_kind *stepper_find(const char *name);

/* Allocates the memory and calls `make` of the kind. */
void stepper_make(struct stepper *stepper);
void stepper_free(struct stepper *stepper);

/* First index in p that the model integrates. */
static inline int stepper_first_index(const struct stepper *s)
{
    return 2 * s->model->first_mat;
}
static inline int stepper_end_index(const struct stepper *s)
{
    return 2 * s->model->last_mat + 3;
}

/* Chooses the step: h_s, or the step to the limit if that is at most 1 % longer (sets `last`).
 * Returns false if h_s has become too small. */
bool stepper_choose_step(const struct stepper *stepper, double limit_s, double *h_s, bool *last);

/* Friction tanh reverses where a mat's speed passes through 0, within a few veps. If the step is
 * much longer, the reversal is a jump, which reduces the order of the method and which the error
 * estimate may miss. Shortens the step to end where the reversal begins, and returns true if it did
 * so; the next two steps cover the reversal. Uses the rates at the start of the step. */
bool stepper_end_at_reversal(const struct stepper *stepper, const double *rate, double *h_s);

/* Accepts the step h_s to t_new_s. The next step is `grow` times as long. If this step was
 * shortened by a limit or a friction reversal (`last`), the next step has the length that was
 * planned for this one. */
void stepper_accept(struct stepper *stepper, double h_s, double t_new_s, bool last, double grow);
/* Rejects the step. The next step has the size next_s. */
void stepper_reject(struct stepper *stepper, double next_s);

/* Error of z_new, for a method of order 4, divided by the tolerance. The error is a fifteenth of
 * the difference from `whole`, the result with steps of double size; the largest of all components
 * is returned. NaN: the state is not finite. */
double stepper_doubling_error(const struct stepper *stepper, const double *whole);

/* Copies a state, for the mats that the model integrates. */
void stepper_copy(const struct stepper *stepper, const double *from, double *to);

/* Rates (v, p'') of a state. Sampling steppers update the modes first. */
void stepper_rates(struct stepper *stepper, double t_s, const double *z, double *rate);

/* Interpolates between two states and their rates by a cubic. For steppers without dense output. */
void stepper_interpolate_cubic(const struct stepper *stepper, const double *z0, const double *rate0,
                               const double *z1, const double *rate1, double t_s, int low, int high,
                               double *z);

/* As stepper_interpolate_cubic, over the last step. Computes the rates at its ends and writes them
 * to rate0 and rate1. */
void stepper_interpolate_last_step(struct stepper *stepper, double *rate0, double *rate1,
                                   double t_s, int low, int high, double *z);

#endif
