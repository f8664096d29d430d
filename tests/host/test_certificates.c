/* Certificates: which one holds, until when, and the verdict of matrig ready. Days are compared
 * with GNU date (date -u -d 2026-03-02 +%s). */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/board/certificates.h"
#include "host/board/ready.h"
#include "host/store/store_readiness.h"
#include "host/store/table.h"
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
                                      .coverage_factor = 2.0};
}

TEST(a_certificate_holds_through_its_due_day)
{
    const struct mr_channel_config channel = {.serial = "ET-17"};
    struct store_certificate c = sound();
    assert_int_equal(certificates_check_state(&c, &channel, 1772409599), CERTIFICATE_VALID);
    assert_int_equal(certificates_check_state(&c, &channel, 1772409600), CERTIFICATE_OVERDUE);
    c.due_day = STORE_NONE;
    assert_int_equal(certificates_check_state(&c, &channel, 4102444800), CERTIFICATE_VALID);
}

TEST(a_certificate_is_of_its_sensor)
{
    struct store_certificate c = sound();
    struct mr_channel_config channel = {.serial = "ET-17"};
    assert_int_equal(certificates_check_state(&c, &channel, 1772409599), CERTIFICATE_VALID);
    memcpy(channel.serial, "ET-18", 5);
    assert_int_equal(certificates_check_state(&c, &channel, 1772409599), CERTIFICATE_OTHER_SENSOR);
    memset(channel.serial, 0, sizeof channel.serial); /* the board does not say */
    assert_int_equal(certificates_check_state(&c, &channel, 1772409599), CERTIFICATE_VALID);
    memcpy(channel.serial, "123456789012", 12); /* fills its room, without an end */
    memcpy(c.sensor, "123456789012", 13);
    assert_int_equal(certificates_check_state(&c, &channel, 1772409599), CERTIFICATE_VALID);
}

TEST(an_uncertainty_is_absolute_or_relative)
{
    struct store_certificate c = sound();
    assert_near(certificates_compute_uncertainty(&c, -1.5), 0.003, 1e-12); /* 0.4 % of 1.5 over 2 */
    c.expanded = 0.01;
    assert_near(certificates_compute_uncertainty(&c, -1.5), 0.005, 1e-12);
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
    return now.is_known[2] ? now.certificate[2].number : "";
}

static void enter(const char *number)
{
    struct store_certificate c = sound();
    snprintf(c.number, sizeof c.number, "%s", number);
    store_certificate_add(store, &c, &error);
    assert_no_error(&error);
}

TEST(the_one_entered_last_holds)
{
    begin("certificates.db");
    assert_string_equal(number_that_holds(), "");
    enter("C-1");
    enter("C-2");
    assert_string_equal(number_that_holds(), "C-2");
    store_close(store);
}

TEST(what_a_person_writes_is_read_or_refused)
{
    static const char good[] = "number=C-1, laboratory=Metrology Lab, calibrated=2026-01-01, "
                               "due=2026-03-01, uncertainty=0.05mm, coverage=2";
    struct store_certificate row = {.index = 2};
    error = (struct error){0};
    certificates_parse(good, &row, &error);
    assert_no_error(&error);
    assert_string_equal(row.laboratory, "Metrology Lab");
    assert_int_equal(row.calibrated_day, JAN_1);
    assert_int_equal(row.due_day, MARCH_1);
    assert_near(row.expanded, 0.05 / 25.4, 1e-9);
    assert_true(isnan(row.expanded_rel));
    row.index = 9; /* a gage: 4.448 N are a pound */
    certificates_parse("number=C-2,calibrated=2026-01-01,due=never,uncertainty=4.4482216 N,"
                       "coverage=1.96",
                       &row, &error);
    assert_no_error(&error);
    assert_near(row.expanded, 1.0, 1e-6);
    assert_near(row.coverage_factor, 1.96, 1e-12);
    assert_true(row.due_day == STORE_NONE);
    static const char *const wrong[][2] = {
        {"calibrated=2026-01-01", "calibrated=2026-13-01"},
        {"calibrated=2026-01-01", "calibrated=2226-01-01"},
        {"due=2026-03-01", "due=2026-02-29"},
        {"due=2026-03-01", "due=2025-12-31"},
        {"uncertainty=0.05mm", "uncertainty=5 lb"},
        {"uncertainty=0.05mm", "uncertainty=0"},
        {"uncertainty=0.05mm", "uncertainty=0.4mm%"},
        {"uncertainty=0.05mm", "uncertainty=0.4%%"},
        {"coverage=2", "coverage=two"},
        {"coverage=2", "coverage=9"},
        {"number=C-1", "number="},
        {"number=C-1", "note=C-1"},
        {"number=C-1, ", ""},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        char text[300];
        const char *at = strstr(good, wrong[i][0]);
        snprintf(text, sizeof text, "%.*s%s%s", (int)(at - good), good, wrong[i][1],
                 at + strlen(wrong[i][0]));
        row.index = 2;
        error = (struct error){0};
        assert_int_equal(certificates_parse(text, &row, &error), MR_USAGE);
    }
}

TEST(history_stays)
{
    begin("history.db");
    enter("C-1");
    assert_int_equal(
        sqlite3_exec(store->database, "UPDATE certificates SET due_day=30000", NULL, NULL, NULL),
        SQLITE_CONSTRAINT);
    assert_int_equal(sqlite3_exec(store->database, "DELETE FROM certificates", NULL, NULL, NULL),
                     SQLITE_CONSTRAINT);
    store_close(store);
}

/* ---- ready ---- */

static struct ready_inputs f;
static struct ready_report report;

static void judge(int64_t now_s)
{
    memset(&report, 0, sizeof report);
    f.now_s = now_s;
    ready_check_certificates(&f, &report);
}

static void says(unsigned i, enum ready_verdict verdict, const char *name, const char *value)
{
    assert_true(i < report.count);
    assert_int_equal(report.check[i].verdict, verdict);
    assert_string_equal(report.check[i].name, name);
    assert_string_equal(report.check[i].value, value);
    assert_int_equal(report.check[i].advice[0] != '\0', verdict == READY_NO_GO);
}

TEST(what_is_overdue_stops_ready)
{
    memset(&f, 0, sizeof f);
    f.config.channel[2].kind = MR_KIND_DISPLACEMENT;
    f.config.channel[9].kind = MR_KIND_TENSION;
    judge(1772409599);
    assert_int_equal(report.count, 1); /* campaigns without certificates go on */
    says(0, READY_NOT_DONE, "certificates", "no certificate for any sensor");
    f.certificates.is_known[2] = true;
    f.certificates.certificate[2] = sound();
    judge(1772409599);
    assert_int_equal(report.count, 2);
    says(0, READY_GO, "certificate d3", "valid until 2026-03-01: No. C-1, Lab");
    says(1, READY_NOT_DONE, "certificates", "no certificate for t2");
    assert_int_equal(ready_verdict(&report), READY_GO);
    judge(1772409600);
    says(0, READY_NO_GO, "certificate d3", "overdue since 2026-03-02: No. C-1, Lab");
    assert_int_equal(ready_verdict(&report), READY_NO_GO);
    f.config.channel[2].kind = MR_KIND_NONE; /* not used: its certificate does not matter */
    judge(1772409600);
    assert_int_equal(report.count, 1);
}
