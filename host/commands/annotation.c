#include "host/commands/annotation.h"

#include <stdio.h>
#include <pwd.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/base/cli.h"
#include "host/base/output.h"
#include "host/store/rows.h"

enum { WHO_SIZE = sizeof((struct store_record *)0)->who };

const char *annotation_author(const char *who)
{
    if (who && (!text_is_plain(who) || strlen(who) >= WHO_SIZE))
        error_set(fatal, MR_USAGE,
                  "not a name: the value of --who; give one line of at most %d characters of UTF-8",
                  WHO_SIZE - 1);
    const char *user = getenv("USER"); /* services, cron and su do not set USER */
    const struct passwd *login = who || (user && user[0]) ? NULL : getpwuid(geteuid());
    return who ? who : login ? login->pw_name : user ? user : "";
}

void annotation_copy(char *into, size_t size, const char *text)
{
    snprintf(into, size, "%.*s", (int)size - 1, text ? text : "");
}

const char *text_or_dash(const char *text)
{
    return text[0] ? text : "-";
}
