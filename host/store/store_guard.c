#include "host/store/store_guard.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

#include "host/store/store_sql.h"

/* A scan takes below 2 steps a byte of the file; sorting and what is looked up for each row do not
 * make it ten times as many. */
#define STEPS_ALWAYS    20000000
#define STEPS_A_BYTE    32
#define STEPS_EACH      10000
#define ROWS_ALWAYS     100000 /* and one for each byte: the shortest row takes six */
/* the longest that matrig writes is an imported channel: 18 h at 1 kHz */
#define VALUE_BYTES_MAX 268435456
#define WORD_MAX        64

void store_guard_settings(sqlite3 *database)
{
    if (!database)
        return;
    sqlite3_db_config(database, SQLITE_DBCONFIG_DEFENSIVE, 1, NULL);
    sqlite3_db_config(database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, NULL);
    sqlite3_limit(database, SQLITE_LIMIT_LENGTH, VALUE_BYTES_MAX);
}

/* ---- the schema ---- */

/* The next word of SQL: a name without its quotes, a number, or one character of another kind.
 * False: the end. */
static bool next_word(const char **at, char word[WORD_MAX])
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
    const char *from = *at + strspn(*at, " \t\r\n");
    size_t length = strspn(from, letters), quotes = 0;
    const char *quote = *from ? strchr("\"`[", *from) : NULL;
    if (quote) {
        char closing[2] = {*quote == '[' ? ']' : *quote, '\0'};
        from++;
        length = strcspn(from, closing);
        quotes = from[length] == closing[0];
    }
    if (!*from)
        return false;
    if (length == 0 && !quotes)
        length = 1;
    snprintf(word, WORD_MAX, "%.*s", (int)length, from);
    if (length >= WORD_MAX || length == 0) /* no name of matrig's */
        snprintf(word, WORD_MAX, "?");
    *at = from + length + quotes;
    return true;
}

/* Whether the text goes on with these words; `at` moves behind them. */
static bool skip_words(const char **at, const char *const *words, size_t count)
{
    char word[WORD_MAX];
    for (size_t i = 0; i < count; i++) {
        if (!next_word(at, word) || strcasecmp(word, words[i]) != 0)
            return false;
    }
    return true;
}

static bool has_word(const char *sql, const char *wanted)
{
    char word[WORD_MAX];
    while (next_word(&sql, word)) {
        if (strcasecmp(word, wanted) == 0)
            return true;
    }
    return false;
}

static bool is_name(const char *word)
{
    return (word[0] >= 'a' && word[0] <= 'z') || (word[0] >= 'A' && word[0] <= 'Z') ||
           word[0] == '_';
}

/* Whether a table's text is names of columns, types and keys: nothing in it is worked out when a
 * row is read or written, or says what becomes of other rows. What matrig's own text for the table
 * has is allowed. A column that is not known is store_migrate's to judge. */
static bool plain_table(const char *sql, const char *wanted)
{
    static const char *const works[] = {"CHECK", "DEFAULT", "AS", "GENERATED", "COLLATE", "ON"};
    char word[WORD_MAX];
    while (next_word(&sql, word)) {
        bool plain = is_name(word) || strchr("(),", word[0]);
        for (size_t i = 0; i < sizeof works / sizeof works[0]; i++)
            plain &= strcasecmp(word, works[i]) != 0;
        if (!plain && !has_word(wanted, word))
            return false;
    }
    return true;
}

/* "(column, column DESC)" and nothing behind: no expression, no condition. */
static bool plain_columns(const char *sql)
{
    char word[WORD_MAX];
    bool begun = false, ended = false;
    while (next_word(&sql, word)) {
        bool opens = strcmp(word, "(") == 0, closes = strcmp(word, ")") == 0,
             comma = strcmp(word, ",") == 0;
        if (ended || begun == opens || !(opens || closes || comma || is_name(word)) ||
            strcasecmp(word, "COLLATE") == 0)
            return false;
        begun |= opens;
        ended |= closes;
    }
    return ended;
}

struct object {
    const char *type, *name, *table, *sql;
    int root;
};

/* What matrig's own schema says of an object; NULL: nothing. */
static const char *own_text(sqlite3_stmt *own, const char *type, const char *name)
{
    sqlite3_reset(own);
    sqlite3_bind_text(own, 1, type, -1, SQLITE_STATIC);
    sqlite3_bind_text(own, 2, name, -1, SQLITE_STATIC);
    return sqlite3_step(own) == SQLITE_ROW ? (const char *)sqlite3_column_text(own, 0) : NULL;
}

static bool table_allowed(const struct object *object, sqlite3_stmt *own)
{
    const char *at = object->sql, *words[] = {"CREATE", "TABLE", object->name};
    const char *wanted = own_text(own, "table", object->name);
    if (object->root <= 0) /* a virtual one */
        return false;
    return skip_words(&at, words, 3) && (!wanted || plain_table(at, wanted));
}

static bool index_allowed(const struct object *object, sqlite3_stmt *own)
{
    const char *at = object->sql, *unique = object->sql;
    const char *words[] = {"CREATE", "INDEX", object->name, "ON", object->table};
    const char *unique_words[] = {"CREATE", "UNIQUE", "INDEX", object->name, "ON", object->table};
    if (!object->sql[0]) /* of a table's own key */
        return true;
    if (own_text(own, "table", object->table))
        return skip_words(&at, words, 5) && plain_columns(at);
    return skip_words(&at, words, 5) || skip_words(&unique, unique_words, 6);
}

static bool allowed(const struct object *object, sqlite3_stmt *own)
{
    if (strcmp(object->type, "table") == 0)
        return table_allowed(object, own);
    if (strcmp(object->type, "index") == 0)
        return index_allowed(object, own);
    const char *wanted = strcmp(object->type, "trigger") == 0
                           ? own_text(own, "trigger", object->name)
                           : NULL;
    return wanted && strcmp(wanted, object->sql) == 0;
}

static const char *text_or_none(sqlite3_stmt *row, int column)
{
    const char *text = (const char *)sqlite3_column_text(row, column);
    return text ? text : "";
}

static void describe(const struct object *object, char what[STORE_FOREIGN_TEXT])
{
    snprintf(what, STORE_FOREIGN_TEXT, "%s%s %.80s",
             strcmp(object->type, "table") == 0 && object->root <= 0 ? "virtual " : "",
             object->type, object->name);
    for (char *p = what; *p; p++) {
        if ((unsigned char)*p < 0x20 || (unsigned char)*p >= 0x7f)
            *p = '?';
    }
}

static int look_through(sqlite3_stmt *theirs, sqlite3_stmt *own, char what[STORE_FOREIGN_TEXT])
{
    int code;
    while ((code = sqlite3_step(theirs)) == SQLITE_ROW) {
        const struct object object = {text_or_none(theirs, 0), text_or_none(theirs, 1),
                                      text_or_none(theirs, 2), text_or_none(theirs, 3),
                                      sqlite3_column_int(theirs, 4)};
        if (!allowed(&object, own)) {
            describe(&object, what);
            return SQLITE_ROW;
        }
    }
    return code;
}

enum mr_status store_guard_schema(sqlite3 *database, char what[STORE_FOREIGN_TEXT])
{
    sqlite3 *model = NULL;
    sqlite3_stmt *theirs = NULL, *own = NULL;
    what[0] = '\0';
    int code = sqlite3_open(":memory:", &model);
    if (code == SQLITE_OK)
        code = store_tables_make(model);
    if (code == SQLITE_OK)
        code = sqlite3_prepare_v2(
            model, "SELECT sql FROM sqlite_schema WHERE type=? AND name=? COLLATE NOCASE", -1, &own,
            NULL);
    if (code == SQLITE_OK)
        code = sqlite3_prepare_v2(
            database,
            "SELECT type, name, tbl_name, sql, rootpage FROM main.sqlite_schema ORDER BY type DESC",
            -1, &theirs, NULL);
    if (code == SQLITE_OK)
        code = look_through(theirs, own, what);
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        snprintf(what, STORE_FOREIGN_TEXT, "%s", sqlite3_errmsg(database));
    sqlite3_finalize(theirs);
    sqlite3_finalize(own);
    sqlite3_close(model);
    return code == SQLITE_DONE ? MR_OK : MR_MALFORMED;
}

/* ---- steps ---- */

static int64_t file_bytes(const struct store *store)
{
    char journal[4200];
    struct stat info;
    int64_t bytes = stat(store->path, &info) == 0 ? (int64_t)info.st_size : 0;
    snprintf(journal, sizeof journal, "%s-wal", store->path);
    return bytes + (stat(journal, &info) == 0 ? (int64_t)info.st_size : 0);
}

/* The file is looked at again before a statement is ended: it grows while it is written to. */
static int too_many_steps(void *context)
{
    struct store *store = context;
    store->steps += STEPS_EACH;
    if (store->steps <= STEPS_ALWAYS + STEPS_A_BYTE * store->guarded_bytes)
        return 0;
    store->guarded_bytes = file_bytes(store);
    return store->steps > STEPS_ALWAYS + STEPS_A_BYTE * store->guarded_bytes;
}

void store_guard_steps(struct store *store)
{
    store->guarded_bytes = file_bytes(store);
    sqlite3_progress_handler(store->database, STEPS_EACH, too_many_steps, store);
}

/* Statements that begin while another one gives rows count with that one: what it does for each row
 * belongs to it. */
void store_guard_renew(struct store *store)
{
    if (store->steps == 0 && store->rows < ROWS_ALWAYS)
        return;
    for (sqlite3_stmt *s = sqlite3_next_stmt(store->database, NULL); s;
         s = sqlite3_next_stmt(store->database, s)) {
        if (sqlite3_stmt_busy(s))
            return;
    }
    store->steps = store->rows = 0;
}

bool store_guard_row(struct store *store)
{
    return ++store->rows <= ROWS_ALWAYS + store->guarded_bytes ||
           store->rows <= ROWS_ALWAYS + (store->guarded_bytes = file_bytes(store));
}
