/* The command matrig bundle: writes one landing and the firmware image that recorded it to a file,
 * to pass on. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/output.h"
#include "host/base/command.h"
#include "host/base/xmalloc.h"
#include "host/commands/commands.h"
#include "host/exchange/import.h"
#include "host/board/imagefile.h"
#include "host/replay/board.h"
#include "host/store/store.h"

struct request {
    const char *words[2]; /* operands DB and RUN */
    const char *path, *elf;
    int64_t run;
};

/* Opens the firmware image that recorded the landing: the image of --elf, or the image installed
 * with matrig. Either must match the landing. */
static enum mr_status find_image(const struct request *r, struct store *store,
                                 const struct cli *cli, struct textfile *file, struct error *error)
{
    char path[PATH_MAX];
    struct store_landing landing;
    struct imagefile image = {0};
    struct error unread = {0};
    enum mr_status status = store_landing_get(store, r->run, &landing, error);
    if (status != MR_OK)
        return status;
    replay_find_image_path(store, r->run, path, sizeof path);
    const char *elf = r->elf ? r->elf : path;
    bool same = imagefile_read(elf, &image, r->elf ? error : &unread) == MR_OK &&
                image.has_header && landing.image_crc == (int64_t)image.header.program_crc;
    imagefile_free(&image);
    if (same)
        return textfile_open(elf, file, error);
    if (r->elf && error->status == MR_OK)
        return error_set(error, MR_USAGE,
                         "a different image recorded this landing (image %08x, commit %s): %s; "
                         "give that image with --elf, or leave --elf out",
                         (unsigned)landing.image_crc, landing.image_commit, elf);
    if (!r->elf && unread.status == MR_IO && access(path, F_OK) == 0)
        /* report the error: without the image the bundle would be incomplete */
        *error = unread;
    else if (!r->elf)
        cli_note(cli,
                 "the bundle lacks the image that recorded the landing (image %08x, commit %s), "
                 "which is not the image of this matrig; add it with --elf F",
                 (unsigned)landing.image_crc, landing.image_commit);
    return error->status;
}

static void remove_draft(const char *path)
{
    static const char *const tails[] = {"", "-wal", "-shm", "-journal"};
    for (size_t i = 0; i < sizeof tails / sizeof tails[0]; i++) {
        char *beside = xasprintf("%s%s", path, tails[i]);
        unlink(beside);
        free(beside);
    }
}

static enum mr_status make_bundle(struct request *r, const struct cli *cli, size_t *image_bytes,
                                  struct error *error)
{
    struct store *store = NULL;
    struct textfile image = {0};
    /* the process id in the name distinguishes drafts of different processes */
    char *draft = xasprintf("%s.making-%ld", r->path, (long)getpid());
    if (access(r->path, F_OK) == 0)
        error_set(error, MR_USAGE, "file exists already: %s; give a different file", r->path);
    if (error->status == MR_OK &&
        store_open(r->words[0], STORE_READ_FOR_BUNDLE, &store, error) == MR_OK &&
        store_find_run(store, &r->run, error) == MR_OK &&
        find_image(r, store, cli, &image, error) == MR_OK &&
        store_bundle_make(store, r->run, draft, (const uint8_t *)image.text, image.length, error) ==
            MR_OK &&
        rename(draft, r->path) != 0)
        error_set(error, MR_IO, "cannot be written (%s): %s; check the path and the permissions",
                  strerror(errno), r->path);
    store_close(store);
    remove_draft(draft);
    free(draft);
    *image_bytes = image.length;
    textfile_close(&image);
    return error->status;
}

static int bundle_command(int argc, char **argv, const struct cli *cli)
{
    struct request r = {0};
    struct error error = {0};
    size_t image = 0;
    command_parse(&command_bundle, argc, argv, cli, &r, r.words, fatal);
    if ((!r.path || strcmp(r.path, "-") == 0))
        error_set(fatal, MR_USAGE,
                  "no file to write: matrig bundle needs -o F; see matrig bundle --help");
    parse_run(r.words[1], &r.run, fatal);
    if (make_bundle(&r, cli, &image, &error) != MR_OK)
        return cli_fail(&error);
    if (cli->json)
        return cli_print_json(json_pack("{sssssIsI}", "file", r.path, "db", r.words[0], "run",
                                        (json_int_t)r.run, "image_bytes", (json_int_t)image),
                              0);
    cli_note(cli, "%s: contains RUN %lld of %s as RUN 1; matrig replay %s checks and replays it",
             r.path, (long long)r.run, r.words[0], r.path);
    return 0;
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB RUN", "campaign database and number of a landing"),
    OPTION_TEXT("-o", "F.db", path,
                "file to write: a campaign with this landing as RUN 1 and the firmware image; its "
                "table bundles has the SHA-256 of the image and the record"),
    OPTION_TEXT("--elf", "F", elf,
                "image that recorded the landing (any other is refused); default: the installed "
                "image, if it matches"),
    HELP_EXAMPLE("matrig bundle campaign.db 5 -o passed-on.db"),
};

const struct command command_bundle = {
    "bundle",
    bundle_command,
    "DB RUN -o F [--elf F]",
    "pack one landing and its firmware image into a new campaign",
    COMMAND_PARTS(parts),
    {2, 2, "DB RUN"},
};
