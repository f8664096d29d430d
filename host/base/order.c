#include "host/base/order.h"

#include <ctype.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

bool order_is_database(const char *path)
{
    static const char magic[16] = "SQLite format 3";
    char head[sizeof magic];
    struct stat info;
    if (stat(path, &info) != 0 || !S_ISREG(info.st_mode))
        return false;
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    bool is = fd >= 0 && read(fd, head, sizeof head) == (ssize_t)sizeof head &&
              memcmp(head, magic, sizeof magic) == 0;
    if (fd >= 0)
        close(fd);
    return is;
}

static bool there(const char *path)
{
    return access(path, F_OK) == 0;
}

static bool is_number(const char *word)
{
    return word[0] && word[strspn(word, "0123456789")] == '\0';
}

/* "pty:", "serial:": letters and a colon. */
static bool is_link(const char *word)
{
    size_t letters = 0;
    while (islower((unsigned char)word[letters]))
        letters++;
    return letters > 2 && word[letters] == ':';
}

static bool begins(const char *names, const char *with)
{
    return strncmp(names, with, strlen(with)) == 0;
}

static bool are_swapped(const char *names, const char *first, const char *second)
{
    if (begins(names, "LINK"))
        return there(first) && is_link(second);
    if (strstr(names, "RUN") && is_number(first) && !is_number(second) && !there(first))
        return true;
    if (begins(names, "DB FILE")) /* a campaign may be made */
        return there(first) && !order_is_database(first) && order_is_database(second);
    return begins(names, "DB") && !there(first) && there(second) &&
           (is_number(first) || order_is_database(second));
}

enum mr_status order_check(const struct command *command, const char *name, const char **words,
                           size_t count, struct error *error)
{
    const char *names = command->operands.names;
    if (count > 0 && begins(names, "DB") && !words[0][0])
        return error_set(
            error, MR_USAGE,
            "an empty word in place of DB: matrig %s; is a variable of the shell not set?", name);
    if (count < 2 || !are_swapped(names, words[0], words[1]))
        return MR_OK;
    return error_set(error, MR_USAGE, "swapped: '%s' and '%s'; write matrig %s %s %s%s", words[0],
                     words[1], name, words[1], words[0], count > 2 ? " ..." : "");
}
