/* The command matrig export: writes one landing in the formats of other programs. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "host/analyse/track.h"
#include "host/analyse/measured_load.h"
#include "host/commands/commands.h"
#include "host/commands/program.h"
#include "host/exchange/export.h"
#include "host/link/link.h"
#include "host/base/output.h"
#include "host/base/command.h"
#include "host/base/units.h"
#include "host/base/xmalloc.h"

/* ---- csv ---- */

static const char *get_emulated_note(const struct store_landing *landing)
{
    return measured_is_emulated(landing) ? " (emulated, synthetic data)" : "";
}

static void write_csv_provenance(const struct measured_landing *measured, bool si, FILE *out)
{
    char source[MEASURED_SOURCE_SIZE];
    const struct store_landing *landing = &measured->landing;
    fprintf(out, "# matrig landing: RUN %lld, landing %lld of board %s%s, firmware %s\n",
            (long long)landing->id, (long long)landing->board_landing, landing->board_uid,
            get_emulated_note(landing), landing->firmware);
    measured_format_source(measured, source);
    fprintf(out, "# readings from %s\n", source);
    char torn[MEASURED_MISSING_START_SIZE];
    measured_format_missing_start(measured, torn);
    if (torn[0])
        fprintf(out, "# %s\n", torn);
    if (!measured->has_calibration_dates)
        fputs("# calibration unknown: the configuration of the board was not read\n", out);
    else if (measured->is_uncalibrated)
        fputs("# UNCALIBRATED: sensors without a calibration date\n", out);
    fprintf(out,
            "# t_s: seconds since %s, middle of the 1 ms block; board time of t_s = 0: %.6f s\n",
            measured_origin_text(measured), (double)measured->t0_us / 1e6);
    fprintf(out,
            "# displacement relative to its mean over the %s, downfield "
            "positive; tension as measured\n",
            measured->is_start_missing || measured->gate_count == 0
                ? "first 0.5 s"
                : "0.5 s before the first edge");
    fputs("# validity: one character per channel in the order of the columns: ", out);
    for (unsigned validity = MR_VALID; validity < MR_VALIDITY_COUNT; validity++)
        fprintf(out, "%u %s, ", validity, mr_validity_text(validity));
    fputs("n: reading not valid, L: block lost; an empty cell is a missing value\n", out);
    fputs("# source: one character per channel: S serial, B black box, C CAN (each value is a mean "
          "over 2 blocks for displacements, 4 for tensions, and is repeated), - none\n",
          out);
    fprintf(out, "# units: %s, s, %s, %s, %s\n", unit_get(UNIT_STATION, si)->text,
            unit_get(UNIT_SPEED, si)->text, unit_get(UNIT_DISPLACEMENT, si)->text,
            unit_get(UNIT_TENSION, si)->text);
}

/* Writes two standard errors per channel (common/channels.h): of a single reading at the peak, and
 * of the peak value. */
static void write_csv_errors(const struct measured_landing *measured,
                             const struct measured_channel **channels, size_t count, bool si,
                             FILE *out)
{
    fputs("# standard error of one reading at the peak, and of the peak (noise averaged):", out);
    for (size_t c = 0; c < count; c++) {
        const struct measured_channel *channel = channels[c];
        bool moves = channel->config.kind == MR_KIND_DISPLACEMENT;
        double factor = unit_get(moves ? UNIT_DISPLACEMENT : UNIT_TENSION, si)->factor;
        double single = measured_standard_error(measured, channel, channel->peak, 1.0);
        if (!isnan(single))
            fprintf(out, " %c%u %.*f %.*f", moves ? 'd' : 't', channel->config.number,
                    moves ? 5 : 3, single * factor, moves ? 5 : 3, channel->peak_error * factor);
    }
    fputc('\n', out);
}

static void write_csv_cell(FILE *out, double value, int digits)
{
    if (isnan(value))
        fputc(',', out);
    else /* do not print "-0.000" */
        fprintf(out, ",%.*f", digits, fabs(value) * pow(10.0, digits) < 0.5 ? 0.0 : value);
}

static void write_csv_row(const struct measured_landing *measured,
                          const struct measured_channel **channels, size_t count, size_t sample,
                          bool si, FILE *out)
{
    char validity[MR_CHANNELS + 1], source[MR_CHANNELS + 1];
    double t_s = measured_time_s(measured, sample);
    double error_ft_s;
    double speed_ft_s = measured_speed_ft_s(measured, t_s, &error_ft_s);
    fprintf(out, "%.7f,%lld", t_s, (long long)(measured->first_block + (int64_t)sample));
    write_csv_cell(out, measured_station_ft(measured, t_s) * unit_get(UNIT_STATION, si)->factor, 4);
    write_csv_cell(out, speed_ft_s * unit_get(UNIT_SPEED, si)->factor, 4);
    for (size_t c = 0; c < count; c++) {
        bool moves = channels[c]->config.kind == MR_KIND_DISPLACEMENT;
        const struct unit *unit = unit_get(moves ? UNIT_DISPLACEMENT : UNIT_TENSION, si);
        write_csv_cell(out, measured_value(channels[c], sample) * unit->factor, moves ? 5 : 3);
        uint8_t v = channels[c]->validity[sample];
        validity[c] = (char)(v == MEASURED_MISSING ? 'L' : v == MEASURED_INVALID ? 'n' : '0' + v);
        source[c] = measured_source_letter((enum measured_source)channels[c]->source[sample]);
    }
    validity[count] = source[count] = '\0';
    fprintf(out, ",%s,%s\n", validity, source);
}

static void export_csv(struct store *store, int64_t run, FILE *out, const struct cli *cli,
                       long *rows)
{
    struct measured_landing measured;
    const struct measured_channel *channels[MR_CHANNELS];
    measured_load(store, run, &measured, fatal);
    if (measured.source == MEASURED_NO_SOURCE)
        error_set(fatal, MR_USAGE,
                  "no readings: RUN %lld of %s; the landing was cancelled before its first "
                  "reading; export a different landing",
                  (long long)run, store_path(store));
    size_t count = measured_list_channels(&measured, channels);
    write_csv_provenance(&measured, cli->si, out);
    write_csv_errors(&measured, channels, count, cli->si, out);
    fprintf(out, "t_s,block,gear_%s,speed_%s", unit_get(UNIT_STATION, cli->si)->suffix,
            unit_get(UNIT_SPEED, cli->si)->suffix);
    for (size_t c = 0; c < count; c++) {
        bool moves = channels[c]->config.kind == MR_KIND_DISPLACEMENT;
        fprintf(out, ",%c%u_%s", moves ? 'd' : 't', channels[c]->config.number,
                unit_get(moves ? UNIT_DISPLACEMENT : UNIT_TENSION, cli->si)->suffix);
    }
    fputs(",validity,source\n", out);
    for (size_t i = 0; i < measured.samples; i++)
        write_csv_row(&measured, channels, count, i, cli->si, out);
    *rows = (long)measured.samples;
    measured_free(&measured);
}

/* ---- film frames ---- */

static void write_film_csv(const struct measured_landing *measured, const struct film *film,
                           bool si, FILE *out)
{
    const struct unit *station = unit_get(UNIT_STATION, si), *speed = unit_get(UNIT_SPEED, si);
    const struct store_landing *landing = &measured->landing;
    fprintf(
        out,
        "# matrig film: RUN %lld, landing %lld of board %s%s, %.4f frames a second, %lld missing\n",
        (long long)landing->id, (long long)landing->board_landing, landing->board_uid,
        get_emulated_note(landing), film->rate_hz, (long long)film->missing_frame_count);
    fprintf(out, "# t_s: seconds since %s; board_s: since the board's scans began\n",
            measured_origin_text(measured));
    fputs("# gear: position of the main bogie's lead wheel, from the switches (speed: from the "
          "fit); errors are standard errors; an empty cell is an unknown value\n",
          out);
    fprintf(out, "frame,pulse,board_s,t_s,gear_%s,gear_error_%s,speed_%s,speed_error_%s\n",
            station->suffix, station->suffix, speed->suffix, speed->suffix);
    for (size_t i = 0; i < film->frame_count; i++) {
        const struct film_frame *frame = &film->frame[i];
        fprintf(out, "%lld,%lld,%.7f,%.7f", (long long)frame->number,
                (long long)frame->board_pulse_count, frame->board_us / 1e6, frame->t_s);
        write_csv_cell(out, frame->station_ft.value * station->factor, 5);
        write_csv_cell(out, frame->station_ft.error * station->factor, 5);
        write_csv_cell(out, frame->speed_ft_s.value * speed->factor, 4);
        write_csv_cell(out, frame->speed_ft_s.error * speed->factor, 4);
        fputc('\n', out);
    }
}

static void export_film(struct store *store, int64_t run, FILE *out, const struct cli *cli,
                        long *rows)
{
    struct measured_landing measured;
    struct film film = {0};
    measured_load(store, run, &measured, fatal);
    film_load(store, &measured, &film, fatal);
    if (film.frame_count == 0)
        error_set(fatal, MR_USAGE,
                  "no film: RUN %lld of %s has no frame pulses; set site.camera to 1 in the "
                  "board's configuration and wire the camera to PE2 and PB3",
                  (long long)run, store_path(store));
    *rows = (long)film.frame_count;
    write_film_csv(&measured, &film, cli->si, out);
    film_free(&film);
    measured_free(&measured);
}

struct request {
    const char *format, *path, *base;
    uint16_t can_base;
};

/* Writes the whole export to memory first, so that a failure leaves the old file unchanged. `store`
 * is NULL for the message catalogue, for which no landing is needed. */
static void write_export(struct store *store, int64_t run, const struct request *r,
                         const struct cli *cli, long *rows)
{
    char *text = NULL;
    size_t length = 0;
    FILE *made = xopen_memstream(&text, &length);
    if (!store)
        *rows = (long)dbc_write(made, r->can_base);
    else if (strcmp(r->format, "candump") == 0)
        export_candump(store, run, made, cli, rows, fatal);
    else if (strcmp(r->format, "frames") == 0)
        export_film(store, run, made, cli, rows);
    else if (strcmp(r->format, "mdf4") == 0)
        export_mdf4(store, run, made, cli, rows, fatal);
    else
        export_csv(store, run, made, cli, rows);
    fclose(made);
    output_write_bytes(r->path, text, length, fatal);
    free(text);
}

/* Finds the format of a file extension; NULL: unknown. */
static const char *find_format_by_extension(const char *path)
{
    static const char *const endings[][2] = {
        {".csv", "csv"},
        {".mf4", "mdf4"},
        {".dbc", "dbc"},
        {".log", "candump"},
    };
    const char *dot = path ? strrchr(path, '.') : NULL;
    for (size_t i = 0; dot && i < sizeof endings / sizeof endings[0]; i++)
        if (strcasecmp(dot, endings[i][0]) == 0)
            return endings[i][1];
    return NULL;
}

/* Determines the format from --format or the file extension. Refuses the command if the two
 * contradict each other. Film frames have the extension of CSV. */
static void find_format(struct request *r)
{
    const char *ending = find_format_by_extension(r->path);
    bool table = ending && strcmp(ending, "csv") == 0;
    if (!r->format)
        r->format = ending;
    else if (ending && strcmp(ending, r->format) != 0 &&
             !(table && strcmp(r->format, "frames") == 0))
        error_set(fatal, MR_USAGE,
                  "format and file extension differ: '%s' for --format %s; give only one of them",
                  r->path, r->format);
}

/* Refuses missing or extra operands: every format except dbc needs DB RUN. */
static void check_operands(const struct request *r, bool dbc, const char *const words[2])
{
    if (!r->format)
        error_set(fatal, MR_USAGE,
                  "no format: matrig export needs --format csv, candump, dbc, frames or "
                  "mdf4; see matrig export --help");
    if (dbc && words[0])
        error_set(fatal, MR_USAGE, "unexpected argument: '%s'; --format dbc takes no landing",
                  words[0]);
    if (!dbc && r->base)
        error_set(fatal, MR_USAGE, "--base works only with --format dbc; leave --base out");
    if (!dbc && !words[1])
        error_set(fatal, MR_USAGE,
                  "argument missing: export needs DB RUN; see matrig export --help");
}

static int export_command(int argc, char **argv, const struct cli *cli)
{
    const char *words[2];
    struct request r = {0};
    struct store *store = NULL;
    int64_t run = 0;
    long rows = 0;
    struct store_landing landing;
    command_parse(&command_export, argc, argv, cli, &r, words, fatal);
    find_format(&r);
    bool dbc = r.format && strcmp(r.format, "dbc") == 0;
    check_operands(&r, dbc, words);
    if (cli->json && !r.path)
        error_set(fatal, MR_USAGE,
                  "no output file: matrig --json export needs -o F, because standard output "
                  "carries the JSON");
    if (!r.path && strcmp(r.format, "mdf4") == 0 && isatty(STDOUT_FILENO))
        error_set(fatal, MR_USAGE,
                  "binary data on a terminal: matrig export --format mdf4; give -o F, or write to "
                  "a pipe");
    if (r.base)
        link_parse_base_number(r.base, "--base", &r.can_base, fatal);
    if (!dbc) {
        parse_run(words[1], &run, fatal);
        output_check(r.path, words[0], fatal);
        store = program_open_campaign(words[0], STORE_READ);
        store_find_run(store, &run, fatal);
        store_landing_get(store, run, &landing, fatal);
    }
    write_export(store, run, &r, cli, &rows);
    if (cli->json)
        return cli_print_json(json_pack("{sssssosI}", "file", r.path, "format", r.format, "run",
                                        dbc ? json_null() : json_integer(run), "rows",
                                        (json_int_t)rows),
                              0);
    return 0;
}

#define OPTION_VALUES struct request
static const struct command_part parts[] = {
    HELP_ITEM("DB RUN", "campaign database and number of a landing"),
    HELP_ITEM("--format dbc", "the CAN messages as a Vector DBC file (give no DB RUN)"),
    HELP_ITEM("--format csv", "time, gear position, displacements and tensions at 1 kHz"),
    HELP_ITEM("--format candump",
              "the CAN frames in the format of candump -L, with times of day from the board's "
              "clock; if unknown: board time plus 1000000000 s (a date in 2001)"),
    HELP_ITEM("--format frames",
              "one row per frame of the camera: time, position of the gear and its error"),
    HELP_ITEM("--format mdf4",
              "ASAM MDF 4.10: readings and gear at 1 kHz with units and invalidation bits, CAN "
              "frames as bus logging with the DBC attached"),
    OPTION_TEXT("-o", "F.csv, .mf4, .dbc or .log", path,
                "file to write; default: standard output. The extension selects the format"),
    OPTION_TEXT("--base", "B", base,
                "CAN base of the board, added to every identifier (dbc): 400 or 0x190"),
    HELP_EXAMPLE("matrig export campaign.db 5 --format csv -o landing5.csv\n"
                 "         matrig export --format dbc -o matrig.dbc"),
    OPTION_CHOICE("--format", "F", format, "format", "csv|candump|dbc|frames|mdf4", NULL),
};

const struct command command_export = {
    "export",
    export_command,
    "DB RUN --format csv|candump|frames|mdf4 [-o F]\n--format dbc [--base B] [-o F]",
    "export one landing, or the DBC, for other tools",
    COMMAND_PARTS(parts),
    {0, 2, "DB RUN"},
};
