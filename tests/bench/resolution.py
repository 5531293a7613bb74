#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The layer of a frame against those of its averages over 2x2 and 4x4 pixels,
and the least error that any kernel of such pixels could have.

usage: resolution.py GLAREPP FRAME [KERNEL]    (eye)
needs python3-numpy and python3-openimageio

Averages begin at each of the 2x2 or 4x4 places, so that no lamp's place in its
pixel decides. Prints rel_l2 against the averaged layer of the frame, which is 30
degrees high: of the model with -t 1, with -t 0, and with -t 0 plus 7x7 taps for
each channel that are fitted to this frame: by least squares to all of it, and to
one half for the other, as a kernel is not made for one frame.
"""
import os
import subprocess
import sys
import tempfile

import numpy as np
import OpenImageIO as oiio

MOST, TAPS = 4, 7


def read(path):
    image = oiio.ImageInput.open(path)
    pixels = image.read_image(0, 0, 0, 3, "float")
    image.close()
    return pixels


def layer(run, frame, threshold, fov):
    height, width = frame.shape[:2]
    image = oiio.ImageOutput.create("frame.exr")
    image.open("frame.exr", oiio.ImageSpec(width, height, 3, "float"))
    image.write_image(np.ascontiguousarray(frame, np.float32))
    image.close()
    subprocess.run(run + ["-t", str(threshold), "--fov", repr(fov), "--layer",
                          "layer.exr", "frame.exr"], check=True)
    return read("layer.exr").astype(float)


def mean(image, n):
    height, width = image.shape[:2]
    return image.reshape(height // n, n, width // n, n, 3).mean((1, 3))


def shifted(plane):
    """Columns of the plane shifted by each tap, 0 from outside."""
    height, width = plane.shape
    wide = np.pad(plane, TAPS // 2)
    return np.stack([wide[y:y + height, x:x + width].ravel()
                     for y in range(TAPS) for x in range(TAPS)], 1)


def solve(square, product):
    return np.linalg.lstsq(square, product, rcond=1e-12)[0]


def fitted(frames):
    """Squared errors that are left by taps fitted to all, and to halves."""
    left, other = 0.0, 0.0
    for c in range(3):
        square = np.zeros((2, TAPS ** 2, TAPS ** 2))
        product, norm = np.zeros((2, TAPS ** 2)), np.zeros(2)
        for light, rest in frames:
            columns = shifted(light[:, :, c])
            half = np.zeros(light.shape[:2], bool)
            half[:, :light.shape[1] // 2] = True
            for i, own in enumerate((half.ravel(), ~half.ravel())):
                x, y = columns[own], rest[:, :, c].ravel()[own]
                square[i] += x.T @ x
                product[i] += x.T @ y
                norm[i] += y @ y
        taps = solve(square.sum(0), product.sum(0))
        left += norm.sum() - taps @ product.sum(0)
        for i in 0, 1:
            taps = solve(square[i], product[i])
            other += (norm[1 - i] - 2 * taps @ product[1 - i] +
                      taps @ square[1 - i] @ taps)
    return left, other


def measure(run, frame):
    height, width = (n // MOST * MOST for n in frame.shape[:2])
    frame = np.pad(frame[:height, :width], ((MOST, MOST), (MOST, MOST), (0, 0)))
    degree = 30.0 / height  # of a pixel
    whole = [layer(run, frame, t, degree * frame.shape[0]) for t in (1, 0)]
    for n in 2, 4:
        norm, error, frames = np.zeros(2), np.zeros(2), []
        for place in range(n * n):
            y, x = divmod(place, n)
            cut = (slice(y, y + height + MOST), slice(x, x + width + MOST))
            light = mean(frame[cut], n)
            fov = degree * n * light.shape[0]
            for t in 0, 1:
                true = mean(whole[t][cut], n)
                rest = true - layer(run, light, 1 - t, fov)
                norm[t] += (true ** 2).sum()
                error[t] += (rest ** 2).sum()
            frames.append((light.astype(float), rest))
        left = np.array(fitted(frames))
        shares = 100.0 * np.sqrt(np.append(error / norm, left / norm[1]))
        print(f"{n}x{n}: -t 1 {shares[0]:.2f} %, -t 0 {shares[1]:.2f} %, with "
              f"{TAPS}x{TAPS} taps fitted to it {shares[2]:.2f} %, to the other "
              f"half {shares[3]:.2f} %", flush=True)


def main():
    glarepp, path = (os.path.abspath(p) for p in sys.argv[1:3])
    kernel = sys.argv[3] if len(sys.argv) > 3 else "eye"
    frame = read(path)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        measure([glarepp, "-q", "-e", "fft", "-k", kernel], frame)


if __name__ == "__main__":
    main()
