/* What of the answers is no truth about the landing. Everything else is compared. */
#include <stdio.h>
#include <string.h>

#include "tests/golden/golden.h"

static const struct {
    const char *message, *field; /* NULL: all of the message */
    const char *reason;
} excluded[] = {
    {"hello", "layout", "number of the wire's layout: the files are by name"},
    {"hello", "major", "which image answers"},
    {"hello", "minor", "which image answers"},
    {"hello", "patch", "which image answers"},
    {"board_image", "image_crc", "which image answers"},
    {"config_state", "board", "which board answers"},
    {"board_config", "config_crc",
     "a checksum over the configuration's layout; its values are told and compared"},
    {"runway_store", "crc",
     "a checksum over the runway's layout; its joints are told and compared"},
    {"restarts", "late_pc", "an address in the image"},
    {"ack", "code", "number of a command; its tag tells which one it was"},
    {"image_commit", NULL, "which commit the image was built from"},
    {"image_header", NULL, "sizes and checksums of the image"},
    {"message_count", NULL, "a count of messages that are all compared"},
    {"can_health", "sent", "a count of messages that are all compared"},
    {"serial_health", "sent", "a count of messages that are all compared"},
    {"health", "load_permille", "how busy the processor was: any change of the code changes it"},
    {"upkeep", NULL, "how far the tests of memory have come in the time that was left"},
    {"sync_at", NULL, "when a frame got onto the bus, to the tick: cycles of the code"},
};

#define RESERVED "reserved"
static const char reserved[] = "says nothing yet";

const char *golden_excluded(const char *message, const char *field)
{
    if (field && strncmp(field, RESERVED, strlen(RESERVED)) == 0)
        return reserved;
    for (size_t i = 0; i < sizeof excluded / sizeof excluded[0]; i++) {
        if (strcmp(excluded[i].message, message) == 0 &&
            (!excluded[i].field || (field && strcmp(excluded[i].field, field) == 0)))
            return excluded[i].reason;
    }
    return NULL;
}

void golden_tell_excluded(void)
{
    printf("*." RESERVED ": %s\n", reserved);
    for (size_t i = 0; i < sizeof excluded / sizeof excluded[0]; i++)
        printf("%s.%s: %s\n", excluded[i].message, excluded[i].field ? excluded[i].field : "*",
               excluded[i].reason);
}
