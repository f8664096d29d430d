/* Files of points: units of the first line and of each value; columns by their names; what is
 * refused. Factors by definition: 25.4 mm in an inch, 4.4482216152605 N in a pound,
 * 9.80665 N in a kilogram. */
#include <math.h>
#include <string.h>

#include "host/calibrate/jump.h"
#include "host/calibrate/points.h"
#include "tests/host/scratch.h"

static struct calibrate_points points;
static struct error error;

static enum mr_status read_as(const char *text, enum unit_kind kind)
{
    char path[80];
    scratch_write(scratch_path(path, sizeof path, "calibration_points.csv"), text, strlen(text));
    error = (struct error){0};
    return calibrate_points_read(path, kind, &points, &error);
}

static void is_read(const char *text, enum unit_kind kind, double value, double code)
{
    if (read_as(text, kind) != MR_OK)
        fail_msg("%s: %s", text, error.text);
    if (points.count != 1 || fabs(points.point[0].value - value) > 1e-12 * fabs(value) ||
        points.point[0].code != code)
        fail_msg("%s: %zu points, %.15g, %.15g", text, points.count, points.point[0].value,
                 points.point[0].code);
}

static void is_refused(const char *text, enum unit_kind kind, enum mr_status status,
                       const char *words)
{
    if (read_as(text, kind) != status || !strstr(error.text, words))
        fail_msg("%s: status %d: %s", text, (int)error.status, error.text);
}

TEST(units_of_the_first_line)
{
    is_read("in,codes\n2,700\n", UNIT_DISPLACEMENT, 2.0, 700.0);
    is_read("mm,codes\n12.7,372.4\n", UNIT_DISPLACEMENT, 0.5, 372.4);
    is_read("cm,codes\n2.54,700\n", UNIT_DISPLACEMENT, 1.0, 700.0);
    is_read("m,codes\n0.0254,700\n", UNIT_DISPLACEMENT, 1.0, 700.0);
    is_read("ft,codes\n0.5,700\n", UNIT_DISPLACEMENT, 6.0, 700.0);
    is_read("lb,codes\n40,700\n", UNIT_TENSION, 40.0, 700.0);
    is_read("N,codes\n4.4482216152605,700\n", UNIT_TENSION, 1.0, 700.0);
    is_read("kN,codes\n0.44482216152605,700\n", UNIT_TENSION, 100.0, 700.0);
    is_read("kg,codes\n10,700\n", UNIT_TENSION, 10.0 * 9.80665 / 4.4482216152605, 700.0);
    is_read("kgf,codes\n10,700\n", UNIT_TENSION, 10.0 * 9.80665 / 4.4482216152605, 700.0);
}

TEST(as_people_and_programs_write_it)
{
    static const char *const names[] = {
        "displacement (mm),codes", "MM , Codes",
        "\xef\xbb\xbfmm,codes",    "# a comment, with a comma\n\nmm,codes",
        "millimetres,code\r",      "Dial [mm], counts"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char text[120];
        snprintf(text, sizeof text, "%s\n 12.7 , 372.4 \r\n", names[i]);
        is_read(text, UNIT_DISPLACEMENT, 0.5, 372.4);
    }
    is_read("codes,mm\n372.4,12.7\n", UNIT_DISPLACEMENT, 0.5, 372.4);
    assert_true(points.are_codes_first);
    is_read("in,codes\n12.7 mm,372.4\n", UNIT_DISPLACEMENT, 0.5, 372.4);
    is_read("value,codes\n12.7mm,372.4\n", UNIT_DISPLACEMENT, 0.5, 372.4);
}

/* A spreadsheet quotes cells, and leaves empty columns and rows. */
TEST(as_a_spreadsheet_writes_it)
{
    is_read("\"mm\",\"codes\"\r\n\"12.7\",\"372.4\"\r\n", UNIT_DISPLACEMENT, 0.5, 372.4);
    is_read("mm,codes,,\n12.7,372.4,,\n,,,\n", UNIT_DISPLACEMENT, 0.5, 372.4);
    is_refused("in\tcodes\n1\t2\n", UNIT_DISPLACEMENT, MR_MALFORMED, "separated by tabs");
    is_refused("in,codes\n\"0,5\",\"372,4\"\n", UNIT_DISPLACEMENT, MR_MALFORMED,
               "a comma in a number");
    is_refused("in,codes\n0,5,372,4\n", UNIT_DISPLACEMENT, MR_MALFORMED, "more than two columns");
    is_refused("in,codes\n1,\"1,682.6\"\n", UNIT_DISPLACEMENT, MR_MALFORMED, "a comma in a number");
}

/* A name is read wholly or not at all: a unit that matrig does not know, or one that something
 * scales, is not passed over. */
TEST(what_is_not_understood_is_refused)
{
    static const char *const odd[] = {"daN",        "kip",       "load (daN)",    "load (lb) daN",
                                      "kip (lb)",   "10 lb",     "tenths (lb)",   "load (lb/10)",
                                      "lb x10",     "lb (0.1)",  "load lb",       "lb/2",
                                      "load (-lb)", "load (lb]", "load (lb",      "%",
                                      "Kraft",      "in lb",     "\xc2\xbd (lb)", ""};
    for (size_t i = 0; i < COUNT_OF(odd); i++) {
        char text[120];
        snprintf(text, sizeof text, "%s,codes\n40,700\n", odd[i]);
        is_refused(text, UNIT_TENSION, MR_MALFORMED, "the first line has no column names");
        assert_non_null(strstr(error.text, ", line 1; name the columns: N,codes"));
    }
    is_refused("codes,raw\n1,2\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 1");
    is_refused("mm,in\n1,2\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 1");
    is_refused("mm,mV\n1,2\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 1");
    is_refused("mm,codes,noise\n1,2\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 1");
    is_refused("12.7,372.4\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 1");
    is_refused("lb,codes\n12.7,372.4\n", UNIT_DISPLACEMENT, MR_MALFORMED,
               "m or ft for a transducer");
    is_refused("mm,codes\n12.7,372.4\n", UNIT_TENSION, MR_MALFORMED, "kN or kg for a gage");
    is_refused("value,codes\n12.7,372.4\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 2");
    is_refused("in,codes\n5 lb,372.4\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 2");
    is_refused("in,codes\n5 furlong,372.4\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 2");
    is_refused("in,codes\n5 mm mm,372.4\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 2");
    is_refused("mm,codes\nmm,codes\n1,2\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 2");
    is_refused("mm,codes\n1,nan\n", UNIT_DISPLACEMENT, MR_MALFORMED, "line 2");
    char text[400]; /* its end is no row of its own */
    snprintf(text, sizeof text, "mm,codes\n1,2%300s3,4\n", "");
    is_refused(text, UNIT_DISPLACEMENT, MR_MALFORMED, "too long: ");
}

TEST(a_mistake_is_named)
{
    static const struct {
        uint8_t kind;
        double gain;
        const char *text;
    } mistake[] = {{MR_KIND_DISPLACEMENT, 0.0409, "the unit of the values may have been mm"},
                   {MR_KIND_DISPLACEMENT, 620.0, "columns may be swapped"},
                   {MR_KIND_DISPLACEMENT, 0.000134, "the unit of the values may have been ft"},
                   {MR_KIND_TENSION, 0.7168, "the unit of the values may have been N"},
                   {MR_KIND_TENSION, 0.000717, "the unit of the values may have been kN"},
                   {MR_KIND_TENSION, 6.2, "columns may be swapped"},
                   {MR_KIND_DISPLACEMENT, 0.0016, ""},
                   {MR_KIND_TENSION, 1e-9, ""}};
    for (size_t i = 0; i < sizeof mistake / sizeof mistake[0]; i++) {
        const struct mr_channel_config c = {.kind = mistake[i].kind,
                                            .unit_per_code = (float)mistake[i].gain};
        char text[80];
        jump_write_mistake_hint(&c, text, sizeof text);
        if (mistake[i].text[0] ? !strstr(text, mistake[i].text) : text[0] != '\0')
            fail_msg("%g: %s", mistake[i].gain, text);
    }
}
