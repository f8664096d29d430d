/* One description of an answer, printed three times. What is expected was written by hand. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/answer.h"
#include "tests/cmocka_all.h"

typedef void printer(const struct answer *answer, FILE *out);

static void as_text(const struct answer *answer, FILE *out)
{
    assert_true(answer_print_text(answer, out));
}

static char *printed(const struct answer *answer, printer *print)
{
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    print(answer, out);
    assert_int_equal(fclose(out), 0);
    return text;
}

static void expect(const struct answer *answer, printer *print, const char *expected)
{
    char *text = printed(answer, print);
    assert_string_equal(text, expected);
    free(text);
}

static void expect_json(const struct answer *answer, const char *expected)
{
    json_t *json = answer_make_json(answer);
    assert_non_null(json);
    char *text = json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(6));
    assert_string_equal(text, expected);
    free(text);
    json_decref(json);
}

static struct answer *landing(bool si)
{
    struct answer *answer = answer_new(si);
    answer_add_count(answer, "run", NULL, 5);
    answer_open_group(answer, NULL, "RUN 5");
    answer_add_estimate(answer, "touchdown_speed", "touchdown", UNIT_SPEED, 35.5, 0.112, 3)
        ->shows_interval = true;
    answer_add_value(answer, "rms", "rms <all>", UNIT_DISPLACEMENT, -0.00001, 4);
    answer_add_value(answer, "at", "at", UNIT_TIME, (double)NAN, 3);
    answer_add_count(answer, "edges", "edges", 17)->suffix = " of 24";
    answer_add_flag(answer, "pass", "pass", true);
    answer_add_text(answer, NULL, "board", "%s", "unknown");
    answer_add_missing_value(answer, "worst", "worst", "not compared");
    answer_add_json(answer, "raw", json_pack("[ii]", 1, 2));
    answer_close_group(answer);
    return answer;
}

TEST(facts_in_three_forms)
{
    struct answer *answer = landing(false);
    expect(answer, as_text,
           "RUN 5\n"
           "  touchdown     35.500 +- 0.112 ft/s (95 %: 35.280 to 35.720)\n"
           "  rms <all>     0.0000 in\n"
           "  at            -\n"
           "  edges         17 of 24\n"
           "  pass          yes\n"
           "  board         unknown\n"
           "  worst         not compared\n");
    expect_json(answer, "{\"run\":5,\"touchdown_speed_ft_s\":35.5,\"touchdown_speed_error_ft_s\":0."
                        "112,\"rms_in\":-1e-5,\"at_s\":null,\"edges\":17,"
                        "\"pass\":true,\"worst\":null,\"raw\":[1,2]}");
    expect(answer, answer_print_html,
           "<h3>RUN 5</h3>\n<dl>\n"
           "<div><dt>touchdown</dt><dd>35.500 \xc2\xb1 0.112 ft/s (95 %: 35.280 to "
           "35.720)</dd></div>\n"
           "<div><dt>rms &lt;all&gt;</dt><dd>0.0000 in</dd></div>\n"
           "<div><dt>at</dt><dd>-</dd></div>\n"
           "<div><dt>edges</dt><dd>17 of 24</dd></div>\n"
           "<div><dt>pass</dt><dd>yes</dd></div>\n"
           "<div><dt>board</dt><dd>unknown</dd></div>\n"
           "<div><dt>worst</dt><dd>not compared</dd></div>\n"
           "</dl>\n");
    answer_free(answer);
}

TEST(si_converts_name_value_and_error)
{
    struct answer *answer = answer_new(true);
    answer_add_estimate(answer, "peak", "peak", UNIT_DISPLACEMENT, 1.0, 0.01, 4); /* 25.4 mm */
    answer_add_value(answer, "pull", "pull", UNIT_TENSION, 1.0, 1);               /* 4.448 N */
    answer_add_value(answer, "station", "station", UNIT_STATION, 10.0, 1);        /* 3.048 m */
    expect(answer, as_text,
           "peak          25.400 +- 0.254 mm\n"
           "pull          4.4 N\n"
           "station       3.05 m\n");
    expect_json(
        answer,
        "{\"peak_mm\":25.4,\"peak_error_mm\":0.254,\"pull_N\":4.44822,\"station_m\":3.048}");
    answer_free(answer);
}

/* 0.1 ft are 1.2 in and 30.48 mm; 2 lb/ft are 29.1878 N/m. */
TEST(programs_get_values_as_they_are_given)
{
    for (int si = 0; si < 2; si++) {
        struct answer *answer = answer_new(si);
        answer_keep_units(answer);
        answer_add_estimate(answer, "lift", "lift", UNIT_MOVEMENT, 0.1, 0.001, 3);
        answer_append_remark(answer, ", of mat %d", 4);
        answer_add_value(answer, "spring", "spring", UNIT_STIFFNESS, 2.0, -4);
        answer_open_group(answer, "ends", "");
        answer_add_value(answer, NULL, "still as it began", UNIT_SPEED, -0.0, -3);
        answer_close_group(answer);
        expect(answer, as_text,
               si ? "lift              30.48 +- 0.30 mm, of mat 4\nspring            29.19 "
                    "N/m\nstill as it began 0 m/s\n"
                  : "lift              1.200 +- 0.012 in, of mat 4\nspring            2 "
                    "lb/ft\nstill as it began 0 ft/s\n");
        expect_json(answer,
                    "{\"lift_ft\":0.1,\"lift_error_ft\":0.001,\"spring_lb_ft\":2.0,\"ends\":{}}");
        answer_free(answer);
    }
}

/* A row ends where the next one begins, or its table; groups and tables in a row do not end it. */
TEST(rows_end_by_themselves)
{
    struct answer *answer = answer_new(false);
    answer_open_list(answer, "landings", NULL);
    for (int landing = 0; landing < 2; landing++) {
        answer_open_row(answer);
        answer_open_group(answer, "wheel", NULL);
        answer_add_count(answer, "at", NULL, landing);
        answer_close_group(answer);
        answer_open_table(answer, "zones", NULL);
        for (int zone = 0; zone < landing + 1; zone++) {
            answer_open_row(answer);
            answer_add_count(answer, "mats", NULL, zone);
        }
        answer_close_group(answer);
        answer_add_count(answer, "run", NULL, landing + 1);
    }
    answer_close_group(answer);
    answer_open_table(answer, "none", NULL);
    answer_close_group(answer);
    answer_add_count(answer, "last", NULL, 9);
    expect_json(answer, "{\"landings\":[{\"wheel\":{\"at\":0},\"zones\":[{\"mats\":0}],\"run\":1},"
                        "{\"wheel\":{\"at\":1},\"zones\":[{\"mats\":0},{\"mats\":1}],\"run\":2}],"
                        "\"none\":[],\"last\":9}");
    answer_free(answer);
}

static struct answer *channels(size_t columns)
{
    struct answer *answer = answer_new(false);
    answer_open_table(answer, "channels", "channels");
    for (int row = 0; row < 3; row++) {
        answer_open_group(answer, NULL, NULL);
        answer_add_count(answer, "number", "no", row + 8);
        answer_add_json(answer, "hidden", json_integer(row));
        if (row == 0)
            answer_add_text(answer, "why", "why", "too late");
        for (size_t c = 0; row > 0 && c < columns; c++) {
            char name[24], label[40];
            snprintf(name, sizeof name, "x%zu", c);
            snprintf(label, sizeof label, "peak|number %zu", c);
            answer_add_value(answer, name, label, UNIT_DISPLACEMENT,
                             row == 1 ? 1000.0 : (double)NAN, 2)
                ->is_capped = true;
        }
        if (row > 0)
            answer_add_text(answer, "why", "why", "%s", "");
        answer_close_group(answer);
    }
    answer_close_group(answer);
    answer_add_count(answer, "last", "last", 1);
    return answer;
}

TEST(a_table_in_three_forms)
{
    struct answer *answer = channels(1);
    expect(answer, as_text,
           "channels\n"
           "          peak\n"
           "      number 0\n"
           "  no        in  why\n"
           "   8            too late\n"
           "   9      >999\n"
           "  10         -\n"
           "last          1\n");
    expect_json(answer, "{\"channels\":[{\"number\":8,\"hidden\":0,\"why\":\"too late\"},"
                        "{\"number\":9,\"hidden\":1,\"x0_in\":1000.0,\"why\":\"\"},"
                        "{\"number\":10,\"hidden\":2,\"x0_in\":null,\"why\":\"\"}],\"last\":1}");
    expect(answer, answer_print_html,
           "<h3>channels</h3>\n<div class=\"scroll\"><table><thead><tr><th "
           "class=\"n\">no</th><th class=\"n\">peak number "
           "0 (in)</th><th>why</th></tr></thead><tbody>\n"
           "<tr><td class=\"n\">8</td><td></td><td>too late</td></tr>\n"
           "<tr><td class=\"n\">9</td><td class=\"n\">&gt;999</td><td></td></tr>\n"
           "<tr><td class=\"n\">10</td><td class=\"n\">\xe2\x80\x93</td><td></td></tr>\n"
           "</tbody></table></div>\n<dl>\n<div><dt>last</dt><dd>1</dd></div>\n</dl>\n");
    answer_free(answer);
}

/* No row has all columns; the value's unit is in the head though the first row has none; groups of
 * a row are cells. */
TEST(columns_of_all_rows)
{
    struct answer *answer = answer_new(false);
    answer_open_table(answer, "zones", "zones");
    answer_open_group(answer, NULL, NULL);
    answer_add_text(answer, NULL, "of", "board");
    answer_add_missing_value(answer, "board", "start", "not known");
    answer_add_text(answer, "doubt", "doubt", "yes");
    answer_close_group(answer);
    answer_open_group(answer, NULL, NULL);
    answer_add_text(answer, NULL, "of", "measured");
    answer_open_group(answer, "measured", NULL);
    answer_add_count(answer, "mats", "mats", 12);
    answer_add_estimate(answer, "start", "start", UNIT_STATION, 74.25, 0.5, 1)->shows_sign = true;
    answer_close_group(answer);
    answer_close_group(answer);
    answer_open_group(answer, NULL, NULL); /* for programs alone */
    answer_add_count(answer, "mats", NULL, 1);
    answer_close_group(answer);
    answer_close_group(answer);
    expect(answer, as_text,
           "zones\n"
           "                         start\n"
           "  of        mats            ft  doubt\n"
           "  board              not known  yes\n"
           "  measured    12  +74.2 +- 0.5\n");
    expect_json(answer, "{\"zones\":[{\"board\":null,\"doubt\":\"yes\"},{\"measured\":{\"mats\":12,"
                        "\"start_ft\":74.25,\"start_error_ft\":0.5}},{\"mats\":1}]}");
    answer_free(answer);
}

TEST(what_is_too_wide_goes_on_below)
{
    struct answer *answer = channels(12);
    char *text = printed(answer, as_text);
    size_t lines = 0, heads = 0;
    for (char *line = strtok(text, "\n"); line; line = strtok(NULL, "\n"), lines++) {
        assert_true(strlen(line) <= 100);
        heads += strncmp(line, "  no ", 5) == 0;
    }
    assert_int_equal(heads, 2);
    assert_int_equal(lines, 1 + 2 * 6 + 1);
    free(text);
    answer_free(answer);
}

TEST(a_sentence_in_lines_that_fit)
{
    char words[601] = "";
    for (int i = 0; i < 50; i++)
        strcat(words, "elevenchars ");
    struct answer *answer = answer_new(false);
    answer_add_sentence(answer, "sentence", "%s", words);
    char *text = printed(answer, as_text);
    assert_int_equal(strcspn(text, "\n"), 8 * 12 - 1); /* a ninth word would end at 107 */
    free(text);
    answer_free(answer);
    answer = answer_new(false); /* a heading, too */
    answer_open_group(answer, NULL, words);
    answer_add_flag(answer, "flag", "flag", true);
    answer_close_group(answer);
    text = printed(answer, as_text);
    assert_int_equal(strcspn(text, "\n"), 8 * 12 - 1);
    free(text);
    answer_free(answer);
}

TEST(nested_groups_and_lists)
{
    struct answer *answer = answer_new(false);
    answer_open_group(answer, "zone", "zone");
    answer_open_group(answer, "measured", "measured");
    answer_add_value(answer, "mats", "mats", UNIT_NUMBER, 12.0, 0);
    answer_close_group(answer);
    answer_open_list(answer, "overruns_ft", NULL);
    answer_add_value(answer, NULL, NULL, UNIT_NUMBER, 1.5, 1);
    answer_add_text(answer, NULL, NULL, "x");
    answer_close_group(answer);
    answer_close_group(answer);
    answer_add_flag(answer, "after", NULL, false);
    answer_open_table(answer, "nothing", "nothing yet");
    answer_close_group(answer);
    expect(answer, as_text, "zone\n  measured\n    mats          12\n");
    expect_json(answer, "{\"zone\":{\"measured\":{\"mats\":12.0},\"overruns_ft\":[1.5,\"x\"]},"
                        "\"after\":false,\"nothing\":[]}");
    answer_free(answer);
}

/* What landings need: counts that nobody told, tables without rows, several facts of one label,
 * facts of a list. */
TEST(what_is_not_there_and_what_is_there_twice)
{
    struct answer *answer = answer_new(false);
    answer_open_group(answer, NULL, "RUN 1");
    answer_add_count(answer, "lost", "lost", ANSWER_COUNT_UNKNOWN);
    answer_open_table(answer, "gaps", "gaps");
    answer_close_group(answer);
    answer_open_list(answer, "lines", "");
    answer_add_text(answer, NULL, "foresight", "one");
    answer_add_text(answer, NULL, "foresight", "two")->is_warning = true;
    answer_close_group(answer);
    answer_add_estimate(answer, "lasted", "lasted", UNIT_TIME, 20.0, 0.29, 2);
    answer_open_table(answer, "rows", "rows");
    answer_open_group(answer, NULL, NULL);
    answer_add_count(answer, "number", "no", 8);
    answer_close_group(answer);
    answer_close_group(answer);
    answer_close_group(answer);
    expect(answer, as_text,
           "RUN 1\n"
           "  lost          -\n"
           "  foresight     one\n"
           "                two\n"
           "  lasted        20.00 +- 0.29 s\n"
           "  rows\n"
           "    no\n"
           "     8\n");
    expect_json(answer, "{\"lost\":null,\"gaps\":[],\"lines\":[\"one\",\"two\"],\"lasted_s\":20.0,"
                        "\"lasted_error_s\":0.29,"
                        "\"rows\":[{\"number\":8}]}");
    expect(answer, answer_print_html,
           "<h3>RUN 1</h3>\n<dl>\n<div><dt>lost</dt><dd>-</dd></div>\n"
           "<div><dt>foresight</dt><dd>one</dd></div>\n<div><dt>foresight</dt><dd "
           "class=\"warn\">two</dd></div>\n"
           "<div><dt>lasted</dt><dd>20.00 \xc2\xb1 0.29 s</dd></div>\n</dl>\n"
           "<h3>rows</h3>\n<div class=\"scroll\"><table><thead><tr><th "
           "class=\"n\">no</th></tr></thead><tbody>\n"
           "<tr><td class=\"n\">8</td></tr>\n</tbody></table></div>\n");
    answer_free(answer);
}
