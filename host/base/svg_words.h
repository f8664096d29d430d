/* Words in pictures: how wide they are, so that they stay inside; lines of them; keys.
 *
 * Which font a viewer has is not known. Widths are those of DejaVu Sans, one of the widest that
 * `sans-serif` may be: what fits by them fits with any usual font. */
#ifndef MATRIG_HOST_BASE_SVG_WORDS_H
#define MATRIG_HOST_BASE_SVG_WORDS_H

#include <stddef.h>
#include <stdio.h>

#define SVG_KEY_SIZE_PX 11.0 /* of the class `tick` in every picture */
#define SVG_KEY_ROW_PX  15.0

/* Pixels of a UTF-8 text on one line. */
double svg_text_width(const char *text, double size_px);

/* A text broken between words into lines of at most `width_px`; a word that is wider alone has a
 * line of its own. Words that U+00A0 joins stay together. */
struct svg_block {
    const char *class;
    double x, y; /* of the first line's foot, its left end */
    double width_px, size_px, line_px;
};
size_t svg_block_lines(const struct svg_block *block, const char *text);
/* Draws it; returns how many lines that were. */
size_t svg_block(FILE *out, const struct svg_block *block, const char *text);

/* A key below or above a picture: a short stroke of each class (a dot where the class begins with
 * "dot") and its text, from (left, y) in pixels to the right, in as many rows as it takes not to go
 * beyond `right`. */
struct svg_key {
    const char *class;
    const char *text;
};
/* How many rows, to make room for them below the first: SVG_KEY_ROW_PX each. */
size_t svg_legend_rows(double left, double right, const struct svg_key *keys, size_t count);
void svg_legend(FILE *out, double left, double right, double y, const struct svg_key *keys,
                size_t count);

#endif
