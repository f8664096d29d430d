#include "host/day/steps.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "common/catalogue.h"
#include "host/store/store.h"

const struct day_word day_step_words[DAY_STEPS] = {
#define DAY_STEP(NAME, key, text) [DAY_##NAME] = {#key, text},
    DAY_STEPS_EACH(DAY_STEP)
#undef DAY_STEP
};

const char *day_state_text(enum day_state state)
{
    static const char *const text[] = {[DAY_DONE] = "done",
                                       [DAY_NEXT] = "next",
                                       [DAY_LATER] = "later",
                                       [DAY_SKIPPED] = "skipped",
                                       [DAY_NOT_NEEDED] = "not needed"};
    return text[state];
}

enum day_step day_step_find(const char *key)
{
    enum day_step step = 0;
    while (step < DAY_STEPS && strcmp(day_step_words[step].key, key) != 0)
        step++;
    return step;
}

/* What a step is, but for what comes before it; and why. */
static enum day_state say(char reason[240], enum day_state state, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
static enum day_state say(char reason[240], enum day_state state, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(reason, 240, format, arguments);
    va_end(arguments);
    return state;
}

static const char *clock_text(int64_t us, char out[9])
{
    time_t s = (time_t)(us / 1000000);
    struct tm at;
    localtime_r(&s, &at);
    snprintf(out, 9, "%02d:%02d", at.tm_hour % 100, at.tm_min % 100);
    return out;
}

bool day_landing_goes_on(const struct day_facts *f)
{
    return f->run && (f->state == MR_LANDING_ARMED || f->state == MR_LANDING_LANDING ||
                      f->state == MR_LANDING_SETTLING);
}

static enum day_state look(const struct day_facts *f, char reason[240])
{
    if (!f->run)
        return say(reason, DAY_NOT_NEEDED, "no landing yet");
    if (f->looked)
        return say(reason, DAY_DONE, "RUN %lld", (long long)f->run);
    if ((f->logging || f->held) && day_landing_goes_on(f))
        return say(reason, DAY_NOT_NEEDED, "RUN %lld goes on%s", (long long)f->run,
                   f->logging ? "" : ", in a log that this day did not begin");
    if (day_landing_goes_on(f))
        return say(reason, DAY_NEXT,
                   "RUN %lld was cut off while it was %s: matrig board list shows whether the "
                   "board has the rest of it",
                   (long long)f->run, mr_landing_state_text((uint8_t)f->state));
    return say(reason, DAY_NEXT, "nobody has looked at RUN %lld", (long long)f->run);
}

static enum day_state series(const struct day_facts *f, char reason[240])
{
    return f->series[0] ? say(reason, DAY_DONE, "%.80s", f->series)
                        : say(reason, DAY_NEXT, "nothing says what is tested");
}

static enum day_state calibrate(const struct day_facts *f, char reason[240])
{
    if (f->calibration_due && f->calibrated_us < f->ready_us)
        return say(reason, DAY_NEXT, "%.200s", f->no_go);
    return f->calibrated_us ? say(reason, DAY_DONE, "walked along the channels")
                            : say(reason, DAY_NOT_NEEDED, "ready says when it is due");
}

static bool surveyed(const struct day_facts *f)
{
    return f->survey && f->survey_ended_us != STORE_NONE && f->survey_us >= f->armed_us;
}

static enum day_state survey(const struct day_facts *f, char reason[240])
{
    char at[9];
    if (f->survey && f->survey_ended_us == STORE_NONE)
        return say(reason, DAY_NEXT, "survey %lld goes on: %zu of %zu read", (long long)f->survey,
                   f->survey_read, f->survey_of);
    if (surveyed(f))
        return say(reason, DAY_DONE, "survey %lld, ended %s", (long long)f->survey,
                   clock_text(f->survey_ended_us, at));
    return f->run
             ? say(reason, DAY_NEXT, "the mat has not been read since RUN %lld", (long long)f->run)
             : say(reason, DAY_NEXT, "the mat has not been read yet");
}

static enum day_state load(const struct day_facts *f, char reason[240])
{
    char at[9];
    if (!surveyed(f) && f->skipped[DAY_SURVEY])
        return say(reason, DAY_NOT_NEEDED, "no survey to load");
    if (surveyed(f) && f->loaded_us)
        return say(reason, DAY_DONE, "the board has survey %lld, since %s", (long long)f->survey,
                   clock_text(f->loaded_us, at));
    return say(reason, DAY_NEXT, "the board has not got the survey");
}

static enum day_state advise(const struct day_facts *f, char reason[240])
{
    if (!f->run)
        return say(reason, DAY_NOT_NEEDED, "it learns from landings, and there is none yet");
    if (f->advised_us && (!surveyed(f) || f->advised_us > f->survey_ended_us))
        return say(reason, DAY_DONE, "%s", f->advice);
    return say(reason, DAY_NEXT, "nobody knows how hard to brake");
}

static enum day_state ready(const struct day_facts *f, char reason[240])
{
    char at[9];
    bool old = f->ready_us < f->armed_us || f->ready_us < f->calibrated_us ||
               (surveyed(f) && f->ready_us < f->loaded_us);
    if (f->ready_us && !old && f->go)
        return say(reason, DAY_DONE, "go, at %s", clock_text(f->ready_us, at));
    if (f->ready_us && !old)
        return say(reason, DAY_NEXT, "no-go at %s: %.180s", clock_text(f->ready_us, at), f->no_go);
    return f->ready_us ? say(reason, DAY_NEXT, "the last one, at %s, is of before",
                             clock_text(f->ready_us, at))
                       : say(reason, DAY_NEXT, "board and sensors were not looked at");
}

static enum day_state land(const struct day_facts *f, char reason[240])
{
    if (f->held)
        return say(reason, DAY_NEXT, "a log that this day did not begin is running: end it first");
    if (!f->logging)
        return say(reason, DAY_NEXT, "all is ready");
    return day_landing_goes_on(f) ? say(reason, DAY_NEXT, "RUN %lld goes on: %s", (long long)f->run,
                                        mr_landing_state_text((uint8_t)f->state))
                                  : say(reason, DAY_NEXT, "the log is running, nothing is armed");
}

void day_plan_make(const struct day_facts *f, struct day_plan *plan)
{
    static enum day_state (*const of[DAY_STEPS])(const struct day_facts *, char[240]) = {
        [DAY_LOOK] = look,     [DAY_SERIES] = series, [DAY_CALIBRATE] = calibrate,
        [DAY_SURVEY] = survey, [DAY_LOAD] = load,     [DAY_ADVISE] = advise,
        [DAY_READY] = ready,   [DAY_LAND] = land};
    bool found = false;
    plan->next = DAY_LAND;
    for (enum day_step step = 0; step < DAY_STEPS; step++) {
        plan->state[step] = of[step](f, plan->reason[step]);
        if (plan->state[step] == DAY_NEXT && f->skipped[step])
            plan->state[step] = DAY_SKIPPED;
        /* what runs is next, whatever is open before it */
        if (plan->state[step] == DAY_NEXT && (f->logging || f->held) && step != DAY_LAND)
            plan->state[step] = DAY_LATER;
        if (plan->state[step] != DAY_NEXT)
            continue;
        if (found)
            plan->state[step] = DAY_LATER;
        else
            plan->next = step;
        if (found && step == DAY_LAND)
            say(plan->reason[step], DAY_LATER, "when what stands before it is done");
        found = true;
    }
}
