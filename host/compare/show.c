#include "host/compare/show.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/units.h"
#include "host/base/xmalloc.h"

/* Adds a value of En or chi. */
static void add_ratio(struct answer *answer, const char *name, const char *label, double value)
{
    answer_add_value(answer, name, label, UNIT_NUMBER, value, 1)->is_capped = true;
}

static void add_moment(struct answer *answer, const char *name, const char *label,
                       const struct signal_moment *moment)
{
    answer_add_estimate(answer, name, label, UNIT_DISPLACEMENT, moment->value, moment->error, 4);
}

static void add_peak_time(struct answer *answer, bool is_measured, const struct signal_moment *peak)
{
    answer_add_value(answer, is_measured ? "peak_measured_at" : "peak_simulated_at",
                     is_measured ? "peak at|measured" : "peak at|simulated", UNIT_TIME, peak->t_s,
                     3);
}

static void add_channel(const struct compare_channel *c, struct answer *answer)
{
    const struct signal_figures *f = &c->figures;
    answer_open_row(answer);
    answer_add_count(answer, "number", "transducer", c->number);
    answer_add_flag(answer, "compared", NULL, c->is_compared);
    answer_add_value(answer, "station", "at", UNIT_STATION, c->station_ft, 1);
    answer_add_value(answer, "valid", "valid|share", UNIT_NUMBER, c->valid_share, 3);
    if (c->reason_or_remark[0])
        answer_add_text(answer, "why", NULL, "%s", c->reason_or_remark);
    if (c->is_compared) {
        answer_add_estimate(answer, "bias", "difference|bias", UNIT_DISPLACEMENT, f->bias,
                            f->bias_error, 4);
        answer_add_value(answer, "rms", "difference|rms", UNIT_DISPLACEMENT, f->rms, 4);
        add_ratio(answer, "chi", "chi", f->rms_per_error);
        add_ratio(answer, "bias_en", NULL, c->bias_en_score);
        add_moment(answer, "peak_measured", "peak|measured", &f->peak_measured);
        add_moment(answer, "peak_simulated", "peak|simulated", &f->peak_simulated);
        answer_add_value(answer, "peak_difference", NULL, UNIT_DISPLACEMENT,
                         f->peak_measured.value - f->peak_simulated.value, 4);
        add_ratio(answer, "peak_en", "peak|En", c->peak_en_score);
        add_peak_time(answer, true, &f->peak_measured);
        add_peak_time(answer, false, &f->peak_simulated);
        add_moment(answer, "end_measured", "end|measured", &c->end_measured);
        add_moment(answer, "end_simulated", "end|simulated", &c->end_simulated);
        answer_add_value(answer, "end_difference", NULL, UNIT_DISPLACEMENT,
                         c->end_measured.value - c->end_simulated.value, 4);
        add_ratio(answer, "end_en", "end|En", c->end_en_score);
        answer_add_estimate(answer, "arrival_measured", "arrival|measured", UNIT_TIME,
                            f->arrival_measured.t_s, f->arrival_measured.t_error_s, 4);
        answer_add_estimate(answer, "arrival_simulated", "arrival|simulated", UNIT_TIME,
                            f->arrival_simulated.t_s, f->arrival_simulated.t_error_s, 4);
        answer_add_value(answer, "arrival_difference", NULL, UNIT_TIME,
                         f->arrival_measured.t_s - f->arrival_simulated.t_s, 4);
        add_ratio(answer, "arrival_en", "arrival|En", c->arrival_en_score);
    }
}

void compare_add_channels(const struct compare_figures *figures, struct answer *answer)
{
    for (size_t i = 0; i < figures->channel_count; i++) {
        const struct compare_channel *c = &figures->channel[i];
        if (c->reason_or_remark[0])
            answer_add_sentence(answer, NULL, "transducer %lld: %s%s", (long long)c->number,
                                c->is_compared ? "" : "not compared: ", c->reason_or_remark);
    }
    answer_open_table(answer, "channels", "");
    for (size_t i = 0; i < figures->channel_count; i++)
        add_channel(&figures->channel[i], answer);
    answer_close_group(answer);
    answer_add_sentence(
        answer, NULL,
        "Differences are measured minus simulated. Errors are standard errors. chi: rms difference "
        "in standard errors. En: difference divided by two standard errors; up to 1 means "
        "agreement. Arrival: time at which the displacement reaches %.0f %% of the peak.",
        100.0 * SIGNAL_ARRIVAL_FRACTION);
}

static void add_zone(const char *name, const struct compare_zone *zone, struct answer *answer)
{
    bool any = zone->mats > 0.0;
    if (!zone->is_known) {
        answer_add_missing_value(answer, name, "from", "not known");
        return;
    }
    answer_open_group(answer, name, NULL);
    answer_add_value(answer, "mats", "mats", UNIT_NUMBER, zone->mats, 0);
    answer_add_estimate(answer, "start", "from", UNIT_STATION, any ? zone->start_ft : (double)NAN,
                        any ? zone->start_error_ft : (double)NAN, 1);
    answer_add_estimate(answer, "end", "to", UNIT_STATION, any ? zone->end_ft : (double)NAN,
                        any ? zone->end_error_ft : (double)NAN, 1);
    answer_close_group(answer);
}

static void add_overlap(const char *name, const struct compare_overlap *overlap,
                        struct answer *answer)
{
    if (!overlap->is_known) {
        answer_add_missing_value(answer, name, NULL, NULL);
        return;
    }
    answer_open_group(answer, name, NULL);
    answer_add_value(answer, "common_mats", "mats|in common", UNIT_NUMBER, overlap->common_mats, 0);
    answer_add_value(answer, "all_mats", "of all", UNIT_NUMBER, overlap->all_mats, 0);
    answer_add_value(answer, "share", NULL, UNIT_NUMBER, overlap->share, 3);
    answer_add_value(answer, "start_difference", "measured start|minus this one", UNIT_STATION,
                     overlap->start_difference_ft, 1)
        ->shows_sign = true;
    answer_add_value(answer, "end_difference", "measured end|minus this one", UNIT_STATION,
                     overlap->end_difference_ft, 1)
        ->shows_sign = true;
    answer_close_group(answer);
}

void compare_add_zones(const struct compare_zones *zones, struct answer *answer)
{
    static const char *const names[COMPARE_SOURCE_COUNT] = {[COMPARE_MEASURED] = "measured",
                                                            [COMPARE_BOARD] = "board",
                                                            [COMPARE_SIMULATED] = "simulated"};
    answer_open_list(answer, "zones", "");
    for (size_t i = 0; i < zones->count; i++) {
        const struct compare_zone_moment *m = &zones->moment[i];
        answer_open_group(answer, NULL, "");
        answer_add_text(answer, "when", "zone", "%s", m->description);
        answer_add_value(answer, "at", "time", UNIT_TIME, m->t_s, 3);
        answer_add_value(answer, "wheel", "wheel at", UNIT_STATION, m->wheel_ft, 1);
        answer_open_table(answer, NULL, "");
        for (size_t source = 0; source < COMPARE_SOURCE_COUNT; source++) {
            answer_open_row(answer);
            answer_add_text(answer, NULL, "source", "%s", names[source]);
            add_zone(names[source], &m->zone[source], answer);
            if (source == COMPARE_BOARD)
                add_overlap("overlap_board", &m->board_overlap, answer);
            else if (source == COMPARE_SIMULATED)
                add_overlap("overlap_simulated", &m->simulated_overlap, answer);
        }
        answer_close_group(answer);
        answer_close_group(answer);
    }
    answer_close_group(answer);
}

static void add_agreement(const struct compare_agreement *a, struct answer *answer)
{
    const enum unit_kind unit = a->is_time ? UNIT_TIME : UNIT_DISPLACEMENT;
    char sentence[COMPARE_AGREEMENT_SIZE];
    compare_write_agreement(a, answer_is_si(answer), sentence);
    answer_open_group(answer, "agreement", "");
    answer_add_sentence(answer, "sentence", "%s", sentence);
    answer_add_count(answer, "judged", NULL, (int64_t)a->judged_value_count);
    answer_add_count(answer, "differ", NULL, (int64_t)a->differing_value_count);
    if (a->channel) {
        answer_add_count(answer, "run", NULL, a->run);
        answer_add_text(answer, "value", NULL, "%s", a->value_name);
        answer_add_count(answer, "number", NULL, a->channel->number);
        answer_add_value(answer, "measured", NULL, unit, a->measured, 4);
        answer_add_value(answer, "simulated", NULL, unit, a->simulated, 4);
        answer_add_value(answer, "en", NULL, UNIT_NUMBER, a->en_score, 1);
    }
    answer_close_group(answer);
}

static void add_verdict(const struct compare_verdict *verdict, struct answer *answer)
{
    if (verdict->checked_limit_count == 0) {
        answer_add_missing_value(answer, "limits", NULL, NULL);
        return;
    }
    answer_open_group(answer, "limits", "limits");
    answer_add_count(answer, "checked", "checked", (int64_t)verdict->checked_limit_count);
    answer_add_count(answer, "failed", "failed", (int64_t)verdict->failed_limit_count);
    answer_add_flag(answer, "pass", NULL, verdict->failed_limit_count == 0);
    answer_add_text(answer, NULL, "verdict", "%s", verdict->failed_limit_count ? "FAIL" : "pass");
    if (verdict->failed_limit_count)
        answer_add_text(answer, "worst", NULL, "%s", verdict->worst_failure);
    answer_close_group(answer);
}

void compare_to_answer(const struct compare_figures *figures, const struct compare_verdict *verdict,
                       struct answer *answer)
{
    answer_add_count(answer, "run", "RUN", figures->run)->suffix = figures->marks;
    if (figures->missing_start_text[0])
        answer_add_sentence(answer, "torn", "%s", figures->missing_start_text);
    else
        answer_add_missing_value(answer, "torn", NULL, NULL);
    answer_add_text(answer, "scene", "against", "%s", figures->model_file);
    answer_add_value(answer, "run_ms", "simulated in", UNIT_NUMBER, figures->simulation_ms, 0)
        ->suffix = " ms";
    answer_add_value(answer, "error", "simulation error", UNIT_DISPLACEMENT,
                     figures->solver_error_in, 4)
        ->suffix = ", estimated by the solver";
    answer_add_count(answer, "seeds", NULL, figures->seed_count);
    if (figures->seed_count > 1)
        answer_add_text(answer, NULL, "runways",
                        "%lld simulated; simulated values are means over these runways, and the "
                        "errors include the spread",
                        (long long)figures->seed_count);
    answer_add_text(answer, NULL, "surveyed", "%zu of %u segments", figures->surveyed_segment_count,
                    MR_SEGMENTS);
    answer_add_count(answer, "surveyed", NULL, (int64_t)figures->surveyed_segment_count);
    size_t missing = 0;
    for (size_t i = 0; i < figures->channel_count; i++)
        missing += !figures->channel[i].is_compared;
    answer_add_count(answer, "missing_channels", NULL, (int64_t)missing);
    compare_add_channels(figures, answer);
    compare_add_zones(&figures->zones, answer);
    struct compare_agreement agreement;
    compare_compute_agreement(figures, &agreement);
    add_agreement(&agreement, answer);
    add_verdict(verdict, answer);
}

void compare_add_summary(const struct compare_figures *figures,
                         const struct compare_verdict *verdict, struct answer *answer)
{
    const struct compare_channel_means mean = compare_compute_means(figures);
    const struct compare_zone_moment *rest = compare_find_moment(&figures->zones, true);
    struct compare_agreement agreement;
    char sentence[COMPARE_AGREEMENT_SIZE];
    compare_compute_agreement(figures, &agreement);
    compare_write_agreement(&agreement, answer_is_si(answer), sentence);
    answer_add_sentence(answer, NULL, "%s", sentence);
    answer_add_count(answer, NULL, "RUN", figures->run)->suffix = figures->marks;
    if (figures->missing_start_text[0])
        answer_add_sentence(answer, NULL, "%s", figures->missing_start_text);
    answer_add_text(answer, NULL, "against", "%s", figures->model_file);
    answer_add_text(answer, NULL, "transducers", "%zu of %zu compared", mean.channel_count,
                    figures->channel_count);
    answer_add_value(answer, NULL, "bias", UNIT_DISPLACEMENT, mean.bias_in, 4)->suffix =
        ", measured minus simulated";
    answer_add_value(answer, NULL, "rms difference", UNIT_DISPLACEMENT, mean.rms_in, 4);
    answer_add_value(answer, NULL, "worst channel", UNIT_DISPLACEMENT, mean.worst_rms_in, 4);
    if (rest && rest->simulated_overlap.is_known)
        answer_add_text(answer, NULL, "zone at rest", "%.0f of %.0f mats in common",
                        rest->simulated_overlap.common_mats, rest->simulated_overlap.all_mats);
    else
        answer_add_text(answer, NULL, "zone at rest", "not known");
    answer_add_text(answer, NULL, "more", "give --all to list each transducer and zone");
    add_verdict(verdict, answer);
}

/* ---- a series ---- */

/* Adds one printed line for a landing of the series. */
static void add_landing(const struct compare_series_landing *landing, struct answer *answer)
{
    const struct compare_zone_moment *rest = compare_find_moment(&landing->figures.zones, true);
    const struct compare_channel_means mean = compare_compute_means(&landing->figures);
    answer_open_row(answer);
    answer_add_count(answer, NULL, "RUN", landing->run);
    if (!landing->is_compared)
        return;
    answer_add_text(answer, NULL, "channels", "%zu of %zu", mean.channel_count,
                    landing->figures.channel_count);
    answer_add_value(answer, NULL, "bias", UNIT_DISPLACEMENT, mean.bias_in, 4);
    answer_add_value(answer, NULL, "rms", UNIT_DISPLACEMENT, mean.rms_in, 4);
    add_ratio(answer, NULL, "worst|peak En", mean.worst_peak_en_score);
    answer_add_value(answer, NULL, "zone at rest|in common", UNIT_NUMBER,
                     rest ? rest->simulated_overlap.share : (double)NAN, 2);
    answer_add_text(answer, NULL, "limits", "%s",
                    landing->verdict.checked_limit_count == 0 ? "-"
                    : landing->verdict.failed_limit_count > 0 ? "FAIL"
                                                              : "pass");
}

static void add_landings(const struct compare_series *set, struct answer *answer)
{
    answer_open_list(answer, "landings", NULL);
    for (size_t i = 0; i < set->landing_count; i++) {
        const struct compare_series_landing *l = &set->landing[i];
        answer_open_row(answer);
        if (l->is_compared)
            compare_to_answer(&l->figures, &l->verdict, answer);
        else
            answer_add_count(answer, "run", NULL, l->run);
        if (!l->is_compared)
            answer_add_text(answer, "not_compared", NULL, "%s", l->reason);
    }
    answer_close_group(answer);
    for (size_t i = 0; i < set->landing_count; i++) {
        if (!set->landing[i].is_compared)
            answer_add_sentence(answer, NULL, "RUN %lld not compared: %s",
                                (long long)set->landing[i].run, set->landing[i].reason);
    }
    answer_open_table(answer, NULL, "landings");
    for (size_t i = 0; i < set->landing_count; i++)
        add_landing(&set->landing[i], answer);
    answer_close_group(answer);
}

static void add_channels(const struct compare_series *set, struct answer *answer)
{
    answer_open_table(answer, "channels", "over all landings, weighted by samples");
    for (size_t c = 0; c < MR_TRANSDUCERS; c++) {
        if (set->channel_means[c].compared_landings == 0)
            continue;
        answer_open_row(answer);
        answer_add_count(answer, "number", "no", set->channel_means[c].number);
        answer_add_value(answer, "station", "at", UNIT_STATION, set->channel_means[c].station_ft,
                         1);
        answer_add_count(answer, "landings", "landings",
                         (int64_t)set->channel_means[c].compared_landings);
        answer_add_value(answer, "bias", "bias", UNIT_DISPLACEMENT, set->channel_means[c].bias_in,
                         4);
        answer_add_value(answer, "rms", "rms", UNIT_DISPLACEMENT, set->channel_means[c].rms_in, 4);
    }
    answer_close_group(answer);
}

/* Adds the agreement of the landing that differs most. */
static void add_worst_agreement(const struct compare_series *set, struct answer *answer)
{
    struct compare_agreement worst = {.en_score = (double)NAN}, one;
    size_t differ = 0;
    for (size_t i = 0; i < set->landing_count; i++) {
        if (!set->landing[i].is_compared)
            continue;
        compare_compute_agreement(&set->landing[i].figures, &one);
        differ += one.differing_value_count > 0;
        if (!worst.model_file || (one.channel && !(one.en_score <= worst.en_score)))
            worst = one;
    }
    answer_add_count(answer, "landings_differ", "differ", (int64_t)differ);
    add_agreement(&worst, answer);
}

void compare_series_to_answer(const struct compare_series *set, struct answer *answer)
{
    answer_add_text(answer, "scene", "against", "%s", set->model_file);
    answer_add_text(answer, "series", set->name[0] ? "series" : NULL, "%s", set->name);
    answer_add_count(answer, NULL, "landings", (int64_t)set->landing_count);
    answer_add_count(answer, "compared", "compared", (int64_t)set->compared_count);
    answer_add_value(answer, "run_ms", "simulated in", UNIT_NUMBER, set->simulation_ms, 0)->suffix =
        " ms";
    answer_add_value(answer, "error", "simulation error", UNIT_DISPLACEMENT,
                     set->worst_solver_error_in, 4)
        ->suffix = " (largest), estimated by the solver";
    add_landings(set, answer);
    add_channels(set, answer);
    answer_add_value(answer, "bias", "all: bias", UNIT_DISPLACEMENT, set->pooled.bias_in, 4);
    answer_add_value(answer, "rms", "all: rms", UNIT_DISPLACEMENT, set->pooled.rms_in, 4);
    add_worst_agreement(set, answer);
    if (!isnan(set->pooled.within_limits_share)) {
        answer_add_value(answer, "within", NULL, UNIT_NUMBER, set->pooled.within_limits_share, 2);
        answer_add_text(answer, NULL, "within limits", "%.0f %% of the landings",
                        100.0 * set->pooled.within_limits_share);
    }
    add_verdict(&set->verdict, answer);
}

/* ---- limits ---- */

void compare_check(const struct compare_figures *figures, const struct compare_limits *limits,
                   struct compare_verdict *verdict)
{
    static const struct compare_verdict none;
    json_t *json[2];
    char where[40];
    for (int si = 0; si < 2; si++) {
        struct answer *answer = answer_new(si);
        compare_to_answer(figures, &none, answer);
        json[si] = answer_make_json_and_free(answer);
    }
    snprintf(where, sizeof where, "RUN %" PRId64, figures->run);
    compare_limits_check(limits, false, json[0], json[1], where, verdict);
    json_decref(json[0]);
    json_decref(json[1]);
}

/* Judges a series against limits. It fails if one of its landings or a limit of the series
 * fails. */
void compare_series_check(struct compare_series *set, const struct compare_limits *limits)
{
    json_t *json[2];
    size_t within = 0;
    for (size_t i = 0; i < set->landing_count && compare_has_limits(limits); i++) {
        struct compare_verdict *one = &set->landing[i].verdict;
        if (set->landing[i].is_compared) {
            compare_check(&set->landing[i].figures, limits, one);
        } else { /* a landing that was not compared fails its limits */
            *one = (struct compare_verdict){.checked_limit_count = 1,
                                            .failed_limit_count = 1,
                                            .worst_excess = (double)INFINITY};
            snprintf(one->worst_failure, sizeof one->worst_failure,
                     "RUN %" PRId64 " not compared: %.200s", set->landing[i].run,
                     set->landing[i].reason);
        }
        set->verdict.checked_limit_count += one->checked_limit_count;
        if (one->failed_limit_count > 0 && (set->verdict.failed_limit_count == 0 ||
                                            one->worst_excess > set->verdict.worst_excess)) {
            set->verdict.worst_excess = one->worst_excess;
            memcpy(set->verdict.worst_failure, one->worst_failure,
                   sizeof set->verdict.worst_failure);
        }
        set->verdict.failed_limit_count += one->failed_limit_count;
        within += one->failed_limit_count == 0;
    }
    if (compare_has_limits(limits))
        set->pooled.within_limits_share = (double)within / (double)set->landing_count;
    for (int si = 0; si < 2; si++) {
        struct answer *answer = answer_new(si);
        compare_series_to_answer(set, answer);
        json[si] = answer_make_json_and_free(answer);
    }
    compare_limits_check(limits, true, json[0], json[1], "the series", &set->verdict);
    json_decref(json[0]);
    json_decref(json[1]);
}

/* ---- files ---- */

/* Curves of the transducers with both measured and simulated samples. */
struct channel_curves {
    const struct store_simulation *row[MR_TRANSDUCERS];
    struct compare_curves curves[MR_TRANSDUCERS];
    size_t count;
};

static void channel_curves_make(const struct compare_landing *landing, struct channel_curves *sides)
{
    const struct measured_landing *measured = &landing->measured;
    sides->count = 0;
    for (size_t i = 0; i < landing->row_count; i++) {
        const struct store_simulation *row = &landing->row[i];
        int c = measured_channel_index(measured, MR_KIND_DISPLACEMENT, (unsigned)row->number);
        if (c < 0 || !measured->channel[c].raw || row->length == 0)
            continue;
        compare_fill_curves(measured, &landing->figures.timing, &measured->channel[c], row,
                            isnan(landing->head.error_in) ? row->peak_simulated_error_in
                                                          : landing->head.error_in,
                            &sides->curves[sides->count]);
        sides->row[sides->count++] = row;
    }
}

static void channel_curves_free(struct channel_curves *sides)
{
    for (size_t i = 0; i < sides->count; i++)
        free(sides->curves[i].storage);
}

void compare_write_csv(FILE *out, const struct compare_landing *landing, bool si)
{
    static const char *const names[] = {"measured", "measured_error", "simulated",
                                        "simulated_error", "alignment"};
    const struct unit *length = unit_get(UNIT_DISPLACEMENT, si);
    struct channel_curves sides;
    channel_curves_make(landing, &sides);
    fputs("t_s", out);
    for (size_t i = 0; i < sides.count; i++) {
        for (size_t k = 0; k < 5; k++)
            fprintf(out, ",d%" PRId64 "_%s_%s", sides.row[i]->number, names[k], length->suffix);
    }
    fputc('\n', out);
    for (size_t i = 0; i < landing->measured.samples; i++) {
        double t_s = measured_time_s(&landing->measured, i);
        if (t_s < 0.0)
            continue;
        fprintf(out, "%.7f", t_s);
        for (size_t c = 0; c < sides.count; c++) {
            const struct compare_curves *s = &sides.curves[c];
            const double *columns[] = {s->measured_in, s->measured_error_in, s->simulated_in,
                                       s->simulated_error_in, s->alignment_error_in};
            for (size_t k = 0; k < 5; k++) {
                if (isnan(columns[k][i]))
                    fputc(',', out);
                else
                    fprintf(out, ",%.8g", columns[k][i] * length->factor);
            }
        }
        fputc('\n', out);
    }
    channel_curves_free(&sides);
}
