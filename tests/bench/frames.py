#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Frames to measure on: few lights (w1), a facade of windows (w2), a bright sky
(w3), at three sizes, and a 512x512 kernel of halo and streaks. The same frames
in every run.

usage: frames.py FOLDER        needs python3-numpy and python3-openimageio
"""
import sys

import numpy as np
import OpenImageIO as oiio

Y = np.array([0.2126, 0.7152, 0.0722])


def save(path, image, compression="zip"):
    height, width = image.shape[:2]
    spec = oiio.ImageSpec(width, height, 3, "float")
    spec.attribute("compression", compression)
    out = oiio.ImageOutput.create(path)
    out.open(path, spec)
    out.write_image(np.ascontiguousarray(image, np.float32))
    out.close()


def noise(height, width, rng, cells):
    """Bilinear value noise in 0..1, the same pattern at any size."""
    grid = rng.random((cells + 2, cells + 2))
    y = np.linspace(0, cells, height, endpoint=False)[:, None]
    x = np.linspace(0, cells, width, endpoint=False)[None]
    iy, ix = y.astype(int), x.astype(int)
    fy, fx = y - iy, x - ix
    top = grid[iy, ix] * (1 - fx) + grid[iy, ix + 1] * fx
    low = grid[iy + 1, ix] * (1 - fx) + grid[iy + 1, ix + 1] * fx
    return top * (1 - fy) + low * fy


def background(height, width, rng):
    n = sum(noise(height, width, rng, c) * a
            for c, a in ((4, .5), (16, .3), (97, .2)))
    n = (n - n.min()) / (n.max() - n.min())
    tint = np.array([1.0, .95, .85])
    return (0.05 + 0.75 * n)[..., None] * tint / (tint @ Y)


def lights(image, rng, count, low, high, scale):
    """Gaussian lights at sub-pixel places, luminance log-uniform."""
    height, width = image.shape[:2]
    for _ in range(count):
        y, x = 8 + rng.random() * (height - 16), 8 + rng.random() * (width - 16)
        colour = rng.uniform(.5, 1, 3)
        colour *= np.exp(rng.uniform(np.log(low), np.log(high))) / (colour @ Y)
        sigma = rng.uniform(.5, 1.5) * scale
        r = int(4 * sigma) + 1
        yy = np.arange(max(0, int(y) - r), min(height, int(y) + r + 1))
        xx = np.arange(max(0, int(x) - r), min(width, int(x) + r + 1))
        g = np.exp(-((yy[:, None] - y) ** 2 + (xx[None] - x) ** 2)
                   / (2 * sigma ** 2))
        image[yy[0]:yy[-1] + 1, xx[0]:xx[-1] + 1] += g[..., None] * colour


def few_lights(height, width):
    rng = np.random.default_rng(1)
    image = background(height, width, rng)
    lights(image, rng, 60, 10, 5000, height / 768)
    return image


def windows(height, width):
    """16 x 12 windows, a third of them lit: 3 % of the pixels."""
    rng = np.random.default_rng(2)
    image = background(height, width, rng)
    for j in range(12):
        for i in range(16):
            colour = rng.uniform([.8, .6, .3], [1, .9, .8])
            colour *= np.exp(rng.uniform(np.log(5), np.log(50))) / (colour @ Y)
            if rng.random() < .34:
                y, x = int((j + .3) * height / 12), int((i + .3) * width / 16)
                image[y:y + int(height * .029), x:x + int(width * .016)] = colour
    lights(image, rng, 20, 100, 5000, height / 768)
    return image


def sky(height, width):
    rng = np.random.default_rng(3)
    image = background(height, width, rng)
    clouds = (noise(height, width, rng, 6) * .6 +
              noise(height, width, rng, 31) * .4)
    clouds = (clouds - clouds.min()) / (clouds.max() - clouds.min())
    horizon = .55 * height + .03 * height * np.sin(np.arange(width) * 9 / width)
    above = np.arange(height)[:, None] < horizon[None]
    blue = np.array([.8, 1.0, 1.3])
    light = (2.1 + 17.9 * clouds)[..., None] * blue / (blue @ Y)
    return np.where(above[..., None], light, image)


def kernel():
    y, x = np.mgrid[-256:256, -256:256].astype(float)
    rng = np.random.default_rng(7)
    angles, strength = rng.uniform(0, 2 * np.pi, 60), rng.exponential(1, 60)
    result = np.zeros((512, 512, 3))
    for c, spread in enumerate((1.06, 1.0, .93)):
        r, t = np.hypot(x, y) / spread, np.arctan2(y, x)
        streaks = np.zeros_like(r)
        for a, s in zip(angles, strength):
            d = np.abs(np.angle(np.exp(1j * (t - a))))
            streaks += s * np.exp(-(d * r / .7) ** 2 / 2) * (d < 1.2)
        edge = np.clip((256 - np.hypot(x, y)) / 40, 0, 1)
        result[..., c] = ((r * r + 1.5) ** -1.25 + .02 / (r * r + 60) +
                          .02 * streaks / (r + 3) ** 1.6) \
            * edge * edge * (3 - 2 * edge)
    return result / result.sum((0, 1))


if __name__ == "__main__":
    folder = sys.argv[1].rstrip("/") + "/"
    save(folder + "k512.exr", kernel(), "none")
    for width, height in ((1024, 768), (1920, 1080), (3840, 2160)):
        for name, make in (("w1", few_lights), ("w2", windows), ("w3", sky)):
            save(f"{folder}{name}_{width}.exr", make(height, width))
