/* The command matrig replay: runs the firmware again with the input of a recorded landing. */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/board/config_text.h"
#include "host/commands/commands.h"
#include "host/base/data_dir.h"
#include "host/base/process.h"
#include "host/replay/board.h"
#include "host/replay/diff.h"
#include "host/replay/input.h"
#include "host/base/command.h"
#include "host/base/xmalloc.h"

#define CONFIG_COPY_A (MR_CONFIGURATION - MR_FLASH)

struct replay {
    const char *db;
    int64_t run;
    const char *speed;
    bool is_exact_required;
    struct replay_board board;
    char program[PATH_MAX], elf[PATH_MAX]; /* paths of the installed files, used by default */
    char directory[TEMPORARY_FOLDER_SIZE]; /* temporary folder; "": not created yet */
    /* path of the image unpacked from a bundle, in `directory` */
    char unpacked_elf_path[PATH_MAX + 20];
    struct board_messages recorded, replayed;
    struct replay_input input;
    struct diff diff;
    bool is_same_image;
};

static void set_default_paths(struct replay *replay)
{
    data_dir_find(DATA_BOARD_PROGRAM, replay->program, sizeof replay->program);
    data_dir_find(DATA_FIRMWARE, replay->elf, sizeof replay->elf);
    replay->board.program = replay->program;
    if (!replay->board.elf_path)
        replay->board.elf_path = replay->elf;
}

static void remove_directory(const struct replay *replay)
{
    static const char *const names[] = {"replay.txt", "can.log",   "serial.bin",
                                        "board.txt",  "flash.bin", "firmware.elf"};
    temporary_folder_remove(replay->directory, names, sizeof names / sizeof names[0]);
}

static enum mr_status load_losses(struct store *store, const struct replay *replay,
                                  struct diff_options *options, struct error *error)
{
    struct store_gap *gap;
    size_t gaps;
    enum mr_status status = store_gaps_get(store, replay->run, &gap, &gaps, error);
    if (status != MR_OK)
        return status;
    for (size_t i = 0; i < gaps; i++)
        options->has_losses[gap[i].link == LINK_SERIAL] = true;
    free(gap);
    return MR_OK;
}

static enum mr_status run_board(struct replay *replay, const struct cli *cli, struct error *error)
{
    struct store *answers = NULL;
    int64_t run = 0;
    replay->board.duration_s =
        (double)(replay->input.last_block - replay->input.shift_blocks) / 1e3 + 2.0;
    cli_note(cli, "playing %.3f s to %s", replay->board.duration_s, replay->board.elf_path);
    enum mr_status status = replay_board_run(&replay->board, replay->directory, &answers, &run,
                                             error)
                              ?: board_messages_load(answers, run, &replay->replayed, error);
    store_close(answers);
    return status;
}

/* Writes the configuration of the landing to copy A of the emulated flash. The built-in
 * configuration is part of the image and is not written. If the database lacks the configuration,
 * the replay has another one, and the comparison reports a difference in config_crc. */
static enum mr_status write_configuration(struct replay *replay, struct store *store,
                                          struct error *error)
{
    static struct mr_config config;
    static uint8_t flash[CONFIG_COPY_A + MR_CONFIG_IMAGE_BYTES];
    char path[PATH_MAX + 20];
    char *text = NULL;
    int64_t crc = replay->recorded.landing.config_crc;
    enum mr_status status = crc == STORE_NONE
                              ? MR_OK
                              : store_configuration_get(store, (uint32_t)crc, &text, error);
    if (status == MR_OK && text)
        status = config_text_read(text, replay->db, &config, error);
    replay->board.has_flash_file = status == MR_OK && text && config.site[0].revision > 0;
    replay->board.can_base = replay->board.has_flash_file ? config.site[0].can_base : 0;
    free(text);
    if (!replay->board.has_flash_file)
        return status;
    memset(flash, 0xff, sizeof flash);
    mr_config_encode(&config, flash + CONFIG_COPY_A);
    snprintf(path, sizeof path, "%s/flash.bin", replay->directory);
    FILE *file = fopen(path, "wb");
    bool written = file && fwrite(flash, sizeof flash, 1, file) == 1;
    if ((file && fclose(file) != 0) || !written)
        return error_set(error, MR_IO, "cannot be written: %s; check the free disk space", path);
    return MR_OK;
}

/* Finds the image: that of --elf, or that of the bundle, or the image installed with matrig. */
static enum mr_status find_image(struct replay *replay, struct store *store, struct error *error)
{
    bool bundled = false;
    snprintf(replay->unpacked_elf_path, sizeof replay->unpacked_elf_path, "%s/firmware.elf",
             replay->directory);
    enum mr_status status = store_bundle_extract(store, replay->run, replay->unpacked_elf_path,
                                                 &bundled, error);
    if (replay->board.elf_path != replay->elf)
        return status;
    if (bundled)
        replay->board.elf_path = replay->unpacked_elf_path;
    else
        replay_image_path(&replay->recorded, replay->elf, sizeof replay->elf);
    return status;
}

static enum mr_status write_input(struct replay *replay, struct store *store, struct error *error)
{
    char path[PATH_MAX + 20];
    snprintf(path, sizeof path, "%s/replay.txt", replay->directory);
    return replay_input_write(store, &replay->recorded, path, &replay->input, error);
}

static enum mr_status replay_run(struct replay *replay, struct store *store, const struct cli *cli,
                                 struct error *error)
{
    struct diff_options options = {0};
    if (!(board_messages_load(store, replay->run, &replay->recorded, error) == MR_OK &&
          temporary_folder_create(replay->directory, "replay", error) == MR_OK &&
          find_image(replay, store, error) == MR_OK &&
          replay_board_check(&replay->board, error) == MR_OK &&
          replay_image_check(replay->board.elf_path, &replay->recorded, error) == MR_OK &&
          write_input(replay, store, error) == MR_OK &&
          write_configuration(replay, store, error) == MR_OK &&
          load_losses(store, replay, &options, error) == MR_OK &&
          run_board(replay, cli, error) == MR_OK))
        return error->status;
    replay->is_same_image = replay->recorded.landing.image_crc ==
                            replay->replayed.landing.image_crc;
    options.is_exact = replay->is_exact_required || replay->is_same_image;
    options.shift_blocks = replay->input.shift_blocks;
    diff_messages(&replay->recorded, &replay->replayed, &options, &replay->diff);
    return MR_OK;
}

static void add_replay(const struct replay *replay, struct answer *answer)
{
    const struct replay_input *input = &replay->input;
    unsigned recorded = (unsigned)replay->recorded.landing.image_crc,
             replayed = (unsigned)replay->replayed.landing.image_crc;
    answer_add_text(answer, "db", NULL, "%s", replay->db);
    answer_add_count(answer, "run", "RUN", replay->run);
    answer_add_count(answer, NULL, "landing", replay->recorded.landing.board_landing);
    answer_add_count(answer, "first_block", "first block", input->first_block);
    answer_add_count(answer, "last_block", "last block", input->last_block);
    answer_add_count(answer, "edges", "edges", (int64_t)input->edge_count);
    answer_add_count(answer, "commands", "commands", (int64_t)input->command_count);
    answer_add_count(answer, "segments_surveyed", "surveyed", (int64_t)input->survey_segment_count)
        ->suffix = " segments";
    answer_add_text(answer, "image", NULL, "%08x", replayed);
    answer_add_text(answer, "recorded_image", NULL, "%08x", recorded);
    if (replay->is_same_image)
        answer_add_text(answer, NULL, "image", "CRC %08x, the image that recorded the landing",
                        replayed);
    else
        answer_add_text(
            answer, NULL, "image",
            "CRC %08x (firmware %s); the landing was recorded by CRC %08x (firmware %s)", replayed,
            replay->replayed.landing.firmware, recorded, replay->recorded.landing.firmware);
    if (replay->recorded.landing.config_crc != replay->replayed.landing.config_crc)
        answer_add_text(answer, NULL, "configuration",
                        "recorded with CRC %08x, replayed with CRC %08x: the database does not "
                        "contain the recorded configuration",
                        (unsigned)replay->recorded.landing.config_crc,
                        (unsigned)replay->replayed.landing.config_crc);
    answer_add_count(answer, "zeros", input->measured_zero_count ? "zeros" : NULL,
                     (int64_t)input->measured_zero_count)
        ->suffix = " measured before the landing and loaded for the replay";
    answer_add_flag(answer, "runway", NULL, input->has_runway);
    answer_add_text(answer, NULL, "runway", "%s",
                    input->has_runway
                        ? "the runway at the arming of the landing was loaded for the replay"
                        : "the recorded runway is incomplete: the replay starts with an unmeasured "
                          "runway, so warnings may differ");
    answer_add_count(answer, "shift_blocks", NULL, input->shift_blocks);
    if (input->shift_blocks)
        answer_add_text(answer, NULL, "moved",
                        "times differ by %lld s: block %lld of the record corresponds to block "
                        "%lld of the replay",
                        (long long)(-input->shift_blocks / 1000), (long long)input->armed_block,
                        (long long)(input->armed_block - input->shift_blocks));
    diff_to_answer(&replay->diff, answer);
}

static enum mr_status parse_request(struct replay *replay, int argc, char **argv,
                                    const struct cli *cli, struct error *error)
{
    const char *words[2];
    enum mr_status status = command_parse(&command_replay, argc, argv, cli, replay, words, error);
    replay->run = 1;
    if (status == MR_OK && words[1])
        status = parse_run(words[1], &replay->run, error);
    replay->db = words[0];
    replay->board.is_real_time = replay->speed && strcmp(replay->speed, "real") == 0;
    return status;
}

static int replay_command(int argc, char **argv, const struct cli *cli)
{
    struct replay *replay = xcalloc(1, sizeof *replay);
    struct error error = {0};
    struct store *store = NULL;
    enum mr_status status = parse_request(replay, argc, argv, cli, &error);
    set_default_paths(replay);
    if (status == MR_OK)
        status = store_open(replay->db, STORE_READ, &store, &error)
                   ?: store_find_run(store, &replay->run, &error);
    if (status == MR_OK)
        status = replay_run(replay, store, cli, &error);
    store_close(store);
    remove_directory(replay);
    struct answer *answer = answer_new(cli->si);
    if (status == MR_OK)
        add_replay(replay, answer);
    int exit_code = answer_print_or_fail(
        cli, answer, replay->diff.differing_fields ? mr_status_exit_code(MR_LIMIT) : 0, &error);
    board_messages_free(&replay->recorded);
    board_messages_free(&replay->replayed);
    free(replay);
    return exit_code;
}

#define OPTION_VALUES struct replay
static const struct command_part parts[] = {
    HELP_ITEM("DB [RUN]", "campaign database and landing; default: RUN 1. If DB is a bundle, its "
                          "digests are checked and its image is used"),
    OPTION_CHOICE("--speed", "S", speed, "speed", "max|real",
                  "max, or real (real time); default: max"),
    OPTION_TEXT("--elf", "F", board.elf_path,
                "firmware image; default: that of the bundle, or the one installed with matrig"),
    OPTION_FLAG("--exact", is_exact_required,
                "require equal fields even when a different image recorded the landing; default: "
                "tolerances, which the output lists"),
    HELP_NOTE("Exit 1 when a field differs."),
    HELP_EXAMPLE("matrig replay landing5.db"),
};

const struct command command_replay = {
    "replay",
    replay_command,
    "DB [RUN] [--speed max|real] [--elf F] [--exact]",
    "re-run a recorded landing through the firmware and check that the output is identical",
    COMMAND_PARTS(parts),
    {1, 2, "DB [RUN]"},
};
