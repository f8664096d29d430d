#include "host/board/stm32flash.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "host/base/process.h"

#define CHIP_TRIES 3u
#define SAID_MAX   2048u
#define WORDS_MAX  16u
#define NOT_FOUND  127 /* exit code of a program that is not there */

/* Vectors and code for sector 0 while the program is not whole: from any reset to the boot ROM,
 * with its stack pointer and entry from 0x1FFF0000 (AN2606), as firmware/f407/board.c goes there.
 *     ldr r0, =0x1fff0000;  ldr r1, [r0];  msr msp, r1;  ldr r1, [r0, #4];  bx r1 */
static const uint8_t detour[24] = {
    0x00, 0x20, 0x00, 0x20, 0x09, 0x00, 0x00, 0x08, 0x02, 0x48, 0x01, 0x68,
    0x81, 0xf3, 0x08, 0x88, 0x41, 0x68, 0x08, 0x47, 0x00, 0x00, 0xff, 0x1f,
};

struct part {
    const char *name;
    uint32_t at; /* from MR_IMAGE_FLASH on */
    const uint8_t *bytes;
    size_t count;
    bool start; /* start the program afterwards */
};

/* The newest `(42.00%)` of what it has said. */
static void show(const struct stm32flash *to, const char *part, const char *said)
{
    const char *percent = strrchr(said, '(');
    char *end;
    double value = percent ? strtod(percent + 1, &end) : 0;
    if (to->progress && percent && *end == '%')
        to->progress(to->context, part, value);
}

/* What it says until it ends; of more than there is room for, the newest. */
static void listen(const struct stm32flash *to, int fd, const char *part, char said[SAID_MAX])
{
    size_t length = 0;
    ssize_t count;
    for (;;) {
        if (length == SAID_MAX - 1) {
            memmove(said, said + SAID_MAX / 2, length -= SAID_MAX / 2);
            said[length] = '\0';
        }
        if ((count = read(fd, said + length, SAID_MAX - 1 - length)) <= 0)
            return;
        said[length += (size_t)count] = '\0';
        show(to, part, said);
    }
}

static void last_line(char *said, char line[120])
{
    size_t end = strlen(said);
    while (end > 0 && strchr("\r\n ", said[end - 1]))
        said[--end] = '\0';
    size_t start = end;
    while (start > 0 && !strchr("\r\n", said[start - 1]))
        start--;
    snprintf(line, 120, "%s", said + start);
}

/* Runs stm32flash with these words between its own and the port. MR_LIMIT, without setting `error`:
 * it failed, and said why in `said`. */
static enum mr_status run(const struct stm32flash *to, const char *const words[], const char *part,
                          char said[SAID_MAX], struct error *error)
{
    char baud[12];
    const char *all[WORDS_MAX] = {"stm32flash", "-m", to->pts ? "8n1" : "8e1", "-b", baud};
    size_t n = 5;
    int ends[2], status = 0;
    pid_t child;
    snprintf(baud, sizeof baud, "%d", to->baud);
    while (*words && n < WORDS_MAX - 2)
        all[n++] = *words++;
    all[n] = to->tty;
    said[0] = '\0';
    if (pipe2(ends, O_CLOEXEC) != 0)
        return error_set(error, MR_IO, "no pipe to stm32flash; close other programs");
    if (process_start(all, (const int[]){-1, ends[1], ends[1]}, &child, error) == MR_OK) {
        close(ends[1]);
        listen(to, ends[0], part, said);
        waitpid(child, &status, 0);
    } else {
        close(ends[1]);
    }
    close(ends[0]);
    if (error->status != MR_OK)
        return error->status;
    if (WIFEXITED(status) && WEXITSTATUS(status) == NOT_FOUND)
        return error_set(error, MR_IO,
                         "no stm32flash, which programs boards: install it (apt-get install "
                         "stm32flash)");
    return status == 0 ? MR_OK : MR_LIMIT;
}

enum mr_status stm32flash_chip(const struct stm32flash *to, unsigned *chip, struct error *error)
{
    char said[SAID_MAX], why[120];
    /* What the firmware still sends when it restarts into the boot ROM can spoil the first try. */
    for (unsigned try = 0; try < CHIP_TRIES; try++) {
        enum mr_status status = run(to, (const char *const[]){NULL}, "boot ROM", said, error);
        const char *id = strstr(said, "Device ID");
        if (status == MR_OK && id && sscanf(id, "Device ID : %x", chip) == 1)
            return MR_OK;
        if (error->status != MR_OK)
            return error->status;
    }
    last_line(said, why);
    return error_set(
        error, MR_TIMEOUT,
        "no boot ROM answers (stm32flash: %s): %s; start the board with BOOT0 high, on "
        "USART1; switch it off and on if an earlier attempt broke off",
        why, to->spec);
}

static enum mr_status write_part(const struct stm32flash *to, const char *folder,
                                 const struct part *part, struct error *error)
{
    char path[TEMPORARY_FOLDER + 40], at[12], said[SAID_MAX], why[120];
    const char *words[] = {"-f", "-w", path, "-v", "-S", at, part->start ? "-g" : NULL, at, NULL};
    snprintf(path, sizeof path, "%s/part.bin", folder);
    snprintf(at, sizeof at, "0x%08x", (unsigned)(MR_IMAGE_FLASH + part->at));
    FILE *file = fopen(path, "wb");
    bool written = file && fwrite(part->bytes, 1, part->count, file) == part->count;
    if (!file || fclose(file) != 0 || !written)
        return error_set(error, MR_IO, "cannot write: %s; make room there, or set TMPDIR", path);
    if (run(to, words, part->name, said, error) != MR_LIMIT)
        return error->status;
    last_line(said, why);
    return error_set(error, MR_IO,
                     "stm32flash failed at the %s, %s: %s (%s); switch the board off and on and "
                     "run it again. stm32flash -u lifts write protection, -k read protection (it "
                     "erases everything)",
                     part->name, at, to->spec, why);
}

/* From `from` to the last byte before `to` that the image gives. False: none. */
static bool extent(const struct imagefile *image, uint32_t from, uint32_t to, struct part *part)
{
    while (to > from && !image->given[to - 1])
        to--;
    part->at = from;
    part->bytes = image->bytes + from;
    part->count = to - from;
    return to > from;
}

enum mr_status stm32flash_program(const struct stm32flash *to, const struct imagefile *image,
                                  struct error *error)
{
    static const char *const files[] = {"part.bin"};
    struct part first = {"detour to the boot ROM", 0, detour, sizeof detour, false};
    struct part program = {.name = "program"}, vectors = {.name = "vectors", .start = true};
    char folder[TEMPORARY_FOLDER];
    enum mr_status status = temporary_folder_make(folder, "flash", error);
    if (status == MR_OK && extent(image, IMAGEFILE_CONFIGURATION_END, IMAGEFILE_BYTES, &program)) {
        status = write_part(to, folder, &first, error);
        if (status == MR_OK)
            status = write_part(to, folder, &program, error);
    }
    if (status == MR_OK && extent(image, 0, IMAGEFILE_CONFIGURATION_START, &vectors))
        status = write_part(to, folder, &vectors, error);
    temporary_folder_remove(folder, files, 1);
    return status;
}
