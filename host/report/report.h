/* What a report is made from, and where its sections come from. page.c lists them; each is a file
 * of its own. */
#ifndef MATRIG_HOST_REPORT_REPORT_H
#define MATRIG_HOST_REPORT_REPORT_H

#include <stdio.h>

#include "common/config.h"
#include "host/analyse/summary.h"
#include "host/base/answer.h"
#include "host/store/store_journal.h"
#include "host/store/store_predict.h"

struct report_landing {
    struct summary summary;
    struct zones_closure survey;
    struct store_series series; /* id 0: none */
    struct store_motion *motion;
    size_t motions;
    struct store_prediction *prediction;
    size_t predictions;
    struct store_simulation *simulation; /* of the newest comparison */
    size_t simulations;
    struct store_simulation_head head; /* of the same */
    struct mr_config *config; /* the board's whole configuration; NULL: it was never read */
};

struct report {
    const char *path; /* of the database */
    struct store *store;
    struct report_landing *landing;
    size_t landings, voided; /* voided: left out */
    struct store_slow *slow;
    size_t slow_rows;
    int64_t run;      /* the only one; 0: all */
    const char *film; /* folder with pictures of the film; NULL: none given */
    bool si;
};

/* Landing report->run, or all of the campaign that count, or with `voided` all there are. The
 * caller frees with report_free, also after an error. */
enum mr_status report_load(struct report *report, bool voided, struct error *error);
void report_free(struct report *report);

/* A section writes what is to be read under its heading; one that writes nothing is left out of the
 * page and its contents. */
typedef enum mr_status report_section(const struct report *report, FILE *out, struct error *error);
typedef enum mr_status report_part(const struct report *report,
                                   const struct report_landing *landing, FILE *out,
                                   struct error *error);

/* An answer on the page; frees the answer. */
void report_answer(struct answer *answer, FILE *out);

/* Of the campaign (campaign_*.c): */
report_section campaign_summary, campaign_compared, campaign_cumulative, campaign_zones,
    campaign_tension, campaign_predictor, campaign_slow, campaign_journal, campaign_survey,
    campaign_advice, campaign_record;
/* Of a landing (landing_*.c): */
report_part landing_facts, landing_speed, landing_movement, landing_wheel, landing_zones,
    landing_tensions, landing_along, landing_bands, landing_predictor, landing_film,
    landing_channels, landing_compare, landing_health;

/* The newest comparison's figures, from what is measured now; false: there is none, or an error. */
struct compare_figures;
bool landing_compared(const struct report_landing *landing, struct compare_figures *figures,
                      struct error *error);

/* The last section, which says what was drawn and by what: of all that was written so far. */
enum mr_status provenance_write(const struct report *report, const char *page, size_t length,
                                FILE *out, struct error *error);

#endif
