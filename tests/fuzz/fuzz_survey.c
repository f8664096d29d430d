/* Sheets of a survey, CSV, for either pattern; and lines as a caliper types them. */
#include <math.h>
#include <string.h>

#include "host/survey/survey.h"
#include "tests/fuzz/fuzz.h"

static void type_lines(struct survey_progress *progress, const char *text, size_t size)
{
    char line[200];
    for (const char *end = text + size; text < end;) {
        const char *newline = memchr(text, '\n', (size_t)(end - text));
        size_t length = (size_t)((newline ? newline : end) - text),
               kept = length < sizeof line ? length : sizeof line - 1;
        struct survey_entry entry;
        size_t item;
        memcpy(line, text, kept);
        line[kept] = '\0';
        survey_entry_parse(line, false, &entry);
        FUZZ_REQUIRE(entry.kind != SURVEY_ENTRY_NUMBER || isfinite(entry.value_in));
        if (entry.kind != SURVEY_ENTRY_QUIT && entry.kind != SURVEY_ENTRY_HELP &&
            entry.kind != SURVEY_ENTRY_EMPTY)
            survey_progress_apply(progress, &entry, &item);
        FUZZ_REQUIRE(progress->current_item <= progress->plan.count &&
                     survey_progress_count_read(progress) <= progress->plan.count);
        text += length + 1;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct survey_progress progress;
    static struct survey_sheet sheet;
    struct error error = {0};
    survey_progress_init(&progress, SURVEY_EDGE_LEFT);
    enum mr_status status = survey_sheet_read(fuzz_file("sheet.csv", data, size), &progress.plan,
                                              &sheet, &error);
    FUZZ_REQUIRE(status == MR_OK || error.text[0]);
    for (size_t i = 0; status == MR_OK && i < progress.plan.count; i++)
        FUZZ_REQUIRE(isnan(sheet.value_in[i]) || isfinite(sheet.value_in[i]));
    type_lines(&progress, (const char *)data, size);
    return 0;
}
