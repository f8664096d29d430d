/* matrig migrate: a campaign of an older matrig, brought forward. */
#include <stdio.h>

#include "host/cli.h"
#include "host/store/store.h"

int migrate_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[1] = {NULL};
    bool check = false, bare = false, older = false;
    const struct cli_option options[] = {{"--check", NULL, &check}, {"--no-backup", NULL, &bare}};
    struct error error = {0};
    struct store *store = NULL;
    enum mr_status status = cli_parse(argc, argv, options, 2, words, 1, 1, "DB", &error);
    if (status == MR_OK && check && bare)
        status = error_set(&error, MR_USAGE, "either --check or --no-backup: matrig migrate; see matrig migrate --help");
    if (status == MR_OK)
        status = store_open(words[0], check ? STORE_READ : bare ? STORE_BARE : STORE_OPEN, &store, &error);
    if (status != MR_OK)
        return cli_fail(&error);
    int64_t version = store_version(store, &older);
    store_close(store);
    int exit_code = check && older ? mr_status_exit_code(MR_LIMIT) : 0;
    if (cli->json)
        return cli_print_json(json_pack("{sssIsisb}", "db", words[0], "found", (json_int_t)version, "version", STORE_VERSION, "older", older),
                              exit_code);
    if (check)
        printf("%s: version %lld, %s\n", words[0], (long long)version, older ? "older than this matrig's" : "this matrig's");
    else if (!older)
        printf("%s: version %lld already\n", words[0], (long long)version);
    return exit_code;
}
