#include "host/advise/advise.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/statistics.h"
#include "host/base/monotonic_clock.h"
#include "host/base/xmalloc.h"

#define SPEED_SPREAD     0.01 /* of a speed planned */
#define TOUCHDOWN_SPREAD 0.5  /* ft */
#define OUTSIDE          0.15 /* so much beyond the landings before is unlike them */
#define OUTSIDE_TIMES    1.5
#define EVEN_ROWS        (ADVISE_ROWS - 1u)
#define HARDEST_LEAST    2.2 /* rows go up to so many times what just stops, */
#define HARDEST_PLAN     1.3 /* or to so many times the plan */
#define HARDEST_TEXT     140

const char *advise_verdict_text(enum advise_verdict verdict)
{
    static const char *const texts[] = {"clear", "caution", "against"};
    return texts[verdict];
}

/* --- learning --- */

static const struct past_landing *last_measured(const struct past *past)
{
    for (size_t i = past->landings; i-- > 0;) {
        if (past->landing[i].measured)
            return &past->landing[i];
    }
    return NULL;
}

/* Says what is done next when the last line is old enough. */
static void tell(struct advise *advise, const char *what, size_t done, size_t of)
{
    double now_s = monotonic_s();
    if (!advise->request.to || now_s < advise->tell_s)
        return;
    fprintf(advise->request.to,
            "matrig: advise: %s: %zu of %zu done; fewer --members are quicker\n", what, done, of);
    advise->tell_s = now_s + ADVISE_TELL_S;
}

static enum mr_status learn(struct advise *advise, struct error *error)
{
    const struct past *past = &advise->past;
    for (size_t i = 0; i < past->landings; i++) {
        const struct past_landing *landing = &past->landing[i];
        tell(advise, "learning from the landings", i, past->landings);
        if (landing->relaid)
            advise_relay(&advise->members);
        if (!landing->measured) {
            advise->unlearned++;
            continue;
        }
        if (!advise_learn(&advise->members, &landing->seen))
            return error_set(error, MR_NUMERICS,
                             "RUN %lld cannot be learned from: a member of the ensemble ran away; "
                             "look at its readings, or void it",
                             (long long)landing->run);
    }
    if (past->relaid)
        advise_relay(&advise->members);
    advise_survey(&advise->members, past->sum_in, past->survey_error_in);
    return MR_OK;
}

/* --- the plan --- */

static bool unlike(double value, double low, double high)
{
    return value > high * (1.0 + OUTSIDE) || value < low * (1.0 - OUTSIDE);
}

static void find_outside(struct advise *advise)
{
    const struct past *past = &advise->past;
    double braking[2] = {(double)INFINITY, 0.0}, speed[2] = {(double)INFINITY, 0.0};
    for (size_t i = 0; i < past->landings; i++) {
        const struct advise_braking *was = &past->landing[i].seen.braking;
        if (!past->landing[i].measured)
            continue;
        braking[0] = fmin(braking[0], was->mean_ft_s2);
        braking[1] = fmax(braking[1], was->mean_ft_s2);
        speed[0] = fmin(speed[0], was->speed_ft_s);
        speed[1] = fmax(speed[1], was->speed_ft_s);
    }
    advise->outside = advise->members.learned &&
                      (unlike(advise->plan.mean_ft_s2, braking[0], braking[1]) ||
                       unlike(advise->plan.speed_ft_s, speed[0], speed[1]));
}

static void take_plan_history(struct advise *advise)
{
    const struct past *past = &advise->past;
    double *log_ratio = xcalloc(past->landings + 1, sizeof *log_ratio);
    size_t count = 0;
    for (size_t i = 0; i < past->landings; i++) {
        const struct past_landing *landing = &past->landing[i];
        if (landing->measured && landing->planned_ft_s2 > 0.0)
            log_ratio[count++] = log(landing->seen.braking.mean_ft_s2 / landing->planned_ft_s2);
    }
    advise->planned = (unsigned)count;
    advise_plan_met(log_ratio, count, &advise->plan.bias, &advise->plan.spread);
    free(log_ratio);
}

static enum mr_status make_plan(struct advise *advise, struct error *error)
{
    const struct advise_request *request = &advise->request;
    const struct past_landing *last = last_measured(&advise->past);
    double length_ft = (double)advise->past.runway.chain.mat_length_ft *
                       advise->past.runway.chain.mats;
    advise->plan = (struct advise_plan){.speed_ft_s = request->speed_ft_s,
                                        .speed_spread = SPEED_SPREAD,
                                        .mean_ft_s2 = request->deceleration_ft_s2,
                                        .touchdown_ft = request->touchdown_ft,
                                        .touchdown_spread_ft = TOUCHDOWN_SPREAD,
                                        .profile = request->profile,
                                        .seed = request->seed};
    struct advise_plan *plan = &advise->plan;
    if (isnan(plan->touchdown_ft))
        plan->touchdown_ft = isfinite(advise->past.touchdown_ft) ? advise->past.touchdown_ft : 0.0;
    if (plan->touchdown_ft >= length_ft)
        return error_set(error, MR_USAGE,
                         "not on the runway: touchdown at %.1f ft; the mats end at %.1f ft",
                         plan->touchdown_ft, length_ft);
    advise->as_before = isnan(plan->speed_ft_s) || isnan(plan->mean_ft_s2);
    if (advise->as_before && !last)
        return error_set(error, MR_USAGE,
                         "no plan: no landing before from which to take it; give --speed and "
                         "--deceleration");
    if (isnan(plan->speed_ft_s))
        plan->speed_ft_s = last->seen.braking.speed_ft_s;
    if (isnan(plan->mean_ft_s2))
        plan->mean_ft_s2 = last->seen.braking.mean_ft_s2;
    take_plan_history(advise);
    if (isfinite(request->spread)) {
        plan->spread = request->spread;
        plan->bias = 0.0;
    }
    return MR_OK;
}

/* --- rows --- */

/* From what just stops on the runway up, to a tenth; the plan among them. */
static void choose_rows(struct advise *advise, double mean_ft_s2[ADVISE_ROWS])
{
    double low = ceil(10.0 * advise->least_ft_s2) / 10.0,
           high = fmax(HARDEST_LEAST * advise->least_ft_s2, HARDEST_PLAN * advise->plan.mean_ft_s2);
    for (unsigned i = 0; i < EVEN_ROWS; i++)
        mean_ft_s2[i] = round(10.0 * (low + (high - low) * i / (EVEN_ROWS - 1u))) / 10.0;
    mean_ft_s2[EVEN_ROWS] = advise->plan.mean_ft_s2;
    sort_numbers(mean_ft_s2, ADVISE_ROWS);
    for (unsigned i = 0; i < ADVISE_ROWS; i++) {
        if (fabs(mean_ft_s2[i] - advise->plan.mean_ft_s2) < 1e-9)
            advise->plan_row = i;
    }
}

static void find_hardest(struct advise *advise)
{
    /* what rolls off is no braking to advise */
    size_t first = 0;
    while (first + 1 < advise->rows && advise->row[first].mean_ft_s2 < advise->least_ft_s2)
        first++;
    advise->hardest_ft_s2 = advise_hardest_ft_s2(advise->row + first, advise->rows - first,
                                                 advise->request.limit, &advise->beyond,
                                                 &advise->short_ft_s2);
}

static enum mr_status find_rows(struct advise *advise, struct error *error)
{
    struct advise_members *members = &advise->members;
    struct advise_braking *braking = xcalloc(members->count, sizeof *braking);
    struct advise_met *met = xcalloc(members->count, sizeof *met);
    double mean_ft_s2[ADVISE_ROWS];
    bool good = true;
    advise->least_ft_s2 = advise_least_ft_s2(members, &advise->plan);
    choose_rows(advise, mean_ft_s2);
    for (size_t i = 0; good && i < ADVISE_ROWS; i++) {
        tell(advise, "trying decelerations", i, ADVISE_ROWS);
        good = advise_row(members, &advise->plan, mean_ft_s2[i], braking, met, &advise->row[i]);
        if (good && i == advise->plan_row)
            advise_worth(members, braking, met, advise->worth);
        advise->rows++;
    }
    free(braking);
    free(met);
    if (!good)
        return error_set(error, MR_FULL,
                         "no memory for %zu members: matrig advise; ask for fewer (--members)",
                         members->count);
    return MR_OK;
}

/* --- the verdict --- */

static void hardest_text(const struct advise *advise, bool si, char out[HARDEST_TEXT])
{
    char value[UNIT_TEXT], from[UNIT_TEXT];
    unit_value_text(UNIT_DECELERATION, si, advise->hardest_ft_s2, 1, value);
    unit_value_text(UNIT_DECELERATION, si, advise->short_ft_s2, 1, from);
    if (isfinite(advise->hardest_ft_s2))
        snprintf(out, HARDEST_TEXT, "%s to %s it stays below",
                 advise->beyond ? "at least up" : "up", value);
    else if (isfinite(advise->short_ft_s2))
        snprintf(out, HARDEST_TEXT,
                 "it stays below from %s on alone, where the gear stops before the closed mats",
                 from);
    else
        snprintf(out, HARDEST_TEXT, "no braking that stops on the runway stays below");
}

static void judge(struct advise *advise, bool si)
{
    const struct advise_row *row = &advise->row[advise->plan_row];
    const double limit = advise->request.limit;
    char braking[UNIT_TEXT], hardest[HARDEST_TEXT];
    const char *lacks = !advise->members.learned ? "no landing has taught it yet"
                      : advise->outside          ? "no landing before was like this"
                      : advise->past.surveyed < advise->past.segments / 2u
                          ? "the joints were not surveyed since the last landing"
                          : NULL;
    unit_value_text(UNIT_DECELERATION, si, row->mean_ft_s2, 1, braking);
    hardest_text(advise, si, hardest);
    bool off = row->off_runway > limit;
    advise->verdict = off || row->zone.low >= limit    ? ADVISE_AGAINST
                    : row->zone.high < limit && !lacks ? ADVISE_CLEAR
                                                       : ADVISE_CAUTION;
    if (off)
        snprintf(advise->reason, sizeof advise->reason,
                 "at %s, %.0f %% of the members roll off the runway's end", braking,
                 100.0 * row->off_runway);
    else if (row->zone.high < limit)
        snprintf(advise->reason, sizeof advise->reason,
                 "at %s a zone of %u mats has a probability of %.0f %%, below the limit of "
                 "%.0f %%%s%s",
                 braking, ADVISE_ZONE_MATS, 100.0 * row->zone.p, 100.0 * limit,
                 lacks ? ", but " : "", lacks ? lacks : "");
    else
        snprintf(advise->reason, sizeof advise->reason,
                 "at %s a zone of %u mats has a probability of %.0f %%, %s the limit of %.0f %%; "
                 "%s",
                 braking, ADVISE_ZONE_MATS, 100.0 * row->zone.p,
                 row->zone.low >= limit ? "beyond" : "which its members do not tell from",
                 100.0 * limit, hardest);
}

enum mr_status advise_find(struct store *store, const struct advise_request *request, bool si,
                           struct advise *advise, struct error *error)
{
    double began_s = monotonic_s(), began_ms = processor_ms();
    *advise = (struct advise){.request = *request, .tell_s = began_s + ADVISE_TELL_S};
    enum mr_status status = past_load(store, request->before, &advise->past, error);
    if (status == MR_OK && isfinite(request->friction))
        advise->past.runway.chain.friction_lb =
            (float)(request->friction * ADVISE_G_FT_S2 *
                    (double)advise->past.runway.chain.mass_slug);
    if (status == MR_OK && isfinite(request->share))
        advise->past.runway.share = request->share;
    if (status == MR_OK)
        status = make_plan(advise, error);
    if (status == MR_OK && advise_members_draw(&advise->members, &advise->past.runway,
                                               request->members, request->seed) != MR_OK)
        status = error_set(error, MR_USAGE,
                           "no runway: the parameters of the board's predictor make no sense; "
                           "look at them with matrig board config");
    if (status == MR_OK)
        status = learn(advise, error);
    if (status == MR_OK) {
        find_outside(advise);
        if (advise->outside)
            advise_widen(&advise->members, OUTSIDE_TIMES);
        status = find_rows(advise, error);
    }
    if (status == MR_OK)
        find_hardest(advise);
    if (status == MR_OK)
        judge(advise, si);
    advise->took_s = monotonic_s() - began_s;
    advise->processor_s = 1e-3 * (processor_ms() - began_ms);
    return status;
}

void advise_free(struct advise *advise)
{
    past_free(&advise->past);
    advise_members_free(&advise->members);
}

struct store_advice advise_row_kept(const struct advise *advise, int64_t made_us)
{
    const struct advise_row *row = &advise->row[advise->plan_row];
    struct store_advice kept = {
        .made_us = made_us,
        .speed_ft_s = advise->plan.speed_ft_s,
        .deceleration_ft_s2 = advise->plan.mean_ft_s2,
        .touchdown_ft = advise->plan.touchdown_ft,
        .zone = row->zone.p,
        .zone_low = row->zone.low,
        .zone_high = row->zone.high,
        .most = advise->request.limit,
        .hardest_ft_s2 = advise->hardest_ft_s2,
        .members = (int64_t)advise->members.count,
        .seed = (int64_t)advise->request.seed,
        .landings = advise->members.learned,
        .after_run = advise->past.newest_run,
    };
    snprintf(kept.verdict, sizeof kept.verdict, "%s", advise_verdict_text(advise->verdict));
    snprintf(kept.reason, sizeof kept.reason, "%s", advise->reason);
    return kept;
}
