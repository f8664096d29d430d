#include "firmware/boards/tables.h"

#include <stdlib.h>
#include <string.h>

#include "common/image.h"

static const struct board_row zg_rows[] = {
#define BOARD_FILE "firmware/boards/zg.def"
#include "firmware/boards/rows.def"
};
static const struct board_fact zg_facts[] = {
#define BOARD_FILE "firmware/boards/zg.def"
#include "firmware/boards/facts.def"
};

static const struct board_row discovery_rows[] = {
#define BOARD_FILE "firmware/boards/discovery.def"
#include "firmware/boards/rows.def"
};
static const struct board_fact discovery_facts[] = {
#define BOARD_FILE "firmware/boards/discovery.def"
#include "firmware/boards/facts.def"
};

static const struct board_row nucleo446_rows[] = {
#define BOARD_FILE "firmware/boards/nucleo446.def"
#include "firmware/boards/rows.def"
};
static const struct board_fact nucleo446_facts[] = {
#define BOARD_FILE "firmware/boards/nucleo446.def"
#include "firmware/boards/facts.def"
};

#define COUNT(array) (sizeof(array) / sizeof(array)[0])
#define TABLE(name)                                                        \
    {                                                                      \
        name##_rows, COUNT(name##_rows), name##_facts, COUNT(name##_facts) \
    }

static const struct board_table tables[] = {
    [MR_BOARD_ZG] = TABLE(zg),
    [MR_BOARD_DISCOVERY] = TABLE(discovery),
    [MR_BOARD_NUCLEO446] = TABLE(nucleo446),
};

const struct board_table *board_table_of(unsigned number)
{
    return number < COUNT(tables) ? &tables[number] : NULL;
}

long board_fact_of(const struct board_table *table, const char *name)
{
    for (size_t i = 0; i < table->facts; i++) {
        if (strcmp(table->fact[i].name, name) == 0)
            return table->fact[i].value;
    }
    abort();
}
