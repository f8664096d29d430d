/* Completion for bash. */
#include <stdio.h>
#include <string.h>

#include "host/base/help.h"
#include "host/base/help_page.h"

#define OPTIONS_MAX 48
#define WORDS_MAX   24

/* What a command takes, each once. */
struct offer {
    const struct command_option *option[OPTIONS_MAX];
    size_t options;
    const char *word[WORDS_MAX]; /* "config set F": its first word */
    size_t words;
};

static size_t word_length(const char *term)
{
    return strcspn(term, " ");
}

static void take_part(void *context, const struct command_part *part)
{
    struct offer *offer = context;
    const struct command_option *option = &part->option;
    bool there = false;
    for (size_t i = 0; i < offer->options && option->name; i++)
        there |= strcmp(offer->option[i]->name, option->name) == 0;
    for (size_t i = 0; i < offer->words && part->word; i++)
        there |= word_length(offer->word[i]) == word_length(part->term) &&
                 memcmp(offer->word[i], part->term, word_length(part->term)) == 0;
    if (option->name && !there && offer->options < OPTIONS_MAX)
        offer->option[offer->options++] = option;
    if (part->word && !there && offer->words < WORDS_MAX)
        offer->word[offer->words++] = part->term;
}

/* "csv|candump" as "csv candump". */
static void print_choices(const char *choices)
{
    for (const char *c = choices; *c; c++)
        putchar(*c == '|' ? ' ' : *c);
}

static void print_command(const struct command *command)
{
    struct offer offer = {.options = 0};
    help_each_part(command, take_part, &offer);
    printf("    %s)\n        options='", command->name);
    for (size_t i = 0; i < offer.options; i++)
        printf("%s ", offer.option[i]->name);
    fputs("--help'\n        words='", stdout);
    for (size_t i = 0; i < offer.words; i++)
        printf("%s%.*s", i > 0 ? " " : "", (int)word_length(offer.word[i]), offer.word[i]);
    puts("'\n        case $prev in");
    for (size_t i = 0; i < offer.options; i++) {
        if (!offer.option[i]->choices)
            continue;
        printf("        %s) values='", offer.option[i]->name);
        print_choices(offer.option[i]->choices);
        puts("' ;;");
    }
    const char *between = "        ";
    for (size_t i = 0; i < offer.options; i++) {
        if (!offer.option[i]->argument || offer.option[i]->choices)
            continue;
        printf("%s%s", between, offer.option[i]->name);
        between = " | ";
    }
    puts(between[1] == '|' ? ") file=1 ;;\n        esac\n        ;;" : "        esac\n        ;;");
}

void help_bash(const struct command_table *table)
{
    puts("# bash completion for matrig; made by matrig help --bash\n"
         "_matrig()\n{\n"
         "    local cur=${COMP_WORDS[COMP_CWORD]} prev=${COMP_WORDS[COMP_CWORD - 1]} command= "
         "options= words= values= file= i\n"
         "    COMPREPLY=()\n"
         "    for ((i = 1; i < COMP_CWORD; i++)); do\n"
         "        if [[ ${COMP_WORDS[i]} != -* ]]; then\n"
         "            command=${COMP_WORDS[i]}\n"
         "            break\n"
         "        fi\n"
         "    done\n"
         "    case $command in\n"
         "    '')");
    fputs("        options='", stdout);
    for (size_t i = 0; i < command_matrig.count; i++)
        printf("%s%s", i > 0 ? " " : "", command_matrig.parts[i].option.name);
    puts("'");
    fputs("        words='help", stdout);
    for (size_t i = 0; i < table->count; i++)
        printf(" %s", table->commands[i].command->name);
    puts("'\n        ;;");
    fputs("    help)\n        options='--bash'\n        words='", stdout);
    for (size_t i = 0; i < table->count; i++)
        printf("%s%s", i > 0 ? " " : "", table->commands[i].command->name);
    puts("'\n        ;;");
    for (size_t i = 0; i < table->count; i++)
        print_command(table->commands[i].command);
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
