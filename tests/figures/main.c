/* figures FOLDER: redraw figures 3.6 to 3.12 and compare the numbers that the text states. Exit 1
 * when one of those that the scenes are held to is missed. */
#include <stdio.h>

#include "tests/figures/figures.h"

int main(int argc, char **argv)
{
    struct error error = {0};
    if (argc != 2) {
        fputs("usage: figures FOLDER\n", stderr);
        return 2;
    }
    if (draw_figures(argv[1], &error) == MR_OK)
        return 0;
    fprintf(stderr, "figures: %s\n", error.text);
    return mr_status_exit_code(error.status);
}
