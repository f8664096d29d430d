/* What matrig-board reads: recorded runs, replays, fault files; the first byte chooses. */
#include "hil/rig/faults.h"
#include "hil/rig/replay.h"
#include "hil/rig/runfile.h"
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct hil_fault_script script;
    char error[400] = "";
    struct hil_run run = {0};
    struct hil_replay replay = {0};
    enum mr_status status;
    if (size < 1)
        return 0;
    const char *path = fuzz_file("file", data + 1, size - 1);
    switch (data[0] % 3u) {
    case 0:
        status = hil_run_read(path, &run, error, sizeof error);
        if (status == MR_OK)
            hil_run_free(&run);
        break;
    case 1:
        status = hil_replay_read(path, &replay, error, sizeof error);
        if (status == MR_OK)
            hil_replay_free(&replay);
        break;
    default: status = hil_faults_read(path, NULL, &script, error, sizeof error);
    }
    FUZZ_REQUIRE(status == MR_OK || error[0]);
    return 0;
}
