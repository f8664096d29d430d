#include "common/command.h"

#include <stdbool.h>

#include "common/decimal.h"

struct command_row {
    uint8_t code;
    const char *name;
    bool has_index;
    int32_t counts_per_unit;
};

static const struct command_row command_rows[] = {
#define COMMAND(NAME, code, text, part, indexed, counts, ...) {code, text, indexed, counts},
#include "common/catalogue.def"
};

#define COMMAND_ROW_COUNT (sizeof command_rows / sizeof command_rows[0])

static const char *skip_blanks(const char *p)
{
    while (*p == ' ' || *p == '\t' || *p == '\r' || *p == '\n')
        p++;
    return p;
}

/* Compares the word at `words` with `name`. If they are equal, returns the text after it; otherwise
 * NULL. */
static const char *match_word(const char *words, const char *name)
{
    while (*name && *words == *name) {
        words++;
        name++;
    }
    bool ends = *words == '\0' || *words == ' ' || *words == '\t' || *words == '\r' ||
              *words == '\n';
    return *name == '\0' && ends ? words : NULL;
}

/* Parses a number and rounds it (half up) to a multiple of 1 / `counts_per_unit`. If
 * `counts_per_unit` is 1, the number is a count and must not have a fraction. */
static const char *parse_scaled(const char *p, int32_t counts_per_unit, int32_t *value)
{
    const char *end;
    double counts = mr_decimal_parse(p, &end) * (double)counts_per_unit;
    if (end == p || !(counts <= (double)INT32_MAX) || !(counts >= -(double)INT32_MAX))
        return NULL;
    *value = (int32_t)(counts < 0.0 ? counts - 0.5 : counts + 0.5);
    return counts_per_unit > 1 || counts == (double)*value ? end : NULL;
}

enum mr_status mr_command_parse(const char *text, uint16_t tag, struct mr_command *command)
{
    text = skip_blanks(text);
    for (size_t i = 0; i < COMMAND_ROW_COUNT; i++) {
        const char *p = match_word(text, command_rows[i].name);
        int32_t index = 0;
        int32_t argument = 0;
        if (!p)
            continue;
        p = skip_blanks(p);
        if (command_rows[i].has_index) {
            p = parse_scaled(p, 1, &index);
            if (!p || index < 0 || index > 255)
                return MR_USAGE;
            p = skip_blanks(p);
            if (!*p)
                return MR_USAGE;
        }
        if (*p) {
            p = parse_scaled(p, command_rows[i].counts_per_unit, &argument);
            if (!p || *skip_blanks(p))
                return MR_USAGE;
        }
        *command = (struct mr_command){.code = command_rows[i].code,
                                       .index = (uint8_t)index,
                                       .tag = tag,
                                       .argument = argument};
        return MR_OK;
    }
    return MR_UNKNOWN;
}

const char *mr_command_name(unsigned code)
{
    for (size_t i = 0; i < COMMAND_ROW_COUNT; i++) {
        if (command_rows[i].code == code)
            return command_rows[i].name;
    }
    return "unknown";
}

enum mr_privilege mr_command_privilege(unsigned code)
{
    switch (code) {
/* clang-format off */
#define COMMAND(NAME, code, text, part, indexed, counts, privilege, ...) \
    case code: return MR_PRIVILEGE_##privilege;
/* clang-format on */
#include "common/catalogue.def"
    default: return MR_PRIVILEGE_OPEN;
    }
}
