/* What each figure of a misfit is called, and what may be behind it. */
#include "host/study/fit/misfit.h"

const struct misfit_word misfit_words[MISFITS] = {
    [MISFIT_SCATTER] = {"scatter", "scatter of the movements",
                        "joints or instruments scatter otherwise than they are drawn: check the "
                        "transducers' calibration and noise"},
    [MISFIT_LARGEST] = {"largest", "largest residual",
                        "one place is unlike the others: check that transducer, and look at the "
                        "joints ahead of it"},
    [MISFIT_KURTOSIS] = {"kurtosis", "heaviness of the residuals' tails",
                         "a few places are unlike the others: look for joints that hardly close"},
    [MISFIT_NEIGHBOURS] = {"neighbours", "likeness of neighbouring transducers",
                           "something changes slowly along the runway: look for dirt or wear on a "
                           "stretch"},
    [MISFIT_LEVEL] = {"level", "movements by the wheel's distance",
                      "mats are pushed otherwise than the chain has it: check the gear's way, "
                      "elastic ground (matrig params --push) and the law of the resistance"},
    [MISFIT_HALVES] =
        {"halves", "difference between the halves of the runway",
         "one half is dirtier, or laid otherwise: clean it, or fit landings that stay "
         "on one half"},
    [MISFIT_STATION] = {"station", "dependence on the station",
                        "joints, ground or braking change along the runway: look at that stretch, "
                        "and hold the thrust against the brakes' record"},
    [MISFIT_TIME] = {"time", "dependence on the time within the landing",
                     "the thrust changes otherwise than the deceleration says: check the gear's "
                     "way, and which bogie braked when"},
    [MISFIT_LANDING] = {"landing", "difference between landings",
                        "something drifts from landing to landing: fit them one by one"},
    [MISFIT_SUMS] = {"sums", "scatter of the sums after",
                     "joints close more or less evenly than resistances drawn alike let them: look "
                     "for a few that hold most"},
    [MISFIT_SUMS_LARGEST] = {"sums_largest", "largest residual of a sum after",
                             "one segment is unlike the others: read it again, and look at its "
                             "joints"},
    [MISFIT_SUMS_ALONG] = {"sums_along", "likeness of neighbouring segments after",
                           "joints hold or close in stretches: look for dirt there, and for joints "
                           "that hold most"},
    [MISFIT_ZONES] = {"zones", "sums after by sixths of the runway",
                      "a stretch has closed otherwise than the rest: look at its joints"},
    [MISFIT_CLOSED] = {"closed", "number of closed segments",
                       "more or fewer joints closed than the resistance lets them: its "
                       "distribution is another, or the survey counts others as closed"},
    [MISFIT_LAID] = {"laid", "spread of the sums before",
                     "gaps were not laid alike: fit with a survey of every segment, and do not "
                     "trust what is said of those between"},
    [MISFIT_LAID_ALONG] = {"laid_along", "likeness of neighbouring segments before",
                           "gaps were laid in stretches: fit with a survey of every segment, and "
                           "do not trust what is said of those between"},
    [MISFIT_ODD_BEYOND] = {"odd_beyond", "resistance beyond the middle, over that before it",
                           "the far half of the runway is dirtier: clean it, or fit landings that "
                           "stay on one half"},
    [MISFIT_ODD_BEFORE] = {"odd_before", "resistance before the middle, over that beyond it",
                           "the near half of the runway is dirtier: clean it, or fit landings that "
                           "stay on one half"},
    [MISFIT_ODD_TAIL] = {"odd_tail", "heavy tail of the resistances",
                         "a few joints hold most: look for lumps of dirt where joints have stayed "
                         "open, and clean them"},
    [MISFIT_ODD_THRUST] = {"odd_thrust", "growth of the thrust within a landing",
                           "the thrust is not what the deceleration says: hold it against the "
                           "brakes' record, and check the gear's way"},
};
