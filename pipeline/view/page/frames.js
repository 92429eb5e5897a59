// Questions to the server and the frames that answer them: at most one question waits for its frame;
// when it comes, the newest state is asked about.

let socket = null;
let asked = 0; // number of the question that waits, 0: none
let again = false; // something changed since
let number = 0;
let facts = null; // of the frame whose bytes come next
let picks = new Map();

// Bounds on the noise of direct light, as shares of white: while something moves, and at rest as `rrf render`'s.
const [COARSE, FINE] = [0.05, 0.01];
const MOVING = { whole: false, aa: 1, noise: COARSE };
let detail = MOVING; // of the question that waits

function question(of = MOVING) {
  // a picture at rest keeps the exposure of the one that moved
  const stops = exposure ?? (shownExposure === null ? null : inHundredths(shownExposure));
  return {
    id: ++number,
    ...(isTyped() ? { camera: cameraWords() } : {}),
    fov: short32(camera.fov),
    size: size(of.whole),
    aa: of.aa,
    blend: $("blend").checked,
    lights: (solo ? [] : lights).map((l) => [...l.position, ...scale(l.colour, l.watts)].map(short32)),
    ...ownQuestion(),
    mode,
    exposure: of === MOVING ? exposure : stops,
    noise: stops === null ? null : { share: of.noise, exposure: stops },
  };
}

// The camera as `rrf render` takes it.
function cameraWords() {
  const { eye, forward, up, mirror } = camera;
  const [from, target, above] = [eye, add(eye, forward), up].map((v) => v.map(short32));
  return { eye: from, target, up: above, mirror: mirror < 0 };
}

const inHundredths = (x) => Number(x.toFixed(2));

// Asks for the view as it is now; the server drops a picture at rest that it is still working on.
function ask() {
  if (!camera) return;
  clearTimeout(resting);
  drawHandles();
  tellCommand();
  const busy = asked && detail === MOVING;
  if (busy || !socket || socket.readyState !== WebSocket.OPEN || document.hidden) {
    again = true;
    return;
  }
  again = false;
  send(MOVING);
}

function send(of) {
  const q = question(of);
  asked = q.id;
  detail = of;
  if (of === MOVING) {
    // the rate is that of a movement: a pause begins another
    if (performance.now() - times.at(-1) > PAUSE) times = [];
    const stale = shot && (sight(q) !== sight(shot) || (!tracing && q.exposure !== shot.exposure));
    if (stale) (tracing ? retrace : hideTruth)();
  }
  socket.send(JSON.stringify(q));
}

function answered() {
  asked = 0;
  if (again) ask();
  else rest();
}

// ---- at rest: the window's size, more and more camera rays a pixel

const PAUSE = 250; // ms without a question that make a picture rest
let longest = 8000; // ms that a picture at rest may take
const MOST_RAYS = 4; // along a side of a pixel
let resting = 0; // timer
let cost = 0; // ms a camera ray, of the last moving frame

// Asks for the next finer picture of a view that does not change.
function rest() {
  const next = finer();
  if (next) resting = setTimeout(() => send(next), detail === MOVING ? PAUSE : 0);
  else resting = setTimeout(tellRest, PAUSE);
}

function finer() {
  const covered = tracing || !$("traced").hidden;
  if (!$("refine").checked || covered || !facts || document.hidden) return null;
  const [width, height] = size(true);
  const time = (aa) => cost * width * height * aa * aa;
  for (let aa = detail === MOVING ? 1 : detail.aa + 1; aa <= MOST_RAYS; aa++) {
    const worth = aa === MOST_RAYS || time(aa) > 2 * PAUSE || time(aa + 1) > longest;
    if (worth && time(aa) <= longest) return { whole: true, aa, noise: FINE };
  }
  return null;
}

function connect() {
  socket = new WebSocket(socketUrl("/frames"));
  socket.binaryType = "arraybuffer";
  socket.onmessage = ({ data }) => {
    if (typeof data !== "string") {
      if (facts.id !== asked) return; // the view has changed since
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
      if (message.id && message.id !== asked) return;
      warnings([message.error]);
      answered();
    } else if (message.dropped) {
      if (message.id === asked) answered();
    } else facts = message;
  };
  socket.onclose = () => { $("gone").hidden = false; };
}

function begin(hello) {
  start = hello;
  $("run").textContent = `${hello.run}: ${hello.cells} cells, ${hello.triangles} triangles`;
  document.title = `${hello.run} - rrf view`;
  lights = hello.lights.map((l) => {
    const watts = Math.max(...l.slice(3)) || 1;
    return { position: l.slice(0, 3), colour: scale(l.slice(3), 1 / watts), watts };
  });
  $("fov").value = hello.fov;
  $("blend-line").hidden = !hello.blends;
  beginOwn(hello);
  listLights();
  home();
}

function show(canvas, [width, height], bytes) {
  if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
  const image = new ImageData(new Uint8ClampedArray(bytes), width, height);
  canvas.getContext("2d").putImageData(image, 0, 0);
}

let times = []; // when the frames of a movement were shown

function told(f) {
  if (detail === MOVING) {
    const now = performance.now();
    times.push(now);
    while (times.length > 4 && now - times[0] > 2000) times.shift();
    // what lights cost once is not paid again for a view at rest
    const all = f.thread_ms.reduce((sum, [, ms]) => sum + ms, 0);
    const once = f.thread_ms.find(([stage]) => stage === "coefficients");
    cost = (f.frame_ms * (1 - (once ? once[1] : 0) / Math.max(all, 1e-9))) / (f.size[0] * f.size[1]);
    const rate = ((times.length - 1) * 1000) / (now - times[0]);
    $("speed").textContent = `${times.length > 3 ? `${rate.toFixed(rate < 9.5 ? 1 : 0)} fps, ` : ""}${f.frame_ms.toFixed(1)} ms, ${pixels(f)}`;
  } else tellRest();
  document.body.dataset.rays = f.aa * f.aa;
  $("speed").title = "Threads' time of the last frame\n" + Object.entries(Object.fromEntries(f.thread_ms))
    .map(([stage, ms]) => `${stage.replaceAll("_", " ")}: ${ms.toFixed(1)} ms`).join("\n");
  shownExposure = f.exposure;
  if (exposure === null) $("exposure").value = f.exposure;
  const stops = inHundredths(f.exposure);
  $("stops").textContent = `${stops < 0 ? "\u2212" : "+"}${Math.abs(stops).toFixed(2)}`;
  warnings(f.warnings);
  tellCommand();
}

const pixels = (f) => `${f.size[0]}\u00d7${f.size[1]}`;

function tellRest() {
  const rays = facts.aa * facts.aa;
  $("speed").textContent = `at rest, ${pixels(facts)}, ${rays} camera ray${rays > 1 ? "s" : ""} a pixel`;
}

function warnings(lines) {
  const told = [...$("warnings").children].map((line) => line.textContent);
  if (told.join("\n") === lines.join("\n")) return;
  $("warnings").replaceChildren(...lines.map((line) => Object.assign(document.createElement("li"), { textContent: line })));
}
