/* How the parts of a board are joined: the chip's pins to the rig, its wires to the links, the
 * memory and the thermometer to their buses. */
#include "hil/board/parts.h"
#include "hil/core/bus.h"
#include "hil/core/event.h"
#include "hil/core/systick.h"
#include "hil/periph/board_type.h"

static void cut_supply(void *device)
{
    hil_supply_cut(device);
}

static void wire_core(struct hil_board *board)
{
    struct hil_core *core = &board->core;
    core->memory = &board->memories->own;
    core->no_ccm = board->options.type->no_ccm;
    core->watch_alignment = board->options.watch_alignment;
    hil_event_create(core);
    hil_systick_create(core);
    hil_clock_start(&core->state.clock, 16000000);
    hil_bus_create(core);
}

/* In the order in which those who listen to pins are told: rig, chip, camera. */
static void wire_pins(struct hil_board *board)
{
    struct hil_core *core = &board->core;
    struct hil_mcu *mcu = &board->mcu;
    board->rig.core = board->camera.core = core;
    board->rig.state = &board->state.rig;
    board->rig.bare = board->options.bare;
    board->rig.gpio = board->camera.gpio = &mcu->gpio;
    board->rig.adc = &mcu->adc;
    board->rig.type = board->options.type;
    board->rig.electronics = &board->electronics;
    board->camera.options = &board->options;
    board->camera.state = &board->state.camera;
    for (unsigned i = 0; i < HIL_BOARD_PULLS; i++) {
        const struct hil_pull *pull = &board->options.type->pull[i];
        hil_gpio_pull(&mcu->gpio, pull->at.port, pull->at.pin, pull->up);
    }
    hil_rig_create(&board->rig);
    hil_mcu_create(mcu, core, &board->options, &board->state.mcu);
    hil_camera_create(&board->camera);
}

static void wire_chips(struct hil_board *board)
{
    const struct hil_options *options = &board->options;
    board->w25q = (struct hil_w25q_device){
        .core = &board->core,
        .options = options,
        .state = &board->state.w25q,
        .orders = &board->state.nor_orders,
        .rules = &board->mcu.rules,
        .spi = &board->mcu.spi,
        .cells = board->memories->nor,
        .began = {hil_faults_nor_operation, &board->faults},
        .cut = {cut_supply, &board->supply},
    };
    board->tmp112 = (struct hil_tmp112_device){
        .core = &board->core, .options = options, .state = &board->state.tmp112};
    board->mcu.spi.slave = hil_w25q_slave(&board->w25q);
    board->mcu.i2c.slave = hil_tmp112_slave(&board->tmp112);
    board->mcu.flash.began = (struct hil_call){hil_faults_flash_operation, &board->faults};
    board->mcu.flash.cut = (struct hil_call){cut_supply, &board->supply};
    hil_flash_create(&board->mcu.flash);
    hil_w25q_create(&board->w25q);
    board->supply = (struct hil_supply_device){
        .core = &board->core,
        .state = &board->state.supply,
        .flash = &board->mcu.flash,
        .rcc = &board->mcu.rcc,
        .nor = &board->w25q,
        .thermometer = &board->tmp112,
    };
    hil_supply_create(&board->supply);
}

static void wire_links(struct hil_board *board)
{
    board->lines = (struct hil_lines_device){
        .core = &board->core,
        .options = &board->options,
        .state = &board->state.lines,
        .frame_sent = {hil_faults_can_sent, &board->faults},
    };
    hil_lines_create(&board->lines, board->options.seed);
    board->mcu.can.wire = board->mcu.usart.wire = hil_lines_wire(&board->lines);
}

static void wire_runs(struct hil_board *board)
{
    struct hil_mcu *mcu = &board->mcu;
    board->script = (struct hil_script_device){
        .core = &board->core,
        .state = &board->state.script,
        .rig = &board->rig,
        .can = &mcu->can,
        .usart = &mcu->usart,
    };
    hil_script_create(&board->script);
    board->replay.core = &board->core;
    board->replay.state = &board->state.replay;
    board->replay.gpio = &mcu->gpio;
    board->replay.adc = &mcu->adc;
    board->replay.rcc = &mcu->rcc;
    board->replay.tim = &mcu->tim;
    board->replay.can = &mcu->can;
    board->replay.usart = &mcu->usart;
    board->replay.rig = &board->rig;
    hil_replay_create(&board->replay);
    board->faults = (struct hil_faults_device){
        .core = &board->core,
        .options = &board->options,
        .state = &board->state.faults,
        .lines = &board->lines,
        .rig = &board->rig,
        .camera = &board->camera,
        .supply = &board->supply,
        .rcc = &mcu->rcc,
        .can = &mcu->can,
        .i2c = &mcu->i2c,
        .nor = &board->state.nor_orders,
        .thermometer = &board->state.tmp112,
    };
    hil_faults_create(&board->faults);
}

void hil_board_fit_electronics(struct hil_board *board)
{
    hil_electronics_make(&board->electronics, &board->options, board->options.figures);
    board->mcu.adc.vdda_v = board->electronics.vdda_v;
    board->mcu.adc.errors = board->electronics.drawn ? &board->electronics.adc : NULL;
}

void hil_board_wire(struct hil_board *board)
{
    wire_core(board);
    wire_pins(board);
    hil_board_fit_electronics(board);
    wire_chips(board);
    wire_links(board);
    wire_runs(board);
}
