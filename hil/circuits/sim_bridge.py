"""A bridge: gain, zero, trim, shunt, drift and noise of its amplifier, with gages as they are bought; the shunts' relays."""
import math

from deck import Deck, Draw, VDDA, corner_hz, deviation, kick, mean, noise_lsb, rails, source_ohm

COPIES = 300
CHUNK = 50
# Band of 3/8 x 0.020 in of steel, 30e6 psi (firmware/config.c); gages of 350 Ohm to 0.3 %, factor 2, two along the band
# and two across it.
GAGE_OHM, GAGE_TOLERANCE, FACTOR, POISSON = 350.0, 0.003, 2.0, 0.3
STRAIN_PER_LB = 1 / (0.375 * 0.020 * 30e6)
V_PER_LB = 0.005
RAILS = {"5V": 5, "2V5G": 2.5, "0V4": 0.4, "VDDA": VDDA, "COILS": 5}
TURN = 0.0001  # of the voltage across a trimmer: its adjustability, Bourns 3296 data sheet


def gages(deck, copy, parts, tension_lb, draw):
    up, plus, minus, down = (deck.node(copy, parts["G1/J1"].net(n)) for n in "1234")
    change = FACTOR * STRAIN_PER_LB * tension_lb
    arms = (("a", up, plus, -POISSON), ("b", plus, down, 1), ("c", up, minus, 1), ("d", minus, down, -POISSON))
    for name, a, b, share in arms:
        deck.add(f"Rgage{copy}{name} {a} {b} {GAGE_OHM * (1 + draw.within(GAGE_TOLERANCE)) * (1 + share * change):.12g}")


def block(parts):
    return [p for r, p in parts.items() if r.startswith("G1/")]


def amplified(deck, copy):
    """The amplifier's output before its ends."""
    return [f"v(x{copy}_g1_u1.f)", f"v({deck.node(copy, '0V4')})"]


def state(parts, work, tension_lb=0.0, turned=None, closed=False, warmer_k=0.0, spread=1.0, copies=COPIES, supplies=None):
    """Amplifier output of each copy, lb at the nominal 0.4 V and 5 mV/lb. `turned`: position of each copy's trimmer; None: the middle."""
    said = []
    for first in range(0, copies, CHUNK):
        deck = Deck(work, "bridge-state")
        save = []
        for copy in range(first, min(first + CHUNK, copies)):
            draw = Draw(f"bridge {copy}", spread)
            draw.turned, draw.closed, draw.warmer_k = (0.5 if turned is None else turned[copy]), closed, warmer_k
            deck.place(copy, block(parts), draw)
            rails(deck, copy, {**RAILS, **(supplies or {})})
            gages(deck, copy, parts, tension_lb, Draw(f"gages {copy}", spread))
            save.append(amplified(deck, copy))
        plot = deck.run(["op", "WRITE"], [name for pair in save for name in pair], 60)[0]
        said += [(plot[f][0] + plot[ref][0] - 0.4) / V_PER_LB for f, ref in save]
    return said


def trimmed(parts, work, zero, low, high):
    """Where each trimmer ends when a person turns it until the zero is right, and then no better than TURN."""
    slope = [h - l for l, h in zip(low, high)]
    turned, left = [0.5] * COPIES, zero
    for _ in range(3):
        turned = [min(max(t - z / s, 0), 1) for t, z, s in zip(turned, left, slope)]
        left = state(parts, work, turned=turned)
    draw = Draw("turning")
    return [min(max(t + draw.within(TURN), 0), 1) for t in turned]


def around(parts):
    def add(deck, copy):
        rails(deck, copy, RAILS)
        gages(deck, copy, parts, 100, Draw(0, 0))
    return add


def small_signal(parts, work):
    deck = Deck(work, "bridge-ac")
    deck.place(0, block(parts), Draw(0, 0))
    rails(deck, 0, RAILS)
    gages(deck, 0, parts, 0, Draw(0, 0))
    deck.add(f"Iin 0 {deck.node(0, parts['G1/J1'].net('2'))} dc 0 ac 1")
    out = f"v({deck.node(0, 'GAGE_1')})"
    response = deck.run(["ac dec 20 1 1meg", "WRITE"], [out])[0]
    noise = deck.run([f"noise {out} Iin dec 10 0.1 1meg", "setplot noise2", "WRITE"], ["all"])[-1]
    return corner_hz([abs(f) for f in response["frequency"]], response[out]), noise_lsb(noise)


def relays(parts, work, copies=20):
    """Time from PE1 to the coils' operate current (3.75 V across it, most) and back to its release (0.4 V, least), ms. All
    fourteen coils are one here; their contacts follow within what the data sheet says."""
    deck = Deck(work, "bridge-relays")
    mine = [p for r, p in parts.items() if r.endswith("/K1") and r.startswith("G") or r in {"Q201", "R201", "R202", "D201"}]
    for copy in range(copies):
        deck.place(copy, mine, Draw(f"relay {copy}"))
        rails(deck, copy, {"5V": 5, "2V5G": 2.5})
        deck.add(f"Rpin{copy} pin {deck.node(copy, 'SHUNTS')} 30")
    deck.add("Vpin pin 0 pwl(0 0 0.1m 0 0.1001m 3.3 3m 3.3 3.0001m 0)")
    names = [f"i(l{copy}_g1_k1)" for copy in range(copies)]
    plot = deck.run(["tran 5u 6m 0 5u", "WRITE"], [f"@l{c}_g1_k1[i]" for c in range(copies)], 60)[0]
    operate, release = [], []
    for copy in range(copies):
        amps = plot.get(f"i(@l{copy}_g1_k1[i])") or plot.get(f"@l{copy}_g1_k1[i]") or plot[names[copy]]
        up = [t for t, a in zip(plot["time"], amps) if a >= 3.75 / 500]
        down = [t for t, a in zip(plot["time"], amps) if t > 3e-3 and a <= 0.4 / 500]
        operate.append(up[0] - 0.1e-3 if up else math.nan)
        release.append(down[0] - 3e-3 if down else math.nan)
    return max(operate) * 1e3, max(release) * 1e3


def reference_rule(parts, work):
    """Rule 1: the volts follow the reference and not VDDA. Relative deviations with the reference 1 % low, and with VDDA 2 % low."""
    def volts(**supplies):
        return state(parts, work, 200, spread=0, copies=1, supplies=supplies)[0] * V_PER_LB + 0.4
    usual = volts()
    return volts(**{"2V5G": 2.475, "0V4": 0.396}) / usual / 0.99 - 1, volts(VDDA=VDDA * 0.98) / usual - 1


def figures(parts, work):
    zero = state(parts, work)
    loaded = state(parts, work, 200)
    low, high = state(parts, work, turned=[0.0] * COPIES), state(parts, work, turned=[1.0] * COPIES)
    shunt = state(parts, work, closed=True)
    turned = trimmed(parts, work, zero, low, high)
    left = state(parts, work, turned=turned)
    warm = state(parts, work, turned=turned, warmer_k=10)
    nominal = state(parts, work, 200, spread=0, copies=1)[0] - state(parts, work, spread=0, copies=1)[0]
    step = state(parts, work, closed=True, spread=0, copies=1)[0] - state(parts, work, spread=0, copies=1)[0]
    gains = [(l - z) / 200 for l, z in zip(loaded, zero)]
    steps = [(s - z) / g for s, z, g in zip(shunt, zero, gains)]
    beyond = sum(t in (0.0, 1.0) for t in turned) / COPIES
    corner, noise = small_signal(parts, work)
    with_reference, with_vdda = reference_rule(parts, work)
    operate_ms, release_ms = relays(parts, work)
    part, near = block(parts), around(parts)
    return [
        ("gage_v_per_lb", nominal / 200 * V_PER_LB, "V/lb", "nominal sensitivity"),
        ("gage_gain_sd_rel", deviation(gains) / mean(gains), "1", f"standard deviation between channels, {COPIES} simulated circuits, without the gage factor"),
        ("gage_zero_sd_lb", deviation(zero), "lb", "standard deviation of the zero before trimming, gage tolerance 0.3 %"),
        ("gage_trim_range_lb", min(min(abs(h - z), abs(z - l)) for z, l, h in zip(zero, low, high)), "lb", "smallest range of the trimmer, in each direction"),
        ("gage_untrimmable_share", beyond, "1", "share of simulated circuits that the trimmer cannot balance"),
        ("gage_trim_residual_lb", deviation(left), "lb", "standard deviation of the zero after trimming to 0.01 % of the trimmer's voltage"),
        ("gage_drift_lb_k", deviation([(w - l) / 10 for w, l in zip(warm, left)]), "lb/K",
         "standard deviation of the zero drift caused by amplifier, trimmer and resistors, without the gages"),
        ("gage_shunt_lb", step / (nominal / 200), "lb", "nominal step of the shunt"),
        ("gage_shunt_error_rel", deviation(steps) / 40, "1", "standard deviation of the shunt step between channels, relative to 40 lb"),
        ("gage_reference_rel", with_reference, "1", "rule 1: residual error with the reference 1 % low, reading taken as ratio to the reference"),
        ("gage_vdda_rel", with_vdda, "1", "rule 1: change of the voltage with VDDA 2 % low"),
        ("gage_noise_lsb", noise, "LSB", "standard deviation at the converter, 0.1 Hz to 1 MHz"),
        ("gage_kick_rel", kick(work, "bridge", part, "GAGE_1", near), "1", "share of the previous channel's voltage that remains in a reading"),
        ("gage_source_ohm", source_ohm(work, "bridge", part, "GAGE_1", near), "Ohm", "source resistance at the converter"),
        ("gage_corner_hz", corner, "Hz", "-3 dB from the bridge to the converter"),
        ("relay_operate_ms", operate_ms + 0.5, "ms",
         "time from PE1 high until the contact is closed (coil 0.1 H assumed, contact 0.5 ms with bounce), maximum of 20 simulated circuits"),
        ("relay_release_ms", release_ms + 0.2, "ms", "time from PE1 low until the contact is open (coil with its diode, contact 0.2 ms), maximum of 20 simulated circuits"),
        ("relay_bounce_ms", 0.25, "ms", "bounce time of the contact, assumed to be half of its operate time of 0.5 ms"),
    ]
