/* Pictures by gnuplot: formats by ending, text that gnuplot must not interpret, gaps, thinning. */
#include <math.h>
#include <stdlib.h>

#include "host/base/plot.h"
#include "tests/host/scratch.h"

#define MANY 50000

static struct plot *small(const char *title)
{
    static const double x[] = {1, 2, 3, 4, 5}, y[] = {1e-3, 1e-2, (double)NAN, 10, 100};
    struct plot *plot = plot_new(title, 600, 400, 2);
    plot_begin_panel(plot, "left", (struct plot_axis){"time (s)", 0, 6, false},
                     (struct plot_axis){"error (ft)", .is_logarithmic = true});
    plot_add_series(plot, &(struct plot_series){
                              .kind = PLOT_LINE_POINTS, .key = "rk4", .x = x, .y = y, .count = 5});
    plot_add_series(
        plot, &(struct plot_series){.kind = PLOT_BAND, .x = x, .y = y, .y_high = x, .count = 5});
    plot_add_series(plot, &(struct plot_series){
                              .kind = PLOT_VERTICAL_LINES, .x = x, .count = 2, .is_dashed = true});
    plot_add_series(plot, &(struct plot_series){
                              .kind = PLOT_HORIZONTAL_LINES, .key = "limit", .y = y, .count = 1});
    plot_begin_panel(plot, NULL, (struct plot_axis){"empty", 0, 1, false},
                     (struct plot_axis){NULL, 1, 0, false});
    return plot;
}

static void read_back(const char *path, char *text, size_t size)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    text[fread(text, 1, size - 1, file)] = '\0';
    fclose(file);
}

TEST(the_ending_chooses_the_format)
{
    static const char *const begins[][2] = {
        {"plot.svg", "<?xml"}, {"plot.png", "\x89PNG"}, {"plot.pdf", "%PDF"}};
    char path[100], text[8];
    for (size_t i = 0; i < COUNT_OF(begins); i++) {
        struct error error = {0};
        scratch_path(path, sizeof path, begins[i][0]);
        plot_write(small("a plot"), path, &error);
        assert_no_error(&error);
        read_back(path, text, sizeof text);
        assert_memory_equal(text, begins[i][1], strlen(begins[i][1]));
        unlink(path);
    }
}

TEST(another_ending_is_refused)
{
    static const char *const names[] = {"plot.gif", "plot", "svg"};
    char path[100];
    for (size_t i = 0; i < COUNT_OF(names); i++) {
        struct error error = {0}, before = {0};
        scratch_path(path, sizeof path, names[i]);
        plot_check(path, NULL, &before);
        assert_error(&before, MR_USAGE, ".svg, .png or .pdf");
        plot_write(small("a plot"), path, &error);
        assert_error(&error, MR_USAGE, ".svg, .png or .pdf");
        assert_int_not_equal(access(path, F_OK), 0);
    }
}

TEST(text_is_shown_as_it_is)
{
    static char text[100000];
    char path[100];
    struct error error = {0};
    scratch_path(path, sizeof path, "plot-text.svg");
    plot_write(small("`date` \"quoted\" it's x_1^2 \xc2\xb1"), path, &error);
    assert_no_error(&error);
    read_back(path, text, sizeof text);
    assert_non_null(strstr(text, "`date` \"quoted\" it's x_1^2 \xc2\xb1"));
    assert_non_null(strstr(text, "error (ft)"));
    unlink(path);
}

TEST(a_long_line_is_thinned_and_keeps_its_spike)
{
    static double x[MANY], y[MANY];
    static char text[1000000];
    char path[100];
    struct error error = {0};
    for (size_t i = 0; i < MANY; i++) {
        x[i] = (double)i;
        y[i] = i == 31234 ? 7.0 : 0.0;
    }
    scratch_path(path, sizeof path, "plot-long.svg");
    struct plot *plot = plot_new("long", 600, 400, 1);
    plot_begin_panel(plot, NULL, (struct plot_axis){.label = "x"},
                     (struct plot_axis){.label = "y"});
    plot_add_series(plot, &(struct plot_series){.kind = PLOT_LINE, .x = x, .y = y, .count = MANY});
    plot_write(plot, path, &error);
    assert_no_error(&error);
    read_back(path, text, sizeof text);
    assert_true(strlen(text) < 100000);
    assert_non_null(strstr(text, ">7<")); /* the axis reaches the spike */
    unlink(path);
}

TEST(without_gnuplot_one_line_names_the_package)
{
    char path[100], *before = strdup(getenv("PATH"));
    struct error error = {0}, early = {0};
    scratch_path(path, sizeof path, "plot-missing.svg");
    setenv("PATH", "/nowhere", 1);
    plot_check(path, NULL, &early);
    plot_write(small("a plot"), path, &error);
    setenv("PATH", before, 1);
    free(before);
    assert_error(&early, MR_IO, "apt install gnuplot-nox");
    assert_error(&error, MR_IO, "apt install gnuplot-nox");
    assert_int_not_equal(access(path, F_OK), 0);
}
