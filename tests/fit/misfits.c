/* Whether the fit notices that its model cannot be the data's: campaigns of tests/fit/runway.h,
 * right ones and four kinds of wrong ones, each fitted and checked (host/study/fit/landings.h).
 * Prints how many of each are called impossible, with Wilson's 95 % intervals, and how often the
 * intervals hold.
 *
 *   misfits FOLDER [FIRST [RIGHT [WRONG [MATS]]]]
 *
 * Seeds from FIRST on (1001), RIGHT right campaigns (60), WRONG of each kind (20), on a runway of
 * so many mats (210). Seeds 1 to 40 are set aside for choosing figures. A fitted campaign is kept
 * in FOLDER: what takes the time does not depend on the figures. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/statistics.h"
#include "host/study/fit/landings.h"
#include "tests/fit/runway.h"

#define VERSION  3u
#define DRAWS    64u
#define REPLICAS 99u
#define BLOCKS   5u /* the kinds in turn: an interrupted run has some of each */

struct head {
    uint32_t version, statistics, rows, parameters;
    double z[FIT_PARAMETERS_MAX], low[FIT_PARAMETERS_MAX], high[FIT_PARAMETERS_MAX];
};

static bool fit(const struct fit_landings *list, uint64_t seed, struct fit_result *answer)
{
    struct fit_model model = fit_landings_model(list);
    struct fit_options options = {.draw_count = DRAWS, .replica_count = REPLICAS, .seed = seed};
    struct error error = {0};
    if (fit_run(&model, list->measured, &options, answer, &error) == MR_OK)
        return true;
    fprintf(stderr, "misfits: seed %llu: %s\n", (unsigned long long)seed, error.text);
    return false;
}

static bool load(const char *path, const struct fit_landings *list, struct fit_result *answer)
{
    struct head head;
    FILE *file = fopen(path, "rb");
    bool good = file && fread(&head, sizeof head, 1, file) == 1 && head.version == VERSION &&
                head.statistics == list->statistics && head.rows > 0 && head.rows < 10000;
    size_t count = good ? (size_t)head.rows * head.statistics : 0;
    answer->residual = calloc(count + 1, sizeof(double));
    good = good && answer->residual &&
           fread(answer->residual, sizeof(double), count, file) == count;
    if (good) {
        answer->statistic_count = head.statistics;
        answer->parameter_count = head.parameters;
        answer->replica_count = head.rows - 1;
        memcpy(answer->z, head.z, sizeof head.z);
        memcpy(answer->low, head.low, sizeof head.low);
        memcpy(answer->high, head.high, sizeof head.high);
    }
    if (file)
        fclose(file);
    if (!good)
        fit_free(answer);
    return good;
}

/* One that was not checked, for want of replicas, has the measured row alone, of zeros. */
static bool save(const char *path, struct fit_result *answer)
{
    if (!answer->residual) {
        answer->replica_count = 0;
        answer->residual = calloc(answer->statistic_count, sizeof(double));
    }
    if (!answer->residual)
        return false;
    struct head head = {.version = VERSION,
                        .statistics = (uint32_t)answer->statistic_count,
                        .rows = (uint32_t)answer->replica_count + 1,
                        .parameters = (uint32_t)answer->parameter_count};
    char made[600];
    memcpy(head.z, answer->z, sizeof head.z);
    memcpy(head.low, answer->low, sizeof head.low);
    memcpy(head.high, answer->high, sizeof head.high);
    snprintf(made, sizeof made, "%s.new", path);
    size_t count = (size_t)head.rows * head.statistics;
    FILE *file = fopen(made, "wb");
    bool good = file && fwrite(&head, sizeof head, 1, file) == 1 &&
                fwrite(answer->residual, sizeof(double), count, file) == count;
    good = file && fclose(file) == 0 && good && rename(made, path) == 0;
    if (!good)
        fprintf(stderr, "misfits: %s cannot be written; is the disk full?\n", path);
    return good;
}

struct tally {
    unsigned cases, unchecked, cannot;
    unsigned held[FIT_KEYS], flagged_held, flagged, unflagged_held, unflagged;
};

static void count(const struct fit_landings *list, const struct fit_result *answer, const double *z,
                  const struct misfit *misfit, struct tally *tally)
{
    enum fit_key key[FIT_KEYS];
    size_t fitted = fit_landings_list_keys(list, key);
    tally->cases++;
    tally->unchecked += !misfit->is_checked;
    tally->cannot += misfit->is_rejected;
    for (size_t i = 0; i < fitted; i++) {
        bool held = answer->low[i] <= z[key[i]] && z[key[i]] <= answer->high[i];
        tally->held[key[i]] += held;
        *(misfit->is_rejected ? &tally->flagged : &tally->unflagged) += 1;
        *(misfit->is_rejected ? &tally->flagged_held : &tally->unflagged_held) += held;
    }
}

static bool play(const char *folder, enum runway_kind kind, int mats, uint64_t seed,
                 struct tally *tally)
{
    const struct runway_wanted wanted = {.kind = kind, .surveyed = true, .mats = mats};
    struct fit_landings list;
    struct fit_result answer = {0};
    struct misfit misfit = {0};
    struct error error = {0};
    double z[FIT_KEYS];
    char path[560];
    snprintf(path, sizeof path, "%s/%s-%d-%llu.bin", folder, runway_names[kind], mats,
             (unsigned long long)seed);
    bool good = runway_campaign(&wanted, seed, z, &list, &error);
    good = good &&
           (load(path, &list, &answer) || (fit(&list, seed, &answer) && save(path, &answer)));
    if (good) {
        misfit = misfit_check(&list, &answer, seed);
        count(&list, &answer, z, &misfit, tally);
    }
    if (good && getenv("MISFITS_ROWS"))
        printf("%-7s %4llu %d %.2f\n", runway_names[kind], (unsigned long long)seed,
               misfit.is_rejected, misfit.p_value);
    fit_free(&answer);
    fit_landings_free(&list);
    return good;
}

static double percent(unsigned part, unsigned of)
{
    return of > 0 ? 100.0 * part / of : (double)NAN;
}

static void print(enum runway_kind kind, const struct tally *tally)
{
    struct proportion_interval proportion_interval = compute_proportion_interval(tally->cannot,
                                                                                 tally->cases);
    printf("%-8s %4u %6u %6.1f %%  %5.1f to %5.1f %%  ", runway_names[kind], tally->cases,
           tally->cannot, percent(tally->cannot, tally->cases), 100.0 * proportion_interval.low,
           100.0 * proportion_interval.high);
    for (int k = 0; k < FIT_STIFFNESS; k++)
        printf(" %5.0f", percent(tally->held[k], tally->cases));
    printf("  %5.1f of %u, %5.1f of %u  ", percent(tally->flagged_held, tally->flagged),
           tally->flagged, percent(tally->unflagged_held, tally->unflagged), tally->unflagged);
    if (tally->unchecked > 0)
        printf(" (not checked: %u)", tally->unchecked);
    printf("\n");
}

int main(int argc, char **argv)
{
    uint64_t first = argc > 2 ? strtoull(argv[2], NULL, 10) : 1001;
    unsigned right = argc > 3 ? (unsigned)strtoul(argv[3], NULL, 10) : 60,
             wrong = argc > 4 ? (unsigned)strtoul(argv[4], NULL, 10) : 20;
    int mats = argc > 5 ? (int)strtol(argv[5], NULL, 10) : RUNWAY_MATS;
    static struct tally tally[RUNWAY_KINDS];
    if (argc < 2) {
        fprintf(stderr, "misfits FOLDER [FIRST [RIGHT [WRONG [MATS]]]]\n");
        return 2;
    }
    for (unsigned b = 0; b < BLOCKS; b++) {
        for (int k = 0; k < RUNWAY_KINDS; k++) {
            unsigned of = k == RUNWAY_MODEL ? right : wrong;
            for (unsigned n = of * b / BLOCKS; n < of * (b + 1) / BLOCKS; n++) {
                if (!play(argv[1], (enum runway_kind)k, mats, first + n, &tally[k]))
                    fprintf(stderr, "misfits: %s %llu is left out\n", runway_names[k],
                            (unsigned long long)(first + n));
            }
        }
    }
    printf("%d mats, two landings, surveys before and after; seeds from %llu; %u draws, %u "
           "replicas\n"
           "kind    cases cannot be the data's (95 %%); intervals hold, %%: gap grit f share; of "
           "all where called impossible, where not\n",
           mats, (unsigned long long)first, DRAWS, REPLICAS);
    for (int k = 0; k < RUNWAY_KINDS; k++)
        print((enum runway_kind)k, &tally[k]);
    return 0;
}
