#include <stdbool.h>
#include <string.h>

#include "common/catalogue.h"
#include "common/command.h"
#include "common/fault.h"
#include "docs/reference/reference.h"

/* A section holds the messages from its first identifier to that of the next section. */
static const struct section {
    uint16_t first_id;
    const char *title;
} sections[] = {
    {0x000, "Landing, predictor and channels"},
    {0x100, "Displacements and tensions"},
    {0x180, "Health, configuration and identity"},
    {0x400, "To the board"},
};
#define SECTIONS (sizeof sections / sizeof sections[0])

static const char *type_text(enum mr_wire_type type)
{
    static const char *const texts[] = {"u8", "i8", "u16", "i16", "u32", "i32", "f32"};
    return texts[type];
}

#define TEXT_MAX 1000

/* Consecutive fields that differ in a final number alone share a row: "transducer 1 to 3". */
static size_t stem_length(const char *text)
{
    size_t length = strlen(text);
    while (length > 0 && text[length - 1] >= '0' && text[length - 1] <= '9')
        length--;
    return length;
}

/* Length of the text before the final number or sum: "transducer ", or "gap of joint " of "gap of
 * joint `index` + 2". */
static size_t length_before_end(const char *text)
{
    size_t length = stem_length(text);
    if (length > 3 && strncmp(text + length - 3, " + ", 3) == 0) {
        length -= 3;
        while (length > 0 && text[length - 1] != ' ')
            length--;
    }
    return length;
}

static bool is_listed(const struct mr_field_info *field)
{
    return strncmp(field->name, "reserved", strlen("reserved")) != 0 &&
           strcmp(field->name, "block16") != 0;
}

static bool is_alike(const struct mr_field_info *a, const struct mr_field_info *b)
{
    char text[TEXT_MAX], other[TEXT_MAX];
    mr_field_text(a, text, sizeof text);
    mr_field_text(b, other, sizeof other);
    size_t stem = stem_length(text);
    return is_listed(b) && a->type == b->type && a->counts_per_unit == b->counts_per_unit &&
           strcmp(a->unit, b->unit) == 0 && stem == stem_length(other) &&
           strncmp(text, other, stem) == 0;
}

/* Returns the number of fields in the row. */
static size_t write_fields(FILE *out, const struct mr_field_info *field, size_t count)
{
    char text[TEXT_MAX], last[TEXT_MAX];
    size_t alike = 1;
    if (!is_listed(field))
        return 1;
    while (alike < count && is_alike(field, &field[alike]))
        alike++;
    for (size_t i = 0; i < alike; i++)
        fprintf(out, "%s%u", i == 0 ? "| " : ", ", field[i].offset);
    for (size_t i = 0; i < alike; i++)
        fprintf(out, "%s`%s`", i == 0 ? " | " : ", ", field[i].name);
    fprintf(out, " | %s", type_text(field->type));
    if (field->counts_per_unit > 0.0f)
        fprintf(out, ", %.9g", 1.0 / (double)field->counts_per_unit);
    if (field->unit[0])
        fprintf(out, "%s%s", field->counts_per_unit > 0.0f ? " " : ", ", field->unit);
    fputs(" | ", out);
    mr_field_text(field, text, sizeof text);
    mr_field_text(&field[alike - 1], last, sizeof last);
    reference_cell(out, text);
    if (strcmp(last, text) != 0)
        fprintf(out, " to %s", last + length_before_end(last));
    fputs(" |\n", out);
    return alike;
}

/* The head of a message is a row of the table, its fields are the rows below. */
static void write_message(FILE *out, const struct mr_message_info *message)
{
    const char *comma = "";
    fprintf(out, "| 0x%03x | **%s** | ", message->id, message->name);
    if (message->period_ms) {
        fprintf(out, "%u ms", message->period_ms);
        comma = ", ";
    }
    if (message->length != 8) {
        fprintf(out, "%s%u bytes", comma, message->length);
        comma = ", ";
    }
    if (strcmp(message->fields[message->field_count - 1].name, "block16") == 0) {
        fprintf(out, "%s`block16`", comma);
        comma = ", ";
    }
    if (message->direction == MR_DIRECTION_CAN)
        fprintf(out, "%sCAN", comma);
    fputs(comma[0] ? " | " : "| ", out);
    reference_cell(out, message->text);
    fputs(" |\n", out);
    for (size_t i = 0; i < message->field_count;)
        i += write_fields(out, &message->fields[i], message->field_count - i);
}

static void write_messages(FILE *out)
{
    size_t count, section = 0;
    const struct mr_message_info *messages = mr_catalogue_messages(&count);
    for (size_t i = 0; i < count; i++) {
        while (section < SECTIONS && messages[i].id >= sections[section].first_id)
            fprintf(out, "\n## %s\n\n| Byte | Field | Type, unit | Meaning |\n|--:|---|---|---|\n",
                    sections[section++].title);
        write_message(out, &messages[i]);
    }
}

static void write_commands(FILE *out)
{
    static const char *const who[] = {"anyone", "anyone", "operator", "maintenance"},
                             *const when[] = {[MR_STATES_IDLE] = "idle",
                                              [MR_STATES_AT_REST] = "idle, done",
                                              [MR_STATES_RECORDING] = "armed, landing, settling",
                                              [MR_STATES_ANY] = "always"},
                             *const how[] = {[MR_LINKS_BOTH] = "either",
                                             [MR_LINKS_CABLE] = "serial; CAN only with the jumper",
                                             [MR_LINKS_JUMPER] = "serial with the jumper",
                                             [MR_LINKS_REPLAY] = "either, after `replay`"};
    fputs(
        "\n## Commands to the board\n\nThe message `command` contains a code. The board accepts a "
        "command only in the state of the landing and over the link that the table lists. Jumper: "
        "MAINTENANCE ([pins](pins.md)).\n\n| Code | Name | Allowed for | State | Link | Effect |\n"
        "|--:|---|---|---|---|---|\n",
        out);
#define COMMAND(NAME, code, text, part, indexed, counts, privilege, states, links, meaning)        \
    fprintf(out, "| %d | `%s` | %s | %s | %s | %s |\n", code, text, who[MR_PRIVILEGE_##privilege], \
            when[MR_STATES_##states], how[MR_LINKS_##links], meaning);
#include "common/catalogue.def"
}

static void write_faults(FILE *out)
{
    fputs("\n## Faults\n\nFault n sets bit n of `health.faults`. Brackets contain the meaning of "
          "the field `detail` of the message `fault`.\n\n| Fault | Meaning |\n|--:|---|\n",
          out);
#define ROW(NAME, number, text) fprintf(out, "| %u | %s |\n", number, text);
    MR_FAULT_TABLE(ROW)
#undef ROW
}

void reference_messages(FILE *out)
{
    reference_head(out, "Messages", "`common/catalogue*.def` and `common/fault.h`");
    fprintf(
        out,
        "Layout version %u. A row with a bold name begins a message: CAN identifier (also the type "
        "of the serial frame), name, period, contents. The rows below it describe the fields.\n\n"
        "- A message has 8 bytes and is sent on CAN and serial, unless the column *Type, unit* "
        "states "
        "otherwise. A board with a CAN base adds the base to every CAN identifier "
        "([base](../howto/configure.md#can-base)).\n"
        "- Integers are little-endian. A unit that begins with a number is the resolution of a "
        "scaled integer; 65535 (u16) or -32768 (i16) then means \"missing\". Reserved bytes are 0 "
        "and not listed.\n"
        "- A block is one millisecond of acquisition. With `block16` in that column, bytes 6 "
        "and 7 are the low 16 bits of the message's block index (u16, ms).\n"
        "- `tick` is a count of timer TIM2 (84 MHz). [Status codes](exit-codes.md) are negative; "
        "an unsigned field holds the code without its sign.\n"
        "- `matrig export --format dbc` writes these messages as a DBC file.\n",
        MR_LAYOUT);
    write_messages(out);
    write_commands(out);
    write_faults(out);
}
