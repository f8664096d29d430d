#include "host/base/plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include "host/base/output.h"
#include "host/base/process.h"
#include "host/base/xmalloc.h"

#define GNUPLOT_TIMEOUT_S      120.0
#define TEMPORARY_FILE_PURPOSE "the plot" /* purpose of a temporary file, in error messages */
/* Maximum number of pixel columns with samples. A line with more samples is thinned to the smallest
 * and largest value per column. */
#define THINNING_COLUMNS       1000

struct plot {
    char *title, *text;
    size_t length;
    FILE *script; /* gnuplot script: one `plot` command per panel, with its data */
    unsigned width, height, columns, panel_count;
    char *panel_elements; /* elements of the `plot` command of the current panel */
    size_t elements_length;
    FILE *series_list;
    /* data blocks of the whole plot; series of the current panel */
    unsigned data_block_count, drawn_series_count;
};

/* Writes the text in single quotes, in which gnuplot substitutes nothing. */
static void write_quoted(FILE *out, const char *text)
{
    fputc('\'', out);
    for (; *text; text++) {
        if (*text == '\'')
            fputc('\'', out);
        fputc((unsigned char)*text < ' ' ? ' ' : *text, out);
    }
    fputc('\'', out);
}

static void write_set_command(FILE *out, const char *what, const char *text)
{
    fprintf(out, "set %s ", what);
    write_quoted(out, text ? text : "");
    fputs(" noenhanced\n", out);
}

struct plot *plot_new(const char *title, unsigned width, unsigned height, unsigned columns)
{
    struct plot *plot = xcalloc(1, sizeof *plot);
    plot->title = xstrdup(title);
    plot->script = xopen_memstream(&plot->text, &plot->length);
    plot->width = width;
    plot->height = height;
    plot->columns = columns;
    return plot;
}

static void end_panel(struct plot *plot)
{
    if (!plot->series_list)
        return;
    fclose(plot->series_list);
    /* an empty panel still shows its axes */
    fprintf(plot->script, "plot %s\n",
            plot->drawn_series_count > 0 ? plot->panel_elements : "NaN notitle");
    free(plot->panel_elements);
    plot->series_list = NULL;
}

static void write_axis_commands(FILE *out, char name, const struct plot_axis *axis)
{
    char what[8];
    snprintf(what, sizeof what, "%clabel", name);
    write_set_command(out, what, axis->label);
    fprintf(out, "set xlabel offset 0,0.4\n"); /* keeps the axis label away from the key */
    fprintf(out,
            axis->is_logarithmic ? "set logscale %c\nset format %c '10^{%%L}'\n"
                                 : "unset logscale %c\nset format %c '%%h'\n",
            name, name);
    if (axis->low < axis->high || axis->low > axis->high)
        fprintf(out, "set %crange [%.9g:%.9g]\n", name, axis->low, axis->high);
    else
        fprintf(out, "set %crange [*:*]\n", name);
}

void plot_begin_panel(struct plot *plot, const char *title, struct plot_axis x, struct plot_axis y)
{
    end_panel(plot);
    plot->series_list = xopen_memstream(&plot->panel_elements, &plot->elements_length);
    plot->panel_count++;
    plot->drawn_series_count = 0;
    fputs("unset label\nunset arrow\n", plot->script);
    write_set_command(plot->script, "title", title);
    write_axis_commands(plot->script, 'x', &x);
    write_axis_commands(plot->script, 'y', &y);
}

static void write_number(FILE *out, double value, char end)
{
    if (isfinite(value))
        fprintf(out, "%.9g%c", value, end);
    else
        fprintf(out, "NaN%c", end);
}

static void write_row(FILE *out, const struct plot_series *series, size_t i)
{
    write_number(out, series->x[i], ' ');
    write_number(out, series->y[i], series->y_high ? ' ' : '\n');
    if (series->y_high)
        write_number(out, series->y_high[i], '\n');
}

/* Reduces samples [from, to) to one row or two: the smallest and the largest value in order of
 * time, or the outline of a band. If any sample is NaN, the result is NaN. */
static void write_thinned_rows(FILE *out, const struct plot_series *series, size_t from, size_t to)
{
    const double *high = series->y_high ? series->y_high : series->y;
    size_t least = from, most = from;
    for (size_t i = from; i < to; i++) {
        if (isnan(series->y[i])) {
            write_row(out, series, i);
            return;
        }
        least = series->y[i] < series->y[least] ? i : least;
        most = high[i] > high[most] ? i : most;
    }
    if (series->y_high) {
        write_number(out, series->x[from], ' ');
        write_number(out, series->y[least], ' ');
        write_number(out, high[most], '\n');
        return;
    }
    write_row(out, series, least < most ? least : most);
    write_row(out, series, least < most ? most : least);
}

static void write_data(struct plot *plot, const struct plot_series *series)
{
    bool may_thin = series->kind == PLOT_LINE || series->kind == PLOT_BAND;
    size_t step = may_thin ? series->count / THINNING_COLUMNS : 0;
    fprintf(plot->script, "$d%u << EOD\n", plot->data_block_count);
    for (size_t i = 0; i < series->count && step <= 2; i++)
        write_row(plot->script, series, i);
    for (size_t i = 0; i < series->count && step > 2; i += step)
        write_thinned_rows(plot->script, series, i,
                           i + step < series->count ? i + step : series->count);
    if (step > 2)
        write_row(plot->script, series, series->count - 1);
    fputs("EOD\n", plot->script);
}

static void add_vertical_lines(struct plot *plot, const struct plot_series *series,
                               const char *look)
{
    for (size_t i = 0; i < series->count; i++)
        fprintf(plot->script, "set arrow from %.9g,graph 0 to %.9g,graph 1 nohead %s\n",
                series->x[i], series->x[i], look);
    fputs("NaN ", plot->series_list);
}

/* Draws constants as functions. gnuplot includes functions in the range of an axis without limits,
 * but not arrows. */
static void add_horizontal_lines(struct plot *plot, const struct plot_series *series,
                                 const char *look)
{
    for (size_t i = 1; i < series->count; i++)
        fprintf(plot->series_list, "%.9g with lines %s notitle, ", series->y[i], look);
    fprintf(plot->series_list, "%.9g ", series->y[0]);
}

void plot_add_series(struct plot *plot, const struct plot_series *series)
{
    static const char *const colours[PLOT_COLOUR_COUNT] = {
        "#0072b2", "#d55e00", "#009e73", "#b8529a", "#a67c00", "#222222", "#56b4e9", "#8a9099"};
    /* gnuplot point types of filled shapes; the hollow shape has the number one below */
    static const int shapes[PLOT_SHAPE_COUNT] = {7, 5, 9, 13, 11, 15};
    int shape = shapes[series->shape % PLOT_SHAPE_COUNT] - series->is_hollow;
    char look[48];
    if (series->count == 0)
        return;
    snprintf(look, sizeof look, "lc rgb '%s' lw 1.4 dt %d",
             colours[series->colour % PLOT_COLOUR_COUNT], series->is_dashed ? 2 : 1);
    if (plot->drawn_series_count++ > 0)
        fputs(", ", plot->series_list);
    if (series->kind == PLOT_VERTICAL_LINES)
        add_vertical_lines(plot, series, look);
    else if (series->kind == PLOT_HORIZONTAL_LINES)
        add_horizontal_lines(plot, series, look);
    else {
        write_data(plot, series);
        fprintf(plot->series_list, "$d%u ", plot->data_block_count++);
    }
    if (series->kind == PLOT_LINE || series->kind == PLOT_VERTICAL_LINES ||
        series->kind == PLOT_HORIZONTAL_LINES)
        fprintf(plot->series_list, "with lines %s", look);
    else if (series->kind == PLOT_POINTS)
        fprintf(plot->series_list, "with points %s pt %d ps 0.6", look, shape);
    else if (series->kind == PLOT_LINE_POINTS)
        fprintf(plot->series_list, "with linespoints %s pt %d ps 0.6", look, shape);
    else if (series->kind == PLOT_BAND)
        fprintf(plot->series_list,
                "using 1:2:3 with filledcurves %s fs transparent solid 0.22 noborder", look);
    fputs(" title ", plot->series_list);
    write_quoted(plot->series_list, series->key ? series->key : "");
}

/* The gnuplot terminal for a file extension; NULL: unsupported. */
static const char *find_gnuplot_terminal(const char *path)
{
    static const char *const endings[][2] = {
        {".svg", "set terminal svg size %u,%u font 'Helvetica,12' background 'white'\n"},
        {".png", "set terminal pngcairo size %u,%u font 'Sans,9'\n"},
        {".pdf", "set terminal pdfcairo size %u/96.,%u/96. font 'Sans,9'\n"}};
    const char *ending = strrchr(path, '.');
    for (size_t i = 0; ending && i < sizeof endings / sizeof endings[0]; i++) {
        if (strcmp(ending, endings[i][0]) == 0)
            return endings[i][1];
    }
    return NULL;
}

static void print_script(FILE *out, const struct plot *plot, const char *terminal)
{
    unsigned columns = plot->panel_count < plot->columns ? plot->panel_count : plot->columns;
    fprintf(out, terminal, plot->width, plot->height);
    fputs("set encoding utf8\nset grid lc rgb '#d4d8dc' lw 1 dt 1\nset border lc rgb '#444444'\n"
          "set key below noenhanced width 1 samplen 2\nset tics nomirror\n",
          out);
    fprintf(out, "set multiplot layout %u,%u ",
            columns > 0 ? (plot->panel_count + columns - 1) / columns : 1,
            columns > 0 ? columns : 1);
    fputs("title ", out);
    write_quoted(out, plot->title);
    fputs(" noenhanced\n", out);
    fwrite(plot->text, 1, plot->length, out);
    fputs("unset multiplot\n", out);
}

/* Runs gnuplot on the script and writes its output to `picture`. */
static enum mr_status run_gnuplot(FILE *script, FILE *picture, struct error *error)
{
    static const char *const words[] = {"/usr/bin/env", "gnuplot", "--default-settings", NULL};
    FILE *errors = output_open_temporary(TEMPORARY_FILE_PURPOSE, error);
    char line[200] = "", next[200];
    pid_t child;
    int status = 0;
    if (!errors)
        return error->status;
    const int streams[3] = {fileno(script), fileno(picture), fileno(errors)};
    if (process_start(words, streams, &child, error) != MR_OK) {
        fclose(errors);
        return error->status;
    }
    if (!process_wait(child, GNUPLOT_TIMEOUT_S, &status))
        snprintf(line, sizeof line, "timed out after %g s", GNUPLOT_TIMEOUT_S);
    else if (WIFSIGNALED(status))
        snprintf(line, sizeof line, "killed by signal %d", WTERMSIG(status));
    else if (WEXITSTATUS(status) != 0)
        snprintf(line, sizeof line, "exit code %d", WEXITSTATUS(status));
    rewind(errors);
    while (fgets(next, sizeof next, errors)) {
        if (strspn(next, " \t^\n") < strlen(next))
            snprintf(line, sizeof line, "%.*s", (int)strcspn(next, "\n"), next);
    }
    fclose(errors);
    if (WIFEXITED(status) && WEXITSTATUS(status) == 127)
        return error_set(error, MR_IO,
                         "cannot plot: gnuplot is missing; run apt install gnuplot-nox");
    return status == 0 ? MR_OK : error_set(error, MR_IO, "gnuplot failed: %s", line);
}

static void plot_free(struct plot *plot)
{
    free(plot->title);
    free(plot->text);
    free(plot);
}

static enum mr_status check_extension(const char *path, struct error *error)
{
    return find_gnuplot_terminal(path)
             ? MR_OK
             : error_set(error, MR_USAGE,
                         "cannot write this type of plot: %s; use a file name "
                         "ending in .svg, .png or .pdf",
                         path);
}

enum mr_status plot_write(struct plot *plot, const char *path, struct error *error)
{
    struct output output;
    FILE *script = output_open_temporary(TEMPORARY_FILE_PURPOSE, error),
         *picture = script ? output_open_temporary(TEMPORARY_FILE_PURPOSE, error) : NULL;
    end_panel(plot);
    fclose(plot->script);
    if (picture && check_extension(path, error) == MR_OK) {
        print_script(script, plot, find_gnuplot_terminal(path));
        rewind(script);
        if (run_gnuplot(script, picture, error) == MR_OK &&
            output_begin(&output, path, error) == MR_OK) {
            output_copy_temporary(picture, output.file);
            output_end(&output, error);
        }
    }
    if (script)
        fclose(script);
    if (picture)
        fclose(picture);
    plot_free(plot);
    return error->status;
}

enum mr_status plot_check(const char *path, const char *input, struct error *error)
{
    if (!path)
        return MR_OK;
    if (check_extension(path, error) == MR_OK && output_check(path, input, error) == MR_OK) {
        FILE *nothing = output_open_temporary(TEMPORARY_FILE_PURPOSE, error),
             *picture = nothing ? output_open_temporary(TEMPORARY_FILE_PURPOSE, error) : NULL;
        if (picture)
            run_gnuplot(nothing, picture, error);
        if (nothing)
            fclose(nothing);
        if (picture)
            fclose(picture);
    }
    return error->status;
}
