/* Statements of host/store/store_import.c; store_sql.h has the others. */
#ifndef MATRIG_HOST_STORE_STORE_SQL_IMPORT_H
#define MATRIG_HOST_STORE_STORE_SQL_IMPORT_H

#define STORE_IMPORT_STATEMENTS(X)                                                                            \
    X(IMPORT_PUT, "ittittti", "INSERT OR REPLACE INTO imports VALUES(?,?,?,?,?,?,?,?)")                        \
    X(IMPORT_GET, "i", "SELECT file, sha256, bytes, format, mapping, verdict, made_us FROM imports WHERE session=?") \
    X(IMPORT_FIND, "tt",                                                                                      \
      "SELECT session FROM imports JOIN sessions ON sessions.id=session WHERE sha256=? AND mapping IS ?"      \
      " AND ended_by='end' LIMIT 1")                                                                          \
    X(IMPORTED_PUT, "iiiib", "INSERT OR REPLACE INTO imported(landing, idx, first_block, stride, readings) VALUES(?,?,?,?,?)") \
    X(IMPORTED, "i", "SELECT idx, first_block, stride, readings FROM imported WHERE landing=? ORDER BY idx")

#endif
