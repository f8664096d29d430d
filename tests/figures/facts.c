#include "tests/figures/facts.h"

#include <math.h>

#define DEGREES_5 0.0871557427 /* sine of 5 degrees: a vee so high has 10 degrees at its top */
#define NUMBER(x) .stated = (x), .low = (x) / UNIT_NUMBER, .high = (x)*UNIT_NUMBER
#define MOST_MISS 100.0
#define LEAST     1e-12

const struct fact facts[] = {
    {"3.6", "3.6", "displacement after three mats, 0.056 ft; its mat is not named", FACT_U,
     .a = RUN_36, .mat_of = IN_MAT36, .at = 2, NUMBER(0.056), .held = true},
    {"3.7", "3.6", "displacement of mat 4 after three mats, 0.1036 ft", FACT_U, .a = RUN_37,
     .mat = 4, .at = 2, NUMBER(0.1036), .held = true},
    {"3.8", "3.6", "KL 16e5, crossing mat 1: mat 12 displaced 0.0075 ft", FACT_U,
     .a = RUN_38_MIDDLE, .mat = 12, .at = 0, NUMBER(0.0075)},
    {"3.8", "3.6", "the same: mat 16 displaced 0.73e-7 ft (within a factor of 2)", FACT_U,
     .a = RUN_38_MIDDLE, .mat = 16, .at = 0, .stated = 0.73e-7, .low = 0.365e-7, .high = 1.46e-7},
    {"3.8", "3.6", "the same: mat 17 not displaced (below a tenth of mat 16's)", FACT_U,
     .a = RUN_38_MIDDLE, .mat = 17, .at = 0, .high = 0.73e-8},
    {"3.12", "3.6", "displacement near the bow wave after four mats, 0.1612 ft", FACT_U,
     .a = RUN_312_TAD10, .mat_of = IN_MAT312, .at = 3, NUMBER(0.1612)},
    {"3.6, 3.7", "3.6", "the last mat stays still (below 0.00005 ft)", FACT_LAST, .a = RUN_36,
     .b = RUN_37, .high = 5e-5},
    {"3.6 to 3.12", "3.6", "displacement only grows (mat 4 falls back by less than 0.0005 ft)",
     FACT_FALLS_BACK, .a = RUN_36, .high = 5e-4},
    {"3.6", "3.6", "a bow wave forms", FACT_BOW, .a = RUN_36, .low = 1, .held = true},
    {"3.7", "3.6", "a bow wave forms", FACT_BOW, .a = RUN_37, .low = 1, .held = true},
    {"3.6", "3.6", "beyond 10 degrees (0.174 ft), below the low profile's 0.5 ft: largest lift, ft",
     FACT_PEAK, .a = RUN_36, .low = 2 * DEGREES_5, .high = 0.5},
    {"3.7", "3.6", "the same", FACT_PEAK, .a = RUN_37, .low = 2 * DEGREES_5, .high = 0.5},
    {"3.6, 3.7", "3.6", "KL 8e6 forms its wave more slowly: time to 0.05 ft over that of 16e6",
     FACT_RISES, .a = RUN_37, .b = RUN_36, .low = 1.001},
    {"3.6, 3.7", "3.6",
     "fig 3.6's deflection as plotted is less: its lift after three mats over "
     "fig 3.7's",
     FACT_LIFTS, .a = RUN_36, .b = RUN_37, .at = 2, .high = 0.999},
    {"3.6", "3.6", "the plotted wave stands: lift after three mats at least half of the largest",
     FACT_STANDS, .a = RUN_36, .low = 0.5},
    {"3.7", "3.6", "the same", FACT_STANDS, .a = RUN_37, .low = 0.5},
    {"3.8", "3.6", "KL 16e6 forms a bow wave", FACT_BOW, .a = RUN_38_STIFF, .low = 1, .held = true},
    {"3.8", "3.6", "KL 16e4 is horizontal again after two mats (lift below 0.005 ft)", FACT_LIFT,
     .a = RUN_38_SOFT, .at = 1, .high = 0.005, .held = true},
    {"3.8, 3.7", "3.6", "the larger bump gives the higher wave: largest lifts, 3.8 over 3.7",
     FACT_PEAKS, .a = RUN_38_STIFF, .b = RUN_37, .low = 1.001},
    {"3.8, 3.7", "3.6", "and more quickly: time to 0.05 ft, 3.7 over 3.8", FACT_RISES, .a = RUN_37,
     .b = RUN_38_STIFF, .low = 1.001},
    {"3.9", "3.6", "f 0.5: a bow wave", FACT_BOW, .a = RUN_39_F05, .low = 1, .held = true},
    {"3.9", "3.6", "almost identical for f 0.9 (5 %): largest lifts, 0.9 over 0.5", FACT_PEAKS,
     .a = RUN_39_F09, .b = RUN_39_F05, .low = 0.95, .high = 1.05, .held = true},
    {"3.9", "3.6", "displacements slightly less for f 0.9: mat 4, 0.9 over 0.5", FACT_MOVES,
     .a = RUN_39_F09, .b = RUN_39_F05, .at = 2, .low = 0.8, .high = 0.999, .held = true},
    {"3.10", "3.6", "f 0.5, two mats: a bow wave", FACT_BOW, .a = RUN_310_F05, .low = 1,
     .held = true},
    {"3.10", "3.6", "friction not significant (5 %): largest lifts, f 0.9 over 0.5", FACT_PEAKS,
     .a = RUN_310_F09, .b = RUN_310_F05, .low = 0.95, .high = 1.05, .held = true},
    {"3.11", "3.6", "6,000 lb: no bow wave", FACT_BOW, .a = RUN_311_6, .high = 0.999, .held = true},
    {"3.11", "6.1.3", "12,000 lb: a wave of approximately 3 in (2.5 to 3.5) after 2.5 mats, ft",
     FACT_LIFT, .a = RUN_311_12, .at = 2, .stated = 0.25, .low = 2.5 / 12, .high = 3.5 / 12,
     .held = true},
    {"3.11", "6.1.3", "24,000 lb: over 1 ft at the same time", FACT_LIFT, .a = RUN_311_24, .at = 2,
     .low = 1, .held = true},
    {"text", "6.1.3", "3/16 in on tightly compressed mat (KL 16e6) buckles", FACT_BOW,
     .a = RUN_311_TIGHT, .low = 1},
    {"text", "6.1.3", "less compressed mat (8e6) more slowly: time to 0.05 ft over that of 16e6",
     FACT_RISES, .a = RUN_311_12, .b = RUN_311_TIGHT, .low = 1.001},
    {"3.12", "3.6", "TAD 10: a bow wave", FACT_BOW, .a = RUN_312_TAD10, .low = 1, .held = true},
    {"3.12", "3.6", "its wave stands after four mats (at least half of the largest lift)",
     FACT_STANDS, .a = RUN_312_TAD10, .low = 0.5},
    {"3.12", "6.1.3", "TAD 1: no bow wave", FACT_BOW, .a = RUN_312_TAD1, .high = 0.999,
     .held = true},
    {"text", "3.6", "full width, 144,000 lb: a bow wave", FACT_BOW, .a = RUN_FULL_144, .low = 1,
     .held = true},
    {"text", "6.1.3", "full width, 40,000 lb: no buckling", FACT_BOW, .a = RUN_FULL_40,
     .high = 0.999, .held = true},
    {"text", "3.6", "full width, 36,000 lb: no bow wave", FACT_BOW, .a = RUN_FULL_36, .high = 0.999,
     .held = true},
    {"text", "3.7", "a flat mat never buckles: largest lift, ft", FACT_PEAK, .a = RUN_FLAT,
     .high = 1e-9, .held = true},
    {"text", "3.7",
     "soil has little influence (10 %): least over most of the largest lifts, four "
     "soils",
     FACT_SPREAD, .a = RUN_SOIL_SOFT, .b = RUN_SOIL_DULL, .low = 0.9, .held = true},
    {"text", "6.1.3", "a wider mat turns significantly less (half): largest lifts, I 8 over I 2",
     FACT_PEAKS, .a = RUN_WIDE, .b = RUN_311_12, .high = 0.5, .held = true},
    {"text", "3.7",
     "velocity matters (a quarter): least over most of the largest lifts, 60 and "
     "140 ft/s",
     FACT_SPREAD, .a = RUN_SLOW, .b = RUN_FAST, .high = 0.8, .held = true},
};
const size_t fact_count = sizeof facts / sizeof facts[0];

static double ratio(double of, double by)
{
    return by > 0 && isfinite(of) ? of / by : (double)NAN;
}

static double largest_last(struct playing *playing, enum run_id from, enum run_id to)
{
    double most = 0;
    for (int id = (int)from; id <= (int)to; id++) {
        const struct played *p = play_run(playing, (enum run_id)id);
        if (!p->ok)
            return (double)NAN;
        for (int k = 0; k < p->times; k++)
            most = fmax(most, fabs(p->last_ft[k]));
    }
    return most;
}

static double falls_back(struct playing *playing)
{
    static const enum run_id runs[] = {RUN_36, RUN_37, RUN_312_TAD10};
    double most = 0;
    for (size_t i = 0; i < sizeof runs / sizeof runs[0]; i++) {
        const struct played *p = play_run(playing, runs[i]);
        if (!p->ok)
            return (double)NAN;
        for (int k = 1; k < p->times; k++)
            most = fmax(most, p->u_ft[k - 1][4] - p->u_ft[k][4]);
    }
    return most;
}

static double spread(struct playing *playing, enum run_id from, enum run_id to)
{
    double least = (double)INFINITY, most = 0;
    for (int id = (int)from; id <= (int)to; id++) {
        if (id == RUN_SOIL_DULL && !playing->fine)
            continue; /* its damper takes ten times the steps of any other run */
        const struct played *p = play_run(playing, (enum run_id)id);
        if (!p->ok)
            return (double)NAN;
        least = fmin(least, p->peak_ft);
        most = fmax(most, p->peak_ft);
    }
    return ratio(least, most);
}

/* Of two runs; one that never rises takes endlessly long. */
static double rises(const struct played *a, const struct played *b)
{
    if (isinf(b->rise_s))
        return (double)NAN;
    return isinf(a->rise_s) ? HUGE_VAL : a->rise_s / b->rise_s;
}

double fact_value(const struct fact *fact, struct playing *playing)
{
    int k = fact->at, mat = fact->mat ? fact->mat : (int)playing->reading.value[fact->mat_of];
    switch (fact->kind) {
    case FACT_LAST: return largest_last(playing, fact->a, fact->b);
    case FACT_FALLS_BACK: return falls_back(playing);
    case FACT_SPREAD: return spread(playing, fact->a, fact->b);
    default: break;
    }
    const struct played *a = play_run(playing, fact->a);
    if (!a->ok)
        return (double)NAN;
    switch (fact->kind) {
    case FACT_U: return a->u_ft[k][mat];
    case FACT_BOW: return a->peak_ft / a->threshold_ft;
    case FACT_LIFT: return a->lift_ft[k];
    case FACT_PEAK: return a->peak_ft;
    case FACT_STANDS: return ratio(a->lift_ft[a->times - 1], a->peak_ft);
    default: break;
    }
    const struct played *b = play_run(playing, fact->b);
    if (!b->ok)
        return (double)NAN;
    switch (fact->kind) {
    case FACT_LIFTS: return ratio(a->lift_ft[k], b->lift_ft[k]);
    case FACT_PEAKS: return ratio(a->peak_ft, b->peak_ft);
    case FACT_MOVES: return ratio(a->u_ft[k][4], b->u_ft[k][4]);
    case FACT_RISES: return rises(a, b);
    default: return (double)NAN;
    }
}

bool fact_met(const struct fact *fact, double value)
{
    return value >= fact->low && (fact->high == 0 || value <= fact->high);
}

double fact_miss(const struct fact *fact, double value)
{
    double bound = value < fact->low ? fact->low : fact->high;
    if (isnan(value))
        return MOST_MISS;
    if (fact->stated > 0) {
        double unit = fact->high / fact->stated;
        return fmin(fabs(log(fmax(value, LEAST) / fact->stated)) / log(unit), MOST_MISS);
    }
    if (fact_met(fact, value))
        return 0;
    return fmin(1 + fabs(log(fmax(value, LEAST) / bound)) / log(UNIT_WORDS), MOST_MISS);
}

bool fact_moves(const struct fact *fact)
{
    return fact->kind == FACT_U || fact->kind == FACT_LAST || fact->kind == FACT_FALLS_BACK ||
           fact->kind == FACT_MOVES;
}
