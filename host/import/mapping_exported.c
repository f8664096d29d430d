/* matrig's own table, as matrig export --format csv writes it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/export/origin.h"
#include "host/import/mapping.h"
#include "host/store/store_import.h"

/* d3_in, t14_N, gear_m. */
static void add_exported(struct mapping *m, const char *name, size_t length)
{
    char word[MAPPING_NAME];
    struct mapping_channel c = {.station_ft = (double)NAN, .error = (double)NAN};
    snprintf(word, sizeof word, "%.*s", (int)(length < sizeof word ? length : sizeof word - 1),
             name);
    snprintf(c.column, sizeof c.column, "%s", word);
    char *unit = strchr(word, '_');
    if (!unit || m->channels == MAPPING_CHANNELS)
        return;
    *unit++ = '\0';
    if (!mapping_channel_named(word, &c) || (c.scale = mapping_unit(c.role, unit)) == 0.0)
        return;
    m->channel[m->channels++] = c;
}

static void take_origin(struct mapping *m, const char *line, size_t length, size_t number)
{
    static const char key[] = "# landing: ";
    const size_t skip = sizeof key - 1;
    if (length < skip || memcmp(line, key, skip) != 0 || m->origin_line)
        return;
    m->origin_line = number;
    m->origin = malloc(sizeof *m->origin);
    if (m->origin && !origin_parse(line + skip, length - skip, m->origin)) {
        free(m->origin);
        m->origin = NULL;
    }
}

bool mapping_of_export(const char *table, size_t length, struct mapping *mapping)
{
    static const char head[] = "# matrig landing:";
    const char *at = table, *end = table + length;
    if (length < sizeof head || memcmp(table, head, sizeof head - 1) != 0)
        return false;
    *mapping = (struct mapping){.exported = true,
                                .separator = ',',
                                .decimal = '.',
                                .comment = '#',
                                .header_lines = 1,
                                .time_column = "t_s",
                                .time_unit_s = 1.0,
                                .gap_s = (double)NAN,
                                .touchdown_ft = (double)NAN,
                                .switch_error_ft = (double)NAN};
    for (size_t line = 1; at < end && *at == '#'; line++) {
        const char *newline = memchr(at, '\n', (size_t)(end - at));
        take_origin(mapping, at, (size_t)((newline ? newline : end) - at), line);
        at = newline ? newline + 1 : end;
    }
    while (at < end && *at != '\n') {
        size_t count = 0;
        while (at + count < end && at[count] != ',' && at[count] != '\n')
            count++;
        add_exported(mapping, at, count);
        at += count;
        at += at < end && *at == ',';
    }
    mapping->text = strdup(STORE_IMPORT_EXPORTED);
    return true;
}

void mapping_by_block(struct mapping *mapping)
{
    if (!mapping->origin)
        return;
    snprintf(mapping->time_column, sizeof mapping->time_column, "block");
    mapping->time_unit_s = 0.001;
    mapping->gap_s = 0.0011; /* what is missing in the table is missing */
}
