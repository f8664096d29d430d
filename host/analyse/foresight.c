#include "host/analyse/foresight.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "common/predictor.h"
#include "host/store/store.h"
#include "host/base/units.h"

/* from arming on the transducers' zeros are found first (0.2 s): nobody lacks them then */
#define SETTLING_BLOCKS 500

static double time_s(const struct measured *measured, int64_t block)
{
    return measured_block_s(measured, block);
}

static void stretch(struct foresight_span *span, double t_s)
{
    if (isnan(span->from_s))
        span->from_s = t_s;
    span->to_s = t_s;
}

/* No motion is a lack only where something moves: before the first switches nobody expects one, and
 * then the level is not kinematic. */
static void look(struct foresight *foresight, const struct store_prediction *row, double t_s)
{
    if (row->basis == STORE_NONE || row->level == STORE_NONE)
        return;
    bool kinematic = row->level == MR_PREDICTOR_KINEMATIC && row->basis & MR_PREDICTOR_NO_MOTION;
    const bool lacks[FORESIGHT_LACKS] = {row->basis & MR_PREDICTOR_BLIND, kinematic,
                                         row->basis & MR_PREDICTOR_DEGRADED,
                                         row->basis & MR_PREDICTOR_FELL_BACK};
    for (unsigned i = 0; i < FORESIGHT_LACKS; i++) {
        if (lacks[i])
            stretch(&foresight->lack[i], t_s);
    }
    if (lacks[FORESIGHT_DEGRADED] && row->level > foresight->worst_level)
        foresight->worst_level = row->level;
}

static void doubt(struct foresight *foresight, const struct measured *measured,
                  const struct store_trust *row)
{
    double t_s = time_s(measured, row->block);
    for (unsigned i = 0; i < MR_TRANSDUCERS && row->doubts != STORE_NONE; i++) {
        unsigned why = (unsigned)row->doubts >> 2 * i & 3u;
        foresight->doubted_still[i] = why != 0;
        if (!why || measured->channel[i].config.kind != MR_KIND_DISPLACEMENT)
            continue;
        foresight->doubt[i] = why;
        stretch(&foresight->left_out[i], t_s);
    }
    if (!isnan(row->resistance))
        foresight->resistance = row->resistance;
}

static enum mr_status load_risk(struct store *store, const struct measured *measured,
                                struct foresight *foresight, struct error *error)
{
    struct store_risk *rows = NULL;
    size_t count = 0;
    foresight->risk_most = foresight->risk_most_s = foresight->plan_left_s = (double)NAN;
    enum mr_status status = store_risks(store, measured->landing.id, &rows, &count, error);
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        double t_s = time_s(measured, rows[i].block);
        unsigned basis = rows[i].basis == STORE_NONE ? 0u : (unsigned)rows[i].basis;
        foresight->chart_old |= (basis & MR_RISK_CHART_OLD) != 0;
        if (basis & MR_RISK_PLAN_LEFT && isnan(foresight->plan_left_s))
            foresight->plan_left_s = t_s;
        if (isnan(rows[i].risk) ||
            (!isnan(foresight->risk_most) && rows[i].risk <= foresight->risk_most))
            continue;
        foresight->risk_most = rows[i].risk;
        foresight->risk_most_s = t_s;
        foresight->risk_basis = basis;
    }
    free(rows);
    return status;
}

enum mr_status foresight_load(struct store *store, const struct measured *measured,
                              struct foresight *foresight, struct error *error)
{
    struct store_prediction *rows = NULL;
    struct store_trust *trusts = NULL;
    struct mr_predictor_state state;
    size_t count = 0, trust_count = 0;
    bool there = false;
    *foresight = (struct foresight){.source = STORE_NONE, .resistance = (double)NAN};
    for (unsigned i = 0; i < FORESIGHT_LACKS; i++)
        foresight->lack[i].from_s = (double)NAN;
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        foresight->left_out[i].from_s = (double)NAN;
    enum mr_status status = store_predictions(store, measured->landing.id, &rows, &count, error);
    if (status == MR_OK)
        status = store_trusts(store, measured->landing.id, &trusts, &trust_count, error);
    if (status == MR_OK)
        status = store_runway_get(store, measured->landing.id, &state, &foresight->source, &there,
                                  error);
    if (status == MR_OK)
        status = load_risk(store, measured, foresight, error);
    if (status == MR_OK) {
        foresight->statements = count;
        foresight->landings = there ? state.landings : 0;
        foresight->source = there ? foresight->source : STORE_NONE;
        int64_t settled = count ? rows[0].block + SETTLING_BLOCKS : 0;
        for (size_t i = 0; i < count; i++) {
            if (rows[i].block >= settled)
                look(foresight, &rows[i], time_s(measured, rows[i].block));
        }
        for (size_t i = 0; i < trust_count; i++) {
            if (trusts[i].block >= settled)
                doubt(foresight, measured, &trusts[i]);
        }
    }
    free(rows);
    free(trusts);
    return status;
}

#define LABEL "foresight"

static void begin_answer(const struct foresight *foresight, struct answer *answer)
{
    char after[40] = "", resists[80] = "";
    if (foresight->landings)
        snprintf(after, sizeof after, ", after %u landings", foresight->landings);
    if (!isnan(foresight->resistance))
        snprintf(resists, sizeof resists,
                 "; its joints resist closing %.2f times as much as configured",
                 foresight->resistance);
    answer_words(answer, NULL, LABEL, "the runway it began with: %s%s%s",
                 foresight->source == STORE_NONE
                     ? "not told"
                     : mr_runway_source_text((unsigned)foresight->source),
                 after, resists);
}

static void lack_answer(const struct foresight *foresight, enum foresight_lack lack,
                        struct answer *answer)
{
    static const char *const words[] = {
        [FORESIGHT_BLIND] = "blind: no transducer to correct the model; zones are what it makes of "
                            "switches, survey and earlier landings",
        [FORESIGHT_NO_MOTION] = "no switch told where the gear is: zones from transducers and "
                                "survey alone, without times to them",
        [FORESIGHT_BEGUN_AGAIN] = "the model ran away and was begun again from the last survey or "
                                  "landing: distrust its zones",
    };
    const struct foresight_span *span = &foresight->lack[lack];
    if (isnan(span->from_s))
        return;
    if (lack == FORESIGHT_DEGRADED)
        answer_words(answer, NULL, LABEL,
                     "%s instead of every mat, from %.3f to %.3f s: the budget "
                     "(predict.updates_per_block) or a backlog; ends of zones are less certain",
                     mr_predictor_level_text((unsigned)foresight->worst_level), span->from_s,
                     span->to_s);
    else
        answer_words(answer, NULL, LABEL, "%s; from %.3f to %.3f s", words[lack], span->from_s,
                     span->to_s);
}

static void doubt_answer(const struct foresight *foresight, const struct measured *measured,
                         unsigned i, struct answer *answer)
{
    const struct unit *station = unit_of(UNIT_STATION, answer_in_si(answer));
    const struct foresight_span *span = &foresight->left_out[i];
    char until[40] = " on";
    if (isnan(span->from_s))
        return;
    if (!foresight->doubted_still[i])
        snprintf(until, sizeof until, " to %.3f s", span->to_s);
    answer_words(answer, NULL, LABEL,
                 "transducer %u (%.1f %s) was left out: %s, from %.3f s%s; zones around it rest on "
                 "its neighbours and the model",
                 i + 1u, (double)measured->channel[i].config.station_ft * station->factor,
                 station->text, mr_predictor_doubt_text(foresight->doubt[i]), span->from_s, until);
}

static void risk_answer(const struct foresight *foresight, struct answer *answer)
{
    if (isnan(foresight->risk_most))
        return;
    answer_words(answer, NULL, LABEL, "risk of a zone of %u mats at most %.2f, at %.3f s%s%s",
                 MR_PREDICTOR_WARNING_MATS, foresight->risk_most, foresight->risk_most_s,
                 foresight->risk_basis & MR_RISK_OF_CHART  ? ", by chart and plan"
                 : foresight->risk_basis & MR_RISK_OF_PLAN ? ", by the plan, without a chart"
                                                           : ", without plan and chart",
                 foresight->risk_basis & MR_RISK_BLIND ? ", blind" : "");
    if (!isnan(foresight->plan_left_s))
        answer_words(answer, NULL, LABEL,
                     "the plan was not followed, seen at %.3f s: the risk went on without it",
                     foresight->plan_left_s);
    if (foresight->chart_old)
        answer_words(answer, NULL, LABEL,
                     "the chart given was of another runway, with another number of landings: it "
                     "was ignored");
}

void foresight_answer(const struct foresight *foresight, const struct measured *measured,
                      struct answer *answer)
{
    answer_list(answer, "foresight", "");
    if (foresight->statements)
        begin_answer(foresight, answer);
    for (unsigned i = 0; foresight->statements && i < FORESIGHT_LACKS; i++)
        lack_answer(foresight, (enum foresight_lack)i, answer);
    for (unsigned i = 0; foresight->statements && i < MR_TRANSDUCERS; i++)
        doubt_answer(foresight, measured, i, answer);
    if (foresight->statements)
        risk_answer(foresight, answer);
    answer_close(answer);
}
