#include "hil/periph/options.h"

#include "common/image.h"
#include "hil/periph/board_type.h"

void hil_options_default(struct hil_options *options)
{
    *options = (struct hil_options){
        .type = hil_board_type_of(MR_BOARD_ZG),
        .seed = 1,
        .hse_hz = 8000000,
        .lsi_hz = 32000,
        .host_baud = 2000000,
        .can_bus = HIL_CAN_CONNECTED,
        .adc_noise = true,
        .temperature_c = 20.0,
        .uid = {0x00310042u, 0x5847500fu, 0x20343635u},
    };
}
