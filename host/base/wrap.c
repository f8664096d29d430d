#include "host/base/wrap.h"

#include <stdbool.h>
#include <string.h>

size_t wrap_width(const char *text, size_t bytes)
{
    size_t width = 0;
    for (size_t i = 0; i < bytes; i++)
        width += ((unsigned char)text[i] & 0xc0) != 0x80;
    return width;
}

void wrap_print(const char *text, size_t column, size_t indent, size_t width, FILE *out)
{
    bool begins = column == 0; /* the line has no word yet */
    if (begins)
        column = (size_t)fprintf(out, "%*s", (int)indent, "");
    for (text += strspn(text, " "); *text; text += strspn(text, " ")) {
        size_t bytes = strcspn(text, " "), word = wrap_width(text, bytes);
        if (!begins && column + 1 + word > width) {
            column = (size_t)fprintf(out, "\n%*s", (int)indent, "") - 1;
            begins = true;
        }
        column += (size_t)fprintf(out, begins ? "%.*s" : " %.*s", (int)bytes, text) - bytes + word;
        begins = false;
        text += bytes;
    }
    fputc('\n', out);
}
