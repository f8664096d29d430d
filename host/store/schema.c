/* The tables as SQLite has them. */
#include "host/store/table.h"

static void say_columns(sqlite3_str *sql, const struct store_table *table)
{
    bool first = true;
    for (unsigned i = 0; i < table->count; i++) {
        const struct store_column *column = &table->columns[i];
        if (!column->name)
            continue;
        sqlite3_str_appendf(sql, "%s%s %s%s%s", first ? "" : ", ", column->name, column->type,
                            column->constraint[0] ? " " : "", column->constraint);
        first = false;
    }
}

static int make_table(sqlite3 *database, enum store_table_number which)
{
    const struct store_table *table = store_table(which);
    sqlite3_str *sql = sqlite3_str_new(database);
    sqlite3_str_appendf(sql, "CREATE TABLE %s(", table->name);
    say_columns(sql, table);
    sqlite3_str_appendf(sql, "%s", table->key);
    char *text = sqlite3_str_finish(sql);
    int code = text ? sqlite3_exec(database, text, NULL, NULL, NULL) : SQLITE_NOMEM;
    sqlite3_free(text);
    return code;
}

int store_tables_make(sqlite3 *database)
{
    int code = SQLITE_OK;
#define TABLE(row, table)  \
    if (code == SQLITE_OK) \
        code = make_table(database, STORE_TABLE_##row);
#define NO_VIEWS
#define ALSO(sql)          \
    if (code == SQLITE_OK) \
        code = sqlite3_exec(database, sql, NULL, NULL, NULL);
#include "host/store/tables.def"
    return code;
}
