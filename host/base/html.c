#include "host/base/html.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

void html_bytes(FILE *out, const char *text, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        switch (text[i]) {
        case '<': fputs("&lt;", out); break;
        case '>': fputs("&gt;", out); break;
        case '&': fputs("&amp;", out); break;
        case '"': fputs("&quot;", out); break;
        default: fputc(text[i], out); break;
        }
    }
}

void html_text(FILE *out, const char *text)
{
    html_bytes(out, text, strlen(text));
}

static void formatted(FILE *out, const char *format, va_list arguments)
{
    char text[1200];
    vsnprintf(text, sizeof text, format, arguments);
    html_text(out, text);
}

void html_base64(FILE *out, const unsigned char *bytes, size_t count)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < count; i += 3) {
        unsigned have = count - i < 3 ? (unsigned)(count - i) : 3u;
        unsigned long word = (unsigned long)bytes[i] << 16 |
                             (have > 1 ? (unsigned long)bytes[i + 1] << 8 : 0) |
                             (have > 2 ? bytes[i + 2] : 0);
        fputc(digits[word >> 18], out);
        fputc(digits[word >> 12 & 63], out);
        fputc(have > 1 ? digits[word >> 6 & 63] : '=', out);
        fputc(have > 2 ? digits[word & 63] : '=', out);
    }
}

void html_cell(FILE *out, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("<td>", out);
    formatted(out, format, arguments);
    fputs("</td>", out);
    va_end(arguments);
}

void html_number(FILE *out, double value, int decimals)
{
    if (isfinite(value))
        fprintf(out, "<td class=\"n\">%.*f</td>", decimals, value);
    else
        fputs("<td class=\"n\">&ndash;</td>", out);
}

void html_estimate(FILE *out, double value, double error, int decimals)
{
    if (isfinite(value))
        fprintf(out, "<td class=\"n\">%.*f&thinsp;&plusmn;&thinsp;%.*f</td>", decimals, value,
                decimals, error);
    else
        fputs("<td class=\"n\">&ndash;</td>", out);
}

void html_table(FILE *out, const char *const *heads)
{
    fputs("<div class=\"scroll\"><table><thead><tr>", out);
    for (; *heads; heads++) {
        fputs("<th>", out);
        html_text(out, *heads);
        fputs("</th>", out);
    }
    fputs("</tr></thead><tbody>\n", out);
}

void html_fact(FILE *out, const char *term, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fputs("<div><dt>", out);
    html_text(out, term);
    fputs("</dt><dd>", out);
    formatted(out, format, arguments);
    fputs("</dd></div>\n", out);
    va_end(arguments);
}
