/* Files of points: units of the first line, of each value and of the caller; columns by their
 * names; what is refused. Factors by definition: 25.4 mm in an inch, 4.4482216152605 N in a pound,
 * 9.80665 N in a kilogram. */
#include <math.h>
#include <string.h>

#include "host/calibrate/mistake.h"
#include "host/calibrate/points.h"
#include "tests/host/scratch.h"

static struct calibrate_points points;
static struct error error;

static enum mr_status read_as(const char *text, enum unit_kind kind, const char *given)
{
    char path[80];
    const struct unit_word *unit = given ? unit_read(given, strlen(given)) : NULL;
    scratch_write(scratch_path(path, sizeof path, "calibration_points.csv"), text, strlen(text));
    error = (struct error){0};
    return calibrate_points_read(path, kind, unit, &points, &error);
}

static void is_read(const char *text, enum unit_kind kind, const char *given, double value,
                    double code)
{
    if (read_as(text, kind, given) != MR_OK)
        fail_msg("%s: %s", text, error.text);
    if (points.count != 1 || fabs(points.point[0].value - value) > 1e-12 * fabs(value) ||
        points.point[0].code != code)
        fail_msg("%s: %zu points, %.15g, %.15g", text, points.count, points.point[0].value,
                 points.point[0].code);
}

static void is_refused(const char *text, enum unit_kind kind, const char *given,
                       enum mr_status status, const char *words)
{
    if (read_as(text, kind, given) != status || !strstr(error.text, words))
        fail_msg("%s: status %d: %s", text, (int)error.status, error.text);
}

static void units_of_the_first_line(void **state)
{
    (void)state;
    is_read("in,codes\n2,700\n", UNIT_DISPLACEMENT, NULL, 2.0, 700.0);
    is_read("mm,codes\n12.7,372.4\n", UNIT_DISPLACEMENT, NULL, 0.5, 372.4);
    is_read("cm,codes\n2.54,700\n", UNIT_DISPLACEMENT, NULL, 1.0, 700.0);
    is_read("m,codes\n0.0254,700\n", UNIT_DISPLACEMENT, NULL, 1.0, 700.0);
    is_read("ft,codes\n0.5,700\n", UNIT_DISPLACEMENT, NULL, 6.0, 700.0);
    is_read("lb,codes\n40,700\n", UNIT_TENSION, NULL, 40.0, 700.0);
    is_read("N,codes\n4.4482216152605,700\n", UNIT_TENSION, NULL, 1.0, 700.0);
    is_read("kN,codes\n0.44482216152605,700\n", UNIT_TENSION, NULL, 100.0, 700.0);
    is_read("kg,codes\n10,700\n", UNIT_TENSION, NULL, 10.0 * 9.80665 / 4.4482216152605, 700.0);
    is_read("kgf,codes\n10,700\n", UNIT_TENSION, NULL, 10.0 * 9.80665 / 4.4482216152605, 700.0);
}

static void as_people_and_programs_write_it(void **state)
{
    (void)state;
    static const char *const names[] = {"displacement (mm),codes",
                                        "\"Weg [mm]\",\"ADC counts\"",
                                        "d3_mm,raw",
                                        "MM , Codes",
                                        "value in mm,reading",
                                        "\xef\xbb\xbfmm,codes",
                                        "# a comment, with a comma\n\nmm,codes",
                                        "millimetres,code\r",
                                        "displacement [mm],ADC code",
                                        "Weg in mm,codes",
                                        "Weg in [mm],codes",
                                        "x_mm,code",
                                        "true value (mm), counts",
                                        "mm of travel,ADC-counts",
                                        "Messuhr Nr. [mm],Anzeige counts",
                                        "ch3 mm,adc3",
                                        "pos. mm,code",
                                        "'mm','codes'",
                                        "displacement - mm,codes",
                                        "Gr\xc3\xb6\xc3\x9f"
                                        "e [mm],codes",
                                        "Gr\xf6\xdf"
                                        "e [mm],codes",
                                        "mm,reading in codes",
                                        "reference_value_mm,raw_code",
                                        "value (mm),value (codes)",
                                        "Weg [in mm],codes"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        char text[120];
        snprintf(text, sizeof text, "%s\n 12.7 , 372.4 \r\n", names[i]);
        is_read(text, UNIT_DISPLACEMENT, NULL, 0.5, 372.4);
    }
    is_read("displacement (in),codes\n2,700\n", UNIT_DISPLACEMENT, NULL, 2.0, 700.0);
    is_read("displacement in in,codes\n2,700\n", UNIT_DISPLACEMENT, NULL, 2.0, 700.0);
    is_read("true in,codes\n2,700\n", UNIT_DISPLACEMENT, NULL, 2.0, 700.0);
    is_read("Load (lb), counts\n40,700\n", UNIT_TENSION, NULL, 40.0, 700.0);
    is_read("load cell in N,counts\n4.4482216152605,700\n", UNIT_TENSION, NULL, 1.0, 700.0);
    /* its first row is no name */
    is_read("\xef\xbb\xbf"
            "12.7 mm,372.4",
            UNIT_DISPLACEMENT, NULL, 0.5, 372.4);
}

static void columns_by_their_names(void **state)
{
    (void)state;
    is_read("codes,mm\n372.4,12.7\n", UNIT_DISPLACEMENT, NULL, 0.5, 372.4);
    assert_true(points.codes_first);
    is_read("reading,mm\n372.4,12.7\n", UNIT_DISPLACEMENT, NULL, 0.5, 372.4);
    is_read("raw,known value\n372.4,12.7\n", UNIT_DISPLACEMENT, "mm", 0.5, 372.4);
    is_refused("codes,raw\n1,2\n", UNIT_DISPLACEMENT, "mm", MR_MALFORMED, "two columns of codes");
    is_refused("mm,in\n1,2\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED, "more than one unit");
    is_refused("mm,mV\n1,2\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED, "volts");
    is_refused("mm,codes,noise\n1,2\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED,
               "more than two columns");
}

static void a_value_has_its_own_unit(void **state)
{
    (void)state;
    is_read("in,codes\n12.7 mm,372.4\n", UNIT_DISPLACEMENT, NULL, 0.5, 372.4);
    is_read("12.7mm,372.4\n", UNIT_DISPLACEMENT, NULL, 0.5, 372.4);
    is_read("12.7,372.4\n", UNIT_DISPLACEMENT, "mm", 0.5, 372.4);
    is_read("value,codes\n12.7,372.4\n", UNIT_DISPLACEMENT, "mm", 0.5, 372.4);
    is_refused("in,codes\n5 lb,372.4\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED, "line 2");
    is_refused("in,codes\n5 furlong,372.4\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED, "line 2");
    is_refused("in,codes\n5 mm mm,372.4\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED, "line 2");
}

/* What the first line says is read wholly or not at all: a unit that matrig does not know, or one
 * that something scales, is neither passed over nor overruled by --unit. */
static void what_is_not_understood_is_refused(void **state)
{
    (void)state;
    static const struct {
        const char *name, *odd;
    } tension[] = {{"daN", "daN"},
                   {"kip", "kip"},
                   {"load in daN", "daN"},
                   {"load (daN)", "daN"},
                   {"load (lb) daN", "daN"},
                   {"load lb (gross)", "gross"},
                   {"kip (lb)", "kip"},
                   {"10 lb", NULL},
                   {"lb x", "x"},
                   {"kilo lb", "kilo"},
                   {"k (lb)", "k"},
                   {"lb/2", "/"},
                   {"%", "%"},
                   {"Kraft", "Kraft"}},
      displacement[] = {{"inch/2", "/"},
                        {"half inches", "half"},
                        {"in (0.1)", "0"},
                        {"mm/10", "/"},
                        {"x10 mm", "x10"},
                        {"thou", "thou"},
                        {"mm*10", "*"},
                        {"mm^2", "^"},
                        {"probe 3 mm", "3"},
                        {"value 3 mm", "3"},
                        {"d9 mm", "d9"},
                        {"ch3x10 mm", "ch3"},
                        {"mm (tenths)", "tenths"},
                        {"hundredths of mm", "hundredths"},
                        {"tenths [mm]", "tenths"},
                        {"Taster mm", "Taster"},
                        {"Weg in", "Weg"},
                        {"um", "um"},
                        {"\xc2\xb5m", "\xc2\xb5m"},
                        {"\xc2\xbd [mm]", "\xc2\xbd"},
                        {"\xbd [mm]", "\xbd"},
                        {"\xc3\x97 mm", "\xc3\x97"},
                        {"-mm", "-"},
                        {"value (-mm)", "-"},
                        {"mm\"", "\""},
                        {"value [mm", "["},
                        {"value mm]", "]"},
                        {"value in Zehntel mm", "Zehntel"},
                        {"mm per turn", "per"}};
    static const char *const unit[] = {NULL, "lb", "mm"};
    for (size_t i = 0; i < COUNT_OF(tension); i++) {
        char text[120], says[60] = "line 1";
        snprintf(text, sizeof text, "%s,codes\n40,700\n", tension[i].name);
        if (tension[i].odd)
            snprintf(says, sizeof says, "what says '%s' in a column's name?: ", tension[i].odd);
        for (size_t u = 0; u < 2; u++)
            is_refused(text, UNIT_TENSION, unit[u], MR_MALFORMED, says);
        assert_non_null(strstr(error.text, ", line 1; "));
    }
    for (size_t i = 0; i < COUNT_OF(displacement); i++) {
        char text[120], says[60];
        snprintf(text, sizeof text, "%s,codes\n12.7,700\n", displacement[i].name);
        snprintf(says, sizeof says, "what says '%s' in a column's name?: ", displacement[i].odd);
        for (size_t u = 0; u < 3; u += 2)
            is_refused(text, UNIT_DISPLACEMENT, unit[u], MR_MALFORMED, says);
        assert_non_null(
            strstr(error.text, "name it VALUE or by its unit alone (in, mm, cm, m, ft)"));
    }
    is_refused("1/10 mm,codes\n12.7,700\n", UNIT_DISPLACEMENT, "mm", MR_MALFORMED, "line 1");
    is_refused("mm,codes/16\n12.7,700\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED, "what says '/'");
    is_refused("mm,kilo counts\n12.7,700\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED,
               "what says 'kilo'");
    is_refused("mm,Anzeige\n12.7,700\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED,
               "what says 'Anzeige'");
    /* a torque */
    is_refused("in lb,codes\n40,700\n", UNIT_TENSION, NULL, MR_MALFORMED, "more than one unit");
    is_refused("N mm,codes\n40,700\n", UNIT_TENSION, NULL, MR_MALFORMED, "more than one unit");
    is_refused("mm codes,codes\n40,700\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED,
               "two columns of codes");
    is_refused("mm counts,value\n40,700\n", UNIT_DISPLACEMENT, "mm", MR_MALFORMED,
               "more than one unit");
}

/* A number of which nobody knows the unit is no number. */
static void without_a_unit_it_is_refused(void **state)
{
    (void)state;
    static const char *const texts[] = {"12.7,372.4\n", "value,codes\n12.7,372.4\n",
                                        "1 mm,20\n12.7,372.4\n"};
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++)
        is_refused(texts[i], UNIT_DISPLACEMENT, NULL, MR_USAGE, "in which unit");
    is_refused("mm,codes\n12.7,372.4\n", UNIT_DISPLACEMENT, "in", MR_USAGE, "which one is right");
    is_refused("lb,codes\n12.7,372.4\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED,
               "a transducer is calibrated in");
    is_refused("mm,codes\n12.7,372.4\n", UNIT_TENSION, NULL, MR_MALFORMED,
               "a gage is calibrated in");
    /* what is wrong with a line comes first */
    is_refused("1,2\n3,x\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED, "line 2");
    is_refused("mm,codes\nmm,codes\n1,2\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED, "line 2");
    is_refused("mm,codes\n1,nan\n", UNIT_DISPLACEMENT, NULL, MR_MALFORMED, "line 2");
    is_refused("x1,2\n", UNIT_DISPLACEMENT, "mm", MR_MALFORMED, "line 1");
    char text[400]; /* its end is no row of its own */
    snprintf(text, sizeof text, "mm,codes\n1,2%300s3,4\n", "");
    is_refused(text, UNIT_DISPLACEMENT, NULL, MR_MALFORMED, "too long: ");
}

static void a_mistake_is_named(void **state)
{
    (void)state;
    static const struct {
        uint8_t kind;
        double gain;
        const char *text;
    } mistake[] = {{MR_KIND_DISPLACEMENT, 0.0409, "were the values mm?"},
                   {MR_KIND_DISPLACEMENT, 620.0, "columns swapped"},
                   {MR_KIND_DISPLACEMENT, 0.000134, "were the values ft?"},
                   {MR_KIND_TENSION, 0.7168, "were the values N?"},
                   {MR_KIND_TENSION, 0.000717, "were the values kN?"},
                   {MR_KIND_TENSION, 6.2, "columns swapped"},
                   {MR_KIND_DISPLACEMENT, 0.0016, ""},
                   {MR_KIND_TENSION, 1e-9, ""}};
    for (size_t i = 0; i < sizeof mistake / sizeof mistake[0]; i++) {
        const struct mr_channel_config c = {.kind = mistake[i].kind,
                                            .unit_per_code = (float)mistake[i].gain};
        char text[80];
        mistake_text(&c, text, sizeof text);
        if (mistake[i].text[0] ? !strstr(text, mistake[i].text) : text[0] != '\0')
            fail_msg("%g: %s", mistake[i].gain, text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(units_of_the_first_line),
        cmocka_unit_test(as_people_and_programs_write_it),
        cmocka_unit_test(columns_by_their_names),
        cmocka_unit_test(what_is_not_understood_is_refused),
        cmocka_unit_test(a_value_has_its_own_unit),
        cmocka_unit_test(without_a_unit_it_is_refused),
        cmocka_unit_test(a_mistake_is_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
