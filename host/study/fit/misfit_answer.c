/* A misfit in words, and as facts. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "host/base/cli.h"
#include "host/study/fit/print.h"

/* How a figure is told: as it is, or as what it is the logarithm of. */
static double shown(enum misfit_figure figure, double value)
{
    switch (figure) {
    case MISFIT_NEIGHBOURS:
    case MISFIT_SUMS_ALONG:
    case MISFIT_CLOSED:
    case MISFIT_LAID_ALONG:
    case MISFIT_ODD_BEYOND:
    case MISFIT_ODD_BEFORE:
    case MISFIT_ODD_TAIL:
    case MISFIT_ODD_THRUST: return value;
    default: return exp(value);
    }
}

static void place(const struct fit_landings *list, size_t statistic, char *text, size_t size)
{
    text[0] = '\0';
    for (size_t l = 0; l < list->count && statistic != SIZE_MAX; l++) {
        const struct fit_landing *landing = &list->landing[l];
        if (statistic >= landing->first + landing->windows)
            continue;
        const struct fit_window *window = &landing->window[statistic - landing->first];
        if (window->channel == SIZE_MAX)
            snprintf(text, size, ", most at segment %zu after RUN %lld", window->segment + 1,
                     (long long)landing->run);
        else
            snprintf(text, size, ", most at transducer %lld at %g ft, %s, RUN %lld",
                     (long long)landing->channel[window->channel].number,
                     landing->channel[window->channel].station_ft, window->name,
                     (long long)landing->run);
        return;
    }
}

void misfit_sentence(const struct fit_landings *list, const struct misfit *misfit, char *text,
                     size_t size)
{
    const struct misfit_found *found = &misfit->found[misfit->worst];
    const struct misfit_word *word = &misfit_words[misfit->worst];
    char where[120];
    place(list, found->where, where, sizeof where);
    if (!misfit->checked)
        snprintf(text, size,
                 "whether the model can be the data's was not checked: %zu replicas of the data, "
                 "%u are needed; allow more time",
                 misfit->replicas, MISFIT_LEAST);
    else if (misfit->cannot)
        snprintf(text, size,
                 "the model cannot be the data's: %s%s: %.3g, where the model gives %.3g to %.3g "
                 "(95 %%; %+.1f standard deviations). What may be behind it: %s. The intervals are "
                 "not to be trusted. (%.0f %% of data sets that the model gives are so far out; "
                 "this is said falsely of %.0f %%)",
                 word->words, where, shown(misfit->worst, found->measured),
                 shown(misfit->worst, found->low), shown(misfit->worst, found->high), found->away,
                 word->reason, 100.0 * misfit->share, 100.0 * MISFIT_FALSE);
    else
        snprintf(text, size,
                 "the model can be the data's: farthest out is the %s, by %+.1f standard "
                 "deviations, and %.0f %% of data sets that the model gives are as far out in "
                 "something; 5 %% or fewer would say that it cannot",
                 word->words, found->away, 100.0 * misfit->share);
}

void misfit_describe(struct answer *answer, const struct fit_landings *list,
                     const struct misfit *misfit)
{
    char text[900];
    misfit_sentence(list, misfit, text, sizeof text);
    answer_sentence(answer, NULL, "%s", text);
    answer_open(answer, "misfit", NULL);
    answer_flag(answer, "checked", NULL, misfit->checked);
    answer_flag(answer, "cannot_be", NULL, misfit->cannot);
    answer_words(answer, "says", NULL, "%s", text);
    answer_value(answer, "false_alarms", NULL, UNIT_NUMBER, MISFIT_FALSE, 2);
    answer_value(answer, "share_so_far_out", NULL, UNIT_NUMBER,
                 misfit->checked ? misfit->share : (double)NAN, 2);
    answer_count(answer, "replicas", NULL, (int64_t)misfit->replicas);
    answer_words(answer, "worst", NULL, "%s",
                 misfit->checked ? misfit_words[misfit->worst].key : "");
    answer_list(answer, "figures", NULL);
    for (enum misfit_figure f = 0; f < MISFITS && misfit->checked; f++) {
        const struct misfit_found *found = &misfit->found[f];
        if (!found->known)
            continue;
        answer_row(answer);
        answer_words(answer, "name", NULL, "%s", misfit_words[f].key);
        answer_value(answer, "measured", NULL, UNIT_NUMBER, shown(f, found->measured), 3);
        answer_value(answer, "expected", NULL, UNIT_NUMBER, shown(f, found->middle), 3);
        answer_value(answer, "low", NULL, UNIT_NUMBER, shown(f, found->low), 3);
        answer_value(answer, "high", NULL, UNIT_NUMBER, shown(f, found->high), 3);
        answer_value(answer, "away", NULL, UNIT_NUMBER, found->away, 2);
    }
    answer_close(answer);
    answer_close(answer);
}
