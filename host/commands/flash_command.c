/* matrig flash: programs a board through its chip's boot ROM, and sees to it that it runs what the
 * file holds. */
#include <poll.h>
#include <stdio.h>
#include <string.h>

#include "common/boards.h"
#include "common/command.h"
#include "host/base/answer.h"
#include "host/board/dialogue.h"
#include "host/commands/commands.h"
#include "host/flash/flash.h"
#include "host/link/diagnose.h"
#include "host/link/tty.h"
#include "host/base/steady.h"

#define BAUD_LEAST    9600.0
#define BAUD_MOST     460800.0
#define HELLO_S       2.5 /* it comes once a second */
#define HELLO_ASKED_S 6.0
#define ORDER_S       3.0
#define BOARD_S       1.0 /* told right behind it; an old one says it a second later */
#define RESTART_MS    200 /* 50 until it leaves, and what a reset takes */
#define BAR           40u

struct session {
    const struct cli *cli;
    const char *spec;
    bool enter, boot0, all, force, stay, erase_configuration;
    int64_t baud;
    int firmware_baud;
    struct imagefile image;
    /* with the firmware; of its link too while the boot ROM is spoken with */
    struct dialogue dialogue;
    uint8_t received[4096]; /* from the link and not yet given on */
    size_t start, end;
    struct bootrom rom;
    struct flash_result result;
    bool entered, same, runs;
    bool drawn;
    bool begun[3];            /* of each phase, where lines stand in place of a bar, */
    unsigned told_quarter[3]; /* and the quarter that the lines came to */
};

/* ---- the line to the boot ROM is a link ---- */

static enum mr_status line_send(void *context, const uint8_t *bytes, size_t count,
                                struct error *error)
{
    struct session *session = context;
    return link_send_bytes(dialogue_link(&session->dialogue), bytes, count, error);
}

static enum mr_status line_receive(void *context, uint8_t *byte, unsigned timeout_ms,
                                   struct error *error)
{
    struct session *session = context;
    struct link *link = dialogue_link(&session->dialogue);
    uint64_t host_us, until_us = steady_us() + 1000u * timeout_ms;
    while (session->start == session->end) {
        enum mr_status status = link_receive_bytes(
            link, session->received, sizeof session->received, &session->end, &host_us, error);
        session->start = 0;
        if (status == MR_OK)
            break;
        session->end = 0;
        if (status == MR_CLOSED)
            return error_set(error, MR_CLOSED,
                             "the link ended: %s; run it again: it goes on where it was",
                             session->spec);
        if (status != MR_TOO_FEW)
            return status;
        if (link_fd(link) < 0)
            return error_set(
                error, MR_IO,
                "the device went away: %s; plug it in and run it again: it goes on where it was",
                session->spec);
        uint64_t now = steady_us();
        if (now >= until_us)
            return MR_TIMEOUT;
        struct pollfd ready = {.fd = link_fd(link), .events = POLLIN};
        (void)poll(&ready, 1, (int)((until_us - now) / 1000u) + 1);
    }
    *byte = session->received[session->start++];
    return MR_OK;
}

static const char *const phases[] = {"comparing", "writing", "reading back"};

/* Where no bar can be drawn: a line when a phase begins, and one for each quarter of it. */
static void tell(struct session *session, enum flash_phase phase, unsigned done, unsigned of)
{
    unsigned quarter = of ? 4u * done / of : 4u;
    /* the last page is written and read back after all others: phases come again */
    bool begins = !session->begun[phase];
    if (!begins && quarter <= session->told_quarter[phase])
        return;
    if (begins)
        cli_note(session->cli, "flash: %s %u pages", phases[phase], of);
    if (quarter > 0 && (!begins || quarter == 4))
        cli_note(session->cli, "flash: %s, %u of %u pages", phases[phase], done, of);
    session->begun[phase] = true;
    session->told_quarter[phase] = quarter;
}

static void show(void *context, enum flash_phase phase, unsigned done, unsigned of)
{
    struct session *session = context;
    char bar[BAR + 1];
    if (!cli_terminal())
        tell(session, phase, done, of);
    if (session->cli->quiet || !cli_terminal())
        return;
    unsigned filled = of ? done * BAR / of : BAR;
    memset(bar, '.', BAR);
    memset(bar, '#', filled < BAR ? filled : BAR);
    bar[BAR] = '\0';
    fprintf(stderr, "\rmatrig: flash: %-12s [%s] %u of %u pages\033[K", phases[phase], bar, done,
            of);
    session->drawn = true;
}

static void clear_bar(struct session *session)
{
    if (session->drawn)
        fputs("\r\033[K", stderr);
    session->drawn = false;
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
    session->entered = status == MR_OK;
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
    enum mr_status status = hear_firmware(session, session->enter ? HELLO_ASKED_S : HELLO_S, error);
    if (status == MR_TIMEOUT) {
        if (session->enter)
            return error_set(error, MR_TIMEOUT,
                             LINK_NO_HELLO
                             ": %s; is it running? Else start it with BOOT0 high and give --boot0",
                             session->spec);
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
    if (session->same && !session->force && !session->all)
        return MR_OK;
    if (!session->same && session->image.stamped)
        cli_note(session->cli, "flash: %s", why);
    return order_into_rom(session, error);
}

/* ---- out of it ---- */

static enum mr_status start_and_compare(struct session *session, struct error *error)
{
    char why[200];
    enum mr_status status = bootrom_go(&session->rom, MR_IMAGE_FLASH, error);
    if (status == MR_OK)
        status = link_line(dialogue_link(&session->dialogue), session->firmware_baud, false, error);
    if (status != MR_OK)
        return status;
    status = hear_firmware(session, HELLO_ASKED_S, error);
    if (status == MR_TIMEOUT)
        return error_set(error, MR_TIMEOUT,
                         "flashed and read back, but no board says hello: %s; take BOOT0 off and "
                         "reset the board",
                         session->spec);
    if (status != MR_OK || !session->image.stamped)
        return status;
    if (!identity_runs(&session->dialogue.identity, &session->image.header, why, sizeof why))
        return error_set(error, MR_LIMIT, "the board does not run what was flashed: %s; %s",
                         session->spec, why);
    session->runs = true;
    return MR_OK;
}

static enum mr_status program(struct session *session, struct error *error)
{
    const struct bootrom_line line = {session, session->spec, line_send, line_receive};
    const struct flash_options options = {session->all, session->erase_configuration, show,
                                          session};
    if (session->entered) /* what it still says is not for the boot ROM's client */
        (void)poll(NULL, 0, RESTART_MS);
    enum mr_status status = link_line(dialogue_link(&session->dialogue), (int)session->baud, true,
                                      error);
    if (status == MR_OK)
        status = bootrom_begin(&session->rom, &line, error);
    if (status == MR_OK)
        status = flash_run(&session->rom, &session->image, &options, &session->result, error);
    clear_bar(session);
    return status == MR_OK && !session->stay ? start_and_compare(session, error) : status;
}

/* ---- the result ---- */

static void sectors_text(unsigned sectors, char *text, size_t size)
{
    size_t used = 0;
    snprintf(text, size, "none");
    for (unsigned i = 0; i < SECTORS; i++) {
        if (sectors >> i & 1u)
            used += (size_t)snprintf(text + used, size - used, "%s%u", used ? ", " : "", i);
    }
}

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

static void erased_answer(const struct session *session, struct answer *answer)
{
    char erased[60];
    answer_list(answer, "erased", NULL);
    for (unsigned i = 0; i < SECTORS; i++) {
        if (session->result.erased >> i & 1u)
            answer_count(answer, NULL, NULL, i);
    }
    answer_close(answer);
    sectors_text(session->result.erased, erased, sizeof erased);
    if (!session->same || session->result.pages)
        answer_words(answer, NULL, "erased", "sectors %s; configuration %s", erased,
                     session->erase_configuration ? "erased" : "kept");
}

static void result_answer(const struct session *session, struct answer *answer)
{
    const struct flash_result *result = &session->result;
    bool already = session->same && !result->pages;
    image_answer(&session->image, answer);
    if (!already)
        answer_words(answer, NULL, "chip", "id 0x%03x, boot ROM %u.%u", session->rom.chip,
                     session->rom.version >> 4, session->rom.version & 15u);
    erased_answer(session, answer);
    answer_count(answer, "pages", already ? NULL : "pages", result->pages);
    answer_count(answer, "written", already ? NULL : "written", result->written)->end =
        result->resumed ? ", resumed" : NULL;
    answer_count(answer, "kept", already ? NULL : "were there", result->kept);
    answer_flag(answer, "resumed", NULL, result->resumed);
    answer_count(answer, "verified_bytes", already ? NULL : "read back", result->verified)->end =
        " bytes, all as in the file";
    answer_count(answer, "repeated", already ? NULL : "repeated", session->rom.repeated)->end =
        " exchanges";
    answer_count(answer, "read_twice", already ? NULL : "read twice", result->reread)->end =
        " pages";
    answer_flag(answer, "already", NULL, already);
    answer_flag(answer, "runs", NULL, session->runs || already);
    answer_words(answer, NULL, "board", "%s",
                 already         ? "runs it already; --force flashes it again"
                 : session->runs ? "runs it"
                 : session->stay ? "left in its boot ROM"
                                 : "started");
}

static int flash(struct session *session, struct error *error)
{
    enum mr_status status = dialogue_open(&session->dialogue, NULL, session->spec, error);
    session->dialogue.any_layout = true;
    if (status == MR_OK)
        status = meet_firmware(session, error);
    bool nothing_to_do = session->same && !session->force && !session->all;
    if (status == MR_OK && !nothing_to_do)
        status = program(session, error);
    dialogue_close(&session->dialogue);
    if (status != MR_OK)
        return cli_fail(error);
    struct answer *answer = answer_new(session->cli->si);
    result_answer(session, answer);
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
    session->rom.wanted = board->chip;
    return MR_OK;
}

static int flash_command(int argc, char **argv, const struct cli *cli)
{
    static struct session session;
    const char *words[2];
    struct error error = {0};
    char path[TTY_PATH_MAX];
    static char spec[LINK_SPEC_MAX];
    session.cli = cli;
    enum mr_status status = command_parse(&command_flash, argc, argv, cli, &session, words, &error);
    if (status == MR_OK)
        status = link_complete(words[0], LINK_SERIAL, spec, &error);
    session.spec = spec;
    if (status == MR_OK && session.enter && session.boot0)
        status = error_set(
            &error, MR_USAGE,
            "--enter and --boot0 together: the firmware runs, or the boot ROM does; give one");
    session.firmware_baud = TTY_BAUD_DEFAULT;
    if (status == MR_OK && strncmp(session.spec, "serial:", 7) == 0)
        status = tty_parse(session.spec + 7, "serial:TTY[:BAUD]", path, &session.firmware_baud,
                           &error);
    if (status == MR_OK && session.firmware_baud == TTY_BAUD_FIND)
        status = error_set(
            &error, MR_USAGE,
            "the rate is not looked for while a board is flashed: %s; write serial:TTY[:BAUD]",
            session.spec);
    if (status == MR_OK && session.baud > BOOTROM_BAUD && strncmp(session.spec, "serial:", 7) == 0)
        status = error_set(&error, MR_USAGE,
                           "--baud %lld: the chip's boot ROM promises %d baud at most (AN3155); "
                           "faster is for the emulated board, pty:",
                           (long long)session.baud, BOOTROM_BAUD);
    if (status == MR_OK && strncmp(session.spec, "file:", 5) == 0)
        status = error_set(&error, MR_USAGE, "a file is no board: %s; give serial:TTY",
                           session.spec);
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
                      "own rate is for the firmware;\n"
                      "the boot ROM is spoken to with 8E1 at --baud. A port that does not do "
                      "2000000 baud: serial:TTY:115200,\n"
                      "with --boot0 --stay"),
    HELP_ITEM("IMAGE", ".elf, .hex or .bin of the firmware"),
    OPTION_FLAG(
        "--enter", enter,
        "the firmware runs: ask it to restart into the boot ROM (refused from arm to done)"),
    OPTION_FLAG("--boot0", boot0,
                "the boot ROM runs already, started with BOOT0 high. Without either: --enter when "
                "a board says hello\n"
                "within 2.5 s, else --boot0"),
    OPTION_WHOLE("--baud", "N", baud, BAUD_LEAST, BAUD_MOST, BOOTROM_BAUD,
                 "{low} to {high} for the boot ROM, else {standard}; more than that on pty: alone"),
    OPTION_FLAG("--all", all, "erase and write also what is there already"),
    OPTION_FLAG("--force", force,
                "flash although the board runs this image, says that it is another board, or the "
                "image carries "
                "no header"),
    OPTION_FLAG("--stay", stay, "do not start the firmware afterwards"),
    OPTION_FLAG("--erase-configuration", erase_configuration,
                "erase sectors 2 and 3 too; else they are never touched"),
    HELP_NOTE("Only sectors that differ are erased. Every byte is read back. After a pulled cable "
              "the same command goes on where it was;\n"
              "until it is done the board starts into the boot ROM. Exit 1 when the board does not "
              "run what was flashed."),
    HELP_EXAMPLE("matrig flash serial:/dev/ttyUSB0 build/firmware/matrig.elf"),
};

const struct command command_flash = {
    "flash",
    flash_command,
    "LINK IMAGE [--enter | --boot0] [--baud N] [--all] [--force] [--stay] [--erase-configuration]",
    "program a board through its chip's boot ROM",
    COMMAND_PARTS(parts),
    {2, 2, "LINK IMAGE"},
};
