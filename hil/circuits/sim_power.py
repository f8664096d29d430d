"""The reference and the voltages derived from it: errors under load."""
from deck import Deck, Draw, VDDA, deviation, kick, mean, rails, source_ohm

COPIES = 100
BRIDGE_OHM, BRIDGES, CELL_A = 350.0, 14, 1.2e-3
SUPPLY = {"5V": 5, "VDDA": VDDA}


def block(parts):
    """The reference, its filter, both followers and the two other voltages."""
    wanted = {f"U{n}" for n in (803, 804, 805, 806, 201)} | {"Q801", "Q802"} | \
             {f"R{n}" for n in (801, 802, 803, 811, 812, 813, 821, 822, 823, 203, 204)} | \
             {f"C{n}" for n in (805, 806, 807, 808, 809, 811, 812, 821, 822, 831, 832, 833, 201, 202)}
    return [p for r, p in parts.items() if r in wanted]


def loads(deck, copy, bridges=BRIDGES):
    deck.add(f"Rbridges{copy} {deck.node(copy, '2V5G')} 0 {BRIDGE_OHM / bridges}")


def levels(parts, work):
    deck = Deck(work, "power-levels")
    for copy in range(COPIES):
        deck.place(copy, block(parts), Draw(f"power {copy}"))
        rails(deck, copy, SUPPLY)
        loads(deck, copy)
        deck.add(f"Icells{copy} {deck.node(copy, '2V5T')} 0 {8 * CELL_A}")
    names = ("2V5", "REFERENCE", "2V5G", "2V5T", "MID", "0V4")
    plot = deck.run(["op", "WRITE"], [f"v({deck.node(c, n)})" for c in range(COPIES) for n in names], 60)[0]
    return {n: [plot[f"v({deck.node(c, n)})"][0] for c in range(COPIES)] for n in names}


def short(parts, work):
    """Amperes into one bridge's excitation lead that is shorted to ground by 1 Ohm."""
    deck = Deck(work, "power-short")
    deck.place(0, block(parts), Draw(0, 0))
    rails(deck, 0, SUPPLY)
    loads(deck, 0)
    deck.add(f"Rshort {deck.node(0, '2V5G')} 0 1")
    name = f"v({deck.node(0, '2V5G')})"
    return deck.run(["op", "WRITE"], [name])[0][name][0]


def figures(parts, work):
    level = levels(parts, work)
    ratio = {n: [v / r for v, r in zip(level[n], level["2V5"])] for n in ("2V5G", "2V5T", "0V4", "REFERENCE")}
    part = [p for p in block(parts) if p.refdes in ("U803", "R801", "C808", "C807")]

    def around(deck, copy):
        rails(deck, copy, SUPPLY)
    return [
        ("adc_noise_lsb", 1.0, "LSB", "standard deviation of a conversion; assumed, because ST states none; the bring-up image measures it"),
        ("adc_inl_typical_lsb", 1.5, "LSB", "integral nonlinearity, typical; STM32F407 data sheet, ADC accuracy, EL"),
        ("adc_inl_max_lsb", 3.0, "LSB", "integral nonlinearity, maximum; STM32F407 data sheet, ADC accuracy, EL"),
        ("adc_offset_lsb", 1.5, "LSB", "offset error, typical (maximum 2.5); STM32F407 data sheet, ADC accuracy, EO"),
        ("adc_gain_lsb", 1.5, "LSB", "gain error at full scale, typical (maximum 3); STM32F407 data sheet, ADC accuracy, EG"),
        ("reference_error_rel", 0.0005, "1", "maximum; REF5025 high grade, data sheet SBOS410"),
        ("reference_drift_ppm_k", 3.0, "ppm/K", "maximum; REF5025 high grade, data sheet SBOS410"),
        ("reference_read_sd_rel", deviation(level["REFERENCE"]) / 2.5, "1", f"standard deviation of the voltage at PC5, {COPIES} simulated circuits"),
        ("reference_source_ohm", source_ohm(work, "reference", part, "REFERENCE", around), "Ohm", "source resistance at the converter"),
        ("reference_kick_rel", kick(work, "reference", part, "REFERENCE", around), "1", "share of the previous channel's voltage that remains in a reading"),
        ("gage_excitation_sd_rel", deviation(ratio["2V5G"]), "1", "standard deviation of the ratio of the bridge supply to the reference, at 100 mA"),
        ("transducer_excitation_sd_rel", deviation(ratio["2V5T"]), "1", "standard deviation of the ratio of the transducer supply to the reference, at 10 mA"),
        ("gage_zero_v", mean(level["0V4"]), "V", "output at zero tension, mean"),
        ("transducer_mid_supply_sd_v", deviation(level["MID"]), "V", "standard deviation of MID at a fixed VDDA"),
        ("gage_supply_short_a", short(parts, work) / 1.0, "A", "current from the bridge supply into an excitation lead shorted by 1 Ohm"),
    ]
