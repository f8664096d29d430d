/* The advice for people and programs. */
#include <math.h>
#include <stdio.h>

#include "host/advise/advise.h"

/* "12 % (8 to 17)"; the numbers for programs. */
static void chance_answer(struct answer *answer, const char *name, const char *label,
                          const struct advise_chance *chance)
{
    char low[40], high[40];
    snprintf(low, sizeof low, "%s_low", name);
    snprintf(high, sizeof high, "%s_high", name);
    if (isfinite(chance->p))
        answer_words(answer, NULL, label, "%.0f %% (%.0f to %.0f)", 100.0 * chance->p,
                     100.0 * chance->low, 100.0 * chance->high);
    else
        answer_words(answer, NULL, label, "-");
    answer_value(answer, name, NULL, UNIT_NUMBER, chance->p, 3);
    answer_value(answer, low, NULL, UNIT_NUMBER, chance->low, 3);
    answer_value(answer, high, NULL, UNIT_NUMBER, chance->high, 3);
}

static void row_answer(const struct advise *advise, const struct advise_row *row,
                       struct answer *answer)
{
    bool si = answer_in_si(answer);
    const struct unit *station = unit_of(UNIT_STATION, si);
    double length_ft = (double)advise->past.runway.chain.mat_length_ft *
                       advise->past.runway.chain.mats;
    answer_row(answer);
    bool plan = row == &advise->row[advise->plan_row];
    answer_words(answer, NULL, "row", "%s", plan ? "plan" : "");
    answer_value(answer, "deceleration", "braking", UNIT_DECELERATION, row->mean_ft_s2, 1);
    answer_flag(answer, "plan", NULL, plan);
    chance_answer(answer, "zone", "zone, 95 %", &row->zone);
    answer_list(answer, "by_station", NULL);
    for (unsigned s = 0; s < ADVISE_STATIONS; s++) {
        answer_row(answer);
        answer_value(answer, "station", NULL, UNIT_STATION, length_ft * (s + 1u) / ADVISE_STATIONS,
                     1);
        answer_value(answer, "zone", NULL, UNIT_NUMBER, row->by_station[s].p, 3);
        answer_value(answer, "zone_low", NULL, UNIT_NUMBER, row->by_station[s].low, 3);
        answer_value(answer, "zone_high", NULL, UNIT_NUMBER, row->by_station[s].high, 3);
    }
    answer_close(answer);
    for (unsigned s = 1; s + 1u < ADVISE_STATIONS; s++) {
        char label[40];
        snprintf(label, sizeof label, "by|%.0f %s",
                 station->factor * length_ft * (s + 1u) / ADVISE_STATIONS, station->text);
        answer_words(answer, NULL, label, "%.0f %%", 100.0 * row->by_station[s].p);
    }
    answer_value(answer, "half_station", "half|by", UNIT_STATION, row->half_ft, 0);
    answer_words(answer, NULL, "rolls|off", "%.0f %%", 100.0 * row->off_runway);
    answer_value(answer, "off_runway", NULL, UNIT_NUMBER, row->off_runway, 3);
}

static void plan_answer(const struct advise *advise, struct answer *answer)
{
    const struct advise_plan *plan = &advise->plan;
    answer_open(answer, "plan", "Plan");
    answer_value(answer, "speed", "speed", UNIT_SPEED, plan->speed_ft_s, 1);
    answer_value(answer, "touchdown", "touchdown", UNIT_STATION, plan->touchdown_ft, 1);
    answer_value(answer, "deceleration", "braking", UNIT_DECELERATION, plan->mean_ft_s2, 2);
    if (advise->planned)
        answer_words(answer, NULL, "met",
                     "within %.0f %% rms, %+.0f %% on the mean, by %u landings with a kept plan",
                     100.0 * plan->spread, 100.0 * (exp(plan->bias) - 1.0), advise->planned);
    else
        answer_words(answer, NULL, "met", "within %.0f %% rms, %s", 100.0 * plan->spread,
                     isfinite(advise->request.spread)
                         ? "as given"
                         : "as assumed: no landing has a kept plan (--keep)");
    answer_value(answer, "spread", NULL, UNIT_NUMBER, plan->spread, 3);
    answer_value(answer, "bias", NULL, UNIT_NUMBER, plan->bias, 3);
    answer_count(answer, "plans_kept", NULL, advise->planned);
    answer_value(answer, "least", "stops at the end", UNIT_DECELERATION, advise->least_ft_s2, 2);
    answer_flag(answer, "as_before", NULL, advise->as_before);
    answer_close(answer);
}

static void known_answer(const struct advise *advise, struct answer *answer)
{
    static const struct {
        const char *name, *label;
        enum advise_unknown unknown;
        enum unit_kind unit;
        int decimals;
    } rows[] = {{"share", "thrust on the strip, of W/axles", ADVISE_SHARE, UNIT_NUMBER, 2},
                {"friction", "friction of a mat", ADVISE_FRICTION, UNIT_TENSION, 3},
                {"resistance", "resistance of a joint", ADVISE_RESISTANCE, UNIT_TENSION, 1},
                {"stiffness", "stiffness of a joint", ADVISE_STIFFNESS, UNIT_STIFFNESS, 0}};
    answer_open(answer, "learned", "What the landings taught");
    answer_count(answer, "landings", "landings", advise->members.learned);
    answer_count(answer, "not_learned", NULL, (int64_t)advise->unlearned);
    answer_count(answer, "voided", NULL, (int64_t)advise->past.voided);
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        double mean, spread;
        advise_unknown(&advise->members, rows[i].unknown, &mean, &spread);
        answer_estimate(answer, rows[i].name, rows[i].label, rows[i].unit, mean, mean * spread,
                        rows[i].decimals);
    }
    answer_close(answer);
}

/* What makes it wider, each in a line. */
static void notes_answer(const struct advise *advise, struct answer *answer)
{
    const struct past *past = &advise->past;
    if (!advise->members.learned)
        answer_words(answer, NULL, "note", "no landing has taught it: wide as drawn");
    if (advise->unlearned)
        answer_words(answer, NULL, "note",
                     "%zu landings without a measured stop were not learned "
                     "from; what they did to the joints is not known",
                     advise->unlearned);
    if (past->voided)
        answer_words(answer, NULL, "note", "%zu voided landings are left out", past->voided);
    if (past->surveyed < past->segments)
        answer_words(answer, NULL, "note",
                     "%u of %u segments were surveyed since the last landing; the others are as "
                     "the members have them",
                     past->surveyed, past->segments);
    if (past->relaid)
        answer_words(answer, NULL, "note",
                     "a series was begun since: the openings are taken as laid anew");
    if (advise->outside)
        answer_words(answer, NULL, "note",
                     "the plan lies outside of the landings before: what they taught is widened "
                     "by half");
    if (advise->as_before)
        answer_words(answer, NULL, "note",
                     "speed or deceleration not given: those of the last landing");
}

static void worth_answer(const struct advise *advise, struct answer *answer)
{
    unsigned best = 0;
    answer_table(answer, "narrows",
                 "What would narrow it: share of the variance that goes when a "
                 "group of inputs is known");
    for (unsigned g = 0; g < ADVISE_GROUPS; g++) {
        answer_row(answer);
        answer_words(answer, "group", "inputs", "%s", advise_group_text((enum advise_group)g));
        answer_words(answer, NULL, "variance", "%.0f %%", 100.0 * advise->worth[g]);
        answer_value(answer, "share", NULL, UNIT_NUMBER, advise->worth[g], 3);
        answer_words(answer, "measure", "how", "%s", advise_group_measure((enum advise_group)g));
        best = advise->worth[g] > advise->worth[best] ? g : best;
    }
    answer_close(answer);
    if (advise->worth[best] > 0.02)
        answer_words(answer, "most", "most", "%s", advise_group_measure((enum advise_group)best));
    else
        answer_none(answer, "most", "most", "no single group narrows it");
}

/* A bow wave rises above a threshold of the thrust (docs/explanation/bow-waves.md). */
static void thrust_answer(const struct advise *advise, struct answer *answer)
{
    const struct advise_runway *runway = &advise->past.runway;
    double share, spread,
        critical_lb = (double)runway->chain.mass_slug * ADVISE_G_FT_S2 *
                      (double)runway->chain.mat_length_ft / (2.0 * runway->bump_ft);
    advise_unknown(&advise->members, ADVISE_SHARE, &share, &spread);
    if (runway->bump_ft > 0.0) {
        answer_value(answer, "thrust", "planned thrust", UNIT_TENSION,
                     share * runway->thrust_lb_per_g * advise->plan.mean_ft_s2 / ADVISE_G_FT_S2, 1);
        answer_value(answer, "critical", "critical thrust", UNIT_TENSION, critical_lb, 1);
        answer_remark(answer, ", for the assumed irregularity; bow waves rise above about 1.2 "
                              "times this");
    } else {
        answer_none(answer, "critical", "critical thrust",
                    "unknown: the board has no irregularity (predict.bump_in)");
    }
}

void advise_answer(const struct advise *advise, struct answer *answer)
{
    double members_per_s = advise->took_s > 0.0 ? (double)advise->members.computed / advise->took_s
                                                : (double)NAN;
    answer_words(answer, "verdict", NULL, "%s", advise_verdict_text(advise->verdict));
    answer_words(answer, "reason", NULL, "%s", advise->reason);
    answer_sentence(answer, NULL, "%s: %s.", advise_verdict_text(advise->verdict), advise->reason);
    plan_answer(advise, answer);
    answer_table(answer, "rows",
                 "Probability that the wheel comes to a zone of 50 mats, against mean deceleration "
                 "and station of the wheel (in brackets: 95 % of the members' number alone)");
    for (size_t i = 0; i < advise->rows; i++)
        row_answer(advise, &advise->row[i], answer);
    answer_close(answer);
    answer_value(answer, "limit", NULL, UNIT_NUMBER, advise->request.limit, 3);
    answer_value(answer, "hardest", "hardest", UNIT_DECELERATION, advise->hardest_ft_s2, 1);
    answer_remark(answer,
                  isnan(advise->hardest_ft_s2) ? "; nothing that stops on the runway, and gentler "
                                                 "than that, stays below %.0f %%"
                  : advise->beyond             ? ", the last row, and still below %.0f %%"
                                               : " stays below %.0f %%",
                  100.0 * advise->request.limit);
    answer_flag(answer, "hardest_beyond", NULL, advise->beyond);
    notes_answer(advise, answer);
    answer_value(answer, "short", isfinite(advise->short_ft_s2) ? "stops short" : NULL,
                 UNIT_DECELERATION, advise->short_ft_s2, 1);
    if (isfinite(advise->short_ft_s2))
        answer_remark(answer, " and harder stops before the mats that are closed");
    answer_flag(answer, "outside", NULL, advise->outside);
    answer_count(answer, "segments_surveyed", NULL, advise->past.surveyed);
    known_answer(advise, answer);
    worth_answer(advise, answer);
    thrust_answer(advise, answer);
    answer_count(answer, "members", "members", (int64_t)advise->members.count);
    answer_remark(answer, "; seed %llu; %.1f s, %.0f members' landings a second on %u processors",
                  (unsigned long long)advise->request.seed, advise->took_s, members_per_s,
                  advise->members.threads);
    answer_count(answer, "seed", NULL, (int64_t)advise->request.seed);
    answer_open(answer, "time", NULL);
    answer_value(answer, "s", NULL, UNIT_NUMBER, advise->took_s, 3);
    answer_value(answer, "processor_s", NULL, UNIT_NUMBER, advise->processor_s, 3);
    answer_value(answer, "members_per_s", NULL, UNIT_NUMBER, members_per_s, 0);
    answer_count(answer, "threads", NULL, advise->members.threads);
    answer_close(answer);
}
