/* error-report FOLDER [predictor]: error against run time of the landing engines and of the onboard
 * predictor, or of the latter alone: Markdown on stdout, plots in FOLDER. */
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "tests/error_report/report.h"

int main(int argc, char **argv)
{
    struct error error = {0};
    bool alone = argc == 3 && strcmp(argv[2], "predictor") == 0;
    if (argc != 2 && !alone) {
        fputs("usage: error-report FOLDER [predictor]\n", stderr);
        return 2;
    }
    if (alone ||
        write_engines(argv[1], "host/landing_series/series/standard.json", &error) == MR_OK)
        write_predictor(argv[1], &error);
    if (error.status == MR_OK)
        return 0;
    fprintf(stderr, "error-report: %s\n", error.text);
    return mr_status_exit_code(error.status);
}
