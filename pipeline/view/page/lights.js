// Point lights: their list, and the handles of all lights in the picture.

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
  $("remove").disabled = !light;
  for (const line of document.querySelectorAll(".of-light")) line.hidden = !light;
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
  const canvas = $("handles");
  const box = canvas.getBoundingClientRect();
  const ratio = devicePixelRatio;
  canvas.width = Math.max(1, box.width * ratio);
  canvas.height = Math.max(1, box.height * ratio);
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
    draw.strokeStyle = k === chosen ? "#ffb65c" : "#000c";
    draw.stroke();
    const outside = light.position.some((c, i) => c < start.light_box[0][i] || c > start.light_box[1][i]);
    if (k < 0) {
      label(draw, light.name, x, y, "#fff");
    } else if (outside) {
      label(draw, "outside the baked box", x, y, "#ffb65c");
    }
  });
}

// Words beside a handle, with a dark edge: any picture may lie under them.
function label(draw, words, x, y, colour) {
  draw.font = "bold 13px system-ui, sans-serif";
  draw.lineJoin = "round";
  draw.lineWidth = 4;
  draw.strokeStyle = "#000c";
  draw.strokeText(words, x + 12, y + 4);
  draw.fillStyle = colour;
  draw.fillText(words, x + 12, y + 4);
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
