/* Files that nothing here overwrites. */
#ifndef MATRIG_HIL_PRECIOUS_H
#define MATRIG_HIL_PRECIOUS_H

#include <stdbool.h>

/* Is it a file that must not be overwritten by mistake: a campaign (SQLite), what SQLite keeps
 * beside one, or a program (ELF)? */
bool hil_is_precious(const char *path);

#endif
