/* Which files hold what matrig wrote there, so that an output takes the place of nothing else.
 *
 * The file itself says so, in an extended attribute: SHA-256 of its content, its inode and its
 * name. So a file that was edited, copied or renamed is not taken for matrig's; a folder may be
 * moved. Where the file system has no such attributes a record in the user's state folder
 * ($XDG_STATE_HOME, else ~/.local/state, then matrig/written/) says it by full path. Where neither
 * can be kept nothing is taken for matrig's. */
#ifndef MATRIG_HOST_BASE_WRITTEN_H
#define MATRIG_HOST_BASE_WRITTEN_H

#include <stdbool.h>

enum written_state {
    WRITTEN_HERE,    /* the content is what matrig wrote at this path */
    WRITTEN_CHANGED, /* it was, and is another by now */
    WRITTEN_UNKNOWN, /* there is no record of it, or it cannot be read */
};

/* Of a regular file. `path` without symbolic links. */
enum written_state written_state(const char *path);

/* Records that the content of the open file `fd` (read from its beginning) is what matrig puts at
 * `path`, before it is put there. False: no record can be kept, errno says why. */
bool written_record(int fd, const char *path);

#endif
