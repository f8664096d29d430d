#include "host/base/command.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/base/spell_suggest.h"
#include "host/base/quantity.h"

struct parser {
    const struct command *command;
    const char *name; /* name of the command as the user typed it */
    const struct cli *cli;
    char *values;
    bool is_given[COMMAND_PARTS_MAX];
};

static void *get_value_address(const struct parser *p, const struct command_option *option)
{
    return p->values + option->offset;
}

/* Index of the option in `parts`; `part_count` if there is no such option. */
static size_t find_option(const struct command *command, const char *word, const char **attached)
{
    const struct command_part *parts = command->parts;
    const char *equals = strchr(word, '=');
    size_t length = equals ? (size_t)(equals - word) : strlen(word);
    *attached = equals ? equals + 1 : NULL;
    for (size_t i = 0; i < command->part_count; i++) {
        const char *name = parts[i].option.name;
        if (name && strlen(name) == length && strncmp(name, word, length) == 0)
            return i;
    }
    /* the value may follow the letter directly, as in make and cc: -j4, -oFILE */
    for (size_t i = 0;
         i < command->part_count && word[0] == '-' && word[1] != '-' && word[1] && word[2]; i++) {
        const char *name = parts[i].option.name;
        if (name && name[1] == word[1] && !name[2] && parts[i].option.argument) {
            *attached = word + 2;
            return i;
        }
    }
    return command->part_count;
}

/* Returns the long option that begins with this letter; NULL if there is none or more than one. */
static const char *find_option_by_letter(const struct command *command, char letter)
{
    const char *only = NULL;
    for (size_t i = 0; i < command->part_count; i++) {
        const char *name = command->parts[i].option.name;
        if (!name || name[1] != '-' || name[2] != letter)
            continue;
        if (only)
            return NULL;
        only = name;
    }
    return only;
}

/* `name`: the command as the user typed it; NULL: the option stands before the command. */
static enum mr_status refuse_unknown_option(const struct command *command, const char *name,
                                            const char *word, struct error *error)
{
    struct spell_suggest near;
    char text[SPELL_SUGGEST_TEXT_SIZE], bare[40];
    snprintf(bare, sizeof bare, "%.*s", (int)strcspn(word, "="), word);
    spell_suggest_begin(&near, bare);
    for (size_t i = 0; i < command->part_count; i++) {
        if (command->parts[i].option.name)
            spell_suggest_add(&near, command->parts[i].option.name);
    }
    if (!near.best && bare[0] == '-' && bare[1] && !bare[2])
        near.best = find_option_by_letter(command, bare[1]);
    spell_suggest_text(&near, text);
    return error_set(error, MR_UNKNOWN, "unknown option: '%s'%s%s%s%s see matrig %s%s--help", word,
                     name ? " of " : "", name ? name : "", text, text[0] ? "" : ";",
                     name ? name : "", name ? " " : "");
}

/* ---- options before the command ---- */

#define OPTION_VALUES struct global_options
static const struct command_part parts[] = {
    OPTION_FLAG("--json", cli.json, "print the result as one JSON object"),
    OPTION_FLAG("--quiet", cli.quiet, "print no progress and no notes"),
    OPTION_FLAG("--si", cli.si,
                "print metres, seconds and newtons instead of feet, inches and pounds"),
    OPTION_FLAG("--version", version, NULL),
    OPTION_FLAG("--help", help, NULL),
};

const struct command command_matrig = {"matrig",
                                       NULL,
                                       "COMMAND ...",
                                       "measuring system for a model landing-mat runway",
                                       COMMAND_PARTS(parts),
                                       {0, 0, ""}};

int command_parse_global_options(int argc, char **argv, struct global_options *before,
                                 struct error *error)
{
    int i = 1;
    for (; i < argc && argv[i][0] == '-' && !before->help && !before->version; i++) {
        const char *attached, *word = strcmp(argv[i], "-h") == 0 ? "--help" : argv[i];
        size_t row = find_option(&command_matrig, word, &attached);
        if (row == command_matrig.part_count || attached)
            refuse_unknown_option(&command_matrig, NULL, argv[i], error);
        if (error->status != MR_OK)
            break;
        *(bool *)((char *)before + parts[row].option.offset) = true;
    }
    return i;
}

static enum mr_status refuse_unknown_or_misplaced(const struct parser *p, const char *word,
                                                  struct error *error)
{
    const char *attached;
    size_t row = find_option(&command_matrig, word, &attached);
    if (row != command_matrig.part_count && !attached &&
        parts[row].text) /* skip --version, which has no help text */
        return error_set(error, MR_UNKNOWN,
                         "option in the wrong place: '%s' after %s; put the option before the "
                         "command: matrig %s %s",
                         word, p->name, word, p->name);
    if (word[1] && strchr("0123456789.", word[1]) && !strstr(p->command->operands.names, "RUN"))
        return error_set(error, MR_USAGE,
                         "negative number: '%s' of %s; places are 0 or more, and a value needs its "
                         "name: NAME=%s",
                         word, p->name, word);
    if (strstr(p->command->operands.names, "RUN") && word[1 + strspn(word + 1, "0123456789")] == 0)
        return error_set(error, MR_UNKNOWN,
                         "not a RUN: '%s' of %s; give the number of a landing, 1 or more (matrig "
                         "show DB lists the landings)",
                         word, p->name);
    return refuse_unknown_option(p->command, p->name, word, error);
}

/* ---- values ---- */

/* Reads a number that may have its own unit: "0.5" or "12mm". */
static enum mr_status read_number(const struct parser *p, const struct command_option *option,
                                  const char *text, struct error *error)
{
    const char *unit = option->unit ? option->unit : "";
    const char *bare = p->cli->si && option->unit_si ? option->unit_si : unit;
    double number;
    if (quantity_read(text, option->name, unit, bare, &number, error) != MR_OK)
        return error->status;
    if (!(number >= option->low && number <= option->high))
        return error_set(error, MR_USAGE, "out of range: %s for %s; allowed: %g to %g%s%s", text,
                         option->name, quantity_convert(option->low, unit, bare),
                         quantity_convert(option->high, unit, bare), *bare ? " " : "", bare);
    *(double *)get_value_address(p, option) = number;
    return MR_OK;
}

static enum mr_status read_integer(const struct parser *p, const struct command_option *option,
                                   const char *text, struct error *error)
{
    double number;
    enum mr_status status = cli_parse_number(text, option->name, option->low, option->high, &number,
                                             error);
    if (status == MR_OK && number != floor(number))
        status = error_set(error, MR_USAGE,
                           "not a whole number: '%s' for %s; write digits such as %g", text,
                           option->name, fmax(option->low, 4.0));
    if (status == MR_OK)
        *(int64_t *)get_value_address(p, option) = (int64_t)number;
    return status;
}

static enum mr_status read_run(const struct parser *p, const struct command_option *option,
                               const char *text, struct error *error)
{
    struct error why = {0};
    if (parse_run(text, get_value_address(p, option), &why) != MR_OK)
        return error_set(error, why.status,
                         "not a RUN: '%s' for %s; give the number of a landing, 1 or more", text,
                         option->name);
    return MR_OK;
}

/* Writes the choices as words: "csv, candump or mdf4". */
static void format_choices(const char *choices, char *out, size_t size)
{
    size_t used = 0;
    const char *last = strrchr(choices, '|');
    for (const char *c = choices; *c && used + 6 < size; c++) {
        const char *between = c == last ? " or " : ", ";
        size_t length = *c == '|' ? strlen(between) : 1;
        memcpy(out + used, *c == '|' ? between : c, length);
        used += length;
    }
    out[used] = '\0';
}

static enum mr_status read_choice(const struct parser *p, const struct command_option *option,
                                  const char *text, struct error *error)
{
    char all[160], suggestion[SPELL_SUGGEST_TEXT_SIZE];
    struct spell_suggest near;
    if (spell_suggest_add_choices(&near, text, option->choices)) {
        *(const char **)get_value_address(p, option) = text;
        return MR_OK;
    }
    format_choices(option->choices, all, sizeof all);
    spell_suggest_text(&near, suggestion);
    return error_set(error, MR_USAGE, "unknown %s: '%s' for %s%s%s give %s", option->noun, text,
                     option->name, suggestion, suggestion[0] ? "" : ";", all);
}

/* Refuses a wrong file extension: x.pdf for an option whose argument is F.html or F.csv. */
static enum mr_status check_extension(const struct command_option *option, const char *text,
                                      struct error *error)
{
    static const char known[] = ".pdf.png.jpg.jpeg.gif.svg.html.htm.csv.tsv.json.mf4.mdf.dbc.xls."
                                "xlsx.ods.doc.docx.zip.gz.cfg.";
    const char *dot = strrchr(text, '.'), *own = strchr(option->argument, '.');
    char ending[12];
    if (!own || !dot || strchr(dot, '/') || strlen(dot) + 2 > sizeof ending)
        return MR_OK;
    snprintf(ending, sizeof ending, "%s.", dot);
    for (char *c = ending; *c; c++)
        *c = (char)tolower((unsigned char)*c);
    if (!strstr(known, ending))
        return MR_OK;
    *strrchr(ending, '.') = '\0';
    if (strstr(own, ending))
        return MR_OK;
    return error_set(error, MR_USAGE, "wrong file extension: '%s' for %s; name the file %s", text,
                     option->name, option->argument);
}

static enum mr_status store_value(const struct parser *p, const struct command_option *option,
                                  const char *text, struct error *error)
{
    switch (option->kind) {
    case OPTION_IS_TEXT:
        *(const char **)get_value_address(p, option) = text;
        return check_extension(option, text, error);
    case OPTION_IS_NUMBER: return read_number(p, option, text, error);
    case OPTION_IS_INTEGER: return read_integer(p, option, text, error);
    case OPTION_IS_RUN: return read_run(p, option, text, error);
    case OPTION_IS_CHOICE: return read_choice(p, option, text, error);
    default: return MR_OK;
    }
}

static void set_defaults(const struct parser *p)
{
    for (size_t i = 0; i < p->command->part_count; i++) {
        const struct command_option *option = &p->command->parts[i].option;
        if (option->kind == OPTION_IS_NUMBER)
            *(double *)get_value_address(p, option) = option->default_value;
        else if (option->kind == OPTION_IS_INTEGER || option->kind == OPTION_IS_RUN)
            *(int64_t *)get_value_address(p, option) = (int64_t)option->default_value;
    }
}

/* Reads the option argv[*at] and its value. If the value is the next argument, increments *at. */
static enum mr_status read_option(struct parser *p, int argc, char **argv, int *at,
                                  struct error *error)
{
    const char *attached;
    size_t i = find_option(p->command, argv[*at], &attached);
    if (i == p->command->part_count)
        return refuse_unknown_or_misplaced(p, argv[*at], error);
    const struct command_option *option = &p->command->parts[i].option;
    if (option->kind == OPTION_IS_FLAG) {
        if (attached)
            return error_set(error, MR_USAGE,
                             "option takes no value: '%s' of %s; leave the value out", argv[*at],
                             p->name);
        *(bool *)get_value_address(p, option) = true;
        return MR_OK;
    }
    if (p->is_given[i])
        return error_set(error, MR_USAGE, "option given twice: %s of %s; give it once",
                         option->name, p->name);
    /* An option is never a value: in `--note --who kl` the value of --note is missing. */
    const char *next = *at + 1 < argc ? argv[*at + 1] : NULL, *of_next = NULL;
    if (!attached &&
        (!next || (next[0] == '-' &&
                   find_option(p->command, next, &of_next) < p->command->part_count && !of_next)))
        return error_set(error, MR_USAGE,
                         "option without its value: %s of %s; see matrig %s --help", option->name,
                         p->name, p->name);
    p->is_given[i] = true;
    return store_value(p, option, attached ? attached : argv[++*at], error);
}

/* True if the word before argv[i] is the value of a text option: argv[i] probably belongs to a text
 * without quotes. */
static bool follows_text_value(const struct parser *p, char **argv, int i)
{
    const char *attached;
    size_t row = i > 2 && argv[i - 2][0] == '-' ? find_option(p->command, argv[i - 2], &attached)
                                                : p->command->part_count;
    return row < p->command->part_count && p->command->parts[row].option.kind == OPTION_IS_TEXT;
}

/* True if the second operand is not a RUN and is probably the rest of a text without quotes, as in
 * `--runway as laid`. */
static bool follows_unquoted_text(const struct parser *p, char **argv, int i, size_t count)
{
    int64_t run;
    struct error ignored = {0};
    return count == 1 && strstr(p->command->operands.names, "RUN") &&
           follows_text_value(p, argv, i) && parse_run(argv[i], &run, &ignored) != MR_OK;
}

static bool has_ending(const char *text, const char *ending)
{
    size_t length = strlen(text), last = strlen(ending);
    return length > last && strcmp(text + length - last, ending) == 0;
}

/* Finds the option that is probably missing before this word, because the word looks like its
 * value: a format, a file F.html or a DB. */
static const char *find_option_of_value(const struct parser *p, const char *word)
{
    const char *dot = strrchr(word, '.');
    for (size_t i = 0; i < p->command->part_count; i++) {
        const struct command_option *option = &p->command->parts[i].option;
        struct error ignored = {0};
        const char *own = option->argument ? strchr(option->argument, '.') : NULL;
        if (!option->name || p->is_given[i] || option->kind == OPTION_IS_FLAG)
            continue;
        if ((option->kind == OPTION_IS_CHOICE && read_choice(p, option, word, &ignored) == MR_OK) ||
            (strcmp(option->name, "-o") == 0 && own && dot && strlen(dot) > 2 &&
             strstr(own, dot)) ||
            (strcmp(option->name, "--db") == 0 && has_ending(word, ".db")))
            return option->name;
    }
    return NULL;
}

/* True if argv[i] is the unit of the number before it, as in --speed 36 ft/s. */
static bool is_unit_of_previous_number(const struct parser *p, char **argv, int i)
{
    const char *attached;
    char joined[80];
    double number;
    struct error ignored = {0};
    size_t row = i > 2 && argv[i - 2][0] == '-' ? find_option(p->command, argv[i - 2], &attached)
                                                : p->command->part_count;
    if (row == p->command->part_count || p->command->parts[row].option.kind != OPTION_IS_NUMBER)
        return false;
    const char *unit = p->command->parts[row].option.unit;
    snprintf(joined, sizeof joined, "%s%s", argv[i - 1], argv[i]);
    return unit && quantity_read(joined, "", unit, unit, &number, &ignored) == MR_OK;
}

static enum mr_status refuse_extra_word(const struct parser *p, char **argv, int i,
                                        struct error *error)
{
    const char *option = find_option_of_value(p, argv[i]), *takes = p->command->operands.names;
    if (option)
        return error_set(error, MR_USAGE, "unexpected argument: '%s' of %s; write %s %s", argv[i],
                         p->name, option, argv[i]);
    if (strstr(takes, "RUN") && strcmp(argv[i - 1], "landing") == 0 &&
        argv[i][strspn(argv[i], "0123456789")] == '\0')
        return error_set(error, MR_USAGE,
                         "unexpected argument: '%s' of %s; for landing %s of the board write "
                         "landing%s, as one word",
                         argv[i], p->name, argv[i], argv[i]);
    if (is_unit_of_previous_number(p, argv, i))
        return error_set(error, MR_USAGE,
                         "unexpected argument: '%s' of %s; put the unit directly after its "
                         "number: %s %s%s",
                         argv[i], p->name, argv[i - 2], argv[i - 1], argv[i]);
    if (!follows_text_value(p, argv, i))
        return error_set(error, MR_USAGE,
                         "unexpected argument: '%s' of %s%s%s; see matrig %s --help", argv[i],
                         p->name, *takes ? ", which takes " : "", takes, p->name);
    return error_set(
        error, MR_USAGE,
        "unexpected argument: '%s' of %s; put a text of several words in quotes: %s '%s %s ...'",
        argv[i], p->name, argv[i - 2], argv[i - 1], argv[i]);
}

/* Refuses a dash or quote of a web page or word processor that was pasted instead of - or ". */
static enum mr_status check_typography(const char *word, struct error *error)
{
    static const struct {
        const char *prefix, *kind, *correct;
    } marks[] = {
        {"\xe2\x80\x93", "dash", "--"},  {"\xe2\x80\x94", "dash", "--"},
        {"\xe2\x88\x92", "minus", "-"},  {"\xe2\x80\x9c", "quote", "\""},
        {"\xe2\x80\x9d", "quote", "\""}, {"\xe2\x80\x9e", "quote", "\""},
        {"\xe2\x80\x98", "quote", "'"},  {"\xe2\x80\x99", "quote", "'"},
    };
    for (size_t i = 0; i < sizeof marks / sizeof marks[0]; i++)
        if (strncmp(word, marks[i].prefix, 3) == 0)
            return error_set(error, MR_USAGE, "typographic %s: '%s'; type %s instead",
                             marks[i].kind, word, marks[i].correct);
    return MR_OK;
}

enum mr_status command_parse(const struct command *command, int argc, char **argv,
                             const struct cli *cli, void *values, const char **words,
                             struct error *error)
{
    struct parser p = {.command = command, .name = argv[0], .cli = cli, .values = values};
    const struct command_operands *operands = &command->operands;
    size_t count = 0;
    set_defaults(&p);
    for (size_t i = 0; i < operands->max; i++)
        words[i] = NULL;
    for (int i = 1; i < argc; i++) {
        bool is_option = argv[i][0] == '-' && argv[i][1] != '\0';
        if (check_typography(argv[i], error) != MR_OK)
            return error->status;
        if (is_option && read_option(&p, argc, argv, &i, error) != MR_OK)
            return error->status;
        if (!is_option && (count == operands->max || follows_unquoted_text(&p, argv, i, count)))
            return refuse_extra_word(&p, argv, i, error);
        if (!is_option)
            words[count++] = argv[i];
    }
    if (count < operands->min)
        return error_set(error, MR_USAGE,
                         "argument missing: matrig %s needs %s; see matrig %s --help", p.name,
                         operands->names, p.name);
    return MR_OK;
}

enum mr_status parse_run(const char *text, int64_t *run, struct error *error)
{
    char *end;
    errno = 0;
    bool boards = strncmp(text, "landing", 7) == 0;
    const char *digits = text + (boards ? 7 : 0);
    long long value = strtoll(digits, &end, 10);
    if (end == digits || *end != '\0' || errno != 0 || value < 1)
        return error_set(error, MR_USAGE,
                         "not a RUN: '%s'; give the landing's number in the campaign (1, 2, ...), "
                         "or landing5 for the board's own landing number 5",
                         text);
    *run = boards ? -value : value;
    return MR_OK;
}
