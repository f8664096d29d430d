/* matrig flash: asks a board into its chip's boot ROM, has stm32flash program it, and checks that
 * it runs the image. */
#include <limits.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/image.h"
#include "common/command.h"
#include "host/base/answer.h"
#include "host/board/dialogue.h"
#include "host/commands/commands.h"
#include "host/board/stm32flash.h"
#include "host/link/link.h"
#include "host/link/tty.h"

#define BAUD_LEAST    9600.0
#define BAUD_MOST     460800.0
#define HELLO_S       2.5 /* it comes once a second */
#define HELLO_ASKED_S 6.0
#define ORDER_S       3.0
#define BOARD_S       1.0 /* told right behind it; an old one says it a second later */
#define RESTART_MS    200 /* 50 until it leaves, and what a reset takes */

struct session {
    const struct cli *cli;
    const char *spec;
    bool boot0, force;
    int64_t baud;
    struct imagefile image;
    unsigned chip; /* that the image is for */
    struct dialogue dialogue;
    bool same, runs;
    bool drawn;
};

static void show(void *context, const char *part, double percent)
{
    struct session *session = context;
    fprintf(stderr, "\rmatrig: flash: %s %.0f %%\033[K", part, percent);
    session->drawn = true;
}

/* ---- into the boot ROM ---- */

static enum mr_status order_into_rom(struct session *session, struct error *error)
{
    struct mr_ack ack;
    const struct dialogue_order order = {.code = MR_COMMAND_BOOTROM, .answer_s = ORDER_S};
    enum mr_status status = dialogue_order(&session->dialogue, &order, &ack, error);
    enum mr_status answer = (enum mr_status)ack.status;
    if (status == MR_TIMEOUT)
        return dialogue_lost(&session->dialogue, MR_COMMAND_BOOTROM, error);
    if (status == MR_OK && answer == MR_NOT_NOW)
        return error_set(
            error, MR_NOT_NOW,
            "the board does not leave a landing (it is %s): %s; wait for its end or disarm it",
            mr_landing_state_text(session->dialogue.identity.hello.state), session->spec);
    if (status == MR_OK && answer == MR_WAIT)
        return error_set(error, MR_WAIT,
                         "the black box still writes the last landing: %s; try again in a second",
                         session->spec);
    if (status == MR_OK && answer == MR_UNKNOWN)
        return error_set(error, MR_UNKNOWN,
                         "the boot ROM of this board does not listen at its serial link: %s; "
                         "program it through its ST-LINK (docs/howto/flash.md)",
                         session->spec);
    if (status == MR_OK && answer != MR_OK)
        return error_set(
            error, answer,
            "the board refuses `bootrom` (%s): %s; start it with BOOT0 high and give --boot0",
            mr_status_text(answer), session->spec);
    if (status == MR_OK)
        (void)poll(NULL, 0, RESTART_MS);
    return status;
}

/* Who runs. MR_TIMEOUT, `error` as it was: nobody says. */
static enum mr_status hear_firmware(struct session *session, double within_s, struct error *error)
{
    dialogue_forget(&session->dialogue);
    enum mr_status status = dialogue_who(&session->dialogue, within_s, error);
    if (status == MR_TIMEOUT && link_fd(dialogue_link(&session->dialogue)) < 0)
        return error_set(error, MR_IO, "the device went away: %s; plug it in again", session->spec);
    return status;
}

static const char *name_of(unsigned board)
{
    const struct mr_board *known = mr_board_of(board);
    return known ? known->name : "one that this matrig does not know";
}

/* The board that runs says which it is; an image for another has other pins. */
static enum mr_status check_board(struct session *session, struct error *error)
{
    struct identity *identity = &session->dialogue.identity;
    if (!session->image.stamped || session->force)
        return MR_OK;
    enum mr_status status = dialogue_until(&session->dialogue, dialogue_flag,
                                           &identity->board_known, BOARD_S, error);
    if (status == MR_TIMEOUT || (status == MR_OK && identity->board == session->image.header.board))
        return MR_OK;
    if (status != MR_OK)
        return status;
    return error_set(error, MR_VERSION,
                     "the board is %s, and the image is for %s: %s; give the image of that board, "
                     "or --force",
                     name_of(identity->board), name_of(session->image.header.board), session->spec);
}

/* The firmware that runs, if any, is asked who it is and to give way. */
static enum mr_status meet_firmware(struct session *session, struct error *error)
{
    char why[200];
    if (session->boot0)
        return MR_OK;
    enum mr_status status = hear_firmware(session, HELLO_S, error);
    if (status == MR_TIMEOUT) {
        cli_note(session->cli,
                 "flash: " LINK_NO_HELLO "; expecting the boot ROM, started with BOOT0 high");
        return MR_OK;
    }
    if (status == MR_OK)
        status = check_board(session, error);
    if (status != MR_OK)
        return status;
    session->same = session->image.stamped &&
                    identity_runs(&session->dialogue.identity, &session->image.header, why,
                                  sizeof why);
    if (session->same && !session->force)
        return MR_OK;
    if (!session->same && session->image.stamped)
        cli_note(session->cli, "flash: %s", why);
    return order_into_rom(session, error);
}

/* ---- out of it ---- */

static enum mr_status compare(struct session *session, struct error *error)
{
    char why[200];
    enum mr_status status = hear_firmware(session, HELLO_ASKED_S, error);
    if (status == MR_TIMEOUT)
        return error_set(error, MR_TIMEOUT,
                         "flashed and read back, but no board says hello: %s; take BOOT0 off and "
                         "reset the board",
                         session->spec);
    if (status != MR_OK)
        return status;
    if (!identity_runs(&session->dialogue.identity, &session->image.header, why, sizeof why))
        return error_set(error, MR_LIMIT, "the board does not run what was flashed: %s; %s",
                         session->spec, why);
    session->runs = true;
    return MR_OK;
}

/* The port's path, which stm32flash opens itself. */
static enum mr_status take_port(const struct session *session, char path[TTY_PATH_MAX],
                                struct error *error)
{
    int baud;
    if (strncmp(session->spec, "serial:", 7) == 0)
        return tty_parse(session->spec + 7, "serial:TTY[:BAUD]", path, &baud, error);
    if (strncmp(session->spec, "pty:", 4) != 0)
        return error_set(error, MR_USAGE,
                         "stm32flash needs a serial port: %s; give serial:TTY, or pty:PATH of an "
                         "emulated board",
                         session->spec);
    snprintf(path, TTY_PATH_MAX, "%s", session->spec + 4);
    return MR_OK;
}

static enum mr_status program(struct session *session, const char *tty, struct error *error)
{
    char real[PATH_MAX];
    const struct stm32flash to = {
        .tty = tty,
        .spec = session->spec,
        .baud = (int)session->baud,
        .pts = realpath(tty, real) && strncmp(real, "/dev/pts/", 9) == 0,
        .progress = cli_terminal() && !session->cli->quiet ? show : NULL,
        .context = session,
    };
    unsigned chip = 0;
    enum mr_status status = stm32flash_chip(&to, &chip, error);
    if (status == MR_OK && chip != session->chip)
        status = error_set(
            error, MR_VERSION,
            "another chip: id 0x%03x, and the image is for one with 0x%03x: %s; is it the right "
            "board, and the image of that board?",
            chip, session->chip, session->spec);
    if (status == MR_OK)
        status = stm32flash_program(&to, &session->image, error);
    if (session->drawn)
        fputs("\r\033[K", stderr);
    return status;
}

/* ---- the result ---- */

/* What the file says of itself; null without its header. */
static void image_answer(const struct imagefile *image, struct answer *answer)
{
    const struct mr_image *header = &image->header;
    char commit[MR_IMAGE_COMMIT_TEXT] = "";
    answer_words(answer, "image", "image", "%s", image->path);
    if (!image->stamped) {
        answer_none(answer, "version", "version", "no header");
        answer_none(answer, "commit", NULL, NULL);
        answer_none(answer, "program_crc", NULL, NULL);
        answer_none(answer, "for_board", NULL, NULL);
        return;
    }
    mr_image_commit_text(header->commit, header->commit_more, header->changed, commit);
    answer_words(answer, "version", "version", "%u.%u.%u", header->major, header->minor,
                 header->patch);
    answer_words(answer, "commit", "commit", "%s", commit);
    answer_words(answer, "program_crc", "program", "%08x", (unsigned)header->program_crc);
    answer_words(answer, "for_board", "for board", "%s", name_of(header->board));
}

static void result_answer(const struct session *session, bool already, struct answer *answer)
{
    image_answer(&session->image, answer);
    answer_count(answer, "verified_bytes", already ? NULL : "read back",
                 already ? 0 : session->image.count)
        ->end = " bytes, all as in the file";
    answer_flag(answer, "already", NULL, already);
    answer_flag(answer, "runs", NULL, session->runs || already);
    answer_words(answer, NULL, "board", "%s",
                 already         ? "runs it already; --force flashes it again"
                 : session->runs ? "runs it"
                                 : "started");
}

/* With the firmware, with the boot ROM, and with the firmware again: one program has the port. */
static int flash(struct session *session, struct error *error)
{
    char tty[TTY_PATH_MAX];
    enum mr_status status = take_port(session, tty, error);
    if (status == MR_OK)
        status = dialogue_open(&session->dialogue, NULL, session->spec, error);
    session->dialogue.any_layout = true;
    if (status == MR_OK)
        status = meet_firmware(session, error);
    dialogue_close(&session->dialogue);
    bool already = session->same && !session->force;
    if (status == MR_OK && !already)
        status = program(session, tty, error);
    if (status == MR_OK && !already && session->image.stamped) {
        status = dialogue_open(&session->dialogue, NULL, session->spec, error);
        session->dialogue.any_layout = true;
        if (status == MR_OK)
            status = compare(session, error);
        dialogue_close(&session->dialogue);
    }
    if (status != MR_OK)
        return cli_fail(error);
    struct answer *answer = answer_new(session->cli->si);
    result_answer(session, already, answer);
    return answer_show(session->cli, answer, 0);
}

/* Which chip the image is for. */
static enum mr_status take_board(struct session *session, struct error *error)
{
    const struct mr_board *board = mr_board_of(session->image.header.board);
    if (!board)
        return error_set(error, MR_VERSION,
                         "an image for board %u, which this matrig does not know: %s; use the "
                         "matrig that came with it",
                         session->image.header.board, session->image.path);
    session->chip = board->chip;
    return MR_OK;
}

static int flash_command(int argc, char **argv, const struct cli *cli)
{
    static struct session session;
    const char *words[2];
    struct error error = {0};
    session.cli = cli;
    session.chip = mr_board_of(MR_BOARD_ZG)->chip;
    enum mr_status status = command_parse(&command_flash, argc, argv, cli, &session, words, &error);
    if (status == MR_OK)
        status = link_check(words[0], &error);
    session.spec = words[0];
    if (status == MR_OK)
        status = imagefile_read(words[1], &session.image, &error);
    if (status == MR_OK && !session.image.stamped && !session.force)
        status = error_set(&error, MR_UNKNOWN,
                           "an image without matrig's header: %s; --force flashes it all the same",
                           words[1]);
    if (status == MR_OK && session.image.stamped)
        status = take_board(&session, &error);
    int exit_code = status == MR_OK ? flash(&session, &error) : cli_fail(&error);
    if (session.image.bytes)
        imagefile_free(&session.image);
    return exit_code;
}

#define VALUES struct session
static const struct command_part parts[] = {
    HELP_ITEM("LINK", "the board's serial port: serial:TTY, or pty:PATH of an emulated board. Its "
                      "own rate is for the firmware"),
    HELP_ITEM("IMAGE", ".elf, .hex or .bin of the firmware"),
    OPTION_FLAG("--boot0", boot0,
                "the boot ROM runs already, started with BOOT0 high. Without it a board that says "
                "hello within 2.5 s\n"
                "restarts into its boot ROM (refused from arm to done)"),
    OPTION_WHOLE("--baud", "N", baud, BAUD_LEAST, BAUD_MOST, STM32FLASH_BAUD,
                 "{low} to {high} for the boot ROM, else {standard}; a chip promises {standard} at "
                 "most"),
    OPTION_FLAG("--force", force,
                "flash although the board runs this image, says that it is another board, or the "
                "image carries "
                "no header"),
    HELP_NOTE("Runs stm32flash. The configuration is kept, every byte is read back. After a pulled "
              "cable switch the board off and on and run it\n"
              "again: it starts into its boot ROM until the image is whole. Exit 1 when the board "
              "does not run what was flashed."),
    HELP_EXAMPLE("matrig flash serial:/dev/ttyUSB0 build/firmware/matrig.elf"),
};

const struct command command_flash = {
    "flash",
    flash_command,
    "LINK IMAGE [--boot0] [--baud N] [--force]",
    "program a board through its chip's boot ROM",
    COMMAND_PARTS(parts),
    {2, 2, "LINK IMAGE"},
};
