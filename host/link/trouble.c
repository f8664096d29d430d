#include "host/link/trouble.h"

const char *link_trouble_text(unsigned trouble)
{
    static const char *const texts[] = {
#define LINK_TROUBLE_TEXT(name, text) text,
        LINK_TROUBLE_TABLE(LINK_TROUBLE_TEXT)
#undef LINK_TROUBLE_TEXT
    };
    return trouble < LINK_TROUBLES ? texts[trouble] : "unknown trouble";
}
