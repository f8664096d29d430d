"""What is measured of any channel in the same way: what the converter sees, and what its neighbour leaves."""
import math

from deck import Deck, Draw, at

VDDA = 3.3
LSB_V = VDDA / 4096
# Converter: sampling capacitor 4 pF, switch 6 kOhm most (STM32F407 data sheet, ADC characteristics); 112 of 124 cycles of
# 21 MHz sample, each channel once in 125 us (firmware/f407/scan.c).
SAMPLE_F, SAMPLE_OHM = 4e-12, 6e3
SAMPLE_S, CONVERT_S, SCAN_S = 112 / 21e6, 124 / 21e6, 125e-6
TRIGGER_S = (2352 - 2) / 84e6  # after the excitation's reversal


def mean(values):
    return sum(values) / len(values)


def deviation(values):
    middle = mean(values)
    return math.sqrt(sum((v - middle) ** 2 for v in values) / (len(values) - 1))


def rails(deck, copy, volts):
    """The supplies of a copy, stiff."""
    for net, volt in volts.items():
        node = deck.node(copy, net)
        deck.add(f"Vrail_{node} {node} 0 {volt}")


def source_ohm(work, name, parts, net, surround):
    """Resistance that the converter sees at direct current. surround(deck, copy) adds supplies and sensor."""
    deck = Deck(work, name + "-source")
    deck.place(0, parts, Draw(0, 0))
    surround(deck, 0)
    node = deck.node(0, net)
    deck.add(f"Iprobe 0 {node} dc 0 ac 1")
    plot = deck.run(["ac lin 1 0.01 0.01", "WRITE"], [f"v({node})"])[0]
    return abs(plot[f"v({node})"][0])


def kick(work, name, parts, net, surround, scans=24):
    """Part of the difference to the channel converted before that is left in a reading, once it is steady: two copies,
    whose capacitors come with 0 V and with 1 V more."""
    deck = Deck(work, name + "-kick")
    for copy in (0, 1):
        deck.place(copy, parts, Draw(0, 0))
        surround(deck, copy)
        node = deck.node(copy, net)
        deck.add(f"Bprevious p{copy} 0 v=v({node})+{copy}", f"Sload p{copy} s{copy} load 0 take", f"Ssample {node} t{copy} sample 0 take",
                 f"Rswitch{copy} t{copy} s{copy} {SAMPLE_OHM}", f"Csample{copy} s{copy} 0 {SAMPLE_F}")
        deck.lines[-5:] = [line.replace("Bprevious", f"Bprevious{copy}").replace("Sload", f"Sload{copy}").replace("Ssample", f"Ssample{copy}")
                           for line in deck.lines[-5:]]
    # The capacitor takes its neighbour's voltage for 1 us, lets go, and samples.
    deck.add(".model take sw vt=0.5 vh=0.01 ron=10 roff=1e13",
             f"Vload load 0 pulse(0 1 10u 1n 1n 1u {SCAN_S})", f"Vsample sample 0 pulse(0 1 11.1u 1n 1n {SAMPLE_S} {SCAN_S})")
    end = (scans - 1) * SCAN_S + 11.1e-6 + SAMPLE_S
    plot = deck.run([f"tran 50n {end + 1e-6} {end - 1e-6} 0.2u", "WRITE"], ["v(s0)", "v(s1)"])[0]
    return at(plot["time"], plot["v(s1)"], end - 5e-9) - at(plot["time"], plot["v(s0)"], end - 5e-9)


def corner_hz(frequencies, gains):
    """Where the gain has fallen by 3 dB from its first value."""
    limit = abs(gains[0]) / math.sqrt(2)
    for i in range(1, len(gains)):
        if abs(gains[i]) < limit:
            a, b = math.log(abs(gains[i - 1])), math.log(abs(gains[i]))
            share = (a - math.log(limit)) / (a - b)
            return frequencies[i - 1] * (frequencies[i] / frequencies[i - 1]) ** share
    return math.nan


def noise_lsb(plot):
    """Standard deviation at the output of a noise analysis, in codes of the converter."""
    total = next(v for k, v in plot.items() if k.startswith("v(onoise_total") or k == "onoise_total")
    return abs(total[0]) / LSB_V
