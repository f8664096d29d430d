/* The command matrig report: writes the campaign as one HTML page with plots. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/base/output.h"
#include "host/report/report.h"

/* Writes the default path of the page: demo/campaign.html for demo/campaign.db. */
static void make_default_path(const char *db, char *out, size_t size)
{
    const char *slash = strrchr(db, '/');
    const char *dot = strrchr(db, '.');
    int stem = dot && (!slash || dot > slash + 1) ? (int)(dot - db) : (int)strlen(db);
    snprintf(out, size, "%.*s.html", stem, db);
}

struct request {
    const char *path;
    int64_t run; /* 0: all landings */
    bool include_voided;
};

static int report_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[1];
    struct request r = {0};
    char made_path[1000];
    struct report report = {.si = cli->si};
    struct output output;
    command_parse(&command_report, argc, argv, cli, &r, words, fatal);
    report.path = words[0];
    report.run = r.run;
    if (!r.path) {
        make_default_path(words[0], made_path, sizeof made_path);
        r.path = made_path;
    }
    output_check(r.path, words[0], fatal);
    report.store = program_open_campaign(words[0], STORE_READ);
    store_find_run(report.store, &report.run, fatal);
    if (report.run)
        store_check_not_void(report.store, report.run, r.include_voided, fatal);
    report_begin(&report, r.include_voided, fatal);
    /* the file is created only when the page is complete */
    output_begin(&output, r.path, fatal);
    report_write_page(&report, output.file, fatal);
    output_end(&output, fatal);
    size_t landings = report.landings;
    report_free(&report);
    if (cli->json)
        return cli_print_json(json_pack("{sssI}", "file", r.path, "landings", (json_int_t)landings),
                              0);
    cli_note(cli, "%zu landing%s in %s", landings, landings == 1 ? "" : "s", r.path);
    return 0;
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database"),
    OPTION_TEXT("-o", "F.html", path, "file to write; default: the campaign's name with .html"),
    OPTION_RUN("--run", "RUN", run, "report only this landing"),
    OPTION_FLAG("--void", include_voided, "include voided landings (matrig landing)"),
    HELP_NOTE("Print the page, or save it as PDF, in the browser. The first page names the command "
              "that adds each missing entry (date, place, operator, ...)."),
    HELP_EXAMPLE("matrig report campaign.db -o report.html"),
};

const struct command command_report = {
    "report",
    report_command,
    "DB [-o F.html] [--run RUN] [--void]",
    "write the report of the campaign as one web page, with plots",
    COMMAND_PARTS(parts),
    {1, 1, "DB"},
};
