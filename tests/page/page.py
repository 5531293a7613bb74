#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Usage: page.py GLAREPP ROOT AXE, in an empty folder: prints "ok ..." or "not ok ..."
for what pages do in a headless chromium. AXE is axe.min.js, or empty."""
import json
import os
import shutil
import subprocess
import sys

import numpy as np

GLAREPP, ROOT, AXE = sys.argv[1:4]
sys.dont_write_bytecode = True
sys.path.insert(0, os.path.join(ROOT, "tests", "page"))
import browser  # noqa: E402


def check(good, what, *found):
    print(f"{'ok' if good else 'not ok'} {what}")
    if not good:
        print("# found", *found)
    sys.stdout.flush()


def glarepp(*words, status=None):
    done = subprocess.run([GLAREPP, *words], capture_output=True, text=True)
    if status is not None and done.returncode != status:
        print(f"not ok glarepp {' '.join(words)}: {done.returncode} {done.stderr}")
    return done.stdout


def frame(name, *keys):
    subprocess.run([sys.executable, os.path.join(ROOT, "tests", "cli", "exr.py"), name, *keys],
                   check=True)


def pfm(name, v):
    """Writes h x w x 3 floats, rows from the top."""
    with open(name, "wb") as f:
        f.write(b"PF\n%d %d\n-1.0\n" % (v.shape[1], v.shape[0]))
        f.write(v[::-1].astype("<f4").tobytes())


def halfs(v):
    return v.astype(np.float16).astype(np.float32)


def silent(b, what):
    check(not b.messages, f"{what}: no message on the console", *b.messages)


def axe(b, what):
    if not AXE:
        return
    with open(AXE, encoding="utf-8") as f:
        b.run(f.read() + "; 0")
    for scheme in ("light", "dark"):
        b.dark(scheme == "dark")
        b.settle()
        found = b.run("axe.run().then(r => r.violations.filter(v => v.impact !== 'minor').map("
                      "v => v.id + ': ' + v.nodes.map(n => n.html).join(' ')))")
        check(not found, f"{what}: axe finds nothing in {scheme}", *found)
    b.dark(False)


def spot(b, x, y, right=False):
    """The place on the screen of an image pixel's centre."""
    left, top, _, _ = b.box("#canvas")
    at = b.run(f"(f => [(f[0] + f[1] / 2 + ({x} + 0.5 - state.x) * state.zoom) / state.dpr, "
               f"(canvas.height / 2 + ({y} + 0.5 - state.y) * state.zoom) / state.dpr])"
               f"(half({'canvas.width' if right else 0}))")
    return left + at[0], top + at[1]


def values(b):
    """Rows of the table: A, B and B - A."""
    return b.run("[...document.querySelectorAll('#values tbody tr')].map("
                 "r => [...r.cells].slice(1).map(c => c.textContent))")


def colour(b, x, y):
    """What the canvas shows at a place on the screen."""
    left, top, _, _ = b.box("#canvas")
    return b.run(f"[...paint.getImageData(Math.floor(({x} - {left}) * state.dpr), "
                 f"Math.floor(({y} - {top}) * state.dpr), 1, 1).data]")


def shown(v, ev=0.0, gamma=2.2):
    return [round(255 * min(max(float(c) * 2 ** ev, 0), 1) ** (1 / gamma)) for c in v]


def near(found, wanted, by=1):
    return all(abs(f - w) <= by for f, w in zip(found, wanted))


# -- one pair ----------------------------------------------------------------------

def read_values(b, a, c, rng, what):
    """The values under the pointer at 50 places; means where the page says so."""
    h, w = a.shape[:2]
    wrong, means = [], 0
    b.run("fit()")
    for _ in range(50):
        x, y = int(rng.integers(w)), int(rng.integers(h))
        b.mouse("mouseMoved", *spot(b, x, y))
        name = b.run("$('pixel').textContent")
        px, py = (int(v.strip(":;")) for v in name.replace("pixel ", "").replace(",", "").split()[:2])
        scale = int(name.split("means of ")[1].split()[0]) if "means" in name else 1
        x0, y0 = px // scale * scale, py // scale * scale
        means += scale > 1
        for row, v in zip(values(b), (a, c)):
            mean = v[y0:y0 + scale, x0:x0 + scale].reshape(-1, 3).mean(0, dtype=np.float64)
            if any(abs(float(g) - m) > (1e-5 if scale == 1 else 1 / 1024) * abs(m) for g, m in zip(row, mean)):
                wrong.append((name, row, mean))
    check(not wrong, f"{what}: values under the pointer at 50 places, {means} of them means", *wrong[:3])


def test_pair(b, rng):
    h, w = 120, 200
    a = halfs(np.exp(rng.normal(-1, 1.5, (h, w, 3))))
    c = halfs(a * rng.uniform(0.7, 1.4, (h, w, 1)))
    a[7, 11] = [-0.5, 0, 2]
    pfm("a.pfm", a)
    pfm("b.pfm", c)
    facts = json.loads(glarepp("compare", "--json", "-", "a.pfm", "b.pfm"))
    glarepp("compare", "-q", "--html", "pair.html", "a.pfm", "b.pfm", status=2)
    b.open("pair.html")
    read_values(b, a, c, rng, "a pair")
    x, y = 60, 40
    b.run(f"zoomTo(8, {w / 2}, {h / 2})")
    for keys, ev in (("", 0), ("EEE", 1.5), ("eeeee", -1)):
        for k in keys:
            b.key(k)
        b.settle()
        left, right = spot(b, x, y), spot(b, 130, y)
        found = colour(b, *left)[:3], colour(b, *right)[:3]
        check(near(found[0], shown(a[y, x], ev)) and near(found[1], shown(c[y, 130], ev)),
              f"exposure {ev}: A and B on their sides of the slider", found, shown(a[y, x], ev), shown(c[y, 130], ev))
    b.run("slide('ev', -state.ev)")
    b.key("G")
    b.settle()
    found = colour(b, *spot(b, x, y))[:3]
    check(near(found, shown(a[y, x], 0, 2.3)), "gamma", found)
    b.key("g")

    box = b.box("#canvas")
    middle = box[0] + box[2] / 2, box[1] + box[3] / 2
    b.mouse("mousePressed", *middle, buttons=1)
    b.mouse("mouseMoved", box[0] + box[2] * 0.25, middle[1], buttons=1)
    b.mouse("mouseReleased", box[0] + box[2] * 0.25, middle[1])
    b.settle()
    check(abs(b.run("state.wipe") - 0.25) < 0.01 and b.run("$('wipe').value") == "250", "dragging moves the slider")
    found = colour(b, *spot(b, 95, y))[:3]
    check(near(found, shown(c[y, 95])), "dragging shows B where A was", found)
    b.run("document.activeElement.blur()")
    b.key("ArrowRight")
    check(abs(b.run("state.wipe") - 0.26) < 1e-6, "an arrow key moves the slider")
    b.run("$('wipe').focus()")
    b.key("ArrowRight")
    check(abs(b.run("state.wipe") - 0.27) < 1e-6, "an arrow key moves the slider that has the focus")

    found = {}
    for key, mode in zip("45678", ("a", "b", "absolute", "relative", "flip")):
        b.key(key)
        b.settle()
        found[mode] = colour(b, *spot(b, 95, y))[:3]
    check(near(found["a"], shown(a[y, 95])) and near(found["b"], shown(c[y, 95])), "keys show A, and B", found)
    check(near(found["absolute"], shown(abs(a[y, 95] - c[y, 95]))), "the absolute difference", found["absolute"])
    lum = np.array([0.2126, 0.7152, 0.0722])
    ya, yb = a @ lum, c @ lum
    wanted = np.abs(ya - yb) / (np.abs(ya) + 1e-6 * ya.max())
    got = np.array(b.run("[...state.B.relative].map(c => errors[c])")).reshape(h, w)
    off = np.abs(got - wanted) / np.maximum(wanted, 1e-9)
    check((off < 0.06).all(), "the relative error of each pixel", off.max())
    mean = b.run("state.B.flip.reduce((s, v) => s + v, 0) / state.B.flip.length / 255")
    check(abs(mean - facts["flip"]) < 1 / 510, "the mean of FLIP is that of --json", mean, facts["flip"])
    code = b.run(f"heat[state.B.flip[{y * w + 95}]]")
    check(near(found["flip"], [code >> 16, code >> 8 & 255, code & 255], 0), "FLIP in its colours", found["flip"])
    b.key("2")
    b.settle()
    b.run("fit()")
    b.settle()
    left, right = spot(b, x, y), spot(b, x, y, True)
    b.mouse("mouseMoved", *right)
    row = values(b)
    check(right[0] - left[0] > box[2] / 3 and near(map(float, row[0]), a[y, x], 1e-5), "side by side: one pixel in both", row)
    b.key("3")
    check(b.run("""new Promise(r => { const was = state.odd, began = Date.now(), look = () => state.odd !== was ? r(true)
        : Date.now() - began > 9000 ? r(false) : setTimeout(look, 20); look(); })"""), "flicker changes by itself")
    b.key("1")
    b.key("x")
    b.wait("state.a === 1 && state.b === 0")
    b.key("x")
    b.wait("state.a === 0")
    b.key("w")
    worst = facts["worst"]
    check(b.run("[state.px, state.py]") == [worst["x"], worst["y"]], "w: the worst pixel")
    b.run("canvas.focus()")
    b.key("ArrowRight")
    b.key("ArrowDown", shift=True)
    check(b.run("[state.px, state.py]") == [min(worst["x"] + 1, w - 1), min(worst["y"] + 10, h - 1)],
          "arrow keys move the pixel that is read")
    check("A " in b.run("$('say').textContent"), "and say its values")

    rows = b.run("[...document.querySelectorAll('#facts table')].map(t => t.innerText)")
    check(facts["result"] == "failure" and "--fail 1e-06" in rows[1] and f"{facts['failed']}" in rows[1],
          "a gate with its limit and status", rows)
    check("glarepp compare a.pfm b.pfm --html pair.html" in b.run("$('made').innerText"), "the command of the page")
    b.run("[...document.querySelectorAll('#made button')].pop().click()")
    b.wait("document.querySelector('#made').innerText.includes('copied')")
    b.key("?")
    check(b.run("$('help').open"), "? opens the list of keys")
    b.key("Escape")
    check(not b.run("$('help').open"), "Escape closes it")
    tab_through(b)
    for width in (400, 1600):
        b.resize(width, 800)
        b.settle()
        check(b.run("document.documentElement.scrollWidth") <= width and
              b.run("canvas.width === Math.round(canvas.getBoundingClientRect().width * state.dpr)") and
              b.run("[...document.querySelectorAll('#facts .scroll')].every(n => n.scrollWidth <= n.clientWidth)") and
              b.run("$('histogram').getBoundingClientRect().left <= "
                    "Math.min(...[...document.querySelectorAll('#histogram text')].map(n => n.getBoundingClientRect().left))"),
              f"{width} pixels wide: nothing is cut")
        b.key("0")
        for key in "21":
            b.key(key)
            check(b.run("Math.abs(Math.max(state.set.w * state.zoom / half(0)[1], state.set.h * state.zoom / canvas.height) - 1)") < 1e-6,
                  f"{width} pixels wide: mode {key} fits")
    light = b.run("getComputedStyle(document.body).backgroundColor")
    b.dark(True)
    b.settle()
    check(b.run("getComputedStyle(document.body).backgroundColor") != light, "dark where the system is")
    silent(b, "a pair")
    axe(b, "a pair")


def tab_through(b):
    """All controls by Tab, each with a focus that is seen."""
    b.run("$('ask').focus()")
    b.key("Tab", shift=True)
    wanted = b.run("""[...document.querySelectorAll('button, input, select, a[href], [tabindex="0"]')].filter(
        n => n.checkVisibility() && !n.disabled && (n.type !== 'radio' || n.checked)).length""")
    seen, unseen = [], []
    for _ in range(wanted + 5):
        b.key("Tab")
        at = b.run("""(n => n === document.body ? null : [n.tagName + '#' + n.id + ' ' + n.textContent.slice(0, 12),
            getComputedStyle(n).outlineStyle !== 'none' && parseFloat(getComputedStyle(n).outlineWidth) >= 2])
            (document.activeElement)""")
        if at is None or at[0] in seen[:1]:
            break
        seen.append(at[0])
        unseen += [] if at[1] else [at[0]]
    check(len(seen) == wanted, f"Tab reaches all {wanted} controls", len(seen), *seen)
    check(not unseen, "each shows its focus", *unseen)


def test_large(b, rng):
    """Noise, which does not pack: most of it must be averages."""
    h, w = 1080, 1920
    a = halfs(np.exp(rng.normal(-1, 1, (h, w, 3))))
    c = halfs(a * rng.uniform(0.9, 1.1, (h, w, 3)))
    c[600:700, 900:1000] *= np.float32(4)
    pfm("a.pfm", a)
    pfm("b.pfm", c)
    glarepp("compare", "-q", "--no-flip", "--html", "large.html", "a.pfm", "b.pfm", status=2)
    size = os.path.getsize("large.html")
    check(size < 3e6, "1920 x 1080 of noise: below 3 MB", size)
    took = b.open("large.html")
    check(took < 5, "it opens in under 5 s", took)
    x, y, rw, rh = b.run("state.set.region")
    check(rw and x <= 900 and y <= 600 and x + rw >= 1000 and y + rh >= 700, "whole pixels where they differ most", x, y, rw, rh)
    check("means of" in b.run("$('notes').textContent"), "the page says what is scaled down")
    read_values(b, a, c, rng, "averages")
    b.key("r")
    for _ in range(3):
        px, py = x + int(rng.integers(rw)), y + int(rng.integers(rh))
        b.mouse("mouseMoved", *spot(b, px, py))
        row = values(b)
        check(f"pixel {px}, {py};" in b.run("$('pixel').textContent") and near(map(float, row[1]), c[py, px], 1e-4 * c[py, px].max()),
              "the region has the pixels of the file", b.run("$('pixel').textContent"), row, c[py, px])
    check(b.run("document.querySelector('input[value=flip]').disabled"), "without FLIP, no such view")
    c[20, 1900] = 6e4
    pfm("b.pfm", c)
    glarepp("compare", "-q", "--no-flip", "--html", "small.html", "--html-size", "0.3", "a.pfm", "b.pfm", status=2)
    check(os.path.getsize("small.html") < 3e5, "--html-size", os.path.getsize("small.html"))
    silent(b, "a large pair")
    b.open("small.html")
    x, y, rw, rh = b.run("state.set.region")
    check(x <= 1900 < x + rw and y <= 20 < y + rh and values(b)[1] == ["60000"] * 3, "the worst pixel is a whole one", x, y, rw, rh, values(b))
    check("--html-size 0.3" in b.run("$('made').innerText"), "the command of the page has its size")
    needed = float(b.run("$('notes').innerText").split("take about ")[1].split()[0])
    glarepp("compare", "-q", "--no-flip", "--html", "whole.html", "--html-size", "40", "a.pfm", "b.pfm", status=2)
    check(0.7 < needed * 1e6 / os.path.getsize("whole.html") < 1.4, "it says which size has all pixels", needed)
    silent(b, "a large pair")


# -- hard frames -------------------------------------------------------------------

def test_hard(b, rng):
    evil = "<script>alert(1)<!--.exr"
    frame("nan.exr", "size=64x48", "kind=nan", "type=float")
    wild = halfs(np.exp(rng.normal(0, 2, (48, 64, 3))))
    wild[3, 4] = np.nan, np.inf, -np.inf
    wild[5, 6] = 1e9, -1, 1e-9
    pfm("wild.pfm", wild)
    for name, *keys in (("one.exr", "size=1x1"), ("wide.exr", "size=16384x8"), ("tall.exr", "size=3x2000"),
                        ("off.exr", "size=60x40", "origin=-70,-30", "display=0,0,59,39"), ("here.exr", "size=60x40"),
                        ("many.exr", "size=32x32", "channels=R,G,B," + ",".join(f"c{i}:float" for i in range(37))),
                        ("z.exr", "size=30x20", "channels=Z:float"), (evil, "size=30x20", "channels=R,G,B,<script>:float"),
                        ("deep.exr", "size=30x20", "deep=1")):
        frame(name, *keys)
    for what, one, two in (("NaN", "nan.exr", "nan.exr"), ("NaN and Inf", "wild.pfm", "nan.exr"), ("1x1", "one.exr", "one.exr"),
                           ("16384x8", "wide.exr", "wide.exr"), ("3x2000", "tall.exr", "tall.exr"), ("negative windows", "off.exr", "here.exr"),
                           ("40 channels", "many.exr", "many.exr"), ("depth alone", "z.exr", "z.exr"), ("<script>", evil, evil),
                           ("deep", "deep.exr", "deep.exr"), ("a missing file", "one.exr", "none.exr")):
        glarepp("compare", "-q", "--html", "hard.html", one, two)
        took = b.open("hard.html")
        for key in "2678w0":
            b.key(key)
        b.settle()
        check(took < 5 and not b.messages, f"{what}: opens in under 5 s without a message", took, *b.messages)
        text = b.run("document.body.innerText")
        if one == evil:
            check("<script>alert(1)<!--.exr" in text and "<script>" in b.run("$('facts').textContent") and
                  b.run("document.scripts.length") == 2, "names are text, never markup", text[:300])
        if what in ("deep", "a missing file"):
            check(("deep pixels" if what == "deep" else "cannot be read") in b.run("$('without').innerText"), f"{what}: no pictures, and why")
        if what == "NaN and Inf":
            b.run("point(4, 3)")
            check(values(b)[0] == ["NaN", "Infinity", "-Infinity"], "NaN and Inf by their names", values(b))
            check("are shown as 65504" in b.run("$('notes').textContent"), "what a half cannot hold is said")
        if what == "negative windows":
            b.run("point(0, 0)")
            row = values(b)
            check(b.run("$('pixel').textContent").startswith("pixel -70, -30;") and row[1] == ["0", "0", "0"] and row[0] != row[1],
                  "coordinates of the file; 0 outside of its window", row)


# -- many pairs ---------------------------------------------------------------------

def test_sequence(b, rng):
    base = halfs(np.exp(rng.normal(-1, 1, (9, 16, 3))))
    worst = [int(v) for v in rng.permutation(300)[:4] + 1]
    for i in range(1, 301):
        pfm(f"a.{i:04}.pfm", base)
        pfm(f"b.{i:04}.pfm", base * np.float32(2 if i in worst else 1.01))
    glarepp("compare", "-q", "--html", "many.html", "a.####.pfm", "b.####.pfm", status=2)
    took = b.open("many.html")
    check(took < 5, "300 frames open in under 5 s", took)
    check(os.path.getsize("many.html") < 3e6, "300 frames in 3 MB", os.path.getsize("many.html"))
    order = b.run("[...document.querySelectorAll('#strip .pair span:first-of-type')].map(n => +n.textContent)")
    check(len(order) == 300 and sorted(order[:4]) == sorted(worst) and order[4:] == sorted(order[4:]), "the worst are first", order[:6], worst)
    check(b.run("page.entries.every(e => e.set && e.thumb && e.facts)"), "all have pictures, figures and thumbnails")
    b.key("n")
    b.wait("document.body.dataset.ready.startsWith('1 ')")
    check(b.run("$('showing').textContent") == f"Pictures of {order[1]}", "n: the next")
    silent(b, "a sequence")
    some = sorted(set(range(1, 301)) - set(worst))[:18] + [max(worst), max(worst) - 1]
    glarepp("compare", "-q", "-f", ",".join(map(str, some)), "--html", "few.html", "--html-size", "0.1", "a.####.pfm", "b.####.pfm", status=2)
    b.open("few.html")
    shown = b.run("page.entries.map(e => !!e.set)")
    n = sum(shown)
    check(os.path.getsize("few.html") <= 100000 and 2 < n < 20 and all(shown[:n]) and b.run("state.set.w") == 16,
          "--html-size: the worst pairs have pictures", os.path.getsize("few.html"), shown)
    check(b.run("page.entries[0].label") == str(max(worst)) and not b.run("$('without').textContent"), "the worst is shown")
    b.run("document.querySelectorAll('#strip .pair')[19].click()")
    check(b.run("$('viewer').hidden && $('without').checkVisibility()") and f"of the {n} worst pairs" in b.run("$('without').innerText"),
          "a pair without pictures says so", b.run("$('without').innerText"))
    check(b.run("[...document.querySelectorAll('#strip .pair')].map(n => n.innerText.includes('no picture'))") == [not s for s in shown],
          "and those that have none are named")
    axe(b, "a sequence")
    os.mkdir("pages")
    glarepp("compare", "-q", "-f", f"{some[0]},{some[1]},{max(worst)}", "--html", "pages/p & q.####.html", "--html-index", "pages/index.html", "a.####.pfm", "b.####.pfm", status=2)
    b.open("pages/index.html")
    links = b.run("[...document.querySelectorAll('#table a')].map(n => n.href)")
    check([int(v[-9:-5]) for v in links] == [max(worst), some[0], some[1]], "an index has all pages, the worst first", links)
    axe(b, "an index")
    silent(b, "an index")
    b.follow("#table a", f"{max(worst):04}.html")
    check(b.run("page.entries.length") == 1, "its links lead there")
    b.follow("header a", "index.html")
    check(True, "and back")
    glarepp("compare", "-q", "-f", "1-300", "--html", "pages/####.html", "--html-index", "over all.html", "--html-size", "1", "a.####.pfm", "b.####.pfm", status=2)
    check(os.path.getsize("over all.html") < 1e6, "an index of 300 is of that size, too", os.path.getsize("over all.html"))
    b.open("pages/0003.html")
    b.follow("header a", "over%20all.html")
    silent(b, "links")


def test_styles(b):
    shutil.copy(os.path.join(ROOT, "examples", "alley.1003.exr"), "alley.exr")
    glarepp("styles", "-o", "sheet.html", "alley.exr", status=0)
    b.open("sheet.html")
    names = b.run("[...$('b').options].map(o => o.textContent)")
    check(names[:2] == ["no glare", "camera"] and len(names) == 9, "all styles", names)
    b.run("$('a').value = 2; $('b').value = 5; $('b').onchange()")
    b.wait("document.body.dataset.ready === '0 2 5'")
    made = b.run("$('made').innerText")
    check(f"glarepp --style {names[2]} alley.exr" in made and f"--style {names[5]} " in made, "two at a time, with their commands", made)
    check(b.run("state.set.scale") == 1 and os.path.getsize("sheet.html") < 13.5e6, "all pixels, of 1.5 MB a picture", os.path.getsize("sheet.html"))
    silent(b, "styles")
    axe(b, "styles")


def test_bench(b):
    frame("bench.exr", "size=96x64")
    glarepp("bench", "--runs", "1", "--html", "bench.html", "bench.exr", status=0)
    b.open("bench.html")
    points = b.run("[...document.querySelectorAll('.point')].map(n => n.getAttribute('aria-label'))")
    check(len(points) >= 8 and b.run("!!document.querySelector('.tolerance') && document.querySelector('.front').getAttribute('d').length > 5"),
          "points, their front, the tolerance", points)
    b.run("document.querySelector('.point:last-of-type').scrollIntoView({block: 'center'})")
    b.settle()
    left, top, w, h = b.box(".point:last-of-type circle")
    b.mouse("mouseMoved", left + w / 2, top + h / 2)
    check(b.run("$('named').textContent.startsWith([...document.querySelectorAll('.point')].pop().getAttribute('aria-label'))"),
          "a point is named under the pointer", b.run("$('named').textContent"))
    same = b.run("""(ps => ps.map(p => ps.filter(q => ['cx', 'cy'].every(k => p[k].baseVal.value === q[k].baseVal.value)).map(
        q => q.parentNode.getAttribute('aria-label'))).sort((p, q) => q.length - p.length)[0])([...document.querySelectorAll('.point circle')])""")
    check(len(same) > 1, "auto lies on what it took", same)
    at = b.box(f".point[aria-label='{same[0]}'] circle")
    at = at[0] + at[2] / 2, at[1] + at[3] / 2
    b.mouse("mouseMoved", *at)
    check(all(name in b.run("$('named').textContent") for name in same), "points over each other are all named", b.run("$('named').textContent"))
    taken = set()
    chosen = "document.querySelector('.point.chosen')?.getAttribute('aria-label')"
    for _ in same:
        before = b.run(chosen)
        b.mouse("mousePressed", *at, buttons=1)
        b.mouse("mouseReleased", *at)
        b.wait(f"{chosen} !== {json.dumps(before)}")
        taken.add(b.run(chosen))
    check(taken == set(same), "and chosen one after the other", taken, same)
    b.run("[...document.querySelectorAll('.point')].find(n => n.getAttribute('aria-label').startsWith('splat group 8')).focus()")
    b.key("Enter")
    b.wait("state.set.pictures[state.b].name === 'splat group 8'")
    check(b.run("document.querySelector('tr[aria-current] button').textContent") == "splat group 8", "its picture and row are chosen")
    b.key("7")
    b.settle()
    check(b.run("state.mode === 'relative' && state.B.relative.some(c => c > 0)"), "with its map of errors")
    b.run("[...document.querySelectorAll('#table thead button')].find(n => n.textContent === 'ms').click()")
    ms = b.run("[...document.querySelectorAll('#table tbody tr')].map(r => +r.cells[1].textContent)")
    check(ms == sorted(ms) and len(ms) > 8, "the table sorts", ms)
    tables = b.run("""[...document.querySelectorAll('#facts table')].map(t => [t.caption.textContent, t.tBodies[0].rows.length,
        t.tHead.innerText.split(/\\s+/), [...t.tBodies[0].rows].map(r => [...r.cells].map(c => c.textContent))])""")
    check([t[:2] for t in tables] == [["fastest within", 12], [tables[-1][0], 23]] and tables[1][0].startswith("whole run: read ") and
          any(r[:2] == ["rel_l2", "0.1"] and float(r[3]) > 0 for r in tables[0][3]) and
          all(float(r[4]) > float(r[2]) > 0 for r in tables[1][3] if r[2] != "–"), "the fastest within each error, and the whole run", tables)
    made = b.run("$('made').innerText")
    check("-e splat --group 8" in made and "--runs 1" in made, "the commands of the point, and of the page", made)
    b.resize(400, 800)
    b.settle()
    check(b.run("[...document.querySelectorAll('.point circle, #plot > .axis')].every(n => n.getBoundingClientRect().right <= 400)"),
          "400 pixels wide: all of the plot is in sight")
    silent(b, "bench")
    axe(b, "bench")
    glarepp("bench", "--runs", "1", "--tolerance", "0", "--html", "none.html", "bench.exr",
            status=0)
    b.open("none.html")
    silent(b, "bench without a tolerance, which is no place on its plot")


def main():
    rng = np.random.default_rng(40)
    b = browser.Browser()
    try:
        test_pair(b, rng)
        test_large(b, rng)
        test_hard(b, rng)
        test_sequence(b, rng)
        test_styles(b)
        test_bench(b)
    finally:
        b.close()


main()
