/* Certificates: which one holds, until when, and what matrig ready says. Dates are held against
 * moments that GNU date gave (date -u -d 2026-03-01T10:00:00Z +%s), factors against tables of the
 * normal distribution. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/board/certificates.h"
#include "host/board/ready_parts.h"
#include "host/store/store_sql.h"
#include "tests/host/scratch.h"

#define MARCH_1 20513 /* 2026-03-01: 1772323200 / 86400 */
#define JAN_1   20454

static struct store_certificate sound(void)
{
    return (struct store_certificate){.index = 2,
                                      .board_uid = "00",
                                      .number = "C-1",
                                      .laboratory = "Lab",
                                      .sensor = "ET-17",
                                      .calibrated_day = JAN_1,
                                      .due_day = MARCH_1,
                                      .expanded = (double)NAN,
                                      .expanded_rel = 0.004,
                                      .coverage_factor = 2.0,
                                      .coverage_percent = (double)NAN,
                                      .withdraws = STORE_NONE};
}

/* 2026-03-01 ends first where clocks are 14 h ahead, at 10:00 UTC of it, and last where they are
 * 12 h behind, at 12:00 UTC of the day after. */
static void the_due_day_is_over_when_it_is_over_everywhere(void **state)
{
    (void)state;
    static const struct {
        int64_t now_s;
        enum certificate_state state;
    } moment[] = {
        {1772359199, CERTIFICATE_VALID},   /* 2026-03-01T09:59:59Z */
        {1772359200, CERTIFICATE_DUE_NOW}, /* 2026-03-01T10:00:00Z */
        {1772452799, CERTIFICATE_DUE_NOW}, /* 2026-03-02T11:59:59Z */
        {1772452800, CERTIFICATE_OVERDUE}, /* 2026-03-02T12:00:00Z */
        {1767175200, CERTIFICATE_VALID},   /* 2025-12-31T10:00:00Z: calibrated today, somewhere */
        {1767175199, CERTIFICATE_AHEAD},
    };
    struct store_certificate c = sound();
    static const char *const zone[] = {"UTC", "Pacific/Kiritimati", "Etc/GMT+12",
                                       "America/Chicago"};
    for (size_t z = 0; z < sizeof zone / sizeof zone[0]; z++) {
        setenv("TZ", zone[z], 1);
        tzset();
        for (size_t i = 0; i < sizeof moment / sizeof moment[0]; i++)
            assert_int_equal(certificates_state(&c, NULL, moment[i].now_s), moment[i].state);
    }
    c.due_day = STORE_NONE;
    assert_int_equal(certificates_state(&c, NULL, 4102444800), CERTIFICATE_VALID);
}

static void a_certificate_is_of_its_sensor(void **state)
{
    (void)state;
    struct store_certificate c = sound();
    struct mr_channel_config channel = {.serial = "ET-17"};
    assert_int_equal(certificates_state(&c, &channel, 1772359199), CERTIFICATE_VALID);
    memcpy(channel.serial, "ET-18", 5);
    assert_int_equal(certificates_state(&c, &channel, 1772359199), CERTIFICATE_ANOTHER);
    memset(channel.serial, 0, sizeof channel.serial); /* the board does not say */
    assert_int_equal(certificates_state(&c, &channel, 1772359199), CERTIFICATE_VALID);
    memcpy(channel.serial, "123456789012", 12); /* fills its room, without an end */
    memcpy(c.sensor, "123456789012", 13);
    assert_int_equal(certificates_state(&c, &channel, 1772359199), CERTIFICATE_VALID);
}

static void a_probability_is_a_factor(void **state)
{
    (void)state;
    assert_near(certificates_factor(95.0), 1.959964, 1e-6);
    assert_near(certificates_factor(68.27), 1.0, 1e-3);
    assert_near(certificates_factor(95.45), 2.0, 1e-3); /* GUM, table G.1 */
    assert_near(certificates_factor(99.0), 2.575829, 1e-6);
    struct store_certificate c = sound();
    assert_near(certificates_standard(&c, -1.5), 0.003, 1e-12); /* 0.4 % of 1.5 over 2 */
    c.expanded = 0.01;
    assert_near(certificates_standard(&c, -1.5), 0.005, 1e-12);
}

/* ---- in a campaign ---- */

static struct store *store;
static struct error error;

static void begin(const char *name)
{
    char path[200];
    error = (struct error){0};
    store_open(scratch_path(path, sizeof path, name), STORE_CREATE, &store, &error);
    assert_no_error(&error);
}

static const char *number_that_holds(void)
{
    static struct certificates now;
    certificates_read(store, "00", &now, &error);
    assert_no_error(&error);
    return now.known[2] ? now.of[2].number : "";
}

static void enter(const char *number, int64_t calibrated_day, double expanded_rel)
{
    struct store_certificate c = sound();
    snprintf(c.number, sizeof c.number, "%s", number);
    c.calibrated_day = calibrated_day;
    c.expanded_rel = expanded_rel;
    store_certificate_add(store, &c, &error);
    assert_no_error(&error);
}

static void the_one_calibrated_last_holds(void **state)
{
    (void)state;
    struct store_certificate *rows;
    size_t count;
    begin("certificates.db");
    assert_string_equal(number_that_holds(), "");
    enter("C-2", JAN_1, 0.004);
    enter("C-1", JAN_1 - 365, 0.004); /* entered afterwards */
    assert_string_equal(number_that_holds(), "C-2");
    enter("C-2", JAN_1, 0.005); /* a correction */
    store_certificates(store, "00", &rows, &count, &error);
    assert_int_equal(count, 3); /* and nothing is lost */
    assert_true(rows[0].gone && !rows[1].gone && !rows[2].gone);
    assert_near(rows[0].expanded_rel, 0.004, 1e-12);
    int64_t corrected = rows[2].id;
    free(rows);
    store_certificate_withdraw(store, corrected, 1, "me", "typed wrongly", &error);
    assert_no_error(&error);
    store_certificates(store, "00", &rows, &count, &error);
    assert_int_equal(count, 4);
    assert_true(!rows[0].gone && rows[2].gone); /* what it stood in place of is back */
    free(rows);
    assert_int_equal(store_certificate_withdraw(store, corrected, 1, "me", "again", &error),
                     MR_UNKNOWN);
    store_close(store);
}

static void history_stays(void **state)
{
    (void)state;
    begin("history.db");
    enter("C-1", JAN_1, 0.004);
    assert_int_equal(
        sqlite3_exec(store->database, "UPDATE certificates SET due_day=30000", NULL, NULL, NULL),
        SQLITE_CONSTRAINT);
    assert_int_equal(sqlite3_exec(store->database, "DELETE FROM certificates", NULL, NULL, NULL),
                     SQLITE_CONSTRAINT);
    store_close(store);
}

/* ---- ready ---- */

static struct ready_facts f;
static struct ready_report report;

static void judge(int64_t now_s)
{
    memset(&report, 0, sizeof report);
    f.now_s = now_s;
    ready_judge_certificates(&f, &report);
}

static void says(unsigned i, enum ready_verdict verdict, const char *name, const char *value)
{
    assert_true(i < report.count);
    assert_int_equal(report.check[i].verdict, verdict);
    assert_string_equal(report.check[i].name, name);
    assert_string_equal(report.check[i].value, value);
    assert_int_equal(report.check[i].advice[0] != '\0',
                     verdict == READY_NO_GO || verdict == READY_NOT_DONE);
}

static void what_is_overdue_stops_ready(void **state)
{
    (void)state;
    memset(&f, 0, sizeof f);
    f.config.channel[2].kind = MR_KIND_DISPLACEMENT;
    f.config.channel[9].kind = MR_KIND_TENSION;
    judge(1772359199);
    assert_int_equal(report.count, 1); /* campaigns without certificates go on */
    says(0, READY_TOLD, "certificates", "none is entered of any sensor");
    f.certificates.known[2] = true;
    f.certificates.of[2] = sound();
    judge(1772359199);
    assert_int_equal(report.count, 2);
    says(0, READY_GO, "certificate d3", "valid until 2026-03-01: No. C-1, Lab");
    says(1, READY_TOLD, "certificates", "none is entered of t2");
    assert_int_equal(ready_verdict(&report), READY_GO);
    judge(1772359200);
    says(0, READY_NOT_DONE, "certificate d3",
         "valid until 2026-03-01, which is today or was yesterday: No. C-1, Lab");
    judge(1772452800);
    says(0, READY_NO_GO, "certificate d3", "overdue since 2026-03-02: No. C-1, Lab");
    assert_int_equal(ready_verdict(&report), READY_NO_GO);
    f.config.channel[2].kind = MR_KIND_NONE; /* not used: its certificate does not matter */
    judge(1772452800);
    assert_int_equal(report.count, 1);
}

static void a_campaign_may_require_them(void **state)
{
    (void)state;
    memset(&f, 0, sizeof f);
    f.config.channel[9].kind = MR_KIND_TENSION;
    begin("required.db");
    store_certificates_demand(store, true, 1, "me", &error);
    assert_no_error(&error);
    certificates_read(store, "00", &f.certificates, &error);
    judge(1772359199);
    says(0, READY_NO_GO, "certificates",
         "none is entered of any sensor, and this campaign requires them");
    store_certificates_demand(store, false, 2, "me", &error);
    certificates_read(store, "00", &f.certificates, &error);
    assert_no_error(&error);
    judge(1772359199);
    says(0, READY_TOLD, "certificates", "none is entered of any sensor");
    store_close(store);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_due_day_is_over_when_it_is_over_everywhere),
        cmocka_unit_test(a_certificate_is_of_its_sensor),
        cmocka_unit_test(a_probability_is_a_factor),
        cmocka_unit_test(the_one_calibrated_last_holds),
        cmocka_unit_test(history_stays),
        cmocka_unit_test(what_is_overdue_stops_ready),
        cmocka_unit_test(a_campaign_may_require_them),
    };
    return cmocka_run_group_tests_name("host/certificates", tests, NULL, NULL);
}
