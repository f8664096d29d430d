/* What was advised and warned of, and what came of it by measurement: sums, then a row for each
 * landing. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "host/analyse/record.h"
#include "host/base/html.h"
#include "host/base/units.h"
#include "host/report/report.h"

static void advice_cells(const struct record_row *row, FILE *out)
{
    if (!row->advised)
        html_cell(out, "%s", "none");
    else
        html_cell(out, "%s%s", row->advice.verdict, row->off_plan ? ", landed otherwise" : "");
    html_number(out, row->advised ? 100.0 * row->advice.zone : (double)NAN, 0);
}

static void board_cells(const struct record_row *row, double station, FILE *out)
{
    static const char *const text[] = {[RECORD_UNWATCHED] = "no board watched",
                                       [RECORD_WARNED] = "warned",
                                       [RECORD_QUIET] = "quiet",
                                       [RECORD_UNHEARD] = "not all heard"};
    if (row->warned == RECORD_WARNED)
        fputs("<td class=\"warn\">warned</td>", out);
    else
        html_cell(out, "%s", text[row->warned]);
    html_number(out, row->warned_t_s, 3);
    html_number(out, station * row->warned_ft, 1);
    html_number(out, row->risk_most, 2);
}

static void outcome_cells(const struct record_row *row, double station, FILE *out)
{
    static const char *const came[] = {"not known", "came", "did not come"};
    const struct outcome *outcome = &row->outcome;
    html_cell(out, "%s", row->is_void ? "void" : came[outcome->came]);
    html_number(out, outcome->mats == STORE_NONE ? (double)NAN : (double)outcome->mats, 0);
    html_number(out, station * (outcome->mats > 0 ? outcome->start_ft : (double)NAN), 1);
    html_number(out, outcome->t_s, 2);
    html_number(out, outcome->left_mats == STORE_NONE ? (double)NAN : (double)outcome->left_mats,
                0);
    html_cell(out, "%zu, %zu", outcome->waves, outcome->breaks);
    html_cell(out, "%s", record_verdict_text(row->verdict));
    html_number(out, row->lead_s, 2);
    html_cell(out, "%s",
              row->verdict == RECORD_NOT_KNOWN ? row->why : outcome_basis_text(outcome->basis));
}

static void write_rows(const struct report *report, const struct record *record, FILE *out)
{
    const struct unit *station = unit_of(UNIT_STATION, report->si);
    char at[40], longest[60];
    snprintf(at, sizeof at, "of a zone from, %s", station->text);
    snprintf(longest, sizeof longest, "from, %s", station->text);
    html_table(out, (const char *const[]){"RUN", "advice", "zone, %", "the board", "at, s", at,
                                          "risk, most", "a zone", "longest, mats", longest,
                                          "50 mats at, s", "left at the wheel, mats",
                                          "waves, breaks seen", "so it was", "lead, s", "known by",
                                          NULL});
    for (size_t i = 0; i < record->rows; i++) {
        const struct record_row *row = &record->row[i];
        fputs("<tr>", out);
        html_cell(out, "%lld", (long long)row->run);
        advice_cells(row, out);
        board_cells(row, station->factor, out);
        outcome_cells(row, station->factor, out);
        fputs("</tr>\n", out);
    }
    fputs("</tbody></table></div>\n<p>A zone: 50 closed mats or more that the wheel came to before "
          "it stopped, by survey and transducers or by what people saw, never by the predictor. "
          "Longest: of those that the wheel came to. Times since touchdown. Left at the wheel: by "
          "the survey after the landing.</p>\n",
          out);
}

enum mr_status campaign_record(const struct report *report, FILE *out, struct error *error)
{
    const struct record *record = &report->record;
    (void)error;
    if (report->run || record->landings + record->to_come == 0)
        return MR_OK;
    struct answer *answer = answer_new(report->si);
    record_answer(record, false, answer);
    report_answer(answer, out);
    if (record->rows)
        write_rows(report, record, out);
    return MR_OK;
}
