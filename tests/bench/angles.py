#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A lamp by true angles against its definition, and what a plane makes of it.

Usage: angles.py GLAREPP [FRAMES]

The definition is here once more, in double, by formulas of its own: light per steradian
at the true angle, times the source's solid angle, its mean over both pixels (three Gauss
points along each axis of each). Pixels 4 and more away from the lamp count. Prints, for
each angle of view, model and place, rel_l2 by --projection perspective: by levels and as
a lone lamp is summed (auto); how many pixels are within 0.5 %; its bound; and rel_l2 by
--projection plane.

Then a lat-long of 2048x1024, a lamp in 12 places: the ratio to the definition that 99 % of
the pixels from 4 rows on are within, and the light that is kept; and a lat-long cut into
a perspective view, against the glare of that view.

With FRAMES, the folder that frames.py fills, also the time of the glare stage and the
memory by perspective over those by plane, at three angles, and those of a lat-long of
4096x2048, and of the default style with --tolerance 0.01: medians of frames that follow
the first, runs in turn.
"""
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile

import numpy as np

GLAREPP = sys.argv[1]
W, H = 480, 270
MODELS = {
    "eye": lambda t: 0.384 * 2.61e6 * np.exp(-(t / 0.02) ** 2) +
    0.478 * 20.91 / (t + 0.02) ** 3 + 0.138 * 72.37 / (t + 0.02) ** 2,
    "cie:age=70": lambda t: 0.92 * (9.2e6 / (1 + (t / 0.0046) ** 2) ** 1.5 +
                                    1.5e5 / (1 + (t / 0.045) ** 2) ** 1.5) +
    2.6 * (400 / (1 + (t / 0.1) ** 2) + 3e-8 * t * t +
           0.5 * (1300 / (1 + (t / 0.1) ** 2) ** 1.5 +
                  0.8 / (1 + (t / 0.1) ** 2) ** 0.5)) + 1.25e-3,
}


def write(path, image):
    with open(path, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % image.shape[1::-1])
        f.write(image[::-1].astype("<f4").tobytes())


def read(path):
    with open(path, "rb") as f:
        f.readline()
        w, h = (int(n) for n in f.readline().split())
        f.readline()
        return np.frombuffer(f.read(), "<f4").reshape(h, w, 3)[::-1, :, 1].astype(float)


def sphere(light):
    """The light of a model over the sphere; behind 100 degrees as there."""
    edge = np.concatenate([[0], np.geomspace(1e-7, 180.0, 400001)])
    t = 0.5 * (edge[1:] + edge[:-1])
    return np.sum(light(np.minimum(t, 100.0)) * 2 * np.pi * np.sin(np.radians(t)) *
                  np.radians(np.diff(edge)))


def definition(light, fov, px, py):
    k = 2 * math.tan(math.radians(fov / 2)) / H
    node, weight = np.polynomial.legendre.leggauss(3)
    y, x = np.mgrid[0:H, 0:W]
    total = np.zeros((H, W))
    for a, b, c, d in np.ndindex(3, 3, 3, 3):
        ax, ay = ((x + 0.5 + node[a] / 2 - W / 2) * k, (y + 0.5 + node[b] / 2 - H / 2) * k)
        sx, sy = ((px + 0.5 + node[c] / 2 - W / 2) * k, (py + 0.5 + node[d] / 2 - H / 2) * k)
        cross = np.sqrt((ax - sx) ** 2 + (ay - sy) ** 2 + (ax * sy - ay * sx) ** 2)
        t = np.degrees(np.arctan2(cross, 1 + ax * sx + ay * sy))
        total += weight[a] * weight[b] * weight[c] * weight[d] / 16 * \
            light(np.minimum(t, 100.0))
    x, y = (px + 0.5 - W / 2) * k, (py + 0.5 - H / 2) * k
    return total * k * k / (1 + x * x + y * y) ** 1.5


def main():
    print("| fov | model | place | levels | auto | within 0.5 % | bound | plane |\n"
          "|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        frame, layer, report = (os.path.join(folder, n) for n in ("f.pfm", "l.pfm", "r"))

        def run(px, py, *words):
            image = np.zeros((H, W, 3), np.float32)
            image[py, px] = 1e6
            write(frame, image)
            subprocess.run([GLAREPP, "-q", "-t", "0", "--threshold-mode", "whole",
                            "--edges", "black", "--layer", layer, "--report", report,
                            *words, frame], check=True)
            with open(report, encoding="utf-8") as f:
                return read(layer) / 1e6, json.loads(f.readline())

        y, x = np.mgrid[0:H, 0:W]
        for fov in 30, 40, 60, 90, 120:
            for model, light in MODELS.items():
                # CIE's is absolute
                whole = sphere(light) if model == "eye" else 1.0
                for place in 0.5, 0.75, 0.98:
                    px, py = int(W * place), int(H * place)
                    want = definition(light, fov, px, py) / whole
                    veil = np.hypot(x - px, y - py) >= 4
                    row = []
                    for way in (["-e", "fft", "--projection", "perspective"],
                                ["--projection", "perspective"],
                                ["--projection", "plane"]):
                        got, facts = run(px, py, "-k", model, "--fov", str(fov), *way)
                        off = got[veil] - want[veil]
                        row.append(math.sqrt((off ** 2).sum() / (want[veil] ** 2).sum()))
                        if not row[1:]:
                            near = np.mean(abs(off) <= 5e-3 * want[veil])
                            bound = facts["bound_angle"]
                    print("| %g | %s | %g | %.1e | %.1e | %.1f %% | %.1e | %.3f |" %
                          (fov, model, place, row[0], row[1], 100 * near, bound, row[2]))


def sphere_definition(light, h, px, py):
    """On a lat-long of 2 h columns, by two Gauss points along each axis of each pixel."""
    node = np.array([-0.5, 0.5]) / math.sqrt(3)
    step, total = math.pi / h, np.zeros((h, 2 * h))
    row, column = np.mgrid[0:h, 0:2 * h]
    for a, b, c, d in np.ndindex(2, 2, 2, 2):
        v = (row + 0.5 + node[a]) * step - math.pi / 2
        w = (py + 0.5 + node[b]) * step - math.pi / 2
        u = (column - px + node[c] - node[d]) * step
        half = np.sin((v - w) / 2) ** 2 + np.cos(v) * np.cos(w) * np.sin(u / 2) ** 2
        t = np.degrees(2 * np.arcsin(np.sqrt(np.minimum(half, 1.0))))
        total += light(np.minimum(t, 100.0)) / 16
    v = (py + 0.5) * step - math.pi / 2
    return total * step * step * math.cos(v)


def spheres():
    h = 1024
    print("| lat-long 2048x1024 | lamp | 99 % within | bound | light kept |\n|---|---|---|---|---|")
    solid = np.cos((np.arange(h) + 0.5) * math.pi / h - math.pi / 2)[:, None]
    row, column = np.mgrid[0:h, 0:2 * h]
    whole = sphere(MODELS["eye"])
    with tempfile.TemporaryDirectory() as folder:
        frame, layer, report = (os.path.join(folder, n) for n in ("f.pfm", "l.pfm", "r"))
        for px, py in ((1024, 512), (0, 512), (2047, 511), (512, 200), (0, 820), (2047, 100),
                       (190, 15), (1300, 5), (630, 1), (0, 0), (1536, 1023), (2047, 1010)):
            image = np.zeros((h, 2 * h, 3), np.float32)
            image[py, px] = 1e6
            write(frame, image)
            subprocess.run([GLAREPP, "-q", "-t", "0", "--threshold-mode", "whole", "-e",
                            "fft", "-k", "eye", "--projection", "latlong", "--layer",
                            layer, "--report", report, frame], check=True)
            got = read(layer) / 1e6
            with open(report, encoding="utf-8") as f:
                bound = json.loads(f.readline())["bound_angle"]
            v, w = ((n + 0.5) * math.pi / h - math.pi / 2 for n in (row, py))
            u = (column - px) * math.pi / h
            away = np.sin((v - w) / 2) ** 2 + np.cos(v) * np.cos(w) * np.sin(u / 2) ** 2
            veil = away > (2 * math.pi / h) ** 2
            want = sphere_definition(MODELS["eye"], h, px, py) / whole
            print("| | %d, %d | %.2f %% | %.1e | %.5f |" %
                  (px, py, 100 * np.quantile(abs(got[veil] / want[veil] - 1), 0.99), bound,
                   (got * solid).sum() / math.cos(w)))


def views():
    """A lat-long's glare as a perspective shows it, against the glare of that view."""
    h, fov, wide, size = 1024, 40, 100, (288, 512)
    rng = np.random.default_rng(3)
    sphere_light = np.zeros((h, 2 * h, 3), np.float32)
    for _ in range(40):  # lamps of 5x5 pixels before the camera
        y, x = rng.integers(h // 3, 2 * h // 3), rng.integers(2 * h // 3, 4 * h // 3)
        sphere_light[y:y + 5, x:x + 5] = rng.random() * 1e4

    def directions(height, width, angle, parts):
        k = 2 * math.tan(math.radians(angle / 2)) / height
        y, x = np.mgrid[0:height * parts, 0:width * parts]
        x, y = (((n + 0.5) / parts - m / 2) * k for n, m in ((x, width), (y, height)))
        return np.arctan2(x, 1) * h / math.pi + h, \
            np.arctan2(y, np.hypot(x, 1)) * h / math.pi + h / 2

    with tempfile.TemporaryDirectory() as folder:
        frame, layer = folder + "/f.pfm", folder + "/l.pfm"

        def glare(image, *words):
            write(frame, image)
            subprocess.run([GLAREPP, "-q", "-t", "0", "--threshold-mode", "whole", "-k",
                            "eye", "--edges", "black", "--layer", layer, *words, frame],
                           check=True)
            return read(layer)
        over = [round(n * math.tan(math.radians(wide / 2)) /
                      math.tan(math.radians(fov / 2)) / 2) * 2 for n in size]
        angle = 2 * math.degrees(math.atan(math.tan(math.radians(fov / 2)) *
                                           over[0] / size[0]))
        x, y = (n.astype(int) for n in directions(*over, angle, 8))
        seen = sphere_light[y, x].reshape(over[0], 8, over[1], 8, 3).mean((1, 3))
        want = glare(seen, "--projection", "perspective", "--fov", str(angle))
        top, left = ((o - n) // 2 for o, n in zip(over, size))
        want, lit = (a[top:top + size[0], left:left + size[1]] for a in (want, seen))
        got = glare(sphere_light, "--projection", "latlong")
        x, y = (n - 0.5 for n in directions(*size, fov, 1))
        i, j = np.floor(x).astype(int), np.floor(y).astype(int)
        x, y = x - i, y - j
        got = (1 - y) * ((1 - x) * got[j, i] + x * got[j, i + 1]) + \
            y * ((1 - x) * got[j + 1, i] + x * got[j + 1, i + 1])
        lit = lit[:, :, 1] > 0
        near = lit.copy()
        for _ in range(12):  # pixels around lamps, which both round to their own
            near[1:] |= near[:-1].copy()
            near[:-1] |= near[1:].copy()
            near[:, 1:] |= near[:, :-1].copy()
            near[:, :-1] |= near[:, 1:].copy()
        off = (got - want)[~near]
        print("lat-long cut into a view of %g degrees, 12 pixels and more from lamps: "
              "rel_l2 %.1e, 95 %% of pixels within %.2f %%" %
              (fov, math.sqrt((off ** 2).sum() / (want[~near] ** 2).sum()),
               100 * np.quantile(abs(off) / want[~near], 0.95)))


def speed_row(folder, frames, fov, way, runs, *head, words=("-k", "eye"), own=()):
    """Prints times of a projection, which has its own words, over the plane's, runs in
    turn."""
    rows = {"plane": [], way: []}
    for _ in range(runs):
        for name, found in rows.items():
            subprocess.run([GLAREPP, "-q", *words, *(own if name == way else ()),
                            "--fov", str(fov), "--projection", name,
                            "--layer", folder + "/l.@.pfm", "--report", folder + "/r",
                            os.path.join(folder, frames)], check=True)
            with open(folder + "/r", encoding="utf-8") as f:
                found.append([json.loads(line) for line in f])
    ms, first, kernel, memory = (
        {name: statistics.median(get(r) for run in found for r in run[part])
         for name, found in rows.items()}
        for part, get in ((slice(1, None), lambda r: r["times_ms"]["glare"]),
                          (slice(1), lambda r: r["times_ms"]["glare"]),
                          (slice(1), lambda r: r["times_ms"]["kernel"]),
                          (slice(-1, None), lambda r: r["peak_rss_mib"])))
    print("| %s | %.1f | %.2f | %.2f | %.1f, %.1f | %.2f |" %
          (" | ".join(head), ms["plane"], ms[way] / ms["plane"],
           first[way] / first["plane"], kernel["plane"], kernel[way],
           memory[way] / memory["plane"]))


def sphere_speeds():
    print("| lat-long 4096x2048 | ms, plane | latlong, over it | first frame | kernel, ms | "
          "memory |\n|---|---|---|---|---|---|")
    rng = np.random.default_rng(1)
    with tempfile.TemporaryDirectory() as folder:
        for name, side, share in ("lamps", 1, 1e-4), ("windows", 8, 0.03), ("sky", 8, 0.4):
            image = rng.random((2048, 4096, 3), np.float32) * 0.5
            lit = rng.random((2048 // side, 4096 // side)) < share
            image[np.kron(lit, np.ones((side, side), bool))] *= 100.0
            for i in range(1, 4):
                write(folder + "/s.%d.pfm" % i, image)
            speed_row(folder, "s.@.pfm", 150, "latlong", 2, name)


def speeds(frames):
    print("| fov | frame | ms, plane | perspective, over it | first frame | kernel, ms | "
          "memory |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name in "w1", "w2", "w3":
            for i in range(1, 6):
                os.symlink(os.path.join(os.path.abspath(frames), name + "_1920.exr"),
                           os.path.join(folder, "%s.%d.exr" % (name, i)))
        for fov in 20, 40, 90:
            for name in "w1", "w2", "w3":
                speed_row(folder, name + ".@.exr", fov, "perspective", 3, str(fov), name)
        # the default style, one thread, one weight a node
        for name in "w1", "w2", "w3":
            speed_row(folder, name + ".@.exr", 30, "perspective", 3, "30, 0.01", name,
                      words=("--threads", "1"), own=("--tolerance", "0.01"))


if __name__ == "__main__":
    main()
    spheres()
    views()
    if len(sys.argv) > 2:
        speeds(sys.argv[2])
        sphere_speeds()
