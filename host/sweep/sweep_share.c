#include "host/sweep/sweep_share.h"

#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- shards ---- */

static bool whole_number(const char *text, long low, long high, unsigned *number)
{
    char *end;
    long value = text ? strtol(text, &end, 10) : 0;
    if (!text || end == text || *end || value < low || value > high)
        return false;
    *number = (unsigned)value;
    return true;
}

/* An array 1-n or 0-(n-1). Another one was not made for this, or leaves some out: how many there
 * should be is not known. */
static enum mr_status shard_of_slurm(struct sweep_shard *shard, const char *task,
                                     struct error *error)
{
    unsigned low, high, count, id;
    if (!whole_number(task, 0, SWEEP_SHARDS_MAX, &id) ||
        !whole_number(getenv("SLURM_ARRAY_TASK_MIN"), 0, 1, &low) ||
        !whole_number(getenv("SLURM_ARRAY_TASK_MAX"), 0, SWEEP_SHARDS_MAX, &high) ||
        !whole_number(getenv("SLURM_ARRAY_TASK_COUNT"), 1, SWEEP_SHARDS_MAX, &count) ||
        count != high - low + 1 || id < low || id > high)
        return error_set(error, MR_USAGE,
                         "no shard: SLURM_ARRAY_TASK_ID is %.40s, of an array that is not 1-N or "
                         "0-N; give --shard /N, N shards in all",
                         task);
    *shard = (struct sweep_shard){id - low + 1, count};
    return MR_OK;
}

enum mr_status sweep_shard_read(struct sweep_shard *shard, const char *text, struct error *error)
{
    const char *task = getenv("SLURM_ARRAY_TASK_ID");
    *shard = (struct sweep_shard){0};
    if (!text)
        return task ? shard_of_slurm(shard, task, error) : MR_OK;
    char i[40] = "";
    const char *slash = strchr(text, '/');
    if (slash && slash - text < (long)sizeof i)
        memcpy(i, text, (size_t)(slash - text));
    if (slash == text && !task)
        return error_set(error, MR_USAGE,
                         "no shard: %s, but SLURM_ARRAY_TASK_ID is not set; give --shard i/n",
                         text);
    if (!slash || !whole_number(slash + 1, 1, SWEEP_SHARDS_MAX, &shard->n) ||
        !whole_number(slash == text ? task : i, 1, shard->n, &shard->i))
        return error_set(error, MR_USAGE, "no shard: --shard %s%s%s; give i/n, i from 1 to n", text,
                         slash == text ? " with SLURM_ARRAY_TASK_ID " : "",
                         slash == text ? task : "");
    return MR_OK;
}

/* Length of the path without the ending ".jsonl", if it has that. */
static int stem(const char *results)
{
    size_t length = strlen(results);
    return (int)(length > 6 && strcmp(results + length - 6, ".jsonl") == 0 ? length - 6 : length);
}

void sweep_shard_path(const char *results, const struct sweep_shard *shard, char *out)
{
    if (shard->n == 0)
        snprintf(out, SWEEP_PATH_MAX + 40, "%s", results);
    else
        snprintf(out, SWEEP_PATH_MAX + 40, "%.*s.%u-of-%u.jsonl", stem(results), results, shard->i,
                 shard->n);
}

void sweep_study_path(const char *results, char *out)
{
    snprintf(out, SWEEP_PATH_MAX + 40, "%.*s.study.json", stem(results), results);
}

/* The files of all shards there are; names that glob takes for patterns are quoted. */
static void find_parts(const char *results, glob_t *found)
{
    char pattern[2 * SWEEP_PATH_MAX + 60], *at = pattern;
    for (int i = 0; i < stem(results) && i < SWEEP_PATH_MAX; i++) {
        if (strchr("*?[\\", results[i]))
            *at++ = '\\';
        *at++ = results[i];
    }
    snprintf(at, 40, ".[0-9]*-of-[0-9]*.jsonl");
    if (glob(pattern, 0, NULL, found) != 0)
        found->gl_pathc = 0;
}

/* ---- what is done ---- */

struct reading {
    struct sweep_done *done;
    const char *path;
    bool other; /* not the file being written */
};

static enum mr_status foreign(const char *path, size_t number, uint64_t id, struct error *error)
{
    char text[SWEEP_ID_SIZE];
    sweep_id_text(id, text);
    return error_set(error, MR_MALFORMED,
                     "results of another sweep: %s line %zu: case %s is not in this one; move the "
                     "file away, or give another with -o",
                     path, number, text);
}

static bool failed(const json_t *line)
{
    return strcmp(json_string_value(json_object_get(line, "status")), "ok") != 0;
}

static enum mr_status count_line(void *ctx, size_t number, uint64_t id, const json_t *line,
                                 const char *text, struct error *error)
{
    struct reading *r = ctx;
    size_t index;
    (void)text;
    if (!sweep_study_find(r->done->study, id, &index))
        return foreign(r->path, number, id, error);
    if (r->other && r->done->retry && failed(line))
        return MR_OK;
    if (r->done->done[index]) {
        r->done->twice++;
        return MR_OK;
    }
    r->done->done[index] = true;
    r->done->count++;
    r->done->failed += failed(line);
    return MR_OK;
}

static enum mr_status count_other(struct sweep_done *done, const struct sweep_results *own,
                                  const char *path, struct error *error)
{
    struct reading r = {done, path, true};
    return strcmp(path, own->path) == 0 ? MR_OK : sweep_results_read(path, count_line, &r, error);
}

enum mr_status sweep_done_load(struct sweep_done *done, const struct sweep_study *study,
                               const struct sweep_results *own, const char *results,
                               struct error *error)
{
    glob_t found = {0};
    struct reading r = {done, own->path, false};
    *done = (struct sweep_done){
        .study = study, .retry = done->retry, .done = calloc(study->cases, sizeof *done->done)};
    if (!done->done)
        return error_set(error, MR_FULL, "out of memory: %zu cases; split the sweep", study->cases);
    if (sweep_results_lines(own, count_line, &r, error) != MR_OK)
        return error->status;
    /* within one file; the same case in two files is nothing new after gathering */
    size_t twice = done->twice;
    count_other(done, own, results, error);
    find_parts(results, &found);
    for (size_t i = 0; i < found.gl_pathc && error->status == MR_OK; i++)
        count_other(done, own, found.gl_pathv[i], error);
    globfree(&found);
    done->twice = twice;
    return error->status;
}

/* ---- gathering ---- */

struct gathering {
    struct sweep_done *done;
    const char *path;
    char **text;   /* [cases]: its line, owned */
    bool *failed;  /* [cases]: that line says so */
    bool *outdone; /* [cases]: R's line is a failure, a shard's is none */
    bool any_outdone;
    struct sweep_gathered *gathered;
};

static bool same_but_time(const char *a, const char *b)
{
    json_t *left = json_loads(a, 0, NULL), *right = json_loads(b, 0, NULL);
    json_object_del(left, "cpu_ms");
    json_object_del(right, "cpu_ms");
    bool same = json_equal(left, right);
    json_decref(left);
    json_decref(right);
    return same;
}

static enum mr_status take_line(void *ctx, size_t number, uint64_t id, const json_t *line,
                                const char *text, struct error *error)
{
    struct gathering *g = ctx;
    size_t index;
    if (!sweep_study_find(g->done->study, id, &index))
        return foreign(g->path, number, id, error);
    if (g->text[index] && g->failed[index] <= failed(line)) { /* nothing better */
        if (g->failed[index] == failed(line) && !g->failed[index] &&
            !same_but_time(g->text[index], text)) {
            g->gathered->differ++;
            sweep_id_text(id, g->gathered->differs);
        }
        return MR_OK;
    }
    if (g->text[index])
        g->any_outdone = g->outdone[index] = true;
    free(g->text[index]);
    g->failed[index] = failed(line);
    g->text[index] = strdup(text);
    return g->text[index]
             ? MR_OK
             : error_set(error, MR_FULL, "out of memory: %s; gather fewer files", g->path);
}

static bool not_outdone(void *ctx, const json_t *line)
{
    const struct gathering *g = ctx;
    uint64_t id;
    size_t index;
    if (!sweep_id_parse(json_string_value(json_object_get(line, "case")), &id) ||
        !sweep_study_find(g->done->study, id, &index))
        return true;
    return !(g->outdone[index] && failed(line));
}

static enum mr_status take_parts(struct gathering *g, const struct sweep_results *into,
                                 const char *const *parts, size_t count, struct error *error)
{
    g->path = into->path;
    sweep_results_lines(into, take_line, g, error); /* what R has comes first */
    for (size_t i = 0; i < count && error->status == MR_OK; i++) {
        if (strcmp(parts[i], into->path) == 0)
            continue; /* reading it by its path would end the lock */
        g->path = parts[i];
        g->gathered->parts++;
        sweep_results_read(parts[i], take_line, g, error);
    }
    return error->status;
}

static enum mr_status mark_own(void *ctx, size_t number, uint64_t id, const json_t *line,
                               const char *text, struct error *error)
{
    struct sweep_done *done = ctx;
    size_t index;
    (void)number;
    (void)line;
    (void)text;
    (void)error;
    if (sweep_study_find(done->study, id, &index))
        done->done[index] = true;
    return MR_OK;
}

/* Those that R does not have yet, in order. */
static enum mr_status append_new(struct gathering *g, struct sweep_results *into,
                                 struct error *error)
{
    struct sweep_done own = {.study = g->done->study,
                             .done = calloc(g->done->study->cases, sizeof *own.done)};
    if (!own.done)
        return error_set(error, MR_FULL, "out of memory: %zu cases; split the sweep",
                         g->done->study->cases);
    sweep_results_lines(into, mark_own, &own, error);
    for (size_t i = 0; i < g->done->study->cases && error->status == MR_OK; i++) {
        if (!g->text[i] || own.done[i])
            continue;
        if (sweep_results_append(into, g->text[i], error) == MR_OK)
            g->gathered->added++;
    }
    free(own.done);
    return error->status == MR_OK ? sweep_results_sync(into, error) : error->status;
}

enum mr_status sweep_gather(struct sweep_results *into, struct sweep_done *done,
                            const char *results, const char *const *parts, size_t part_count,
                            struct sweep_gathered *gathered, struct error *error)
{
    glob_t found = {0};
    size_t cases = done->study->cases;
    struct gathering g = {.done = done,
                          .gathered = gathered,
                          .text = calloc(cases, sizeof *g.text),
                          .failed = calloc(cases, sizeof(bool)),
                          .outdone = calloc(cases, sizeof(bool))};
    *gathered = (struct sweep_gathered){0};
    if (!g.text || !g.failed || !g.outdone)
        error_set(error, MR_FULL, "out of memory: %zu cases; split the sweep", cases);
    if (!parts) {
        find_parts(results, &found);
        parts = (const char *const *)found.gl_pathv;
        part_count = found.gl_pathc;
    }
    if (error->status == MR_OK && take_parts(&g, into, parts, part_count, error) == MR_OK &&
        g.any_outdone)
        sweep_results_rewrite(into, not_outdone, &g, error);
    if (error->status == MR_OK)
        append_new(&g, into, error);
    for (size_t i = 0; g.text && i < cases; i++)
        free(g.text[i]);
    free(g.text);
    free(g.failed);
    free(g.outdone);
    globfree(&found);
    return error->status;
}
