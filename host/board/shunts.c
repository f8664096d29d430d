#include "host/board/shunts.h"

#include <math.h>

void shunts_take(struct shunts *shunts, uint32_t id, const uint8_t *bytes, size_t length)
{
    struct mr_shunt_check check;
    if (id == MR_ID_SHUNT) {
        shunts->begun = true;
        shunts->count = 0;
    } else if (id == MR_ID_SHUNT_RESULT) {
        if (shunts->begun && shunts->count < MR_GAGES &&
            mr_shunt_result_get(&shunts->result[shunts->count], bytes, length) == MR_OK)
            shunts->check[shunts->count++] = (struct mr_shunt_check){
                .expected_lb = NAN, .change_lb = NAN, .zero_change_lb = NAN};
    } else if (id == MR_ID_SHUNT_CHECK && shunts->count &&
               mr_shunt_check_get(&check, bytes, length) == MR_OK &&
               check.gage == shunts->result[shunts->count - 1].gage) {
        shunts->check[shunts->count - 1] = check;
    }
}

const char *shunts_verdict_text(int64_t verdict)
{
    return verdict >= MR_SHUNT_GOOD && verdict <= MR_SHUNT_WRONG
             ? mr_shunt_verdict_text((unsigned)verdict)
             : "not calibrated";
}
