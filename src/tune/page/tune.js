// The page of `gen tune`. The text of the recipe is the one truth: a knob asks the server to write its key into the
// text, and every answer says what all knobs show. Nothing is loaded from elsewhere.
"use strict";

const $ = (id) => document.getElementById(id);
const make = (tag, properties = {}, ...children) => {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
};

const QUICK = 256;            // pixels of a side of the region that is answered first
const MOST_PIXELS = 1 << 20;  // pixels of the largest region that is asked for
const CALM_MS = 250;          // rest after the last change before the whole scan is refined
const STRIP = 8;              // samples of the strip
const HISTORY = 200;          // texts that Undo goes back to

const page = Array.from(crypto.getRandomValues(new Uint32Array(2)), (n) => n.toString(36)).join("-");
let start = null;             // what the server says once
let state = null;             // the last state without faults
let text = "";                // the text of the recipe
let faults = [];              // what is wrong with it
let written = new Set();      // keys that it has
let seed = 0, index = 0;
let turn = 0, look = 0;       // numbers of the state and of what is looked at
let region = null;            // maps of a region, as numbers
let scan = null;              // maps of the whole scan, as pictures
let pick = null;              // picked profile and column
let exposure = null;
let sections = [];
const history = [];
const rows = new Map();       // rows of the keys, by path

async function ask(name, question) {
  const answer = await fetch(`api/${name}`, {
    method: "POST", headers: { "Content-Type": "application/json" }, body: JSON.stringify(question),
  });
  if ((answer.headers.get("Content-Type") || "").startsWith("application/json")) {
    const document = await answer.json();
    return document;
  }
  return answer.arrayBuffer();
}
const sampleQuestion = (more = {}) => ({ text, seed, index, page, turn, look, ...more });
const isBytes = (answer) => answer instanceof ArrayBuffer;
const said = (words, busy = false) => { $("state").textContent = words; $("state").classList.toggle("busy", busy); };
const figure = (value, digits = 4) => {
  if (value === null || value === undefined || Number.isNaN(value)) return "-";
  if (value === 0) return "0";
  const size = Math.abs(value);
  return size >= 1e6 || size < 1e-4 ? value.toExponential(digits - 1) : String(Number(value.toPrecision(digits)));
};

// ---- States: each answer says what the text has become ----

let asking = false;
let nextState = null;
const waitingEdits = new Map();

/// Writes a key, or takes it out for `null`; of a key that moves on meanwhile the last value counts.
function edit(key, value) {
  waitingEdits.set(key, value);
  goOn();
}
/// Asks for the state of the text, of another sample, or of another class.
function refresh(more = {}) {
  nextState = { ...(nextState || {}), ...more };
  goOn();
}
async function goOn() {
  if (asking) return;
  asking = true;
  try {
    while (waitingEdits.size > 0 || nextState) {
      const question = { text, seed, index, class: $("scope").value || null, ...(nextState || {}) };
      nextState = null;
      const [entry] = waitingEdits;
      if (entry) {
        waitingEdits.delete(entry[0]);
        question.edit = { key: entry[0], value: entry[1] };
      }
      const before = text;
      const answer = await ask("state", question);
      // What was typed meanwhile is newer.
      if (text !== before) {
        if (entry && !waitingEdits.has(entry[0])) waitingEdits.set(...entry); else refresh();
        continue;
      }
      take(answer, entry ? entry[0] : null);
    }
  } catch (error) {
    said("gen tune has ended: start it again, and open the address that it prints");
  } finally {
    asking = false;
  }
}

function take(answer, key) {
  if (answer.fault !== undefined) {
    faults = [{ key: key || "", line: 0, problem: answer.fault, remedy: "" }];
    showFaults();
    return;
  }
  if (answer.text !== text) {
    history.push(text);
    if (history.length > HISTORY) history.shift();
    $("undo").disabled = false;
  }
  text = answer.text;
  if ($("text").value !== text) $("text").value = text;
  faults = answer.faults;
  written = new Set(answer.written);
  if (faults.length === 0) {
    const isOther = !state || answer.hash !== state.hash || answer.id !== state.id || answer.text !== state.text;
    index = answer.index;
    $("index").value = index;
    const isNewScan = !state || state.columns !== answer.columns || state.profiles !== answer.profiles;
    state = answer;
    if (isNewScan) beginScan();
    showSample();
    if (isOther) { turn += 1; renew(); }
  }
  showKeys();
  showFaults();
  showCommand();
  if (state && buildKeys.subject && buildKeys.subject !== state.subject) buildKeys().then(showFaults);
}

/// A scan of another size: small ones are shown whole, of large ones the middle at true pixels, which is there at once.
function beginScan() {
  scan = region = exposure = null;
  pick = [state.profiles >> 1, state.columns >> 1];
  fitting = Math.max(state.columns, state.profiles) <= 4 * QUICK;
  if (fitting) { fit(); return; }
  const { width, height } = viewSize();
  view = { sx: 1, sy: 1, x: (state.columns - width) / 2, y: (state.profiles - height) / 2 };
}

// ---- What is rendered: a region at once, the rest behind ----

let calm = null;
let stripOf = "";

function renew() {
  if (scan) scan.stale = true;
  askRegion();
  clearTimeout(calm);
  calm = setTimeout(refine, CALM_MS);
}

/// The pixels that the first map's view shows.
function visible() {
  const { width, height } = viewSize();
  const first = (at, all) => Math.min(Math.max(Math.floor(at), 0), all - 1);
  const column = first(view.x, state.columns), profile = first(view.y, state.profiles);
  return {
    column, profile,
    columns: first(view.x + width / view.sx, state.columns) - column + 1,
    profiles: first(view.y + height / view.sy, state.profiles) - profile + 1,
  };
}

let regionAsked = null;
async function askRegion(atHand = false) {
  if (!state) return;
  const seen = visible();
  let asked;
  if (atHand || seen.columns * seen.profiles <= QUICK * QUICK) {
    if (seen.columns * seen.profiles > MOST_PIXELS) return;
    asked = {
      profile: seen.profile + (seen.profiles >> 1), column: seen.column + (seen.columns >> 1),
      profiles: seen.profiles, columns: seen.columns,
    };
  } else {
    asked = {
      profile: Math.round(seen.profile + seen.profiles / 2), column: Math.round(seen.column + seen.columns / 2),
      profiles: QUICK, columns: QUICK,
    };
  }
  look += 1;
  const question = sampleQuestion({ ...asked, at_hand: atHand });
  regionAsked = question;
  const begun = performance.now();
  if (!atHand) said("rendering", true);
  const answer = await ask("region", question);
  if (question.look !== look || question.turn !== turn) return;
  if (!isBytes(answer)) {
    if (answer.status === 422) said(answer.fault);
    return;
  }
  region = unpackRegion(answer);
  if (!atHand) {
    const ms = performance.now() - begun;
    said(`${region.columns} x ${region.profiles} pixels in ${Math.round(ms)} ms`);
    window.lastRegionMs = ms;
  }
  paintRegion();
  if (fitting) fit(); else draw();
  drawHistogram();
  showValues();
}

function unpackRegion(bytes) {
  const length = new DataView(bytes).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  const pixels = head.profiles * head.columns;
  let at = 4 + length;
  const floats = () => { const map = new Float32Array(bytes, at, pixels); at += 4 * pixels; return map; };
  head.maps = [floats(), floats(), floats()];
  if (head.grey) head.maps.push(floats());
  head.instance = new Uint16Array(bytes.slice(at, at + 2 * pixels));
  head.class = new Uint8Array(bytes, at + 2 * pixels, pixels);
  head.turn = turn;
  return head;
}

async function refine() {
  const own = turn;
  const isOld = () => own !== turn;
  await askExposure();
  if (isOld()) return;
  const rig = await ask("rig", sampleQuestion());
  if (isOld()) return;
  if (rig.numbers) showRig(rig);
  if (state.columns * state.profiles > 4 * QUICK * QUICK && (!scan || scan.stale)) {
    const answer = await ask("look", sampleQuestion());
    if (isOld()) return;
    if (answer.pictures) await takeLook(answer);
  }
  said(`refining to the whole scan of ${state.columns} x ${state.profiles} pixels`, true);
  const whole = await ask("scan", sampleQuestion());
  if (isOld()) return;
  if (whole.fault !== undefined) { if (whole.status === 422) said(whole.fault); return; }
  await takeScan(whole);
  if (isOld()) return;
  said("the whole scan is there");
  await askRegion(true);
  await fillStrip(isOld);
}

const decoded = async (url) => { const image = new Image(); image.src = url; await image.decode(); return image; };

async function takeScan(answer) {
  const pictures = await Promise.all([...answer.maps.map((map) => map.picture), answer.labels].map(decoded));
  const labels = pictures.pop();
  scan = { ...answer, pictures, labels, stale: false, coarse: false, turn };
  if (!$("hold").checked || !scales.length) setScales(scan.maps);
  showMaps();
  if (fitting) fit();
  paintRegion();
  draw();
  drawHistogram();
}
/// A look at a few profiles, until the scan is there.
async function takeLook(answer) {
  const pictures = await Promise.all(answer.pictures.map(decoded));
  const labels = pictures.pop();
  scan = { pictures, labels, stale: true, coarse: true, width: pictures[0].naturalWidth, height: pictures[0].naturalHeight, turn };
  draw();
}

// ---- Maps ----

const NAMES = ["Range", "Reflectance", "Scatter less dark", "Grey, under lamps"];
let view = { x: 0, y: 0, sx: 1, sy: 1 };
let fitting = true;
let scales = [];
let panels = [];
let paints = [];
let overlay = null;

const mapCount = () => (region ? region.maps.length : 3);
const less = (map) => (map === 2 ? state.scatter_dark : 0);
const unitOf = (map) => (map === 0 ? state.range_unit : "DN");

function setScales(maps) {
  scales = maps.map(({ low, high }) => ({ low, high }));
}
/// Scales of what is known of a sample whose whole scan is not there yet: of the region's values, as of a scan's.
function regionScales() {
  return region.maps.map((map, number) => {
    const known = [];
    region.maps[0].forEach((z, at) => { if (!Number.isNaN(z) && !Number.isNaN(map[at])) known.push(map[at]); });
    const values = Float32Array.from(known).sort();
    const end = (share) => (values.length ? values[Math.floor((values.length - 1) * share)] : 0);
    if (number === 3) return { low: 0, high: state.most_dn };
    const high = end(0.995) - less(number);
    return number === 0 ? { low: end(0.005), high: Math.max(high, end(0.005) + 0.1) } : { low: 0, high: Math.max(high, 0.1) };
  });
}

function showMaps() {
  const count = mapCount();
  if (panels.length === count) { panels.forEach(showScale); return; }
  $("maps").replaceChildren();
  panels = [];
  for (let number = 0; number < count; number += 1) {
    const canvas = make("canvas");
    canvas.setAttribute("aria-hidden", "true");
    const ends = make("span");
    const scale = make("canvas", { className: "scale", width: 256, height: 1 });
    scale.setAttribute("aria-hidden", "true");
    const element = make("figure", {}, make("figcaption", {}, make("b", { textContent: NAMES[number] }), ends), canvas, scale);
    panels.push({ canvas, ends, scale, element, number });
    $("maps").append(element);
    const context = scale.getContext("2d");
    const colours = context.createImageData(256, 1);
    for (let at = 0; at < 256; at += 1) colours.data.set([...colour(number, at / 255), 255], 4 * at);
    context.putImageData(colours, 0, 0);
    watch(canvas);
  }
  const options = NAMES.slice(0, count).map((name, value) => make("option", { value, textContent: name }));
  const chosen = $("histogram-of").value || "1";
  $("histogram-of").replaceChildren(...options);
  $("histogram-of").value = chosen;
  panels.forEach(showScale);
  size();
}
function showScale({ ends, number }) {
  const scale = scales[number];
  if (scale) ends.textContent = `${figure(scale.low)} to ${figure(scale.high)} ${unitOf(number)}`;
}

const viewSize = () => {
  const canvas = panels[0] && panels[0].canvas;
  return canvas ? { width: canvas.width, height: canvas.height } : { width: QUICK, height: QUICK };
};

function size() {
  const ratio = window.devicePixelRatio || 1;
  for (const { canvas } of panels) {
    const box = canvas.getBoundingClientRect();
    const [width, height] = [Math.max(1, Math.round(box.width * ratio)), Math.max(1, Math.round(box.height * ratio))];
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  }
  if (fitting) fit(); else draw();
  drawExposure();
  drawHistogram();
}

/// Size of the picture that `gen preview` makes of a map.
function panelSize() {
  if (scan && !scan.coarse) return [scan.width, scan.height];
  if (!region) return [state.columns, state.profiles];
  const across = state.columns * region.column_mm, along = state.profiles * state.step_mm;
  const zoom = Math.min(400 / across, 800 / along);
  return [Math.max(150, Math.round(across * zoom)), Math.max(1, Math.round(along * zoom))];
}
/// All of the scan, true to scale, as `gen preview` shows it and no larger.
function fit() {
  if (!state || !panels.length) return;
  fitting = true;
  const { width, height } = viewSize();
  const [across, along] = panelSize();
  const zoom = Math.min(1, width / across, height / along);
  view = { sx: zoom * across / state.columns, sy: zoom * along / state.profiles, x: 0, y: 0 };
  centre();
  draw();
}
/// Keeps the scan in view: in the middle where it is smaller.
function centre() {
  const { width, height } = viewSize();
  const keep = (at, seen, all) => (seen >= all ? (all - seen) / 2 : Math.min(Math.max(at, 0), all - seen));
  view.x = keep(view.x, width / view.sx, state.columns);
  view.y = keep(view.y, height / view.sy, state.profiles);
}
function zoomTo(sx, sy, at = null) {
  const { width, height } = viewSize();
  const [px, py] = at || [width / 2, height / 2];
  const [column, profile] = [view.x + px / view.sx, view.y + py / view.sy];
  const bound = (zoom) => Math.min(Math.max(zoom, 1 / 64), 32);
  fitting = false;
  view.sx = bound(sx); view.sy = bound(sy);
  view.x = column - px / view.sx; view.y = profile - py / view.sy;
  centre();
  draw();
  moved();
}
let moving = null;
/// The view has moved: after a moment its pixels are asked for.
function moved() {
  clearTimeout(moving);
  moving = setTimeout(() => askRegion(Boolean(scan) && !scan.stale), 120);
}

/// Colour of a number in [0, 1], as the program has it.
function colour(map, t) {
  if (map === 0) return start.colours[Math.round(255 * t)];
  const level = Math.floor(Math.fround(255 * t));
  return [level, level, level];
}
const MISSING = [130, 25, 25];

/// The pictures of the region, a pixel for each of the scan.
function paintRegion() {
  if (!region || !state) return;
  if (region.maps.length !== panels.length) showMaps();
  if (!scales.length || scales.length !== region.maps.length || (scan === null && !$("hold").checked)) {
    scales = regionScales();
    panels.forEach(showScale);
  }
  const { columns, profiles } = region;
  paints = region.maps.map((map, number) => {
    const picture = paints[number] && paints[number].width === columns && paints[number].height === profiles
      ? paints[number] : make("canvas", { width: columns, height: profiles });
    const context = picture.getContext("2d");
    const image = context.createImageData(columns, profiles);
    const { low, high } = scales[number];
    const dark = less(number);
    for (let at = 0; at < map.length; at += 1) {
      const value = number === 2 ? Math.max(map[at] - dark, 0) : map[at];
      const t = Math.min(Math.max(Math.fround(Math.fround(value - low) / Math.fround(high - low)), 0), 1);
      const [red, green, blue] = Number.isNaN(value) ? MISSING : colour(number, t);
      image.data[4 * at] = red; image.data[4 * at + 1] = green; image.data[4 * at + 2] = blue; image.data[4 * at + 3] = 255;
    }
    context.putImageData(image, 0, 0);
    return picture;
  });
  if (!overlay || overlay.width !== columns || overlay.height !== profiles) {
    overlay = make("canvas", { width: columns, height: profiles });
  }
  const context = overlay.getContext("2d");
  const image = context.createImageData(columns, profiles);
  const colours = new Map(start.classes.map((known) => [known.value, known.colour]));
  region.class.forEach((value, at) => image.data.set([...(colours.get(value) || [0, 0, 0]), 255], 4 * at));
  context.putImageData(image, 0, 0);
}

function draw() {
  if (!state || !start) return;
  for (const { canvas, number, element } of panels) {
    const context = canvas.getContext("2d");
    context.clearRect(0, 0, canvas.width, canvas.height);
    const place = (x, y, columns, profiles) =>
      [(x - view.x) * view.sx, (y - view.y) * view.sy, columns * view.sx, profiles * view.sy];
    // Edges of one to one pictures lie on whole pixels.
    const put = (picture, box) => {
      const [x, y, width, height] = box;
      const isWhole = Math.abs(width - picture.width) < 0.5 && Math.abs(height - picture.height) < 0.5;
      if (isWhole) context.drawImage(picture, Math.round(x), Math.round(y));
      else context.drawImage(picture, x, y, width, height);
    };
    const isShown = scan && scan.pictures[number];
    element.classList.toggle("stale", Boolean(scan && scan.stale));
    context.imageSmoothingEnabled = view.sx < 1;
    if (isShown) put(scan.pictures[number], place(0, 0, state.columns, state.profiles));
    // Where the picture of the whole scan is as fine as the view, it is what `gen preview` shows.
    const isCoarse = !scan || scan.stale || view.sx * state.columns > scan.width + 0.5;
    const isFine = region && paints[number] && isCoarse;
    if (isFine) {
      context.imageSmoothingEnabled = view.sx < 1;
      put(paints[number], place(region.column, region.profile, region.columns, region.profiles));
    }
    if ($("labels").checked) {
      context.globalAlpha = 0.45;
      context.imageSmoothingEnabled = false;
      if (isShown) put(scan.labels, place(0, 0, state.columns, state.profiles));
      if (isFine) put(overlay, place(region.column, region.profile, region.columns, region.profiles));
      context.globalAlpha = 1;
    }
    if (pick) {
      const y = (pick[0] + 0.5 - view.y) * view.sy;
      context.fillStyle = "rgba(255, 90, 60, 0.8)";
      context.fillRect(0, Math.round(y), 6, 1);
      context.fillRect(canvas.width - 6, Math.round(y), 6, 1);
    }
  }
  $("zoom").textContent = `${figure(100 * view.sx, 3)} % of columns, ${figure(100 * view.sy, 3)} % of profiles`;
}

// ---- Pointer and keyboard over the maps ----

let dragged = null;
let pointed = null;
function pixelAt(canvas, event) {
  const box = canvas.getBoundingClientRect();
  const x = (event.clientX - box.left) * canvas.width / box.width, y = (event.clientY - box.top) * canvas.height / box.height;
  const column = Math.floor(view.x + x / view.sx), profile = Math.floor(view.y + y / view.sy);
  return { x, y, column, profile, inside: column >= 0 && profile >= 0 && column < state.columns && profile < state.profiles };
}
function watch(canvas) {
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    dragged = { x: event.clientX, y: event.clientY, view: { ...view }, far: false };
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!state) return;
    if (dragged) {
      const ratio = canvas.width / canvas.getBoundingClientRect().width;
      const [dx, dy] = [(event.clientX - dragged.x) * ratio, (event.clientY - dragged.y) * ratio];
      if (Math.hypot(dx, dy) > 4) dragged.far = true;
      if (dragged.far) {
        fitting = false;
        view = { ...dragged.view, x: dragged.view.x - dx / view.sx, y: dragged.view.y - dy / view.sy };
        centre();
        draw();
      }
    }
    const at = pixelAt(canvas, event);
    pointed = at.inside ? [at.profile, at.column] : null;
    showValues();
  });
  canvas.addEventListener("pointerleave", () => { pointed = null; showValues(); });
  canvas.addEventListener("pointerup", (event) => {
    const was = dragged;
    dragged = null;
    if (!was || !state) return;
    if (was.far) { moved(); return; }
    const at = pixelAt(canvas, event);
    if (at.inside) pickPixel(at.profile, at.column);
  });
  canvas.addEventListener("pointercancel", () => { dragged = null; });
  canvas.addEventListener("wheel", (event) => {
    if (!state) return;
    event.preventDefault();
    const by = 2 ** (event.deltaY < 0 ? 0.5 : -0.5);
    const { x, y } = pixelAt(canvas, event);
    zoomTo(view.sx * by, view.sy * by, [x, y]);
  }, { passive: false });
}
function pickPixel(profile, column) {
  pick = [profile, column];
  showValues();
  draw();
  askExposure();
}
function onMapKey(event) {
  if (!state) return;
  const { width, height } = viewSize();
  const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  if (step) {
    fitting = false;
    view.x += step[0] * width / view.sx / 8; view.y += step[1] * height / view.sy / 8;
    centre(); draw(); moved();
  } else if (event.key === "+" || event.key === "=") zoomTo(view.sx * Math.SQRT2, view.sy * Math.SQRT2);
  else if (event.key === "-") zoomTo(view.sx / Math.SQRT2, view.sy / Math.SQRT2);
  else if (event.key === "Enter") {
    const bound = (at, all) => Math.min(Math.max(Math.floor(at), 0), all - 1);
    pickPixel(bound(view.y + height / view.sy / 2, state.profiles), bound(view.x + width / view.sx / 2, state.columns));
  } else return;
  event.preventDefault();
}

let point = null;             // a single pixel out of the whole scan, where the region has it not
async function showValues() {
  const at = pointed || pick;
  if (!state || !at) return;
  const [profile, column] = at;
  const holds = (part) => part && part.turn === turn && profile >= part.profile && profile < part.profile + part.profiles
    && column >= part.column && column < part.column + part.columns;
  const source = [region, point].find(holds);
  const where = `${pointed ? "Under the pointer" : "Picked"}: column ${column}, profile ${profile}, y ${figure(profile * state.step_mm)} mm`;
  if (!source) {
    $("values").textContent = `${where}; rendered so far is another part`;
    if (scan && !scan.stale && !showValues.busy) {
      showValues.busy = true;
      const answer = await ask("region", { ...sampleQuestion({ profile, column, profiles: 1, columns: 1, at_hand: true }), page: `${page}-point` });
      showValues.busy = false;
      if (isBytes(answer)) { point = unpackRegion(answer); showValues(); }
    }
    return;
  }
  const place = (profile - source.profile) * source.columns + column - source.column;
  const [z, bright, deep, grey] = source.maps.map((map) => map[place]);
  const name = (start.classes.find((known) => known.value === source.class[place]) || { name: "?" }).name;
  const object = source.instance[place] ? `, object ${source.instance[place]}` : "";
  const parts = [
    `Range ${Number.isNaN(z) ? "missing" : `${z.toFixed(3)} ${state.range_unit}`}`, `Reflectance ${figure(bright, 6)} DN`,
    `Scatter ${figure(deep, 6)} DN (less dark ${figure(Math.max(deep - less(2), 0), 6)})`,
    grey === undefined ? null : `grey ${Number.isNaN(grey) ? "unseen" : `${figure(grey, 6)} DN`}`, `class ${name}${object}`,
  ];
  $("values").textContent = `${where}. ${parts.filter(Boolean).join(", ")}.`;
}

// ---- Sensor frame, cross-section, histogram ----

async function askExposure() {
  if (!state || !pick) return;
  const question = sampleQuestion({ profile: pick[0], look });
  const answer = await ask("exposure", question);
  if (question.turn !== turn || !isBytes(answer)) return;
  const length = new DataView(answer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(answer, 4, length)));
  let at = 4 + length;
  const floats = () => { const map = new Float32Array(answer, at, head.columns); at += 4 * head.columns; return map; };
  exposure = { ...head, line: floats(), x: floats(), z: floats(), dn: new Uint16Array(answer.slice(at)) };
  drawExposure();
}
const ink = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
function prepare(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const box = canvas.getBoundingClientRect();
  canvas.width = Math.max(1, Math.round(box.width * ratio));
  canvas.height = Math.max(1, Math.round(box.height * ratio));
  const context = canvas.getContext("2d");
  context.font = `${11 * ratio}px system-ui, sans-serif`;
  return [context, canvas.width, canvas.height, ratio];
}
function drawExposure() {
  if (!exposure) return;
  const { columns, rows: frameRows, first_row: first, max_dn: most, dn, line, x, z } = exposure;
  $("frame-title").textContent =
    `Sensor frame of profile ${exposure.profile}, y ${figure(exposure.y_mm)} mm: square root of DN, rows ${first} to ${first + frameRows - 1}`;
  const [context, width, height, ratio] = prepare($("frame"));
  const picture = make("canvas", { width: columns, height: frameRows });
  const own = picture.getContext("2d");
  const image = own.createImageData(columns, frameRows);
  for (let at = 0; at < dn.length; at += 1) {
    const level = Math.floor(255 * Math.sqrt(dn[at] / most));
    image.data[4 * at] = level; image.data[4 * at + 1] = level; image.data[4 * at + 2] = level; image.data[4 * at + 3] = 255;
  }
  own.putImageData(image, 0, 0);
  context.imageSmoothingEnabled = width < columns;
  context.drawImage(picture, 0, 0, width, height);
  if ($("line").checked) {
    context.strokeStyle = "rgb(255, 120, 60)";
    context.lineWidth = ratio;
    trace(context, line, (column) => (column + 0.5) * width / columns, (row) => (row + 0.5 - first) * height / frameRows);
  }
  drawSection(x, z);
}
/// A line through what is known; breaks where something is missing.
function trace(context, values, placeX, placeY) {
  context.beginPath();
  let isOpen = false;
  values.forEach((value, at) => {
    if (Number.isNaN(value)) { isOpen = false; return; }
    if (isOpen) context.lineTo(placeX(at), placeY(value)); else context.moveTo(placeX(at), placeY(value));
    isOpen = true;
  });
  context.stroke();
}
function drawSection(x, z) {
  const [context, width, height, ratio] = prepare($("section"));
  const known = Array.from(z.keys()).filter((at) => !Number.isNaN(z[at]) && !Number.isNaN(x[at]));
  if (!known.length) { $("section-title").textContent = "Cross-section: no line is found"; return; }
  let [left, right, low, high] = [Infinity, -Infinity, Infinity, -Infinity];
  for (const at of known) {
    left = Math.min(left, x[at]); right = Math.max(right, x[at]); low = Math.min(low, z[at]); high = Math.max(high, z[at]);
  }
  if (high - low < 0.2) { const middle = (high + low) / 2; low = middle - 0.1; high = middle + 0.1; }
  const pad = 16 * ratio;
  const placeX = (at) => pad / 2 + (x[at] - left) / Math.max(right - left, 1e-6) * (width - pad);
  const placeY = (value) => height - pad - (value - low) / (high - low) * (height - 2 * pad);
  context.strokeStyle = ink("--accent");
  context.lineWidth = 1.2 * ratio;
  trace(context, z, placeX, placeY);
  context.fillStyle = ink("--dim");
  context.textAlign = "left";
  context.fillText(`${figure(high)} mm`, 4 * ratio, 12 * ratio);
  context.fillText(`${figure(low)} mm`, 4 * ratio, height - 16 * ratio);
  context.fillText(`x ${figure(left)} mm`, 4 * ratio, height - 4 * ratio);
  context.textAlign = "right";
  context.fillText(`${figure(right)} mm`, width - 4 * ratio, height - 4 * ratio);
  $("section-title").textContent = `Cross-section: z over x, ${figure(low)} to ${figure(high)} mm`;
}
function drawHistogram() {
  if (!region || !scales.length) return;
  const number = Math.min(Number($("histogram-of").value || 1), region.maps.length - 1);
  const [context, width, height, ratio] = prepare($("histogram"));
  const dark = less(number);
  let [low, high] = [Infinity, -Infinity];
  for (const value of region.maps[number]) if (!Number.isNaN(value)) { low = Math.min(low, value - dark); high = Math.max(high, value - dark); }
  if (low > high) return;
  if (high - low < 1e-6) high = low + 1;
  const bins = new Float64Array(96);
  for (const value of region.maps[number]) {
    if (!Number.isNaN(value)) bins[Math.min(bins.length - 1, Math.floor((value - dark - low) / (high - low) * bins.length))] += 1;
  }
  const most = Math.max(...bins);
  context.fillStyle = ink("--accent");
  const foot = 16 * ratio;
  bins.forEach((count, at) => {
    const tall = Math.sqrt(count / most) * (height - foot - 4 * ratio);
    context.fillRect(at * width / bins.length, height - foot - tall, Math.max(1, width / bins.length - ratio), tall);
  });
  context.fillStyle = ink("--dim");
  context.textAlign = "left";
  context.fillText(`${figure(low)} ${unitOf(number)}`, 4 * ratio, height - 4 * ratio);
  context.textAlign = "center";
  context.fillText("square root of pixels in view", width / 2, height - 4 * ratio);
  context.textAlign = "right";
  context.fillText(figure(high), width - 4 * ratio, height - 4 * ratio);
}

// ---- Strip ----

async function fillStrip(isOld) {
  const first = Math.floor(index / STRIP) * STRIP;
  const key = JSON.stringify([text, seed, first]);
  if (stripOf === key) { markStrip(); return; }
  const items = Array.from({ length: STRIP }, (_, place) => stripItem(first + place));
  $("strip").replaceChildren(...items.map(({ item }) => item));
  markStrip();
  for (const { number, fill } of items) {
    const answer = await ask("look", { ...sampleQuestion(), index: number });
    if (isOld()) return;
    if (answer.pictures) fill(answer);
  }
  stripOf = key;
}
function stripItem(number) {
  const image = make("img", { alt: "" });
  const words = make("span", { textContent: `${number}` });
  const button = make("button", { type: "button" }, image, words);
  button.addEventListener("click", () => goTo(number));
  const item = make("li", {}, button);
  const fill = (answer) => {
    item.pictures = answer.pictures;
    image.src = answer.pictures[Number($("strip-of").value)];
    words.textContent = `${number} ${answer.class}`;
  };
  item.number = number;
  return { number, item, fill };
}
function markStrip() {
  for (const item of $("strip").children) item.firstChild.setAttribute("aria-current", String(item.number === index));
}

// ---- Knobs ----

const FORMS = {
  fixed: { name: "number", of: (v) => [v], write: ([v]) => `${v}` },
  uniform: { name: "uniform", of: (v, a, b) => [a, b], labels: ["from", "to"], write: ([a, b]) => `{uniform: [${a}, ${b}]}` },
  log_uniform: { name: "log-uniform", of: (v, a, b) => [a, b], labels: ["from", "to"], write: ([a, b]) => `{log_uniform: [${a}, ${b}]}` },
  normal: { name: "normal", of: (v, a, b) => [v, rounded((b - a) / 4)], labels: ["mean", "sd"], write: ([a, b]) => `{normal: {mean: ${a}, sd: ${b}}}` },
  lognormal: { name: "lognormal", of: (v) => [v, 0.1], labels: ["median", "log sd"], write: ([a, b]) => `{lognormal: {median: ${a}, log_sd: ${b}}}` },
  text: { name: "as YAML" },
};
const rounded = (value) => Number(value.toPrecision(4));

/// The form of a value, with its arguments and where it mostly lies.
function formOf(value) {
  if (typeof value === "number") return { form: "fixed", numbers: [value], ends: [value, value] };
  if (value && value.uniform) return { form: "uniform", numbers: value.uniform, ends: value.uniform };
  if (value && value.log_uniform) return { form: "log_uniform", numbers: value.log_uniform, ends: value.log_uniform };
  if (value && value.normal) {
    const { mean, sd } = value.normal;
    return { form: "normal", numbers: [mean, sd], ends: [mean - 2 * sd, mean + 2 * sd] };
  }
  if (value && value.lognormal) {
    const { median, log_sd: sd } = value.lognormal;
    return { form: "lognormal", numbers: [median, sd], ends: [median * Math.exp(-2 * sd), median * Math.exp(2 * sd)] };
  }
  if (value && value.truncated) return { form: "text", numbers: [], ends: [value.truncated.min, value.truncated.max] };
  if (value && value.choice) return { form: "text", numbers: [], ends: [Math.min(...value.choice.values), Math.max(...value.choice.values)] };
  return { form: "text", numbers: [], ends: null };
}
/// A value as YAML in one line.
function flow(value) {
  if (Array.isArray(value)) return `[${value.map(flow).join(", ")}]`;
  if (value && typeof value === "object") return `{${Object.entries(value).map(([key, inner]) => `${key}: ${flow(inner)}`).join(", ")}}`;
  return typeof value === "string" && !/^[A-Za-z][A-Za-z0-9_./-]*$/.test(value) ? JSON.stringify(value) : String(value);
}

/// Places on a slider: even, or even in the logarithm where a range is wide and above 0.
function scaleOf({ min, max, integer }) {
  const isLog = min > 0 && max / min > 200;
  const place = (value) => {
    const bounded = Math.min(Math.max(value, min), max);
    return isLog ? Math.log(bounded / min) / Math.log(max / min) : (bounded - min) / (max - min || 1);
  };
  const value = (at) => {
    const raw = isLog ? min * (max / min) ** at : min + at * (max - min);
    const near = integer ? Math.round(raw) : rounded(raw);
    return Math.min(Math.max(near, min), max);
  };
  return { place, value };
}

async function buildKeys() {
  const subject = state ? state.subject : start.subject;
  if (buildKeys.subject === subject) return;
  buildKeys.subject = subject;
  sections = await ask("declarations", subject);
  rows.clear();
  $("sections").replaceChildren(...sections.map((section, number) => {
    const body = make("div");
    const count = make("span", { className: "dim" });
    const summary = make("summary", {}, section.path, " ", count);
    const details = make("details", { open: number === 2 }, summary, make("p", { className: "doc", textContent: section.doc }), body);
    details.dataset.path = section.path;
    Object.assign(section, { details, body, count, built: false });
    details.addEventListener("toggle", () => { if (details.open) { buildSection(section); showKeys(); } });
    if (details.open) buildSection(section);
    return details;
  }));
  filter();
}
function buildSection(section) {
  if (section.built) return;
  section.built = true;
  section.body.replaceChildren(...section.keys.map((key) => {
    const row = keyRow(key);
    rows.set(key.path, row);
    return row.element;
  }));
}

function keyRow(key) {
  const id = `key-${key.path.replace(/\W/g, "-")}`;
  const info = make("button", { type: "button", textContent: "?" });
  info.setAttribute("aria-label", `What ${key.path} means`);
  info.setAttribute("aria-expanded", "false");
  const reset = make("button", { type: "button", textContent: "take out", hidden: true });
  reset.setAttribute("aria-label", `take out ${key.path}`);
  const drawn = make("span", { className: "drawn" });
  const name = make("span", { className: "name", id, textContent: key.name });
  const top = make("div", { className: "top" }, name, make("span", { className: "unit", textContent: key.unit }), drawn, reset, info);
  const numbers = make("div", { className: "numbers" });
  const reason = make("p", { className: "reason", id: `${id}-reason`, hidden: true });
  const fault = make("p", { className: "fault", id: `${id}-fault`, hidden: true });
  fault.setAttribute("role", "alert");
  const more = make("div", { className: "more", hidden: true }, ...meaning(key));
  const element = make("div", { className: "key" }, top, numbers, reason, fault, more);
  element.dataset.path = key.path;
  element.setAttribute("role", "group");
  element.setAttribute("aria-labelledby", id);
  const row = { key, element, numbers, reason, fault, drawn, reset, shape: null };
  info.addEventListener("click", () => {
    more.hidden = !more.hidden;
    info.setAttribute("aria-expanded", String(!more.hidden));
  });
  reset.addEventListener("click", () => edit(scopedKey(key), null));
  return row;
}
function meaning(key) {
  const rest = [];
  const tell = (term, words) => { if (words) rest.push(make("dt", { textContent: term }), make("dd", { textContent: words })); };
  const unit = key.unit ? ` ${key.unit}` : "";
  if (key.kind === "parameter") {
    tell("range", `${figure(key.min, 6)} to ${figure(key.max, 6)}${unit}${key.integer ? ", whole numbers" : ""}`);
    tell("by nature", key.natural ? `${figure(key.natural.ends[0])} to ${figure(key.natural.ends[1])}${unit}: ${flow(key.natural.value)}` : "fixed");
    tell("default", `${figure(key.default, 6)}${unit}`);
  } else {
    tell("allowed", key.allowed);
    tell("default", flow(key.default));
  }
  tell("source", key.source);
  return [make("p", { textContent: key.doc }), make("dl", {}, ...rest)];
}
const keyPath = (key) => key.replace(/^classes\.[a-z0-9_]+\./, "");
const scopedKey = (key) => ($("scope").value ? `classes.${$("scope").value}.${key.path}` : key.path);

/// Shows in a row what its key is; controls are made anew only where their kind has changed.
function showRow(row) {
  const { key } = row;
  const own = state.states[key.path] || {};
  const isFixed = $("scope").value && key.kind === "setting";
  const reason = isFixed ? "is the same for all classes" : own.reason;
  const isWritten = written.has(scopedKey(key));
  row.element.classList.toggle("written", isWritten);
  row.element.classList.toggle("idle", Boolean(reason));
  row.reason.textContent = reason || "";
  row.reason.hidden = !reason;
  row.reset.hidden = !isWritten;
  const drawn = state.draws[key.path];
  const isDrawn = drawn !== undefined && typeof own.value !== "number";
  row.drawn.textContent = isDrawn ? `here ${figure(drawn)}` : "";
  if (own.value === undefined || own.value === null) { row.numbers.replaceChildren(); row.shape = null; return; }
  const show = key.kind === "parameter" ? showParameter : showSetting;
  show(row, own.value, (value) => edit(scopedKey(key), value));
  for (const control of row.numbers.querySelectorAll("input, select")) {
    control.disabled = Boolean(reason);
    control.setAttribute("aria-describedby", `${row.reason.id} ${row.fault.id}`);
  }
}

/// A number with its slider.
function numberControl(label, range, write) {
  const scale = scaleOf(range);
  const number = make("input", { type: "number", step: range.integer ? 1 : "any" });
  number.setAttribute("aria-label", label);
  const slider = range.min === undefined ? null : make("input", { type: "range", min: 0, max: 1, step: 0.001 });
  if (slider) {
    slider.setAttribute("aria-label", `${label}, slider`);
    slider.addEventListener("input", () => { number.value = scale.value(Number(slider.value)); write(Number(number.value)); });
  }
  number.addEventListener("change", () => { if (number.value !== "") write(Number(number.value)); });
  const show = (value) => {
    // Whoever types is left alone.
    if (document.activeElement !== number) number.value = value;
    if (slider && document.activeElement !== slider) slider.value = scale.place(value);
    if (slider) slider.setAttribute("aria-valuetext", `${value} ${range.unit || ""}`.trim());
  };
  return { number, slider, show };
}

function showParameter(row, value, write) {
  const { key } = row;
  const known = formOf(value);
  const { numbers, ends } = known;
  const form = row.isText ? "text" : known.form;
  const shape = `${form} ${$("scope").value}`;
  if (row.shape !== shape) {
    row.shape = shape;
    row.current = numbers;
    const select = make("select", {}, ...Object.entries(FORMS).filter(([name]) => name !== "log_uniform" && name !== "lognormal" || key.max > 0)
      .map(([name, { name: words }]) => make("option", { value: name, textContent: words })));
    select.value = form;
    select.setAttribute("aria-label", `Distribution of ${key.path}`);
    select.addEventListener("change", () => changeForm(row, select.value, write));
    const controls = [];
    const parts = [select];
    if (form === "text") {
      const field = make("input", { type: "text", spellcheck: false });
      field.setAttribute("aria-label", `${key.path} as YAML`);
      field.addEventListener("change", () => write(field.value));
      field.style.gridColumn = "1 / -1";
      parts.push(field);
      controls.push({ show: (own) => { if (document.activeElement !== field) field.value = flow(own); } });
    } else {
      const labels = FORMS[form].labels || [""];
      numbers.forEach((_, place) => {
        const isSpread = place === 1 && (form === "normal" || form === "lognormal");
        const range = isSpread
          ? (form === "normal" ? { min: 0, max: (key.max - key.min) / 4 } : { min: 0, max: 1 })
          : { min: key.min, max: key.max, integer: key.integer, unit: key.unit };
        const control = numberControl(`${key.path} ${labels[place]}`.trim(), range, (number) => {
          row.current[place] = number;
          write(FORMS[form].write(row.current));
        });
        controls.push(control);
        parts.push(labels[place] ? make("label", {}, labels[place], control.number) : control.number);
      });
      parts.push(...controls.map(({ slider }) => slider));
    }
    row.controls = controls;
    row.numbers.replaceChildren(...parts);
    row.spread = make("div", { className: "spread" });
    row.spread.setAttribute("aria-hidden", "true");
    row.numbers.append(row.spread);
    row.spread.style.gridColumn = "1 / -1";
    for (const { slider } of controls) if (slider) slider.style.gridColumn = "1 / -1";
  }
  row.current = [...numbers];
  row.controls.forEach((control, place) => control.show(form === "text" ? value : numbers[place]));
  showSpread(row, ends);
}
/// Where the value lies in its range, and what is natural.
function showSpread({ key, spread }, ends) {
  const { place } = scaleOf(key);
  const bar = (className, [low, high]) => {
    const part = make("span", { className });
    part.style.left = `${100 * place(low)}%`;
    part.style.right = `${100 - 100 * place(high)}%`;
    return part;
  };
  spread.replaceChildren(...[
    key.natural ? bar("natural", key.natural.ends) : null, ends ? bar("own", ends) : null,
  ].filter(Boolean));
}
function changeForm(row, form, write) {
  const { key } = row;
  const own = formOf(state.states[key.path].value);
  row.isText = form === "text";
  if (row.isText) { showRow(row); return; }
  const drawn = state.draws[key.path];
  const middle = own.form === "fixed" ? own.numbers[0] : (drawn === undefined ? key.default : drawn);
  const inside = (value) => rounded(Math.min(Math.max(value, key.min), key.max));
  let [low, high] = own.ends && own.ends[1] > own.ends[0] ? own.ends : key.natural ? key.natural.ends : [middle * 0.9, middle * 1.1];
  if (low > high) [low, high] = [high, low];
  if (low === high) [low, high] = [middle, middle + (key.max - key.min) / 20];
  if (form === "log_uniform" && low <= 0) low = Math.max(high / 10, 1e-6);
  write(FORMS[form].write(FORMS[form].of(inside(middle), inside(low), inside(high)).map(key.integer ? Math.round : rounded)));
}

function showSetting(row, value, write) {
  const { key } = row;
  const { schema } = key;
  if (!row.shape) {
    row.shape = "setting";
    if (schema.enum) {
      const select = make("select", {}, ...schema.enum.map((word) => make("option", { value: flow(word), textContent: word })));
      select.setAttribute("aria-label", key.path);
      select.addEventListener("change", () => write(select.value));
      row.numbers.replaceChildren(select);
      row.show = (own) => { select.value = flow(own); };
    } else if (schema.type === "boolean") {
      const box = make("input", { type: "checkbox" });
      box.addEventListener("change", () => write(String(box.checked)));
      row.numbers.replaceChildren(make("label", {}, box, key.name));
      row.show = (own) => { box.checked = own; };
    } else if (schema.type === "integer" || schema.type === "number") {
      const range = { min: schema.minimum, max: schema.maximum, integer: schema.type === "integer", unit: key.unit };
      const control = numberControl(key.path, range, (number) => write(String(number)));
      row.numbers.replaceChildren(...[control.number, control.slider].filter(Boolean));
      if (control.slider) control.slider.style.gridColumn = "1 / -1";
      row.show = control.show;
    } else {
      const field = make("input", { type: "text", spellcheck: false });
      field.setAttribute("aria-label", `${key.path} as YAML`);
      field.addEventListener("change", () => write(field.value));
      row.numbers.replaceChildren(field);
      row.show = (own) => { if (document.activeElement !== field) field.value = flow(own); };
    }
  }
  row.show(value);
}

function showKeys() {
  if (!state) return;
  // What is at fault stays as it was given.
  const faulty = new Set(faults.map(({ key }) => keyPath(key)));
  for (const [path, row] of rows) if (!faulty.has(path) || !row.shape) showRow(row);
  for (const section of sections) {
    const count = section.keys.filter((key) => written.has(scopedKey(key))).length;
    section.count.textContent = count ? `${count} written` : "";
  }
}
function filter() {
  const words = $("find").value.trim().toLowerCase();
  const onlyWritten = $("only-written").checked;
  for (const section of sections) {
    if (words || onlyWritten) buildSection(section);
    let shown = 0;
    for (const key of section.keys) {
      const row = rows.get(key.path);
      const is = (!words || `${key.path} ${key.doc}`.toLowerCase().includes(words)) && (!onlyWritten || written.has(scopedKey(key)));
      if (row) row.element.hidden = !is;
      if (is) shown += 1;
    }
    section.details.hidden = shown === 0;
    if (words || onlyWritten) section.details.open = shown > 0;
  }
  showKeys();
}

// ---- Faults, rig, recipe ----

function showFaults() {
  for (const { element, fault } of rows.values()) {
    element.classList.remove("faulty");
    fault.hidden = true;
    fault.textContent = "";
  }
  const elsewhere = [];
  for (const { key, problem, remedy } of faults) {
    const path = keyPath(key);
    let row = rows.get(path);
    const section = sections.find((known) => known.keys.some((own) => own.path === path));
    if (!row && section) { buildSection(section); showKeys(); row = rows.get(path); }
    if (row) {
      section.details.open = true;
      row.element.classList.add("faulty");
      row.fault.hidden = false;
      row.fault.textContent += `${row.fault.textContent ? " " : ""}${problem}${remedy ? `; ${remedy}` : ""}.`;
    } else elsewhere.push(`${key ? `${key} ` : ""}${problem}${remedy ? `; ${remedy}` : ""}.`);
  }
  $("other-faults").hidden = elsewhere.length === 0;
  $("other-faults").textContent = elsewhere.join(" ");
  $("faults").replaceChildren(...faults.map(({ key, line, origin, problem, remedy }) => {
    const jump = make("button", { type: "button", textContent: `line ${line}` });
    jump.addEventListener("click", () => goToLine(line));
    return make("li", {}, line && !origin ? jump : origin || "", ` ${key} ${problem}${remedy ? `; ${remedy}` : ""}`);
  }));
  if (faults.length) said(`${faults.length === 1 ? "a fault" : `${faults.length} faults`}: the sample is that of the last recipe without one`);
  document.body.classList.toggle("faulty", faults.length > 0);
}
function goToLine(line) {
  const field = $("text");
  const lines = field.value.split("\n");
  const from = lines.slice(0, line - 1).reduce((sum, own) => sum + own.length + 1, 0);
  field.focus();
  field.setSelectionRange(from, from + (lines[line - 1] || "").length);
  field.scrollTop = Math.max(0, (line - 4) * 18);
}
function showRig({ numbers, warnings }) {
  $("warnings").replaceChildren(...[...warnings, ...state.notes].map((words) => make("li", { textContent: words })));
  $("rig-numbers").tBodies[0].replaceChildren(...numbers.map(({ name, doc, value }) => {
    const head = make("th", { scope: "row", title: doc }, name, make("small", { textContent: doc }));
    return make("tr", {}, head, make("td", { textContent: figure(value) }));
  }));
}
function showSample() {
  document.title = `gen tune: ${state.name}`;
  $("recipe-name").textContent = state.name;
  $("sample-facts").textContent =
    `${state.class}, ${state.split}; ${state.columns} columns x ${state.profiles} profiles, every ${figure(state.step_mm)} mm`;
  const names = state.classes.map((known) => known.name);
  options($("of-class"), ["", ...names], (name) => name || "(any)");
  $("of-class").value = "";
  options($("scope"), ["", ...names], (name) => (name ? `class ${name}` : "all classes"));
  markStrip();
}
function options(select, values, words) {
  if (select.dataset.values === values.join()) return;
  const chosen = select.value;
  select.dataset.values = values.join();
  select.replaceChildren(...values.map((value) => make("option", { value, textContent: words(value) })));
  select.value = values.includes(chosen) ? chosen : "";
}
function showCommand() {
  const name = start.file || $("save-name").value || "mine.yaml";
  const stem = name.replace(/\.yaml$/, "");
  $("command").textContent = `gen --recipe ${name} --n ${$("samples").value || 1000} --seed ${seed} --out out/${stem}`;
}
async function save(name, replace = false) {
  const answer = await ask("save", { text, name, replace });
  const where = $("saved");
  where.classList.toggle("bad", answer.fault !== undefined);
  if (answer.saved) { where.textContent = `Saved as ${answer.saved}.`; showCommand(); return; }
  where.textContent = `${answer.fault}. `;
  if (answer.status === 409) {
    const button = make("button", { type: "button", textContent: "Replace it" });
    button.addEventListener("click", () => save(name, true));
    where.append(button);
  }
}
async function savePicture() {
  said("rendering the picture of gen preview", true);
  const answer = await ask("picture", sampleQuestion());
  if (!isBytes(answer)) return;
  const url = URL.createObjectURL(new Blob([answer], { type: "image/png" }));
  make("a", { href: url, download: `${state.name}-${index}.png` }).click();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
  said("the picture is among the downloads");
}

// ---- Everything together ----

function goTo(number) {
  const wanted = Math.min(Math.max(Math.floor(number) || 0, 0), Number.MAX_SAFE_INTEGER);
  refresh({ index: wanted });
}
function listen() {
  $("index").addEventListener("change", () => goTo(Number($("index").value)));
  $("index-less").addEventListener("click", () => goTo(index - 1));
  $("index-more").addEventListener("click", () => goTo(index + 1));
  $("seed").addEventListener("change", () => {
    seed = Math.min(Math.max(Math.floor(Number($("seed").value)) || 0, 0), Number.MAX_SAFE_INTEGER);
    $("seed").value = seed;
    refresh();
  });
  $("of-class").addEventListener("change", () => {
    if ($("of-class").value) refresh({ index: index + 1, of_class: $("of-class").value });
  });
  $("scope").addEventListener("change", () => refresh());
  $("find").addEventListener("input", filter);
  $("only-written").addEventListener("change", filter);
  $("fit").addEventListener("click", () => { fit(); moved(); });
  $("true-pixels").addEventListener("click", () => zoomTo(1, 1));
  $("zoom-in").addEventListener("click", () => zoomTo(view.sx * Math.SQRT2, view.sy * Math.SQRT2));
  $("zoom-out").addEventListener("click", () => zoomTo(view.sx / Math.SQRT2, view.sy / Math.SQRT2));
  $("labels").addEventListener("change", draw);
  $("line").addEventListener("change", drawExposure);
  $("hold").addEventListener("change", () => {
    if (!$("hold").checked && scan && !scan.stale) { setScales(scan.maps); panels.forEach(showScale); paintRegion(); draw(); }
  });
  $("histogram-of").addEventListener("change", drawHistogram);
  $("strip-of").addEventListener("change", () => {
    for (const item of $("strip").children) {
      if (item.pictures) item.querySelector("img").src = item.pictures[Number($("strip-of").value)];
    }
  });
  $("maps").addEventListener("keydown", onMapKey);
  $("explain").addEventListener("change", () => $("rig-numbers").classList.toggle("explained", $("explain").checked));
  let typing = null;
  $("text").addEventListener("input", () => {
    clearTimeout(typing);
    typing = setTimeout(() => {
      if ($("text").value === text) return;
      history.push(text);
      $("undo").disabled = false;
      text = $("text").value;
      refresh();
    }, 250);
  });
  $("undo").addEventListener("click", () => {
    if (!history.length) return;
    text = history.pop();
    $("text").value = text;
    $("undo").disabled = !history.length;
    refresh();
  });
  $("save").addEventListener("click", () => save(null));
  $("save-as").addEventListener("click", () => save($("save-name").value));
  $("save-name").addEventListener("input", showCommand);
  $("samples").addEventListener("input", showCommand);
  $("picture").addEventListener("click", savePicture);
  $("copy").addEventListener("click", async () => {
    await navigator.clipboard.writeText($("command").textContent);
    said("the command is on the clipboard");
  });
  new ResizeObserver(() => size()).observe($("maps"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { drawExposure(); drawHistogram(); });
}

async function begin() {
  start = await ask("start", {});
  ({ text, seed, index } = start);
  $("text").value = text;
  $("seed").value = seed;
  $("index").value = index;
  $("save").hidden = start.file === null;
  $("save-name").value = start.file === null ? "mine.yaml" : "";
  showMaps();
  listen();
  await goOnFrom();
}
async function goOnFrom() {
  take(await ask("state", { text, seed, index, class: null }), null);
  await buildKeys();
  showKeys();
  showFaults();
}

begin().catch((error) => said(`the page cannot begin: ${error.message}`));
