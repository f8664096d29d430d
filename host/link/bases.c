#include "host/link/bases.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "host/link/link.h"

_Static_assert(LINK_BASES_TEXT > 1u + LINK_BOARDS * sizeof "0x190", "room for all bases");

enum mr_status link_read_base(const char *text, const char *where, uint16_t *base,
                              struct error *error)
{
    bool hex = text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
    const char *digits = text + (hex ? 2 : 0);
    char *end;
    unsigned long value = strtoul(digits, &end, hex ? 16 : 10);
    if (!isxdigit((unsigned char)*digits) || *end || strlen(digits) > 8)
        return error_set(error, MR_USAGE, "no base of CAN identifiers: '%s' of %s; write 0x190",
                         text, where);
    if (value > MR_CAN_BASE_MOST)
        return error_set(error, MR_USAGE,
                         "base 0x%03lx: %s; 0x%03x at most, or identifiers would be beyond 0x%x",
                         value, where, MR_CAN_BASE_MOST, MR_CAN_ID_MOST);
    *base = (uint16_t)value;
    return MR_OK;
}

bool link_bases_meet(uint16_t one, uint16_t other, uint16_t *id)
{
    size_t count;
    const struct mr_message_info *messages = mr_catalogue(&count);
    for (size_t i = 0; i < count; i++) {
        *id = mr_can_to_bus(messages[i].id, one);
        if (mr_message_find(mr_can_from_bus(*id, other)))
            return true;
    }
    return false;
}

static enum mr_status check_apart(const struct link_bases *bases, const char *spec,
                                  struct error *error)
{
    uint16_t id;
    for (unsigned i = 0; i < bases->count; i++) {
        for (unsigned k = 0; k < i; k++) {
            if (link_bases_meet(bases->base[k], bases->base[i], &id))
                return error_set(error, MR_USAGE,
                                 "boards at 0x%03x and 0x%03x share identifiers (0x%03x): %s; give "
                                 "bases such as 0, 0x190 and 0x3c0",
                                 bases->base[k], bases->base[i], id, spec);
        }
    }
    return MR_OK;
}

enum mr_status link_take_bases(char *spec, struct link_bases *bases, struct error *error)
{
    char list[100], whole[300], *rest = list, *one;
    char *at = strrchr(spec, '@'), *path = strchr(spec, ':');
    *bases = (struct link_bases){.count = 1};
    if (!at || !isdigit((unsigned char)at[1]) || strlen(at) >= sizeof list ||
        at[1 + strspn(at + 1, "0123456789abcdefABCDEFxX,")] || access(spec, F_OK) == 0 ||
        (path && access(path + 1, F_OK) == 0))
        return MR_OK;
    snprintf(whole, sizeof whole, "%s", spec);
    snprintf(list, sizeof list, "%s", at + 1);
    bases->given = true;
    bases->count = 0;
    while ((one = strsep(&rest, ",")) != NULL) {
        if (bases->count == LINK_BOARDS)
            return error_set(error, MR_USAGE,
                             "more than %u boards on one bus: %s; log the others "
                             "with another matrig log",
                             LINK_BOARDS, whole);
        if (link_read_base(one, whole, &bases->base[bases->count++], error) != MR_OK)
            return error->status;
    }
    *at = '\0';
    return check_apart(bases, whole, error);
}

enum mr_status link_count_boards(const char *spec, unsigned *boards, struct error *error)
{
    char plain[LINK_SPEC_MAX];
    struct link_bases bases;
    snprintf(plain, sizeof plain, "%s", spec);
    enum mr_status status = link_take_bases(plain, &bases, error);
    *boards = bases.count;
    return status;
}

void link_bases_text(const struct link_bases *bases, char out[LINK_BASES_TEXT])
{
    size_t used = 0;
    out[0] = '\0';
    for (unsigned i = 0; bases->given && i < bases->count && used < LINK_BASES_TEXT; i++)
        used += (size_t)snprintf(out + used, LINK_BASES_TEXT - used, "%c0x%03x", i ? ',' : '@',
                                 bases->base[i]);
}
