#include <string.h>

#include "host/bundle/inside.h"

/* In the order in which they lie in the bundle: of one that is cut off, the first are saved. */
const struct bundle_file_info bundle_files[BUNDLE_FILES] = {
    [BUNDLE_PAGE] = {"report.html", "page", "what matrig report makes of the landing"},
    [BUNDLE_CANDUMP] = {"can.log", "candump", "CAN frames of the landing, as candump -L"},
    [BUNDLE_CONFIGURATION] = {"configuration.txt", "configuration",
                              "what the board had in force, as matrig board config reads it"},
    [BUNDLE_SCENE] = {"scene.json", "scene", "the mat scene it is compared with"},
    [BUNDLE_FIRMWARE] = {"firmware.elf", "firmware", "the image that recorded the landing"},
};

int bundle_known_file(const char *name, size_t length)
{
    for (int i = 0; i < BUNDLE_FILES; i++) {
        if (strlen(bundle_files[i].name) == length &&
            memcmp(bundle_files[i].name, name, length) == 0)
            return i;
    }
    return -1;
}
