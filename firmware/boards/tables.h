/* The rows of all boards as tables, for generated pages and tests. Firmware images do not contain
 * them. */
#ifndef MATRIG_FIRMWARE_BOARDS_TABLES_H
#define MATRIG_FIRMWARE_BOARDS_TABLES_H

#include <stddef.h>

enum board_row_kind { BOARD_ROW_ANALOGUE, BOARD_ROW_FUNCTION, BOARD_ROW_OUTPUT, BOARD_ROW_INPUT };

struct board_row {
    enum board_row_kind kind;
    char port; /* letter of the port */
    unsigned pin;
    const char *function; /* alternate function: "ADC3_IN9", "TIM4_CH1"; "": the pin needs none */
    unsigned number;      /* number of the alternate function, or initial level of an output */
    const char *pull;     /* "NONE", "UP" */
    const char *signal;   /* "TRANSDUCER_1" */
    const char *text;
};

struct board_constant {
    const char *name;
    long value;
    const char *text;
};

struct board_region { /* a memory region, as in common/memory.def */
    const char *name;
    unsigned long start, bytes; /* 0 bytes: the chip does not have this region */
    const char *text;
};

struct board_table {
    const struct board_row *row;
    size_t row_count;
    const struct board_constant *constant;
    size_t constant_count;
    const struct board_region *region;
    size_t region_count;
};

/* Table of a board by its number in common/boards.def, or NULL. Static storage. */
const struct board_table *board_table_by_number(unsigned number);
/* Region with this name; aborts if there is none. */
const struct board_region *board_region_by_name(const struct board_table *table, const char *name);
/* Value of the fact with this name; aborts if there is none. */
long board_constant_value(const struct board_table *table, const char *name);

#endif
