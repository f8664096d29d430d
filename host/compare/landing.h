/* Landings of a campaign compared with a model: one, kept in the campaign, or a series. */
#ifndef MATRIG_HOST_COMPARE_LANDING_H
#define MATRIG_HOST_COMPARE_LANDING_H

#include "host/compare/figures.h"
#include "host/compare/limits.h"
#include "host/compare/model.h"

/* One landing of a campaign compared with a model, and the comparison kept in the campaign. */

struct compare_landing {
    struct compare_figures figures;
    struct measured measured;
    struct store_simulation_head head;
    struct store_simulation row[MR_TRANSDUCERS]; /* aligned with the measured */
    size_t rows;
    /* of the gage points by this landing, simulated */
    double moved_in[SURVEY_POINTS], moved_spread_in[SURVEY_POINTS];
};

/* RUN as landing `index` (from 0) of the model's series: simulated, compared and kept; it replaces
 * no earlier comparison. MR_TOO_FEW, MR_TRUNCATED: nothing to compare with (no motion, no
 * transducers), the model is as before. The caller frees, also after an error. */
enum mr_status compare_landing(struct store *store, int64_t run, struct compare_model *model,
                               size_t index, struct compare_landing *landing, struct error *error);
void compare_landing_free(struct compare_landing *landing);

/* A series of landings compared with one model, in order: each landing, all together, and what
 * surveys between them say. */

struct compare_series_landing {
    int64_t run;
    bool compared;
    char why[600]; /* not compared: why */
    struct compare_figures figures;
    struct compare_verdict verdict;
};

/* Movement of the gage points between two surveys; mean over the lines that have it. */
struct compare_moved {
    int64_t from_survey, to_survey;
    bool simulated; /* false: a landing between them was not */
    size_t landings, points;
    struct {
        double measured_in, error_in, simulated_in, spread_in; /* NaN: not read */
    } point[SURVEY_POINTS];                                    /* every ten mats */
    double bias_in, rms_in, chi; /* over the points; chi: in standard errors */
};

/* All landings of a series together. */
struct compare_pooled {
    double within; /* share of landings within their limits; NaN: not judged */
    double bias_in, rms_in;
    double moved_in; /* rms of the movements between surveys, measured less simulated */
};

struct compare_series {
    char against[120], name[80]; /* the model's file; the series' name, or empty: all landings */
    struct compare_series_landing *landing;
    size_t count, compared;
    struct {
        int64_t number;
        double station_ft;
        size_t landings;
        double samples, bias_in, rms_in;
    } channel
        [MR_TRANSDUCERS]; /* by number, pooled over the landings by samples; landings 0: none */
    struct compare_pooled pooled;
    double run_ms, error_in; /* all simulations; the largest of their estimates */
    struct compare_moved *moved;
    size_t moves;
    struct compare_verdict verdict; /* landings and series */
};

/* Landings of series `name` (NULL: of the campaign) that are not void, in order. A landing that
 * cannot be compared is there with its reason (no motion, a simulation that fails), and what it did
 * to the runway is unknown to those after it until the next survey. MR_TOO_FEW: none could be;
 * MR_UNKNOWN: no such series. `progress` may be NULL. The caller frees, also after an error. */
enum mr_status compare_series_run(struct store *store, const char *name,
                                  struct compare_model *model,
                                  void (*progress)(void *ctx, size_t done, size_t of), void *ctx,
                                  struct compare_series *set, struct error *error);
void compare_series_free(struct compare_series *set);

#endif
