#include "host/dbc.h"

#include <stdbool.h>
#include <string.h>

#include "common/catalogue.h"
#include "common/channels.h"
#include "common/command.h"
#include "common/crash.h"
#include "common/fault.h"
#include "host/collect.h"

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

static void write_values(FILE *out, const struct mr_message_info *message, const struct mr_field_info *field)
{
    static const char *const kinds[] = {"not fitted", "displacement", "tension", "staircase", "reference"};
    static const char *const clocks[] = {"crystal", "internal oscillator, 1 %", "internal oscillator alone"};
    static const char *const causes[] = {"no change", "command", "edge", "stopped", "settled", "time limit"};

    if (field->per_unit > 0.0f) {
        begin_values(out, message, field);
        write_value(out, field->type == MR_WIRE_u16 ? 65535 : -32768, "missing");
    } else if (strcmp(field->name, "state") == 0) {
        begin_values(out, message, field);
        for (unsigned i = 0; i <= 4; i++)
            write_value(out, (long)i, collector_state_text(i));
    } else if (message->id == MR_ID_LANDING && strcmp(field->name, "cause") == 0) {
        begin_values(out, message, field);
        for (size_t i = 0; i < sizeof causes / sizeof causes[0]; i++)
            write_value(out, (long)i, causes[i]);
    } else if (message->id == MR_ID_FAULT && strcmp(field->name, "code") == 0) {
        begin_values(out, message, field);
        for (unsigned i = 0; i < MR_FAULT_COUNT; i++)
            write_value(out, (long)i, mr_fault_text(i));
    } else if (message->id == MR_ID_CRASH && strcmp(field->name, "item") == 0) {
        begin_values(out, message, field);
        for (unsigned i = 0; i < MR_CRASH_ITEMS; i++)
            write_value(out, (long)i, mr_crash_item_name(i));
    } else if (message->id == MR_ID_CAN_ALARM && strcmp(field->name, "state") == 0) {
        begin_values(out, message, field);
        for (unsigned i = 0; i <= MR_CAN_MISSING; i++)
            write_value(out, (long)i, mr_can_state_text(i));
    } else if (message->id == MR_ID_RESTARTS && strcmp(field->name, "late_task") == 0) {
        begin_values(out, message, field);
        for (unsigned i = 1; i < MR_TASK_COUNT; i++)
            write_value(out, (long)i, mr_task_text(i));
    } else if ((message->id == MR_ID_COMMAND || message->id == MR_ID_ACK) &&
               strcmp(field->name, "code") == 0) {
        begin_values(out, message, field);
        for (unsigned i = MR_COMMAND_STATE; i <= MR_COMMAND_SELF_TEST; i++)
            write_value(out, (long)i, mr_command_name(i));
    } else if (message->id == MR_ID_ACK && strcmp(field->name, "status") == 0) {
        begin_values(out, message, field);
        for (int i = 0; i >= MR_HALTED; i--)
            write_value(out, i, mr_status_text((enum mr_status)i));
    } else if (message->id == MR_ID_CHANNEL && strcmp(field->name, "kind") == 0) {
        begin_values(out, message, field);
        for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++)
            write_value(out, (long)i, kinds[i]);
    } else if (strcmp(field->name, "clock_source") == 0) {
        begin_values(out, message, field);
        for (size_t i = 0; i < sizeof clocks / sizeof clocks[0]; i++)
            write_value(out, (long)i, clocks[i]);
    } else {
        return;
    }
    fputs(" ;\n", out);
}

unsigned dbc_write(FILE *out)
{
    size_t count;
    const struct mr_message_info *messages = mr_catalogue(&count);

    fputs("VERSION \"\"\n\nNS_ :\n\tCM_\n\tVAL_\n\tSIG_VALTYPE_\n\nBS_:\n\nBU_: BOARD HOST\n\n", out);
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
