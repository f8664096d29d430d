#include "host/sim/scene/scene_units.h"

bool sim_unit_read(const struct sim_key *key, const json_t *value, double *number,
                   struct quantity_wrong *wrong)
{
    return quantity_json(value, quantity_kind_of(key->unit) ? key->unit : "", number, wrong);
}
