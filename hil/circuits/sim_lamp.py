"""The warning lamp: its currents from a filament's physics, and when PE3 shows them."""
import math

from deck import Deck, Draw, at, deviation, mean, rails

COPIES = 20
# Filament of 12 V, 5 W from tungsten's own constants: resistivity 5.65e-8 Ohm m x (T/300)^1.2, total emissivity 0.3 at
# 2500 K, density 19300 kg/m3, 132 J/(kg K) at 300 K to 165 at 2500 K, 150 taken. Length and diameter follow from 28.8 Ohm
# and 5 W radiated at 2500 K.
V, WATT, HOT_K, COLD_K = 12.0, 5.0, 2500.0, 300.0
SIGMA, EMISSIVITY, DENSITY, HEAT = 5.67e-8, 0.3, 19300.0, 150.0


def resistivity(kelvin):
    return 5.65e-8 * (kelvin / 300) ** 1.2


def filament():
    """Ohm when hot, J/K, W/K^4."""
    ohm = V * V / WATT
    area = WATT / (EMISSIVITY * SIGMA * HOT_K ** 4)  # pi d l
    slender = ohm / resistivity(HOT_K)               # 4 l / (pi d^2)
    d = (4 * area / (math.pi ** 2 * slender)) ** (1 / 3)
    length = area / (math.pi * d)
    return ohm, HEAT * DENSITY * math.pi / 4 * d * d * length, WATT / HOT_K ** 4


def lamp(deck, copy, a, b):
    ohm, heat, loss = filament()
    deck.add(f"Blamp{copy} {a} {b} i=v({a},{b})/({ohm}*pow(max(v(hot{copy}),200)/{HOT_K},1.2))",
             f"Bheat{copy} 0 hot{copy} i=v({a},{b})*v({a},{b})/({ohm}*pow(max(v(hot{copy}),200)/{HOT_K},1.2)) - {loss}*(pow(v(hot{copy}),4)-pow({COLD_K},4))",
             f"Cheat{copy} hot{copy} 0 {heat} ic={COLD_K}", f"Rheat{copy} hot{copy} 0 1e9")


def block(parts):
    return [p for r, p in parts.items() if len(r) == 4 and r[1] == "4" and r[0] != "J"]


def build(parts, work, name, copies, fitted):
    deck = Deck(work, name)
    for copy in range(copies):
        deck.place(copy, block(parts), Draw(f"lamp {copy}", float(copies > 1)))
        rails(deck, copy, {"12V": V, "3V3": 3.3})
        if fitted:
            lamp(deck, copy, *(deck.node(copy, parts["J401"].net(n)) for n in "12"))
        deck.add(f"Rpin{copy} pin {deck.node(copy, 'WARNING')} 30")
    return deck


def thresholds(parts, work, copies=COPIES):
    """Current at which PE3 falls, by a current that rises slowly through the sense resistor."""
    deck = build(parts, work, "lamp-threshold", copies, False)
    deck.add("Vpin pin 0 3.3")
    for copy in range(copies):
        deck.add(f"Iramp{copy} 0 {deck.node(copy, parts['R405'].net('1'))} pwl(0 0 10m 1)")
    names = [f"v({deck.node(c, 'LAMP')})" for c in range(copies)]
    plot = deck.run(["tran 20u 10m 0 20u", "WRITE"], names, 60)[0]
    return [next((t / 10e-3 for t, v in zip(plot["time"], plot[n]) if v < 1.65), math.nan) for n in names]


def switched(parts, work):
    """On at 1 ms, off at 301 ms: times, current, PE3."""
    deck = build(parts, work, "lamp-switched", 1, True)
    deck.add("Vpin pin 0 pwl(0 3.3 1m 3.3 1.0001m 0 301m 0 301.0001m 3.3)")
    sense, out = f"v({deck.node(0, parts['R405'].net('1'))})", f"v({deck.node(0, 'LAMP')})"
    deck.add(f".ic v(hot0)={COLD_K}")
    plot = deck.run(["tran 50u 303m 0 50u", "WRITE"], [sense, out], 90, "method=gear")[0]
    return plot["time"], [v / parts["R405"].value() for v in plot[sense]], plot[out]


def fast(parts, work, on, copies=COPIES):
    """From PE0's edge to PE3's, us; the lamp cold when it goes on, hot (28.8 Ohm) when it goes off."""
    deck = build(parts, work, "lamp-fast", copies, False)
    deck.add(f"Vpin pin 0 pwl(0 {3.3 if on else 0} 20u {3.3 if on else 0} 20.01u {0 if on else 3.3})")
    for copy in range(copies):
        deck.add(f"Rlamp{copy} {' '.join(deck.node(copy, parts['J401'].net(n)) for n in '12')} {V * V / WATT * ((COLD_K / HOT_K) ** 1.2 if on else 1)}")
    names = [f"v({deck.node(c, 'LAMP')})" for c in range(copies)]
    plot = deck.run(["tran 0.05u 120u 0 0.05u", "WRITE"], names, 60)[0]
    found = []
    for n in names:
        after = [t for t, v in zip(plot["time"], plot[n]) if t > 20e-6 and ((v < 1.65) if on else (v > 1.65))]
        found.append((after[0] - 20e-6) * 1e6 if after else math.nan)
    return max(found)


def undriven(parts, work):
    """Amperes through a hot lamp with PE0 floating and with no 3.3 V: both must warn."""
    deck = Deck(work, "lamp-undriven")
    for copy, volt in ((0, 3.3), (1, 0)):
        deck.place(copy, block(parts), Draw(0, 0))
        rails(deck, copy, {"12V": V, "3V3": volt})
        deck.add(f"Rlamp{copy} {' '.join(deck.node(copy, parts['J401'].net(n)) for n in '12')} {V * V / WATT}")
    names = [f"v({deck.node(c, parts['R405'].net('1'))})" for c in (0, 1)]
    plot = deck.run(["op", "WRITE"], names)[0]
    return min(plot[n][0] for n in names) / parts["R405"].value()


def figures(parts, work):
    times, amps, pin = switched(parts, work)
    hot = at(times, amps, 300e-3)
    cold = max(a for t, a in zip(times, amps) if t < 20e-3)
    level = thresholds(parts, work)
    return [
        ("lamp_cold_a", cold, "A", "peak current when switched on cold, tungsten filament"),
        ("lamp_hot_a", hot, "A", "current 300 ms after switching on"),
        ("lamp_sense_us", fast(parts, work, True), "us", "time from PE0 low to PE3 low, maximum of 20 simulated circuits"),
        ("lamp_clear_us", fast(parts, work, False), "us", "time from PE0 high to PE3 high, maximum of 20 simulated circuits"),
        ("lamp_sense_threshold_a", mean(level), "A", "lamp current above which PE3 is low, mean"),
        ("lamp_sense_threshold_sd_a", deviation(level), "A", "standard deviation of this threshold"),
        ("lamp_undriven_a", undriven(parts, work), "A", "lamp current with PE0 floating or without 3.3 V: the lamp is on"),
        ("is_lamp_sense_right", float(at(times, pin, 299e-3) < 0.8 and at(times, pin, 0.9e-3) > 2.5 and at(times, pin, 302e-3) > 2.5), "1",
         "1: PE3 is low while the lamp is on and high while it is off"),
    ]
