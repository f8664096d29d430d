/* Drawing plots as SVG inside a page: axes with units and ticks, lines, bands, marks.
 *
 * A picture has its own pixels (viewBox); the page scales it. Colours are CSS classes of the page
 * (report/style.c), so one picture serves light, dark and print. Long series are thinned to what
 * can be seen: of a column of pixels the least and the greatest value stay, so no spike is lost,
 * and where the line strays no further than SVG_THINNED_PX from them not even those. What is drawn
 * are values that were given, none is a mean. */
#ifndef MATRIG_HOST_BASE_SVG_H
#define MATRIG_HOST_BASE_SVG_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#define SVG_THINNED_PX 0.3 /* 0.05 mm on paper */

struct svg_axis {
    double low, high;
    const char *label; /* with its unit; NULL: none */
    bool ticks;        /* numbers beside the ticks */
};

/* One coordinate system: pixels of the drawing area and what they stand for. */
struct svg_plot {
    FILE *out;
    double left, top, width, height;
    struct svg_axis x, y;
    bool log_x, log_y; /* logarithmic: low > 0, a tick per decade */
    double column_px;  /* width of the columns that lines are thinned by; 0: 1 */
};

/* Ticks at first + i * step, i < count: step is 1, 2 or 5 times a power of ten, at most `most`
 * ticks in [low, high]. `decimals` is what the numbers need. low < high, else count is 0. */
struct svg_ticks {
    double first, step;
    unsigned count;
    int decimals;
};
struct svg_ticks svg_choose_ticks(double low, double high, unsigned most);

/* Widen [low, high] by a twentieth on each side and to at least `least`; an empty or not finite
 * range becomes 0 to least. */
void svg_widen(double *low, double *high, double least);

void svg_open(FILE *out, double width, double height, const char *title);
/* The same for a picture that is a file of its own, not part of a page: with the name space that
 * viewers want. */
void svg_open_file(FILE *out, double width, double height, const char *title);
void svg_close(FILE *out);

double svg_x(const struct svg_plot *plot, double x);
double svg_y(const struct svg_plot *plot, double y);

/* Frame, grid, ticks and labels. */
void svg_axes(const struct svg_plot *plot);
/* A line through points in order; NaN breaks it. Outside the plot it is clipped to the edge. */
void svg_line(const struct svg_plot *plot, const char *class, const double *x, const double *y,
              size_t count);
/* Area between two curves. */
void svg_band(const struct svg_plot *plot, const char *class, const double *x, const double *low,
              const double *high, size_t count);
void svg_rect(const struct svg_plot *plot, const char *class, double x0, double y0, double x1,
              double y1);
void svg_dot(const struct svg_plot *plot, const char *class, double x, double y);
/* A mark of one of SVG_SHAPES shapes (circle, square, triangle up, diamond, triangle down,
 * pentagon, cross) at pixel (px, py); svg_x and svg_y turn values into pixels. The class fills or
 * strokes it. */
#define SVG_SHAPES 7
void svg_mark(FILE *out, const char *class, unsigned shape, double px, double py, double radius);
/* Dots at points of the plot, all in one path: the class gives their form and size by
 * stroke-linecap and stroke-width. NaN is left out, and what lies outside. */
void svg_dots(const struct svg_plot *plot, const char *class, const double *x, const double *y,
              size_t count);
/* Text at a point of the plot, moved by pixels; anchor "start", "middle" or "end". */
void svg_text(const struct svg_plot *plot, const char *class, const char *anchor, double x,
              double y, double dx, double dy, const char *text);

#endif
