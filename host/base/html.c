#include "host/base/html.h"

#include <string.h>

void html_write_bytes(FILE *out, const char *text, size_t length)
{
    for (size_t i = 0; i < length; i++) {
        switch (text[i]) {
        case '<': fputs("&lt;", out); break;
        case '>': fputs("&gt;", out); break;
        case '&': fputs("&amp;", out); break;
        case '"': fputs("&quot;", out); break;
        case '+': /* writes "+-" as a plus-minus sign */
            fputs(i + 1 < length && text[i + 1] == '-' ? "\xc2\xb1" : "+", out);
            break;
        case '-':
            if (i == 0 || text[i - 1] != '+')
                fputc('-', out);
            break;
        case '2': /* writes the 2 of "ft/s2" as a superscript */
            fputs(i >= 2 && text[i - 1] == 's' && text[i - 2] == '/' ? "\xc2\xb2" : "2", out);
            break;
        default: fputc(text[i], out); break;
        }
    }
}

void html_write_text(FILE *out, const char *text)
{
    html_write_bytes(out, text, strlen(text));
}

void html_write_base64(FILE *out, const unsigned char *bytes, size_t count)
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
