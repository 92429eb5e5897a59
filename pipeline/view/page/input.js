// Mouse, keys and the panel.

let drag = null;
const touches = new Map(); // places of the pointers that are down

function within(event) {
  const box = $("frame").getBoundingClientRect();
  return [event.clientX - box.left, event.clientY - box.top];
}

$("frame").addEventListener("pointerdown", (event) => {
  if (!camera) return;
  touches.set(event.pointerId, [event.clientX, event.clientY]);
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
  if (touches.size === 2 && touches.has(event.pointerId)) { pinch(event); return; }
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

// Two fingers: nearer and farther by their distance.
function pinch(event) {
  const apart = () => { const [a, b] = [...touches.values()]; return Math.max(1, length(sub(a, b))); };
  const before = apart();
  touches.set(event.pointerId, [event.clientX, event.clientY]);
  drag = null;
  dolly(clamp(before / apart(), 0.5, 2));
}

for (const end of ["pointerup", "pointercancel"]) {
  $("frame").addEventListener(end, (event) => {
    touches.delete(event.pointerId);
    drag = null;
    $("frame").classList.remove("busy");
  });
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
  exposure = value === null ? null : inHundredths(value);
  $("auto").checked = value === null;
  if (value !== null) $("exposure").value = exposure;
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
$("blend").onchange = ask;
$("refine").onchange = ask;
$("fov").oninput = () => { camera.fov = Number($("fov").value); change(); };
$("home").onclick = () => { home(); $("fov").value = camera.fov; ask(); };
$("help-button").onclick = () => $("help").showModal();
$("trace").onclick = () => trace();
$("hide-truth").onclick = () => { hideTruth(); ask(); };
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
new ResizeObserver(() => ask()).observe($("picture"));

function tellCommand() {
  const [w, h] = facts ? facts.size : size();
  const rays = facts && facts.aa > 1 ? ` --aa ${facts.aa}` : "";
  const list = (values) => values.map(short32).join(",");
  const quoted = /^[\w./-]+$/.test(start.run) ? start.run : `'${start.run.replaceAll("'", "'\\''")}'`;
  const words = [`rrf render ${quoted} -o view.exr -o view.png`];
  if (isTyped()) {
    const { eye, target, up, mirror } = cameraWords();
    words.push(`--eye=${list(eye)} --look-at=${list(target)} --up=${list(up)}`);
    if (mirror) words.push("--mirror");
  }
  words.push(`--fov ${short32(camera.fov)} --size ${w}x${h}${rays}`);
  for (const l of solo ? [] : lights) words.push(`--light=${list([...l.position, ...scale(l.colour, l.watts)])}`);
  words.push(...ownWords(list));
  if (facts?.noise && facts.noise !== Math.fround(FINE) && isSampled()) words.push(`--noise ${short32(facts.noise)}`);
  if (mode === "direct" || mode === "indirect") words.push(`--part ${mode}`);
  if ($("blend").checked) words.push("--blend");
  words.push(`--exposure=${(shownExposure ?? 0).toFixed(2)}`);
  $("command").textContent = words.join(" \\\n  ");
  $("degrees").textContent = `${camera.fov.toFixed(1)}\u00b0`;
}
