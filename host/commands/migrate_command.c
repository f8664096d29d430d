/* matrig migrate: a campaign of an older matrig, brought forward. */
#include <stdio.h>

#include "host/commands/commands.h"
#include "host/store/store.h"

struct request {
    bool check, bare;
};

static int migrate_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[1];
    struct request r = {0};
    bool older = false;
    struct error error = {0};
    struct store *store = NULL;
    enum mr_status status = command_parse(&command_migrate, argc, argv, cli, &r, words, &error);
    if (status == MR_OK && r.check && r.bare)
        status =
            error_set(&error, MR_USAGE,
                      "either --check or --no-backup: matrig migrate; see matrig migrate --help");
    if (status == MR_OK)
        status = store_open(words[0],
                            r.check  ? STORE_READ
                            : r.bare ? STORE_BARE
                                     : STORE_OPEN,
                            &store, &error);
    if (status != MR_OK)
        return cli_fail(&error);
    int64_t version = store_version(store, &older);
    store_close(store);
    int exit_code = r.check && older ? mr_status_exit_code(MR_LIMIT) : 0;
    if (cli->json)
        return cli_print_json(json_pack("{sssIsisb}", "db", words[0], "found", (json_int_t)version,
                                        "version", STORE_VERSION, "older", older),
                              exit_code);
    if (r.check)
        printf("%s: version %lld, %s\n", words[0], (long long)version,
               older ? "older than this matrig's" : "this matrig's");
    else if (!older)
        printf("%s: version %lld already\n", words[0], (long long)version);
    return exit_code;
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database. What writes to a campaign brings it forward by itself; "
                    "what reads does not need to"),
    OPTION_FLAG("--check", check, "only say which version it has; exit 1 when it is an older one"),
    OPTION_FLAG("--no-backup", bare,
                "keep no copy; else it stays beside it as it was, as DB.v2 and so on"),
    HELP_NOTE("All of it happens or nothing, also when the power fails. "),
    HELP_EXAMPLE("matrig migrate campaign.db --check"),
};

const struct command command_migrate = {
    "migrate",
    migrate_command,
    "DB [--check | --no-backup]",
    "bring a campaign of an older matrig forward",
    COMMAND_PARTS(parts),
    {1, 1, "DB"},
};
