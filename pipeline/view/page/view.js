"use strict";
// The page's part of `rrf view`: a camera and lights, questions to the server, pictures shown.
// At most one question waits for its frame; when it comes, the newest state is asked about.

const $ = (id) => document.getElementById(id);
const add = (a, b) => a.map((x, i) => x + b[i]);
const sub = (a, b) => a.map((x, i) => x - b[i]);
const scale = (a, s) => a.map((x) => x * s);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.hypot(...a);
const unit = (a) => scale(a, 1 / length(a));
const rotate = (v, axis, angle) => {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return add(add(scale(v, c), scale(cross(axis, v), s)), scale(axis, dot(axis, v) * (1 - c)));
};
const clamp = (x, low, high) => Math.min(high, Math.max(low, x));

const token = new URLSearchParams(location.search).get("token") || "";
const socketUrl = (path) => `ws://${location.host}${path}?token=${encodeURIComponent(token)}`;

let start = null; // what the server said at first
let camera = null; // { eye, forward, pivot, up (the world's), mirror, fov }
let lights = []; // { position, colour (brightest channel 1), watts }
let chosen = 0;
let mode = "full";
let exposure = null; // stops, or null: automatic
let shownExposure = 0;
let moved = false; // the camera is no longer the scene's own

// ---- the camera

function axes() {
  const right = scale(unit(cross(camera.forward, camera.up)), camera.mirror);
  return { right, up: scale(cross(right, camera.forward), camera.mirror), forward: camera.forward };
}

function home() {
  const middle = scale(add(start.bounds[0], start.bounds[1]), 0.5);
  const depth = dot(sub(middle, start.eye), start.forward);
  const size = length(sub(start.bounds[1], start.bounds[0]));
  // the world's up: the axis nearest to the camera's
  const axis = start.up.map(Math.abs).reduce((best, x, i, all) => (x > all[best] ? i : best), 0);
  const up = [0, 0, 0];
  up[axis] = Math.sign(start.up[axis]) || 1;
  camera = {
    eye: start.eye,
    forward: start.forward,
    pivot: add(start.eye, scale(start.forward, depth > 0 ? depth : 0.2 * size)),
    up,
    mirror: Math.sign(dot(cross(start.forward, start.up), start.right)) || 1,
    fov: start.fov,
  };
  if (Math.abs(dot(camera.forward, up)) > 0.999) camera.up = start.up;
  moved = false;
  ask();
}

const polar = (forward) => Math.acos(clamp(dot(forward, camera.up), -1, 1));

// Turns a direction by angles about the world's up and the camera's right, never past the poles.
function turned(v, across, down) {
  const { right } = axes();
  const now = polar(camera.forward);
  const tilt = clamp(now + down, 0.02, Math.PI - 0.02) - now;
  return rotate(rotate(v, right, -tilt * camera.mirror), camera.up, -across * camera.mirror);
}

function orbit(dx, dy) {
  const arm = sub(camera.eye, camera.pivot);
  const eye = add(camera.pivot, turned(arm, dx, dy));
  camera.forward = unit(turned(camera.forward, dx, dy));
  camera.eye = eye;
  change();
}

function look(dx, dy) {
  const reach = length(sub(camera.pivot, camera.eye));
  camera.forward = unit(turned(camera.forward, dx, dy));
  camera.pivot = add(camera.eye, scale(camera.forward, reach));
  change();
}

function shift(by) {
  camera.eye = add(camera.eye, by);
  camera.pivot = add(camera.pivot, by);
  change();
}

function dolly(factor) {
  const arm = sub(camera.eye, camera.pivot);
  camera.eye = add(camera.pivot, scale(arm, factor));
  change();
}

function change() {
  moved = true;
  ask();
}

// ---- picture and world

function size() {
  const box = $("frame").parentElement.getBoundingClientRect();
  const shorter = Number($("size").value) || Math.min(box.width, box.height) * devicePixelRatio;
  const ratio = box.width / Math.max(1, box.height);
  const wide = ratio > 1 ? [shorter * ratio, shorter] : [shorter, shorter / ratio];
  const least = Math.min(1, 2048 / Math.max(...wide));
  return wide.map((side) => Math.max(16, Math.round(side * least)));
}

// Side of a picture's pixel on the plane at distance 1.
const pixelSide = ([w, h]) => (2 * Math.tan((camera.fov * Math.PI) / 360)) / Math.min(w, h);

// Where a world point is in a picture: pixels from the top left, and depth.
function project(p, picture) {
  const { right, up, forward } = axes();
  const to = sub(p, camera.eye);
  const depth = dot(to, forward);
  const side = pixelSide(picture) * depth;
  return [picture[0] / 2 + dot(to, right) / side, picture[1] / 2 - dot(to, up) / side, depth];
}

// ---- questions and frames

let socket = null;
let asked = 0; // number of the question that waits, 0: none
let again = false; // something changed since
let number = 0;
let facts = null; // of the frame whose bytes come next
let picks = new Map();
const times = [];

function question(width_height) {
  const { right, up, forward } = axes();
  return {
    id: ++number,
    eye: camera.eye, right, up, forward,
    fov: camera.fov,
    size: width_height || size(),
    lights: (solo ? [] : lights).map((l) => [...l.position, ...scale(l.colour, l.watts)]),
    ...ownQuestion(),
    mode, exposure,
  };
}

function ask() {
  if (!camera) return;
  drawHandles();
  tellCommand();
  if (asked || !socket || socket.readyState !== WebSocket.OPEN || document.hidden) {
    again = true;
    return;
  }
  again = false;
  const q = question();
  asked = q.id;
  if (tracing && shot && sight(q) !== sight(shot)) retrace();
  socket.send(JSON.stringify(q));
}

function answered() {
  asked = 0;
  if (again) ask();
}

function connect() {
  socket = new WebSocket(socketUrl("/frames"));
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) => {
    if (typeof data !== "string") {
      show($("frame"), facts.size, data);
      document.body.dataset.frames = Number(document.body.dataset.frames || 0) + 1;
      told(facts);
      drawHandles();
      answered();
      return;
    }
    const message = JSON.parse(data);
    if (message.hello) begin(message.hello);
    else if ("picked" in message) {
      const then = picks.get(message.id);
      picks.delete(message.id);
      if (then && message.picked) then(message.picked);
    } else if (message.error) {
      warnings([message.error]);
      answered();
    } else facts = message;
  };
  socket.onclose = () => { $("gone").hidden = false; };
}

function begin(hello) {
  start = hello;
  $("run").textContent = `${hello.run}: ${hello.cells} nets, ${hello.triangles} triangles`;
  document.title = `${hello.run} - rrf view`;
  lights = hello.lights.map((l) => {
    const watts = Math.max(...l.slice(3)) || 1;
    return { position: l.slice(0, 3), colour: scale(l.slice(3), 1 / watts), watts };
  });
  $("fov").value = hello.fov;
  beginOwn(hello);
  listLights();
  home();
}

function show(canvas, [width, height], bytes) {
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const image = new ImageData(new Uint8ClampedArray(bytes), width, height);
  canvas.getContext("2d").putImageData(image, 0, 0);
  fitCanvas(canvas);
}

// A canvas as large as its frame allows, its pixels square.
function fitCanvas(canvas) {
  const box = canvas.parentElement.getBoundingClientRect();
  const factor = Math.min(box.width / canvas.width, box.height / canvas.height);
  canvas.style.width = `${canvas.width * factor}px`;
  canvas.style.height = `${canvas.height * factor}px`;
}

function told(f) {
  const now = performance.now();
  times.push(now);
  while (times.length > 1 && now - times[0] > 2000) times.shift();
  const rate = times.length > 1 ? ((times.length - 1) * 1000) / (now - times[0]) : 0;
  $("speed").textContent = `${rate.toFixed(0)} fps, ${f.frame_ms.toFixed(1)} ms, ${f.size[0]}\u00d7${f.size[1]}`;
  $("speed").title = Object.entries(Object.fromEntries(f.thread_ms))
    .map(([stage, ms]) => `${stage.replaceAll("_", " ")}: ${ms.toFixed(1)} ms`).join("\n");
  shownExposure = f.exposure;
  if (exposure === null) $("exposure").value = f.exposure;
  $("stops").textContent = `${f.exposure >= 0 ? "+" : "\u2212"}${Math.abs(f.exposure).toFixed(2)}`;
  warnings(f.warnings);
  tellCommand();
}

function warnings(lines) {
  $("warnings").replaceChildren(...lines.map((line) => Object.assign(document.createElement("li"), { textContent: line })));
}

// ---- lights

function css(colour) {
  const byte = (x) => Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
  return "#" + colour.map((x) => byte(clamp(x, 0, 1)).toString(16).padStart(2, "0")).join("");
}

function linear(text) {
  const colour = [1, 3, 5].map((at) => parseInt(text.slice(at, at + 2), 16) / 255)
    .map((x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4));
  const most = Math.max(...colour);
  return most > 0 ? scale(colour, 1 / most) : [0, 0, 0];
}

function listLights() {
  chosen = clamp(chosen, 0, Math.max(0, lights.length - 1));
  $("lights").replaceChildren(...lights.map((light, k) => {
    const item = document.createElement("li");
    const button = document.createElement("button");
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    const dot = document.createElementNS("http://www.w3.org/2000/svg", "circle");
    svg.setAttribute("viewBox", "0 0 12 12");
    for (const [name, value] of [["cx", 6], ["cy", 6], ["r", 5.5], ["fill", css(light.colour)]]) dot.setAttribute(name, value);
    svg.append(dot);
    const text = `${light.position.map((x) => x.toFixed(2)).join(", ")}   ${short(light.watts)} W/sr`;
    button.append(svg, text);
    button.setAttribute("aria-pressed", k === chosen);
    button.onclick = () => { chosen = k; listLights(); drawHandles(); };
    item.append(button);
    return item;
  }));
  const light = lights[chosen];
  for (const id of ["remove", "colour", "power", "watts", "x", "y", "z"]) $(id).disabled = !light;
  $("add").disabled = lights.length >= 64;
  if (!light) return;
  $("colour").value = css(light.colour);
  $("power").value = Math.log2(Math.max(light.watts, 2 ** -8));
  $("watts").value = short(light.watts);
  ["x", "y", "z"].forEach((id, i) => { $(id).value = Number(light.position[i].toFixed(4)); });
}

const short = (x) => Number(x.toPrecision(4));

function addLight() {
  if (lights.length >= 64) return;
  const [low, high] = start.light_box;
  const from = lights[chosen];
  const step = scale(sub(high, low), 0.15);
  const position = from
    ? from.position.map((x, i) => (x + step[i] <= high[i] ? x + step[i] : x - step[i]))
    : scale(add(low, high), 0.5);
  lights.push({ position, colour: from ? from.colour : [1, 1, 1], watts: from ? from.watts : 1 });
  chosen = lights.length - 1;
  lightsChanged();
}

function removeLight() {
  lights.splice(chosen, 1);
  lightsChanged();
}

function lightsChanged() {
  listLights();
  ask();
}

// Lights that can be dragged: the page's own and the scene's that have a place and shine.
function handles() {
  const placed = own.filter((light) => light.position && shines(light));
  return [...(solo ? [] : lights), ...placed];
}

// Handles of the lights over the picture, where it is shown.
function drawHandles() {
  const [canvas, frame] = [$("handles"), $("frame")];
  const box = frame.getBoundingClientRect();
  const ratio = devicePixelRatio;
  canvas.width = Math.max(1, box.width * ratio);
  canvas.height = Math.max(1, box.height * ratio);
  canvas.style.width = `${box.width}px`;
  canvas.style.height = `${box.height}px`;
  const draw = canvas.getContext("2d");
  draw.scale(ratio, ratio);
  handles().forEach((light) => {
    const [x, y, depth] = project(light.position, [box.width, box.height]);
    if (depth <= 0) return;
    const k = lights.indexOf(light);
    draw.beginPath();
    if (k >= 0) draw.arc(x, y, 7, 0, 2 * Math.PI);
    else draw.rect(x - 6, y - 6, 12, 12);
    draw.fillStyle = css(light.colour);
    draw.fill();
    draw.lineWidth = k === chosen ? 3 : 1.5;
    draw.strokeStyle = k === chosen ? "#f0a23a" : "#000a";
    draw.stroke();
    const outside = light.position.some((c, i) => c < start.light_box[0][i] || c > start.light_box[1][i]);
    if (k < 0) {
      draw.fillStyle = "#fffc";
      draw.font = "12px system-ui, sans-serif";
      draw.fillText(light.name, x + 12, y + 4);
    } else if (outside) {
      draw.fillStyle = "#f0a23a";
      draw.font = "bold 13px system-ui, sans-serif";
      draw.fillText("outside the baked box", x + 12, y + 4);
    }
  });
}

function lightAt(x, y) {
  const box = $("frame").getBoundingClientRect();
  let best = null;
  let nearest = 14;
  handles().forEach((light) => {
    const [px, py, depth] = project(light.position, [box.width, box.height]);
    const distance = Math.hypot(px - x, py - y);
    if (depth > 0 && distance < nearest) [best, nearest] = [light, distance];
  });
  return best;
}

function dragLight(light, dx, dy, event) {
  const box = $("frame").getBoundingClientRect();
  const { right, up, forward } = axes();
  const depth = dot(sub(light.position, camera.eye), forward);
  const side = pixelSide([box.width, box.height]) * depth;
  let by = add(scale(right, dx * side), scale(up, -dy * side));
  if (event.shiftKey) by = scale(camera.up, -dy * side);
  else if (event.altKey) by = scale(forward, -dy * side);
  light.position = add(light.position, by);
  lightsChanged();
}

// ---- mouse and keys

let drag = null;

function within(event) {
  const box = $("frame").getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
}

$("frame").addEventListener("pointerdown", (event) => {
  if (!camera) return;
  $("frame").focus();
  $("frame").setPointerCapture(event.pointerId);
  const light = event.button === 0 ? lightAt(...within(event)) : null;
  const what = light ? "light" : event.button === 2 ? "look" : event.button === 1 || event.ctrlKey ? "pan" : "orbit";
  if (lights.includes(light)) { chosen = lights.indexOf(light); listLights(); drawHandles(); }
  drag = { what, light, x: event.clientX, y: event.clientY };
  $("frame").classList.add("busy");
  event.preventDefault();
});

$("frame").addEventListener("pointermove", (event) => {
  if (!drag) {
    $("frame").classList.toggle("over", camera !== null && lightAt(...within(event)) !== null);
    return;
  }
  const [dx, dy] = [event.clientX - drag.x, event.clientY - drag.y];
  if (!dx && !dy) return;
  [drag.x, drag.y] = [event.clientX, event.clientY];
  const box = $("frame").getBoundingClientRect();
  if (drag.what === "light") dragLight(drag.light, dx, dy, event);
  else if (drag.what === "orbit") orbit(0.008 * dx, 0.008 * dy);
  else if (drag.what === "look") {
    const angle = pixelSide([box.width, box.height]);
    look(-dx * angle, -dy * angle);
  } else {
    const { right, up } = axes();
    const side = pixelSide([box.width, box.height]) * length(sub(camera.pivot, camera.eye));
    shift(add(scale(right, -dx * side), scale(up, dy * side)));
  }
});

for (const end of ["pointerup", "pointercancel"]) {
  $("frame").addEventListener(end, () => { drag = null; $("frame").classList.remove("busy"); });
}
$("frame").addEventListener("contextmenu", (event) => event.preventDefault());
$("frame").addEventListener("wheel", (event) => {
  event.preventDefault();
  if (camera) dolly(Math.exp(clamp(event.deltaY, -200, 200) * 0.001));
}, { passive: false });
$("frame").addEventListener("dblclick", (event) => {
  const box = $("frame").getBoundingClientRect();
  const [x, y] = within(event);
  const q = question();
  q.pick = [(x / box.width) * q.size[0], (y / box.height) * q.size[1]];
  picks.set(q.id, (point) => {
    const reach = dot(sub(point, camera.eye), camera.forward);
    camera.pivot = point;
    if (reach > 0) { camera.forward = unit(sub(point, camera.eye)); change(); }
  });
  socket.send(JSON.stringify(q));
});

const held = new Set();
let flying = 0;

function fly(now) {
  if (!held.size) { flying = 0; return; }
  const seconds = flying ? Math.min(0.1, (now - flying) / 1000) : 0;
  flying = now;
  const { right, forward } = axes();
  const speed = 0.12 * length(sub(start.bounds[1], start.bounds[0])) * (held.has("shift") ? 4 : 1);
  const along = (plus, minus) => Number(held.has(plus)) - Number(held.has(minus));
  const way = add(add(scale(forward, along("w", "s")), scale(right, along("d", "a"))), scale(camera.up, along("e", "q")));
  if (length(way) > 0 && seconds > 0) shift(scale(unit(way), speed * seconds));
  requestAnimationFrame(fly);
}

function setMode(value) {
  mode = value;
  document.querySelector(`input[name=mode][value=${value}]`).checked = true;
  ask();
}

function setExposure(value) {
  exposure = value;
  $("auto").checked = value === null;
  if (value !== null) $("exposure").value = value;
  ask();
}

const keys = {
  1: () => setMode("full"), 2: () => setMode("direct"), 3: () => setMode("indirect"),
  4: () => setMode("cells"), 5: () => setMode("trust"),
  l: addLight, delete: removeLight, backspace: removeLight, home,
  t: () => trace(), x: () => { $("difference").click(); },
  "+": () => setExposure(shownExposure + 0.25), "=": () => setExposure(shownExposure + 0.25),
  "-": () => setExposure(shownExposure - 0.25), 0: () => setExposure(null),
  "?": () => $("help").showModal(),
};

addEventListener("keydown", (event) => {
  const typing = event.target.matches("input[type=number], input[type=color], input[type=date], select");
  if (!camera || typing || event.ctrlKey || event.metaKey || event.altKey || $("help").open) return;
  const key = event.key.toLowerCase();
  if ("wasdqe".includes(key) || key === "shift") {
    held.add(key);
    if (!flying && key !== "shift") { flying = performance.now(); requestAnimationFrame(fly); }
    return;
  }
  if (keys[key]) { keys[key](); event.preventDefault(); }
});
addEventListener("keyup", (event) => held.delete(event.key.toLowerCase()));
addEventListener("blur", () => held.clear());
document.addEventListener("visibilitychange", () => { if (!document.hidden && again) ask(); });

// ---- the panel

document.querySelectorAll("input[name=mode]").forEach((input) => { input.onchange = () => setMode(input.value); });
$("add").onclick = addLight;
$("remove").onclick = removeLight;
$("colour").oninput = () => { lights[chosen].colour = linear($("colour").value); lightsChanged(); };
$("power").oninput = () => { lights[chosen].watts = 2 ** Number($("power").value); lightsChanged(); };
$("watts").onchange = () => {
  const watts = Number($("watts").value);
  if (watts >= 0 && Number.isFinite(watts)) { lights[chosen].watts = watts; lightsChanged(); }
};
["x", "y", "z"].forEach((id, i) => {
  $(id).onchange = () => {
    const value = Number($(id).value);
    if (Number.isFinite(value)) lights[chosen].position = lights[chosen].position.with(i, value);
    lightsChanged();
  };
});
$("exposure").oninput = () => setExposure(Number($("exposure").value));
$("auto").onchange = () => setExposure($("auto").checked ? null : shownExposure);
$("size").onchange = ask;
$("fov").oninput = () => { camera.fov = Number($("fov").value); change(); };
$("home").onclick = () => { home(); $("fov").value = camera.fov; ask(); };
$("help-button").onclick = () => $("help").showModal();
$("trace").onclick = () => trace();
$("difference").onchange = () => {
  if ($("difference").checked && !tracing) trace();
  else showTraced();
};
$("copy").onclick = async () => {
  try {
    await navigator.clipboard.writeText($("command").textContent);
    $("copy").textContent = "Copied";
  } catch {
    getSelection().selectAllChildren($("command"));
    $("copy").textContent = "Selected: press Ctrl-C";
  }
  setTimeout(() => { $("copy").textContent = "Copy"; }, 1500);
};
new ResizeObserver(() => {
  for (const id of ["frame", "traced"]) fitCanvas($(id));
  ask();
}).observe($("frame").parentElement);

function tellCommand() {
  const [w, h] = facts ? facts.size : size();
  const list = (values) => values.map((x) => Number(x.toPrecision(7))).join(",");
  const quoted = /^[\w./-]+$/.test(start.run) ? start.run : `'${start.run.replaceAll("'", "'\\''")}'`;
  const words = [`rrf render ${quoted} -o view.exr -o view.png`];
  if (moved) {
    words.push(`--eye=${list(camera.eye)} --look-at=${list(add(camera.eye, camera.forward))} --up=${list(camera.up)}`);
    if (camera.mirror < 0) words.push("--mirror");
  }
  words.push(`--fov ${Number(camera.fov.toPrecision(6))} --size ${w}x${h}`);
  for (const l of solo ? [] : lights) words.push(`--light=${list([...l.position, ...scale(l.colour, l.watts)])}`);
  words.push(...ownWords(list));
  if (mode === "direct" || mode === "indirect") words.push(`--part ${mode}`);
  words.push(`--exposure=${shownExposure.toFixed(2)}`);
  $("command").textContent = words.join(" \\\n  ");
  $("degrees").textContent = `${camera.fov.toFixed(1)}\u00b0`;
}

// ---- path tracing beside the live picture

let tracing = null; // the socket
let shot = null; // the question that is traced
let later = 0; // timer
let tracedFacts = null;
let pictures = []; // traced, difference
const measured = { relative_error: "relative error", rel_mse: "relMSE", delta_e_2000: "\u0394E2000", flip: "FLIP" };

// A question without what is only shown.
const sight = (q) => JSON.stringify({ ...q, id: 0, exposure: null });

// The view has changed: trace the new one, once it stands still.
function retrace() {
  clearTimeout(later);
  later = setTimeout(() => { if (tracing) { stopTracing(); trace(); } }, 400);
}

function stopTracing() {
  clearTimeout(later);
  if (tracing) { tracing.onclose = null; tracing.close(); }
  tracing = null;
  $("trace").textContent = "Path-trace this view";
}

function trace() {
  if (tracing) { stopTracing(); return; }
  $("truth").hidden = false;
  $("measures").hidden = true;
  $("trace").textContent = "Stop tracing";
  $("trace-state").textContent = "tracing the first paths";
  pictures = [];
  const own = new WebSocket(socketUrl("/trace"));
  tracing = own;
  own.binaryType = "arraybuffer";
  let next = [];
  shot = null;
  own.onopen = () => {
    // the view as it is once the second picture has taken its place
    requestAnimationFrame(() => { shot = question(); ask(); own.send(JSON.stringify({ begin: shot })); });
  };
  own.onmessage = ({ data }) => {
    if (own !== tracing) return;
    if (typeof data === "string") {
      const message = JSON.parse(data);
      if (message.error) { $("trace-state").textContent = message.error; stopTracing(); return; }
      tracedFacts = message;
      next = [];
      return;
    }
    next.push(data);
    if (next.length < 2) return;
    pictures = next;
    showTraced();
    tellMeasures(tracedFacts);
    document.body.dataset.paths = tracedFacts.paths;
    if (tracedFacts.paths < 4096) own.send('"next"');
    else stopTracing();
  };
  own.onclose = () => { if (own === tracing) stopTracing(); };
}

function showTraced() {
  if (pictures.length < 2) return;
  const difference = $("difference").checked;
  show($("traced"), tracedFacts.size, pictures[difference ? 1 : 0]);
  const full = (100 * tracedFacts.full_difference).toFixed(0);
  $("truth-caption").textContent = difference
    ? `nets minus traced, luminance: red too bright, blue too dark, full colour at ${full} %`
    : `path traced, ${tracedFacts.paths} paths a pixel`;
}

function tellMeasures(f) {
  $("trace-state").textContent =
    `${f.paths} paths a pixel in ${f.seconds.toFixed(1)} s; the traced picture's own noise: ${(100 * f.relative_noise).toFixed(1)} %`;
  if (!f.measures) return;
  $("measures").hidden = false;
  const rows = f.measures.filter((m) => m.name in measured).map((m) => {
    const row = document.createElement("tr");
    const cells = [measured[m.name], Number(m.value.toPrecision(3))];
    row.append(...cells.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
    row.title = m.definition;
    return row;
  });
  $("measures").tBodies[0].replaceChildren(...rows);
}

