#include "common/catalogue.h"
#include "common/command.h"
#include "common/fault.h"
#include "docs/reference/reference.h"

static const char *type_text(enum mr_wire_type type)
{
    static const char *const texts[] = {"u8", "i8", "u16", "i16", "u32", "i32", "f32"};
    return texts[type];
}

static const char *direction_text(enum mr_direction direction)
{
    static const char *const texts[] = {"From the board, on CAN and serial",
                                        "From the board, on CAN alone",
                                        "To the board, on either link"};
    return texts[direction];
}

static void write_field(FILE *out, const struct mr_field_info *field)
{
    char text[1000];
    mr_field_text(field, text, sizeof text);
    fprintf(out, "| %u | `%s` | %s | ", field->offset, field->name, type_text(field->type));
    if (field->per_unit > 0.0f)
        fprintf(out, "%.9g %s", 1.0 / (double)field->per_unit, field->unit);
    else
        fputs(field->unit, out);
    fputs(" | ", out);
    reference_cell(out, text);
    fputs(" |\n", out);
}

static void write_message(FILE *out, const struct mr_message_info *message)
{
    fprintf(out, "\n### %s, 0x%03x\n\n%s. %s; %u bytes", message->name, message->id, message->text,
            direction_text(message->direction), message->length);
    if (message->every_ms)
        fprintf(out, "; every %u ms", message->every_ms);
    fputs(".\n\n| byte | field | type | resolution or unit | meaning |\n|---|---|---|---|---|\n",
          out);
    for (size_t i = 0; i < message->field_count; i++)
        write_field(out, &message->fields[i]);
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
        "\n## Commands to the board\n\nThe message `command` carries a code. In another state than "
        "those named, or by another link, the board refuses it. The jumper: MAINTENANCE "
        "([pins](pins.md)).\n\n| code | name | who | state of the landing | link | counts a unit "
        "of the argument | meaning |\n|---|---|---|---|---|---|---|\n",
        out);
#define COMMAND(NAME, code, text, part, indexed, counts, privilege, states, links, meaning)       \
    fprintf(out, "| %d | `%s` | %s | %s | %s | %d | %s |\n", code, text,                          \
            who[MR_PRIVILEGE_##privilege], when[MR_WHEN_##states], how[MR_LINKS_##links], counts, \
            meaning);
#include "common/catalogue.def"
}

static void write_faults(FILE *out)
{
    fputs("\n## Faults\n\nThe number of a fault is its bit in `health.faults`. A bracket in the "
          "text says what the detail means.\n\n| fault | text |\n|---|---|\n",
          out);
#define ROW(NAME, number, text) fprintf(out, "| %u | %s |\n", number, text);
    MR_FAULT_TABLE(ROW)
#undef ROW
}

void reference_messages(FILE *out)
{
    size_t count;
    const struct mr_message_info *messages = mr_catalogue(&count);
    reference_head(out, "Messages", "`common/catalogue*.def` and `common/fault.h`");
    fprintf(
        out,
        "The layout version is %u. The identifier is the CAN identifier and the serial type. On "
        "CAN a board with another base than 0 adds it\n"
        "([the base](../howto/configure.md#can-base)); all pages "
        "are in terms of these, without a base.\n"
        "All integers are little-endian. A scaled field keeps one code for \"missing\". `matrig "
        "export --format dbc` writes the same as a DBC file.\n\n## Messages\n",
        MR_LAYOUT);
    for (size_t i = 0; i < count; i++)
        write_message(out, &messages[i]);
    write_commands(out);
    write_faults(out);
}
