#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bars of lights, colours and veils: measured, the bar, and whether it holds.

Usage: bars.py GLAREPP [PART...]

A part is a module beside this file whose bars(GLAREPP) gives rows of text, measured and
bar; all of them without a word. What they measure against shares nothing with src.
Exit status 1: a bar does not hold.
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
        holds = measured <= bar
        failed |= not holds
        print("%-80s %10.3g %8g %s" % (text, measured, bar, "holds" if holds else "DOES NOT HOLD"),
              flush=True)
sys.exit(failed)
