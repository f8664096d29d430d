"""A transducer: drive and reading of a cell, at the sampling times of the converter."""
import math

from deck import (CONVERT_S, Deck, Draw, LSB_V, SAMPLE_S, SCAN_S, TRIGGER_S, VDDA,
                  at, corner_hz, deviation, kick, mean, noise_lsb, rails, source_ohm)

COPIES = 40
CELL_OHM = 2000.0
TRAVEL = 0.6  # of the cell's half travel: about 2 in
RAILS = {"2V5T": 2.5, "VDDA": VDDA, "MID": VDDA / 2}


def cell(deck, copy, parts, share, ohm=CELL_OHM):
    """An electrolytic cell at the connector: its centre stands at `share`, -1 to 1, towards the plus electrode."""
    plus, minus, centre = (deck.node(copy, parts["T1/J1"].net(n)) for n in "123")
    deck.add(f"Rcellp{copy} {plus} {centre} {ohm * (1 - share) / 2}", f"Rcellm{copy} {centre} {minus} {ohm * (1 + share) / 2}")


def drive(deck):
    """PD12 and PD13: at first in the middle, so that the coupling capacitors have the charge of a long run; then 4 kHz in
    antiphase."""
    for name, levels in (("drivep", (3.3, 0)), ("drivem", (0, 3.3))):
        points = ["0 1.25", "1u 1.25", f"1.05u {levels[0]}"]
        for n in range(1, 5):
            points += [f"{n * SCAN_S} {levels[(n + 1) % 2]}", f"{n * SCAN_S + 50e-9} {levels[n % 2]}"]
        deck.add(f"V{name} {name} 0 pwl({' '.join(points)})")


def connect(deck, copy, parts):
    for pin, source in (("1A", "drivep"), ("2A", "drivem")):
        deck.add(f"Rdrive{copy}{pin} {source} {deck.node(copy, parts['T1/U1'].net(pin))} 1")


def block(parts):
    return [p for r, p in parts.items() if r.startswith("T1/")]


def codes(times, volts, first_s=SCAN_S * 2):
    """Half difference and mean of the two polarities at the end of each of the eight sampling times, volts."""
    half, middle = [], []
    for i in range(8):
        end = TRIGGER_S + i * CONVERT_S + SAMPLE_S
        forward, backward = at(times, volts, first_s + end), at(times, volts, first_s + SCAN_S + end)
        half.append((forward - backward) / 2)
        middle.append((forward + backward) / 2)
    return half, middle


def time_constant_us(times, volts, start_s):
    """Between a half and a twentieth of what is left of a reversal."""
    end = at(times, volts, start_s + 40e-6)
    begin = at(times, volts, start_s)
    crossed = []
    for left in (0.5, 0.05):
        crossed.append(next(t for t, v in zip(times, volts) if t > start_s and abs(v - end) < left * abs(begin - end)))
    return (crossed[1] - crossed[0]) / math.log(10) * 1e6


def transient(parts, work, copies, spread, share, name="transducer-transient", ohm=CELL_OHM, supplies=None):
    deck = Deck(work, name)
    drive(deck)
    for copy in range(copies):
        deck.place(copy, block(parts), Draw(f"transducer {copy}", spread))
        rails(deck, copy, {**RAILS, **(supplies or {})})
        connect(deck, copy, parts)
        cell(deck, copy, parts, share, ohm)
    out = [f"v({deck.node(c, 'TRANSDUCER_1')})" for c in range(copies)]
    plot = deck.run([f"tran 0.25u {SCAN_S * 4} 0 0.25u", "WRITE"], out, 120)[0]
    return plot["time"], [plot[name] for name in out]


def small_signal(parts, work):
    """Corner and noise, from the cell's centre to the converter."""
    deck = Deck(work, "transducer-ac")
    deck.place(0, block(parts), Draw(0, 0))
    rails(deck, 0, RAILS)
    deck.add("Vp drivep 0 3.3", "Vm drivem 0 0")
    connect(deck, 0, parts)
    cell(deck, 0, parts, 0)
    centre = deck.node(0, parts["T1/J1"].net("3"))
    deck.add(f"Iin 0 {centre} dc 0 ac 1")
    out = f"v({deck.node(0, 'TRANSDUCER_1')})"
    response = deck.run(["ac dec 20 100 10meg", "WRITE"], [out])[0]
    noise = deck.run([f"noise {out} Iin dec 10 1 10meg", "setplot noise2", "WRITE"], ["onoise_total", "all"])[-1]
    return corner_hz([abs(f) for f in response["frequency"]], response[out]), noise_lsb(noise)


def surround(parts):
    def add(deck, copy):
        rails(deck, copy, RAILS)
        if copy == 0:
            deck.add("Vp drivep 0 3.3", "Vm drivem 0 0")
        connect(deck, copy, parts)
        cell(deck, copy, parts, 0)
    return add


def reference_rule(parts, work, usual_v):
    """Rule 2: the amplitude follows the reference and not VDDA. Relative deviations with the reference 1 % low, and with VDDA 2 % low."""
    def amplitude(**supplies):
        times, volts = transient(parts, work, 1, 0, TRAVEL, "transducer-rule", supplies=supplies)
        return mean(codes(times, volts[0])[0])
    return amplitude(**{"2V5T": 2.475}) / usual_v / 0.99 - 1, amplitude(VDDA=VDDA * 0.98, MID=VDDA * 0.49) / usual_v - 1


def figures(parts, work):
    times, nominal = transient(parts, work, 1, 0, TRAVEL)
    half, middle = codes(times, nominal[0])
    times_mc, volts = transient(parts, work, COPIES, 1, TRAVEL, "transducer-tolerance")
    read = [codes(times_mc, v) for v in volts]
    gains = [mean(h) for h, _ in read]
    _, warm = transient(parts, work, 1, 0, TRAVEL, "transducer-warm", CELL_OHM * 0.98)
    warmer = mean(codes(times, nominal[0])[0]), mean(codes(_, warm[0])[0])
    corner, noise = small_signal(parts, work)
    around, part = surround(parts), block(parts)
    with_reference, with_vdda = reference_rule(parts, work, mean(half))
    return [
        ("transducer_top_in", (VDDA / 2 - 0.03) / 0.5 - 0.1, "in", "displacement at the upper limit of the amplifier, with 0.5 V/in and 0.050 V at zero displacement"),
        ("transducer_gain_sd_rel", deviation(gains) / mean(gains), "1", f"standard deviation between channels, {COPIES} simulated circuits, without the cell"),
        ("transducer_cell_ppm_k", abs(warmer[1] / warmer[0] - 1) * 1e6, "ppm/K", "change of gain if the conductance of the cell rises by 2 %/K"),
        ("transducer_mid_v", mean(middle), "V", "common mode of both polarities"),
        ("transducer_mid_sd_v", deviation([mean(m) for _, m in read]), "V", "standard deviation of the common mode, without MID"),
        ("transducer_settle_us", time_constant_us(times, nominal[0], SCAN_S * 2), "us", "time constant of a reversal at the converter"),
        ("transducer_scan_change_rel", (half[7] - half[0]) / mean(half), "1", "difference of the eighth conversion of a scan from the first: settling and droop"),
        ("transducer_reference_rel", with_reference, "1",
         "rule 2: residual error with the reference 1 % low, reading taken as ratio to the reference"),
        ("transducer_vdda_rel", with_vdda, "1", "rule 2: change of the amplitude with VDDA 2 % low"),
        ("transducer_noise_lsb", noise, "LSB", "standard deviation at the converter, 1 Hz to 10 MHz"),
        ("transducer_kick_rel", kick(work, "transducer", part, "TRANSDUCER_1", around), "1",
         "share of the previous channel's voltage that remains in a reading"),
        ("transducer_source_ohm", source_ohm(work, "transducer", part, "TRANSDUCER_1", around), "Ohm", "source resistance at the converter"),
        ("transducer_corner_hz", corner, "Hz", "-3 dB from the cell to the converter"),
    ]
