/* What commands take: options by a descriptor's rows (host/base/command.h); and the rows of every
 * command of matrig: no text speaks of an option that the command does not take, and the command
 * takes none that no text speaks of. */
#include "tests/cmocka_all.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/commands/commands.h"
#include "host/base/help.h"

struct given {
    const char *db, *format;
    double for_s, gap_in;
    int64_t seeds, run;
    bool loud;
};

#define OPTION_VALUES struct given
static const struct command_part parts[] = {
    HELP_ITEM("DB", "a file"),
    OPTION_TEXT("--db", "DB", db, "another; of {low}"),
    OPTION_NUMBER("--for", "S", for_s, "s", 0.5, 7200.0, 60.0,
                  "from {low} to {high}; else {standard}"),
    OPTION_NUMBER_SI("--gap", "IN", gap_in, "in", "mm", 0.0, 10.0, (double)NAN, "a gap"),
    OPTION_INTEGER("-n", "N", seeds, 1.0, 9.0, 4.0, "so many"),
    OPTION_RUN("--run", "RUN", run, "of one"),
    OPTION_CHOICE("--format", "F", format, "format", "csv|candump|mdf4", "how"),
    OPTION_FLAG("--loud", loud, "be so"),
};
static const struct command command = {
    "try", NULL, "DB ...", "a try", COMMAND_PARTS(parts), {1, 2, "DB [RUN]"}};

static struct error error;

static enum mr_status parse(struct given *given, const char *words[2], bool si, int argc,
                            const char *const *argv)
{
    const struct cli cli = {.si = si};
    memset(given, 0, sizeof *given);
    error = (struct error){0};
    return command_parse(&command, argc, (char **)argv, &cli, given, words, &error);
}

#define PARSE(...)                                                                          \
    parse(&given, words, false, (int)COUNT_OF(((const char *const[]){"try", __VA_ARGS__})), \
          (const char *const[]){"try", __VA_ARGS__})
#define PARSE_SI(...)                                                                      \
    parse(&given, words, true, (int)COUNT_OF(((const char *const[]){"try", __VA_ARGS__})), \
          (const char *const[]){"try", __VA_ARGS__})
#define REFUSED(why, ...)                                             \
    do {                                                              \
        assert_int_equal(mr_status_exit_code(PARSE(__VA_ARGS__)), 2); \
        if (!strstr(error.text, why))                                 \
            fail_msg("'%s' is not in '%s'", why, error.text);         \
    } while (0)

static struct given given;
static const char *words[2];

TEST(every_kind_has_its_value)
{
    assert_int_equal(PARSE("a.db", "--db", "b.db", "--for=90", "-n4", "--run", "12", "--format",
                           "mdf4", "--loud", "3"),
                     MR_OK);
    assert_string_equal(words[0], "a.db");
    assert_string_equal(words[1], "3");
    assert_string_equal(given.db, "b.db");
    assert_true(given.for_s == 90.0 && given.seeds == 4 && given.run == 12 && given.loud);
    assert_string_equal(given.format, "mdf4");
}

TEST(what_is_not_given_is_the_standard)
{
    words[1] = "left over";
    assert_int_equal(PARSE("a.db"), MR_OK);
    assert_null(words[1]);
    assert_true(given.for_s == 60.0 && isnan(given.gap_in) && given.seeds == 4 && given.run == 0 &&
                !given.loud);
    assert_null(given.db);
    assert_null(given.format);
}

TEST(a_number_is_read_with_its_unit)
{
    assert_int_equal(PARSE("a.db", "--for", "2min", "--gap", "5 mm"), MR_OK);
    assert_near(given.for_s, 120.0, 1e-12);
    assert_near(given.gap_in, 5.0 / 25.4, 1e-12);
    assert_int_equal(PARSE("a.db", "--for", "1500ms", "--gap", "0.5"), MR_OK);
    assert_near(given.for_s, 1.5, 1e-12);
    assert_near(given.gap_in, 0.5, 0.0);
    /* a bare number is in millimetres then */
    assert_int_equal(PARSE_SI("a.db", "--for", "2", "--gap", "25.4"), MR_OK);
    assert_near(given.for_s, 2.0, 0.0);
    assert_near(given.gap_in, 1.0, 1e-12);
    assert_int_equal(PARSE_SI("a.db", "--gap", "0.25in"), MR_OK);
    assert_near(given.gap_in, 0.25, 1e-12);
    REFUSED("a length instead of a time: '3m' for --for; write s, ms, us, min, h or d", "a.db",
            "--for", "3m"); /* metres */
    REFUSED("a time instead of a length: '3s' for --gap; write ft, in, mm, cm or m", "a.db",
            "--gap", "3s");
    REFUSED("out of range: 3h for --for; allowed: 0.5 to 7200 s", "a.db", "--for", "3h");
    assert_int_equal(PARSE_SI("a.db", "--gap", "300"), MR_USAGE);
    assert_non_null(strstr(error.text, "allowed: 0 to 254 mm"));
}

TEST(nonsense_is_refused_in_a_line)
{
    REFUSED("unknown option: '--bd' of try; see matrig try --help", "a.db", "--bd", "b.db");
    REFUSED(
        "option in the wrong place: '--json' after try; put the option before the command: matrig "
        "--json try",
        "a.db", "--json");
    REFUSED("unknown option: '--version' of try", "a.db", "--version");
    REFUSED("option given twice: --db of try", "a.db", "--db", "b", "--db", "c");
    /* also when it is no text */
    REFUSED("option given twice: --for of try", "a.db", "--for", "1", "--for", "2");
    REFUSED("option without its value: --db of try", "a.db", "--db");
    REFUSED("option without its value: --db of try", "a.db", "--db", "--db");
    REFUSED("option takes no value: '--loud=1' of try", "a.db", "--loud=1");
    REFUSED("argument missing: matrig try needs DB [RUN]", "--loud");
    REFUSED("unexpected argument: 'c' of try", "a", "b", "c");
    REFUSED("not a number: 'x' for --for", "a.db", "--for", "x");
    REFUSED("not a number: 'inf' for --for", "a.db", "--for", "inf");
    REFUSED("not a number: 'nan' for --gap", "a.db", "--gap", "nan");
    REFUSED("out of range: 0 for --for", "a.db", "--for", "0");
    REFUSED("not a whole number: '2.5' for -n", "a.db", "-n", "2.5");
    REFUSED("out of range: 10 for -n; allowed: 1 to 9", "a.db", "-n10");
    REFUSED("not a RUN: '1.5' for --run", "a.db", "--run", "1.5");
    REFUSED("not a RUN: '0' for --run", "a.db", "--run", "0");
    REFUSED("unknown format: 'cs' for --format; give csv, candump or mdf4", "a.db", "--format",
            "cs");
}

TEST(options_stand_before_the_command)
{
    const char *const line[] = {"matrig", "--json", "--si", "log", "--quiet"};
    struct global_options before = {.help = false};
    error = (struct error){0};
    assert_int_equal(command_parse_global_options(5, (char **)line, &before, &error), 3);
    assert_true(before.cli.json && before.cli.si && !before.cli.quiet && !before.help);
    const char *const help[] = {"matrig", "-h", "--no-such-option"};
    assert_int_equal(command_parse_global_options(3, (char **)help, &before, &error), 2);
    assert_true(before.help && error.status == MR_OK);
    const char *const wrong[] = {"matrig", "--jsn", "log"};
    before.help = false;
    command_parse_global_options(3, (char **)wrong, &before, &error);
    assert_string_equal(error.text,
                        "unknown option: '--jsn'; did you mean --json? see matrig --help");
}

TEST(help_has_the_rows)
{
    char *text = help_page_text(&command);
    assert_string_equal(text, "  DB             a file\n"
                              "  --db DB        another; of 0\n"
                              "  --for S        from 0.5 to 7200; else 60 (unit: s)\n"
                              "  --gap IN       a gap (unit: in, with --si mm)\n"
                              "  -n N           so many\n"
                              "  --run RUN      of one\n"
                              "  --format F     how\n"
                              "  --loud         be so\n");
    free(text);
}

/* ---- every command ---- */

/* Characters of the option that text begins with; 0: with none. */
static size_t option_length(const char *at)
{
    size_t dashes = strspn(at, "-"), length = dashes;
    if (dashes == 0 || dashes > 2 || !isalpha((unsigned char)at[dashes]))
        return 0;
    while (isalnum((unsigned char)at[length]) ||
           (at[length] == '-' && isalnum((unsigned char)at[length + 1])))
        length++;
    return dashes == 1 && length > 2 ? 0 : length;
}

struct search {
    const char *name;
    size_t length;
    bool found;
};

static void same_option(void *context, const struct command_part *part)
{
    struct search *search = context;
    const char *name = part->option.name;
    search->found |= name && strlen(name) == search->length &&
                     memcmp(name, search->name, search->length) == 0;
}

static bool takes(const struct command *c, const char *name, size_t length)
{
    struct search search = {name, length, false};
    help_for_each_part(c, same_option, &search);
    return search.found;
}

/* "see matrig ready --help", "the page of matrig log --live": another command's option, said with
 * its name. */
static bool of_another(const char *text, const char *name, size_t length)
{
    for (size_t i = 0; i < command_table.count; i++) {
        char named[40];
        snprintf(named, sizeof named, "matrig %s", command_table.commands[i].command->name);
        if (strstr(text, named) && takes(command_table.commands[i].command, name, length))
            return true;
    }
    return takes(&command_matrig, name, length); /* before every command */
}

/* "ssh -L": another program's. */
static bool of_a_program(const char *text, const char *at)
{
    static const char *const programs[] = {"ssh ", "candump "};
    for (size_t i = 0; i < COUNT_OF(programs); i++) {
        size_t length = strlen(programs[i]);
        if ((size_t)(at - text) >= length && memcmp(at - length, programs[i], length) == 0)
            return true;
    }
    return false;
}

static void speaks_of_its_own(const struct command *c, const char *text)
{
    for (const char *at = text; *at; at++) {
        size_t length = at == text || !isalnum((unsigned char)at[-1]) ? option_length(at) : 0;
        if (length == 0 || (at > text && at[-1] == '-') || of_a_program(text, at))
            continue;
        if (!takes(c, at, length) && !of_another(text, at, length))
            fail_msg("matrig %s does not take %.*s, of which its help speaks: %s", c->name,
                     (int)length, at, text);
    }
}

TEST(no_text_speaks_of_an_option_that_is_not_taken)
{
    for (size_t i = 0; i < command_table.count; i++) {
        const struct command *c = command_table.commands[i].command;
        struct help_page page = help_page_make(c);
        speaks_of_its_own(c, c->usage);
        for (size_t r = 0; r < page.row_count; r++) {
            speaks_of_its_own(c, page.row[r].text);
            if (page.row[r].term)
                speaks_of_its_own(c, page.row[r].term);
        }
        help_page_free(&page);
    }
}

static void sound_rows(const struct command *c)
{
    for (size_t i = 0; i < c->part_count; i++) {
        const struct command_option *o = &c->parts[i].option;
        if (c->parts[i].included)
            sound_rows(c->parts[i].included);
        for (size_t k = 0; o->name && k < i; k++) {
            if (c->parts[k].option.name && strcmp(c->parts[k].option.name, o->name) == 0)
                fail_msg("matrig %s has %s twice", c->name, o->name);
        }
        bool number = o->kind == OPTION_IS_NUMBER || o->kind == OPTION_IS_INTEGER;
        if (o->name && option_length(o->name) != strlen(o->name))
            fail_msg("matrig %s: %s is no name of an option", c->name, o->name);
        if (o->name && (o->argument == NULL) != (o->kind == OPTION_IS_FLAG))
            fail_msg("matrig %s: a flag alone has no value: %s", c->name, o->name);
        if (number && !(o->low < o->high))
            fail_msg("matrig %s: %s has no range", c->name, o->name);
        /* 0, NaN and infinity say that it was not given */
        if (number && o->default_value != 0.0 && isfinite(o->default_value) &&
            !(o->default_value >= o->low && o->default_value <= o->high))
            fail_msg("matrig %s: the standard of %s is outside its range", c->name, o->name);
    }
}

TEST(rows_are_sound)
{
    for (size_t i = 0; i < command_table.count; i++) {
        const struct command *c = command_table.commands[i].command;
        char example[60], *page = help_page_text(c);
        sound_rows(c);
        assert_true(c->operands.min <= c->operands.max);
        snprintf(example, sizeof example, "matrig %s ", c->name);
        const char *at = strstr(page, "Example:");
        if (!at || !strstr(at, example))
            fail_msg("matrig %s has no example", c->name);
        free(page);
    }
}
