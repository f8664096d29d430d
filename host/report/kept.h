/* What a folder of pages keeps in a file of its own, so that a landing is read again only when
 * something changed: for each page what it rests on, how it was left, and its facts.
 *
 * The file is of one program on one computer: another matrig, a damaged file or none keep
 * nothing, and every page is made anew. */
#ifndef MATRIG_HOST_REPORT_KEPT_H
#define MATRIG_HOST_REPORT_KEPT_H

#include "host/report/report.h"

#define KEPT_FILE ".matrig-report"

/* A file as it was left. */
struct kept_file {
    int64_t bytes, written_ns; /* 0, 0: there is none */
};

struct kept_page {
    int64_t run;
    char digest[REPORT_HASH]; /* of what it rests on */
    struct kept_file file;
};

struct kept {
    char program[REPORT_HASH]; /* of this matrig */
    struct kept_front {
        char drawn[REPORT_HASH]; /* of its <main> to </main> */
        struct kept_file file;
    } front;
    struct kept_page *page;     /* by rising run */
    struct report_facts *facts; /* of each; pointers in them lead nowhere */
    size_t pages;
};

/* Of a folder; nothing where nothing is kept. The caller frees it with kept_free. */
void kept_load(struct kept *kept, const char *folder);
/* Puts the file in its place, whole: of the pages that are there (file.bytes). */
enum mr_status kept_save(const struct kept *kept, const char *folder, bool force,
                         struct error *error);
void kept_free(struct kept *kept);
/* NULL: there is none. */
const struct kept_page *kept_find(const struct kept *kept, int64_t run);

struct kept_file kept_file_at(const char *path);
bool kept_same_file(struct kept_file a, struct kept_file b);

#endif
