/* Files that nothing here overwrites. */
#ifndef MATRIG_HIL_PRECIOUS_H
#define MATRIG_HIL_PRECIOUS_H

#include <stdbool.h>

/* Is it a file that must not be overwritten by mistake: a campaign (SQLite) or a program
 * (ELF)? */
bool hil_is_precious(const char *path);
/* Is there a file, of whatever content, that does not begin with `head` as a record of this program
 * does? */
bool hil_is_another_file(const char *path, const char *head);

#endif
