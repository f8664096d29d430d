/* Results of a sweep (JSON lines), studies and campaign files; the first byte says which. */
#include "host/campaign/campaign.h"
#include "host/sweep/sweep_table.h"
#include "tests/fuzz/fuzz.h"

static enum mr_status read_results(const uint8_t *data, size_t size, struct error *error)
{
    struct sweep_table table;
    enum mr_status status = sweep_table_load(&table, fuzz_file("r.jsonl", data, size), error);
    if (status != MR_OK)
        return status;
    for (size_t i = 0; i < table.count; i++)
        FUZZ_REQUIRE(sweep_table_status(&table.rows[i]));
    sweep_table_free(&table);
    return MR_OK;
}

static enum mr_status read_study(const uint8_t *data, size_t size, struct error *error)
{
    struct sweep_study study;
    enum mr_status status = sweep_study_load(&study, fuzz_file("study.json", data, size), error);
    if (status != MR_OK)
        return status;
    FUZZ_REQUIRE(study.cases > 0);
    json_decref(sweep_study_values(&study, study.cases - 1));
    json_decref(sweep_study_input(&study, study.cases - 1));
    sweep_study_free(&study);
    return MR_OK;
}

static enum mr_status read_campaign(const uint8_t *data, size_t size, struct error *error)
{
    struct campaign campaign;
    enum mr_status status = campaign_load(&campaign, fuzz_file("campaign.json", data, size), error);
    if (status == MR_OK)
        campaign_free(&campaign);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct error error = {0};
    if (size == 0)
        return 0;
    enum mr_status status = data[0] == 'r' ? read_results(data + 1, size - 1, &error)
                          : data[0] == 's' ? read_study(data + 1, size - 1, &error)
                                           : read_campaign(data + 1, size - 1, &error);
    FUZZ_REQUIRE(status == MR_OK || error.text[0]);
    return 0;
}
