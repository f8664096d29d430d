#include "host/base/csv.h"

#include <stdbool.h>
#include <string.h>

void csv_write_cell(FILE *out, const char *text)
{
    bool quoted = strpbrk(text, ",\"\n\r") != NULL;
    fputs(quoted ? "\"" : "", out);
    for (const char *c = text; *c; c++)
        fprintf(out, *c == '"' ? "\"\"" : "%c", *c);
    fputs(quoted ? "\"" : "", out);
}

size_t csv_split(char *line, char separator, char *cell[], size_t most)
{
    size_t count = 0, end = strlen(line);
    while (end > 0 && (line[end - 1] == '\n' || line[end - 1] == '\r'))
        line[--end] = '\0';
    for (char *p = line; count < most;) {
        char *to = p;
        bool quoted = *p == '"', open = quoted;
        cell[count++] = p;
        for (p += quoted; *p && (quoted || *p != separator); p++) {
            if (quoted && *p == '"') {
                quoted = p[1] == '"';
                open = quoted;
                if (!quoted)
                    continue;
                p++;
            }
            *to++ = *p;
        }
        bool more = *p == separator;
        if (open)
            return 0;
        *to = '\0';
        if (!more)
            break;
        p++;
    }
    return count;
}
