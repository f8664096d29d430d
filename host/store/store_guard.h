/* What a campaign made by somebody else may hold and do. A schema can hold programs: a view in a
 * table's place that never ends, a trigger that runs at every row that is written. matrig runs none
 * but its own.
 *
 * Allowed in a campaign: tables of tables.def without expressions, its indices and triggers as they
 * are there; also ordinary tables of other names with any indices, which matrig neither reads nor
 * writes, and indices on columns of matrig's tables that do not demand anything of the rows (not
 * unique, not partial). All else is foreign. */
#ifndef MATRIG_HOST_STORE_STORE_GUARD_H
#define MATRIG_HOST_STORE_STORE_GUARD_H

#include <sqlite3.h>

#include "host/store/store.h"

#define STORE_FOREIGN_TEXT 120

/* Settings of every connection to a campaign: its schema is data, and cannot be written as a table.
 * NULL: none. */
void store_guard_settings(sqlite3 *database);

/* Whether something foreign is in the schema; `what` receives its type and name: "view gaps".
 * MR_OK: nothing is. MR_MALFORMED: it is, or the schema cannot be read (`what` says why). */
enum mr_status store_guard_schema(sqlite3 *database, char what[STORE_FOREIGN_TEXT]);

/* From now on a statement ends by itself when it has taken many more steps, or given many more
 * rows, than a file of this size can have need of: pages can lead in circles. SQLite then tells
 * SQLITE_INTERRUPT. */
void store_guard_steps(struct store *store);
/* A new statement begins. */
void store_guard_renew(struct store *store);
/* A row was given; false: too many. */
bool store_guard_row(struct store *store);

#endif
