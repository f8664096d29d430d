#include "host/base/svg_words.h"

#include <stdbool.h>
#include <string.h>

#include "host/base/html.h"

#define KEY_MARK_PX  25.0 /* from a key's stroke to its text */
#define KEY_APART_PX 20.0

/* Widths of the printable ASCII characters, thousandths of the size. */
static const unsigned short widths[] = {
    318, 401, 460, 838, 636, 950, 780, 275, 390, 390, 500, 838, 318, 361,  318, 337, 636, 636, 636,
    636, 636, 636, 636, 636, 636, 636, 337, 337, 838, 838, 838, 531, 1000, 684, 686, 698, 770, 632,
    575, 775, 752, 295, 295, 656, 557, 863, 748, 787, 603, 787, 695, 635,  611, 732, 684, 989, 685,
    611, 685, 390, 337, 390, 838, 500, 500, 613, 635, 550, 635, 615, 352,  635, 634, 278, 278, 579,
    278, 974, 634, 612, 635, 635, 411, 521, 392, 634, 592, 818, 592, 592,  525, 636, 337, 636, 838,
};
#define OTHER 838u /* signs such as +- and minus; letters with accents are narrower */

static double width_of(const char *text, size_t length, double size_px)
{
    unsigned long sum = 0;
    for (size_t i = 0; i < length; i++) {
        unsigned char c = (unsigned char)text[i];
        if (c >= ' ' && c < ' ' + sizeof widths / sizeof widths[0])
            sum += widths[c - ' '];
        else if (c == 0xc2 && i + 1 < length && (unsigned char)text[i + 1] == 0xa0)
            sum += widths[0]; /* a blank at which no line is broken */
        /* what follows the first byte of a character has no width of its own */
        else if ((c & 0xc0) != 0x80)
            sum += OTHER;
    }
    return 1e-3 * (double)sum * size_px;
}

double svg_text_width(const char *text, double size_px)
{
    return width_of(text, strlen(text), size_px);
}

/* Length of the line that `text` begins with; its words as far as they fit, the first in any
 * case. */
static size_t line_length(const struct svg_block *block, const char *text)
{
    size_t fits = strcspn(text, " ");
    while (text[fits]) {
        size_t next = fits + 1 + strcspn(text + fits + 1, " ");
        if (width_of(text, next, block->size_px) > block->width_px)
            break;
        fits = next;
    }
    return fits;
}

static size_t lay(FILE *out, const struct svg_block *block, const char *text)
{
    size_t lines = 0;
    while (*text) {
        size_t length = line_length(block, text);
        if (out) {
            fprintf(out, "<text class=\"%s\" x=\"%.1f\" y=\"%.1f\">", block->class, block->x,
                    block->y + block->line_px * (double)lines);
            html_bytes(out, text, length);
            fputs("</text>\n", out);
        }
        lines++;
        text += length;
        text += strspn(text, " ");
    }
    return lines;
}

size_t svg_block_lines(const struct svg_block *block, const char *text)
{
    return lay(NULL, block, text);
}

size_t svg_block(FILE *out, const struct svg_block *block, const char *text)
{
    return lay(out, block, text);
}

/* ---- keys ---- */

struct place {
    double x;
    size_t row;
};

/* Where key i is, after the one before it at `last`. */
static struct place next_place(double left, double right, const struct svg_key *keys, size_t i,
                               struct place last)
{
    if (i == 0)
        return (struct place){left, 0};
    double x = last.x + KEY_MARK_PX + svg_text_width(keys[i - 1].text, SVG_KEY_SIZE_PX) +
               KEY_APART_PX;
    bool fits = x + KEY_MARK_PX + svg_text_width(keys[i].text, SVG_KEY_SIZE_PX) <= right;
    return fits ? (struct place){x, last.row} : (struct place){left, last.row + 1};
}

size_t svg_legend_rows(double left, double right, const struct svg_key *keys, size_t count)
{
    struct place at = {left, 0};
    for (size_t i = 0; i < count; i++)
        at = next_place(left, right, keys, i, at);
    return at.row + 1;
}

void svg_legend(FILE *out, double left, double right, double y, const struct svg_key *keys,
                size_t count)
{
    struct place at = {left, 0};
    for (size_t i = 0; i < count; i++) {
        at = next_place(left, right, keys, i, at);
        double foot = y + SVG_KEY_ROW_PX * (double)at.row;
        if (strncmp(keys[i].class, "dot", 3) == 0)
            fprintf(out, "<circle class=\"%s\" cx=\"%.1f\" cy=\"%.1f\" r=\"2.6\"/>", keys[i].class,
                    at.x + 10.0, foot - 4.0);
        else
            fprintf(out, "<path class=\"%s\" d=\"M%.1f %.1fh20\"/>", keys[i].class, at.x,
                    foot - 4.0);
        fprintf(out, "<text class=\"tick\" x=\"%.1f\" y=\"%.1f\">", at.x + KEY_MARK_PX, foot);
        html_text(out, keys[i].text);
        fputs("</text>\n", out);
    }
}
