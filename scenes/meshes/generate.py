#!/usr/bin/env python3
"""Writes the instruments' meshes: one OBJ a link and tool, millimetres, in the link frames of robot/tool.hpp.

    python3 scenes/meshes/generate.py            # from the repository's root; rewrites the OBJ files beside it

Dimensions: 8.4 mm shaft, wrist-pitch to wrist-yaw axis 9.1 mm (ProGrasp 10.7 mm), jaws 11 mm beyond the yaw axis, from
dVRK's tool files; outlines are our own after photographs of EndoWrist instruments. Links: shaft (origin on the
wrist-pitch axis, z distal), wrist (same origin), jaw_left and jaw_right (origin on the wrist-yaw axis, y the pin; the
left one opens towards +x). Materials are named; render/instrument.cpp says how each looks.
"""
import math
import os

CREASE_COS = math.cos(math.radians(38.0))


def sub(a, b):
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def unit(a):
    n = math.sqrt(dot(a, a))
    return (a[0] / n, a[1] / n, a[2] / n) if n > 1e-12 else (0.0, 0.0, 1.0)


class Mesh:
    """Polygons by material, made of closed solids; overlaps are fine."""

    def __init__(self):
        self.faces = {}

    def add(self, material, polygons):
        """Outward counter-clockwise polygons of one closed solid; turned if the solid is inside out."""
        volume = 0.0
        for p in polygons:
            for i in range(1, len(p) - 1):
                volume += dot(p[0], cross(p[i], p[i + 1]))
        self.faces.setdefault(material, []).extend(
            [list(reversed(p)) for p in polygons] if volume < 0.0 else polygons)

    def write(self, path, mirror=False):
        vertices, normals, lines = {}, {}, []

        def index(table, v):
            return table.setdefault(tuple(round(c, 5) + 0.0 for c in v), len(table) + 1)

        for material in sorted(self.faces):
            triangles = []
            for p in self.faces[material]:
                if mirror:
                    p = [(-x, y, z) for x, y, z in reversed(p)]
                for i in range(1, len(p) - 1):
                    t = (p[0], p[i], p[i + 1])
                    n = cross(sub(t[1], t[0]), sub(t[2], t[0]))
                    if dot(n, n) > 1e-12:
                        triangles.append((t, n))
            around = {}
            for t, n in triangles:
                for v in t:
                    around.setdefault(index(vertices, v), []).append(n)
            lines.append(f"usemtl {material}")
            for t, n in triangles:
                corners = []
                for v in t:
                    i = index(vertices, v)
                    near = [m for m in around[i] if dot(unit(m), unit(n)) > CREASE_COS]
                    mean = unit(tuple(sum(m[c] for m in near) for c in range(3)))
                    corners.append(f"{i}//{index(normals, tuple(round(c, 3) for c in mean))}")
                lines.append("f " + " ".join(corners))
        with open(path, "w", encoding="ascii") as out:
            out.write("# made by scenes/meshes/generate.py; millimetres\n")
            for v in vertices:
                out.write("v %.5g %.5g %.5g\n" % v)
            for n in normals:
                out.write("vn %.3g %.3g %.3g\n" % n)
            out.write("\n".join(lines) + "\n")


def loft(sections):
    """Closed sections of equal size, joined and capped."""
    polygons = [list(sections[0]), list(reversed(sections[-1]))]
    for a, b in zip(sections, sections[1:]):
        n = len(a)
        for i in range(n):
            k = (i + 1) % n
            polygons.append([a[k], a[i], b[i], b[k]])
    return polygons


def ring(radius, z, n=40):
    return [(radius * math.cos(2 * math.pi * i / n), radius * math.sin(2 * math.pi * i / n), z) for i in range(n)]


def lathe(profile, axis="z", centre=(0.0, 0.0, 0.0), n=40):
    """Solid of revolution of (radius, height) pairs about an axis through a point."""
    turn = {"z": lambda p: p, "x": lambda p: (p[2], p[0], p[1]), "y": lambda p: (p[1], p[2], p[0])}[axis]
    moved = []
    for radius, height in profile:
        moved.append([tuple(turn(p)[c] + centre[c] for c in range(3)) for p in ring(max(radius, 1e-3), height, n)])
    return loft(moved)


def disc(radius, low, high, axis, centre=(0.0, 0.0, 0.0), bevel=0.25, n=36):
    return lathe([(radius - bevel, low), (radius, low + bevel), (radius, high - bevel), (radius - bevel, high)], axis,
                 centre, n)


def superellipse(cx, cy, hx, hy, z, power=4.0, n=28):
    points = []
    for i in range(n):
        a = 2 * math.pi * (i + 0.5) / n
        c, s = math.cos(a), math.sin(a)
        points.append((cx + hx * math.copysign(abs(c) ** (2 / power), c), cy + hy * math.copysign(abs(s) ** (2 / power), s), z))
    return points


def prongs(mesh, material, outer, inner, z0, z_pin, reach, along_x):
    """Two cheeks of a clevis: slices of a cylinder of radius `outer` beyond `inner`, rounded about the pin."""
    full = math.sqrt(outer * outer - inner * inner) * 0.985
    heights = [z0, z_pin - 0.2]
    heights += [z_pin + reach * math.sin(math.radians(a)) for a in range(4, 91, 8)]
    for side in (1.0, -1.0):
        sections = []
        for z in heights:
            above = max(0.0, (z - z_pin) / reach)
            half = min(full, (reach + 0.25) * math.sqrt(max(0.004, 1.0 - min(1.0, above) ** 2)) if z > z_pin else full)
            if z > z_pin:
                half = min(half, full)
            row = []
            for k in range(11):
                t = half * (2.0 * k / 10.0 - 1.0)
                row.append((side * math.sqrt(outer * outer - t * t) * (1.0 - 0.05 * above * above), t, z))
            for k in range(11):
                t = half * (1.0 - 2.0 * k / 10.0)
                row.append((side * inner, t, z))
            sections.append(row if along_x else [(y, x, zz) for x, y, zz in row])
        mesh.add(material, loft(sections))


def cable(mesh, points, radius=0.19, n=8):
    sections = []
    for i, p in enumerate(points):
        d = unit(sub(points[min(i + 1, len(points) - 1)], points[max(i - 1, 0)]))
        u = unit(cross(d, (0.3, 0.2, 0.93) if abs(d[2]) < 0.9 else (1.0, 0.0, 0.0)))
        v = cross(d, u)
        sections.append([tuple(p[c] + radius * (math.cos(2 * math.pi * k / n) * u[c] + math.sin(2 * math.pi * k / n) * v[c])
                               for c in range(3)) for k in range(n)])
    mesh.add("cable", loft(sections))


def shaft():
    mesh = Mesh()
    mesh.add("composite", lathe([(4.15, -400.0), (4.2, -399.9), (4.2, -17.0), (4.1, -16.9)], n=48))
    mesh.add("steel_dark", lathe([(4.0, -17.0), (4.0, -16.2)], n=48))
    mesh.add("steel", lathe([(4.05, -16.2), (4.2, -16.0), (4.2, -12.4), (4.05, -12.2), (3.9, -12.1), (3.9, -11.6),
                             (4.05, -11.5), (4.2, -11.3), (4.2, -6.6), (3.9, -5.8), (2.3, -5.0)], n=48))
    prongs(mesh, "steel", 4.15, 2.75, -7.0, 0.0, 2.4, True)
    for side in (1.0, -1.0):
        mesh.add("pin", disc(1.0, 2.9, 4.22, "x", bevel=0.2) if side > 0 else disc(1.0, -4.22, -2.9, "x", bevel=0.2))
    # The two screws of the clevis.
    for side in (1.0, -1.0):
        mesh.add("pin", disc(0.55, 3.6, 4.3, "y", (0.0, 0.0, -9.0), 0.1, 20) if side > 0 else
                 disc(0.55, -4.3, -3.6, "y", (0.0, 0.0, -9.0), 0.1, 20))
    return mesh


def wrist(length):
    mesh = Mesh()
    # Pulleys on the pitch axis, between the shaft's cheeks.
    for low, high in ((-2.65, -1.45), (-1.3, -0.1), (0.1, 1.3), (1.45, 2.65)):
        mesh.add("steel", lathe([(2.75, low), (3.15, low + 0.12), (2.85, low + 0.42), (2.85, high - 0.42),
                                 (3.15, high - 0.12), (2.75, high)], "x", n=36))
    body = [superellipse(0, 0, 1.5, 2.3, -0.5, 3.5), superellipse(0, 0, 2.2, 3.3, 1.6, 3.0),
            superellipse(0, 0, 2.5, 3.75, 2.9, 2.6), superellipse(0, 0, 3.45, 3.85, 3.9, 2.2),
            superellipse(0, 0, 3.75, 3.9, 4.6, 2.1), superellipse(0, 0, 3.7, 3.9, 5.2, 2.1),
            superellipse(0, 0, 2.9, 3.3, length - 3.3, 2.4)]
    mesh.add("steel", loft(body))
    prongs(mesh, "steel", 3.98, 2.6, 4.4, length, 2.3, False)
    for low, high in ((2.7, 4.12), (-4.12, -2.7)):
        mesh.add("pin", disc(1.0, low, high, "y", (0.0, 0.0, length), 0.2))
    # Cables from the pulleys to the jaws' hubs.
    for x in (-1.0, 1.0):
        for y in (-1.0, 1.0):
            cable(mesh, [(1.95 * x, 2.9 * y, -0.2), (2.1 * x, 3.05 * y, 1.5), (2.9 * x, 2.75 * y, 3.6), (3.1 * x, 1.9 * y, 5.2),
                         (2.75 * x, 1.3 * y, length - 1.6), (2.72 * x, 1.25 * y, length)])
    return mesh


def hub(mesh, low, high):
    """A jaw's disc on the pin, with the groove its cable runs in."""
    middle = 0.5 * (low + high)
    mesh.add("steel", lathe([(2.45, low), (2.7, low + 0.15), (2.7, middle - 0.3), (2.4, middle - 0.15),
                             (2.4, middle + 0.15), (2.7, middle + 0.3), (2.7, high - 0.15), (2.45, high)], "y", n=40))


def teeth(mesh, material, z0, z1, pitch, half_y, depth, base_x):
    """Serrations of a gripping face: ridges along y, tips on x = 0.02."""
    profile, z = [(base_x, z0)], z0
    while z + pitch < z1:
        profile += [(0.02 + depth, z), (0.02, z + 0.35 * pitch), (0.02, z + 0.65 * pitch)]
        z += pitch
    profile += [(0.02 + depth, z), (base_x, z)]
    width = half_y if callable(half_y) else (lambda _: half_y)
    low = [(x, -width(zz), zz) for x, zz in profile]
    high = [(x, width(zz), zz) for x, zz in profile]
    # The profile isn't convex: cap it in slices between its bottom and the teeth.
    polygons = []
    for i in range(len(profile) - 1):
        polygons.append([low[i], low[i + 1], high[i + 1], high[i]])
        for side, flip in ((low, False), (high, True)):
            base0, base1 = (base_x, side[i][1], side[i][2]), (base_x, side[i + 1][1], side[i + 1][2])
            cap = [side[i], base0, base1, side[i + 1]]
            polygons.append(list(reversed(cap)) if flip else cap)
    polygons.append([low[-1], low[0], high[0], high[-1]])
    mesh.add(material, polygons)


def needle_driver_jaw():
    mesh = Mesh()
    hub(mesh, 0.08, 2.45)
    sections = [superellipse(0.9, 1.1, 1.2, 1.1, 0.3), superellipse(1.45, 0.75, 1.25, 1.25, 1.6),
                superellipse(1.7, 0.25, 1.35, 1.55, 2.8), superellipse(1.75, 0.0, 1.45, 1.72, 3.8),
                superellipse(1.68, 0.0, 1.40, 1.70, 5.6), superellipse(1.42, 0.0, 1.18, 1.48, 7.4),
                superellipse(1.20, 0.0, 0.98, 1.30, 9.2), superellipse(1.00, 0.0, 0.79, 1.10, 10.3),
                superellipse(0.78, 0.0, 0.52, 0.78, 10.85), superellipse(0.65, 0.0, 0.28, 0.42, 11.0)]
    mesh.add("steel", loft(sections))
    teeth(mesh, "carbide", 3.0, 10.7, 0.46, lambda z: 1.30 - 0.055 * (z - 3.0), 0.16, 0.5)
    # The two grooves a needle driver's back carries.
    mesh.add("steel_dark", loft([superellipse(x, 0.0, 0.10, 0.16, z, 2.0, 12) for x, z in
                                 ((3.16, 3.5), (3.16, 4.4), (3.04, 5.6), (2.58, 7.4))]))
    return mesh


def prograsp_jaw():
    mesh = Mesh()
    hub(mesh, 0.08, 2.45)
    mesh.add("steel", loft([superellipse(0.9, 1.1, 1.2, 1.1, 0.3), superellipse(1.5, 0.75, 1.3, 1.3, 1.6),
                            superellipse(1.65, 0.2, 1.35, 1.75, 2.8), superellipse(1.55, 0.0, 1.3, 1.95, 3.7),
                            superellipse(1.40, 0.0, 1.1, 1.9, 4.4)]))
    # A window between two rails, closed by a broad nose.
    for side in (1.0, -1.0):
        mesh.add("steel", loft([superellipse(x, side * y, hx, 0.50, z) for z, x, y, hx in
                                ((4.0, 1.45, 1.32, 1.15), (5.5, 1.35, 1.38, 1.05), (7.2, 1.22, 1.26, 0.95), (9.2, 1.15, 1.18, 0.88))]))
        ridge = Mesh()
        teeth(ridge, "steel", 4.1, 9.1, 0.62, 0.42, 0.2, 0.6)
        for polygons in ridge.faces.values():
            mesh.add("steel", [[(x, y + side * 0.9, z) for x, y, z in p] for p in polygons])
    mesh.add("steel", loft([superellipse(1.18, 0.0, 0.92, 1.68, 8.7), superellipse(1.15, 0.0, 0.9, 1.62, 9.6),
                            superellipse(1.08, 0.0, 0.85, 1.36, 10.4), superellipse(0.95, 0.0, 0.66, 0.95, 10.9),
                            superellipse(0.85, 0.0, 0.36, 0.55, 11.1)]))
    teeth(mesh, "steel", 8.8, 10.8, 0.62, lambda z: 1.1 - 0.12 * (z - 8.8), 0.2, 0.5)
    return mesh


def blade(bow, tip_round, side):
    """A scissor blade lying at `side` of the plane y = bow: shearing face there, edge at x = -0.2, back at +x."""
    mesh = Mesh()
    hub(mesh, 0.06, 2.45) if side > 0 else hub(mesh, -2.45, -0.06)
    reach = 7.2 if bow > 0.0 else 7.45  # the bow turns the point away from its capsule
    heights = [1.2, 1.9, 2.6, 3.4] + [3.4 + reach * i / 18.0 for i in range(1, 19)]
    sections = []
    for z in heights:
        y0 = bow * (z / 11.0) ** 2 + side * 0.03
        along = max(0.0, (z - 3.4) / 7.45)
        back = 1.95 - 0.75 * along
        edge = -0.2
        if tip_round:
            end = max(0.0, (z - 9.6) / 1.25)
            shrink = math.sqrt(max(0.015, 1.0 - end * end))
            middle = 0.5 * (back + edge)
            back, edge = middle + (back - middle) * shrink, middle + (edge - middle) * shrink
        else:
            back = 1.95 - 0.5 * along - 1.35 * along ** 5
        thick = (1.05 - 0.42 * along)
        if z < 3.4:
            edge = -0.2 + 0.25 * (3.4 - z) / 2.2
            thick = 1.05 + 0.35 * (3.4 - z) / 2.2
        span = back - edge
        row = [(edge, y0, z), (edge + 0.12 * span, y0 + side * 0.30 * thick, z), (edge + 0.45 * span, y0 + side * 0.95 * thick, z),
               (edge + 0.8 * span, y0 + side * thick, z), (edge + 0.95 * span, y0 + side * 0.8 * thick, z),
               (back, y0 + side * 0.5 * thick, z), (edge + 0.96 * span, y0, z), (edge + 0.5 * span, y0, z)]
        sections.append(row)
    mesh.add("blade", loft(sections))
    y = side * 1.0
    mesh.add("steel", loft([superellipse(0.75, y, 1.2, 1.0, 0.2), superellipse(0.85, y, 1.1, 0.9, 1.4),
                            superellipse(0.85, side * 0.75, 0.95, 0.62, 2.4), superellipse(0.85, side * 0.66, 0.8, 0.42, 3.2)]))
    return mesh


def main():
    here = os.path.dirname(os.path.abspath(__file__))
    jaws = {
        "needle_driver": (9.1, needle_driver_jaw(), None),
        "prograsp": (10.7, prograsp_jaw(), None),
        "curved_scissors": (9.1, blade(1.5, False, 1.0), (1.5, False)),
        "round_tip_scissors": (9.1, blade(0.0, True, 1.0), (0.0, True)),
    }
    for name, (length, left, mirrored_blade) in jaws.items():
        folder = os.path.join(here, name)
        os.makedirs(folder, exist_ok=True)
        shaft().write(os.path.join(folder, "shaft.obj"))
        wrist(length).write(os.path.join(folder, "wrist.obj"))
        left.write(os.path.join(folder, "jaw_left.obj"))
        if mirrored_blade:
            blade(*mirrored_blade, -1.0).write(os.path.join(folder, "jaw_right.obj"), mirror=True)
        else:
            flip(left).write(os.path.join(folder, "jaw_right.obj"))


def flip(mesh):
    """Turned by half a turn about z: the other jaw of a pair."""
    other = Mesh()
    for material, polygons in mesh.faces.items():
        other.faces[material] = [[(-x, -y, z) for x, y, z in p] for p in polygons]
    return other


if __name__ == "__main__":
    main()
