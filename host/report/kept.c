#include "host/report/kept.h"

#include <sha2.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "host/base/output.h"
#include "host/base/place.h"

#define PATH_MOST 4200
#define NS_PER_S  1000000000

/* Before the pages in the file; behind them SHA-256 of all before it. */
struct head {
    char what[16], program[REPORT_HASH];
    struct kept_front front;
    uint64_t pages, page_bytes;
};
static const char what[16] = "matrig report";

/* SHA-256 of the program that runs: another one may draw otherwise. "": it cannot be read. */
static void hash_program(char hash[REPORT_HASH])
{
    char path[PATH_MOST];
    place_program(path, sizeof path);
    if (!SHA256File(path, hash) && !SHA256File("/proc/self/exe", hash))
        hash[0] = '\0';
}

static bool file_path(const char *folder, char path[PATH_MOST])
{
    return snprintf(path, PATH_MOST, "%s/" KEPT_FILE, folder) < PATH_MOST;
}

/* Reads, and adds to the hash. */
static bool take_part(void *part, size_t size, SHA2_CTX *hash, FILE *file)
{
    if (fread(part, size, 1, file) != 1)
        return false;
    SHA256Update(hash, part, size);
    return true;
}

/* False: not what this program kept. */
static bool take(struct kept *kept, FILE *file)
{
    struct head head;
    struct stat info;
    SHA2_CTX hash;
    uint8_t is[SHA256_DIGEST_LENGTH], said[SHA256_DIGEST_LENGTH];
    const size_t each = sizeof *kept->page + sizeof *kept->facts;
    SHA256Init(&hash);
    if (!kept->program[0] || fstat(fileno(file), &info) != 0 ||
        !take_part(&head, sizeof head, &hash, file) || memcmp(head.what, what, sizeof what) != 0 ||
        memcmp(head.program, kept->program, sizeof head.program) != 0 || head.page_bytes != each ||
        head.pages > (uint64_t)info.st_size / each)
        return false;
    kept->page = calloc(head.pages + 1, sizeof *kept->page);
    kept->facts = calloc(head.pages + 1, sizeof *kept->facts);
    bool whole = kept->page && kept->facts;
    for (size_t i = 0; i < head.pages && whole; i++)
        whole = take_part(&kept->page[i], sizeof *kept->page, &hash, file) &&
                take_part(&kept->facts[i], sizeof *kept->facts, &hash, file);
    SHA256Final(is, &hash);
    if (!whole || fread(said, sizeof said, 1, file) != 1 || memcmp(is, said, sizeof is) != 0)
        return false;
    kept->pages = head.pages;
    kept->front = head.front;
    return true;
}

void kept_load(struct kept *kept, const char *folder)
{
    char path[PATH_MOST];
    memset(kept, 0, sizeof *kept);
    hash_program(kept->program);
    FILE *file = file_path(folder, path) ? fopen(path, "r") : NULL;
    if (!file)
        return;
    if (!take(kept, file))
        kept_free(kept);
    fclose(file);
}

static void put_part(const void *part, size_t size, SHA2_CTX *hash, FILE *file)
{
    fwrite(part, size, 1, file);
    SHA256Update(hash, part, size);
}

static bool is_there(const struct kept_page *page)
{
    return page->file.bytes > 0;
}

static void put_all(const struct kept *kept, FILE *file)
{
    struct head head;
    struct report_facts facts;
    SHA2_CTX hash;
    uint8_t sum[SHA256_DIGEST_LENGTH];
    memset(&head, 0, sizeof head);
    memcpy(head.what, what, sizeof what);
    memcpy(head.program, kept->program, sizeof head.program);
    head.front = kept->front;
    head.page_bytes = sizeof *kept->page + sizeof *kept->facts;
    for (size_t i = 0; i < kept->pages; i++)
        head.pages += is_there(&kept->page[i]);
    SHA256Init(&hash);
    put_part(&head, sizeof head, &hash, file);
    for (size_t i = 0; i < kept->pages; i++) {
        if (!is_there(&kept->page[i]))
            continue;
        facts = kept->facts[i];
        facts.record.why = facts.record.outcome.why = NULL;
        put_part(&kept->page[i], sizeof *kept->page, &hash, file);
        put_part(&facts, sizeof facts, &hash, file);
    }
    SHA256Final(sum, &hash);
    fwrite(sum, sizeof sum, 1, file);
}

enum mr_status kept_save(const struct kept *kept, const char *folder, bool force,
                         struct error *error)
{
    char path[PATH_MOST];
    struct output output;
    if (!file_path(folder, path) || output_begin(&output, path, force, error) != MR_OK)
        return error->status;
    put_all(kept, output.file);
    return output_end(&output, error);
}

void kept_free(struct kept *kept)
{
    free(kept->page);
    free(kept->facts);
    kept->page = NULL;
    kept->facts = NULL;
    kept->pages = 0;
}

const struct kept_page *kept_find(const struct kept *kept, int64_t run)
{
    const struct kept_page *page = kept->page;
    size_t low = 0, high = kept->pages;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (page[middle].run < run)
            low = middle + 1;
        else
            high = middle;
    }
    return low < kept->pages && page[low].run == run ? &page[low] : NULL;
}

struct kept_file kept_file_at(const char *path)
{
    struct stat info;
    if (stat(path, &info) != 0 || !S_ISREG(info.st_mode))
        return (struct kept_file){0, 0};
    return (struct kept_file){(int64_t)info.st_size,
                              (int64_t)info.st_mtim.tv_sec * NS_PER_S + info.st_mtim.tv_nsec};
}

bool kept_same_file(struct kept_file a, struct kept_file b)
{
    return a.bytes > 0 && a.bytes == b.bytes && a.written_ns == b.written_ns;
}
