#include "tests/figures/inputs.h"

#include <math.h>

#define RIGHT_OPTIONS   \
    {                   \
        "fixed", "free" \
    }
#define NODE_HEIGHT_FT 0.015625 /* 3/16 in (6.1.3) */

const struct input inputs[INPUTS] = {
    [IN_W] = {"weight of a mat, lb", "Table 3.1: 140-160", INPUT_EVEN, 140, 160, 160, {0}},
    [IN_V0] = {"first speed of the mat under the wheel, ft/s",
               "3.5: approximately 2",
               INPUT_EVEN,
               0,
               6,
               2,
               {0}},
    [IN_VAC] = {"speed of the aircraft, ft/s",
                "stated for fig 3.8 alone: 90",
                INPUT_EVEN,
                75,
                105,
                90,
                {0}},
    [IN_S0] = {"place of the wheel on mat 1 at the start, ft",
               "3.6: four joints before the bump",
               INPUT_EVEN,
               0,
               1.9,
               0,
               {0}},
    [IN_TO_EDGE] = {"mats crossed are counted",
                    "not said",
                    INPUT_CHOICE,
                    0,
                    2,
                    0,
                    {"from the start", "at joints"}},
    [IN_CROSS38] = {"share of mat 1 crossed in fig 3.8",
                    "3.6: as the aircraft crosses mat 1",
                    INPUT_EVEN,
                    0.5,
                    1,
                    1,
                    {0}},
    [IN_N] = {"mats", "3.6: sufficient", INPUT_WHOLE, 30, 160, 53, {0}},
    [IN_LEFT] = {"left end", "3.1.3: fixed or free", INPUT_CHOICE, 0, 2, 1, RIGHT_OPTIONS},
    [IN_RIGHT] = {"right end", "3.1.3: fixed or free", INPUT_CHOICE, 0, 2, 0, RIGHT_OPTIONS},
    [IN_RIGHT312] = {"right end in fig 3.12", "3.1.3: fixed or free", INPUT_CHOICE, 0, 2, 0,
                     RIGHT_OPTIONS},
    [IN_F312] = {"thrust in fig 3.12, lb",
                 "2.6: 495,000 lb; 3.4: 480,000",
                 INPUT_EVEN,
                 11500,
                 12600,
                 12000,
                 {0}},
    [IN_CL] = {"CL, lb s/ft", "Table 3.1: 50-0", INPUT_LOG, 10, 1000, 50, {0}},
    [IN_THRUST] = {"thrust", "not said", INPUT_CHOICE, 0, 2, 0, {"jump", "shared"}},
    [IN_FRICTION] =
        {"friction at rest", "A.1: sign; RKGS chatters", INPUT_CHOICE, 0, 2, 0, {"stick", "tanh"}},
    [IN_SHEAR] = {"V over the weight", "3.2: approximately 1", INPUT_EVEN, 0.5, 1.3, 0.75, {0}},
    [IN_SHEAR_LAW] = {"where V acts",
                      "3.2: in words",
                      INPUT_CHOICE,
                      0,
                      4,
                      0,
                      {"rising", "none", "following", "both"}},
    [IN_KV] = {"KV, lb/ft", "Table 3.1: illegible", INPUT_LOG, 1e5, 4e7, 1e7, {0}},
    [IN_TAD_MODE] =
        {"torsion beyond TAD", "3.4: in words", INPUT_CHOICE, 0, 2, 0, {"dead band", "switched"}},
    [IN_BUMP_FIRST] =
        {"first raised joint", "3.6: four joints from the wheel", INPUT_WHOLE, 4, 6, 5, {0}},
    [IN_THIRD36] = {"third height in figs 3.6 and 3.7, ft",
                    "3.6: only .0099 and .0200",
                    INPUT_EVEN,
                    0.005,
                    0.02,
                    0.0099,
                    {0}},
    [IN_RATIO] = {"outer over middle height, other figures",
                  "on the lost prints",
                  INPUT_EVEN,
                  0.3,
                  1,
                  0.5,
                  {0}},
    [IN_HEIGHT] = {"height in figs 3.9 and 3.10, ft",
                   "on the lost prints",
                   INPUT_EVEN,
                   0.0104,
                   0.03,
                   NODE_HEIGHT_FT,
                   {0}},
    [IN_NODES39] = {"raised joints in fig 3.9", "3.6: three mats", INPUT_WHOLE, 2, 3, 3, {0}},
    [IN_NODES311] = {"raised joints in fig 3.11", "on the lost print", INPUT_WHOLE, 1, 3, 3, {0}},
    [IN_NODES312] = {"raised joints in fig 3.12", "on the lost print", INPUT_WHOLE, 1, 3, 1, {0}},
    [IN_MAT36] = {"mat of fig 3.6's 0.056 ft", "not said", INPUT_WHOLE, 4, 8, 4, {0}},
    [IN_MAT312] = {"mat of fig 3.12's 0.1612 ft", "near the bow wave", INPUT_WHOLE, 4, 8, 4, {0}},
};

struct reading reading_rstar(void)
{
    struct reading reading;
    for (int i = 0; i < INPUTS; i++)
        reading.value[i] = inputs[i].rstar;
    return reading;
}
