/* The command matrig flash: restarts a board into the boot ROM of its chip, programs the board with
 * stm32flash, and checks that it runs the image. */
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/image.h"
#include "common/command.h"
#include "host/base/answer.h"
#include "host/base/process.h"
#include "host/board/dialogue.h"
#include "host/commands/commands.h"
#include "host/board/imagefile.h"
#include "host/link/link.h"
#include "host/link/tty.h"

#define BAUD_MIN                    9600.0
#define BAUD_MAX                    460800.0
#define HELLO_TIMEOUT_S             2.5 /* wait for a hello, s; the board sends one once a second */
#define HELLO_AFTER_RESET_TIMEOUT_S 6.0
#define COMMAND_TIMEOUT_S           3.0
/* Wait for the board type, s; the board sends it after the hello, older firmware 1 s later. */
#define BOARD_TYPE_TIMEOUT_S        1.0
/* the board resets 50 ms after the command; the rest is the duration of the reset */
#define RESTART_MS                  200
#define ROM_BAUD                    115200 /* highest rate that AN3155 guarantees, baud */
#define CHIP_READ_TRIES_MAX         3u
#define PROGRAM_OUTPUT_SIZE         2048u
#define WORDS_MAX                   16u
#define EXIT_PROGRAM_NOT_FOUND      127 /* exit code of a program that is not found */

struct session {
    const struct cli *cli;
    const char *spec;
    const char *tty; /* path of the port, which stm32flash opens */
    bool is_pts;     /* the port is a pseudo-terminal, which does not support parity */
    bool force;
    int64_t baud;
    struct imagefile image;
    unsigned chip; /* id of the chip for which the image is built */
    struct dialogue *dialogue;
    bool is_same_image, is_firmware_running;
};

/* ---- stm32flash ---- */

/* Programs a board in its chip's boot ROM with stm32flash (Debian's package), which uses the
 * protocol of AN3155.
 *
 * The image is written in parts. First, a few instructions that start the boot ROM are written to
 * sector 0, then the program, and last vectors and header. If power or cable fail in between, the
 * board starts the boot ROM, and the user can flash it again. stm32flash verifies each part and
 * erases only the sectors of that part, so the configuration is kept. */

/* Vectors and code for sector 0 while the program is incomplete: they make every reset start the
 * boot ROM, with stack pointer and entry from 0x1FFF0000 (AN2606), as in firmware/f407/board.c.
 *
 *     ldr r0, =0x1fff0000;  ldr r1, [r0];  msr msp, r1;  ldr r1, [r0, #4];  bx r1 */
static const uint8_t boot_rom_instructions[24] = {
    0x00, 0x20, 0x00, 0x20, 0x09, 0x00, 0x00, 0x08, 0x02, 0x48, 0x01, 0x68,
    0x81, 0xf3, 0x08, 0x88, 0x41, 0x68, 0x08, 0x47, 0x00, 0x00, 0xff, 0x1f,
};

struct image_part {
    const char *name;
    uint32_t address; /* offset from MR_FLASH, bytes */
    const uint8_t *bytes;
    size_t count;
    bool is_program_started; /* start the program afterwards */
};

/* Shows the progress: the newest percentage, such as `(42.00%)`, in the output of stm32flash. */
static void show_output(const struct session *to, const char *part, const char *output)
{
    const char *percent = strrchr(output, '(');
    char *end;
    double value = percent ? strtod(percent + 1, &end) : 0;
    if (cli_is_stderr_terminal() && !to->cli->quiet && percent && *end == '%')
        fprintf(stderr, "\rmatrig: flash: %s %.0f %%\033[K", part, value);
}

/* Reads the output of stm32flash until stm32flash ends. If the output is too long, keeps its
 * end. */
static void read_output(const struct session *to, int fd, const char *part,
                        char output[PROGRAM_OUTPUT_SIZE])
{
    size_t length = 0;
    ssize_t count;
    for (;;) {
        if (length == PROGRAM_OUTPUT_SIZE - 1) {
            memmove(output, output + PROGRAM_OUTPUT_SIZE / 2, length -= PROGRAM_OUTPUT_SIZE / 2);
            output[length] = '\0';
        }
        if ((count = read(fd, output + length, PROGRAM_OUTPUT_SIZE - 1 - length)) <= 0)
            return;
        output[length += (size_t)count] = '\0';
        show_output(to, part, output);
    }
}

static void copy_last_line(char *output, char line[120])
{
    size_t end = strlen(output);
    while (end > 0 && strchr("\r\n ", output[end - 1]))
        output[--end] = '\0';
    size_t start = end;
    while (start > 0 && !strchr("\r\n", output[start - 1]))
        start--;
    snprintf(line, 120, "%s", output + start);
}

/* Runs stm32flash with the arguments `words`. MR_LIMIT: stm32flash failed; `output` has its output
 * and `error` is not set. */
static enum mr_status run_program(const struct session *to, const char *const words[],
                                  const char *part, char output[PROGRAM_OUTPUT_SIZE],
                                  struct error *error)
{
    char baud[12];
    const char *all[WORDS_MAX] = {"stm32flash", "-m", to->is_pts ? "8n1" : "8e1", "-b", baud};
    size_t n = 5;
    int ends[2], status = 0;
    pid_t child;
    snprintf(baud, sizeof baud, "%d", (int)to->baud);
    while (*words && n < WORDS_MAX - 2)
        all[n++] = *words++;
    all[n] = to->tty;
    output[0] = '\0';
    if (pipe2(ends, O_CLOEXEC) != 0)
        return error_set(error, MR_IO, "cannot create a pipe to stm32flash; close other programs");
    if (process_start(all, (const int[]){-1, ends[1], ends[1]}, &child, error) == MR_OK) {
        close(ends[1]);
        read_output(to, ends[0], part, output);
        waitpid(child, &status, 0);
    } else {
        close(ends[1]);
    }
    close(ends[0]);
    if (error->status != MR_OK)
        return error->status;
    if (WIFEXITED(status) && WEXITSTATUS(status) == EXIT_PROGRAM_NOT_FOUND)
        return error_set(error, MR_IO,
                         "stm32flash is missing, and matrig needs it to program boards; run "
                         "apt-get install stm32flash");
    return status == 0 ? MR_OK : MR_LIMIT;
}

/* Reads the id of the chip from its boot ROM. MR_TIMEOUT: the boot ROM does not answer. MR_IO:
 * stm32flash is missing. */
static enum mr_status stm32flash_read_chip(const struct session *to, unsigned *chip,
                                           struct error *error)
{
    char output[PROGRAM_OUTPUT_SIZE], why[120];
    /* several tries, because the firmware may still send while it restarts */
    for (unsigned try = 0; try < CHIP_READ_TRIES_MAX; try++) {
        enum mr_status status = run_program(to, (const char *const[]){NULL}, "boot ROM", output,
                                            error);
        const char *id = strstr(output, "Device ID");
        if (status == MR_OK && id && sscanf(id, "Device ID : %x", chip) == 1)
            return MR_OK;
        if (error->status != MR_OK)
            return error->status;
    }
    copy_last_line(output, why);
    return error_set(
        error, MR_TIMEOUT,
        "the boot ROM does not answer (stm32flash: %s): %s; connect to USART1 and start the board "
        "with BOOT0 high; after an interrupted attempt, power-cycle the board first",
        why, to->spec);
}

static enum mr_status write_part(const struct session *to, const char *folder,
                                 const struct image_part *part, struct error *error)
{
    char path[TEMPORARY_FOLDER_SIZE + 40], at[12], output[PROGRAM_OUTPUT_SIZE], why[120];
    const char *words[] = {"-f", "-w", path, "-v", "-S", at, part->is_program_started ? "-g" : NULL,
                           at,   NULL};
    snprintf(path, sizeof path, "%s/part.bin", folder);
    snprintf(at, sizeof at, "0x%08x", (unsigned)(MR_FLASH + part->address));
    FILE *file = fopen(path, "wb");
    bool written = file && fwrite(part->bytes, 1, part->count, file) == part->count;
    if (!file || fclose(file) != 0 || !written)
        return error_set(error, MR_IO, "cannot write: %s; free disk space there, or set TMPDIR",
                         path);
    if (run_program(to, words, part->name, output, error) != MR_LIMIT)
        return error->status;
    copy_last_line(output, why);
    return error_set(error, MR_IO,
                     "stm32flash failed at the %s, %s: %s (%s); power-cycle the board and run the "
                     "command again. stm32flash -u removes write protection; stm32flash -k removes "
                     "read protection and erases everything",
                     part->name, at, to->spec, why);
}

/* Finds the part of the image between offsets `from` and `to`. Returns false if the image has no
 * bytes there. */
static bool find_image_part(const struct imagefile *image, uint32_t from, uint32_t to,
                            struct image_part *part)
{
    while (to > from && !image->is_present[to - 1])
        to--;
    part->address = from;
    part->bytes = image->bytes + from;
    part->count = to - from;
    return to > from;
}

/* Programs and verifies the image and starts it. MR_IO: a step failed. */
static enum mr_status stm32flash_program(const struct session *to, struct error *error)
{
    static const char *const files[] = {"part.bin"};
    const struct imagefile *image = &to->image;
    struct image_part first = {"jump to the boot ROM", 0, boot_rom_instructions,
                               sizeof boot_rom_instructions, false};
    struct image_part program = {.name = "program"},
                      vectors = {.name = "vectors", .is_program_started = true};
    char folder[TEMPORARY_FOLDER_SIZE];
    enum mr_status status = temporary_folder_create(folder, "flash", error);
    if (status == MR_OK &&
        find_image_part(image, IMAGEFILE_CONFIGURATION_END, IMAGEFILE_BYTES, &program)) {
        status = write_part(to, folder, &first, error) ?: write_part(to, folder, &program, error);
    }
    if (status == MR_OK && find_image_part(image, 0, IMAGEFILE_CONFIGURATION_START, &vectors))
        status = write_part(to, folder, &vectors, error);
    temporary_folder_remove(folder, files, 1);
    return status;
}

/* ---- into the boot ROM ---- */

static void enter_boot_rom(struct session *session)
{
    struct mr_ack ack;
    const struct dialogue_command order = {.code = MR_COMMAND_BOOTROM,
                                           .answer_timeout_s = COMMAND_TIMEOUT_S};
    if (dialogue_send_command(session->dialogue, &order, &ack, fatal) == MR_TIMEOUT)
        dialogue_set_no_answer_error(session->dialogue, MR_COMMAND_BOOTROM, fatal);
    enum mr_status answer = (enum mr_status)ack.status;
    if (answer == MR_NOT_NOW)
        error_set(fatal, MR_NOT_NOW,
                  "the board cannot restart during a landing (state: %s): %s; wait for the end of "
                  "the landing or disarm the board",
                  mr_landing_state_text(session->dialogue->identity.hello.state), session->spec);
    if (answer == MR_WAIT)
        error_set(fatal, MR_WAIT,
                  "the black box is still writing the last landing: %s; try again in a second",
                  session->spec);
    if (answer == MR_UNKNOWN)
        error_set(fatal, MR_UNKNOWN,
                  "the boot ROM of this board does not use this serial link: %s; program the board "
                  "through its ST-LINK (docs/howto/flash.md)",
                  session->spec);
    if (answer != MR_OK)
        error_set(fatal, answer,
                  "the board refused `bootrom` (%s): %s; start the board with BOOT0 high",
                  mr_status_text(answer), session->spec);
    (void)poll(NULL, 0, RESTART_MS);
}

/* Waits for a hello of the firmware. Returns false after `within_s` seconds without one. */
static bool wait_for_firmware(struct session *session, double within_s)
{
    dialogue_reset(session->dialogue);
    bool heard = dialogue_wait_for_identity(session->dialogue, within_s, fatal) != MR_TIMEOUT;
    if (!heard && link_fd(dialogue_link(session->dialogue)) < 0)
        error_set(fatal, MR_IO, "the device was disconnected: %s; plug it in again", session->spec);
    return heard;
}

static const char *get_board_name(unsigned board)
{
    const struct mr_board *known = mr_board_by_number(board);
    return known ? known->name : "a board unknown to this matrig";
}

/* Refuses an image that is built for another board, because the pins differ. */
static void check_board(struct session *session)
{
    struct identity *identity = &session->dialogue->identity;
    if (session->image.has_header && !session->force &&
        dialogue_wait_until(session->dialogue, dialogue_is_flag_set, &identity->board_known,
                            BOARD_TYPE_TIMEOUT_S, fatal) == MR_OK &&
        identity->board_type != session->image.header.board)
        error_set(fatal, MR_VERSION,
                  "the board is %s, but the image is for %s: %s; give the image for this board, or "
                  "--force",
                  get_board_name(identity->board_type), get_board_name(session->image.header.board),
                  session->spec);
}

/* Identifies the running firmware, if there is any, and restarts the board into the boot ROM. */
static void identify_firmware(struct session *session)
{
    char why[200];
    if (!wait_for_firmware(session, HELLO_TIMEOUT_S)) {
        cli_note(session->cli,
                 "flash: " LINK_NO_HELLO "; expecting the boot ROM, started with BOOT0 high");
        return;
    }
    check_board(session);
    session->is_same_image = session->image.has_header &&
                             identity_is_running(&session->dialogue->identity,
                                                 &session->image.header, why, sizeof why);
    if (session->is_same_image && !session->force)
        return;
    if (!session->is_same_image && session->image.has_header)
        cli_note(session->cli, "flash: %s", why);
    enter_boot_rom(session);
}

/* ---- back to the firmware ---- */

static void compare_images(struct session *session)
{
    char why[200];
    if (!wait_for_firmware(session, HELLO_AFTER_RESET_TIMEOUT_S))
        error_set(fatal, MR_TIMEOUT,
                  "the image is flashed and verified, but the board does not send a hello: %s; set "
                  "BOOT0 low and reset the board",
                  session->spec);
    session->is_firmware_running = identity_is_running(&session->dialogue->identity,
                                                       &session->image.header, why, sizeof why);
    if (!session->is_firmware_running)
        error_set(fatal, MR_LIMIT, "the board does not run the flashed image: %s; %s",
                  session->spec, why);
}

/* Finds the path of the port. */
static void find_port(const struct session *session, char path[TTY_PATH_SIZE])
{
    int baud;
    if (strncmp(session->spec, "serial:", 7) == 0) {
        tty_parse(session->spec + 7, "serial:TTY[:BAUD]", path, &baud, fatal);
        return;
    }
    if (strncmp(session->spec, "pty:", 4) != 0)
        error_set(fatal, MR_USAGE,
                  "stm32flash needs a serial port: %s; give serial:TTY, or pty:PATH of an "
                  "emulated board",
                  session->spec);
    snprintf(path, TTY_PATH_SIZE, "%s", session->spec + 4);
}

static enum mr_status program_chip(struct session *session, const char *tty, struct error *error)
{
    char real[PATH_MAX];
    session->tty = tty;
    session->is_pts = realpath(tty, real) && strncmp(real, "/dev/pts/", 9) == 0;
    unsigned chip = 0;
    enum mr_status status = stm32flash_read_chip(session, &chip, error);
    if (status == MR_OK && chip != session->chip)
        status = error_set(error, MR_VERSION,
                           "wrong chip: the board has chip id 0x%03x, but the image is for chip id "
                           "0x%03x: %s; check that the image is for this board",
                           chip, session->chip, session->spec);
    if (status == MR_OK)
        status = stm32flash_program(session, error);
    if (cli_is_stderr_terminal() && !session->cli->quiet)
        fputs("\r\033[K", stderr);
    return status;
}

/* ---- the result ---- */

/* Adds the header of the image to the answer; null if the image has none. */
static void add_image(const struct imagefile *image, struct answer *answer)
{
    const struct mr_image *header = &image->header;
    char commit[MR_IMAGE_COMMIT_TEXT] = "";
    answer_add_text(answer, "image", "image", "%s", image->path);
    if (!image->has_header) {
        answer_add_missing_value(answer, "version", "version", "no header");
        answer_add_missing_value(answer, "commit", NULL, NULL);
        answer_add_missing_value(answer, "program_crc", NULL, NULL);
        answer_add_missing_value(answer, "for_board", NULL, NULL);
        return;
    }
    mr_image_commit_text(header->commit, header->commit_more, header->is_modified, commit);
    answer_add_text(answer, "version", "version", "%u.%u.%u", header->major, header->minor,
                    header->patch);
    answer_add_text(answer, "commit", "commit", "%s", commit);
    answer_add_text(answer, "program_crc", "program", "%08x", (unsigned)header->program_crc);
    answer_add_text(answer, "for_board", "for board", "%s", get_board_name(header->board));
}

static void add_result(const struct session *session, bool already, struct answer *answer)
{
    add_image(&session->image, answer);
    answer_add_count(answer, "verified_bytes", already ? NULL : "read back",
                     already ? 0 : session->image.present_count)
        ->suffix = " bytes, identical to the file";
    answer_add_flag(answer, "already", NULL, already);
    answer_add_flag(answer, "runs", NULL, session->is_firmware_running || already);
    answer_add_text(answer, NULL, "board", "%s",
                    already ? "already runs this image; --force flashes the image again"
                    : session->is_firmware_running ? "runs it"
                                                   : "started");
}

/* Programs the board. Closes the dialogue first, because only one program can use the port. */
static int run_flash(struct session *session)
{
    char tty[TTY_PATH_SIZE];
    struct error error = {0};
    find_port(session, tty);
    session->dialogue = dialogue_open_for_command(NULL, session->spec);
    session->dialogue->accepts_any_layout = true;
    identify_firmware(session);
    dialogue_close(session->dialogue);
    bool already = session->is_same_image && !session->force;
    if (!already && program_chip(session, tty, &error) != MR_OK)
        return cli_fail(&error);
    if (!already && session->image.has_header) {
        session->dialogue = dialogue_open_for_command(NULL, session->spec);
        session->dialogue->accepts_any_layout = true;
        compare_images(session);
        dialogue_close(session->dialogue);
    }
    struct answer *answer = answer_new(session->cli->si);
    add_result(session, already, answer);
    return answer_print(session->cli, answer, 0);
}

/* Id of the chip for which the image is built. */
static unsigned find_chip(const struct imagefile *image)
{
    const struct mr_board *board = mr_board_by_number(image->header.board);
    if (!board)
        error_set(fatal, MR_VERSION,
                  "the image is for board %u, which this matrig does not know: %s; use the matrig "
                  "version that belongs to the image",
                  image->header.board, image->path);
    return board->chip;
}

static int flash_command(int argc, char **argv, const struct cli *cli)
{
    static struct session session;
    const char *words[2];
    session.cli = cli;
    command_parse(&command_flash, argc, argv, cli, &session, words, fatal);
    link_check(words[0], fatal);
    session.spec = words[0];
    imagefile_read(words[1], &session.image, fatal);
    if (!session.image.has_header && !session.force)
        error_set(fatal, MR_UNKNOWN,
                  "the image has no matrig header: %s; to flash this image anyway, use --force",
                  words[1]);
    session.chip = session.image.has_header ? find_chip(&session.image)
                                            : mr_board_by_number(MR_BOARD_ZG)->chip;
    int exit_code = run_flash(&session);
    imagefile_free(&session.image);
    return exit_code;
}

#define OPTION_VALUES struct session
static const struct command_part parts[] = {
    HELP_ITEM("LINK", "the board's serial port: serial:TTY, or pty:PATH of an emulated board. A "
                      "baud rate in LINK applies to the firmware, not to the boot ROM"),
    HELP_ITEM("IMAGE", "firmware image, .elf or .bin"),
    OPTION_INTEGER("--baud", "N", baud, BAUD_MIN, BAUD_MAX, ROM_BAUD,
                   "baud rate of the boot ROM, {low} to {high}; default: {standard}, the highest "
                   "rate guaranteed for the chip"),
    OPTION_FLAG("--force", force,
                "flash even if the board already runs this image or is of a different type, or the "
                "image has no header"),
    HELP_NOTE("If the board sends a hello within 2.5 s, the command restarts the board into its "
              "boot ROM. An armed board refuses the restart until the landing has ended. If no "
              "hello is received, restart the board with BOOT0 high. stm32flash programs the chip "
              "and verifies every byte; the configuration is kept. If the cable was pulled, "
              "power-cycle the board and repeat the command: a board with an incomplete image "
              "starts its boot ROM. Exit 1 when the board does not run the image afterwards."),
    HELP_EXAMPLE("matrig flash serial:/dev/ttyUSB0 build/firmware/matrig.elf"),
};

const struct command command_flash = {
    "flash",
    flash_command,
    "LINK IMAGE [--baud N] [--force]",
    "program a board through its chip's boot ROM",
    COMMAND_PARTS(parts),
    {2, 2, "LINK IMAGE"},
};
