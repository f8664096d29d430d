#include "host/commands/annotation.h"

#include <stdio.h>
#include <pwd.h>
#include <stdlib.h>
#include <unistd.h>

const char *annotation_author(const char *who)
{
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
