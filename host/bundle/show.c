#include "host/bundle/show.h"

#include <string.h>

bool bundle_sound(const struct bundle_check *check)
{
    return check->bad == 0 && check->parts > 0 && !check->truncated;
}

/* "report.html, table frames and 3 more" */
static void name_bad(const struct bundle_check *check, char *text, size_t size)
{
    size_t told = 0, at = 0;
    text[0] = '\0';
    for (size_t i = 0; i < check->parts && told < 4; i++) {
        const struct bundle_part *part = &check->part[i];
        if (part->state == BUNDLE_WHOLE || at >= size)
            continue;
        bool file = strcmp(part->kind, "file") == 0 || strcmp(part->kind, part->name) == 0;
        at += (size_t)snprintf(text + at, size - at, "%s%s%s", told++ ? ", " : "", file ? "" : "table ", part->name);
    }
    if (check->bad > told && at < size)
        snprintf(text + at, size - at, " and %zu more", check->bad - told);
}

void bundle_verdict(const struct bundle_check *check, char *text, size_t size)
{
    char names[400];
    size_t whole = check->parts - check->bad;
    name_bad(check, names, sizeof names);
    if (check->truncated)
        snprintf(text, size, "truncated at byte %zu of %llu: %zu of %zu parts are whole; not %s", check->bytes,
                 (unsigned long long)check->whole_bytes, whole, check->parts, check->bad ? names : "its end");
    else if (check->bad)
        snprintf(text, size, "changed since it was made: %s; %zu of %zu parts are whole", names, whole, check->parts);
    else if (!check->sealed)
        snprintf(text, size, "changed since it was made, between its parts: all %zu of them are whole, other bytes are not", check->parts);
    else if (check->aside)
        snprintf(text, size, "complete, but a journal lies beside it: it is open in another program, or was changed");
    else
        snprintf(text, size, "complete: all %zu parts and every byte are as they were made", check->parts);
}

static const char *const states[] = {
    [BUNDLE_WHOLE] = "whole", [BUNDLE_CHANGED] = "changed", [BUNDLE_LOST] = "lost", [BUNDLE_FOREIGN] = "foreign"};

static bool was_saved(const struct bundle_part *part, const bool saved[BUNDLE_FILES])
{
    bool found = false;
    for (int i = 0; i < BUNDLE_FILES && saved; i++)
        found |= saved[i] && strcmp(part->kind, "file") == 0 && part->state == BUNDLE_WHOLE && strcmp(part->name, bundle_files[i].name) == 0;
    return found;
}

void bundle_print(const struct bundle_check *check, const bool saved[BUNDLE_FILES], FILE *out)
{
    char verdict[600];
    size_t tables = 0;
    long long rows = 0;
    bundle_verdict(check, verdict, sizeof verdict);
    fprintf(out, "%s: %zu bytes\n  verdict       %s\n", check->path, check->bytes, verdict);
    for (size_t i = 0; i < check->parts; i++) {
        const struct bundle_part *part = &check->part[i];
        bool file = strcmp(part->kind, "file") == 0;
        if (part->state != BUNDLE_WHOLE)
            fprintf(out, "  %-17s %s: %s%s\n", part->name, states[part->state], part->why, file ? "" : " (table)");
        else if (file)
            fprintf(out, "  %-17s %9lld bytes  %s  %s%s\n", part->name, (long long)part->bytes, part->digest, part->what,
                    was_saved(part, saved) ? "; saved" : "");
        tables += part->state == BUNDLE_WHOLE && strcmp(part->kind, "table") == 0;
        rows += part->state == BUNDLE_WHOLE ? part->rows : 0;
    }
    fprintf(out, "  %zu tables with %lld rows are whole\n", tables, rows);
}

json_t *bundle_json(const struct bundle_check *check, const bool saved[BUNDLE_FILES])
{
    char verdict[600];
    json_t *parts = json_array();
    bundle_verdict(check, verdict, sizeof verdict);
    for (size_t i = 0; i < check->parts; i++) {
        const struct bundle_part *part = &check->part[i];
        json_t *entry = json_pack("{sssssssssI}", "name", part->name, "kind", part->kind, "state", states[part->state], "sha256", part->digest,
                                  "bytes", (json_int_t)part->bytes);
        if (part->state != BUNDLE_WHOLE)
            json_object_set_new(entry, "why", json_string(part->why));
        if (saved)
            json_object_set_new(entry, "saved", json_boolean(was_saved(part, saved)));
        json_array_append_new(parts, entry);
    }
    return json_pack("{sssssbsbsbsIsIso}", "file", check->path, "verdict", verdict, "complete", bundle_sound(check) && check->sealed && !check->aside,
                     "sound", bundle_sound(check), "truncated", check->truncated, "bytes", (json_int_t)check->bytes, "whole_bytes",
                     (json_int_t)check->whole_bytes, "parts", parts);
}
