/* A name without a kind, as people type it: can0, /dev/ttyUSB0, landing.log. */
#include <ctype.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "host/link/link.h"

#define FORMS_TEXT 200u

static const struct {
    const char *prefix, *form;
} kinds[] = {
#define LINK_OF(name, form, text) {#name ":", form},
#include "host/link/kinds.def"
};
#define KINDS (sizeof kinds / sizeof kinds[0])

static bool has_kind(const char *spec)
{
    for (size_t i = 0; i < KINDS; i++) {
        if (strncmp(spec, kinds[i].prefix, strlen(kinds[i].prefix)) == 0)
            return true;
    }
    return false;
}

/* "unix:PATH, file:PATH or pty:PATH" */
static void say_forms(char out[FORMS_TEXT])
{
    size_t n = 0;
    for (size_t i = 0; i < KINDS && n < FORMS_TEXT; i++)
        n += (size_t)snprintf(out + n, FORMS_TEXT - n, "%s%s",
                              i == 0          ? ""
                              : i + 1 < KINDS ? ", "
                                              : " or ",
                              kinds[i].form);
}

/* can0, vcan1, slcan0: as Linux calls its CAN interfaces; or one that is there. */
static bool is_can(const char *name)
{
    const char *can = strstr(name, "can");
    bool called = can && can - name <= 2 && can[3] &&
                  can[3 + strspn(can + 3, "0123456789")] == '\0';
    return !strchr(name, '/') && strlen(name) < IF_NAMESIZE &&
           (called || if_nametoindex(name) != 0);
}

/* /dev/ttyUSB0, or ttyUSB0 as it is said; the device's path without the rate behind it. False: of
 * another kind. */
static bool is_port(const char *name, char path[200])
{
    bool bare = strncmp(name, "tty", 3) == 0 && isupper((unsigned char)name[3]);
    bool whole = strncmp(name, "/dev/tty", 8) == 0 || strncmp(name, "/dev/serial/", 12) == 0;
    const char *dev = bare ? "/dev/" : "";
    snprintf(path, 200, "%s%s", dev, name);
    return bare || whole;
}

static enum mr_status say(char out[LINK_SPEC_MAX], const char *kind, const char *name)
{
    snprintf(out, LINK_SPEC_MAX, "%s:%s", kind, name);
    return MR_OK;
}

/* COM3, as another system calls its ports. */
static bool is_com(const char *name)
{
    return strncasecmp(name, "com", 3) == 0 && name[3] &&
           name[3 + strspn(name + 3, "0123456789")] == '\0';
}

static enum mr_status complete_file(const char *spec, enum link_kind kind, char out[LINK_SPEC_MAX],
                                    const struct stat *info, struct error *error)
{
    static const char magic[] = "SQLite format 3";
    char head[sizeof magic] = "";
    FILE *file = S_ISREG(info->st_mode) ? fopen(spec, "rb") : NULL;
    bool database = file && fread(head, sizeof head, 1, file) == 1 &&
                    memcmp(head, magic, sizeof magic) == 0;
    if (file)
        fclose(file);
    if (database)
        return error_set(error, MR_USAGE,
                         "a campaign, no link: '%s'; give it as DB (--db of matrig log)", spec);
    if (S_ISDIR(info->st_mode))
        return error_set(error, MR_USAGE, "a folder, no link: '%s'; name a file in it", spec);
    if (S_ISSOCK(info->st_mode))
        return say(out, "unix", spec);
    if (S_ISREG(info->st_mode) || S_ISFIFO(info->st_mode))
        return say(out, "file", spec);
    if (S_ISCHR(info->st_mode) && kind == LINK_SERIAL)
        return say(out, "pty", spec);
    return error_set(error, MR_USAGE, "not a link: '%s'; write serial:%s or pty:%s", spec, spec,
                     spec);
}

static enum mr_status refuse_name(const char *spec, struct error *error)
{
    char forms[FORMS_TEXT];
    if (is_com(spec))
        return error_set(error, MR_USAGE,
                         "not a link: '%s'; Linux calls its serial ports /dev/ttyUSB0, "
                         "/dev/ttyACM0, ...",
                         spec);
    if (strchr(spec, '/') || strchr(spec, '.'))
        return error_set(error, MR_IO,
                         "no such file, port or interface: %s; check its name (ls, ip link)", spec);
    say_forms(forms);
    return error_set(error, MR_USAGE, "not a link: '%s'; write %s", spec, forms);
}

enum mr_status link_complete(const char *spec, enum link_kind kind, char out[LINK_SPEC_MAX],
                             struct error *error)
{
    struct stat info;
    char port[200];
    if (has_kind(spec)) {
        snprintf(out, LINK_SPEC_MAX, "%s", spec);
        return MR_OK;
    }
    if (is_port(spec, port) && kind == LINK_SERIAL)
        return say(out, "serial", port);
    if (is_port(strncmp(spec, "slcan:", 6) == 0 ? spec + 6 : spec, port))
        return error_set(error, MR_USAGE,
                         "not a CAN link: '%s'; for an SLCAN adapter run slcand -o -s8 %s can0 and "
                         "ip link set can0 up, then give can:can0; the board's own line is "
                         "--serial",
                         spec, port);
    if (stat(spec, &info) == 0)
        return complete_file(spec, kind, out, &info, error);
    if (is_can(spec) && kind == LINK_CAN)
        return say(out, "can", spec);
    if (is_can(spec))
        return error_set(error, MR_USAGE,
                         "%s is a CAN interface: it carries no serial bytes; give it as --can",
                         spec);
    return refuse_name(spec, error);
}

bool link_is_can(const char *spec)
{
    struct stat info;
    struct link_bases bases;
    struct error ignored = {0};
    char plain[LINK_SPEC_MAX];
    snprintf(plain, sizeof plain, "%s", spec);
    (void)link_take_bases(plain, &bases, &ignored); /* whoever opens it says what is wrong there */
    return strncmp(plain, "can:", 4) == 0 ||
           (!has_kind(plain) && stat(plain, &info) != 0 && is_can(plain));
}
