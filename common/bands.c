#include "common/bands.h"

#include <string.h>

#include "common/wire.h"

/* a change is sudden if it is larger by this factor than the changes before and after it */
#define SUDDEN_RATIO_MIN     3.0f
/* fraction of a sudden change that must remain after the hold time */
#define PERSISTING_SHARE_MIN 0.5f
#define SIGNIFICANCE_SIGMA   3.0f /* smallest significant change, in standard errors */
#define UNKNOWN_STATION_FT   1e6f

float mr_bands_tension_error_lb(const struct mr_channel_config *gage, float tension_lb)
{
    float gain_lb = gage->gain_error * tension_lb;
    return __builtin_sqrtf(gage->zero_error * gage->zero_error + gain_lb * gain_lb +
                           gage->linearity_error * gage->linearity_error);
}

/* ---- arming ---- */

static float get_gage_station_ft(const struct mr_bands *bands, unsigned gage)
{
    float station_ft = bands->channel[gage].station_ft;
    return __builtin_isnan(station_ft) ? UNKNOWN_STATION_FT : station_ft;
}

static void collect_gages_by_station(const struct mr_bands *bands, struct mr_band *band,
                                     unsigned number)
{
    for (unsigned g = 0; g < MR_GAGES; g++) {
        if (bands->channel[g].kind != MR_KIND_TENSION || bands->channel[g].band != number)
            continue;
        unsigned place = band->gage_count++;
        for (; place &&
               get_gage_station_ft(bands, band->gage[place - 1]) > get_gage_station_ft(bands, g);
             place--)
            band->gage[place] = band->gage[place - 1];
        band->gage[place] = (uint8_t)g;
    }
}

/* Computes the weight of each gage: the fraction of the band between the midpoints to its
 * neighbours. */
static void compute_gage_weights(const struct mr_bands *bands, struct mr_band *band)
{
    float sum = 0.0f;
    for (unsigned i = 0; i < band->gage_count; i++) {
        unsigned before = i ? i - 1 : i, after = i + 1 < band->gage_count ? i + 1 : i;
        float length_ft = get_gage_station_ft(bands, band->gage[after]) -
                          get_gage_station_ft(bands, band->gage[before]);
        if (after - before == 1) /* a gage at an end of the band has only one neighbour */
            length_ft *= 2.0f;
        band->weight[i] = length_ft > 0.0f && length_ft < UNKNOWN_STATION_FT / 2.0f ? length_ft
                                                                                    : 1.0f;
        sum += band->weight[i];
    }
    for (unsigned i = 0; i < band->gage_count; i++)
        band->weight[i] /= sum;
}

static void set_tension_limits(struct mr_band *band, float pretension_lb)
{
    float step_lb = MR_BANDS_SUDDEN_MIN_SHARE * pretension_lb;
    band->sudden_change_min_lb = step_lb > MR_BANDS_SUDDEN_MIN_LB ? step_lb
                                                                  : MR_BANDS_SUDDEN_MIN_LB;
    band->slack_limit_lb = MR_BANDS_SLACK_MAX_SHARE * pretension_lb;
}

static void reset_group_sums(struct mr_bands *bands)
{
    bands->group_step_count = 0;
    bands->is_group_quiet = true;
    for (unsigned g = 0; g < MR_GAGES; g++)
        bands->sum_lb[g] = bands->square_sum_lb2[g] = 0.0f;
}

void mr_bands_arm(struct mr_bands *bands, const struct mr_channel_config *gages,
                  const struct mr_band_config band[MR_CONFIG_BANDS])
{
    memset(bands, 0, sizeof *bands);
    bands->channel = gages;
    for (unsigned b = 0; b < MR_CONFIG_BANDS; b++) {
        struct mr_band *each = &bands->band[b];
        if (band[b].pretension_lb > 0.0f)
            collect_gages_by_station(bands, each, b + 1);
        compute_gage_weights(bands, each);
        set_tension_limits(each, band[b].pretension_lb);
        each->yield_lb = band[b].yield_lb;
        each->min_tension.tension_lb = each->max_tension.tension_lb = MR_NAN;
        bands->is_active |= each->gage_count > 0;
    }
    for (unsigned g = 0; g < MR_GAGES; g++)
        bands->group_mean_lb[g] = bands->before_lb[g] = bands->group_noise_lb[g] =
            bands->before_noise_lb[g] = MR_NAN;
    reset_group_sums(bands);
}

/* ---- findings ---- */

static void add_finding(struct mr_bands *bands, unsigned band, unsigned gage, unsigned other,
                        enum mr_band_reason reason, float value_lb, uint32_t block)
{
    if (bands->finding_count < MR_BANDS_FINDINGS_MAX)
        bands->finding[bands->finding_count++] =
            (struct mr_band_finding){.band = (uint8_t)(band + 1),
                                     .gage = (uint8_t)gage,
                                     .other_gage = (uint8_t)other,
                                     .reason = (uint8_t)reason,
                                     .value_lb = value_lb,
                                     .block = block};
}

/* Returns the mean tension of a band over its valid gages, weighted by length. */
static float compute_weighted_mean_lb(const struct mr_band *band, const float *lb_by_place)
{
    float sum = 0.0f, weights = 0.0f;
    for (unsigned i = 0; i < band->gage_count; i++) {
        if (__builtin_isnan(lb_by_place[i]))
            continue;
        sum += band->weight[i] * lb_by_place[i];
        weights += band->weight[i];
    }
    return weights > 0.0f ? sum / weights : MR_NAN;
}

/* Returns the tension at a gage `age` steps ago; 0: the newest. */
static float get_past_tension_lb(const struct mr_bands *bands, unsigned gage, unsigned age)
{
    return bands->history[(bands->newest_row + MR_BANDS_HISTORY_STEPS - age) %
                          MR_BANDS_HISTORY_STEPS][gage];
}

/* Finds two neighbouring gages that changed in opposite directions so that their difference
 * decreased, as after a rivet has pulled out. Returns the position of the first in the band;
 * band->gages: none. */
static unsigned find_rivet_pullout(const struct mr_bands *bands, const struct mr_band *band,
                                   const float *step_lb)
{
    unsigned found = band->gage_count;
    float most_lb = 0.0f;
    for (unsigned i = 0; i + 1 < band->gage_count; i++) {
        float a = step_lb[i], b = step_lb[i + 1];
        float large = __builtin_fabsf(a) > __builtin_fabsf(b) ? __builtin_fabsf(a)
                                                              : __builtin_fabsf(b);
        float small = __builtin_fabsf(a) + __builtin_fabsf(b) - large;
        if (!(a * b < 0.0f) || !(large >= band->sudden_change_min_lb) ||
            small < MR_BANDS_SUDDEN_IGNORED_SHARE * large)
            continue;
        float before_lb = get_past_tension_lb(bands, band->gage[i + 1], 4) -
                          get_past_tension_lb(bands, band->gage[i], 4);
        float after_lb = get_past_tension_lb(bands, band->gage[i + 1], 2) -
                         get_past_tension_lb(bands, band->gage[i], 2);
        if (__builtin_fabsf(after_lb) < __builtin_fabsf(before_lb) && large + small > most_lb) {
            most_lb = large + small;
            found = i;
        }
    }
    return found;
}

/* Returns the neighbour of a gage with the larger change; band->gages if the gage is at an end of
 * the band. */
static unsigned find_gage_with_larger_step(const struct mr_band *band, const float *step_lb,
                                           unsigned place)
{
    if (place == 0 || place + 1 == band->gage_count)
        return band->gage_count;
    return __builtin_fabsf(step_lb[place - 1]) > __builtin_fabsf(step_lb[place + 1]) ? place - 1
                                                                                     : place + 1;
}

/* Records a possible failure if find_rivet_pullout found none: a pullout (the load has moved) if
 * any gage rose, a step if only one gage dropped, a slip if several dropped and none rose.
 * `trend_lb`: the change of each gage in two steps without the event. */
static void record_candidate(const struct mr_bands *bands, struct mr_band *band,
                             const float *step_lb, const float *trend_lb, uint32_t block)
{
    unsigned worst = 0, drops = 0, rises = 0;
    float from_lb[MR_GAGES];
    for (unsigned i = 1; i < band->gage_count; i++) {
        if (__builtin_fabsf(step_lb[i]) > __builtin_fabsf(step_lb[worst]) ||
            __builtin_isnan(step_lb[worst]))
            worst = i;
    }
    float least_lb = MR_BANDS_SUDDEN_IGNORED_SHARE * __builtin_fabsf(step_lb[worst]);
    for (unsigned i = 0; i < band->gage_count; i++) {
        drops += step_lb[i] <= -least_lb;
        rises += step_lb[i] >= least_lb;
        from_lb[i] = get_past_tension_lb(bands, band->gage[i], 4) +
                     trend_lb[i] * (0.5f * (float)(MR_BANDS_PERSIST_STEPS + 4u));
    }
    struct mr_band_candidate *doubt = &band->candidate;
    *doubt = (struct mr_band_candidate){.position = (uint8_t)worst,
                                        .change_lb = step_lb[worst],
                                        .block = block,
                                        .min_lb = PERSISTING_SHARE_MIN * step_lb[worst],
                                        .before_lb = from_lb[worst]};
    if (rises) {
        doubt->reason = MR_BAND_PULLOUT;
    } else if (drops == 1) {
        doubt->reason = MR_BAND_STEP;
    } else {
        unsigned other = find_gage_with_larger_step(band, step_lb, worst);
        doubt->reason = MR_BAND_SLIP;
        doubt->other_gage = (uint8_t)(other < band->gage_count ? band->gage[other] + 1 : 0);
        doubt->min_lb = PERSISTING_SHARE_MIN * compute_weighted_mean_lb(band, step_lb);
        doubt->before_lb = compute_weighted_mean_lb(band, from_lb);
    }
}

/* Reports a sudden change if it still exists after the hold time. */
static void confirm_candidate(struct mr_bands *bands, unsigned number)
{
    struct mr_band *band = &bands->band[number];
    const struct mr_band_candidate doubt = band->candidate;
    float now_lb[MR_GAGES];
    band->candidate.reason = 0;
    for (unsigned i = 0; i < band->gage_count; i++)
        now_lb[i] = get_past_tension_lb(bands, band->gage[i], 0);
    float left_lb = (doubt.reason == MR_BAND_SLIP ? compute_weighted_mean_lb(band, now_lb)
                                                  : now_lb[doubt.position]) -
                    doubt.before_lb;
    if (!(doubt.min_lb < 0.0f ? left_lb <= doubt.min_lb : left_lb >= doubt.min_lb))
        return;
    band->is_baseline_frozen = true;
    add_finding(bands, number, band->gage[doubt.position] + 1u, doubt.other_gage,
                (enum mr_band_reason)doubt.reason,
                doubt.reason == MR_BAND_SLIP ? -doubt.change_lb : doubt.change_lb, doubt.block);
}

/* Called when a gage changed suddenly two to four steps ago: classifies the change from all gages
 * of the band. */
static void classify_step(struct mr_bands *bands, unsigned number, uint32_t block)
{
    struct mr_band *band = &bands->band[number];
    float step_lb[MR_GAGES], trend_lb[MR_GAGES];
    for (unsigned i = 0; i < band->gage_count; i++) {
        unsigned g = band->gage[i];
        if (get_past_tension_lb(bands, g, 6) < band->slack_limit_lb ||
            get_past_tension_lb(bands, g, 0) < band->slack_limit_lb)
            /* Report appendix C.5 applies only while the whole band is under tension: a slack band
             * also changes suddenly when it becomes tight. */
            return;
        trend_lb[i] = 0.5f * (get_past_tension_lb(bands, g, 4) - get_past_tension_lb(bands, g, 6) +
                              get_past_tension_lb(bands, g, 0) - get_past_tension_lb(bands, g, 2));
        step_lb[i] = get_past_tension_lb(bands, g, 2) - get_past_tension_lb(bands, g, 4) -
                     trend_lb[i];
    }
    band->persist_steps = MR_BANDS_PERSIST_STEPS;
    block -= MR_BANDS_STEP_BLOCKS * 3u;
    unsigned i = find_rivet_pullout(bands, band, step_lb);
    if (i == band->gage_count) {
        record_candidate(bands, band, step_lb, trend_lb, block);
        return;
    }
    band->is_baseline_frozen = true;
    add_finding(bands, number, band->gage[i] + 1u, band->gage[i + 1] + 1u, MR_BAND_PULLOUT,
                __builtin_fabsf(step_lb[i]) + __builtin_fabsf(step_lb[i + 1]), block);
}

static bool is_sudden_change(const struct mr_bands *bands, const struct mr_band *band,
                             unsigned gage)
{
    float at2 = get_past_tension_lb(bands, gage, 2), at4 = get_past_tension_lb(bands, gage, 4);
    float step_lb = __builtin_fabsf(at2 - at4);
    if (!(step_lb >= band->sudden_change_min_lb) ||
        __builtin_fabsf(get_past_tension_lb(bands, gage, 1) - get_past_tension_lb(bands, gage, 3)) >
            step_lb)
        /* There is no step; or the step is within one of the averaged intervals, and the next
         * difference contains more of it. */
        return false;
    float before_lb = __builtin_fabsf(at4 - get_past_tension_lb(bands, gage, 6)),
          after_lb = __builtin_fabsf(get_past_tension_lb(bands, gage, 0) - at2);
    return step_lb >= SUDDEN_RATIO_MIN * before_lb && step_lb >= SUDDEN_RATIO_MIN * after_lb;
}

static void check_for_slack(struct mr_bands *bands, unsigned number, unsigned gage, float lb,
                            float wheel_ft, uint32_t block)
{
    const struct mr_band *band = &bands->band[number];
    if (!(lb < band->slack_limit_lb)) {
        bands->slack_step_count[gage] = 0;
        return;
    }
    if (bands->slack_step_count[gage] < MR_BANDS_SLACK_STEPS)
        bands->slack_step_count[gage]++;
    if (bands->slack_step_count[gage] < MR_BANDS_SLACK_STEPS ||
        bands->slack_reported_gages >> gage & 1u)
        return;
    bands->slack_reported_gages |= 1u << gage;
    bool ahead = bands->channel[gage].station_ft > wheel_ft;
    add_finding(bands, number, gage + 1, 0, ahead ? MR_BAND_SLACK : MR_BAND_LOOSE, lb, block);
}

static void update_tension_extremes(struct mr_band *band, unsigned gage, float lb, uint32_t block)
{
    struct mr_band_extreme here = {.tension_lb = lb, .gage = (uint8_t)(gage + 1), .block = block};
    /* negated, so that it is also true for the first reading, when the extremes are NaN */
    if (!(lb >= band->min_tension.tension_lb))
        band->min_tension = here;
    if (!(lb <= band->max_tension.tension_lb))
        band->max_tension = here;
}

static void update_band(struct mr_bands *bands, unsigned number, const float *tension_lb,
                        bool quiet, float wheel_ft, uint32_t block)
{
    struct mr_band *band = &bands->band[number];
    bool sudden = false;
    if (quiet) /* movement before the landing does not count */
        band->min_tension = band->max_tension = (struct mr_band_extreme){.tension_lb = MR_NAN};
    for (unsigned i = 0; i < band->gage_count; i++) {
        unsigned g = band->gage[i];
        float lb = tension_lb[g];
        float change_lb = lb - get_past_tension_lb(bands, g, 1);
        bands->sum_lb[g] += lb;
        bands->square_sum_lb2[g] += bands->group_step_count ? change_lb * change_lb : 0.0f;
        if (__builtin_isnan(lb)) {
            bands->slack_step_count[g] = 0;
            continue;
        }
        if (!quiet)
            update_tension_extremes(band, g, lb, block);
        check_for_slack(bands, number, g, lb, wheel_ft, block);
        if (band->yield_lb > 0.0f && lb >= band->yield_lb &&
            !(bands->overload_reported_gages >> g & 1u)) {
            bands->overload_reported_gages |= 1u << g;
            add_finding(bands, number, g + 1, 0, MR_BAND_OVERLOAD, lb, block);
        }
        sudden |= bands->filled_rows == MR_BANDS_HISTORY_STEPS && is_sudden_change(bands, band, g);
    }
    if (!band->persist_steps) {
        if (sudden)
            classify_step(bands, number, block);
    } else if (--band->persist_steps == 0 && band->candidate.reason) {
        confirm_candidate(bands, number);
    }
}

/* ---- spread at rest before and after a group of steps ---- */

static void check_for_unequal_tension(struct mr_bands *bands, unsigned number, uint32_t block)
{
    struct mr_band *band = &bands->band[number];
    unsigned low = MR_GAGES, high = MR_GAGES, valid = 0;
    float sum_lb = 0.0f;
    for (unsigned i = 0; i < band->gage_count; i++) {
        unsigned g = band->gage[i];
        float lb = bands->before_lb[g];
        if (__builtin_isnan(lb))
            continue;
        sum_lb += lb;
        valid++;
        low = low == MR_GAGES || lb < bands->before_lb[low] ? g : low;
        high = high == MR_GAGES || lb > bands->before_lb[high] ? g : high;
    }
    if (!valid)
        return;
    float mean_lb = sum_lb / (float)valid;
    set_tension_limits(band, mean_lb > 0.0f ? mean_lb : 0.0f);
    float spread_lb = bands->before_lb[high] - bands->before_lb[low];
    float low_error = mr_bands_tension_error_lb(&bands->channel[low], bands->before_lb[low]);
    float high_error = mr_bands_tension_error_lb(&bands->channel[high], bands->before_lb[high]);
    float error_lb = __builtin_sqrtf(low_error * low_error + high_error * high_error);
    if (spread_lb > MR_BANDS_SPREAD_MAX_SHARE * mean_lb + SIGNIFICANCE_SIGMA * error_lb &&
        !band->is_unequal_reported) {
        band->is_unequal_reported = true;
        add_finding(bands, number, low + 1, high + 1, MR_BAND_UNEQUAL, spread_lb, block);
    }
}

static void finish_group(struct mr_bands *bands, uint32_t block)
{
    for (unsigned g = 0; g < MR_GAGES; g++) {
        bands->group_mean_lb[g] = bands->sum_lb[g] / (float)MR_BANDS_GROUP_STEPS;
        bands->group_noise_lb[g] =
            __builtin_sqrtf(bands->square_sum_lb2[g] / (float)(2u * (MR_BANDS_GROUP_STEPS - 1u)));
    }
    for (unsigned b = 0; b < MR_CONFIG_BANDS; b++) {
        struct mr_band *band = &bands->band[b];
        if (!bands->is_group_quiet || band->is_baseline_frozen)
            continue;
        for (unsigned i = 0; i < band->gage_count; i++) {
            bands->before_lb[band->gage[i]] = bands->group_mean_lb[band->gage[i]];
            bands->before_noise_lb[band->gage[i]] = bands->group_noise_lb[band->gage[i]];
        }
        check_for_unequal_tension(bands, b, block);
    }
    reset_group_sums(bands);
}

unsigned mr_bands_update(struct mr_bands *bands, const float tension_lb[MR_GAGES], bool quiet,
                         float wheel_ft, uint32_t block)
{
    bands->finding_count = 0;
    if (!bands->is_active)
        return 0;
    bands->newest_row = (bands->newest_row + 1u) % MR_BANDS_HISTORY_STEPS;
    memcpy(bands->history[bands->newest_row], tension_lb, sizeof bands->history[0]);
    if (bands->filled_rows < MR_BANDS_HISTORY_STEPS)
        bands->filled_rows++;
    for (unsigned b = 0; b < MR_CONFIG_BANDS; b++) {
        if (bands->band[b].gage_count)
            update_band(bands, b, tension_lb, quiet, wheel_ft, block);
    }
    bands->is_group_quiet &= quiet;
    if (++bands->group_step_count == MR_BANDS_GROUP_STEPS)
        finish_group(bands, block);
    return bands->finding_count;
}

/* ---- the end ---- */

void mr_bands_end(struct mr_bands *bands)
{
    bands->is_active = false;
}

static float compute_extreme_error_lb(const struct mr_bands *bands,
                                      const struct mr_band_extreme *extreme)
{
    if (!extreme->gage)
        return MR_NAN;
    unsigned g = extreme->gage - 1u;
    float error_lb = mr_bands_tension_error_lb(&bands->channel[g], extreme->tension_lb),
          noise_lb = bands->before_noise_lb[g];
    return __builtin_sqrtf(error_lb * error_lb + noise_lb * noise_lb);
}

void mr_bands_get_summary(const struct mr_bands *bands, unsigned number,
                          struct mr_band_summary *figures)
{
    const struct mr_band *band = &bands->band[number];
    float before_variance = 0.0f, change_variance = 0.0f, low_lb = MR_NAN, high_lb = MR_NAN;
    *figures = (struct mr_band_summary){.min = band->min_tension, .max = band->max_tension};
    for (unsigned i = 0; i < band->gage_count; i++) {
        unsigned g = band->gage[i];
        const struct mr_channel_config *gage = &bands->channel[g];
        float before_lb = bands->before_lb[g], change_lb = bands->group_mean_lb[g] - before_lb;
        if (__builtin_isnan(change_lb))
            continue;
        float noise = bands->before_noise_lb[g] * bands->before_noise_lb[g] /
                      (float)MR_BANDS_GROUP_STEPS;
        float error_lb = mr_bands_tension_error_lb(gage, before_lb),
              gain_lb = gage->gain_error * change_lb;
        figures->gage_count++;
        figures->before_lb += before_lb;
        figures->change_lb += change_lb;
        before_variance += error_lb * error_lb + noise;
        change_variance += gain_lb * gain_lb + 2.0f * noise;
        low_lb = before_lb >= low_lb ? low_lb : before_lb;
        high_lb = before_lb <= high_lb ? high_lb : before_lb;
    }
    float count = figures->gage_count ? (float)figures->gage_count : MR_NAN;
    figures->before_lb /= count;
    figures->change_lb /= count;
    figures->after_lb = figures->before_lb + figures->change_lb;
    figures->before_error_lb = __builtin_sqrtf(before_variance) / count;
    figures->change_error_lb = __builtin_sqrtf(change_variance) / count;
    figures->spread_lb = high_lb - low_lb;
    figures->min_error_lb = compute_extreme_error_lb(bands, &band->min_tension);
    figures->max_error_lb = compute_extreme_error_lb(bands, &band->max_tension);
}

unsigned mr_bands_find_extremes(const struct mr_channel_config *gages,
                                const float tension_lb[MR_GAGES], unsigned band, float *min_lb,
                                float *mean_lb, float *max_lb)
{
    unsigned count = 0;
    float sum_lb = 0.0f;
    *min_lb = *max_lb = MR_NAN;
    for (unsigned g = 0; g < MR_GAGES; g++) {
        float lb = tension_lb[g];
        if (gages[g].kind != MR_KIND_TENSION || gages[g].band != band + 1 || __builtin_isnan(lb))
            continue;
        count++;
        sum_lb += lb;
        *min_lb = lb >= *min_lb ? *min_lb : lb;
        *max_lb = lb <= *max_lb ? *max_lb : lb;
    }
    *mean_lb = count ? sum_lb / (float)count : MR_NAN;
    return count;
}
