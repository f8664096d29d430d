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

#define ROW_COUNT(array) (sizeof(array) / sizeof(array)[0])
#define TABLE_OF(name)                                                              \
    {                                                                               \
        name##_rows, ROW_COUNT(name##_rows), name##_facts, ROW_COUNT(name##_facts), \
            name##_regions, ROW_COUNT(name##_regions)                               \
    }

static const struct board_table tables[] = {
    [MR_BOARD_ZG] = TABLE_OF(zg),
    [MR_BOARD_DISCOVERY] = TABLE_OF(discovery),
    [MR_BOARD_NUCLEO446] = TABLE_OF(nucleo446),
};

const struct board_table *board_table_by_number(unsigned number)
{
    return number < ROW_COUNT(tables) ? &tables[number] : NULL;
}

const struct board_region *board_region_by_name(const struct board_table *table, const char *name)
{
    for (size_t i = 0; i < table->region_count; i++) {
        if (strcmp(table->region[i].name, name) == 0)
            return &table->region[i];
    }
    abort();
}

long board_constant_value(const struct board_table *table, const char *name)
{
    for (size_t i = 0; i < table->constant_count; i++) {
        if (strcmp(table->constant[i].name, name) == 0)
            return table->constant[i].value;
    }
    abort();
}
