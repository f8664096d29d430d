/* matrig bundle: one landing as a campaign of its own. */
#include <string.h>

#include "host/cli.h"
#include "host/run.h"
#include "host/store/store.h"

int bundle_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2] = {NULL, NULL}, *path = NULL;
    const struct cli_option options[] = {{"-o", &path, NULL}};
    struct error error = {0};
    struct store *store = NULL;
    int64_t run = 0;
    enum mr_status status = cli_parse(argc, argv, options, 1, words, 2, 2, "DB RUN", &error);
    if (status == MR_OK && !path)
        status = error_set(&error, MR_USAGE, "nowhere to write: matrig bundle needs -o F; see matrig bundle --help");
    if (status == MR_OK && strcmp(path, "-") == 0)
        status = error_set(&error, MR_USAGE, "not a file: -; a bundle is a database, give it a path");
    if (status == MR_OK)
        status = run_parse(words[1], &run, &error);
    if (status == MR_OK)
        status = store_open(words[0], STORE_OPEN, &store, &error);
    if (status == MR_OK)
        status = store_bundle(store, run, path, &error);
    store_close(store);
    if (status != MR_OK)
        return cli_fail(&error);
    if (cli->json)
        return cli_print_json(json_pack("{sssssI}", "file", path, "db", words[0], "run", (json_int_t)run), 0);
    cli_note(cli, "RUN %lld of %s is RUN 1 of %s", (long long)run, words[0], path);
    return 0;
}
