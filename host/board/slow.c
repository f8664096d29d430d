#include "host/board/slow.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "host/board/box_client.h"
#include "host/base/answer.h"
#include "host/base/output.h"
#include "host/base/xmalloc.h"

#define ROUNDS   4 /* of asking for what has not come */
#define SEQ_MAX  0x7fffffffu
#define ROWS_MAX 4096u /* more than any board holds */

struct fetch {
    struct box_client *talk;
    char uid[IDENTITY_UID_TEXT];
    uint32_t first, next;    /* numbers the board may hold: first <= seq < next */
    bool *known;             /* by seq - first: in the database, or come */
    struct store_slow *rows; /* that came */
    size_t count;
};

void slow_row(const struct mr_slowrow *row, const char *board_uid, int64_t time_us,
              struct store_slow *out)
{
    *out = (struct store_slow){.seq = row->seq ? row->seq : STORE_NONE,
                               .boot = row->boot,
                               .block = row->block,
                               .time_us = time_us,
                               .faults = row->faults,
                               .state = row->state,
                               .temperature_c = (double)row->temperature_c};
    snprintf(out->board_uid, sizeof out->board_uid, "%s", board_uid);
    for (unsigned i = 0; i < MR_TRANSDUCERS; i++)
        out->displacement_in[i] = (double)row->displacement_in[i];
    for (unsigned i = 0; i < MR_GAGES; i++)
        out->tension_lb[i] = (double)row->tension_lb[i];
}

static void take_row(void *context, const struct mr_slowrow *row)
{
    struct fetch *fetch = context;
    if (!fetch->known || row->seq < fetch->first || row->seq >= fetch->next ||
        fetch->known[row->seq - fetch->first])
        return;
    fetch->known[row->seq - fetch->first] = true;
    slow_row(row, fetch->uid, STORE_NONE, &fetch->rows[fetch->count++]);
}

static uint32_t first_missing(const struct fetch *fetch)
{
    uint32_t seq = fetch->first;
    while (seq < fetch->next && fetch->known[seq - fetch->first])
        seq++;
    return seq;
}

/* Rows of the present boot were made so long before the newest block. */
static void date_rows(struct fetch *fetch)
{
    const struct box_client *talk = fetch->talk;
    for (size_t i = 0; i < fetch->count; i++) {
        struct store_slow *row = &fetch->rows[i];
        if (talk->clock_known && row->boot == talk->slow_end.boot &&
            row->block <= (int64_t)talk->clock.block)
            row->time_us = (int64_t)talk->clock_us -
                           1000 * ((int64_t)talk->clock.block - row->block);
    }
}

static enum mr_status know(struct fetch *fetch, struct store *store, struct error *error)
{
    struct store_slow *rows = NULL;
    size_t count = 0;
    enum mr_status status = store ? store_slow_rows(store, fetch->uid, &rows, &count, error)
                                  : MR_OK;
    for (size_t i = 0; status == MR_OK && i < count; i++) {
        if (rows[i].seq >= (int64_t)fetch->first && rows[i].seq < (int64_t)fetch->next)
            fetch->known[rows[i].seq - (int64_t)fetch->first] = true;
    }
    free(rows);
    return status;
}

/* What the board holds, then all from the first that is missing, and again while more comes. */
static enum mr_status receive(struct fetch *fetch, struct store *store, struct error *error)
{
    struct box_client *talk = fetch->talk;
    enum mr_status status = box_client_slow(talk, SEQ_MAX, take_row, fetch, error);
    if (status != MR_OK)
        return status;
    fetch->next = talk->slow_end.next_seq;
    fetch->first = fetch->next > ROWS_MAX ? fetch->next - ROWS_MAX : 1;
    identity_uid_text(&talk->dialogue->identity, fetch->uid);
    fetch->known = xcalloc(ROWS_MAX + 1, sizeof *fetch->known);
    fetch->rows = xcalloc(ROWS_MAX + 1, sizeof *fetch->rows);
    status = know(fetch, store, error);
    /* Rows that the ring has lost are not asked for: there are as many as it holds, at most, before
     * the next. */
    uint32_t held = fetch->next -
                    (talk->slow_end.rows < fetch->next ? talk->slow_end.rows : fetch->next - 1u);
    for (uint32_t seq = fetch->first; seq < held; seq++)
        fetch->known[seq - fetch->first] = true;
    size_t before = SIZE_MAX;
    for (int round = 0; status == MR_OK && round < ROUNDS && first_missing(fetch) < fetch->next &&
                        fetch->count != before;
         round++) {
        before = fetch->count;
        status = box_client_slow(talk, first_missing(fetch), take_row, fetch, error);
    }
    return status;
}

static enum mr_status keep(struct store *store, const struct fetch *fetch, struct error *error)
{
    enum mr_status status = store_begin(store, error);
    for (size_t i = 0; status == MR_OK && i < fetch->count; i++)
        status = store_slow_put(store, &fetch->rows[i], error);
    return status == MR_OK ? store_commit(store, error) : status;
}

static void print_number(FILE *file, double value, int digits)
{
    if (isnan(value))
        fputc(',', file);
    else
        fprintf(file, ",%.*f", digits, value);
}

static void print_time(FILE *file, int64_t time_us)
{
    time_t s = (time_t)(time_us / 1000000);
    struct tm utc;
    char text[40];
    if (time_us == STORE_NONE || !gmtime_r(&s, &utc))
        return;
    strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
    fputs(text, file);
}

static int compare_rows(const void *a, const void *b)
{
    int64_t x = ((const struct store_slow *)a)->seq, y = ((const struct store_slow *)b)->seq;
    return (x > y) - (x < y);
}

static enum mr_status write_csv(const char *path, struct fetch *fetch, struct error *error)
{
    struct output output;
    if (output_begin(&output, path, error) != MR_OK)
        return error->status;
    FILE *file = output.file;
    qsort(fetch->rows, fetch->count, sizeof *fetch->rows, compare_rows);
    fputs("seq,boot,block_ms,time_utc,faults,state,temperature_c", file);
    for (unsigned i = 1; i <= MR_TRANSDUCERS; i++)
        fprintf(file, ",d%u_in", i);
    for (unsigned i = 1; i <= MR_GAGES; i++)
        fprintf(file, ",t%u_lb", i);
    fputc('\n', file);
    for (size_t i = 0; i < fetch->count; i++) {
        const struct store_slow *row = &fetch->rows[i];
        fprintf(file, "%lld,%lld,%lld,", (long long)row->seq, (long long)row->boot,
                (long long)row->block);
        print_time(file, row->time_us);
        fprintf(file, ",%lld,%lld", (long long)row->faults, (long long)row->state);
        print_number(file, row->temperature_c, 4);
        for (unsigned k = 0; k < MR_TRANSDUCERS; k++)
            print_number(file, row->displacement_in[k], 4);
        for (unsigned k = 0; k < MR_GAGES; k++)
            print_number(file, row->tension_lb[k], 2);
        fputc('\n', file);
    }
    return output_end(&output, error);
}

static int tell(const struct cli *cli, const struct fetch *fetch)
{
    int64_t missing = 0;
    for (uint32_t seq = fetch->first; seq < fetch->next; seq++)
        missing += !fetch->known[seq - fetch->first];
    const struct mr_slow_end *end = &fetch->talk->slow_end;
    struct answer *answer = answer_new(cli->si);
    answer_words(answer, "board", "board", "%s", fetch->uid);
    answer_count(answer, "held", "rows held", end->rows);
    answer_value(answer, NULL, "they cover", UNIT_NUMBER, (double)end->rows / 60.0, 1)->end = " h";
    answer_count(answer, "new", "new here", (int64_t)fetch->count);
    answer_count(answer, "missing", "missing", missing)->end = " numbers without a row";
    answer_count(answer, "next_seq", NULL, (int64_t)end->next_seq);
    answer_count(answer, "boot", NULL, end->boot);
    return answer_show(cli, answer, 0);
}

int slow_fetch(const struct cli *cli, struct box_client *talk, const char *db, const char *csv,
               struct error *error)
{
    struct fetch fetch = {.talk = talk};
    struct store *store = NULL;
    enum mr_status status = db ? store_open(db, STORE_CREATE, &store, error) : MR_OK;
    if (status == MR_OK)
        status = receive(&fetch, store, error);
    struct error broken = *error;
    if (fetch.count) { /* also what came before the link broke: the next call goes on from there */
        struct error late = {0};
        date_rows(&fetch);
        enum mr_status kept = db ? keep(store, &fetch, &late) : MR_OK;
        if (kept == MR_OK && csv)
            kept = write_csv(csv, &fetch, &late);
        if (kept != MR_OK && status == MR_OK) {
            status = kept;
            broken = late;
        }
    } else if (status == MR_OK && csv) {
        status = write_csv(csv, &fetch, &broken);
    }
    *error = broken;
    store_close(store);
    int exit_code = status == MR_OK ? tell(cli, &fetch) : cli_fail(error);
    free(fetch.known);
    free(fetch.rows);
    return exit_code;
}
