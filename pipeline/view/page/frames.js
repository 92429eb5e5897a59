// Questions to the server and the frames that answer them: at most one question waits for its frame;
// when it comes, the newest state is asked about.

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
