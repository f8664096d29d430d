/* The command matrig import: imports data of other programs into the campaign. */
#include <stdio.h>
#include <string.h>

#include "host/analyse/summary.h"
#include "host/base/answer.h"
#include "host/base/output.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/exchange/import.h"
#include "host/link/link.h"

/* Prints the imported landings. */
static enum mr_status add_landings(struct store *store, const struct import_result *result,
                                   struct answer *answer, struct error *error)
{
    for (size_t i = 0; i < result->run_count && error->status == MR_OK; i++) {
        struct store_landing landing;
        int64_t frames = 0;
        char label[30], counted[40] = "";
        if (store_landing_get(store, result->runs[i], &landing, error) != MR_OK ||
            store_frames_count(store, result->runs[i], LINK_CAN, &frames, error) != MR_OK)
            break;
        snprintf(label, sizeof label, "RUN %lld", (long long)result->runs[i]);
        if (frames)
            snprintf(counted, sizeof counted, ", %lld frames", (long long)frames);
        answer_add_text(answer, NULL, label, "landing %lld, %s, board %s%s",
                        (long long)landing.board_landing,
                        mr_landing_state_text((unsigned)landing.state),
                        landing.board_uid[0] ? landing.board_uid : "unknown", counted);
    }
    if (result->run_count == 0)
        answer_add_sentence(answer, NULL, "the file contains no landing");
    return error->status;
}

static enum mr_status add_result(struct store *store, const struct import_request *request,
                                 const struct store_import *row, const struct import_result *result,
                                 struct answer *answer, struct error *error)
{
    char troubles[400];
    answer_add_text(answer, "file", NULL, "%s", request->path);
    answer_add_text(answer, NULL, "file", "%s", row->file);
    answer_add_text(answer, "verdict", "verdict", "%s", row->verdict);
    answer_add_count(answer, "rows", "imported", (int64_t)result->row_count)->suffix =
        strcmp(row->format, "csv") == 0 ? " rows" : " frames";
    answer_add_text(answer, "sha256", "sha256", "%s", row->sha256);
    answer_add_text(answer, "format", NULL, "%s", row->format);
    answer_add_count(answer, "session", NULL, result->session);
    answer_add_text_or_missing(answer, "bus", row->bus[0] ? "bus" : NULL,
                               row->bus[0] ? row->bus : NULL, NULL);
    answer_add_count(answer, "other_interfaces",
                     result->other_interface_frames ? "other buses" : NULL,
                     (int64_t)result->other_interface_frames)
        ->suffix = " frames, left out";
    answer_add_count(answer, "foreign", result->counts.foreign ? "foreign" : NULL,
                     result->counts.foreign)
        ->suffix = " frames of other devices, stored as raw frames";
    if (result->counts.foreign && result->run_count == 0)
        answer_add_sentence(answer, NULL,
                            "the log has no landing of a board at base 0x%03x; to read a different "
                            "board, use --base B",
                            request->can_base);
    answer_add_count(answer, "lost", result->counts.lost ? "lost" : NULL, result->counts.lost)
        ->suffix = " frames lost, according to the counters of the board";
    summary_format_link_errors(result->link_fault_count, troubles, sizeof troubles);
    answer_add_json(answer, "troubles", summary_link_errors_to_json(result->link_fault_count));
    if (troubles[0])
        answer_add_text(answer, NULL, "CAN link", "%s", troubles);
    answer_open_list(answer, "runs", NULL);
    for (size_t i = 0; i < result->run_count; i++)
        answer_add_count(answer, NULL, NULL, result->runs[i]);
    answer_close_group(answer);
    return add_landings(store, result, answer, error);
}

static enum mr_status refuse_repeated_import(struct store *store, const struct store_import *row,
                                             const struct import_request *request, bool again,
                                             struct error *error)
{
    int64_t session = 0;
    enum mr_status status = store_import_find(store, row, request->can_base, &session, error);
    if (status == MR_OK && session && !again)
        status = error_set(error, MR_USAGE,
                           "session %lld of %s already contains this file: %s; to import the file "
                           "again, use --again",
                           (long long)session, store_path(store), request->path);
    return status;
}

/* Reads the whole file of another instrument before a campaign is opened. A candump log is only
 * checked here. */
static enum mr_status import_readings(const struct textfile *file,
                                      const struct import_request *request, struct mapping *mapping,
                                      struct import_result *result, struct error *error)
{
    if (!mapping->json_text)
        return import_candump_check(file, request, result, error);
    return mapping->reads_signals ? import_read_signals(file, request, mapping, result, error)
                                  : csv_read(file->text, file->length, request->path, mapping,
                                             &result->row_count, &result->parsed, error);
}

/* Imports the data and stores what it was imported from. If a log has an invalid line, the data
 * before the line is kept. */
static enum mr_status import_file(struct store *store, const struct textfile *file,
                                  const struct import_request *request, struct mapping *mapping,
                                  struct store_import *row, bool again,
                                  struct import_result *result, struct error *error)
{
    snprintf(row->bus, sizeof row->bus, "%s", result->bus);
    enum mr_status status = store_begin(store, error)
                              ?: refuse_repeated_import(store, row, request, again, error)
                              ?: (mapping->json_text
                                      ? import_landing(store, mapping, request, result, error)
                                      : import_candump(store, file, request, result, error));
    if (result->session == 0)
        return status;
    struct error late = {0};
    row->made_us = (int64_t)link_now_us();
    parse_result_text(&result->parsed, row->verdict, sizeof row->verdict);
    if (status != MR_OK)
        snprintf(row->verdict, sizeof row->verdict, "given up: %.250s", error->text);
    if (store_import_put(store, result->session, row, &late) != MR_OK ||
        store_commit(store, &late) != MR_OK)
        status = error_set(error, late.status, "%s", late.text);
    return status;
}

/* Finds the kind of the file and records its name, size and checksum. */
static enum mr_status describe_import(const struct textfile *file,
                                      const struct import_request *request, const char *map,
                                      struct mapping *mapping, struct store_import *row,
                                      struct error *error)
{
    snprintf(row->file, sizeof row->file, "%s", request->path);
    snprintf(row->sha256, sizeof row->sha256, "%s", file->sha256);
    row->bytes = (int64_t)file->length;
    if (map) {
        struct textfile text;
        if (textfile_open(map, &text, error) == MR_OK)
            mapping_parse(text.text, text.length, map, mapping, error);
        textfile_close(&text);
        if (error->status != MR_OK)
            return error->status;
    }
    bool csv = mapping->json_text && !mapping->reads_signals;
    row->mapping = mapping->json_text;
    snprintf(row->format, sizeof row->format, "%s",
             csv                  ? "csv"
             : mapping->json_text ? "signals"
                                  : "candump");
    if (request->template_run && !mapping->json_text)
        return error_set(error, MR_USAGE,
                         "--like works only with readings of other instruments: %s is a log of a "
                         "matrig board; leave --like out",
                         request->path);
    if (request->can_base && (csv || map))
        return error_set(error, MR_USAGE,
                         "--base works only with logs of a matrig board: %s is from a different "
                         "instrument; leave --base out",
                         request->path);
    if (request->interface && csv)
        return error_set(
            error, MR_USAGE,
            "--interface works only with candump logs: %s is a table; leave --interface out",
            request->path);
    return MR_OK;
}

struct request {
    const char *map, *base;
    bool again;
    struct import_request readings;
};

static int import_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2];
    struct request r = {.readings.cli = cli};
    struct import_request *request = &r.readings;
    struct error error = {0}, unread = {0};
    struct store *store = NULL;
    struct textfile file = {0};
    struct mapping mapping = {0};
    struct import_result result = {0};
    struct store_import row = {0};
    bool is_new = false;
    command_parse(&command_import, argc, argv, cli, &r, words, &error);
    request->path = words[1];
    if (error.status == MR_OK)
        output_check_file_format(request->path, "log", &error);
    (void)(error.status == MR_OK &&
           (!r.base ||
            link_parse_base_number(r.base, "--base", &request->can_base, &error) == MR_OK) &&
           textfile_open(request->path, &file, &error) == MR_OK &&
           describe_import(&file, request, r.map, &mapping, &row, &error) == MR_OK &&
           import_readings(&file, request, &mapping, &result, &error) == MR_OK &&
           (is_new = program_is_new_campaign(words[0]),
            store_open(words[0], STORE_CREATE, &store, &error)) == MR_OK &&
           store_find_run(store, &request->template_run, &error) == MR_OK &&
           import_file(store, &file, request, &mapping, &row, r.again, &result, &error));
    if (is_new && store)
        program_note_new_campaign(cli, words[0]);
    enum mr_status status = error.status;
    bool told = cli->json ? result.session != 0 : status == MR_OK;
    struct answer *answer = answer_new(cli->si);
    if (told && add_result(store, request, &row, &result, answer, &unread) != MR_OK &&
        status == MR_OK)
        status = error_set(&error, unread.status, "%s", unread.text);
    if (status == MR_OK && result.parsed.status != MR_OK)
        status = error_set(&error, result.parsed.status, "%s: %s; the valid part was imported",
                           row.verdict, request->path);
    int exit_code = status != MR_OK ? cli_fail(&error) : 0;
    if (told)
        exit_code = answer_print(cli, answer, exit_code);
    else
        answer_free(answer);
    mapping_free(&mapping);
    textfile_close(&file);
    store_close(store);
    return exit_code;
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB", "campaign database; created if missing"),
    HELP_ITEM("FILE", "a candump -L log of a matrig board, imported like a live log; with --map, a "
                      "file of a different instrument"),
    OPTION_TEXT(
        "--map", "M.json", map,
        "import a table of a different instrument (CSV), or its frames in a candump log, as a "
        "landing. M names the columns:\n  {\"separator\": \";\", \"decimal\": \",\", "
        "\"header_lines\": 2, \"comment\": \"#\", \"missing\": [\"---\"],\n   \"time\": "
        "{\"column\": \"Zeit\", \"unit\": \"ms\", \"shift_s\": 0.25},\n   \"align\": {\"column\": "
        "\"Trigger\", \"threshold\": 2.5, \"edge\": \"falling\", \"switch\": 3},\n   \"channels\": "
        "[{\"column\": \"Weg 1\", \"channel\": \"d1\", \"unit\": \"mm\", \"scale\": 2.5, "
        "\"offset\": -1,\n                 \"station_ft\": 40, \"error\": 0.05}]}\n  header_lines: "
        "lines above the rows; blank lines count, comments do not\n  column: name of the column, "
        "or its number from 1\n  channel: d1 to d8 (in, mm, cm, m, ft), t1 to t14 (lb, N, kN, "
        "kip),\n    gear (position of the gear, in ft, m, in or mm; matrig generates an edge "
        "where it\n    passes a switch), switch1 to switch64 (with threshold and edge)\n  scale, "
        "offset: value = (number in the file * scale + offset) in "
        "unit; error: standard error\n  unit of times: s, ms, us, min\nOptional: touchdown_ft, "
        "switch_error_ft, note, gap_s (a longer gap is missing data; default: 1.5 times the usual "
        "step), last_line_open (true: the last line needs no newline). For frames, replace column "
        "by:\n  \"id\": \"0x321\", \"start_bit\", \"bits\", \"signed\", \"float\", \"byte_order\""),
    OPTION_RUN(
        "--like", "RUN", readings.template_run,
        "the file has readings of the same landing as RUN: gear, switches, survey and stations are "
        "copied from RUN. Time 0 of the file is the touchdown of RUN, unless `align` gives an "
        "edge"),
    OPTION_TEXT("--base", "B", base, "CAN base of the board, such as 0x190; default: 0"),
    OPTION_TEXT("--interface", "I", readings.interface,
                "bus to read if the log contains several buses, such as can1"),
    OPTION_FLAG("--again", again, "import a file that was already imported"),
    HELP_NOTE("The output states whether the file is complete, truncated or malformed (with line "
              "and column; exit 4). The valid part is imported."),
    HELP_EXAMPLE("matrig import campaign.db candump-2026-05-04.log\n"
                 "         matrig import campaign.db lvdt.csv --map lvdt.json --like 5"),
};

const struct command command_import = {
    "import",
    import_command,
    "DB FILE [--map M.json] [--like RUN] [--base B] [--interface I] [--again]",
    "import logs, or readings of other instruments, into a campaign",
    COMMAND_PARTS(parts),
    {2, 2, "DB FILE"},
};
