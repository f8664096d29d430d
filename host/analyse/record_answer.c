/* The sums of a campaign's record in words and numbers. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/analyse/record.h"
#include "host/base/statistics.h"

const char *record_verdict_text(enum record_verdict verdict)
{
    static const char *const text[RECORD_VERDICTS] = {
        [RECORD_NOT_KNOWN] = "not known",
        [RECORD_HIT] = "hit",
        [RECORD_LATE] = "warned, but too late",
        [RECORD_MISS] = "missed",
        [RECORD_FALSE] = "false",
        [RECORD_SILENCE] = "rightly quiet",
    };
    return text[verdict];
}

static const char *const advised[RECORD_ADVICES] = {"clear", "caution", "against"};

/* "3 of 4", with Wilson's interval. For programs NAME, NAME_of, NAME_low, NAME_high. */
static void share_answer(struct answer *answer, const char *name, const char *label, size_t count,
                         size_t of, const char *what)
{
    char key[60];
    struct wilson share = wilson_of(count, of);
    answer_count(answer, name, NULL, (int64_t)count);
    snprintf(key, sizeof key, "%s_of", name);
    answer_count(answer, key, NULL, (int64_t)of);
    snprintf(key, sizeof key, "%s_low", name);
    answer_value(answer, key, NULL, UNIT_NUMBER, of ? share.low : (double)NAN, 3);
    snprintf(key, sizeof key, "%s_high", name);
    answer_value(answer, key, NULL, UNIT_NUMBER, of ? share.high : (double)NAN, 3);
    if (of)
        answer_words(answer, NULL, label, "%zu of %zu %s: with 95 %% between %.0f and %.0f %%",
                     count, of, what, 100.0 * share.low, 100.0 * share.high);
    else
        answer_words(answer, NULL, label, "no %s", what);
}

static size_t came(const struct record *record)
{
    return record->verdict[RECORD_HIT] + record->verdict[RECORD_LATE] +
           record->verdict[RECORD_MISS];
}

static void unknown_answer(const struct record *record, struct answer *answer)
{
    size_t unknown = record->verdict[RECORD_NOT_KNOWN];
    answer_count(answer, "unknown", NULL, (int64_t)unknown);
    answer_count(answer, "unknown_warned", NULL, (int64_t)record->unknown_warned);
    answer_count(answer, "unwatched", NULL, (int64_t)record->unwatched);
    answer_words(answer, NULL, "not known",
                 "%zu landing%s, %zu of them warned of: counted as neither right nor wrong",
                 unknown, unknown == 1 ? "" : "s", record->unknown_warned);
}

static void lead_answer(const struct record *record, struct answer *answer)
{
    answer_value(answer, "lead_median", NULL, UNIT_TIME, record->lead_median_s, 3);
    answer_value(answer, "lead_least", NULL, UNIT_TIME, record->lead_least_s, 3);
    answer_count(answer, "leads", NULL, (int64_t)record->leads);
    if (record->leads)
        answer_words(answer, NULL, "lead time",
                     "median %.2f s, least %.2f s, to when the wheel came to 50 closed mats; of "
                     "%zu",
                     record->lead_median_s, record->lead_least_s, record->leads);
}

static void warnings_answer(const struct record *record, struct answer *answer)
{
    size_t hit = record->verdict[RECORD_HIT], wrong = record->verdict[RECORD_FALSE],
           late = record->verdict[RECORD_LATE];
    answer_open(answer, "warnings", "warnings");
    share_answer(answer, "warned", "warned of", hit + late, came(record),
                 "landings in which the wheel came to a zone");
    share_answer(answer, "hits", "in time", hit, came(record), "of them, before it came there");
    answer_count(answer, "late", "too late", (int64_t)late);
    answer_count(answer, "misses", "missed", (int64_t)record->verdict[RECORD_MISS]);
    share_answer(answer, "false", "false", wrong, wrong + hit + late,
                 "warnings of which that is known");
    answer_count(answer, "silences", "rightly quiet", (int64_t)record->verdict[RECORD_SILENCE]);
    lead_answer(record, answer);
    unknown_answer(record, answer);
    answer_close(answer);
}

static void score_answer(const struct record_score *score, const char *name, const char *label,
                         struct answer *answer)
{
    answer_open(answer, name, "");
    answer_count(answer, "known", NULL, (int64_t)score->count);
    answer_value(answer, "brier", NULL, UNIT_NUMBER, score->brier, 4);
    answer_value(answer, "climatology", NULL, UNIT_NUMBER, score->climatology, 4);
    if (score->count >= RECORD_SCORED)
        answer_words(answer, NULL, label,
                     "Brier score %.3f of %zu; always saying the share that came would have %.3f",
                     score->brier, score->count, score->climatology);
    else
        answer_words(answer, NULL, label,
                     "no score: %zu known landings, and fewer than %d tell nothing", score->count,
                     RECORD_SCORED);
    answer_close(answer);
}

static void one_advice_answer(const struct record *record, enum record_advised verdict,
                              struct answer *answer)
{
    static const char *const label[RECORD_ADVICES] = {"said clear", "said caution", "said against"};
    const size_t *by = record->advice[verdict];
    char what[80];
    answer_open(answer, advised[verdict], "");
    snprintf(what, sizeof what, "known landings came to a zone, %zu not known",
             by[OUTCOME_UNKNOWN]);
    share_answer(answer, "came", label[verdict], by[OUTCOME_CAME],
                 by[OUTCOME_CAME] + by[OUTCOME_DID_NOT],
                 by[OUTCOME_CAME] + by[OUTCOME_DID_NOT] ? what : "landing of which it is known");
    answer_count(answer, "unknown", NULL, (int64_t)by[OUTCOME_UNKNOWN]);
    answer_close(answer);
}

static void advice_answer(const struct record *record, struct answer *answer)
{
    answer_open(answer, "advice", "advice before landings");
    answer_count(answer, "given", "kept before a landing", (int64_t)record->advices);
    for (int i = RECORD_ADVICES - 1; i >= 0; i--)
        one_advice_answer(record, (enum record_advised)i, answer);
    answer_count(answer, "off_plan", "landed otherwise than planned", (int64_t)record->off_plan);
    answer_count(answer, "to_come", NULL, (int64_t)record->to_come);
    answer_count(answer, "replaced", "replaced by a later one", (int64_t)record->replaced);
    answer_count(answer, "voided", "before a landing that is void", (int64_t)record->advice_voided);
    score_answer(&record->said, "probability", "its probabilities", answer);
    answer_close(answer);
}

static void basis_answer(const struct record *record, struct answer *answer)
{
    char text[200] = "";
    for (int i = 1; i < OUTCOME_BASES; i++) {
        size_t used = strlen(text);
        if (record->basis[i])
            snprintf(text + used, sizeof text - used, "%s%s in %zu", used ? ", " : "",
                     outcome_basis_text((enum outcome_basis)i), record->basis[i]);
    }
    answer_count(answer, "by_seen", NULL, (int64_t)record->basis[OUTCOME_SEEN]);
    answer_count(answer, "by_transducers", NULL, (int64_t)record->basis[OUTCOME_TRANSDUCERS]);
    answer_count(answer, "by_survey_after", NULL, (int64_t)record->basis[OUTCOME_SURVEY_AFTER]);
    answer_words(answer, NULL, "what came rests on", "%s",
                 text[0] ? text : "nothing: none is known");
}

static void line_answer(const struct record *record, struct answer *answer)
{
    size_t hit = record->verdict[RECORD_HIT], late = record->verdict[RECORD_LATE],
           wrong = record->verdict[RECORD_FALSE];
    char before[60] = "";
    if (record->advices)
        snprintf(before, sizeof before, "; advice before %zu", record->advices);
    answer_sentence(answer, NULL,
                    "warned of %zu of %zu landings that came to a zone (%zu in time), %zu of %zu "
                    "warnings false, %zu rightly quiet, %zu not known%s (matrig report has each)",
                    hit + late, came(record), hit, wrong, wrong + hit + late,
                    record->verdict[RECORD_SILENCE], record->verdict[RECORD_NOT_KNOWN], before);
}

void record_answer(const struct record *record, bool brief, struct answer *answer)
{
    answer_open(answer, "record", brief ? NULL : "");
    answer_count(answer, "counted", brief ? NULL : "landings", (int64_t)record->landings);
    answer_count(answer, "voided", brief ? NULL : "void, not counted", (int64_t)record->voided);
    basis_answer(record, answer);
    warnings_answer(record, answer);
    score_answer(&record->risk, "risk", "risk told 1 s after touchdown", answer);
    advice_answer(record, answer);
    answer_close(answer);
    if (brief)
        line_answer(record, answer);
}
