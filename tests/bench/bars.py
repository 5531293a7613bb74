#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bars of lights, colours, veils and angles: measured, the bar, and whether it holds.

Usage: bars.py GLAREPP [PART...]

A part is a module beside this file whose bars(GLAREPP) gives rows of text, measured and
bar, None where there is none; without a word all but angles, which measures times too and
takes some ten minutes. What they measure against shares nothing with src. Exit status 1:
a bar does not hold.
"""
import importlib
import os
import sys

PARTS = ["shares", "lens", "veil"]

failed = False
glarepp = os.path.abspath(sys.argv[1])
print("%-80s %10s %8s" % ("", "measured", "bar"))
for part in sys.argv[2:] or PARTS:
    for text, measured, bar in importlib.import_module(part).bars(glarepp):
        row = "%-80s" % text
        if measured is not None:
            row += " %10.3g" % measured
        if bar is not None:
            holds = measured <= bar
            failed |= not holds
            row += " %8g %s" % (bar, "holds" if holds else "DOES NOT HOLD")
        print(row, flush=True)
sys.exit(failed)
