#include "host/analyse/measured_source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/xmalloc.h"

static const struct {
    const char *name;
    char letter;
    const char *alone, *filled;
} sources[MEASURED_SOURCES] = {
    [MEASURED_NOTHING] = {"none", '-', "no readings came", "came from nowhere"},
    [MEASURED_SERIAL] = {"serial", 'S', "serial block records, 1 kHz", "from serial"},
    [MEASURED_CAN] = {"can", 'C', "CAN messages, displacements at 500 Hz and tensions at 250 Hz",
                      "from CAN (displacements at 500 Hz, tensions at 250 Hz)"},
    [MEASURED_BOX] = {"blackbox", 'B', "black box records, 1 kHz", "from the black box"},
    [MEASURED_IMPORT] = {"import", 'I', "a file of another instrument",
                         "from a file of another instrument"},
};

const char *measured_source_name(enum measured_source source)
{
    return sources[source].name;
}

char measured_source_letter(enum measured_source source)
{
    return sources[source].letter;
}

/* A block is what most of it is: its record's source, else CAN when that filled any of it. */
static enum measured_source source_of_block(const struct measured *measured, size_t sample)
{
    enum measured_source source = MEASURED_NOTHING;
    for (unsigned c = 0; c < MR_CHANNELS; c++) {
        enum measured_source of_channel = (enum measured_source)measured->channel[c].source[sample];
        if (of_channel != MEASURED_NOTHING)
            source = of_channel;
    }
    return source;
}

enum mr_status measured_find_stretches(struct measured *measured, struct error *error)
{
    for (size_t i = 0; i < measured->samples; i++) {
        enum measured_source source = source_of_block(measured, i);
        int64_t block = measured->first_block + (int64_t)i;
        measured->blocks_from[source]++;
        if (measured->stretches && measured->stretch[measured->stretches - 1].source == source) {
            measured->stretch[measured->stretches - 1].to_block = block;
            continue;
        }
        if (!list_grow(&measured->stretch, measured->stretches, sizeof *measured->stretch))
            return error_set(error, MR_FULL, "no memory: RUN %lld; close other programs",
                             (long long)measured->landing.id);
        measured->stretch[measured->stretches++] = (struct measured_stretch){source, block, block};
    }
    return MR_OK;
}

/* What was set aside because of its time; false: nothing. */
static bool aside_text(const struct measured *measured, char *out, size_t size)
{
    const struct measured_aside *aside = &measured->aside;
    const struct {
        size_t count;
        const char *one, *many;
    } kinds[] = {{aside->blocks, "block record", "block records"},
                 {aside->messages, "CAN message", "CAN messages"},
                 {aside->edges, "switch edge", "switch edges"},
                 {aside->readings, "reading", "readings"}};
    size_t used = 0;
    for (size_t k = 0; k < sizeof kinds / sizeof kinds[0]; k++) {
        if (kinds[k].count && used < size)
            used += (size_t)snprintf(out + used, size - used, "%s%zu %s", used ? ", " : "",
                                     kinds[k].count,
                                     kinds[k].count == 1 ? kinds[k].one : kinds[k].many);
    }
    if (used && used < size)
        snprintf(out + used, size - used,
                 " set aside: the time lies far from the landing's (first: %.3f s of the board)",
                 (double)aside->block / 1000.0);
    return used != 0;
}

void measured_source_text(const struct measured *measured, char out[MEASURED_SOURCE_TEXT])
{
    static const enum measured_source order[] = {MEASURED_SERIAL, MEASURED_BOX, MEASURED_CAN,
                                                 MEASURED_IMPORT, MEASURED_NOTHING};
    size_t used = (size_t)snprintf(out, MEASURED_SOURCE_TEXT, "%s",
                                   sources[measured->source].alone);
    const char *separator = ";";
    for (unsigned k = 0; k < MEASURED_SOURCES && used < MEASURED_SOURCE_TEXT; k++) {
        size_t stretches = 0;
        if (order[k] == measured->source || !measured->blocks_from[order[k]])
            continue;
        for (size_t i = 0; i < measured->stretches; i++)
            stretches += measured->stretch[i].source == order[k];
        used += (size_t)snprintf(
            out + used, MEASURED_SOURCE_TEXT - used, "%s %lld of %zu ms %s, %zu %s", separator,
            (long long)measured->blocks_from[order[k]], measured->samples, sources[order[k]].filled,
            stretches, stretches == 1 ? "stretch" : "stretches");
        separator = ",";
    }
    if (measured->skipped_blocks && used < MEASURED_SOURCE_TEXT)
        used += (size_t)snprintf(out + used, MEASURED_SOURCE_TEXT - used,
                                 "; %lld ms before them are in the campaign alone",
                                 (long long)measured->skipped_blocks);
    if (used < MEASURED_SOURCE_TEXT &&
        aside_text(measured, out + used + 2, MEASURED_SOURCE_TEXT - used - 2))
        memcpy(out + used, "; ", 2);
}

void measured_aside_note(const struct measured *measured, const struct cli *cli)
{
    char text[MEASURED_SOURCE_TEXT];
    if (aside_text(measured, text, sizeof text))
        cli_note(cli, "RUN %lld: %s", (long long)measured->landing.id, text);
}

json_t *measured_aside_json(const struct measured *measured)
{
    const struct measured_aside *aside = &measured->aside;
    if (aside->blocks + aside->messages + aside->edges + aside->readings == 0)
        return json_null();
    return json_pack("{sIsIsIsIsI}", "blocks", (json_int_t)aside->blocks, "messages",
                     (json_int_t)aside->messages, "edges", (json_int_t)aside->edges, "readings",
                     (json_int_t)aside->readings, "first_block", (json_int_t)aside->block);
}
