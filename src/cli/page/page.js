// SPDX-License-Identifier: Apache-2.0
// The viewer of pages: pictures as halfs on a canvas, their figures, and a bench's
// plot. No text of a page becomes markup: all of it is set as textContent.
'use strict';

const $ = id => document.getElementById(id);
const page = JSON.parse($('data').textContent);
const between = (v, least, most) => Math.min(Math.max(v, least), most);
const still = matchMedia('(prefers-reduced-motion: reduce)');

function make(tag, text, set = {}) {
  const node = tag.includes(':') ? document.createElementNS('http://www.w3.org/2000/svg', tag.slice(4))
    : document.createElement(tag);
  if (text !== undefined) node.textContent = text;
  for (const key in set) node.setAttribute(key, set[key]);
  return node;
}

function number(v) {
  return v === null || v === undefined ? '–' : typeof v !== 'number' ? String(v)
    : Number.isInteger(v) ? String(v) : Math.abs(v) < 1e-3 ? v.toExponential(2) : String(+v.toPrecision(5));
}

// -- numbers of pictures -------------------------------------------------------

const floats = new Float32Array(65536); // of each half
for (let i = 0; i < 65536; i++) {
  const e = i >> 10 & 31, m = i & 1023;
  const v = e === 31 ? (m ? NaN : Infinity) : e ? (1024 + m) * 2 ** (e - 25) : m * 2 ** -24;
  floats[i] = i < 32768 ? v : -v;
}

async function inflate(text) {
  const packed = atob(text), bytes = new Uint8Array(packed.length);
  for (let i = 0; i < packed.length; i++) bytes[i] = packed.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Undoes predict() of pack.c: a w x h block from `at` of v.
function restore(v, high, low, at, w, h) {
  for (let y = 0; y < h; y++) {
    for (let x = 0; x < w; x++, at++) {
      const l = x ? v[at - 1] : y ? v[at - w] : 0, u = y ? v[at - w] : l;
      const lu = x && y ? v[at - w - 1] : l;
      const least = l < u ? l : u, most = l < u ? u : l;
      const code = high[at] << 8 | low[at];
      v[at] = (lu >= most ? least : lu <= least ? most : l + u - lu) + (code >> 1 ^ -(code & 1));
    }
  }
}

// Unpacks picture i of a set, once: {rgb: three planes of halfs, relative, flip}.
function picture(set, i) {
  const p = set.pictures[i];
  p.ready = p.ready || (async () => {
    const bytes = await inflate(p.rgb), base = i ? await picture(set, 0) : null;
    const n = bytes.length / 6, w = Math.ceil(set.w / set.scale), h = Math.ceil(set.h / set.scale);
    const code = [0, 1, 2].map(c => {
      const v = new Int16Array(n), high = bytes.subarray(2 * c * n, (2 * c + 1) * n);
      const low = bytes.subarray((2 * c + 1) * n, (2 * c + 2) * n);
      restore(v, high, low, 0, w, h);
      restore(v, high, low, w * h, set.region[2], set.region[3]);
      for (let k = 0; base && k < n; k++) v[k] += base.code[c][k];
      return v;
    });
    const plane = c => c ? code[c].map((v, k) => v + code[0][k]) : code[0];
    return {
      code, rgb: [1, 0, 2].map(c => new Uint16Array(plane(c).buffer)),
      relative: p.relative ? await inflate(p.relative) : null,
      flip: p.flip ? await inflate(p.flip) : null,
    };
  })();
  return p.ready;
}

// The relative error of a code, as in find_relative() of pack.c.
const errors = Float64Array.from({length: 256}, (_, c) => c ? c === 255 ? Infinity : 10 ** ((c - 1) * 11 / 254 - 9) : 0);

// magma, as in gp_compare_heatmap(): t in [0,1] to 0xrrggbb
const powers = [[-0.002136485, -0.000749655, -0.005386128], [0.251660541, 0.677523244, 2.494026599],
  [8.353717279, -3.577719515, 0.314467903], [-27.66873309, 14.26473078, -13.64921319],
  [52.17613981, -27.94360607, 12.94416944], [-50.76852536, 29.04658282, 4.23415299],
  [18.65570507, -11.48977352, -5.60196151]];
function magma(t) {
  const v = c => powers.reduceRight((sum, p) => sum * between(t, 0, 1) + p[c], 0);
  return [0, 1, 2].reduce((all, c) => all << 8 | Math.round(255 * between(v(c), 0, 1)), 0);
}
const heat = Uint32Array.from({length: 256}, (_, c) => magma(c / 255));
const LEAST = 1e-7; // of the colours of relative errors; the most is 1
const errorColour = e => magma(e > 0 ? 1 - Math.log10(Math.min(e, 1)) / Math.log10(LEAST) : 0);
const errorHeat = Uint32Array.from(errors, errorColour);

// -- state ----------------------------------------------------------------------

const canvas = $('canvas'), paint = canvas.getContext('2d', {willReadFrequently: true});
const state = {
  entry: 0, set: null, a: 0, b: 1, A: null, B: null, mode: 'wipe', ev: 0, gamma: 2.2,
  wipe: 0.5, zoom: 1, x: 0, y: 0, // image pixel in the middle, from the window's corner
  px: 0, py: 0, odd: false, dpr: 1,
};
const codes = new Uint8ClampedArray(65536); // of each half at this exposure
let timer = 0, waiting = false;

function expose() {
  const gain = 2 ** state.ev, power = 1 / state.gamma;
  for (let i = 0; i < 65536; i++) {
    const v = floats[i] * gain;
    codes[i] = v > 0 ? Math.round(255 * Math.min(v, 1) ** power) : 0;
  }
  $('evs').textContent = `${state.ev > 0 ? '+' : ''}${state.ev} EV`;
  $('gammas').textContent = state.gamma.toFixed(1);
  histogram();
  redraw();
}

function redraw() {
  if (!waiting) requestAnimationFrame(() => { waiting = false; draw(); });
  waiting = true;
}

// The sample of a pixel, from the window's corner; -1 outside.
function sample(set, x, y) {
  const [rx, ry, rw, rh] = set.region;
  if (x < 0 || y < 0 || x >= set.w || y >= set.h) return -1;
  const w = Math.ceil(set.w / set.scale), h = Math.ceil(set.h / set.scale);
  return x >= rx && y >= ry && x < rx + rw && y < ry + rh ? w * h + (y - ry) * rw + x - rx
    : Math.floor(y / set.scale) * w + Math.floor(x / set.scale);
}

function luminance(p, at) {
  return 0.2126 * floats[p.rgb[0][at]] + 0.7152 * floats[p.rgb[1][at]] + 0.0722 * floats[p.rgb[2][at]];
}

// Error of B against A at a sample: packed with B where A is the first picture, else
// of the halfs.
const packed = () => state.a === 0 && state.B.relative, coarse = v => v > 90 ? 'over 90' : v ? `about ${+v.toPrecision(2)}` : 0;
function relative(at) {
  if (packed()) return errors[packed()[at]];
  const [a, b] = [luminance(state.A, at), luminance(state.B, at)];
  const e = Math.abs(a - b) / Math.abs(a);
  return a === b || (a !== a && b !== b) ? 0 : e >= 0 ? e : Infinity;
}
const flip = () => state.a === 0 ? state.B.flip : state.b === 0 ? state.A.flip : null;

// Returns sample -> 0xrrggbb of what a mode shows.
function shader(mode) {
  const {A, B} = state;
  if (mode === 'relative') return packed() ? at => errorHeat[B.relative[at]] : at => errorColour(relative(at));
  if (mode === 'flip') { const map = flip(); return at => map ? heat[map[at]] : 0; }
  if (mode === 'absolute') {
    const gain = 2 ** state.ev, power = 1 / state.gamma;
    const code = (a, b) => {
      const d = Math.abs(floats[a] - floats[b]) * gain;
      return a === b || d === 0 ? 0 : d > 0 ? Math.round(255 * Math.min(d, 1) ** power) : 255; // NaN: all
    };
    return at => code(A.rgb[0][at], B.rgb[0][at]) << 16 | code(A.rgb[1][at], B.rgb[1][at]) << 8 |
      code(A.rgb[2][at], B.rgb[2][at]);
  }
  const [r, g, b] = (mode === 'a' ? A : B).rgb;
  return at => codes[r[at]] << 16 | codes[g[at]] << 8 | codes[b[at]];
}

// The part of the canvas that shows a picture, in its pixels: [from, width].
function half(x) {
  const w = state.mode === 'side' ? canvas.width >> 1 : canvas.width;
  return x >= w && state.mode === 'side' ? [w, canvas.width - w] : [0, w];
}

// Image coordinates of a canvas pixel, from the window's corner.
function place(x, y) {
  const [from, w] = half(x);
  return [state.x + (x - from - w / 2) / state.zoom, state.y + (y - canvas.height / 2) / state.zoom];
}

// Draws n x n samples a pixel where pixels are smaller than the screen's, after the
// curve, so that a bright one does not spread.
function draw() {
  const set = state.set, w = canvas.width, h = canvas.height;
  if (!set || !state.A || !w || !h) return;
  const n = between(Math.ceil(1 / state.zoom), 1, 4), cut = Math.round(state.wipe * w);
  const mode = state.mode === 'flicker' ? (state.odd ? 'b' : 'a') : state.mode;
  const two = mode === 'wipe' || mode === 'side';
  const left = shader(two ? 'a' : mode), right = two ? shader('b') : left;
  const turn = mode === 'side' ? w >> 1 : mode === 'wipe' ? cut : w;
  const [rx, ry, rw, rh] = set.region, sw = Math.ceil(set.w / set.scale), squares = sw * Math.ceil(set.h / set.scale);
  const column = new Int32Array(w * n), inner = new Int32Array(w * n).fill(-1);
  for (let i = 0; i < w * n; i++) {
    const x = Math.floor(place((i + 0.5) / n, 0)[0]);
    column[i] = x >= 0 && x < set.w ? Math.floor(x / set.scale) : -1;
    if (x >= rx && x < rx + rw) inner[i] = x - rx;
  }
  const image = paint.createImageData(w, h), out = new Uint32Array(image.data.buffer);
  const sum = new Uint16Array(4 * w);
  for (let j = 0; j < h; j++) {
    sum.fill(0);
    for (let k = 0; k < n; k++) {
      const y = Math.floor(place(0, j + (k + 0.5) / n)[1]);
      if (y < 0 || y >= set.h) continue;
      const row = Math.floor(y / set.scale) * sw, at = y >= ry && y < ry + rh ? squares + (y - ry) * rw : -1;
      for (let i = 0; i < w * n; i++) {
        if (column[i] < 0) continue;
        const c = at >= 0 && inner[i] >= 0 ? at + inner[i] : row + column[i];
        const to = n === 1 ? i : Math.floor(i / n), v = to < turn ? left(c) : right(c);
        sum[4 * to] += v >> 16;
        sum[4 * to + 1] += v >> 8 & 255;
        sum[4 * to + 2] += v & 255;
        sum[4 * to + 3]++;
      }
    }
    for (let i = 0; i < w; i++) {
      const m = sum[4 * i + 3];
      if (m) out[j * w + i] = (255 << 24 | Math.round(sum[4 * i + 2] / m) << 16 | Math.round(sum[4 * i + 1] / m) << 8 |
        Math.round(sum[4 * i] / m)) >>> 0;
    }
  }
  paint.putImageData(image, 0, 0);
  drawMarks(cut);
}

// A line that reads on any picture.
function stroke(path, dash) {
  for (const [colour, width] of [['#000', 3], ['#fff', 1]]) {
    paint.strokeStyle = colour;
    paint.lineWidth = width * state.dpr;
    paint.setLineDash(width === 1 && dash ? [6 * state.dpr, 4 * state.dpr] : []);
    paint.stroke(path);
  }
}

function drawMarks(cut) {
  const set = state.set, w = canvas.width, h = canvas.height, z = state.zoom;
  const halves = state.mode === 'side' ? [0, w >> 1] : [0];
  for (const from of halves) {
    const [start, width] = half(from), path = new Path2D(), frame = new Path2D();
    const at = (x, y) => [start + width / 2 + (x - state.x) * z, h / 2 + (y - state.y) * z];
    paint.save();
    paint.beginPath(); paint.rect(start, 0, width, h); paint.clip();
    if (z >= 6 * state.dpr) {
      path.rect(...at(state.px, state.py), z, z);
      stroke(path);
    }
    if (set.scale > 1 && set.region[2]) {
      frame.rect(...at(set.region[0], set.region[1]), set.region[2] * z, set.region[3] * z);
      stroke(frame, true);
    }
    paint.restore();
  }
  const named = {wipe: 'AB', side: 'AB', flicker: state.odd ? 'B' : 'A', a: 'A', b: 'B'}[state.mode] || '';
  [...named].forEach((name, i) => {
    Object.assign(paint, {font: `600 ${15 * state.dpr}px system-ui, sans-serif`, textAlign: i ? 'right' : 'left',
      strokeStyle: '#000', fillStyle: '#fff', lineWidth: 3 * state.dpr, lineJoin: 'round'});
    const at = [name, i ? w - 8 * state.dpr : 8 * state.dpr, 20 * state.dpr];
    paint.strokeText(...at); paint.fillText(...at);
  });
  if (named === 'AB') stroke(new Path2D(`M${state.mode === 'side' ? w >> 1 : cut} 0V${h}`));
}

// -- the pixel that is read --------------------------------------------------------

function readPixel(aloud) {
  const {set, A, B} = state;
  if (!set || !A) return;
  const at = sample(set, state.px, state.py), body = $('values').tBodies[0];
  const mean = set.scale > 1 && at >= 0 && at < Math.ceil(set.w / set.scale) * Math.ceil(set.h / set.scale);
  const rows = [['A', A], ['B', B]].map(([name, p]) => [name, ...p.rgb.map(v => at < 0 ? NaN : floats[v[at]])]);
  const beyond = [state.a, state.b].map(i => set.pictures[i].clamped ? 65504 : NaN); // what is more is shown as that
  rows.push(['B − A', ...[1, 2, 3].map(c => rows[1][c] - rows[0][c])]);
  body.replaceChildren(...rows.map((r, i) => {
    const row = make('tr');
    row.append(make('th', r[0], {scope: 'row'}), ...r.slice(1).map((v, c) => make('td', at < 0 ? '–'
      : rows.slice(0, 2).some((q, k) => q[c + 1] === beyond[k] && (q === r || i === 2)) ? (i < 2 ? `≥ ${v}` : 'not known') : String(+v.toPrecision(6)))));
    return row;
  }));
  const map = flip(), most = mean ? ', the most of them' : '';
  $('pixel').textContent = `pixel ${state.px + set.x}, ${state.py + set.y}` + (at < 0 ? ': outside'
    : (mean ? `: means of ${set.scale} × ${set.scale} pixels` : '') + `; relative error ${packed() ? coarse(relative(at)) + most : number(relative(at))}` +
      (map ? `; FLIP ${(map[at] / 255).toFixed(3)}${most}` : ''));
  if (aloud) $('say').textContent = $('pixel').textContent + '; ' + rows.slice(0, 2).map(r => r.join(' ')).join('; ');
}

function point(x, y, aloud) {
  [state.px, state.py] = [between(x, 0, state.set.w - 1), between(y, 0, state.set.h - 1)];
  readPixel(aloud);
}

// -- view ----------------------------------------------------------------------------

function moveTo(x, y) {
  Object.assign(state, {x: between(x, 0, state.set.w), y: between(y, 0, state.set.h)});
  redraw();
}

// The zoom at which the picture fits, and true at that one.
const fitting = () => Math.max(Math.min(half(0)[1] / state.set.w, canvas.height / state.set.h, 64), Math.min(1, 8 * state.dpr / Math.min(state.set.w, state.set.h)));
const fitted = () => state.set && Math.abs(state.zoom / fitting() - 1) < 1e-6;

function zoomTo(zoom, x = state.x, y = state.y) {
  state.zoom = between(zoom, Math.min(fitting(), 1) / 2, 128 * state.dpr);
  moveTo(x, y);
}

const fit = () => zoomTo(fitting(), state.set.w / 2, state.set.h / 2);

// Zooms around a canvas pixel, or the middle.
function zoomBy(factor, x, y) {
  const before = state.zoom, at = x === undefined ? [state.x, state.y] : place(x, y);
  zoomTo(state.zoom * factor);
  const k = before / state.zoom;
  zoomTo(state.zoom, at[0] + (state.x - at[0]) * k, at[1] + (state.y - at[1]) * k);
}

function resize() {
  const dpr = Math.min(devicePixelRatio || 1, 2), box = canvas.getBoundingClientRect();
  const w = Math.round(box.width * dpr), h = Math.round(box.height * dpr);
  if (!w || !h || (w === canvas.width && h === canvas.height)) return;
  const whole = !canvas.ready || fitted();
  state.zoom *= w / canvas.width;
  Object.assign(canvas, {width: w, height: h, ready: true});
  state.dpr = dpr;
  if (state.set) whole ? fit() : redraw();
}

function setMode(mode) {
  const was = state.mode, whole = fitted(), radio = document.querySelector(`input[name=mode][value=${mode}]`);
  if (radio.disabled) return;
  radio.checked = true;
  state.mode = mode;
  clearInterval(timer);
  if (mode === 'flicker') timer = setInterval(() => { state.odd = !state.odd; redraw(); }, still.matches ? 2000 : 500);
  $('wipe').hidden = mode !== 'wipe';
  $('scale').hidden = mode !== 'relative' && mode !== 'flip';
  [$('low').textContent, $('high').textContent] = mode === 'flip' ? [0, '1 FLIP'] : [LEAST, '1 relative error'];
  if ((was === 'side') !== (mode === 'side') && state.set) whole ? fit() : zoomBy(mode === 'side' ? 0.5 : 2);
  resize();
  redraw();
}

function setWipe(v) {
  state.wipe = between(v, 0, 1);
  $('wipe').value = Math.round(1000 * state.wipe);
  redraw();
}

function slide(id, delta) {
  $(id).value = +$(id).value + delta;
  state[id] = +$(id).value;
  expose();
}

// The exposure at which all but 1 in 200 samples of A are below white.
function autoExposure() {
  const bins = total(state.a);
  let above = bins.reduce((s, v) => s + v, 0) / 200, i = 61;
  while (i > 0 && (above -= bins[i]) > 0) i--;
  slide('ev', between(14.5 - i / 2, -16, 16) - state.ev);
}

// The counts of a picture's half stops, of all channels.
const total = i => state.set.pictures[i].histogram.reduce((sum, bins) => sum.map((v, k) => v + bins[k]));

function histogram() {
  const svg = $('histogram');
  if (!state.set) return;
  const sums = [total(state.a), total(state.b)];
  const top = Math.log10(2 + Math.max(...sums.flat())), x = i => 10 + i * 10, y = v => 130 - 120 * Math.log10(1 + v) / top;
  const path = bins => bins.map((v, i) => `V${y(v).toFixed(1)}H${x(i + 1)}`).join('');
  const white = x(between(30 - 2 * state.ev, 0, 62));
  svg.replaceChildren(make('svg:path', '', {class: 'fillB', d: `M10 130${path(sums[1])}V130Z`}),
    make('svg:path', '', {class: 'lineA', d: `M10 130${path(sums[0])}V130`}),
    make('svg:path', '', {class: 'white', d: `M${white} 5V135`}));
  for (let e = -14; e <= 14; e += 4)
    svg.append(make('svg:text', 2 ** e < 1 ? `1/${2 ** -e}` : 2 ** e, {class: 'axis', x: x(30 + 2 * e), y: 146, 'text-anchor': 'middle'}));
}

// -- tables ----------------------------------------------------------------------------

// A table whose headings sort it: of rows {cells}, to which it adds their `tr`.
function sortable(columns, rows) {
  const table = make('table'), head = make('tr'), body = make('tbody');
  rows.forEach(r => {
    r.tr = make('tr');
    r.cells.forEach((v, i) => {
      const cell = make(i ? 'td' : 'th', v instanceof Node ? undefined : number(v), i ? {} : {scope: 'row'});
      if (v instanceof Node) cell.append(v);
      if (i && v instanceof Node) cell.className = 'text';
      if (typeof v === 'string') cell.className = 'text ' + (i && /^(file )?\w+$/.test(v) ? v.replace('file ', '') : '');
      r.tr.append(cell);
    });
    body.append(r.tr);
  });
  columns.forEach((name, i) => {
    const words = rows.every(r => typeof r.cells[i] === 'string' || r.cells[i] instanceof Node);
    const th = make('th', undefined, {scope: 'col', class: words ? 'text' : ''}), button = make('button', name, {type: 'button'});
    button.onclick = () => {
      const up = th.getAttribute('aria-sort') !== 'ascending';
      head.querySelectorAll('[aria-sort]').forEach(o => o.removeAttribute('aria-sort'));
      th.setAttribute('aria-sort', up ? 'ascending' : 'descending');
      const key = r => r.cells[i] instanceof Node ? r.cells[i].textContent : r.cells[i];
      rows.sort((p, q) => {
        const a = key(p), b = key(q), none = v => v === null || v === undefined;
        return none(a) || none(b) ? none(a) - none(b)
          : (up ? 1 : -1) * (typeof a === 'number' && typeof b === 'number' ? a - b
            : String(a).localeCompare(String(b), 'en', {numeric: true}));
      });
      body.append(...rows.map(r => r.tr));
    };
    th.append(button); head.append(th);
  });
  table.append(make('thead'), body);
  table.firstChild.append(head);
  return table;
}

function showTable(columns, rows) {
  $('table').hidden = false;
  $('table').firstElementChild.replaceChildren(sortable(columns, rows));
}

function titled(caption, columns, rows) {
  const box = make('div', undefined, {class: 'scroll', tabindex: 0, role: 'region', 'aria-label': caption});
  box.append(sortable(columns, rows.map(cells => ({cells}))));
  box.firstChild.prepend(make('caption', caption));
  return box;
}

function showFacts(entry) {
  const facts = entry.facts, parts = [];
  $('numbers').hidden = !facts;
  if (!facts) return;
  const plain = Object.entries(facts).filter(([k, v]) => !['a', 'b', 'status', 'why'].includes(k) && (v === null || typeof v !== 'object'));
  const rows = plain.map(([k, v]) => [k, v === null ? 'inf' : v]);
  if (facts.worst) rows.push(['worst', `${facts.worst.x}, ${facts.worst.y}, ${facts.worst.channel}: ${number(facts.worst.a)} and ${number(facts.worst.b)}`]);
  if (facts.flip_exposures) rows.push(['flip_exposures', facts.flip_exposures.map(v => +v.toPrecision(4)).join(', ')]);
  parts.push(titled('as --json has them', ['figure', 'value'], rows));
  if (entry.gates && entry.gates.length)
    parts.push(titled('gates', ['gate', 'status', 'found', 'limit', 'of'],
      entry.gates.map(g => [g.gate, g.status, g.found, g.limit === null ? 'any' : g.limit, g.of])));
  if (entry.channels) parts.push(make('p', `${entry.channels.length} channel${entry.channels.length > 1 ? 's' : ''}: ${entry.channels.join(', ')}`));
  $('facts').replaceChildren(...parts);
}

function command(name, text, list) {
  const dd = make('dd'), button = make('button', 'copy', {type: 'button', 'aria-label': `copy the command of ${name}`});
  const code = make('code', text);
  button.onclick = async () => {
    const done = await navigator.clipboard?.writeText(text).then(() => true, () => false) ||
      (getSelection().selectAllChildren(code), document.execCommand('copy'));
    button.textContent = done ? 'copied' : 'not copied';
  };
  dd.append(code, button);
  list.append(make('dt', name), dd);
}

function showCommands() {
  const list = $('made'), {set} = state, notes = [...(page.entries[state.entry]?.notes || [])];
  list.replaceChildren();
  for (const [name, i] of set ? [['A', state.a], ['B', state.b]] : []) {
    const p = set.pictures[i], label = set.pictures.length > 2 ? `${name}, ${p.name}` : `${name}, ${p.file || p.name}`;
    if (p.command) command(label, p.command, list);
    else list.append(make('dt', label), make('dd', p.file ? 'does not say which command made it' : 'is what the others are measured against'));
    if (p.rounded) notes.push(`${name}: ${p.rounded} values were rounded to half floats, to 1 in 2048 of each, or to 3e-8${p.relative ? '; relative errors and FLIP are of those before' : ''}`);
    if (p.clamped) notes.push(`${name}: ${p.clamped} values beyond 65504 are shown as 65504`);
    if (p.odd) notes.push(`${name}: ${p.odd} values are NaN or infinite`);
  }
  command('this page', page.command, list);
  if (set && set.scale > 1) {
    const samples = Math.ceil(set.w / set.scale) * Math.ceil(set.h / set.scale) + set.region[2] * set.region[3];
    notes.unshift(`scaled down to fit --html-size: means of ${set.scale} × ${set.scale} pixels` +
      (set.region[2] ? `; whole pixels within ${set.region[2]} × ${set.region[3]} at ${set.region[0] + set.x}, ${set.region[1] + set.y}, dashed` : '') +
      `; all pixels of these pictures take about ${+(set.bytes * set.w * set.h / samples / 1e6).toPrecision(2)} MB`);
  }
  notes.push(`glarepp ${page.version}`);
  $('notes').replaceChildren(...notes.map(n => make('li', n)));
  $('exact').textContent = set ? `${set.w} × ${set.h} at ${set.x}, ${set.y}; ` + (set.scale > 1
    ? `means of ${set.scale} × ${set.scale} pixels${set.region[2] ? ', whole pixels in the dashed frame' : ''}` : `every pixel${[state.a, state.b].some(i => set.pictures[i].rounded) ? ', as half floats' : ' as it is'}`) : '';
}

// -- bench ---------------------------------------------------------------------------------

function showBench(entry) {
  const rows = entry.table, svg = $('plot');
  $('bench').hidden = !rows;
  if (!rows) return;
  const points = rows.filter(r => r.ms > 0 && r.rel_l2 !== undefined && !r.layer).map(r => ({r, x: Math.log10(r.ms), y: Math.log10(Math.max(r.rel_l2, 1e-10))}));
  const limit = Math.log10(Math.max(entry.tolerance, 1e-10)), range = (list) => [Math.floor(Math.min(...list)), Math.floor(Math.max(...list)) + 1];
  const [x0, x1] = range([...points.map(p => p.x), 0]), [y0, y1] = range([...points.map(p => p.y), limit]);
  const x = v => 62 + (v - x0) / (x1 - x0) * 400, y = v => 370 - (v - y0) / (y1 - y0) * 350;
  const line = (cls, d) => svg.append(make('svg:path', undefined, {class: cls, d}));
  const text = (t, tx, ty, set) => svg.append(make('svg:text', t, {class: 'axis', x: tx, y: ty, ...set}));
  svg.replaceChildren();
  for (let v = x0; v <= x1; v++) { line('grid', `M${x(v)} 20V370`); text(number(10 ** v), x(v), 386, {'text-anchor': 'middle'}); }
  for (let v = y0; v <= y1; v++) { line('grid', `M62 ${y(v)}H462`); text(`1e${v}`, 56, y(v) + 4, {'text-anchor': 'end'}); }
  text('milliseconds, bright pass to layer', 262, 408, {'text-anchor': 'middle'});
  text('rel_l2', 62, 14, {});
  line('tolerance', `M62 ${y(limit)}H462`);
  text('tolerance', 460, y(limit) - 4, {'text-anchor': 'end'});
  points.sort((p, q) => p.x - q.x || q.y - p.y);
  line('front', points.filter(p => p.r.pareto).map((p, i) => `${i ? 'L' : 'M'}${x(p.x)} ${y(p.y)}`).join('') || 'M0 0');
  const name = list => { $('named').textContent = list.map(q => q.r.node.getAttribute('aria-label') + (q.r.pareto ? '; no other is both faster and nearer' : '')).join('. ') +
    (list.length > 1 ? '. Click for one after the other' : ''); };
  let label = 0;
  points.sort((p, q) => q.y - p.y);
  for (const [i, p] of points.entries()) { // (no label is as low as the axis's)
    label = Math.min(Math.max(y(p.y) + 4, label + 15), 370 - 15 * (points.length - 1 - i));
    const node = make('svg:g', undefined, {class: 'point', tabindex: 0, role: 'button', 'aria-label': `${p.r.name}: ${number(p.r.ms)} ms, rel_l2 ${number(p.r.rel_l2)}`});
    node.append(make('svg:path', undefined, {class: 'grid', d: `M${x(p.x)} ${y(p.y)}L472 ${label - 4}`}),
      make('svg:circle', undefined, {cx: x(p.x), cy: y(p.y), r: 6}), make('svg:text', p.r.name, {class: p.r.pareto ? '' : 'dim', x: 476, y: label}));
    const near = [p, ...points.filter(q => q !== p && Math.hypot(x(q.x) - x(p.x), y(q.y) - y(p.y)) < 9)];
    const under = e => e.target.tagName === 'circle' ? near : [p]; // those that hide each other
    node.onpointerover = e => name(under(e));
    node.onfocus = () => name([p]);
    node.onclick = e => choose(under(e)[(under(e).findIndex(q => q.r.node.classList.contains('chosen')) + 1) % under(e).length].r);
    node.onkeydown = e => { if (e.key === 'Enter' || e.key === ' ') { e.preventDefault(); choose(p.r); } };
    svg.append(p.r.node = node);
  }
  const columns = ['name', 'ms', 'ms_first', 'rel_l2', 'max_rel', 'flip', 'bound', 'options'], lines = rows.map(r => {
    const pick = make('button', r.name, {type: 'button'});
    pick.onclick = () => choose(r);
    return r.line = {cells: [pick, ...columns.slice(1).map(c => c === 'options' ? make('span', r.why || r.options) : r[c] ?? null)]};
  });
  showTable(columns, lines);
  const table = (caption, names, all) => titled(caption, names, all.map(r => names.map(c => r[c] ?? null))), w = entry.whole;
  const before = w && (w.read_ms || 0) + w.glare_ms + w.tone_ms;
  $('numbers').hidden = false;
  $('facts').replaceChildren(table('fastest within', ['by', 'within', 'name', 'ms', 'error', 'bound', 'options'], entry.choices), ...w ? [table(
    `whole run: read ${number(w.read_ms)}, glare ${number(w.glare_ms)}, compose and tone map ${number(w.tone_ms)} ms, then one of; pareto: of its format`,
    ['options', 'format', 'ms', 'bytes', 'whole ms', 'default', 'pareto'], w.outputs.map(o => ({...o, 'whole ms': before + o.ms || null})))] : []);
}

const current = (node, on) => on ? node.setAttribute('aria-current', 'true') : node.removeAttribute('aria-current');

// Marks a row and its point, if there is one of that name.
function mark(name) {
  for (const r of page.entries[state.entry].table || []) {
    r.node?.classList.toggle('chosen', r.name === name);
    current(r.line.tr, r.name === name);
  }
}

// Shows the picture of a row.
function choose(row) {
  const i = state.set ? state.set.pictures.findIndex(p => p.name === row.name) : -1;
  if (i >= 0) pick(0, i);
  else { mark(row.name); $('named').textContent = `${row.name}: its picture is not on the page`; }
}

// -- entries ---------------------------------------------------------------------------------

async function pick(a, b) {
  const set = state.set, turn = state.turn = (state.turn || 0) + 1;
  const [A, B] = await Promise.all([picture(set, a), picture(set, b)]);
  if (set !== state.set || turn !== state.turn) return; // another was chosen meanwhile
  Object.assign(state, {a, b, A, B});
  $('a').value = a; $('b').value = b;
  const without = !flip(), radio = document.querySelector('input[name=mode][value=flip]');
  radio.disabled = without;
  if (without && state.mode === 'flip') setMode('wipe');
  mark(set.pictures[b].name);
  showCommands();
  expose();
  readPixel();
  document.body.dataset.ready = `${state.entry} ${a} ${b}`; // for tests
}

const link = (text, path) => make('a', text, {href: path.split('/').map(encodeURIComponent).join('/')});
const several = () => page.entries.length > 1;
const coloured = (text, result) => make('span', text, {class: result.replace('file ', '')});

// Counts the pairs of each result.
function tally() {
  const count = {};
  for (const e of page.entries) if (e.facts) count[e.facts.result] = (count[e.facts.result] || 0) + 1;
  return several() ? Object.entries(count).map(([k, n]) => coloured(`${n} ${k} `, k)) : [];
}

async function open(i) {
  const entry = page.entries[i], set = entry?.set || null, was = state.set;
  Object.assign(state, {entry: i, set, A: null, B: null});
  $('viewer').hidden = !set;
  document.querySelectorAll('#strip .pair').forEach((n, k) => {
    current(n, k === i && page.kind !== 'index');
    if (page.kind !== 'index') n.tabIndex = k === i ? 0 : -1; // n and p go to others
    if (k === i) n.parentNode.parentNode.scrollLeft = n.offsetLeft - n.parentNode.parentNode.offsetLeft - 40;
  });
  $('showing').textContent = entry?.label ? `Pictures of ${entry.label}` : 'Pictures';
  if (entry && page.kind !== 'index') { showFacts(entry); showBench(entry); }
  showCommands();
  const result = page.kind !== 'index' && entry?.facts?.result;
  $('verdict').replaceChildren(...tally(), ...(result ? [coloured((entry.label ? `${several() ? '· ' : ''}${entry.label}: ` : '') + result, result),
    make('span', entry.facts.why ? ` (${entry.facts.why})` : '')] : []));
  $('without').textContent = set || !result ? '' : 'No pictures here: ' + (entry.facts.why || (entry.notes || []).find(n => /^deep|to show$/.test(n)) ||
    `--html-size has room for those of the ${page.entries.filter(e => e.set).length} worst pairs; raise it, or compare this pair alone. Its figures are below.`);
  if (!set) { document.body.dataset.ready = `${i}`; return; }
  const worst = entry.facts?.worst;
  $('worst').hidden = !worst;
  $('region').hidden = !(set.scale > 1 && set.region[2]);
  for (const id of ['a', 'b'])
    $(id).replaceChildren(...set.pictures.map((p, k) => make('option', p.file ? `${p.name}: ${p.file}` : p.name, {value: k})));
  canvas.style.aspectRatio = `${set.w} / ${set.h}`; resize();
  if (!was || was.w !== set.w || was.h !== set.h) fit();
  point(...worst ? [worst.x - set.x, worst.y - set.y] : [set.w >> 1, set.h >> 1]);
  await pick(0, Math.min(1, set.pictures.length - 1));
}

async function showThumb(thumb, to) {
  const rgb = await inflate(thumb.rgb), image = new ImageData(thumb.w, thumb.h);
  for (let i = 0; i < thumb.w * thumb.h; i++) image.data.set([rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2], 255], 4 * i);
  to.getContext('2d').putImageData(image, 0, 0);
}

function list() {
  const index = page.kind === 'index', strip = $('strip').firstElementChild;
  $('strip').hidden = !several() && !index;
  if ($('strip').hidden) return;
  const node = (e, i, text) => index ? link(text, e.href)
    : Object.assign(make('button', text, {type: 'button'}), {onclick: () => open(i)});
  page.entries.forEach((e, i) => {
    const item = make('li'), button = node(e, i), thumb = e.thumb || {w: 16, h: 9};
    const map = make('canvas', undefined, {width: thumb.w, height: thumb.h, 'aria-hidden': 'true'});
    button.className = 'pair';
    button.append(map, make('span', e.label || e.facts?.b || e.name));
    if (e.facts) button.append(coloured(e.facts.result, e.facts.result), make('span', e.set || index ? '' : 'no picture'));
    if (e.thumb) showThumb(e.thumb, map);
    item.append(button);
    strip.append(item);
  });
  if (!page.entries[0]?.facts) return;
  const columns = ['pair', 'result', 'flip', 'rel_l2', 'max_rel', 'max', 'failed'];
  showTable(columns, page.entries.map((e, i) => ({
    cells: [node(e, i, e.label || e.facts.b), ...columns.slice(1).map(c => e.facts[c] ?? null)]})));
}

// -- input ---------------------------------------------------------------------------------------

function press(e) {
  if (e.ctrlKey || e.metaKey || e.altKey || $('help').open || e.target.matches('select')) return;
  const arrow = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]}[e.key];
  const {set} = state, modes = [...document.querySelectorAll('input[name=mode]')];
  if (e.key === '?') $('help').showModal();
  else if (e.key === 'n' || e.key === 'p') {
    const to = state.entry + (e.key === 'n' ? 1 : -1);
    if (to >= 0 && to < page.entries.length && page.kind !== 'index') open(to);
  } else if (!set || !state.A) return;
  else if (arrow && e.target === canvas) {
    const step = e.shiftKey ? 10 : 1;
    point(state.px + step * arrow[0], state.py + step * arrow[1], true);
    const [from, w] = half(0), far = (d, size) => Math.abs(d) > size / 2 / state.zoom - 1;
    moveTo(far(state.px - state.x, w - from) ? state.px + 0.5 : state.x, far(state.py - state.y, canvas.height) ? state.py + 0.5 : state.y);
  } else if (arrow && !arrow[1] && state.mode === 'wipe' && !e.target.matches('input, .point, .scroll')) setWipe(state.wipe + arrow[0] / 100);
  else if (/^[1-8]$/.test(e.key)) setMode(modes[e.key - 1].value);
  else {
    const act = {'+': () => zoomBy(2), '=': () => zoomBy(2), '-': () => zoomBy(0.5), 0: fit, z: () => $('one').click(),
      e: () => slide('ev', -0.5), E: () => slide('ev', 0.5), g: () => slide('gamma', -0.1),
      G: () => slide('gamma', 0.1), a: autoExposure, x: () => pick(state.b, state.a),
      w: () => $('worst').click(), r: () => $('region').click()}[e.key];
    if (!act) return;
    act();
  }
  if (e.target === canvas || e.key === '?') e.preventDefault();
}

function listen() {
  let drag = null; // 'wipe', or the last place
  const at = e => { const b = canvas.getBoundingClientRect(); return [(e.clientX - b.left) * state.dpr, (e.clientY - b.top) * state.dpr]; };
  const nearWipe = x => state.mode === 'wipe' && Math.abs(x - state.wipe * canvas.width) < 12 * state.dpr;
  canvas.onpointerdown = e => { drag = nearWipe(at(e)[0]) ? 'wipe' : at(e); canvas.setPointerCapture(e.pointerId); };
  canvas.onpointerup = canvas.onpointercancel = () => { if (drag === 'wipe') $('wipe').focus(); drag = null; };
  canvas.onpointermove = e => {
    const [x, y] = at(e);
    if (!state.set || !state.A) return;
    canvas.style.cursor = drag === 'wipe' || nearWipe(x) ? 'ew-resize' : '';
    if (drag === 'wipe') setWipe(x / canvas.width);
    else if (drag) {
      moveTo(state.x - (x - drag[0]) / state.zoom, state.y - (y - drag[1]) / state.zoom);
      drag = [x, y];
    } else point(...place(x, y).map(Math.floor));
  };
  canvas.addEventListener('wheel', e => {
    if (!e.ctrlKey && document.activeElement !== canvas) return;
    e.preventDefault();
    zoomBy(2 ** (-e.deltaY / 200), ...at(e));
  }, {passive: false});
  canvas.onfocus = canvas.onblur = redraw;
  $('wipe').oninput = () => setWipe($('wipe').value / 1000);
  for (const id of ['ev', 'gamma']) $(id).oninput = () => slide(id, 0);
  $('modes').onchange = e => setMode(e.target.value);
  $('a').onchange = $('b').onchange = () => pick(+$('a').value, +$('b').value);
  $('auto').onclick = autoExposure; $('fit').onclick = fit;
  $('one').onclick = () => zoomTo(state.dpr);
  $('in').onclick = () => zoomBy(2); $('out').onclick = () => zoomBy(0.5);
  $('worst').onclick = () => {
    const w = page.entries[state.entry].facts?.worst;
    if (!w) return;
    point(w.x - state.set.x, w.y - state.set.y, true);
    zoomTo(Math.max(state.zoom, 16 * state.dpr), state.px + 0.5, state.py + 0.5);
  };
  $('region').onclick = () => {
    const [x, y, w, h] = state.set.region;
    if (w) zoomTo(Math.min(half(0)[1] / w, canvas.height / h), x + w / 2, y + h / 2);
  };
  $('ask').onclick = () => $('help').showModal();
  addEventListener('keydown', press); new ResizeObserver(resize).observe(canvas);
}

$('title').textContent = document.title = page.title;
if (page.index) $('ask').before(link('all pages', page.index));
$('map').getContext('2d').putImageData(new ImageData(new Uint8ClampedArray(Array.from(heat, v => [v >> 16, v >> 8 & 255, v & 255, 255]).flat()), 256, 1), 0, 0);
if (typeof DecompressionStream === 'undefined') {
  $('trouble').textContent = 'This browser cannot unpack the pictures (DecompressionStream): take one of 2023 or later. The figures are below.';
  page.entries.forEach(e => { delete e.set; delete e.thumb; });
}
for (const [mode, name] of Object.entries({wipe: 'slider', side: 'side by side', flicker: 'flicker', a: 'A', b: 'B',
  absolute: '|A − B|', relative: 'relative', flip: 'FLIP'})) {
  const label = make('label'), radio = make('input', undefined, {type: 'radio', name: 'mode', value: mode});
  label.append(radio, ` ${name}`);
  $('modes').append(label);
}
listen();
list();
setMode('wipe');
open(0);
