/* matrig dbc: the CAN messages as a Vector DBC file. */
#include "host/commands/commands.h"
#include "host/export/dbc.h"
#include "host/link/bases.h"
#include "host/base/output.h"

struct request {
    const char *path, *base_text;
    bool force;
};

static int dbc_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {0};
    struct error error = {0};
    unsigned messages = 0;
    uint16_t base = 0;
    enum mr_status status = command_parse(&command_dbc, argc, argv, cli, &r, NULL, &error);
    if (status == MR_OK && r.base_text)
        status = link_read_base(r.base_text, "--base", &base, &error);
    if (status == MR_OK && cli->json && !r.path)
        status = error_set(
            &error, MR_USAGE,
            "nowhere to write: matrig --json dbc needs -o F; standard output is the JSON's");
    struct output output;
    if (status == MR_OK && output_begin(&output, r.path, r.force, &error) == MR_OK) {
        messages = dbc_write(output.file, base);
        output_end(&output, &error);
    }
    if (error.status != MR_OK)
        return cli_fail(&error);
    if (cli->json)
        return cli_print_json(
            json_pack("{sssisi}", "file", r.path, "messages", (int)messages, "base", base), 0);
    return 0;
}

#define VALUES struct request
static const struct command_part parts[] = {
    OPTION_TEXT("-o", "F", path, "where to write; else standard output"),
    OPTION_TEXT("--base", "B", base_text,
                "of a board with this base on its bus, which is added to every identifier: 400 and "
                "0x190 are the same; else 0"),
    OPTION_FORCE(force),
    HELP_EXAMPLE("matrig dbc -o matrig.dbc; matrig dbc --base 0x190 -o second.dbc"),
};

const struct command command_dbc = {
    "dbc",
    dbc_command,
    "[-o F] [--base B] [--force]",
    "the CAN messages as a Vector DBC file",
    COMMAND_PARTS(parts),
    {0, 0, ""},
};
