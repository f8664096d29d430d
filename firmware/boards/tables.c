#include "firmware/boards/tables.h"

#include <stdlib.h>
#include <string.h>

#include "common/image.h"

#define TABLE(part) zg_##part
#define BOARD_FILE  "firmware/boards/zg.def"
#include "firmware/boards/table.def"
#define TABLE(part) discovery_##part
#define BOARD_FILE  "firmware/boards/discovery.def"
#include "firmware/boards/table.def"
#define TABLE(part) nucleo446_##part
#define BOARD_FILE  "firmware/boards/nucleo446.def"
#include "firmware/boards/table.def"

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define OF(name)                                                                            \
    {                                                                                       \
        name##_rows, COUNT(name##_rows), name##_facts, COUNT(name##_facts), name##_regions, \
            COUNT(name##_regions)                                                           \
    }

static const struct board_table tables[] = {
    [MR_BOARD_ZG] = OF(zg),
    [MR_BOARD_DISCOVERY] = OF(discovery),
    [MR_BOARD_NUCLEO446] = OF(nucleo446),
};

const struct board_table *board_table_by_number(unsigned number)
{
    return number < COUNT(tables) ? &tables[number] : NULL;
}

const struct board_region *board_region_by_name(const struct board_table *table, const char *name)
{
    for (size_t i = 0; i < table->regions; i++) {
        if (strcmp(table->region[i].name, name) == 0)
            return &table->region[i];
    }
    abort();
}

long board_fact_value(const struct board_table *table, const char *name)
{
    for (size_t i = 0; i < table->facts; i++) {
        if (strcmp(table->fact[i].name, name) == 0)
            return table->fact[i].value;
    }
    abort();
}
