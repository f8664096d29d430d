/* Results of a sweep (JSON lines), sweeps and campaign files; the first byte says which. */
#include "host/landing_series/series.h"
#include "host/sweep/sweep_table.h"
#include "tests/fuzz/fuzz.h"

static enum mr_status read_results(const uint8_t *data, size_t size, struct error *error)
{
    static const char text[] = "{\"base\": {\"model\": \"chain\", \"N\": 2}, \"vary\": {\"F\": "
                               "[1, 2]}, \"outputs\": [\"status\"]}";
    struct sweep sweep;
    struct sweep_table table;
    FUZZ_REQUIRE(sweep_load(&sweep, fuzz_file("s.json", (const uint8_t *)text, sizeof text - 1),
                            error) == MR_OK);
    const char *const paths[] = {fuzz_file("r.jsonl", data, size), NULL};
    if (sweep_table_load(&table, &sweep, paths, error) == MR_OK)
        answer_free(sweep_table_to_answer(&table, true));
    sweep_table_free(&table);
    sweep_free(&sweep);
    return error->status;
}

static enum mr_status read_sweep(const uint8_t *data, size_t size, struct error *error)
{
    struct sweep sweep;
    enum mr_status status = sweep_load(&sweep, fuzz_file("sweep.json", data, size), error);
    if (status != MR_OK)
        return status;
    FUZZ_REQUIRE(sweep.case_count > 0);
    json_decref(sweep_case_values(&sweep, sweep.case_count - 1));
    json_decref(sweep_case_input(&sweep, sweep.case_count - 1));
    sweep_free(&sweep);
    return MR_OK;
}

static enum mr_status read_study(const uint8_t *data, size_t size, struct error *error)
{
    struct landing_series series;
    enum mr_status status = series_load(&series, fuzz_file("campaign.json", data, size), error);
    if (status == MR_OK)
        series_free(&series);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct error error = {0};
    if (size == 0)
        return 0;
    enum mr_status status = data[0] == 'r' ? read_results(data + 1, size - 1, &error)
                          : data[0] == 's' ? read_sweep(data + 1, size - 1, &error)
                                           : read_study(data + 1, size - 1, &error);
    FUZZ_REQUIRE(status == MR_OK || error.text[0]);
    return 0;
}
