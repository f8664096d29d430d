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

static void write_field(FILE *out, const struct mr_field_info *field)
{
    char text[1000];
    if (strncmp(field->name, "reserved", strlen("reserved")) == 0)
        return;
    mr_field_text(field, text, sizeof text);
    fprintf(out, "| %u | `%s` | %s | ", field->offset, field->name, type_text(field->type));
    if (field->per_unit > 0.0f)
        fprintf(out, "%.9g%s%s", 1.0 / (double)field->per_unit, field->unit[0] ? " " : "",
                field->unit);
    else
        fputs(field->unit, out);
    fputs(" | ", out);
    reference_cell(out, text);
    fputs(" |\n", out);
}

/* The head of a message is a row of the table, its fields are the rows below. */
static void write_message(FILE *out, const struct mr_message_info *message)
{
    fprintf(out, "| **0x%03x** | **%s** | ", message->id, message->name);
    if (message->length != 8)
        fprintf(out, "%u bytes", message->length);
    fputs(" | ", out);
    if (message->every_ms)
        fprintf(out, "%u ms", message->every_ms);
    fputs(" | ", out);
    reference_cell(out, message->text);
    fprintf(out, "%s |\n", message->direction == MR_DIRECTION_CAN ? "; CAN only" : "");
    for (size_t i = 0; i < message->field_count; i++)
        write_field(out, &message->fields[i]);
}

static void write_messages(FILE *out)
{
    size_t count, section = 0;
    const struct mr_message_info *messages = mr_catalogue(&count);
    for (size_t i = 0; i < count; i++) {
        while (section < SECTIONS && messages[i].id >= sections[section].first_id)
            fprintf(out,
                    "\n## %s\n\n| Byte | Field | Type | Unit | Meaning |\n|--:|---|---|---|---|\n",
                    sections[section++].title);
        write_message(out, &messages[i]);
    }
}

static void write_commands(FILE *out)
{
    static const char *const who[] = {"anyone", "anyone", "operator", "maintenance"},
                             *const when[] = {[MR_WHEN_IDLE] = "idle",
                                              [MR_WHEN_AT_REST] = "idle, done",
                                              [MR_WHEN_RECORDING] = "armed, landing, settling",
                                              [MR_WHEN_ANY] = "always"},
                             *const how[] = {[MR_LINKS_BOTH] = "either",
                                             [MR_LINKS_CABLE] = "serial; CAN with the jumper",
                                             [MR_LINKS_JUMPER] = "serial with the jumper",
                                             [MR_LINKS_REPLAY] = "either, after `replay`"};
    fputs(
        "\n## Commands to the board\n\nThe message `command` carries a code. The board accepts a "
        "command only in the state of the landing and over the link that the table lists. Jumper: "
        "MAINTENANCE ([pins](pins.md)).\n\n| Code | Name | Allowed for | State | Link | Effect |\n"
        "|--:|---|---|---|---|---|\n",
        out);
#define COMMAND(NAME, code, text, part, indexed, counts, privilege, states, links, meaning)        \
    fprintf(out, "| %d | `%s` | %s | %s | %s | %s |\n", code, text, who[MR_PRIVILEGE_##privilege], \
            when[MR_WHEN_##states], how[MR_LINKS_##links], meaning);
#include "common/catalogue.def"
}

static void write_faults(FILE *out)
{
    fputs("\n## Faults\n\nFault n sets bit n of `health.faults`. Brackets explain the field "
          "`detail` of the message `fault`.\n\n| Fault | Meaning |\n|--:|---|\n",
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
        "Layout version %u. A bold row begins a message. It contains the CAN identifier (also the "
        "type of the serial frame), the name, the length if it is not 8 bytes, the period and the "
        "meaning. The rows below it are the fields of the message.\n\n"
        "- The board sends a message on CAN and serial unless stated otherwise. A board with a CAN "
        "base adds the base to every CAN identifier ([base](../howto/configure.md#can-base)).\n"
        "- Integers are little-endian. A unit that begins with a number is the resolution of a "
        "scaled integer. In a scaled integer, 65535 (u16) or -32768 (i16) means \"missing\". "
        "Reserved bytes are 0 and not listed.\n"
        "- `tick` is a count of timer TIM2 (84 MHz). Status codes are the negative numbers in "
        "`common/status.h`; an unsigned field holds the code without its sign.\n"
        "- A block is one millisecond of acquisition; `block16` is the low 16 bits of the block "
        "index.\n"
        "- `matrig export --format dbc` writes this table as a DBC file.\n",
        MR_LAYOUT);
    write_messages(out);
    write_commands(out);
    write_faults(out);
}
