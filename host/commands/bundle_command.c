/* matrig bundle: one landing with all that a replay of it needs, in one file. */
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/bundle/bundle.h"
#include "host/commands/commands.h"
#include "host/replay/image.h"
#include "host/base/place.h"
#include "host/base/run.h"
#include "host/sim/scene/scene.h"
#include "host/store/store.h"

/* "page,candump" */
static enum mr_status leave_out(const char *list, bool without[BUNDLE_FILES], struct error *error)
{
    while (list && *list) {
        size_t length = strcspn(list, ",");
        int found = -1;
        for (int i = 0; i < BUNDLE_FILES; i++) {
            if (strlen(bundle_files[i].option) == length &&
                memcmp(bundle_files[i].option, list, length) == 0)
                found = i;
        }
        if (found < 0)
            return error_set(error, MR_USAGE,
                             "no such part: '%.*s' for --without; use page, candump, "
                             "configuration, scene, firmware",
                             (int)length, list);
        without[found] = true;
        list += length + (list[length] == ',');
    }
    return MR_OK;
}

static int tell(const struct bundle_made *made, const char *db, int64_t run, const char *path,
                const struct cli *cli)
{
    json_t *files = json_object();
    for (int i = 0; i < BUNDLE_FILES; i++) {
        json_object_set_new(files, bundle_files[i].name,
                            made->file_bytes[i] ? json_integer((json_int_t)made->file_bytes[i])
                                                : json_null());
        if (!cli->json && !made->file_bytes[i])
            cli_note(cli, "without %s: %s", bundle_files[i].name, made->why_not[i]);
    }
    if (cli->json)
        return cli_print_json(json_pack("{sssssIsIssso}", "file", path, "db", db, "run",
                                        (json_int_t)run, "bytes", (json_int_t)made->bytes, "sha256",
                                        made->digest, "files", files),
                              0);
    json_decref(files);
    cli_note(cli,
             "RUN %lld of %s is RUN 1 of %s, %zu bytes, checked and replayed by: matrig replay %s",
             (long long)run, db, path, made->bytes, path);
    return 0;
}

static enum mr_status scene_check(const char *path, struct error *error)
{
    struct sim_scene *scene = malloc(sizeof *scene);
    if (!scene)
        return error_set(error, MR_FULL, "no memory: %s; close other programs", path);
    enum mr_status status = sim_scene_load(scene, path, error);
    if (status == MR_OK)
        sim_scene_free(scene);
    free(scene);
    return status;
}

struct request {
    const char *path, *without;
    struct bundle_want want;
};

static int bundle_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2];
    char elf[PATH_MAX], scene[PATH_MAX];
    struct request r = {0};
    struct bundle_want *want = &r.want;
    struct bundle_made made;
    struct error error = {0};
    struct store *store = NULL;
    int64_t run = 0;
    enum mr_status status = command_parse(&command_bundle, argc, argv, cli, &r, words, &error);
    if (status == MR_OK && !r.path)
        status = error_set(&error, MR_USAGE,
                           "nowhere to write: matrig bundle needs -o F; see matrig bundle --help");
    if (status == MR_OK && strcmp(r.path, "-") == 0)
        status = error_set(&error, MR_USAGE,
                           "not a file: -; a bundle is a database, give it a path");
    if (status == MR_OK)
        status = leave_out(r.without, want->without, &error);
    if (status == MR_OK)
        status = run_parse(words[1], &run, &error);
    if (status == MR_OK && want->scene)
        status = scene_check(want->scene, &error);
    place_find(PLACE_RUNWAY, scene, sizeof scene);
    if (!want->scene && access(scene, R_OK) == 0)
        want->scene = scene;
    if (status == MR_OK)
        status = store_open(words[0], STORE_OPEN, &store, &error);
    if (status == MR_OK && !want->elf) {
        replay_image_find(store, run, elf, sizeof elf);
        want->elf = elf;
    }
    if (status == MR_OK)
        status = bundle_make(store, run, want, r.path, &made, &error);
    store_close(store);
    return status == MR_OK ? tell(&made, words[0], run, r.path, cli) : cli_fail(&error);
}

#define VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB RUN", "campaign database and number of the landing in it, from 1"),
    OPTION_TEXT("-o", "F", path,
                "where to write it: a database in which the landing is RUN 1, with page, candump "
                "log, configuration,\n"
                "scene and firmware image as an archive (sqlite3 F -Ax) and SHA-256 of each; at "
                "most 10 MB"),
    OPTION_TEXT(
        "--elf", "F", want.elf,
        "the image that recorded it, another one is refused; else the one that came with matrig"),
    OPTION_TEXT("--scene", "F", want.scene,
                "when the landing was not compared; else the model runway"),
    OPTION_TEXT("--without", "P", without,
                "parts to leave out, with commas: page, candump, configuration, scene, firmware"),
    OPTION_FORCE(want.force),
    HELP_EXAMPLE("matrig bundle campaign.db 5 -o landing5.bundle"),
};

const struct command command_bundle = {
    "bundle",
    bundle_command,
    "DB RUN -o F [--force] [--elf F] [--scene F] [--without PART,...]",
    "one landing with all that a replay needs, in one file, to pass on",
    COMMAND_PARTS(parts),
    {2, 2, "DB RUN"},
};
