/* The DBC: its lines, worked out by hand. That another program's parser reads it to the values of
 * the CSV: tests/cli/exchange.sh. */
#include <stdlib.h>

#include "host/exchange/export.h"
#include "tests/host/scratch.h"

TEST(lines_are_as_worked_out_by_hand)
{
    static const char *const there[] = {
        "\nBU_: BOARD HOST\n",
        /* 500, 1000 and 500 counts in a unit; little-endian from the byte's lowest bit */
        "\nBO_ 145 motion: 8 BOARD\n SG_ position_ft : 0|16@1+ (0.002,0) [0|131.068] \"ft\" HOST\n "
        "SG_ speed_ft_s : 16|16@1+ (0.001,0) [0|65.534] \"ft/s\" HOST\n SG_ deceleration_ft_s2 : "
        "32|16@1- (0.002,0) [-65.534|65.534] \"ft/s2\" HOST\n",
        "\nBO_ 1024 command: 8 HOST\n SG_ code : 0|8@1+ (1,0) [0|255] \"\" BOARD\n SG_ index : "
        "8|8@1+ (1,0) [0|255] \"\" BOARD\n SG_ tag : 16|16@1+ (1,0) [0|65535] \"\" BOARD\n SG_ "
        "argument : 32|32@1- (1,0) [-2147483648|2147483647] \"\" BOARD\n",
        "\n SG_ station_ft : 32|32@1- (1,0) [0|0] \"ft\" HOST\n",
        "\nSIG_VALTYPE_ 503 station_ft : 1;\n",
        "\nSIG_VALTYPE_ 502 zero_code : 1;\n",
        "\nVAL_ 256 d1_in -32768 \"missing\" ;\n",
        "\nVAL_ 160 state 0 \"idle\" 1 \"armed\" 2 \"landing\" 3 \"settling\" 4 \"done\" ;\n",
        ("\nVAL_ 176 code 1 \"state\" 2 \"arm\" 3 \"disarm\" 4 \"mark\" 5 \"survey\" 6 \"bootrom\" "
         "7 \"reset\" 8 \"self-test\" ;\n"),
        /* a state has its names wherever it stands */
        "\nVAL_ 496 state 0 \"idle\" 1 \"armed\" 2 \"landing\" 3 \"settling\" 4 \"done\" ;\n",
        "\nVAL_ 233 validity 0 \"valid\" 2 \"saturated\" ",
        "\nCM_ SG_ 496 reset_cause \"bit 0 power, 1 pin, ",
        " 19 \"the watchdog reset the board\" ",
    };
    char *text;
    size_t length;
    FILE *out = open_memstream(&text, &length);
    dbc_write(out, 0);
    fclose(out);
    for (size_t i = 0; i < sizeof there / sizeof there[0]; i++) {
        if (!strstr(text, there[i]))
            fail_msg("not in it: %s", there[i]);
    }
    /* no float, and bits are no values */
    assert_null(strstr(text, "SIG_VALTYPE_ 256"));
    assert_null(strstr(text, "\nVAL_ 496 reset_cause"));
    free(text);
}
