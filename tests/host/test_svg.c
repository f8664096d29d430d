/* Ticks, scales, thinning and escaping of the report's pictures. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/html.h"
#include "host/base/svg.h"
#include "host/base/svg_words.h"
#include "tests/host/scratch.h"

static void ticks_are_round_numbers(void **state)
{
    static const struct {
        double low, high;
        unsigned most;
        double first, step;
        unsigned count;
        int decimals;
    } cases[] = {
        {0, 120, 8, 0, 20, 7, 0},       {0, 120, 13, 0, 10, 13, 0},
        {-0.3, 4.6, 10, 0, 0.5, 10, 1}, {0, 0.3, 4, 0, 0.1, 4, 1},
        {-0.04, 0.91, 5, 0, 0.2, 5, 1}, {1e5, 1.00001e5, 4, 1e5, 0.5, 3, 1},
        {37, 43, 3, 38, 2, 3, 0},       {0.00012, 0.00019, 4, 0.00012, 0.00002, 4, 5},
    };
    (void)state;
    for (size_t i = 0; i < COUNT_OF(cases); i++) {
        struct svg_ticks t = svg_choose_ticks(cases[i].low, cases[i].high, cases[i].most);
        assert_near(t.first, cases[i].first, 1e-9 * fabs(cases[i].high));
        assert_near(t.step, cases[i].step, 1e-12);
        assert_int_equal(t.count, cases[i].count);
        assert_int_equal(t.decimals, cases[i].decimals);
    }
}

static void no_ticks_without_a_range(void **state)
{
    (void)state;
    assert_int_equal(svg_choose_ticks(1, 1, 5).count, 0);
    assert_int_equal(svg_choose_ticks(2, 1, 5).count, 0);
    assert_int_equal(svg_choose_ticks((double)NAN, 1, 5).count, 0);
    assert_int_equal(svg_choose_ticks(0, (double)INFINITY, 5).count, 0);
    assert_int_equal(svg_choose_ticks(0, 1, 0).count, 0);
}

static void ranges_widen(void **state)
{
    double low = 0, high = 10;
    (void)state;
    svg_widen(&low, &high, 1.0);
    assert_near(low, -0.5, 1e-12);
    assert_near(high, 10.5, 1e-12);
    low = high = 5;
    svg_widen(&low, &high, 2.0);
    assert_near(low, 4.0, 1e-12);
    assert_near(high, 6.0, 1e-12);
    low = (double)INFINITY;
    high = -(double)INFINITY;
    svg_widen(&low, &high, 2.0);
    assert_near(low, 0.0, 0.0);
    assert_near(high, 2.0, 0.0);
}

static char *drawn;
static size_t drawn_length;

static struct svg_plot begin_plot(double x_high)
{
    struct svg_plot plot = {.out = open_memstream(&drawn, &drawn_length),
                            .left = 100,
                            .top = 10,
                            .width = 200,
                            .height = 100};
    plot.x = (struct svg_axis){0, x_high, NULL, false};
    plot.y = (struct svg_axis){-1, 1, NULL, false};
    return plot;
}

static void end_plot(struct svg_plot *plot)
{
    fclose(plot->out);
}

static void points_land_where_they_should(void **state)
{
    struct svg_plot plot = begin_plot(10);
    const double x[] = {0, 5, (double)NAN, 10, 20}, y[] = {0, 1, 0, -1, -3};
    (void)state;
    assert_near(svg_x(&plot, 5), 200, 1e-12);
    assert_near(svg_y(&plot, 1), 10, 1e-12);
    assert_near(svg_y(&plot, -1), 110, 1e-12);
    svg_line(&plot, "line", x, y, 5);
    end_plot(&plot);
    /* the NaN breaks the line, what lies outside is held at the edge */
    assert_string_equal(drawn, "<path class=\"line\" d=\"M100 60l100-50M300 110\"/>\n");
    free(drawn);
}

/* The points of the only path that was drawn, read back; the caller frees them. */
struct drawn_point {
    double x, y;
};
static size_t drawn_points(const char *text, struct drawn_point **points)
{
    const char *at = strstr(text, " d=\"") + 4;
    struct drawn_point p = {0.0, 0.0};
    size_t count = 0;
    *points = calloc(strlen(text), sizeof **points);
    bool step = false;
    while (*at != '"') {
        char *end;
        if (*at == 'M' || *at == 'l')
            step = *at++ == 'l';
        double x = strtod(at, &end), y = strtod(end, &end);
        p = step ? (struct drawn_point){p.x + x, p.y + y} : (struct drawn_point){x, y};
        (*points)[count++] = p;
        at = end;
    }
    return count;
}

/* Every value of a smooth curve and of noise lies within what svg.h promises of the line that is
 * drawn, and every corner of that line is a value that was given. */
static void a_thinned_line_stays_near(void **state)
{
    enum { COUNT = 5000 };
    (void)state;
    for (int kind = 0; kind < 2; kind++) {
        struct svg_plot plot = begin_plot(COUNT - 1);
        double *x = malloc(COUNT * sizeof *x), *y = malloc(COUNT * sizeof *y);
        for (int i = 0; i < COUNT; i++) {
            x[i] = i;
            y[i] = kind ? 0.1 * ((i * 7919) % 13 - 6) : sin(i / 300.0);
        }
        svg_line(&plot, "line", x, y, COUNT);
        end_plot(&plot);
        struct drawn_point *p;
        size_t points = drawn_points(drawn, &p), k = 0;
        assert_in_range(points, kind ? 100 : 10, kind ? 401 : 100);
        for (size_t j = 0; j < points; j++) {
            size_t i = (size_t)lround((p[j].x - 100.0) / 200.0 * (COUNT - 1));
            double nearest = (double)INFINITY; /* 25 values share a tenth of a pixel along x */
            for (size_t n = i > 3 ? i - 3 : 0; n < i + 4 && n < COUNT; n++)
                nearest = fmin(nearest, fabs(svg_y(&plot, y[n]) - p[j].y));
            assert_true(nearest < 0.06);
        }
        for (int i = 0; i < COUNT && kind == 0; i++) {
            double px = svg_x(&plot, x[i]);
            while (k + 2 < points && p[k + 1].x < px)
                k++;
            double line = p[k].y + (p[k + 1].y - p[k].y) * (px - p[k].x) / (p[k + 1].x - p[k].x);
            /* and what it falls within a column of one pixel */
            assert_near(svg_y(&plot, y[i]), line, SVG_THINNED_PX + 0.35);
        }
        assert_near(p[0].x, 100.0, 0.05);
        assert_near(p[points - 1].x, 300.0, 0.05);
        free(p);
        free(x);
        free(y);
        free(drawn);
    }
}

/* 100,000 points of noise on 200 pixels, with one spike: the page stays small and the spike
 * stays. */
static void long_series_are_thinned_and_keep_spikes(void **state)
{
    enum { COUNT = 100000 };
    struct svg_plot plot = begin_plot(COUNT);
    double *x = malloc(COUNT * sizeof *x), *y = malloc(COUNT * sizeof *y);
    (void)state;
    for (int i = 0; i < COUNT; i++) {
        x[i] = i;
        y[i] = 0.01 * ((i * 7919) % 13 - 6);
    }
    y[54321] = 0.9;
    svg_line(&plot, "line", x, y, COUNT);
    end_plot(&plot);
    assert_true(drawn_length < 201 * 2 * 14);
    struct drawn_point *at;
    size_t count = drawn_points(drawn, &at), spikes = 0;
    for (size_t i = 0; i < count; i++)
        /* 10 + 100 (1 - 0.9) / 2 */
        spikes += fabs(at[i].y - 15.0) < 0.051 && fabs(at[i].x - svg_x(&plot, 54321.0)) < 0.051;
    assert_int_equal(spikes, 1);
    free(at);
    free(x);
    free(y);
    free(drawn);
}

static void logarithmic_axes_have_decades(void **state)
{
    (void)state;
    struct svg_plot plot = begin_plot(10);
    plot.log_x = plot.log_y = true;
    plot.x = (struct svg_axis){1.0, 100.0, NULL, true};
    plot.y = (struct svg_axis){1e-4, 1.0, NULL, true};
    assert_near(svg_x(&plot, 10.0), plot.left + 0.5 * plot.width, 1e-9);
    assert_near(svg_y(&plot, 1e-3), plot.top + 0.75 * plot.height, 1e-9);
    svg_axes(&plot);
    svg_mark(plot.out, "m", 1, 50.0, 60.0, 4.0);
    end_plot(&plot);
    unsigned ticks = 0;
    for (const char *at = drawn; (at = strstr(at, "10<tspan")) != NULL; at++)
        ticks++;
    assert_int_equal(ticks, 3 + 5);
    assert_non_null(strstr(drawn, ">\xe2\x88\x92"
                                  "4</tspan>"));
    /* a square of half diagonal 5 */
    assert_non_null(strstr(drawn, "<path class=\"m\" d=\"M53.54 56.46L"));
    free(drawn);
}

static void text_is_escaped(void **state)
{
    (void)state;
    FILE *out = open_memstream(&drawn, &drawn_length);
    html_text(out, "a<b> & \"c\"");
    html_number(out, (double)NAN, 2);
    html_cell(out, "%s", "<script>");
    fclose(out);
    assert_string_equal(
        drawn, "a&lt;b&gt; &amp; &quot;c&quot;<td class=\"n\">&ndash;</td><td>&lt;script&gt;</td>");
    free(drawn);
}

/* As Chromium measures DejaVu Sans on a canvas, 1000 px high. */
static void words_are_as_wide_as_a_browser_says(void **state)
{
    (void)state;
    assert_near(svg_text_width("with the third band, five landings", 1000.0), 16581.5, 50.0);
    assert_near(svg_text_width("\u00b1", 1000.0), 837.9, 1.0);
    assert_near(svg_text_width("1\u00a0of\u00a02", 12.0), svg_text_width("1 of 2", 12.0), 1e-9);
}

static size_t count_of(const char *text, const char *what)
{
    size_t count = 0;
    for (const char *at = strstr(text, what); at; at = strstr(at + 1, what))
        count++;
    return count;
}

/* Lines are within their width, no word is lost, and what is joined stays joined. */
static void a_block_stays_within_its_width(void **state)
{
    static const char text[] = "with the third band, five landings (1\u00a0of\u00a01)";
    (void)state;
    for (double width_px = 40.0; width_px < 400.0; width_px += 7.0) {
        const struct svg_block block = {.class = "key",
                                        .x = 10.0,
                                        .y = 20.0,
                                        .width_px = width_px,
                                        .size_px = 12.0,
                                        .line_px = 15.0};
        FILE *out = open_memstream(&drawn, &drawn_length);
        size_t lines = svg_block(out, &block, text), words = 0;
        fclose(out);
        assert_int_equal(lines, svg_block_lines(&block, text));
        assert_int_equal(lines, count_of(drawn, "<text "));
        const char *at = drawn;
        for (size_t i = 0; i < lines; i++) {
            char line[200], start[60];
            snprintf(start, sizeof start, "x=\"10.0\" y=\"%.1f\">", 20.0 + 15.0 * (double)i);
            at = strstr(at, start);
            assert_non_null(at);
            at += strlen(start);
            snprintf(line, sizeof line, "%.*s", (int)strcspn(at, "<"), at);
            words += 1 + count_of(line, " ");
            if (strchr(line, ' '))
                assert_true(svg_text_width(line, 12.0) <= width_px);
        }
        assert_int_equal(words, 7);
        assert_non_null(strstr(drawn, "(1\u00a0of\u00a01)"));
        free(drawn);
    }
}

/* As many keys as there may be, each of a row's length, an odd one between: none goes beyond the
 * right end, none shares a place. */
static void a_legend_stays_between_its_ends(void **state)
{
    (void)state;
    const struct svg_key keys[] = {{"line a", "cleat_every 0.0025 and the rest of it"},
                                   {"dot b", "x"},
                                   {"line c", "cleat_every 0.0050 and the rest of it"},
                                   {"line d", "cleat_every 0.0075 and the rest of it"},
                                   {"line e", "cleat_every 0.0100 and the rest of it"},
                                   {"line f", "two & two"}};
    for (double right = 300.0; right < 1500.0; right += 100.0) {
        double last_x = -1.0, last_y = 0.0;
        FILE *out = open_memstream(&drawn, &drawn_length);
        svg_legend(out, 58.0, right, 14.0, keys, COUNT_OF(keys));
        fclose(out);
        const char *at = drawn;
        for (size_t i = 0; i < COUNT_OF(keys); i++) {
            double x, y;
            at = strstr(at, "<text class=\"tick\" ") + strlen("<text class=\"tick\" ");
            assert_int_equal(sscanf(at, "x=\"%lf\" y=\"%lf\"", &x, &y), 2);
            assert_true(x + svg_text_width(keys[i].text, SVG_KEY_SIZE_PX) <= right);
            assert_true(y > last_y ||
                        x > last_x + svg_text_width(keys[i - 1].text, SVG_KEY_SIZE_PX));
            last_x = x;
            last_y = y;
        }
        assert_near(last_y,
                    14.0 + SVG_KEY_ROW_PX *
                               (double)(svg_legend_rows(58.0, right, keys, COUNT_OF(keys)) - 1),
                    1e-9);
        assert_non_null(strstr(drawn, "two &amp; two"));
        free(drawn);
    }
    assert_int_equal(svg_legend_rows(58.0, 1500.0, keys, 0), 1);
}

/* A span that no double holds, as a damaged campaign may give: no ticks, and no integer of
 * infinity. */
static void a_span_without_end(void **state)
{
    (void)state;
    assert_int_equal(svg_choose_ticks(-1.7e308, 1.7e308, 8).count, 0);
    assert_int_equal(svg_choose_ticks((double)NAN, 1.0, 8).count, 0);
    assert_int_equal(svg_choose_ticks(0.0, (double)INFINITY, 8).count, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(words_are_as_wide_as_a_browser_says),
        cmocka_unit_test(a_block_stays_within_its_width),
        cmocka_unit_test(a_legend_stays_between_its_ends),
        cmocka_unit_test(a_span_without_end),
        cmocka_unit_test(ticks_are_round_numbers),
        cmocka_unit_test(no_ticks_without_a_range),
        cmocka_unit_test(ranges_widen),
        cmocka_unit_test(points_land_where_they_should),
        cmocka_unit_test(long_series_are_thinned_and_keep_spikes),
        cmocka_unit_test(a_thinned_line_stays_near),
        cmocka_unit_test(logarithmic_axes_have_decades),
        cmocka_unit_test(text_is_escaped),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
