#include "host/compare/series.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_journal.h"
#include "host/survey/campaign.h"

/* What simulations moved the gage points by, landing by landing. */
struct moves {
    bool known;
    double in[SURVEY_POINTS], spread_in[SURVEY_POINTS];
};

/* The runs of the series; the caller frees. */
static enum mr_status select_runs(struct store *store, const char *name, int64_t **runs,
                                  size_t *count, struct error *error)
{
    struct store_landing *rows = NULL;
    size_t all = 0;
    *count = 0;
    *runs = NULL;
    if (store_landings(store, &rows, &all, error) != MR_OK)
        return error->status;
    *runs = calloc(all + 1, sizeof **runs);
    if (!*runs)
        error_set(error, MR_FULL, "no memory: %zu landings; close other programs", all);
    for (size_t i = 0; i < all && error->status == MR_OK; i++) {
        struct store_series series = {0};
        bool is_void = false;
        if (store_is_void(store, rows[i].id, &is_void, NULL, error) == MR_OK && name)
            store_series_of(store, &rows[i], &series, error);
        if (!is_void && (!name || strcmp(series.name, name) == 0))
            (*runs)[(*count)++] = rows[i].id;
    }
    free(rows);
    if (error->status == MR_OK && *count == 0 && name)
        error_set(error, MR_UNKNOWN,
                  "no landings in series '%s': %s; leave --series out for all, or matrig series %s "
                  "NAME begins one",
                  name, store_path(store), store_path(store));
    else if (error->status == MR_OK && *count == 0)
        error_set(error, MR_TOO_FEW, "no landings to compare: %s; log one first",
                  store_path(store));
    return error->status;
}

static void pool(struct compare_series *set, const struct compare_figures *figures)
{
    set->run_ms += figures->run_ms;
    set->error_in = fmax(set->error_in, figures->error_in);
    for (size_t c = 0; c < figures->channels; c++) {
        const struct compare_channel *channel = &figures->channel[c];
        double n = (double)channel->f.compared;
        if (!channel->compared || channel->f.compared == 0)
            continue;
        set->channel[channel->number - 1].number = channel->number;
        set->channel[channel->number - 1].station_ft = channel->station_ft;
        set->channel[channel->number - 1].landings++;
        set->channel[channel->number - 1].samples += n;
        set->channel[channel->number - 1].bias_in += n * channel->f.bias;
        set->channel[channel->number - 1].rms_in += n * channel->f.rms * channel->f.rms;
    }
}

/* From sums to means. */
static void finish(struct compare_series *set)
{
    double samples = 0.0, sum = 0.0, squares = 0.0;
    size_t within = 0;
    for (size_t c = 0; c < MR_TRANSDUCERS; c++) {
        double n = set->channel[c].samples;
        samples += n;
        sum += set->channel[c].bias_in;
        squares += set->channel[c].rms_in;
        set->channel[c].bias_in /= n;
        set->channel[c].rms_in = sqrt(set->channel[c].rms_in / n);
    }
    for (size_t i = 0; i < set->count; i++)
        within += set->landing[i].compared && set->landing[i].verdict.failed == 0;
    set->pooled.bias_in = sum / samples;
    set->pooled.rms_in = sqrt(squares / samples);
    set->pooled.within = (double)within / (double)set->count;
}

/* ---- surveys ---- */

/* Mean over the lines of what has moved. */
static void take_measured(const struct survey_change *change, struct compare_moved *moved)
{
    for (size_t p = 0; p < SURVEY_POINTS; p++) {
        double sum = 0.0, variance = 0.0, n = 0.0;
        for (size_t line = 0; line < SURVEY_LINES; line++) {
            const struct survey_estimate *e = &change->moved[line][p];
            if (isnan(e->value_in))
                continue;
            sum += e->value_in;
            variance += e->error_in * e->error_in;
            n += 1.0;
        }
        moved->point[p].measured_in = n > 0.0 ? sum / n : (double)NAN;
        moved->point[p].error_in = n > 0.0 ? sqrt(variance) / n : (double)NAN;
    }
}

/* `all`: landings of the campaign between the surveys, void ones and those of other series too:
 * each has moved the mat. */
static void take_simulated(const struct compare_series *set, const struct moves *moves,
                           int64_t after, int64_t until, size_t all, struct compare_moved *moved)
{
    moved->simulated = true;
    for (size_t i = 0; i < set->count; i++) {
        if (set->landing[i].run <= after || set->landing[i].run > until)
            continue;
        moved->landings++;
        moved->simulated = moved->simulated && moves[i].known;
        for (size_t p = 0; p < SURVEY_POINTS; p++) {
            moved->point[p].simulated_in += moves[i].in[p];
            moved->point[p].spread_in = hypot(moved->point[p].spread_in, moves[i].spread_in[p]);
        }
    }
    moved->simulated = moved->simulated && moved->landings == all && all > 0;
    double sum = 0.0, squares = 0.0, chi = 0.0;
    for (size_t p = 0; p < SURVEY_POINTS && moved->simulated; p++) {
        double d = moved->point[p].measured_in - moved->point[p].simulated_in;
        double u = hypot(moved->point[p].error_in, hypot(moved->point[p].spread_in, set->error_in));
        if (isnan(d))
            continue;
        sum += d;
        squares += d * d;
        chi += d * d / (u * u);
        moved->points++;
    }
    double n = (double)moved->points;
    moved->bias_in = moved->points ? sum / n : (double)NAN;
    moved->rms_in = moved->points ? sqrt(squares / n) : (double)NAN;
    moved->chi = moved->points ? sqrt(chi / n) : (double)NAN;
}

static size_t landings_between(const struct store_landing *rows, size_t count, int64_t after,
                               int64_t until)
{
    size_t found = 0;
    for (size_t i = 0; i < count; i++)
        found += rows[i].id > after && rows[i].id <= until;
    return found;
}

static enum mr_status compare_surveys(struct store *store, const struct moves *moves,
                                      struct compare_series *set, struct error *error)
{
    struct store_gage_survey *rows = NULL;
    struct survey *survey = NULL;
    struct survey_found found;
    struct store_landing *landings = NULL;
    size_t count = 0, points = 0, landing_count = 0;
    double squares = 0.0;
    if (store_gage_surveys(store, &rows, &count, error) != MR_OK ||
        store_landings(store, &landings, &landing_count, error) != MR_OK) {
        free(rows);
        return error->status;
    }
    set->moved = calloc(count + 1, sizeof *set->moved);
    survey = malloc(sizeof *survey);
    if (!set->moved || !survey)
        error_set(error, MR_FULL, "no memory: %zu surveys; close other programs", count);
    for (size_t i = 1; i < count && error->status == MR_OK; i++) {
        if (survey_get(store, rows[i].id, survey, error) != MR_OK ||
            survey_find(store, survey, &found, error) != MR_OK)
            break;
        size_t before = i;
        while (before > 0 && rows[before - 1].id != found.previous)
            before--;
        if (before == 0 || rows[i].after_run == STORE_NONE)
            continue;
        const struct store_gage_survey *previous = &rows[before - 1];
        struct compare_moved *moved = &set->moved[set->moves];
        moved->from_survey = previous->id;
        moved->to_survey = rows[i].id;
        take_measured(&found.since_previous, moved);
        int64_t after = previous->after_run == STORE_NONE ? 0 : previous->after_run,
                until = rows[i].after_run;
        take_simulated(set, moves, after, until,
                       landings_between(landings, landing_count, after, until), moved);
        if (moved->landings == 0) /* none of this series between them */
            memset(moved, 0, sizeof *moved);
        else
            set->moves++;
        if (moved->points > 0) {
            squares += (double)moved->points * moved->rms_in * moved->rms_in;
            points += moved->points;
        }
    }
    set->pooled.moved_in = points ? sqrt(squares / (double)points) : (double)NAN;
    free(landings);
    free(rows);
    free(survey);
    return error->status;
}

/* ---- the series ---- */

static enum mr_status run_landing(struct store *store, struct compare_model *model,
                                  const struct compare_limits *limits, bool si,
                                  struct compare_series *set, size_t index, struct moves *moves,
                                  struct error *error)
{
    struct compare_landing landing;
    struct compare_series_landing *out = &set->landing[index];
    struct error why = {0};
    enum mr_status status = compare_landing(store, out->run, model, index, &landing, &why);
    if (status == MR_OK) {
        out->compared = true;
        set->compared++;
        out->figures = landing.figures;
        compare_limits_check(limits, &out->figures, si, &out->verdict);
        pool(set, &out->figures);
        moves->known = true;
        memcpy(moves->in, landing.moved_in, sizeof moves->in);
        memcpy(moves->spread_in, landing.moved_spread_in, sizeof moves->spread_in);
    } else if (status == MR_TOO_FEW || status == MR_TRUNCATED || status == MR_NUMERICS) {
        snprintf(out->why, sizeof out->why, "%s", why.text);
    } else {
        error_set(error, status, "%s", why.text);
    }
    compare_landing_free(&landing);
    return error->status;
}

/* The verdict of the whole: the worst of the landings' and the series' own limits. */
static void judge(struct compare_series *set, const struct compare_limits *limits, bool si)
{
    for (size_t i = 0; i < set->count; i++) {
        struct compare_verdict *one = &set->landing[i].verdict;
        if (!set->landing[i].compared && compare_limits_any(limits)) {
            /* nobody knows whether it is within them */
            *one = (struct compare_verdict){.checked = 1, .failed = 1, .worst = (double)INFINITY};
            snprintf(one->text, sizeof one->text, "RUN %lld not compared: %.200s",
                     (long long)set->landing[i].run, set->landing[i].why);
        }
        set->verdict.checked += one->checked;
        if (one->failed > 0 && (set->verdict.failed == 0 || one->worst > set->verdict.worst)) {
            set->verdict.worst = one->worst;
            memcpy(set->verdict.text, one->text, sizeof set->verdict.text);
        }
        set->verdict.failed += one->failed;
    }
    compare_limits_check_series(limits, &set->pooled, si, &set->verdict);
}

enum mr_status compare_series_run(struct store *store, const char *name,
                                  struct compare_model *model, const struct compare_limits *limits,
                                  bool si, void (*progress)(void *ctx, size_t done, size_t of),
                                  void *ctx, struct compare_series *set, struct error *error)
{
    int64_t *runs = NULL;
    struct moves *moves = NULL;
    memset(set, 0, sizeof *set);
    snprintf(set->against, sizeof set->against, "%s", model->name);
    snprintf(set->name, sizeof set->name, "%s", name ? name : "");
    if (select_runs(store, name, &runs, &set->count, error) == MR_OK) {
        set->landing = calloc(set->count, sizeof *set->landing);
        moves = calloc(set->count, sizeof *moves);
        if (!set->landing || !moves)
            error_set(error, MR_FULL, "no memory: %zu landings; close other programs", set->count);
    }
    for (size_t i = 0; i < set->count && error->status == MR_OK; i++) {
        set->landing[i].run = runs[i];
        run_landing(store, model, limits, si, set, i, &moves[i], error);
        if (progress)
            progress(ctx, i + 1, set->count);
    }
    if (error->status == MR_OK && set->compared == 0)
        error_set(error, MR_TOO_FEW, "no landing could be compared: %s: %s", store_path(store),
                  set->landing[0].why);
    if (error->status == MR_OK) {
        finish(set);
        if (compare_surveys(store, moves, set, error) == MR_OK)
            judge(set, limits, si);
    }
    free(runs);
    free(moves);
    return error->status;
}

void compare_series_free(struct compare_series *set)
{
    free(set->landing);
    free(set->moved);
    memset(set, 0, sizeof *set);
}

void compare_series_sentence(const struct compare_series *set, bool si, char out[COMPARE_SENTENCE])
{
    const struct compare_figures **figures = calloc(set->count + 1,
                                                    sizeof(const struct compare_figures *));
    size_t count = 0;
    for (size_t i = 0; i < set->count && figures; i++) {
        if (set->landing[i].compared)
            figures[count++] = &set->landing[i].figures;
    }
    compare_sentence_of(figures, count, si, out);
    free(figures);
}
