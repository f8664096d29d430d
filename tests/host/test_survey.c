/* Surveys: the walk, what is typed, what it comes to. */
#include <math.h>
#include <stdlib.h>

#include "host/survey/survey.h"
#include "tests/host/scratch.h"

#define MAT_SPAN_FT (120.0 / 42.0) /* ten of 420 mats on 120 ft */

/* ---- the walk ---- */

TEST(the_walk_is_whole_and_never_jumps)
{
    struct survey_plan plan;
    unsigned gaps[SURVEY_LINES] = {0}, stations = 0;
    survey_plan_init(&plan, SURVEY_EDGE_LEFT);
    assert_int_equal(plan.count, 4 * 42 + 13);
    double at_ft = 0.0;
    for (size_t i = 0; i < plan.count; i++) {
        const struct survey_item *item = &plan.item[i];
        assert_int_equal(survey_plan_find(&plan, item), i); /* no place twice */
        gaps[item->line - 1] += item->kind == SURVEY_ITEM_GAP;
        stations += item->kind == SURVEY_ITEM_STATION;
        double next_ft = item->kind == SURVEY_ITEM_GAP ? MAT_SPAN_FT * item->index
                                                       : 10.0 * item->index;
        assert_true(fabs(next_ft - at_ft) < 2 * MAT_SPAN_FT);
        at_ft = next_ft;
    }
    for (unsigned line = 0; line < SURVEY_LINES; line++)
        assert_int_equal(gaps[line], 42);
    assert_int_equal(stations, 13);
    survey_plan_init(&plan, SURVEY_EDGE_NONE);
    assert_int_equal(plan.count, 168);
    survey_plan_init(&plan, SURVEY_EDGE_BOTH);
    assert_int_equal(plan.count, 168 + 26);
    survey_plan_init(&plan, SURVEY_EDGE_DIAGONAL);
    assert_int_equal(plan.count, 168 + 2 * 4 * 13 + 7 * 7);
    for (size_t i = 0; i < plan.count; i++)
        assert_int_equal(survey_plan_find(&plan, &plan.item[i]), i);
    assert_true(fabs(survey_line_offset_in(3) - survey_line_offset_in(2) - 36.0) < 1e-12 &&
                survey_line_offset_in(1) == 12.0);
}

/* ---- typing ---- */

static void entry(const char *line, bool si, enum survey_entry_kind word, double value_in)
{
    struct survey_entry e;
    survey_entry_parse(line, si, &e);
    if (e.kind != word || (word == SURVEY_ENTRY_NUMBER && fabs(e.value_in - value_in) > 1e-9))
        fail_msg("'%s': word %d, %g in", line, e.kind, e.value_in);
}

TEST(lines_are_read_as_calipers_type_them)
{
    entry("33.512", false, SURVEY_ENTRY_NUMBER, 33.512);
    entry("  +33.512\r", false, SURVEY_ENTRY_NUMBER, 33.512);
    entry("851.2048 mm", false, SURVEY_ENTRY_NUMBER, 33.512);
    entry("2.5 ft", true, SURVEY_ENTRY_NUMBER, 30.0);
    entry("33.512in", true, SURVEY_ENTRY_NUMBER, 33.512);
    entry("851.2048", true, SURVEY_ENTRY_NUMBER, 33.512);
    entry("-0.25", false, SURVEY_ENTRY_NUMBER, -0.25);
    entry("", false, SURVEY_ENTRY_EMPTY, 0);
    entry(" \r", false, SURVEY_ENTRY_EMPTY, 0);
    entry("s", false, SURVEY_ENTRY_SKIP, 0);
    entry("u ", false, SURVEY_ENTRY_UNDO, 0);
    entry("b", false, SURVEY_ENTRY_BACK, 0);
    entry("q", false, SURVEY_ENTRY_QUIT, 0);
    entry("?", false, SURVEY_ENTRY_HELP, 0);
    entry("n dirt in the joint", false, SURVEY_ENTRY_NOTE, 0);
    const char *const nonsense[] = {"n",   "n ",        "su",   "33.5.1", "33.5 lb", "33.5 34.1",
                                    "1e3", "nan",       "inf",  "0x10",   "-",       "99999",
                                    ".",   "33.5mm in", "33,8", "33,512"};
    for (size_t i = 0; i < sizeof nonsense / sizeof nonsense[0]; i++)
        entry(nonsense[i], false, SURVEY_ENTRY_INVALID, 0);
}

static enum survey_entry_outcome typed(struct survey_progress *progress, const char *line,
                                       size_t *item)
{
    struct survey_entry e;
    survey_entry_parse(line, false, &e);
    return survey_progress_apply(progress, &e, item);
}

TEST(a_reading_beyond_the_joints_is_asked_again)
{
    struct survey_progress progress;
    size_t item;
    survey_progress_init(&progress, SURVEY_EDGE_NONE);
    for (size_t i = 0; i < progress.plan.count; i++)
        progress.previous_in[i] = 33.60;
    /* 0.36: ten joints of 0.036 can do that */
    assert_int_equal(typed(&progress, "33.24", &item), SURVEY_OUTCOME_STORED);
    assert_int_equal(typed(&progress, "33.96", &item), SURVEY_OUTCOME_STORED);
    assert_int_equal(typed(&progress, "33.239", &item), SURVEY_OUTCOME_DOUBTFUL);
    assert_int_equal(progress.current_item, 2);
    assert_true(isnan(progress.value_in[2]));
    /* read again, and right this time */
    assert_int_equal(typed(&progress, "33.241", &item), SURVEY_OUTCOME_STORED);
    assert_int_equal(item, 2);
    assert_int_equal(typed(&progress, "36.60", &item), SURVEY_OUTCOME_DOUBTFUL);
    assert_int_equal(typed(&progress, "36.65", &item),
                     SURVEY_OUTCOME_DOUBTFUL); /* another one: doubted anew */
    assert_int_equal(typed(&progress, "36.66", &item), SURVEY_OUTCOME_CONFIRMED);
    assert_int_equal(item, 3);
    assert_true(progress.value_in[3] == 36.66);
    assert_int_equal(typed(&progress, "30", &item), SURVEY_OUTCOME_DOUBTFUL);
    /* forget the doubtful one, not the one before */
    assert_int_equal(typed(&progress, "u", &item), SURVEY_OUTCOME_ITEM_CHANGED);
    assert_true(progress.value_in[3] == 36.66);
    progress.previous_in[4] = (double)NAN; /* nothing before: against the designed distance */
    assert_int_equal(typed(&progress, "33.861", &item), SURVEY_OUTCOME_DOUBTFUL);
    assert_int_equal(typed(&progress, "33.859", &item), SURVEY_OUTCOME_STORED);
}

TEST(undo_skip_back)
{
    struct survey_progress progress;
    size_t item;
    survey_progress_init(&progress, SURVEY_EDGE_NONE);
    assert_int_equal(typed(&progress, "u", &item), SURVEY_OUTCOME_REFUSED);
    assert_int_equal(typed(&progress, "b", &item), SURVEY_OUTCOME_REFUSED);
    assert_int_equal(typed(&progress, "n lost", &item), SURVEY_OUTCOME_REFUSED);
    typed(&progress, "33.51", &item);
    typed(&progress, "33.52", &item);
    assert_int_equal(typed(&progress, "s", &item), SURVEY_OUTCOME_SKIPPED);
    typed(&progress, "33.54", &item);
    assert_int_equal(typed(&progress, "n dirt", &item), SURVEY_OUTCOME_NOTED);
    assert_int_equal(item, 3);
    assert_int_equal(typed(&progress, "u", &item), SURVEY_OUTCOME_UNDONE);
    assert_int_equal(item, 3);
    assert_true(isnan(progress.value_in[3]) && progress.current_item == 3);
    assert_int_equal(typed(&progress, "u", &item), SURVEY_OUTCOME_UNDONE); /* the skipped one */
    assert_true(item == 2 && !progress.is_skipped[2] && progress.current_item == 2);
    assert_int_equal(typed(&progress, "b", &item), SURVEY_OUTCOME_ITEM_CHANGED);
    assert_int_equal(progress.current_item, 1);
    typed(&progress, "33.53", &item); /* in its place */
    assert_true(progress.value_in[1] == 33.53 && progress.current_item == 2);
    assert_int_equal(survey_progress_count_read(&progress), 2);
    typed(&progress, "s", &item);
    while (progress.current_item < progress.plan.count)
        assert_int_equal(typed(&progress, "33.5", &item), SURVEY_OUTCOME_STORED);
    assert_int_equal(survey_progress_count_read(&progress), 167);
    assert_int_equal(typed(&progress, "33.5", &item), SURVEY_OUTCOME_REFUSED);
}

/* ---- what it comes to ---- */

static double gauss(void)
{
    double sum = -6.0; /* twelve even ones: variance 1 */
    for (int i = 0; i < 12; i++)
        sum += rand() / (RAND_MAX + 1.0);
    return sum;
}

/* A movement to be found again, downfield, in. */
static double wanted_in(unsigned line, double x_ft)
{
    static const double height_in[SURVEY_LINES] = {0.9, 2.0, 1.9, 0.7};
    return 0.1 + height_in[line] * exp(-pow((x_ft - 60.0) / 20.0, 2));
}

static void make(struct survey_readings *now, struct survey_readings *before, double noise,
                 unsigned stations)
{
    survey_readings_init(now);
    survey_readings_init(before);
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        for (unsigned k = 0; k < SURVEY_SPANS; k++) {
            before->gap_in[line][k] = 33.6 + noise * 0.005 * gauss();
            now->gap_in[line][k] = 33.6 + wanted_in(line, MAT_SPAN_FT * (k + 1)) -
                                   wanted_in(line, MAT_SPAN_FT * k) + noise * 0.005 * gauss();
        }
        for (unsigned s = 0; stations >> line & 1u && s < SURVEY_STATIONS; s++) {
            double at = 10.0 * s / MAT_SPAN_FT, k = floor(at + 1e-9);
            before->station_in[line][s] = noise * 0.02 * gauss();
            now->station_in[line][s] = (1.0 - at + k) * wanted_in(line, MAT_SPAN_FT * k) +
                                       (at - k) * wanted_in(line, MAT_SPAN_FT * (k + 1)) +
                                       noise * 0.02 * gauss();
        }
    }
}

TEST(movement_without_noise_is_found_again)
{
    struct survey_readings now, before;
    static struct survey_change change;
    make(&now, &before, 0.0, 1u);
    survey_compute_change(&now, &before, &change);
    for (unsigned line = 0; line < SURVEY_LINES; line++) {
        for (unsigned k = 0; k < SURVEY_POINTS; k++)
            /* all begin at 0.1, and a trace more */
            assert_true(fabs(change.movement[line][k].value_in - wanted_in(line, MAT_SPAN_FT * k)) <
                        3e-4);
    }
    /* the middle of the runway: chord of the edges 0.9 (12 in) and 0.7 (156 in); line 2 at 48 in,
     * line 3 at 84 in; of height at 60 ft */
    double line2_in = 2.0 - (0.9 + (0.7 - 0.9) * 36.0 / 144.0),
           line3_in = 1.9 - (0.9 + (0.7 - 0.9) * 72.0 / 144.0);
    assert_true(line2_in > line3_in);
    assert_true(fabs(change.bow[21].value_in - line2_in) < 4e-4);
    assert_true(SURVEY_BOW_LIMIT_IN == 11.0 / 7.0);
}

/* Errors are what they say: over many surveys, departures have the stated spread. */
TEST(stated_errors_hold)
{
    enum { TRIALS = 400 };
    struct survey_readings now, before;
    static struct survey_change change;
    double squares[3] = {0}, square_bow = 0;
    static const unsigned lines[3] = {0, 1, 3};
    srand(11);
    for (int i = 0; i < TRIALS; i++) {
        make(&now, &before, 1.0, 1u);
        survey_compute_change(&now, &before, &change);
        for (int l = 0; l < 3; l++) {
            const struct survey_estimate *e = &change.movement[lines[l]][30];
            squares[l] += pow((e->value_in - wanted_in(lines[l], MAT_SPAN_FT * 30)) / e->error_in,
                              2) /
                          TRIALS;
        }
        double line2_in = 2.0 - (0.9 + (0.7 - 0.9) * 36.0 / 144.0);
        square_bow += pow((change.bow[21].value_in - line2_in) / change.bow[21].error_in, 2) /
                      TRIALS;
    }
    for (int l = 0; l < 3; l++) /* 400 normal squares: 1 +- 0.07 */
        assert_true(squares[l] > 0.75 && squares[l] < 1.25);
    /* lines taken as independent: stated a little large, and the larger of two */
    assert_true(square_bow > 0.4 && square_bow < 1.3);
}

TEST(what_was_not_read_is_not_known)
{
    struct survey_readings now, before;
    static struct survey_change change;
    make(&now, &before, 0.0, 1u);
    for (unsigned k = 0; k < SURVEY_SPANS; k++)
        now.gap_in[3][k] = (double)NAN;
    survey_compute_change(&now, &before, &change);
    assert_true(isnan(change.movement[3][20].value_in) && isnan(change.bow[20].value_in));
    assert_true(!isnan(change.movement[1][20].value_in));
    make(&now, &before, 0.0, 1u);
    /* a hole: behind it the line is known to what ten joints can do */
    now.gap_in[1][20] = (double)NAN;
    survey_compute_change(&now, &before, &change);
    assert_true(change.movement[1][20].error_in < 0.05 && change.movement[1][21].error_in > 0.2);
}

TEST(slack_is_the_mean_of_the_lines)
{
    struct survey_readings now;
    static struct survey_slack slack;
    survey_readings_init(&now);
    now.gap_in[0][4] = 33.60;
    now.gap_in[1][4] = 33.70;
    now.gap_in[2][4] = 33.80;
    now.gap_in[3][4] = 33.45; /* shorter than closed: none */
    now.gap_in[2][5] = 33.62;
    survey_compute_slack(&now, 33.5, &slack);
    assert_int_equal(slack.surveyed_segment_count, 2);
    assert_int_equal(slack.line_count[4], 4);
    assert_true(fabs(slack.segment[4].value_in - 0.15) < 1e-9);
    /* of 0.1, 0.2, 0.3, 0: standard deviation 0.1291, of the mean half of it */
    assert_true(fabs(slack.segment[4].error_in - 0.06455) < 1e-5);
    assert_true(fabs(slack.segment[5].value_in - 0.12) < 1e-9 &&
                fabs(slack.segment[5].error_in - 0.005) < 1e-9);
    assert_true(isnan(slack.segment[6].value_in));
}
