/* Campaigns of older versions: brought forward when they are opened for writing, read as they are
 * otherwise.
 *
 * What a version lacks is found by comparing its tables with those of tables.def, so nothing is
 * listed by hand: missing tables and indexes are made, missing columns are added (old rows have
 * NULL there, or the column's default), and a table whose columns then stand in another order or
 * under other constraints is built anew around its rows. A column of tables.def that is new must
 * therefore allow NULL or have a default. */
#ifndef MATRIG_HOST_STORE_STORE_MIGRATE_H
#define MATRIG_HOST_STORE_STORE_MIGRATE_H

#include <sqlite3.h>

#include "host/store/store.h"

/* Whether tables, columns or indexes are missing. */
enum mr_status store_migrate_due(struct store *store, bool *due, struct error *error);
/* In one transaction, after a copy PATH.vN beside it when `backup`. A crash at any moment leaves
 * the old campaign whole, or the new one. MR_VERSION: it has a column that this matrig does not
 * know. */
enum mr_status store_migrate(struct store *store, bool backup, struct error *error);
/* Lets this connection read an older campaign: what is missing is empty, or NULL. The file stays as
 * it is. */
enum mr_status store_migrate_view(struct store *store, struct error *error);

#endif
