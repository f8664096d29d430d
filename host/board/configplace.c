#include "host/board/configplace.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

const struct mr_config_field *configplace_field(struct configplace at)
{
    return &mr_config_groups[at.group].fields[at.field];
}

void *configplace_bytes(const struct mr_config *config, struct configplace at)
{
    const struct mr_config_group *group = &mr_config_groups[at.group];
    return (uint8_t *)(uintptr_t)config + group->offset + at.index * group->size +
           group->fields[at.field].offset;
}

/* The next one in the order of the table; false: that was the last. Begin with {0}. */
bool configplace_next(struct configplace *at)
{
    if (++at->field < mr_config_groups[at->group].field_count)
        return true;
    at->field = 0;
    if (++at->index < mr_config_groups[at->group].count)
        return true;
    at->index = 0;
    return ++at->group < MR_CONFIG_GROUPS;
}

void configplace_name(struct configplace at, char out[CONFIGPLACE_NAME])
{
    const struct mr_config_group *group = &mr_config_groups[at.group];
    if (group->count == 1)
        snprintf(out, CONFIGPLACE_NAME, "%s.%s", group->name, configplace_field(at)->name);
    else
        snprintf(out, CONFIGPLACE_NAME, "%s[%u].%s", group->name, at.index + 1,
                 configplace_field(at)->name);
}

bool configplace_is_day(const struct mr_config_field *field)
{
    size_t length = strlen(field->name);
    return length > 4 && strcmp(field->name + length - 4, "_day") == 0;
}

/* Days since 1970-01-01 of the Gregorian calendar and back: years begin in March, 400 of them have
 * 146097 days. */
int64_t configplace_day(int64_t year, unsigned month, unsigned day)
{
    int64_t y = year - (month <= 2);
    unsigned from_march = (month + 9) % 12;
    return 365 * y + y / 4 - y / 100 + y / 400 + (int64_t)((153 * from_march + 2) / 5 + day - 1) -
           719468;
}

void configplace_date(uint32_t days, unsigned *year, unsigned *month, unsigned *day)
{
    *year = 1970 + days / 366;
    while (configplace_day(*year + 1, 1, 1) <= (int64_t)days)
        ++*year;
    *month = 12;
    while (configplace_day(*year, *month, 1) > (int64_t)days)
        --*month;
    *day = (unsigned)((int64_t)days - configplace_day(*year, *month, 1)) + 1;
}

bool configplace_date_read(const char *text, uint32_t *days)
{
    unsigned year, month, day, y, m, d;
    int used = 0;
    if (sscanf(text, "%4u-%2u-%2u%n", &year, &month, &day, &used) != 3 ||
        used != CONFIGPLACE_DATE - 1 || month < 1 || month > 12 || year < 1970)
        return false;
    *days = (uint32_t)configplace_day(year, month, day);
    configplace_date(*days, &y, &m, &d);
    return *days > 0 && y == year && m == month && d == day;
}

void configplace_date_text(uint32_t days, char out[CONFIGPLACE_DATE])
{
    unsigned year, month, day;
    configplace_date(days, &year, &month, &day);
    snprintf(out, CONFIGPLACE_DATE, "%04u-%02u-%02u", year % 10000u, month % 100u, day % 100u);
}

static uint32_t integer_at(const struct mr_config_field *field, const void *bytes)
{
    uint8_t small;
    uint16_t half;
    uint32_t word;
    switch (field->type) {
    case MR_CONFIG_TYPE_u8: memcpy(&small, bytes, sizeof small); return small;
    case MR_CONFIG_TYPE_u16: memcpy(&half, bytes, sizeof half); return half;
    default: memcpy(&word, bytes, sizeof word); return word;
    }
}

static void write_day(uint32_t days, char *out, size_t size)
{
    char date[CONFIGPLACE_DATE];
    configplace_date_text(days, date);
    snprintf(out, size, "%s", days ? date : "never");
}

static void write_text(const char *text, unsigned count, char *out, size_t size)
{
    size_t used = 0;
    out[used++] = '"';
    for (unsigned i = 0; i < count && text[i] && used + 4 < size; i++) {
        if (text[i] == '"' || text[i] == '\\')
            out[used++] = '\\';
        out[used++] = text[i];
    }
    out[used++] = '"';
    out[used] = '\0';
}

/* Nine digits name a single exactly. */
static void write_reals(const float *values, unsigned count, char *out, size_t size)
{
    size_t used = 0;
    for (unsigned i = 0; i < count && used < size; i++) {
        if (isnan(values[i]))
            used += (size_t)snprintf(out + used, size - used, "%smissing", i ? " " : "");
        else
            used += (size_t)snprintf(out + used, size - used, "%s%.9g", i ? " " : "",
                                     (double)values[i]);
    }
}

void configplace_value(const struct mr_config_field *field, const void *bytes,
                       char out[CONFIGPLACE_VALUE])
{
    if (field->type == MR_CONFIG_TYPE_TEXT)
        write_text(bytes, field->count, out, CONFIGPLACE_VALUE);
    else if (field->type == MR_CONFIG_TYPE_REAL || field->type == MR_CONFIG_TYPE_OPTIONAL)
        write_reals(bytes, field->count, out, CONFIGPLACE_VALUE);
    else if (configplace_is_day(field))
        write_day(integer_at(field, bytes), out, CONFIGPLACE_VALUE);
    else
        snprintf(out, CONFIGPLACE_VALUE, "%u", integer_at(field, bytes));
}

void configplace_limits(const struct mr_config_field *field, char *out, size_t size)
{
    if (field->type == MR_CONFIG_TYPE_TEXT) {
        snprintf(out, size, "at most %u printable characters in double quotes", field->count);
    } else if (field->type == MR_CONFIG_TYPE_REAL || field->type == MR_CONFIG_TYPE_OPTIONAL) {
        char many[40] = "";
        if (field->count > 1)
            snprintf(many, sizeof many, "%u numbers, each ", field->count);
        snprintf(out, size, "%sfrom %.7g to %.7g%s", many, (double)field->low, (double)field->high,
                 field->type == MR_CONFIG_TYPE_OPTIONAL ? ", or missing" : "");
    } else if (configplace_is_day(field)) {
        char last[20];
        write_day(field->most, last, sizeof last);
        snprintf(out, size, "YYYY-MM-DD up to %s, or never", last);
    } else {
        snprintf(out, size, "from %u to %u", field->least, field->most);
    }
}
