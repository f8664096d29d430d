#include "host/advise/arming.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/store/store_readiness.h"
#include "host/survey/survey.h"

static void append_line(char out[ARMING_TEXT_SIZE], const char *format, ...)
    __attribute__((format(printf, 2, 3)));
static void append_line(char out[ARMING_TEXT_SIZE], const char *format, ...)
{
    size_t at = strlen(out);
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(out + at, ARMING_TEXT_SIZE - at, format, arguments);
    va_end(arguments);
}

static void check_advice(struct store *store, int64_t armed_us, char out[ARMING_TEXT_SIZE])
{
    struct error ignored = {0};
    struct store_advice *rows = NULL;
    size_t count = 0;
    (void)store_advices_get(store, &rows, &count, &ignored);
    if (count && rows[count - 1].made_us > armed_us &&
        strcmp(rows[count - 1].verdict, "against") == 0)
        append_line(out, "matrig advise recommends against the next landing: %.300s\n",
                    rows[count - 1].reason);
    free(rows);
}

/* Warns if the newest survey is unfinished, older than the last landing, or not loaded. Sets
 * *runway_loaded_us to the time at which it was loaded into a board; 0: never. */
static void check_survey(struct store *store, int64_t armed_us, int64_t *runway_loaded_us,
                         char out[ARMING_TEXT_SIZE])
{
    struct error ignored = {0};
    struct store_gage_survey *rows = NULL;
    size_t count = 0;
    (void)store_gage_surveys_get(store, &rows, &count, &ignored);
    if (count) {
        const struct store_gage_survey *row = &rows[count - 1];
        (void)store_gage_load_time_get(store, row->id, runway_loaded_us, &ignored);
        if (row->ended_us == STORE_NONE)
            append_line(out,
                        "survey %lld is not finished; continue the survey with matrig survey DB\n",
                        (long long)row->id);
        else if (row->made_us < armed_us)
            append_line(out,
                        "the mat has not been surveyed since the last landing (newest survey: "
                        "%lld); run matrig survey DB\n",
                        (long long)row->id);
        else if (!*runway_loaded_us)
            append_line(
                out, "survey %lld is not loaded into the board; run matrig survey DB --load LINK\n",
                (long long)row->id);
    }
    free(rows);
}

static void check_readiness(struct store *store, int64_t now_us, int64_t armed_us,
                            int64_t runway_loaded_us, char out[ARMING_TEXT_SIZE])
{
    struct error ignored = {0};
    struct store_readiness row = {0};
    bool found = false;
    char uid[25] = "", at[40];
    if (store_newest_board_get(store, uid, &ignored) == MR_OK && uid[0])
        (void)store_readiness_get(store, uid, "ready", now_us, false, &row, &found, &ignored);
    if (!found)
        return;
    survey_format_time(row.made_us, at, sizeof at);
    if (strcmp(row.verdict, "go") != 0)
        append_line(out, "the result of matrig ready at %s was no-go\n", at);
    else if (row.made_us < armed_us || row.made_us < runway_loaded_us ||
             now_us - row.made_us > STORE_READINESS_VALID_US)
        append_line(out, "the result of matrig ready was go at %s, %s\n", at,
                    row.made_us < armed_us           ? "before the last landing"
                    : row.made_us < runway_loaded_us ? "before the survey was loaded"
                                                     : "more than 12 h ago");
    free(row.checks);
}

void arming_write_warnings(struct store *store, int64_t now_us, char out[ARMING_TEXT_SIZE])
{
    struct store_landing landing = {0};
    struct error ignored = {0};
    int64_t run = 0, runway_loaded_us = 0;
    out[0] = '\0';
    if (store_newest_logged_run_get(store, &run, &ignored) == MR_OK && run > 0)
        (void)store_landing_get(store, run, &landing, &ignored);
    check_advice(store, landing.armed_us, out);
    check_survey(store, landing.armed_us, &runway_loaded_us, out);
    check_readiness(store, now_us, landing.armed_us, runway_loaded_us, out);
}
