#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The largest step of a lamp's radial profile, from pixel to pixel, by kernel.

usage: steps.py GLAREPP [KERNEL ...]    (all presets, aperture and temporal)
needs python3-numpy and python3-openimageio

A lamp of 1e6 in the dark, at 540, 1080 and 2160 lines of 30 degrees; the profile
is the mean luminance over circles, as far as half a code value of 8 bits shows
at +6 EV. Prints the largest step from 150 pixels on, in % of the value, and where
it is; a light that falls by the power p of the distance steps by p / 150 there.
"""
import os
import re
import subprocess
import sys
import tempfile

import numpy as np
import OpenImageIO as oiio

SEEN = 1.5e-4 / 64
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def lamp(path, lines):
    width = lines * 16 // 9
    frame = np.zeros((lines, width, 3), np.float32)
    frame[lines // 2, width // 2] = 1e6
    image = oiio.ImageOutput.create(path)
    image.open(path, oiio.ImageSpec(width, lines, 3, "float"))
    image.write_image(frame)
    image.close()


def profile(path):
    """Means over circles whose radius is a whole number of pixels."""
    image = oiio.ImageInput.open(path)
    light = image.read_image(0, 0, 0, 3, "float").astype(float) @ LUMINANCE
    image.close()
    height, width = light.shape
    y, x = np.mgrid[:height, :width]
    radius = np.hypot(x - width // 2, y - height // 2).ravel()
    low, size = radius.astype(int), height // 2 - 1
    sums = []
    for values in light.ravel(), np.ones(light.size):
        inner = np.bincount(low, (low + 1 - radius) * values)[:size]
        outer = np.bincount(low + 1, (radius - low) * values)[:size]
        sums.append(inner + outer)
    return sums[0] / sums[1]


def largest(means):
    steps = np.abs(np.diff(means)) / np.maximum(means[:-1], SEEN)
    steps[means[1:] < SEEN] = 0
    steps[:150] = 0
    at = int(steps.argmax())
    return 100 * steps[at], at


def main():
    run = [os.path.abspath(sys.argv[1]), "-q", "-e", "fft", "--fov", "30"]
    listed = subprocess.run([run[0], "kernel", "--list"], check=True,
                            capture_output=True, text=True).stdout
    presets = re.findall(r"^  ([a-z-]+) ", listed.split("\nPresets")[1], re.M)
    kernels = sys.argv[2:] or presets + ["aperture", "temporal"]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for lines in 540, 1080, 2160:
            lamp(f"{lines}.exr", lines)
        for kernel in kernels:
            row = []
            for lines in 540, 1080, 2160:
                subprocess.run(run + ["-k", kernel, "--layer", "layer.exr",
                                      f"{lines}.exr"], check=True)
                step, at = largest(profile("layer.exr"))
                row.append(f"{step:.1f} % at {30 * at / lines:.2f}")
            print(f"{kernel}: {', '.join(row)} degrees", flush=True)


if __name__ == "__main__":
    main()
