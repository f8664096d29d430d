#include "host/export/dbc.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "common/catalogue.h"
#include "common/channels.h"
#include "common/command.h"
#include "common/crash.h"
#include "common/fault.h"

static bool is_signed(enum mr_wire_type type)
{
    return type == MR_WIRE_i8 || type == MR_WIRE_i16 || type == MR_WIRE_i32 || type == MR_WIRE_f32;
}

/* Range in units. A scaled real keeps one code for "missing"; a float has no range worth stating (0|0 means
 * none). */
static void range(const struct mr_field_info *field, double *low, double *high)
{
    double steps = field->per_unit > 0.0f ? (double)field->per_unit : 1.0;
    switch (field->type) {
    case MR_WIRE_u8:
        *low = 0;
        *high = 255;
        break;
    case MR_WIRE_i8:
        *low = -128;
        *high = 127;
        break;
    case MR_WIRE_u16:
        *low = 0;
        *high = field->per_unit > 0.0f ? 65534 : 65535;
        break;
    case MR_WIRE_i16:
        *low = field->per_unit > 0.0f ? -32767 : -32768;
        *high = 32767;
        break;
    case MR_WIRE_u32:
        *low = 0;
        *high = 4294967295.0;
        break;
    case MR_WIRE_i32:
        *low = -2147483648.0;
        *high = 2147483647.0;
        break;
    case MR_WIRE_f32: *low = *high = 0; break;
    }
    *low /= steps;
    *high /= steps;
}

static void write_signal(FILE *out, const struct mr_message_info *message, const struct mr_field_info *field)
{
    double low, high;
    double factor = field->per_unit > 0.0f ? 1.0 / (double)field->per_unit : 1.0;
    range(field, &low, &high);
    fprintf(out, " SG_ %s : %u|%u@1%c (%.10g,0) [%.10g|%.10g] \"%s\" %s\n", field->name, 8u * field->offset,
            8u * field->size, is_signed(field->type) ? '-' : '+', factor, low, high, field->unit,
            message->direction == MR_DIRECTION_HOST ? "BOARD" : "HOST");
}

/* Text inside quotes of a DBC file. */
static void write_text(FILE *out, const char *text)
{
    fputc('"', out);
    for (; *text; text++)
        fputc(*text == '"' ? '\'' : *text, out);
    fputc('"', out);
}

static void begin_values(FILE *out, const struct mr_message_info *message, const struct mr_field_info *field)
{
    fprintf(out, "VAL_ %u %s", message->id, field->name);
}

static void write_value(FILE *out, long value, const char *text)
{
    fprintf(out, " %ld ", value);
    write_text(out, text);
}

/* One "3 settling" of a list; returns where the next begins, NULL when `at` is none. `name` may be NULL. */
static const char *take_listed(const char *at, long *value, char *name, size_t size)
{
    char *after;
    if (!isdigit((unsigned char)*at))
        return NULL;
    *value = strtol(at, &after, 10);
    if (*after != ' ' || after[1] == '+')
        return NULL;
    size_t length = strcspn(++after, ",;");
    if (name)
        snprintf(name, size, "%.*s", (int)length, after);
    after += length;
    return *after == ',' ? after + 1 + (after[1] == ' ') : after;
}

/* Many fields' texts list what their values mean: "0 idle, 1 armed, 2 landing", also after "why: ". Sets of bits are no such list. */
static const char *find_list(const char *text)
{
    long value;
    const char *colon = strstr(text, ": ");
    const char *at = isdigit((unsigned char)*text) ? text : colon ? colon + 2 : NULL;
    if (!at || strncmp(text, "bit", 3) == 0 || strstr(text, "bits "))
        return NULL;
    const char *second = take_listed(at, &value, NULL, 0);
    return second && take_listed(second, &value, NULL, 0) ? at : NULL;
}

static bool write_listed(FILE *out, const struct mr_message_info *message, const struct mr_field_info *field)
{
    char name[100];
    long value;
    const char *at = find_list(field->text);
    if (!at)
        return false;
    begin_values(out, message, field);
    for (const char *next; (next = take_listed(at, &value, name, sizeof name)) != NULL; at = next)
        write_value(out, value, name);
    return true;
}

static void write_values(FILE *out, const struct mr_message_info *message, const struct mr_field_info *field)
{
    const char *name = field->name;
    bool code = strcmp(name, "code") == 0;
    if (field->per_unit > 0.0f) {
        begin_values(out, message, field);
        write_value(out, field->type == MR_WIRE_u16 ? 65535 : -32768, "missing");
    } else if (message->id == MR_ID_FAULT && code) {
        begin_values(out, message, field);
        for (unsigned i = 0; i < MR_FAULT_COUNT; i++)
            write_value(out, (long)i, mr_fault_text(i));
    } else if (message->id == MR_ID_CRASH && strcmp(name, "item") == 0) {
        begin_values(out, message, field);
        for (unsigned i = 0; i < MR_CRASH_ITEMS; i++)
            write_value(out, (long)i, mr_crash_item_name(i));
    } else if (message->id == MR_ID_CAN_ALARM && strcmp(name, "state") == 0) {
        begin_values(out, message, field);
        for (unsigned i = 0; i <= MR_CAN_MISSING; i++)
            write_value(out, (long)i, mr_can_state_text(i));
    } else if (message->id == MR_ID_RESTARTS && strcmp(name, "late_task") == 0) {
        begin_values(out, message, field);
        for (unsigned i = 1; i < MR_TASK_COUNT; i++)
            write_value(out, (long)i, mr_task_text(i));
    } else if ((message->id == MR_ID_COMMAND || message->id == MR_ID_ACK) && code) {
        begin_values(out, message, field);
        for (unsigned i = MR_COMMAND_STATE; i <= MR_COMMAND_SELF_TEST; i++)
            write_value(out, (long)i, mr_command_name(i));
    } else if (message->id == MR_ID_ACK && strcmp(name, "status") == 0) {
        begin_values(out, message, field);
        for (int i = 0; i >= MR_HALTED; i--)
            write_value(out, i, mr_status_text((enum mr_status)i));
    } else if (!write_listed(out, message, field)) {
        return;
    }
    fputs(" ;\n", out);
}

/* How often messages come that come by the clock, ms: as common/catalogue.def says it of each; those of zones and readings while a
 * landing is recorded. One that comes for each channel or band in turn has no cycle of its own. */
static const struct {
    uint16_t id, ms;
} cycles[] = {
    {MR_ID_DISPLACEMENT_1_3, 2}, {MR_ID_DISPLACEMENT_4_6, 2}, {MR_ID_DISPLACEMENT_7_8, 2}, {MR_ID_TENSION_1_3, 4},
    {MR_ID_TENSION_4_6, 4}, {MR_ID_TENSION_7_9, 4}, {MR_ID_TENSION_10_12, 4}, {MR_ID_TENSION_13_14, 4}, {MR_ID_ZONE, 50},
    {MR_ID_ZONE_LEAD, 50}, {MR_ID_ZONE_ERROR, 50}, {MR_ID_ZONE_COMING, 50}, {MR_ID_ZONE_PRESS, 50}, {MR_ID_VERDICT, 50},
    {MR_ID_MESSAGE_COUNT, 50}, {MR_ID_CLOCK, 100}, {MR_ID_HEALTH, 100}, {MR_ID_CAN_HEALTH, 100}, {MR_ID_SERIAL_HEALTH, 100},
    {MR_ID_SYNC, 1000}, {MR_ID_SYNC_AT, 1000}, {MR_ID_TRUST, 1000}, {MR_ID_LANDING, 1000}, {MR_ID_BOX_STATE, 1000},
    {MR_ID_BOX_SPACE, 1000}, {MR_ID_TEMPERATURE, 1000}, {MR_ID_UPKEEP, 1000}, {MR_ID_CAN_ALARM, 1000}, {MR_ID_RESTARTS, 1000},
    {MR_ID_CAN_DROPS, 1000}, {MR_ID_CONFIG_STATE, 1000}, {MR_ID_HELLO, 1000}, {MR_ID_BOARD_UID, 1000}, {MR_ID_BOARD_IMAGE, 1000},
    {MR_ID_BOARD_CONFIG, 1000}, {MR_ID_SITE, 1000}, {MR_ID_WHEEL, 1000}, {MR_ID_IMAGE_COMMIT, 1000}, {MR_ID_IMAGE_HEADER, 1000},
};

static void write_attributes(FILE *out)
{
    fputs("BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\nBA_DEF_ \"BusType\" STRING ;\n"
          "BA_DEF_DEF_ \"GenMsgCycleTime\" 0;\nBA_DEF_DEF_ \"BusType\" \"CAN\";\nBA_ \"BusType\" \"CAN\";\n", out);
    for (size_t i = 0; i < sizeof cycles / sizeof cycles[0]; i++)
        fprintf(out, "BA_ \"GenMsgCycleTime\" BO_ %u %u;\n", cycles[i].id, cycles[i].ms);
}

unsigned dbc_write(FILE *out)
{
    size_t count;
    const struct mr_message_info *messages = mr_catalogue(&count);

    fputs("VERSION \"\"\n\nNS_ :\n\tCM_\n\tBA_DEF_\n\tBA_\n\tVAL_\n\tBA_DEF_DEF_\n\tSIG_VALTYPE_\n\nBS_:\n\nBU_: BOARD HOST\n\n", out);
    for (size_t m = 0; m < count; m++) {
        const struct mr_message_info *message = &messages[m];
        fprintf(out, "BO_ %u %s: %u %s\n", message->id, message->name, message->length,
                message->direction == MR_DIRECTION_HOST ? "HOST" : "BOARD");
        for (unsigned f = 0; f < message->field_count; f++)
            write_signal(out, message, &message->fields[f]);
        fputc('\n', out);
    }
    fprintf(out, "CM_ \"matrig, message layout %u. Scaled signals keep one raw value for missing data.\";\n",
            MR_LAYOUT);
    for (size_t m = 0; m < count; m++) {
        fprintf(out, "CM_ BO_ %u ", messages[m].id);
        write_text(out, messages[m].text);
        fputs(";\n", out);
        for (unsigned f = 0; f < messages[m].field_count; f++) {
            fprintf(out, "CM_ SG_ %u %s ", messages[m].id, messages[m].fields[f].name);
            write_text(out, messages[m].fields[f].text);
            fputs(";\n", out);
        }
    }
    write_attributes(out);
    for (size_t m = 0; m < count; m++) {
        for (unsigned f = 0; f < messages[m].field_count; f++)
            write_values(out, &messages[m], &messages[m].fields[f]);
    }
    for (size_t m = 0; m < count; m++) {
        for (unsigned f = 0; f < messages[m].field_count; f++) {
            if (messages[m].fields[f].type == MR_WIRE_f32)
                fprintf(out, "SIG_VALTYPE_ %u %s : 1;\n", messages[m].id, messages[m].fields[f].name);
        }
    }
    return (unsigned)count;
}
