#include "host/collect/doubt.h"

const char *doubt_text(unsigned doubt)
{
    static const char *const texts[] = {
#define DOUBT_WORDS(name, obeyed, text) text,
        DOUBT_TABLE(DOUBT_WORDS)
#undef DOUBT_WORDS
    };
    return doubt < DOUBTS ? texts[doubt] : "unknown";
}

bool doubt_obeyed(unsigned doubt)
{
    static const bool obeyed_ones[] = {
#define DOUBT_OBEYED(name, obeyed, text) obeyed,
        DOUBT_TABLE(DOUBT_OBEYED)
#undef DOUBT_OBEYED
    };
    return doubt < DOUBTS && obeyed_ones[doubt];
}
