#!/usr/bin/env python3
"""Draws the pictures of boundary conditions, docs/pictures/conditions/*.svg; `docs/manual/method/conditions.md` shows them.

Blue is fluid, orange is solid, a hatched line is fixed. Nothing but Python is needed.
"""
import math
import os

WIDTH, HEIGHT = 260, 130
INK, FLUID, SOLID, RED = "#333333", "#cfe3f5", "#f3cf9f", "#c0392b"
LEFT, RIGHT, TOP, BOTTOM = 60, 200, 25, 100


class Drawing:
    def __init__(self, title):
        self.parts = [
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}" '
            f'role="img" font-family="DejaVu Sans, Verdana, Arial, sans-serif" font-size="12">',
            f"<title>{title}</title>",
            f'<rect width="{WIDTH}" height="{HEIGHT}" rx="6" fill="#ffffff"/>']

    def area(self, color, left=LEFT, top=TOP, right=RIGHT, bottom=BOTTOM):
        self.parts.append(f'<rect x="{left}" y="{top}" width="{right - left}" height="{bottom - top}" fill="{color}"/>')

    def path(self, points, color=INK, width=1.5, fill="none", dash=""):
        d = "M" + " L".join(f"{x:.1f} {y:.1f}" for x, y in points)
        extra = f' stroke-dasharray="{dash}"' if dash else ""
        self.parts.append(f'<path d="{d}" fill="{fill}" stroke="{color}" stroke-width="{width}"{extra}/>')

    def line(self, a, b, color=INK, width=1.5, dash=""):
        self.path([a, b], color, width, dash=dash)

    def arrow(self, a, b, color=RED, both=False):
        self.line(a, b, color, 1.6)
        angle = math.atan2(b[1] - a[1], b[0] - a[0])
        for (x, y), turn in [(b, angle)] + ([(a, angle + math.pi)] if both else []):
            wing = [(x - 7 * math.cos(turn + s), y - 7 * math.sin(turn + s)) for s in (0.4, -0.4)]
            self.path([wing[0], (x, y), wing[1]], color, 1.6, fill=color)

    def hatched(self, a, b, side):
        """A fixed line from a to b; `side` is where the hatching is, as a unit vector."""
        self.line(a, b, INK, 2)
        n = int(math.dist(a, b) // 8)
        for i in range(n + 1):
            x, y = (a[d] + (b[d] - a[d]) * i / n for d in (0, 1))
            self.line((x, y), (x + 7 * side[0] - 4 * side[1], y + 7 * side[1] - 4 * side[0]), INK, 1)

    def text(self, at, words, color=INK, anchor="middle", size=12):
        self.parts.append(f'<text x="{at[0]}" y="{at[1]}" fill="{color}" text-anchor="{anchor}" font-size="{size}">{words}</text>')

    def channel(self):
        """Fluid between two walls."""
        self.area(FLUID)
        self.hatched((LEFT, TOP), (RIGHT, TOP), (0, -1))
        self.hatched((LEFT, BOTTOM), (RIGHT, BOTTOM), (0, 1))

    def save(self, name):
        folder = os.path.join(os.path.dirname(os.path.abspath(__file__)), "conditions")
        os.makedirs(folder, exist_ok=True)
        with open(os.path.join(folder, name + ".svg"), "w") as file:
            file.write("\n".join(self.parts) + "\n</svg>\n")


def profile(drawing, x, length, way=1):
    """Arrows of a parabola at x."""
    points = []
    for i in range(9):
        s = i / 8
        y = TOP + s * (BOTTOM - TOP)
        reach = length * 4 * s * (1 - s)
        points.append((x + way * reach, y))
        if 0 < i < 8:
            drawing.arrow((x, y), (x + way * reach, y))
    drawing.path(points, RED, 1)


def spring(drawing, x, y, length):
    points = [(x, y), (x + 5, y)]
    points += [(x + 5 + (length - 10) * (i + 0.5) / 6, y + (5 if i % 2 else -5)) for i in range(6)]
    drawing.path(points + [(x + length - 5, y), (x + length, y)], INK, 1.3)


def velocity():
    d = Drawing("velocity: given velocities at an inlet")
    d.channel()
    profile(d, LEFT, 45)
    d.text((155, 58), "v = g(x, t)", size=11)
    d.text((155, 76), "u = 0", size=11)
    d.save("velocity")


def no_slip():
    d = Drawing("no-slip: the fluid rests at a wall")
    d.area(FLUID)
    d.hatched((LEFT, BOTTOM), (RIGHT, BOTTOM), (0, 1))
    for i in range(1, 6):
        y = BOTTOM - 12 * i
        d.arrow((100, y), (100 + 60 * (1 - (1 - i / 6) ** 2), y))
    d.path([(100 + 60 * (1 - (1 - i / 12) ** 2), BOTTOM - 6 * i) for i in range(12)], RED, 1)
    d.text((130, 18), "v = 0, u = 0")
    d.save("no-slip")


def clamped():
    d = Drawing("clamped: the body is held")
    d.path([(LEFT, 50), (120, 50), (RIGHT, 62), (RIGHT - 4, 88), (120, 76), (LEFT, 76)], INK, 1.5, fill=SOLID)
    d.hatched((LEFT, 35), (LEFT, 95), (-1, 0))
    d.text((130, 30), "u = 0, v = 0")
    d.save("clamped")


def do_nothing():
    d = Drawing("do-nothing: an outlet")
    d.channel()
    profile(d, RIGHT - 8, 45)
    d.line((RIGHT, TOP), (RIGHT, BOTTOM), INK, 1.5, dash="5 4")
    d.text((122, 60), "ρν ∇v n − p n = 0")
    d.text((122, 78), "as if it went on", size=10)
    d.save("do-nothing")


def traction_free():
    d = Drawing("traction-free: nothing acts there")
    d.path([(LEFT, 40), (140, 46), (RIGHT, 70), (RIGHT - 14, 96), (130, 78), (LEFT, 70)], INK, 1, fill=SOLID)
    d.hatched((LEFT, 30), (LEFT, 80), (-1, 0))
    d.path([(LEFT, 40), (140, 46), (RIGHT, 70), (RIGHT - 14, 96), (130, 78), (LEFT, 70)], INK, 2, dash="5 4")
    d.text((150, 25), "σ n = 0")
    d.save("traction-free")


def traction():
    d = Drawing("traction: a dead load per area of the body at rest")
    d.hatched((LEFT, 40), (LEFT, 100), (-1, 0))
    d.path([(LEFT, 58), (130, 62), (RIGHT, 82), (RIGHT - 8, 104), (125, 84), (LEFT, 80)], INK, 1.5, fill=SOLID)
    for x, y in [(85, 59), (110, 61), (135, 64), (160, 71), (185, 78)]:
        d.arrow((x, y - 32), (x, y - 2))
    d.text((215, 40), "P N = g")
    d.save("traction")


def pressure():
    d = Drawing("pressure: it follows the boundary in motion")
    d.hatched((LEFT, 40), (LEFT, 105), (-1, 0))
    top = [(LEFT + 140 * s, 58 + 26 * s * s) for s in [i / 14 for i in range(15)]]
    low = [(x - 22 * 26 * 2 * (x - LEFT) / 140 / 140, y + 22) for x, y in reversed(top)]
    d.path(top + low, INK, 1.5, fill=SOLID)
    for i in (2, 5, 8, 11, 13):
        (x, y), slope = top[i], 2 * 26 * (i / 14) / 140
        size = math.hypot(1, slope)
        n = (slope / size, -1 / size)
        d.arrow((x + 32 * n[0], y + 32 * n[1]), (x + 2 * n[0], y + 2 * n[1]))
    d.text((108, 20), "σ n = −P n")
    d.save("pressure")


def displacement():
    d = Drawing("displacement: a piston")
    d.area(FLUID, LEFT + 25)
    d.hatched((LEFT, TOP), (RIGHT, TOP), (0, -1))
    d.hatched((LEFT, BOTTOM), (RIGHT, BOTTOM), (0, 1))
    d.area("#777777", LEFT + 15, TOP + 2, LEFT + 25, BOTTOM - 2)
    d.arrow((LEFT - 15, 62), (LEFT + 45, 62), both=True)
    d.text((155, 58), "u = g(x, t)")
    d.text((155, 76), "v = ∂ₜu")
    d.save("displacement")


def slip():
    d = Drawing("slip: nothing flows through, no shear stress")
    d.area(FLUID, bottom=BOTTOM - 8)
    for x in range(LEFT + 8, RIGHT, 20):
        d.parts.append(f'<circle cx="{x}" cy="{BOTTOM - 4}" r="4" fill="none" stroke="{INK}" stroke-width="1.2"/>')
    d.hatched((LEFT, BOTTOM), (RIGHT, BOTTOM), (0, 1))
    for y in (40, 56, 72, 88):
        d.arrow((85, y), (145, y))
    d.text((130, 18), "n·v = 0, n·u = 0")
    d.save("slip")


def symmetry():
    d = Drawing("symmetry: half of the domain is enough")
    d.area(FLUID, top=TOP, bottom=64)
    d.area("#edf4fb", top=64)
    d.hatched((LEFT, TOP), (RIGHT, TOP), (0, -1))
    d.line((LEFT - 15, 64), (RIGHT + 15, 64), INK, 1.5, dash="12 4 2 4")
    for i, y in enumerate((34, 44, 54)):
        d.arrow((85, y), (115 + 12 * i, y))
        d.arrow((85, 128 - y), (115 + 12 * i, 128 - y), "#e0b4ae")
    d.text((130, 120), "n·v = 0, n·u = 0")
    d.save("symmetry")


def periodic():
    d = Drawing("periodic: what leaves on one side comes in on the other")
    d.channel()
    for x in (LEFT, RIGHT):
        d.line((x, TOP), (x, BOTTOM), INK, 2, dash="8 3")
        for y in (45, 62, 79):
            d.arrow((x - 18, y), (x + 18, y))
    d.text((130, 66), "v, u, p equal", size=11)
    d.save("periodic")


def bed():
    d = Drawing("spring: a bed of springs and dashpots")
    d.path([(LEFT - 20, 40), (LEFT + 70, 36), (LEFT + 74, 92), (LEFT - 20, 88)], INK, 1.5, fill=SOLID)
    for y in (44, 64, 84):
        spring(d, LEFT + 73, y, 50)
    d.hatched((LEFT + 123, 30), (LEFT + 123, 98), (1, 0))
    d.text((130, 18), "σ n = −(k u + c v) − P n")
    d.save("spring")


def circuit(name, title, text, with_capacitor):
    d = Drawing(title)
    d.area(FLUID, 20, 40, 80, 85)
    d.hatched((20, 40), (80, 40), (0, -1))
    d.hatched((20, 85), (80, 85), (0, 1))
    d.arrow((45, 62), (88, 62))
    d.text((60, 56), "Q")
    y = 62
    d.line((90, y), (105, y))
    resistor = lambda x: d.path([(x, y - 6), (x + 30, y - 6), (x + 30, y + 6), (x, y + 6), (x, y - 6)])
    resistor(105)
    if with_capacitor:
        d.text((120, y - 12), "R_p")
        d.line((135, y), (175, y))
        d.line((155, y), (155, y + 16))
        d.line((143, y + 16), (167, y + 16), INK, 2)
        d.line((143, y + 22), (167, y + 22), INK, 2)
        d.line((155, y + 22), (155, y + 36))
        d.line((147, y + 36), (163, y + 36))
        d.text((178, y + 24), "C")
        d.text((155, y - 12), "P_c")
        resistor(175)
        d.text((190, y - 12), "R_d")
        d.line((205, y), (225, y))
        d.text((238, y + 4), "P_d")
    else:
        d.text((120, y - 12), "R")
        d.line((135, y), (165, y))
        d.text((180, y + 4), "P_d")
    d.text((130, 20), text, size=9 if with_capacitor else 12)
    d.save(name)


def flux():
    d = Drawing("flux: the flow is given, the profile may be")
    d.channel()
    profile(d, LEFT, 45)
    d.arrow((LEFT - 45, 62), (LEFT - 8, 62))
    d.text((LEFT - 30, 54), "Q(t)", RED)
    d.text((155, 66), "∫ v·n ds = Q", size=11)
    d.save("flux")


if __name__ == "__main__":
    for draw in (velocity, no_slip, clamped, do_nothing, traction_free, traction, pressure, displacement, slip, symmetry, periodic,
                 bed, flux):
        draw()
    circuit("resistance", "resistance: the pressure of an outlet grows with its flow", "P = R Q + P_d", False)
    circuit("windkessel", "windkessel: an outlet with a capacitor", "P = R_p Q + P_c,  C dP_c/dt = Q − (P_c − P_d)/R_d", True)
