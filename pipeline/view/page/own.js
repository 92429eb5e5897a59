// The scene's own lights, a row each, and suns with their dial.

let own = []; // { name, kind, strength, unit, position, toward, shows; on, colour, factor, home }
let suns = []; // { toward: [azimuth, elevation], colour (brightest channel 1), watts, on }
let solo = null; // the only light that shines, if any
let sun = null; // the light of own or suns that the dial turns

const isSun = (light) => Boolean(light.toward);
const shines = (light) => (solo ? solo === light : light.on);
// Whether shadow rays have to choose among places of a light.
const isSampled = () => suns.some(shines) || own.some((light) => shines(light) && light.kind !== "point");
const same = (a, b) => a === b || (a && b && a.every((x, i) => x === b[i]));

function beginOwn(hello) {
  own = hello.own.map((light) => ({
    ...light, on: hello.own_on, colour: [1, 1, 1], factor: 1,
    home: { position: light.position, toward: light.toward },
  }));
  suns = hello.suns.map(([azimuth, elevation, ...irradiance]) => {
    const watts = Math.max(...irradiance) || 1;
    return { toward: [azimuth, elevation], colour: scale(irradiance, 1 / watts), watts, on: true };
  });
  sun = suns[0] || own.find(isSun) || null;
  listOwn();
}

// What a question says of them.
function ownQuestion() {
  return {
    suns: suns.filter(shines).map((s) => [...s.toward, ...scale(s.colour, s.watts)].map(short32)),
    own: own.filter(shines).map((light) => ({
      name: light.name,
      dim: scale(light.colour, light.factor).map(short32),
      ...(same(light.position, light.home.position) ? {} : { position: light.position.map(short32) }),
      ...(same(light.toward, light.home.toward) ? {} : { toward: light.toward.map(short32) }),
    })),
  };
}

function element(tag, props = {}, ...children) {
  const made = Object.assign(document.createElement(tag), props);
  made.append(...children);
  return made;
}

// Strength of a row as the file has it: its brightest channel.
const peak = (light) => Math.max(...light.strength) || 1;

function ownRow(light, title, typed) {
  const changed = () => { ask(); };
  const onOff = element("input", { type: "checkbox", checked: light.on, title: "On or off" });
  onOff.onchange = () => { light.on = onOff.checked; listOwn(); changed(); };
  const alone = element("button", { textContent: "solo", title: "Only this light shines" });
  alone.setAttribute("aria-pressed", solo === light);
  alone.onclick = () => { solo = solo === light ? null : light; listOwn(); changed(); };
  const head = element("div", { className: "line" }, element("label", {}, onOff, " ", title), alone);
  if (typed) {
    const away = element("button", { textContent: "×", title: "Remove this sun" });
    away.onclick = () => {
      suns = suns.filter((s) => s !== light);
      if (solo === light) solo = null;
      if (sun === light) sun = suns[0] || own.find(isSun) || null;
      listOwn();
      changed();
    };
    head.append(away);
  }
  const colour = element("input", { type: "color", value: css(light.colour), title: "Colour, times the light's own" });
  colour.oninput = () => { light.colour = linear(colour.value); changed(); };
  const unitless = () => (typed ? light.watts : light.factor * peak(light));
  const set = (value) => {
    if (typed) light.watts = value;
    else light.factor = value / peak(light);
  };
  const start = unitless();
  const range = element("input", { type: "range", min: -6, max: 6, step: 0.05, value: 0, title: "Intensity" });
  const number = element("input", { type: "number", min: 0, step: "any", value: short(start), title: "Intensity, the brightest channel" });
  range.oninput = () => { set(start * 2 ** Number(range.value)); number.value = short(unitless()); changed(); };
  number.onchange = () => {
    const value = Number(number.value);
    if (value >= 0 && Number.isFinite(value)) { set(value); changed(); }
  };
  const body = element("div", { className: "line" }, colour, range, number, element("span", { className: "quiet", textContent: typed ? "W/m²" : light.unit }));
  const item = element("li", {}, head, body);
  if (light.shows) item.append(element("p", { className: "quiet", textContent: light.shows }));
  item.dataset.name = typed ? "sun" : light.name;
  if (isSun(light)) {
    item.onclick = (event) => {
      if (event.target.closest("input, button")) return;
      sun = light;
      listOwn();
    };
    item.setAttribute("aria-current", sun === light);
  }
  return item;
}

function listOwn() {
  const rows = own.map((light) => ownRow(light, `${light.name} (${light.kind === "distant" ? "sun" : light.kind})`, false));
  const more = suns.map((light, k) => ownRow(light, suns.length > 1 ? `sun ${k + 1}` : "sun", true));
  $("own").replaceChildren(...rows, ...more);
  $("own-none").hidden = rows.length + more.length > 0;
  drawDial();
}

function addSun() {
  const light = { toward: [135, 45], colour: [1, 1, 1], watts: 1, on: true };
  suns.push(light);
  sun = light;
  solo = null;
  listOwn();
  ask();
}

// ---- the dial: the sky from below, zenith in the middle, -z up and +x to the right

const RADIUS = 60;

function drawDial() {
  $("dial-box").hidden = !sun;
  if (!sun) return;
  const [azimuth, elevation] = sun.toward;
  const turn = (azimuth * Math.PI) / 180;
  const far = (RADIUS * (90 - clamp(elevation, 0, 90))) / 90;
  const [x, y] = [far * Math.sin(turn), -far * Math.cos(turn)];
  for (const [key, value] of [["cx", x], ["cy", y]]) $("dial-sun").setAttribute(key, value);
  for (const [key, value] of [["x2", x], ["y2", y]]) $("dial-hand").setAttribute(key, value);
  $("dial-sun").setAttribute("fill", elevation < 0 ? "#adb2ba" : "#f0a23a");
  $("azimuth").value = Number(azimuth.toFixed(2));
  $("elevation").value = Number(elevation.toFixed(2));
}

function turnSun(azimuth, elevation) {
  if (!sun || !Number.isFinite(azimuth) || !Number.isFinite(elevation)) return;
  sun.toward = [((azimuth % 360) + 360) % 360, clamp(elevation, -90, 90)];
  drawDial();
  ask();
}

function dialAt(event) {
  const box = $("dial").getBoundingClientRect();
  const unit = box.width / (2 * (RADIUS + 10));
  const x = (event.clientX - box.left - box.width / 2) / unit;
  const y = (event.clientY - box.top - box.height / 2) / unit;
  const far = Math.min(1, Math.hypot(x, y) / RADIUS);
  turnSun((Math.atan2(x, -y) * 180) / Math.PI, 90 - 90 * far);
}

$("dial").addEventListener("pointerdown", (event) => { $("dial").setPointerCapture(event.pointerId); dialAt(event); });
$("dial").addEventListener("pointermove", (event) => { if (event.buttons) dialAt(event); });
for (const id of ["azimuth", "elevation"]) {
  $(id).onchange = () => turnSun(Number($("azimuth").value), Number($("elevation").value));
}
$("add-sun").onclick = addSun;

// Azimuth (from north, eastwards) and elevation of the sun in degrees, by a day of the year, true solar
// time in hours and latitude in degrees; the declination within 0.3 degrees (Cooper 1969).
function sunAt(day, hour, latitude) {
  const rad = Math.PI / 180;
  const tilt = 23.45 * rad * Math.sin(((284 + day) / 365) * 2 * Math.PI);
  const [angle, place] = [(hour - 12) * 15 * rad, latitude * rad];
  const up = Math.sin(place) * Math.sin(tilt) + Math.cos(place) * Math.cos(tilt) * Math.cos(angle);
  const east = -Math.cos(tilt) * Math.sin(angle);
  const north = Math.cos(place) * Math.sin(tilt) - Math.sin(place) * Math.cos(tilt) * Math.cos(angle);
  return [(Math.atan2(east, north) / rad + 360) % 360, Math.asin(clamp(up, -1, 1)) / rad];
}

function sunByDate() {
  const date = new Date(`${$("date").value}T00:00:00Z`);
  const day = Math.floor((date - Date.UTC(date.getUTCFullYear(), 0, 0)) / 86400000);
  const [hour, latitude] = [Number($("hour").value), Number($("latitude").value)];
  $("clock").textContent = `${Math.floor(hour)}:${String(Math.round((hour % 1) * 60) % 60).padStart(2, "0")}`;
  if (!Number.isFinite(day) || Math.abs(latitude) > 90) return;
  turnSun(...sunAt(day, hour, latitude));
}
for (const id of ["date", "hour", "latitude"]) $(id).oninput = sunByDate;

// ---- the shell's words for them

function ownWords(list) {
  const words = [];
  const shown = own.filter(shines);
  const typed = suns.filter(shines);
  const named = (name) => (/^[\w.-]+$/.test(name) ? name : `'${name.replaceAll("'", "'\\''")}'`);
  const turned = shown.filter((light) => !same(light.toward, light.home.toward));
  for (const s of typed) words.push(`--sun=${list([...s.toward, ...scale(s.colour, s.watts)])}`);
  for (const light of turned) {
    const irradiance = light.strength.map((x, i) => x * light.colour[i] * light.factor);
    words.push(`--sun=${list([...light.toward, ...irradiance])}`);
  }
  if (!own.length) return words;
  if (!shown.length) return [...words, "--own-lights none"];
  words.push("--scene-lights");
  for (const light of own) {
    const dim = shown.includes(light) && !turned.includes(light) ? scale(light.colour, light.factor) : [0, 0, 0];
    if (!same(dim, [1, 1, 1])) words.push(`--dim ${named(light.name)}=${list(dim)}`);
    if (shown.includes(light) && !same(light.position, light.home.position)) {
      words.push(`--move ${named(light.name)}:${list(light.position)}`);
    }
  }
  return words;
}

connect();
