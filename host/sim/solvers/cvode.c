/* cvode: SUNDIALS' variable-order BDF with its banded direct solver, a general-purpose solver for
 * comparison. It restarts where the wheel reaches the next mat, and where a mat stops or breaks
 * loose, because exact sticking cannot be written as a differential equation. The other switches
 * are sampled, as a user of the library might do.
 *
 * Its state is p and v interleaved (half-bandwidth 2 MODEL_HALF_BANDWIDTH + 1). Rates need the
 * inverse of the mass matrix, which is full. The Newton matrix is therefore M (I - gamma J), which
 * is banded, and the right-hand side is multiplied by M before the library solves. The matrix is
 * computed for every step. An old matrix, from before a foot left the soil, would still contain the
 * soil's damper; the iteration would converge at once, and the library would accept a step that it
 * should reject.
 *
 * cvode is an independent check of the other solvers: method, step control and matrix solution are
 * those of the library. Right-hand side, Jacobian and laws are those of the model (models/model.h),
 * as in every solver; tests/sim_reference checks them independently. */
#include <cvode/cvode.h>
#include <math.h>
#include <stdlib.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_band.h>
#include <sunmatrix/sunmatrix_band.h>

#include "host/base/xmalloc.h"
#include "host/sim/models/model.h"
#include "host/sim/solvers/stepper.h"

struct cvode_work {
    double *z, *rate, *half_rhs; /* 2 size values in each array */
    double *mass, *dr_dp, *dr_dv, *dr_dt;
    struct stepper *stepper;
    SUNContext context;
    void *cvode;
    N_Vector y, tolerance, interpolated;
    SUNMatrix matrix;
    SUNLinearSolver solver, band_solver;
    bool is_started;
};

static void state_from_vector(const struct cvode_work *w, const double *y, double *z)
{
    int size = w->stepper->model->coordinate_count;
    for (int i = 0; i < size; i++) {
        z[i] = y[2 * i];
        z[size + i] = y[2 * i + 1];
    }
}

static void vector_from_state(const struct cvode_work *w, const double *z, double *y)
{
    int size = w->stepper->model->coordinate_count;
    for (int i = 0; i < size; i++) {
        y[2 * i] = z[i];
        y[2 * i + 1] = z[size + i];
    }
}

static int compute_rates(realtype t, N_Vector y, N_Vector to, void *user)
{
    struct cvode_work *w = user;
    int size = w->stepper->model->coordinate_count;
    state_from_vector(w, N_VGetArrayPointer(y), w->z);
    stepper_rates(w->stepper, t, w->z, w->rate);
    for (int i = 0; i < 2 * size; i++) {
        if (!isfinite(w->rate[i]))
            return 1; /* makes the library retry with a smaller step */
    }
    vector_from_state(w, w->rate, N_VGetArrayPointer(to));
    return 0;
}

static void add_row(SUNMatrix matrix, int row, int i, int size, const double *rows, double scale,
                    int half)
{
    for (int k = 0; k < MODEL_ROW_LENGTH; k++) {
        int column = i + k - MODEL_HALF_BANDWIDTH;
        if (column >= 0 && column < size)
            SM_ELEMENT_B(matrix, row, 2 * column + half) +=
                scale * rows[(size_t)i * MODEL_ROW_LENGTH + (size_t)k];
    }
}

static int set_newton_matrix(realtype t, N_Vector y, N_Vector fy, SUNMatrix matrix,
                             booleantype reuse, booleantype *fresh, realtype gamma, void *user,
                             N_Vector t1, N_Vector t2, N_Vector t3)
{
    struct cvode_work *w = user;
    struct model *m = w->stepper->model;
    (void)t1, (void)t2, (void)t3;
    if (!reuse) {
        state_from_vector(w, N_VGetArrayPointer(y), w->z);
        state_from_vector(w, N_VGetArrayPointer(fy), w->rate);
        model_sample_shape_modes(m, w->z);
        model_linearise(m, t, w->z, w->rate + m->coordinate_count, w->mass, w->dr_dp, w->dr_dv,
                        w->dr_dt);
    }
    *fresh = !reuse;
    SUNMatZero(matrix);
    for (int i = 0; i < m->coordinate_count; i++) {
        SM_ELEMENT_B(matrix, 2 * i, 2 * i) = 1.0;
        SM_ELEMENT_B(matrix, 2 * i, 2 * i + 1) = -gamma;
        add_row(matrix, 2 * i + 1, i, m->coordinate_count, w->mass, 1.0, 1);
        add_row(matrix, 2 * i + 1, i, m->coordinate_count, w->dr_dp, -gamma, 0);
        add_row(matrix, 2 * i + 1, i, m->coordinate_count, w->dr_dv, -gamma, 1);
    }
    return 0;
}

static SUNLinearSolver_Type band_solver_type(SUNLinearSolver solver)
{
    (void)solver;
    return SUNLINEARSOLVER_DIRECT;
}

static int band_solver_setup(SUNLinearSolver solver, SUNMatrix matrix)
{
    return SUNLinSolSetup(((struct cvode_work *)solver->content)->band_solver, matrix);
}

static int band_solver_solve(SUNLinearSolver solver, SUNMatrix matrix, N_Vector x, N_Vector b,
                             realtype tolerance)
{
    struct cvode_work *w = solver->content;
    int size = w->stepper->model->coordinate_count;
    double *right = N_VGetArrayPointer(b);
    for (int i = 0; i < size; i++)
        w->half_rhs[size + i] = right[2 * i + 1];
    banded_multiply(size, w->mass, w->half_rhs + size, w->half_rhs);
    for (int i = 0; i < size; i++)
        right[2 * i + 1] = w->half_rhs[i];
    return SUNLinSolSolve(w->band_solver, matrix, x, b, tolerance);
}

static void free_work(struct stepper *s)
{
    struct cvode_work *w = s->work;
    if (w->cvode)
        CVodeFree(&w->cvode);
    if (w->solver)
        SUNLinSolFreeEmpty(w->solver);
    if (w->band_solver)
        SUNLinSolFree(w->band_solver);
    if (w->matrix)
        SUNMatDestroy(w->matrix);
    if (w->y)
        N_VDestroy(w->y);
    if (w->tolerance)
        N_VDestroy(w->tolerance);
    if (w->interpolated)
        N_VDestroy(w->interpolated);
    if (w->context)
        SUNContext_Free(&w->context);
}

/* Creates the objects of the library. Returns false if one could not be created. */
static bool create_sundials_objects(struct stepper *s)
{
    struct cvode_work *w = s->work;
    int length = 2 * s->model->coordinate_count, half = 2 * MODEL_HALF_BANDWIDTH + 1 < length - 1
                                                          ? 2 * MODEL_HALF_BANDWIDTH + 1
                                                          : length - 1;
    if (SUNContext_Create(NULL, &w->context) != 0)
        return false;
    w->y = N_VNew_Serial(length, w->context);
    w->tolerance = N_VNew_Serial(length, w->context);
    w->interpolated = N_VNew_Serial(length, w->context);
    w->matrix = SUNBandMatrix(length, half, half, w->context);
    w->cvode = CVodeCreate(CV_BDF, w->context);
    w->solver = SUNLinSolNewEmpty(w->context);
    if (!w->y || !w->tolerance || !w->interpolated || !w->matrix || !w->cvode || !w->solver)
        return false;
    w->band_solver = SUNLinSol_Band(w->y, w->matrix, w->context);
    if (!w->band_solver)
        return false;
    w->solver->content = w;
    w->solver->ops->gettype = band_solver_type;
    w->solver->ops->setup = band_solver_setup;
    w->solver->ops->solve = band_solver_solve;
    double *tolerance = N_VGetArrayPointer(w->tolerance);
    for (int i = 0; i < length; i++)
        tolerance[i] = i % 2 == 0 ? s->atol_ft : s->atol_ft_s;
    vector_from_state(w, s->z, N_VGetArrayPointer(w->y));
    return CVodeInit(w->cvode, compute_rates, 0.0, w->y) == CV_SUCCESS &&
           CVodeSetUserData(w->cvode, w) == CV_SUCCESS &&
           CVodeSetErrFile(w->cvode, NULL) == CV_SUCCESS &&
           CVodeSVtolerances(w->cvode, s->rtol, w->tolerance) == CV_SUCCESS &&
           CVodeSetLinearSolver(w->cvode, w->solver, w->matrix) == CV_SUCCESS &&
           CVodeSetLinSysFn(w->cvode, set_newton_matrix) == CV_SUCCESS &&
           CVodeSetLSetupFrequency(w->cvode, 1) == CV_SUCCESS &&
           CVodeSetJacEvalFrequency(w->cvode, 1) == CV_SUCCESS &&
           CVodeSetMaxErrTestFails(w->cvode, 40) == CV_SUCCESS &&
           CVodeSetMaxConvFails(w->cvode, 40) == CV_SUCCESS;
}

static void make(struct stepper *s, double *more)
{
    struct cvode_work *w = s->work;
    size_t size = (size_t)s->model->coordinate_count;
    w->stepper = s;
    w->dr_dt = more;
    w->mass = w->dr_dt + size;
    w->dr_dp = w->mass + MODEL_ROW_LENGTH * size;
    w->dr_dv = w->dr_dp + MODEL_ROW_LENGTH * size;
    if (!create_sundials_objects(s))
        xmalloc_exit_out_of_memory(size * sizeof *more);
}

static void restart(struct stepper *s)
{
    ((struct cvode_work *)s->work)->is_started = false;
}

static bool advance(struct stepper *s, double limit_s)
{
    struct cvode_work *w = s->work;
    realtype reached = s->t_s;
    if (!w->is_started) {
        vector_from_state(w, s->z, N_VGetArrayPointer(w->y));
        if (CVodeReInit(w->cvode, s->t_s, w->y) != CV_SUCCESS)
            return false;
        w->is_started = true;
    }
    if (CVodeSetStopTime(w->cvode, limit_s) != CV_SUCCESS)
        return false;
    int flag = CVode(w->cvode, limit_s, w->y, &reached, CV_ONE_STEP);
    long failures = 0;
    CVodeGetNumErrTestFails(w->cvode, &failures);
    if (flag < 0 || !(reached > s->t_s))
        return false;
    state_from_vector(w, N_VGetArrayPointer(w->y), s->z_new);
    s->t_new_s = flag == CV_TSTOP_RETURN ? limit_s : reached;
    return true;
}

static void interpolate(struct stepper *s, double t_s, int low, int high, double *z)
{
    struct cvode_work *w = s->work;
    if (CVodeGetDky(w->cvode, fmin(t_s, s->t_new_s), 0, w->interpolated) != CV_SUCCESS)
        N_VScale(1.0, w->y, w->interpolated);
    const double *y = N_VGetArrayPointer(w->interpolated);
    for (int i = low; i < high; i++) {
        z[i] = y[2 * i];
        z[s->model->coordinate_count + i] = y[2 * i + 1];
    }
}

const struct stepper_kind stepper_cvode = {
    .name = "cvode",
    .samples_shape_switches = true,
    .rtol = 1e-8,
    .description = "SUNDIALS CVODE, BDF, banded, restarted at each new mat and at each change "
                   "between sticking and slipping",
    .work_bytes = sizeof(struct cvode_work),
    .row_count = 3,
    .extra_value_rows = 1 + 3 * MODEL_ROW_LENGTH,
    .make = make,
    .free = free_work,
    .restart = restart,
    .advance = advance,
    .interpolate = interpolate,
};
