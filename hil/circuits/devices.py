"""What the parts do, as ngspice models: each number is of its data sheet, or says what it is instead.
`draw` gives a part of this copy its own errors: draw.within(x) is uniform in +-x, draw.between(a, b) too."""

# Op amp MCP6021 (DS20001685): 10 MHz, 7 V/us, 8.7 nV/rtHz at 10 kHz, offset 500 uV most, open loop 110 dB typical;
# the output resistance of 30 Ohm is assumed. A resistor without current makes the noise: 4 k T R = en^2, 4.57 kOhm.
# Instrumentation amplifier INA826 (SBOS562): gain 1 + 49.4 kOhm / RG, 0.15 % at 100; input stage 18 nV/rtHz (19.6 kOhm),
# offset 150 uV, 2 uV/K; output stage 700 uV; the bandwidth at a gain of 346 is 17 kHz between 60 kHz at 100 and
# 6 kHz at 1000. Voltages at its inputs may reach V+ - 1 V; its inner outputs stand 0.8 V above its inputs.
LIBRARY = """
.subckt opamp inp inn out vp vn vos=0
rn inp n1 4.57k
bi 0 x i=7e-3*tanh((v(n1)-v(inn)+{vos})*6.283e7/7e6)
cx x 0 1n
rx x 0 5meg
bc x 0 i=max(0,v(x)-v(vp))+min(0,v(x)-v(vn))
bo o 0 v=min(max(v(x),v(vn)+0.015),v(vp)-0.015)
ro o out 30
.ends
.subckt ina826 inp inn rgp rgm out ref vp vn vosi=0 voso=0 gerr=0
rn inp n1 19.6k
b1 p1 0 v=v(n1)+{vosi}
v1 p1 rgp 0
b2 p2 0 v=v(inn)
v2 p2 rgm 0
bd d 0 v=(v(n1)-v(inn)+{vosi}+i(v1)*49.4k)*(1+{gerr})+{voso}
rf d f 1
cf f 0 9.36u
bo o 0 v=min(max(v(f)+v(ref),v(vn)+0.1),v(vp)-0.15)
ro o out 10
.ends
.subckt buffer a y vcc r=15
bo o 0 v=0.5*v(vcc)*(1+tanh(8*(v(a)-0.5*v(vcc))))
ro o y {r}
.ends
.subckt schmitt_inverter a y vcc gnd vt=1.5 vh=0.35 r=12
bc c 0 v=-v(a)
sh y vcc c 0 up
.model up sw vt={-vt} vh={vh} ron={r} roff=1g
sl y gnd a 0 down
.model down sw vt={vt} vh={vh} ron={r} roff=1g
.ends
.subckt comparator inp inn out vn vos=0
bd d 0 v=v(inp)-v(inn)+{vos}
rd d e 1k
cd e 0 0.3n
bo f 0 v=5*tanh(v(e)*2000)
so out vn 0 f off
.model off sw vt=0 vh=0.2 ron=40 roff=1g
.ends
.subckt one_shot b rcx cx q vcc gnd vth=2.08 vtr=1.6
* set by B above its threshold, reset by the capacitor above the upper one: the latch is x
bset s 0 v=v(b)>{vtr} ? 1 : 0
rs s s2 1k
cs s2 0 2n
bres r 0 v=v(rcx,cx)>{vth} ? 1 : 0
bx y 0 v=v(s)-v(s2)>0.5 ? 1 : v(r)>0.5 ? 0 : v(x)>0.5 ? 1 : 0
rx y x 1k
cx x 0 50p
bg g 0 v=v(x)>0.5 ? 0 : 1
sd rcx gnd g 0 disch
.model disch sw vt=0.5 vh=0.1 ron=20 roff=1g
vg cx gnd 0
bq o 0 v=v(x)>0.5 ? v(vcc) : 0
rq o q 20
.ends
.model bas70 d(is=0.28n n=1.05 rs=15 cjo=2p)
.model 1n4148w d(is=2.5n n=1.75 rs=0.6 cjo=2p)
.model ss34 d(is=10u n=1.05 rs=0.03)
.model z10 d(is=1n n=1.1 bv=10 ibv=5m)
.model bcp56 npn(is=3e-14 bf=150 vaf=80 cje=80p cjc=15p tf=1n)
.model ao3400a vdmos(nchan vto=1.1 kp=25 rd=18m rs=2m cgs=0.6n cgdmin=30p cgdmax=0.2n is=1p)
.model 2n7002 vdmos(nchan vto=2.0 kp=0.3 rd=1.2 rs=0.1 cgs=30p cgdmin=3p cgdmax=20p is=1p)
.model irlml0030 vdmos(nchan vto=1.7 kp=30 rd=15m rs=2m cgs=0.35n cgdmin=20p cgdmax=0.15n is=1p)
"""

DIODES = {"BAS70H": "bas70", "1N4148W": "1n4148w", "SS34": "ss34", "BZX384-C10": "z10"}
# W/o an entry a part is not simulated: that it is one of these is checked where a block is taken.
SILENT = {"CONNECTOR", "TVS", "CRYSTAL", "STM32F407ZG", "FLASH", "CAN_TRANSCEIVER", "THERMOMETER"}


def resistor(name, part, node, draw):
    """Coefficient of temperature: 25 ppm/K of those to 0.1 %, 100 ppm/K of others."""
    tolerance = part.tolerance()
    ohm = part.value() * (1 + draw.within(tolerance))
    ohm *= 1 + draw.within(25e-6 if tolerance <= 0.001 else 100e-6) * draw.warmer_k
    return [f"R{name} {node('1')} {node('2')} {ohm:.12g}"]


def capacitor(name, part, node, draw):
    farad = part.value() * (1 + draw.within(part.tolerance()))
    return [f"C{name} {node('1')} {node('2')} {farad:.9g}"]


def diode(name, part, node, draw):
    return [f"D{name} {node('A')} {node('K')} {DIODES[part['value'] or part['part']]}"]


def clamp(name, part, node, draw):
    return [f"D{name}a {node('A')} {node('M')} bas70", f"D{name}b {node('M')} {node('K')} bas70"]


def tvs(name, part, node, draw):
    """Only the Zener at a gate does something in normal use."""
    return diode(name, part, node, draw) if part["value"] in DIODES else []


def opamp(name, part, node, draw):
    pins = " ".join(node(p) for p in ("IN+", "IN-", "OUT", "V+", "V-"))
    return [f"X{name} {pins} opamp vos={draw.within(500e-6):.9g}"]


def ina826(name, part, node, draw):
    pins = " ".join(node(p) for p in ("IN+", "IN-", "RG+", "RG-", "OUT", "REF", "V+", "V-"))
    offset_v = draw.within(150e-6) + draw.within(2e-6) * draw.warmer_k
    return [f"X{name} {pins} ina826 vosi={offset_v:.9g} voso={draw.within(700e-6):.9g} gerr={draw.within(0.0015):.9g}"]


def dual_buffer(name, part, node, draw):
    """74LVC2G34 at 2.5 V: VOL is 0.3 V most at 8 mA and 2.3 V, 37 Ohm; 10 to 20 Ohm at 25 C is assumed."""
    return [f"X{name}{n} {node(n + 'A')} {node(n + 'Y')} {node('VCC')} buffer r={draw.between(10, 20):.9g}" for n in "12"]


def schmitt_inverter(name, part, node, draw):
    """74LVC1G14 at 3.3 V: thresholds 1.3 to 2.2 V and 0.8 to 1.5 V from lot to lot; 8 to 16 Ohm is assumed."""
    upper, lower = draw.between(1.5, 2.0), draw.between(0.8, 1.3)
    pins = " ".join(node(p) for p in ("A", "Y", "VCC", "GND"))
    return [f"X{name} {pins} schmitt_inverter vt={(upper + lower) / 2:.9g} vh={(upper - lower) / 2:.9g} r={draw.between(8, 16):.9g}"]


def comparator(name, part, node, draw):
    """LMV331: offset 7 mV most."""
    pins = " ".join(node(p) for p in ("IN+", "IN-", "OUT", "V-"))
    return [f"X{name} {pins} comparator vos={draw.within(7e-3):.9g}"]


def one_shot(name, part, node, draw):
    """SN74LVC1G123: pulse of K R C, K within 0.9 to 1.1 at 10 nF. The capacitor is charged to 1 - exp(-K) of VCC."""
    import math
    share = 1 - math.exp(-draw.between(0.9, 1.1))
    pins = " ".join(node(p) for p in ("B", "RCX", "CX", "Q", "VCC", "GND"))
    return [f"X{name} {pins} one_shot vth={3.3 * share:.9g} vtr={draw.between(1.5, 2.0):.9g}"]


def nmos(name, part, node, draw):
    return [f"M{name} {node('D')} {node('G')} {node('S')} {part['value'].lower()}"]


def npn(name, part, node, draw):
    return [f"Q{name} {node('C')} {node('B')} {node('E')} {part['value'].lower()}"]


def trimmer(name, part, node, draw):
    ohm = part.value() * (1 + draw.within(part.tolerance())) * (1 + draw.within(100e-6) * draw.warmer_k)
    turned = draw.turned
    return [f"R{name}a {node('CCW')} {node('W')} {max(ohm * turned, 1):.9g}", f"R{name}b {node('W')} {node('CW')} {max(ohm * (1 - turned), 1):.9g}"]


def fuse(name, part, node, draw):
    return [f"R{name} {node('1')} {node('2')} 0.1"]


def bead(name, part, node, draw):
    return [f"R{name} {node('1')} {node('2')} 0.38"]


def reed_relay(name, part, node, draw):
    """Coil 500 Ohm +-10 %; its inductance of 0.1 H is assumed. The contact is set by the simulation."""
    ohm = 500 * (1 + draw.within(0.1))
    return [f"R{name} {node('COIL+')} {name}l {ohm:.9g}", f"L{name} {name}l {node('COIL-')} 0.1",
            f"R{name}c {node('A')} {node('B')} {0.2 if draw.closed else 1e12:g}"]


def reference(name, part, node, draw):
    """REF5025 high grade: 0.05 % most; 20 ppm/mA."""
    return [f"V{name} {name}v 0 {2.5 * (1 + draw.within(0.0005)):.9g}", f"R{name} {name}v {node('VOUT')} 0.05",
            f"R{name}t {node('TRIM')} 0 1meg", f"R{name}i {node('VIN')} 0 5k"]


MODELS = {"RESISTOR": resistor, "CAPACITOR": capacitor, "DIODE": diode, "CLAMP": clamp, "OPAMP": opamp, "INA826": ina826,
          "DUAL_BUFFER": dual_buffer, "SCHMITT_INVERTER": schmitt_inverter, "COMPARATOR": comparator, "ONE_SHOT": one_shot,
          "NMOS": nmos, "NPN": npn, "TRIMMER": trimmer, "FUSE": fuse, "BEAD": bead, "REED_RELAY": reed_relay,
          "REFERENCE": reference, "TVS": tvs}
