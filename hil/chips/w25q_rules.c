#include "hil/chips/w25q_rules.h"

#include "hil/chips/w25q_commands.h"
#include "hil/periph/rules.h"

static bool is_array_read(uint8_t command)
{
    return command == READ || command == FAST_READ;
}

/* What a command wants to be left alone for. */
static enum hil_rule rest_after(uint8_t command)
{
    return command == RELEASE    ? HIL_RULE_RELEASE
         : command == POWER_DOWN ? HIL_RULE_POWER_DOWN
         : command == RESET      ? HIL_RULE_RESTART
                                 : HIL_RULES;
}

void hil_w25q_hold_rules(struct hil_rules_device *rules, const struct hil_w25q_past *past,
                         uint8_t command, double clock_period_ns)
{
    const struct hil_rules_edges *select = hil_rules_edges(rules, HIL_RULES_MEMORY_SELECT);
    const struct hil_moment power = {.ps = past->power_ps};
    bool reads = is_array_read(past->before) && is_array_read(command);
    enum hil_rule rest = rest_after(past->rests);
    if (!past->before)
        hil_rules_judge(rules, HIL_RULE_POWER_TO_SELECT, power, select->fell);
    else
        hil_rules_judge(rules, reads ? HIL_RULE_SELECT_HIGH_READS : HIL_RULE_SELECT_HIGH,
                        select->rose, select->fell);
    if (rest != HIL_RULES)
        hil_rules_judge(rules, rest, select->rose, select->fell);
    if (command == WRITE_ENABLE || command == VOLATILE_ENABLE)
        hil_rules_judge(rules, HIL_RULE_POWER_TO_WRITE, power, select->fell);
    hil_rules_measure(rules, command == READ ? HIL_RULE_CLOCK_PERIOD_READ : HIL_RULE_CLOCK_PERIOD,
                      clock_period_ns, 0.0, select->fell.pc);
}
