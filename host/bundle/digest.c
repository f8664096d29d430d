#include "host/bundle/digest.h"

#include <sha2.h>
#include <stdio.h>
#include <string.h>

static void to_hex(const uint8_t sum[SHA256_DIGEST_LENGTH], char hex[BUNDLE_DIGEST])
{
    for (size_t i = 0; i < SHA256_DIGEST_LENGTH; i++)
        snprintf(hex + 2 * i, 3, "%02x", sum[i]);
}

void digest_bytes(const void *bytes, size_t size, char hex[BUNDLE_DIGEST])
{
    SHA2_CTX hash;
    uint8_t sum[SHA256_DIGEST_LENGTH];
    SHA256Init(&hash);
    SHA256Update(&hash, bytes, size);
    SHA256Final(sum, &hash);
    to_hex(sum, hex);
}

struct hashing {
    SHA2_CTX hash;
    int64_t bytes;
};

static void add(struct hashing *hashing, const void *bytes, size_t size)
{
    if (size)
        SHA256Update(&hashing->hash, bytes, size);
    hashing->bytes += (int64_t)size;
}

/* A letter and 8 bytes, low byte first: a number, or a length. */
static void add_head(struct hashing *hashing, char letter, uint64_t value)
{
    uint8_t head[9] = {(uint8_t)letter};
    for (unsigned i = 0; i < 8; i++)
        head[1 + i] = (uint8_t)(value >> (8 * i));
    add(hashing, head, sizeof head);
}

static void add_text(struct hashing *hashing, const char *text)
{
    add_head(hashing, 'T', strlen(text));
    add(hashing, text, strlen(text));
}

static void add_value(struct hashing *hashing, sqlite3_stmt *row, int column)
{
    uint64_t bits;
    double real;
    switch (sqlite3_column_type(row, column)) {
    case SQLITE_NULL: add(hashing, "N", 1); break;
    case SQLITE_INTEGER: add_head(hashing, 'I', (uint64_t)sqlite3_column_int64(row, column)); break;
    case SQLITE_FLOAT:
        real = sqlite3_column_double(row, column);
        memcpy(&bits, &real, sizeof bits);
        add_head(hashing, 'R', bits);
        break;
    default: {
        bool text = sqlite3_column_type(row, column) == SQLITE_TEXT;
        const void *bytes = sqlite3_column_blob(row, column);
        size_t size = (size_t)sqlite3_column_bytes(row, column);
        add_head(hashing, text ? 'T' : 'B', size);
        add(hashing, bytes, bytes ? size : 0);
    }
    }
}

/* SELECT of all columns in the order of the primary key; the caller frees it. */
static char *selection(sqlite3 *database, const char *table)
{
    sqlite3_stmt *statement;
    char *order = NULL;
    if (!table)
        return sqlite3_mprintf(
            "SELECT name, sql FROM sqlite_schema WHERE sql IS NOT NULL ORDER BY type, name");
    if (sqlite3_prepare_v2(database, "SELECT name FROM pragma_table_info(?) WHERE pk>0 ORDER BY pk",
                           -1, &statement, NULL) != SQLITE_OK)
        return NULL;
    sqlite3_bind_text(statement, 1, table, -1, SQLITE_STATIC);
    while (sqlite3_step(statement) == SQLITE_ROW)
        order = sqlite3_mprintf("%z%s\"%w\"", order, order ? "," : "",
                                sqlite3_column_text(statement, 0));
    sqlite3_finalize(statement);
    char *sql = sqlite3_mprintf("SELECT * FROM \"%w\" ORDER BY %s", table, order ? order : "rowid");
    sqlite3_free(order);
    return sql;
}

int digest_table(sqlite3 *database, const char *table, int64_t bytes_max, struct digest_sum *sum)
{
    struct hashing hashing = {.bytes = 0};
    uint8_t bytes[SHA256_DIGEST_LENGTH];
    sqlite3_stmt *row = NULL;
    char *sql = selection(database, table);
    int code = sql ? sqlite3_prepare_v2(database, sql, -1, &row, NULL) : sqlite3_errcode(database);
    *sum = (struct digest_sum){.rows = 0};
    SHA256Init(&hashing.hash);
    for (int c = 0; code == SQLITE_OK && table && c < sqlite3_column_count(row); c++)
        add_text(&hashing, sqlite3_column_name(row, c));
    while (code == SQLITE_OK && (code = sqlite3_step(row)) == SQLITE_ROW) {
        for (int c = 0; c < sqlite3_column_count(row); c++)
            add_value(&hashing, row, c);
        sum->rows++;
        code = hashing.bytes > bytes_max ? SQLITE_TOOBIG : SQLITE_OK;
    }
    sqlite3_finalize(row);
    sqlite3_free(sql);
    SHA256Final(bytes, &hashing.hash);
    to_hex(bytes, sum->hex);
    sum->bytes = hashing.bytes;
    return code == SQLITE_DONE ? SQLITE_OK : code == SQLITE_OK ? SQLITE_ERROR : code;
}

void digest_sealed(const uint8_t *bytes, size_t size, char hex[BUNDLE_DIGEST], size_t *at)
{
    static const char zeros[] = "0000000000000000000000000000000000000000000000000000000000000000";
    const size_t length = sizeof BUNDLE_SEAL - 1, digits = sizeof zeros - 1;
    const uint8_t *seal = memmem(bytes, size, BUNDLE_SEAL, length);
    *at = 0;
    hex[0] = '\0';
    if (!seal || (size_t)(seal - bytes) + length + digits > size)
        return;
    size_t place = (size_t)(seal - bytes) + length;
    if (memmem(bytes + place, size - place, BUNDLE_SEAL, length))
        return;
    SHA2_CTX hash;
    uint8_t sum[SHA256_DIGEST_LENGTH];
    SHA256Init(&hash);
    SHA256Update(&hash, bytes, place);
    SHA256Update(&hash, (const uint8_t *)zeros, digits);
    SHA256Update(&hash, bytes + place + digits, size - place - digits);
    SHA256Final(sum, &hash);
    to_hex(sum, hex);
    *at = place;
}
