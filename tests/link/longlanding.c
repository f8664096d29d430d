/* A landing that was armed long before, as a board made by hand (tests/host/stream.h) sends it:
 * longlanding CANDUMP SERIAL ARMED_S */
#include "tests/host/stream.h"

int main(int argc, char **argv)
{
    struct stream stream = {.host_us = 1000000, .armed_s = argc == 4 ? strtod(argv[3], NULL) : 0.0};
    struct stream_truth truth = {.v0_ft_s = 35.0, .a_ft_s2 = 8.0, .peak_in = 0.4};
    if (argc != 4 || !(stream.can = fopen(argv[1], "w")) || !(stream.serial = fopen(argv[2], "wb")))
        return 2;
    stream_hello(&stream, MR_LAYOUT);
    stream_configuration(&stream);
    stream_idle(&stream, 200);
    stream_landing(&stream, &truth, 1);
    stream_idle(&stream, 1500);
    return fclose(stream.can) != 0 || fclose(stream.serial) != 0;
}
