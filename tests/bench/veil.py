# SPDX-License-Identifier: Apache-2.0
"""Frames whose veil, illuminance, TI, UGR and DGP are known in closed form.

Everything here is from the publications, typed anew: CIE 146 (2002), the general
disability glare equation; CIE 140, threshold increment; CIE 117, UGR; Guth's position
index as IES has it and Iwata's below the line of sight; Wienold and Christoffersen 2006,
DGP. Frames are PFM, the light is in the middle pixel of an odd size, whose direction is
the axis, and the eye looks away from it: so its angle is exact.
"""
import array
import json
import math
import os
import subprocess
import tempfile

SIZE = 401


def write(path, light, w=SIZE, h=SIZE):
    """A grey PFM; `light` is (x, y) -> luminance, y down."""
    rows = array.array("f")
    for y in reversed(range(h)):
        for x in range(w):
            v = light(x, y)
            rows.extend((v, v, v))
    with open(path, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % (w, h))
        f.write(rows.tobytes())


def measure(glarepp, frame, *words):
    """The veil of a report."""
    out = subprocess.run([glarepp, "-q", "-t", "1e12", "--layer", "l.exr", "--report", "-", *words, frame],
                         check=True, capture_output=True).stdout
    return json.loads(out)["veil"]


def general(t, age, pigment):
    """CIE 146: L_v over E, per steradian, t in degrees."""
    a = 1 + (age / 62.5) ** 4
    return 10 / t ** 3 + (5 / t ** 2 + 0.1 * pigment / t) * a + 0.0025 * pigment


def points(glarepp):
    """Worst relative error of L_v and of E over angles, ages and projections."""
    mid, light = SIZE // 2, 2e5
    write("point.pfm", lambda x, y: light if x == mid and y == mid else 0)
    worst = {"veil": 0, "lux": 0}
    for how, fov in (("perspective", 40), ("fisheye", 90), ("equisolid", 90)):
        half = math.radians(fov / 2)
        k = (math.tan(half) if how == "perspective" else
             half if how == "fisheye" else 2 * math.sin(half / 2)) / (SIZE / 2)
        for t in (1, 2, 5, 10, 20, 30):
            r = math.radians(t)
            off = {"perspective": math.tan(r), "fisheye": r}.get(how, 2 * math.sin(r / 2)) / k
            for age, pigment in ((20, 0.5), (35, 1), (50, 0), (65, 0.5), (80, 1.2)):
                v = measure(glarepp, "point.pfm", "--projection", how, "--fov", str(fov),
                            "--luminance-scale", "3", "--fixation",
                            "%.9g,%.9g" % (mid + 0.5 + 0.6 * off, mid + 0.5 - 0.8 * off),
                            "-k", "cie:age=%g,pigment=%g" % (age, pigment))
                lux = 3 * light * k * k * math.cos(r)
                truth = lux * general(t, age, pigment)
                worst["veil"] = max(worst["veil"], abs(v["luminance"] / truth - 1),
                                    abs(v["luminance_of_sources"] / truth - 1))
                worst["lux"] = max(worst["lux"], abs(v["illuminance"] / lux - 1))
    return worst


def spheres(glarepp):
    """Worst relative error of L_v and of the fixated degree of even lat-longs."""
    n, worst = 20000, 0
    step = 89.5 / n
    truth = sum(general(t, 35, 0.5) * math.sin(2 * math.radians(t)) * math.pi
                for t in (0.5 + (i + 0.5) * step for i in range(n))) * math.radians(step)
    for w in (64, 128, 256, 512, 1024):
        write("even.pfm", lambda x, y: 1, w, w // 2)
        for at in (w / 2, w / 4), (0.31 * w, 0.23 * w):
            v = measure(glarepp, "even.pfm", "--projection", "latlong", "--luminance-scale", "100",
                        "--fixation", "%.9g,%.9g" % at, "-k", "cie:age=35")
            worst = max(worst, abs(v["luminance"] / truth / 100 - 1), abs(v["fixated"] / 100 - 1))
    return worst


def discs(glarepp):
    """Worst relative error of L_v and of E of lamps by flux, in the picture and beside it."""
    k, side, flux, worst = math.tan(math.radians(30)) / (SIZE / 2), 300, 1e6, 0
    write("none.pfm", lambda x, y: 0)
    aim = (-100 * k, 0, 1)
    for x, radius in ((100, 40), (-50, 40), (199, 0.5), (-0.3 - SIZE / 2, 0.5), (-260, 30),
                      (-20000, 0.5)):
        lux = veil = points = 0
        for i in range(side * side):
            a, b = (2 * (i % side) + 1) / side - 1, (2 * (i // side) + 1) / side - 1
            if a * a + b * b > 1:
                continue
            d = ((x + radius * a) * k, radius * b * k, 1)
            far = math.hypot(*d)
            cosine = sum(p * q for p, q in zip(d, aim)) / far / math.hypot(*aim)
            points += 1
            if cosine > 0:
                e = flux * k * k / far ** 3 * cosine
                lux += e
                veil += e * general(math.degrees(math.acos(cosine)), 35, 0.5)
        v = measure(glarepp, "none.pfm", "--projection", "perspective", "--fov", "60",
                    "--luminance-scale", "1", "--sun=%g,%g,%g" % (x + SIZE / 2, SIZE / 2, radius),
                    "--sun-color", str(flux), "--sun-outside", "visible", "-k", "cie:age=35",
                    "--fixation", "%g,%g" % (SIZE / 2 - 100, SIZE / 2))
        worst = max(worst, abs(v["luminance"] * points / veil - 1),
                    abs(v["illuminance"] * points / lux - 1))
    return worst


def increment(glarepp):
    """Worst relative error of TI over L_b of 0.3 to 30 cd/m2; the road is all around."""
    mid, light, worst = SIZE // 2, 1e6, 0
    k = math.tan(math.radians(20)) / (SIZE / 2)
    off = math.tan(math.radians(10)) / k
    for b in (0.3, 2, 4.9, 5.1, 30):
        write("road.pfm", lambda x, y: light if x == mid and y == mid else b)
        v = measure(glarepp, "road.pfm", "--fov", "40", "--luminance-scale", "1",
                    "--fixation", "%.9g,%.9g" % (mid + 0.5 + off, mid + 0.5), "-k", "cie:age=23")
        veil = light * k * k * math.cos(math.radians(10)) * general(10, 23, 0.5)
        truth = 65 * veil / b ** 0.8 if b <= 5 else 95 * veil / b ** 1.05
        worst = max(worst, abs(v["threshold_increment"] / truth - 1), abs(v["fixated"] / b - 1))
    return worst


def guth(d):
    """The position index of a direction (right, up, ahead)."""
    right, up, ahead = d
    if up < 0:
        r = min(math.hypot(right, up) / ahead, 3)
        return 1 + (1.2 if r > 0.6 else 0.8) * r
    sigma = math.degrees(math.acos(ahead))
    tau = math.degrees(math.atan2(abs(right), up))
    return min(16, math.exp((35.2 - 0.31889 * tau - 1.22 * math.exp(-2 * tau / 9)) / 1000 * sigma +
                            (21 + 0.26667 * tau - 0.002963 * tau * tau) / 1e5 * sigma * sigma))


def rooms(glarepp):
    """Worst absolute errors of UGR and DGP of windows and lamps in an even room."""
    k = math.pi / SIZE
    worst = {"ugr": 0, "dgp": 0}
    lamps = (  # places of lights, radians to the right and up; radius; luminance
        [(0.0, 0.5, 0.1, 3e4)], [(0.4, 0.3, 0.05, 2e5)], [(-0.6, -0.4, 0.12, 2e4)],
        [(0.5, 0.5, 0.06, 1e5), (-0.5, 0.6, 0.04, 3e5), (0.2, -0.9, 0.05, 8e4)])
    for room in (100.0, 600.0):
        for lights in lamps:
            picture, sums = {}, {}
            for y in range(SIZE):
                for x in range(SIZE):
                    u, v = (x + 0.5 - SIZE / 2) * k, (SIZE / 2 - y - 0.5) * k
                    for i, (a, b, r, light) in enumerate(lights):
                        t = math.hypot(u, v)
                        if math.hypot(u - a, v - b) < r:
                            s = math.sin(t) / t
                            w = k * k * s
                            d = (w, w * u * s, w * v * s, w * math.cos(t))
                            picture[x, y] = light
                            sums[i] = [p + q for p, q in zip(sums.get(i, (0,) * 4), d)]
            write("room.pfm", lambda x, y: picture.get((x, y), room))
            v = measure(glarepp, "room.pfm", "--projection", "fisheye", "--luminance-scale", "1")
            direct = glare = hidden = 0
            for i, (w, right, up, ahead) in sums.items():
                n = math.sqrt(right ** 2 + up ** 2 + ahead ** 2)
                glare += lights[i][3] ** 2 * w / guth((right / n, up / n, ahead / n)) ** 2
                direct += lights[i][3] * ahead
                hidden += ahead
            indirect = room * (math.pi - hidden)
            ugr = 8 * math.log10(0.25 / (indirect / math.pi) * glare)
            lux = indirect + direct
            dgp = min(1, 5.87e-5 * lux + 0.0918 * math.log10(1 + glare / lux ** 1.87) + 0.16)
            assert v["sources"] == len(lights), v
            worst["ugr"] = max(worst["ugr"], abs(v["ugr"] - ugr))
            worst["dgp"] = max(worst["dgp"], abs(v["dgp"] - dgp))
    return worst


def curve(glarepp):
    """Worst relative error of the glare of a point by `cie` against CIE 135/1 (1999), the
    total glare function, at 1 to 30 degrees."""
    mid, light, worst = SIZE // 2, 1e9, 0
    write("point.pfm", lambda x, y: light if x == mid and y == mid else 0)
    for fov, angles in ((6, (1,)), (30, (5, 10)), (75, (20, 30))):
        k = math.tan(math.radians(fov / 2)) / (SIZE / 2)
        for age, p in ((20, 0.5), (35, 0.5), (70, 0.5), (85, 1.2)):
            subprocess.run([glarepp, "-q", "-t", "0", "--threshold-mode", "whole", "-k",
                            "cie:age=%g,pigment=%g" % (age, p), "--fov", str(fov),
                            "--layer", "l.pfm", "point.pfm"], check=True)
            with open("l.pfm", "rb") as f:
                for _ in range(3):
                    f.readline()
                layer = array.array("f", f.read())
            for t in angles:
                x = round(math.tan(math.radians(t)) / k)
                t = math.degrees(math.atan(x * k))
                a = (age / 70) ** 4
                s, u = 1 + (t / 0.1) ** 2, 0.0046
                truth = (1 - 0.08 * a) * (9.2e6 / (1 + (t / u) ** 2) ** 1.5 +
                                          1.5e5 / (1 + (t / 0.045) ** 2) ** 1.5) + \
                    (1 + 1.6 * a) * (400 / s + 3e-8 * t * t +
                                     p * (1300 / s ** 1.5 + 0.8 / s ** 0.5)) + 2.5e-3 * p
                found = layer[3 * ((SIZE - 1 - mid) * SIZE + mid + x)] / light / (k * k)
                worst = max(worst, abs(found / truth - 1))
    return worst


def bars(glarepp):
    """Rows: text, measured, bar."""
    back = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            p, ti, r = points(glarepp), increment(glarepp), rooms(glarepp)
            cie, even, disc = curve(glarepp), spheres(glarepp), discs(glarepp)
        finally:
            os.chdir(back)
    return [
        ("2.2 glare of `cie` over CIE 135/1, 1 to 30 degrees, ages 20 to 85", cie, 0.01),
        ("2.4 L_v of point lights, 1 to 30 degrees, ages 20 to 80: relative error", p["veil"], 0.01),
        ("2.4 L_v of even lat-longs of 64 to 1024 pixels, and L_b", even, 0.01),
        ("2.4 L_v and illuminance of lamps by flux, in the frame and beside it", disc, 0.01),
        ("2.4 illuminance at the eye of the points", p["lux"], 0.01),
        ("2.4 TI on a road of 0.3 to 30 cd/m2: relative error", ti, 0.01),
        ("2.4 UGR of lamps in a room: error", r["ugr"], 0.05),
        ("2.4 DGP of these", r["dgp"], 0.001),
    ]
