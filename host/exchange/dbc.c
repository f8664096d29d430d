#include "host/exchange/export.h"

#include <stdbool.h>
#include <string.h>

#include "common/canbase.h"
#include "common/command.h"
#include "common/fault.h"

static bool is_signed(enum mr_wire_type type)
{
    return type == MR_WIRE_i8 || type == MR_WIRE_i16 || type == MR_WIRE_i32 || type == MR_WIRE_f32;
}

/* Computes the physical range of a field, without the code that means "missing". Floats have no
 * range, written as 0|0. */
static void get_field_range(const struct mr_field_info *field, double *low, double *high)
{
    static const double whole[][2] = {[MR_WIRE_u8] = {0, 255},
                                      [MR_WIRE_i8] = {-128, 127},
                                      [MR_WIRE_u16] = {0, 65535},
                                      [MR_WIRE_i16] = {-32768, 32767},
                                      [MR_WIRE_u32] = {0, 4294967295.0},
                                      [MR_WIRE_i32] = {-2147483648.0, 2147483647.0},
                                      [MR_WIRE_f32] = {0, 0}};
    bool scaled = field->counts_per_unit > 0.0f;
    double steps = scaled ? (double)field->counts_per_unit : 1.0;
    *low = (whole[field->type][0] + (scaled && field->type == MR_WIRE_i16)) / steps;
    *high = (whole[field->type][1] - (scaled && field->type == MR_WIRE_u16)) / steps;
}

static void write_signal(FILE *out, const struct mr_message_info *message,
                         const struct mr_field_info *field)
{
    double low, high;
    double factor = field->counts_per_unit > 0.0f ? 1.0 / (double)field->counts_per_unit : 1.0;
    get_field_range(field, &low, &high);
    fprintf(out, " SG_ %s : %u|%u@1%c (%.10g,0) [%.10g|%.10g] \"%s\" %s\n", field->name,
            8u * field->offset, 8u * field->size, is_signed(field->type) ? '-' : '+', factor, low,
            high, field->unit, message->direction == MR_DIRECTION_HOST ? "BOARD" : "HOST");
}

/* Writes text within the quotes of a DBC file. */
static void write_text(FILE *out, const char *text)
{
    fputc('"', out);
    for (; *text; text++)
        fputc(*text == '"' ? '\'' : *text, out);
    fputc('"', out);
}

static void write_value(FILE *out, long value, const char *text)
{
    fprintf(out, " %ld ", value);
    write_text(out, text);
}

static const char *get_status_text(unsigned minus)
{
    return mr_status_text((enum mr_status) - (int)minus);
}

/* Fields with named values. The names belong to the numbers from `first` to `last`, multiplied by
 * `sign`. */
static const struct {
    uint16_t id;
    const char *field;
    unsigned first, last;
    int sign;
    const char *(*text)(unsigned number);
} named_values[] = {
    {MR_ID_FAULT, "code", 0, MR_FAULT_COUNT - 1, 1, mr_fault_text},
    {MR_ID_CRASH, "item", 0, MR_CRASH_ITEM_COUNT - 1, 1, mr_crash_item_name},
    {MR_ID_CAN_ALARM, "state", 0, MR_CAN_MISSING, 1, mr_can_state_text},
    {MR_ID_RESTARTS, "late_task", 1, MR_TASK_COUNT - 1, 1, mr_task_text},
    {MR_ID_COMMAND, "code", MR_COMMAND_STATE, MR_COMMAND_SELF_TEST, 1, mr_command_name},
    {MR_ID_ACK, "code", MR_COMMAND_STATE, MR_COMMAND_SELF_TEST, 1, mr_command_name},
    {MR_ID_ACK, "status", 0, -MR_HALTED, -1, get_status_text},
};

/* Writes the named values of a field, with a blank before each. */
static void list_values(FILE *out, const struct mr_message_info *message,
                        const struct mr_field_info *field)
{
    if (field->counts_per_unit > 0.0f)
        write_value(out, field->type == MR_WIRE_u16 ? 65535 : -32768, "missing");
    for (size_t i = 0; i < sizeof named_values / sizeof named_values[0]; i++) {
        bool is = named_values[i].id == message->id &&
                  strcmp(named_values[i].field, field->name) == 0;
        for (unsigned number = named_values[i].first; is && number <= named_values[i].last;
             number++) {
            const char *text = named_values[i].text(number);
            if (strcmp(text, "unknown fault") != 0) /* leave out numbers that no fault uses */
                write_value(out, named_values[i].sign * (long)number, text);
        }
    }
    for (const struct mr_value *value = field->values;
         field->coding == MR_CODING_ENUM && value->text; value++) {
        if (value->text[0])
            write_value(out, value->number, value->text);
    }
}

static void write_values(FILE *out, const struct mr_message_info *message,
                         const struct mr_field_info *field, uint16_t base)
{
    bool coded = field->counts_per_unit > 0.0f || field->coding == MR_CODING_ENUM;
    for (size_t i = 0; i < sizeof named_values / sizeof named_values[0]; i++)
        coded |= named_values[i].id == message->id &&
                 strcmp(named_values[i].field, field->name) == 0;
    if (!coded)
        return;
    fprintf(out, "VAL_ %u %s", mr_can_id_to_bus(message->id, base), field->name);
    list_values(out, message, field);
    fputs(" ;\n", out);
}

static void write_attributes(FILE *out, const struct mr_message_info *messages, size_t count,
                             uint16_t base)
{
    fputs("BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\nBA_DEF_ \"BusType\" STRING ;\n"
          "BA_DEF_DEF_ \"GenMsgCycleTime\" 0;\nBA_DEF_DEF_ \"BusType\" \"CAN\";\nBA_ \"BusType\" "
          "\"CAN\";\n",
          out);
    for (size_t m = 0; m < count; m++) {
        if (messages[m].period_ms)
            fprintf(out, "BA_ \"GenMsgCycleTime\" BO_ %u %u;\n",
                    mr_can_id_to_bus(messages[m].id, base), messages[m].period_ms);
    }
}

unsigned dbc_write(FILE *out, uint16_t base)
{
    size_t count;
    const struct mr_message_info *messages = mr_catalogue_messages(&count);
    char text[400];

    fputs("VERSION \"\"\n\nNS_ "
          ":\n\tCM_\n\tBA_DEF_\n\tBA_\n\tVAL_\n\tBA_DEF_DEF_\n\tSIG_VALTYPE_\n\nBS_:\n\nBU_: BOARD "
          "HOST\n\n",
          out);
    for (size_t m = 0; m < count; m++) {
        const struct mr_message_info *message = &messages[m];
        fprintf(out, "BO_ %u %s: %u %s\n", mr_can_id_to_bus(message->id, base), message->name,
                message->length, message->direction == MR_DIRECTION_HOST ? "HOST" : "BOARD");
        for (unsigned f = 0; f < message->field_count; f++)
            write_signal(out, message, &message->fields[f]);
        fputc('\n', out);
    }
    fprintf(out,
            "CM_ \"matrig, message layout %u. Scaled signals keep one raw value for missing data.",
            MR_LAYOUT);
    if (base)
        fprintf(out, " All identifiers include base 0x%03x of the board.", base);
    fputs("\";\n", out);
    for (size_t m = 0; m < count; m++) {
        fprintf(out, "CM_ BO_ %u ", mr_can_id_to_bus(messages[m].id, base));
        write_text(out, messages[m].text);
        fputs(";\n", out);
        for (unsigned f = 0; f < messages[m].field_count; f++) {
            fprintf(out, "CM_ SG_ %u %s ", mr_can_id_to_bus(messages[m].id, base),
                    messages[m].fields[f].name);
            mr_field_text(&messages[m].fields[f], text, sizeof text);
            write_text(out, text);
            fputs(";\n", out);
        }
    }
    write_attributes(out, messages, count, base);
    for (size_t m = 0; m < count; m++) {
        for (unsigned f = 0; f < messages[m].field_count; f++)
            write_values(out, &messages[m], &messages[m].fields[f], base);
    }
    for (size_t m = 0; m < count; m++) {
        for (unsigned f = 0; f < messages[m].field_count; f++) {
            if (messages[m].fields[f].type == MR_WIRE_f32)
                fprintf(out, "SIG_VALTYPE_ %u %s : 1;\n", mr_can_id_to_bus(messages[m].id, base),
                        messages[m].fields[f].name);
        }
    }
    return (unsigned)count;
}
