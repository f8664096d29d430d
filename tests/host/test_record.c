/* The record of warnings: a campaign made by hand, of which it is known by construction what came
 * of each landing. The mats do not move; segments that were surveyed as closed are the zone. */
#include "common/emulated.h"
#include "host/analyse/measured_load.h"
#include "host/analyse/outcome.h"
#include "tests/host/session.h"

#define DB      "build/test-tmp/record.db"
#define STOP_FT 79.5625 /* 3 + 35^2 / 16 */

/* Closed from 57.14 to 74.29 ft: the wheel comes within 2 ft of it at (35 - sqrt(35^2 - 16 x
 * 52.14)) / 8 = 1.904 s. The board warns in the first look 1 s after touchdown, if it does. */
#define FAR_FIRST   20
#define FAR_LAST    25
#define FAR_AT_S    1.904
#define WARNED_AT_S 1.0
/* 14.29 to 31.43 ft: at 0.273 s */
#define NEAR_FIRST  5
#define NEAR_LAST   10
#define NEAR_AT_S   0.273
/* 77.14 to 94.29 ft: 53 mats ahead of where the wheel stands */
#define LEFT_FIRST  27
#define LEFT_LAST   32

static void sql(const char *format, ...) __attribute__((format(printf, 1, 2)));
static void sql(const char *format, ...)
{
    char statement[400], command[500];
    va_list list;
    va_start(list, format);
    vsnprintf(statement, sizeof statement, format, list);
    va_end(list);
    snprintf(command, sizeof command, "sqlite3 " DB " \"%s\"", statement);
    assert_int_equal(system(command), 0);
}

/* Sums of 0.2 in, read anew before each landing; closed ones 0. */
static void survey_anew(int run)
{
    sql("update slack set slack_in = 0.2 + 0.001 * %d where survey = (select id from surveys where "
        "landing = %d)",
        run, run);
}
static void survey_closed(int run, int first, int last)
{
    sql("update slack set slack_in = 0 where survey = (select id from surveys where landing = %d) "
        "and segment between %d and %d",
        run, first, last);
}

static struct session session;

/* `landings` of them; one that is warned of where `warned` has a 1. */
static void make(const char *warned)
{
    session_begin(&session, false, true);
    stream_hello(&session.stream, MR_LAYOUT);
    stream_configuration(&session.stream);
    stream_idle(&session.stream, 300);
    for (unsigned n = 1; *warned; n++, warned++) {
        struct stream_truth truth = {.v0_ft_s = 35.0, .a_ft_s2 = 8.0, .warn = *warned == '1'};
        stream_landing(&session.stream, &truth, n);
        stream_idle(&session.stream, 100);
    }
    session_log(&session, "record.db");
    assert_no_error(&session.error);
    store_close(session.store);
    session.store = NULL;
}

static void reopen(void)
{
    store_open(DB, STORE_OPEN, &session.store, &session.error);
    assert_no_error(&session.error);
}

static void load(struct outcome_record *record)
{
    assert_int_equal(outcome_record_load(session.store, record, &session.error), MR_OK);
}

static void advise(int64_t after_run, const char *verdict, double zone, double planned_ft_s2)
{
    struct store_advice advice = {.made_us = 1,
                                  .speed_ft_s = 35.0,
                                  .deceleration_ft_s2 = planned_ft_s2,
                                  .zone = zone,
                                  .after_run = after_run};
    snprintf(advice.verdict, sizeof advice.verdict, "%s", verdict);
    snprintf(advice.reason, sizeof advice.reason, "by hand");
    assert_int_equal(store_advice_add(session.store, &advice, &session.error), MR_OK);
}

static void see(int64_t run, const char *kind, const char *form)
{
    struct store_observation seen = {.run = run,
                                     .made_us = 1,
                                     .station_ft = 88.0,
                                     .panels = STORE_NONE,
                                     .height_in = (double)NAN,
                                     .time_s = (double)NAN,
                                     .withdraws = STORE_NONE};
    snprintf(seen.kind, sizeof seen.kind, "%s", kind);
    snprintf(seen.form, sizeof seen.form, "%s", form);
    assert_int_equal(store_observation_add(session.store, &seen, &session.error), MR_OK);
}

static void is(const struct outcome_record *record, int run, enum warning_outcome verdict,
               enum outcome_basis basis)
{
    const struct outcome_record_row *row = &record->row[run - 1];
    if (row->run != run || row->warning_outcome != verdict || row->outcome.basis != basis)
        fail_msg("RUN %d: %s by %s (%s), wanted %s by %s", run,
                 warning_outcome_text(row->warning_outcome), outcome_basis_text(row->outcome.basis),
                 row->unknown_reason ? row->unknown_reason : "", warning_outcome_text(verdict),
                 outcome_basis_text(basis));
    if (verdict == WARNING_OUTCOME_UNKNOWN)
        assert_non_null(row->unknown_reason);
}

/* The JSON of an outcome. */
static void has_json(const struct outcome_record_row *row, const char *result, int zone_reached)
{
    struct answer *answer = answer_new(false);
    outcome_record_add_outcome(row, answer);
    json_t *all = answer_make_json_and_free(answer), *outcome = json_object_get(all, "outcome");
    const json_t *lead = json_object_get(outcome, "lead_s"),
                 *reached = json_object_get(outcome, "zone_reached");
    char evidence[OUTCOME_TEXT_SIZE];
    assert_string_equal(json_string_value(json_object_get(outcome, "result")), result);
    assert_string_equal(json_string_value(json_object_get(outcome, "evidence")),
                        outcome_record_format_evidence(row, evidence));
    assert_true(zone_reached < 0
                    ? json_is_null(reached)
                    : json_is_boolean(reached) && json_is_true(reached) == zone_reached);
    assert_true(isnan(row->lead_time_s) ? json_is_null(lead) : json_is_real(lead));
    if (json_is_real(lead)) {
        assert_near(json_real_value(lead), row->lead_time_s, 1e-5);
        assert_near(json_real_value(json_object_get(outcome, "lead_low_s")), row->lead_time_low_s,
                    1e-5);
    }
    if (row->is_void)
        assert_true(json_is_null(json_object_get(outcome, "zone_mats")) &&
                    json_is_null(json_object_get(outcome, "zone_reached_t_s")));
    json_decref(all);
}

TEST(each_kind)
{
    struct outcome_record record;
    make("1010100101000");
    for (int run = 1; run <= 13; run++)
        survey_anew(run);
    survey_closed(1, FAR_FIRST, FAR_LAST); /* warned, came */
    survey_closed(2, FAR_FIRST, FAR_LAST); /* quiet, came */
    /* 3: warned, did not come; 4: quiet, did not come */
    sql("update slack set slack_in = 0.204 where survey = (select id from surveys where landing = "
        "5)"); /* warned, but all of the survey but two segments is the one before landing 4 */
    sql("update slack set slack_in = 0.1 where survey = (select id from surveys where landing = 5) "
        "and segment < 2");
    /* 6: quiet; a person saw a wave. 7: quiet; a two-panel wave, and an old survey */
    sql("update slack set slack_in = 0.206 where survey = (select id from surveys where landing = "
        "7)");
    /* 8: warned, void */
    survey_closed(9, NEAR_FIRST, NEAR_LAST);  /* came, quiet */
    survey_closed(10, NEAR_FIRST, NEAR_LAST); /* warned after it came */
    /* 11: quiet, not surveyed where a zone may be */
    sql("update slack set slack_in = null where survey = (select id from surveys where landing = "
        "11) and segment between %d and %d",
        FAR_FIRST, FAR_LAST);
    /* 12: quiet, its own survey is old; the one after it shows a zone at the wheel */
    sql("update slack set slack_in = (select s.slack_in from slack s where s.segment = "
        "slack.segment and s.survey = (select id from surveys where landing = 11)) where survey = "
        "(select id from surveys where landing = 12)");
    survey_closed(13, LEFT_FIRST, LEFT_LAST);
    sql("insert into landing_changes (landing, made_us, field, value) values (8, 1, 'void', "
        "'yes')");
    reopen();
    see(6, "wave", "");
    see(7, "wave", "two-panel");
    load(&record);
    assert_int_equal(record.row_count, 13);
    is(&record, 1, WARNING_HIT, OUTCOME_TRANSDUCERS);
    is(&record, 2, WARNING_MISS, OUTCOME_TRANSDUCERS);
    is(&record, 3, WARNING_FALSE_ALARM, OUTCOME_TRANSDUCERS);
    is(&record, 4, WARNING_TRUE_NEGATIVE, OUTCOME_TRANSDUCERS);
    is(&record, 5, WARNING_OUTCOME_UNKNOWN, OUTCOME_NO_BASIS);
    is(&record, 6, WARNING_MISS, OUTCOME_OBSERVATION);
    is(&record, 7, WARNING_OUTCOME_UNKNOWN, OUTCOME_NO_BASIS);
    is(&record, 8, WARNING_OUTCOME_UNKNOWN, OUTCOME_NO_BASIS);
    is(&record, 9, WARNING_MISS, OUTCOME_TRANSDUCERS);
    is(&record, 10, WARNING_LATE, OUTCOME_TRANSDUCERS);
    is(&record, 11, WARNING_OUTCOME_UNKNOWN, OUTCOME_NO_BASIS);
    is(&record, 12, WARNING_MISS, OUTCOME_SURVEY_AFTER);
    is(&record, 13, WARNING_MISS, OUTCOME_TRANSDUCERS); /* the same zone, before it */
    assert_int_equal(record.landing_count, 12);
    assert_int_equal(record.void_count, 1);
    assert_int_equal(record.warning_outcome_count[WARNING_HIT], 1);
    assert_int_equal(record.warning_outcome_count[WARNING_LATE], 1);
    assert_int_equal(record.warning_outcome_count[WARNING_MISS], 5);
    assert_int_equal(record.warning_outcome_count[WARNING_FALSE_ALARM], 1);
    /* looks are 20 ms apart; the board looks every 50 ms */
    assert_near(record.row[0].outcome.reached_t_s, FAR_AT_S, 0.021);
    assert_near(record.row[0].warned_t_s, WARNED_AT_S, 0.051);
    assert_near(record.row[0].lead_time_s, FAR_AT_S - WARNED_AT_S, 0.06);
    assert_near(record.row[8].outcome.reached_t_s, NEAR_AT_S, 0.021);
    /* 60 mats at once: 4.86 ft before the zone at 1.764 s, inside it at 2.008 s */
    assert_near(record.row[0].outcome.reached_earliest_s, 1.764, 0.021);
    assert_near(record.row[0].outcome.reached_latest_s, 2.008, 0.021);
    assert_near(record.row[0].lead_time_low_s, 1.764 - WARNED_AT_S, 0.06);
    assert_near(record.row[0].lead_time_high_s, 2.008 - WARNED_AT_S, 0.06);
    assert_near(record.row[9].lead_time_s, NEAR_AT_S - WARNED_AT_S, 0.06);
    has_json(&record.row[0], "hit", 1);
    has_json(&record.row[1], "missed", 1);
    has_json(&record.row[2], "false", 0);
    has_json(&record.row[3], "correctly quiet", 0);
    has_json(&record.row[4], "not known", -1);
    has_json(&record.row[7], "not known", -1); /* void */
    has_json(&record.row[9], "warned, but too late", 1);
    assert_int_equal(record.row[0].outcome.longest_mats, 60);
    assert_near(record.row[0].outcome.longest_start_ft, 57.14, 0.1);
    assert_int_equal(record.row[11].outcome.closed_after_mats, 52); /* 79.56 to 94.29 ft */
    outcome_record_free(&record);
    session_end(&session);
}

TEST(advice_and_what_came)
{
    struct outcome_record record;
    make("0000000000");
    for (int run = 1; run <= 10; run++) {
        survey_anew(run);
        if (run % 2)
            survey_closed(run, FAR_FIRST, FAR_LAST);
    }
    reopen();
    for (int run = 1; run <= 10; run++) { /* odd ones come: said 0.8, the others 0.3 */
        if (run == 4)
            advise(run - 1, "against", 0.99, 8.0); /* taken back by the next */
        advise(run - 1, run % 2 ? "against" : "clear", run % 2 ? 0.8 : 0.3, 8.0);
    }
    advise(10, "caution", 0.5, 8.0);
    load(&record);
    assert_int_equal(record.advice_count[ADVICE_AGAINST][OUTCOME_REACHED], 5);
    assert_int_equal(record.advice_count[ADVICE_AGAINST][OUTCOME_NOT_REACHED], 0);
    assert_int_equal(record.advice_count[ADVICE_CLEAR][OUTCOME_NOT_REACHED], 5);
    outcome_record_free(&record);

    /* Planned at 5 ft/s2 and braked at 8: another landing. */
    advise(1, "against", 0.9, 5.0);
    load(&record);
    assert_int_equal(record.off_plan_count, 1);
    assert_int_equal(record.advice_count[ADVICE_CLEAR][OUTCOME_NOT_REACHED], 4);
    outcome_record_free(&record);
    session_end(&session);
}

/* Whoever has loaded a landing need not wait for it again, and gets the same. */
TEST(given)
{
    struct outcome_record record;
    static struct measured_landing measured;
    struct zones zones;
    make("1");
    survey_closed(1, FAR_FIRST, FAR_LAST);
    reopen();
    assert_int_equal(measured_load(session.store, 1, &measured, &session.error), MR_OK);
    assert_int_equal(zones_load(session.store, &measured, &zones, &session.error), MR_OK);
    const struct outcome_record_landing there = {&measured, &zones};
    assert_int_equal(outcome_record_begin(session.store, &record, &session.error), MR_OK);
    assert_int_equal(outcome_record_evaluate(session.store, &record, &there, &session.error),
                     MR_OK);
    assert_int_equal(outcome_record_end(session.store, &record, &session.error), MR_OK);
    is(&record, 1, WARNING_HIT, OUTCOME_TRANSDUCERS);
    outcome_record_free(&record);
    zones_free(&zones);
    measured_free(&measured);
    session_end(&session);
}

static void begin_on(int64_t run, unsigned landings)
{
    const struct mr_predictor_state state = {.mats = 420, .landing_count = (uint16_t)landings};
    assert_int_equal(store_runway_put(session.store, run, &state, 1, &session.error), MR_OK);
}

/* RUN 3 begins on the runway of RUN 2 again: the advice is of it too, and it braked at 8 ft/s2, as
 * RUN 2. The mat of a real board does not go back. */
TEST(restored_runway)
{
    struct outcome_record record;
    char text[OUTCOME_ADVICE_SIZE];
    const struct store_advice advice = {.made_us = 1,
                                        .speed_ft_s = 35.0,
                                        .deceleration_ft_s2 = 9.0,
                                        .hardest_ft_s2 = 8.5,
                                        .verdict = "against",
                                        .reason = "by hand",
                                        .after_run = 1};
    make("000");
    for (int run = 1; run <= 3; run++)
        survey_anew(run);
    sql("delete from runways");
    reopen();
    for (int run = 1; run <= 3; run++)
        begin_on(run, run > 1);
    assert_int_equal(store_advice_add(session.store, &advice, &session.error), MR_OK);
    load(&record);
    assert_int_equal(record.row[2].first_run_on_runway, STORE_NONE);
    assert_string_equal(outcome_record_format_advice(&record.row[1], text), "against, followed");
    assert_string_equal(outcome_record_format_advice(&record.row[2], text), "none");
    outcome_record_free(&record);
    sql("update landings set board_uid = substr(board_uid, 1, 8) || '" MR_EMULATED_LOT_TEXT
        "' || substr(board_uid, 15)");
    load(&record);
    assert_int_equal(record.row[1].first_run_on_runway, STORE_NONE);
    assert_int_equal(record.row[2].first_run_on_runway, 2);
    assert_string_equal(outcome_record_format_advice(&record.row[2], text), "against, followed");
    assert_int_equal(record.off_plan_count, 2);
    outcome_record_free(&record);
    session_end(&session);
}

TEST(a_lead_time_has_no_negative_zero)
{
    struct outcome_record_row row = {.warning_outcome = WARNING_LATE,
                                     .lead_time_s = -0.04,
                                     .lead_time_low_s = -0.8,
                                     .lead_time_high_s = -0.01};
    char text[OUTCOME_TEXT_SIZE], lead[OUTCOME_LEAD_TIME_SIZE];
    assert_string_equal(outcome_record_format_lead_time(&row, true, lead), "0.0 (-0.8 to 0.0)");
    assert_string_equal(
        outcome_record_format_outcome(&row, text),
        "warned, but too late, lead time about 0.0 s (75 % interval: -0.8 to 0.0 s)");
    row.lead_time_high_s = (double)NAN;
    assert_string_equal(outcome_record_format_lead_time(&row, true, lead), "0.0 (-0.8 or more)");
    assert_string_equal(outcome_record_format_lead_time(&row, false, lead),
                        "0.0 s (75 % interval: -0.8 s or more)");
    row.lead_time_s = (double)NAN;
    assert_string_equal(outcome_record_format_lead_time(&row, true, lead), "-");
    assert_string_equal(outcome_record_format_outcome(&row, text), "warned, but too late");
}
