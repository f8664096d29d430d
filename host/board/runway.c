#include "host/board/runway.h"

#include <stddef.h>

#define TEXT(texts, n) ((n) < sizeof(texts) / sizeof(texts)[0] ? (texts)[n] : "unknown")

const char *runway_source_text(unsigned source)
{
    static const char *const text[] = {"nobody has measured it", "from memory, copy A", "from memory, copy B", "given by the host",
                                       "of a landing or a survey since the reset"};
    return TEXT(text, source);
}

const char *runway_verdict_text(unsigned verdict)
{
    static const char *const text[] = {"quiet", "advisory", "warning"};
    return TEXT(text, verdict);
}

const char *runway_reason_text(unsigned reason)
{
    static const char *const text[] = {"no reason", "a closed zone lies ahead",
                                       "the model expects a closed zone ahead before the gear stops",
                                       "the compression is beyond the critical one"};
    return TEXT(text, reason);
}

const char *runway_level_text(unsigned level)
{
    static const char *const text[] = {"every mat", "two mats in one", "four mats in one", "plough", "kinematic"};
    return TEXT(text, level);
}

const char *runway_doubt_text(unsigned doubt)
{
    static const char *const text[] = {"trusted", "missing", "drifts", "disagrees with the model"};
    return TEXT(text, doubt);
}
