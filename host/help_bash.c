/* Completion for bash. */
#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "host/help.h"

#define OPTIONS_MAX 48
#define NAME_MAX_BYTES 32
#define CHOICES_MAX 80

struct option {
    char name[NAME_MAX_BYTES];
    char choices[CHOICES_MAX]; /* "csv candump": its values; "" */
    bool value;                /* takes one */
};

struct found {
    struct option option[OPTIONS_MAX];
    size_t count;
    char words[200]; /* "list read free": words that come first in an alternative */
};

static size_t option_length(const char *at)
{
    size_t dashes = strspn(at, "-"), length = dashes;
    if (dashes == 0 || dashes > 2 || !isalpha((unsigned char)at[dashes]))
        return 0;
    while (isalnum((unsigned char)at[length]) || (at[length] == '-' && isalnum((unsigned char)at[length + 1])))
        length++;
    return dashes == 1 && length > 2 ? 0 : length;
}

static struct option *option_of(struct found *found, const char *name, size_t length)
{
    static const char *const global[] = {"--json", "--quiet", "--si"}; /* spoken of; they stand before the command */
    for (size_t i = 0; i < sizeof global / sizeof global[0]; i++) {
        if (strlen(global[i]) == length && memcmp(global[i], name, length) == 0)
            return NULL;
    }
    for (size_t i = 0; i < found->count; i++) {
        if (strlen(found->option[i].name) == length && memcmp(found->option[i].name, name, length) == 0)
            return &found->option[i];
    }
    if (found->count == OPTIONS_MAX || length >= NAME_MAX_BYTES)
        return NULL;
    struct option *option = &found->option[found->count++];
    *option = (struct option){0};
    memcpy(option->name, name, length);
    return option;
}

/* What follows an option: " LINK", " 'OPTIONS'" or " i/n" is a value, " csv|candump" a choice of values. */
static void take_value(struct option *option, const char *after)
{
    if (after[0] != ' ' || after[1] == ' ')
        return;
    after++;
    option->value = option->value || isupper((unsigned char)after[0]) || after[0] == '\'' || after[1] == '/';
    size_t length = strspn(after, "abcdefghijklmnopqrstuvwxyz0123456789-|");
    if (islower((unsigned char)after[0]) && memchr(after, '|', length) && length < CHOICES_MAX) {
        option->value = true;
        for (size_t i = 0; i < length; i++)
            option->choices[i] = (char)(after[i] == '|' ? ' ' : after[i]);
        option->choices[length] = '\0';
    }
}

static void take_options(struct found *found, const char *line, size_t length)
{
    for (const char *at = line; at < line + length; at++) {
        size_t name = at == line || strchr(" [|(", at[-1]) ? option_length(at) : 0;
        struct option *option = name > 0 ? option_of(found, at, name) : NULL;
        if (option)
            take_value(option, at + name);
        at += name > 0 ? name - 1 : 0;
    }
}

/* Lines that begin with an option. */
static void take_details(struct found *found, const char *details)
{
    for (const char *line = details; *line;) {
        size_t length = strcspn(line, "\n"), indent = strspn(line, " ");
        if (indent > 0 && line[indent] == '-')
            take_options(found, line, length);
        line += length + (line[length] == '\n');
    }
}

/* The first word of every alternative, when it stands for itself. */
static void take_words(struct found *found, const char *words)
{
    for (const char *at = words; at;) {
        at += strspn(at, " |\n");
        size_t length = strspn(at, "abcdefghijklmnopqrstuvwxyz-"), used = strlen(found->words);
        if (length > 1 && islower((unsigned char)at[0]) && (at[length] == ' ' || at[length] == '\0' || at[length] == '\n') &&
            used + length + 2 < sizeof found->words)
            snprintf(found->words + used, sizeof found->words - used, "%s%.*s", used > 0 ? " " : "", (int)length, at);
        const char *next = strstr(at, " | "), *wrapped = strstr(at, " |\n");
        at = !next || (wrapped && wrapped < next) ? wrapped : next;
    }
}

static void collect(struct found *found, const struct command *command)
{
    *found = (struct found){0};
    take_options(found, command->words, strlen(command->words));
    take_words(found, command->words);
    take_details(found, command->details);
    option_of(found, "--help", 6);
}

static void print_command(const struct command *command)
{
    struct found found;
    collect(&found, command);
    printf("    %s)\n        options='", command->name);
    for (size_t i = 0; i < found.count; i++)
        printf("%s%s", i > 0 ? " " : "", found.option[i].name);
    printf("'\n        words='%s'\n        case $prev in\n", found.words);
    for (size_t i = 0; i < found.count; i++) {
        if (found.option[i].choices[0])
            printf("        %s) values='%s' ;;\n", found.option[i].name, found.option[i].choices);
    }
    const char *between = "        ";
    for (size_t i = 0; i < found.count; i++) {
        if (!found.option[i].value || found.option[i].choices[0])
            continue;
        printf("%s%s", between, found.option[i].name);
        between = " | ";
    }
    puts(between[1] == '|' ? ") file=1 ;;\n        esac\n        ;;" : "        esac\n        ;;");
}

void help_bash(const struct command_table *table)
{
    puts("# bash completion for matrig; made by matrig help --bash\n"
         "_matrig()\n{\n"
         "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} command= options= words= values= file= i\n"
         "    COMPREPLY=()\n"
         "    for ((i = 1; i < COMP_CWORD; i++)); do\n"
         "        if [[ ${COMP_WORDS[i]} != -* ]]; then\n"
         "            command=${COMP_WORDS[i]}\n"
         "            break\n"
         "        fi\n"
         "    done\n"
         "    case $command in\n"
         "    '')\n        options='--json --quiet --si --version --help'");
    fputs("        words='help", stdout);
    for (size_t i = 0; i < table->count; i++)
        printf(" %s", table->commands[i].name);
    puts("'\n        ;;");
    fputs("    help)\n        options='--man --bash'\n        words='", stdout);
    for (size_t i = 0; i < table->count; i++)
        printf("%s%s", i > 0 ? " " : "", table->commands[i].name);
    puts("'\n        ;;");
    for (size_t i = 0; i < table->count; i++)
        print_command(&table->commands[i]);
    puts("    esac\n"
         "    if [[ $values ]]; then\n"
         "        words=$values\n"
         "    elif [[ $file ]]; then\n"
         "        return\n"
         "    elif [[ $cur == -* ]]; then\n"
         "        words=$options\n"
         "    fi\n"
         "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$cur\")\n"
         "}\n"
         "complete -o bashdefault -o default -F _matrig matrig");
}
