# SPDX-License-Identifier: Apache-2.0
"""Answers a test's questions about files in one process, which imports its
libraries once.

usage: ask.py SCRIPT <QUESTIONS >ANSWERS

A question is a line: a function of SCRIPT and its words, each ended by the
control character US. The answer is a line: "ok", or the exception.
"""
import contextlib
import sys
import traceback

script = {"__name__": "script"}
with open(sys.argv[1]) as f:
    exec(compile(f.read(), sys.argv[1], "exec"), script)
for line in sys.stdin:
    name, *words = line.rstrip("\n").split("\x1f")[:-1]
    answer = "ok"
    try:
        with contextlib.redirect_stdout(sys.stderr):
            script[name](*words)
    except Exception as e:
        last = traceback.extract_tb(e.__traceback__)[-1]
        answer = f"{name}, line {last.lineno}: {type(e).__name__} {e}"
    print(" ".join(answer.split("\n")), flush=True)
