/* matrig dbc: the CAN messages as a Vector DBC file. */
#include "host/cli.h"
#include "host/export/dbc.h"
#include "host/output.h"

int dbc_command(int argc, char **argv, const struct cli *cli)
{
    const char *path = NULL;
    bool force = false;
    const struct cli_option options[] = {{"-o", &path, NULL}, {"--force", NULL, &force}};
    struct error error = {0};
    unsigned messages = 0;
    enum mr_status status = cli_parse(argc, argv, options, 2, NULL, 0, 0, "", &error);
    if (status == MR_OK && cli->json && !path)
        status = error_set(&error, MR_USAGE,
                           "nowhere to write: matrig --json dbc needs -o F; standard output is the JSON's");
    struct output output;
    if (status == MR_OK && output_begin(&output, path, force, &error) == MR_OK) {
        messages = dbc_write(output.file);
        output_end(&output, &error);
    }
    if (error.status != MR_OK)
        return cli_fail(&error);
    if (cli->json)
        return cli_print_json(json_pack("{sssi}", "file", path, "messages", (int)messages), 0);
    return 0;
}
