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
        at += (size_t)snprintf(text + at, size - at, "%s%s%s", told++ ? ", " : "",
                               file ? "" : "table ", part->name);
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
        snprintf(text, size, "truncated at byte %zu of %llu: %zu of %zu parts are whole; not %s",
                 check->bytes, (unsigned long long)check->whole_bytes, whole, check->parts,
                 check->bad ? names : "its end");
    else if (check->bad)
        snprintf(text, size, "changed since it was made: %s; %zu of %zu parts are whole", names,
                 whole, check->parts);
    else if (!check->sealed)
        snprintf(text, size,
                 "changed since it was made, between its parts: all %zu of them are whole, other "
                 "bytes are not",
                 check->parts);
    else if (check->aside)
        snprintf(text, size,
                 "complete, but a journal lies beside it: it is open in another program, or was "
                 "changed");
    else
        snprintf(text, size, "complete: all %zu parts and every byte are as they were made",
                 check->parts);
}

static const char *const states[] = {[BUNDLE_WHOLE] = "whole",
                                     [BUNDLE_CHANGED] = "changed",
                                     [BUNDLE_LOST] = "lost",
                                     [BUNDLE_FOREIGN] = "foreign"};

static bool was_saved(const struct bundle_part *part, const bool saved[BUNDLE_FILES])
{
    bool found = false;
    for (int i = 0; i < BUNDLE_FILES && saved; i++)
        found |= saved[i] && strcmp(part->kind, "file") == 0 && part->state == BUNDLE_WHOLE &&
                 strcmp(part->name, bundle_files[i].name) == 0;
    return found;
}

/* For programs, every part; for people every file, and those tables that are not whole. */
static void parts_answer(const struct bundle_check *check, const bool saved[BUNDLE_FILES],
                         struct answer *answer)
{
    answer_list(answer, "parts", NULL);
    for (size_t i = 0; i < check->parts; i++) {
        const struct bundle_part *part = &check->part[i];
        answer_row(answer);
        answer_words(answer, "name", NULL, "%s", part->name);
        answer_words(answer, "kind", NULL, "%s", part->kind);
        answer_words(answer, "state", NULL, "%s", states[part->state]);
        answer_words(answer, "sha256", NULL, "%s", part->digest);
        answer_count(answer, "bytes", NULL, part->bytes);
        if (part->state != BUNDLE_WHOLE)
            answer_words(answer, "why", NULL, "%s", part->why);
        if (saved)
            answer_flag(answer, "saved", NULL, was_saved(part, saved));
    }
    answer_close(answer);
    for (size_t i = 0; i < check->parts; i++) {
        const struct bundle_part *part = &check->part[i];
        bool file = strcmp(part->kind, "file") == 0;
        if (part->state != BUNDLE_WHOLE)
            answer_words(answer, NULL, part->name, "%s: %s%s", states[part->state], part->why,
                         file ? "" : " (table)");
        else if (file)
            answer_words(answer, NULL, part->name, "%9lld bytes  %s  %s%s", (long long)part->bytes,
                         part->digest, part->what, was_saved(part, saved) ? "; saved" : "");
    }
}

void bundle_answer(const struct bundle_check *check, const bool saved[BUNDLE_FILES],
                   struct answer *answer)
{
    char verdict[600];
    long long tables = 0, rows = 0;
    bundle_verdict(check, verdict, sizeof verdict);
    for (size_t i = 0; i < check->parts; i++) {
        bool whole = check->part[i].state == BUNDLE_WHOLE;
        tables += whole && strcmp(check->part[i].kind, "table") == 0;
        rows += whole ? check->part[i].rows : 0;
    }
    answer_words(answer, "file", "file", "%s", check->path);
    answer_count(answer, "bytes", "bytes", (int64_t)check->bytes);
    answer_words(answer, "verdict", "verdict", "%s", verdict);
    answer_flag(answer, "complete", NULL, bundle_sound(check) && check->sealed && !check->aside);
    answer_flag(answer, "sound", NULL, bundle_sound(check));
    answer_flag(answer, "truncated", NULL, check->truncated);
    answer_count(answer, "whole_bytes", NULL, (int64_t)check->whole_bytes);
    parts_answer(check, saved, answer);
    answer_words(answer, NULL, "tables", "%lld with %lld rows are whole", tables, rows);
}
