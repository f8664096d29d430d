/* golden: files of golden landings (golden.h, README.md). The scripts beside it run the board. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "tests/golden/golden.h"

static const char usage[] =
    "usage: golden given CAMPAIGN.db RUN SCRATCH OUT.given.gz      what the board was given; "
    "SCRATCH: a file that may be written\n"
    "       golden replay IN.given.gz OUT.txt FLASH.bin            as a replay file of today, and "
    "the flash with the configuration\n"
    "       golden said IN.given.gz CAN.log SERIAL.bin OUT.said.gz what matrig-board said to it\n"
    "       golden compare [--fields] WAS.said.gz IS.said.gz       exit 1: they differ\n"
    "       golden excluded                                        fields that are not compared, "
    "with the reason\n";

void golden_fail(int code, const char *format, ...)
{
    va_list arguments;
    fputs("golden: ", stderr);
    va_start(arguments, format);
    vfprintf(stderr, format, arguments);
    va_end(arguments);
    fputc('\n', stderr);
    exit(code);
}

void *golden_grow(void *array, size_t count, size_t size)
{
    if (count && (count & (count - 1)))
        return array; /* room comes in powers of two */
    void *grown = realloc(array, (count ? 2 * count : 1) * size);
    if (!grown)
        golden_fail(3, "no memory");
    return grown;
}

static int compare(int argc, char **argv)
{
    struct golden_said was, is;
    bool brief = argc == 5 && strcmp(argv[2], "--fields") == 0;
    said_read(&was, argv[argc - 2]);
    said_read(&is, argv[argc - 1]);
    return said_compare(&was, &is, brief) ? 1 : 0;
}

int main(int argc, char **argv)
{
    struct golden_given given;
    struct golden_said said;
    const char *word = argc > 1 ? argv[1] : "";
    if (strcmp(word, "given") == 0 && argc == 6) {
        given_take(&given, argv[2], atol(argv[3]), argv[4]);
        given_write(&given, argv[5]);
    } else if (strcmp(word, "replay") == 0 && argc == 5) {
        given_read(&given, argv[2]);
        given_replay(&given, argv[3]);
        given_config_flash(given.config, argv[4]);
    } else if (strcmp(word, "said") == 0 && argc == 6) {
        given_read(&given, argv[2]);
        if (!said_take(&said, &given, argv[3], argv[4]))
            return 1;
        said_write(&said, argv[5]);
    } else if (strcmp(word, "compare") == 0 &&
               (argc == 4 || (argc == 5 && strcmp(argv[2], "--fields") == 0))) {
        return compare(argc, argv);
    } else if (strcmp(word, "excluded") == 0 && argc == 2) {
        golden_tell_excluded();
    } else {
        fputs(usage, stderr);
        return 2;
    }
    return 0;
}
