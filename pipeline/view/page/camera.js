"use strict";
// The state of the page: vectors, the camera, and where a point of the world is in the picture.

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
// The shortest number that a float of 32 bits is written as: the page asks by the numbers that it prints.
const short32 = (x) => {
  const wanted = Math.fround(x);
  for (let digits = 1; digits < 9; digits++) {
    const shorter = Number(x.toPrecision(digits));
    if (Math.fround(shorter) === wanted) return shorter;
  }
  return Number(x.toPrecision(9));
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
let shownExposure = null; // of the last frame
let moved = false; // the camera is no longer the scene's own

// ---- the camera

// Whether the view is other than the scene's own.
const isTyped = () => moved || start.view_is_typed;

function axes() {
  if (!isTyped()) return start;
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

// Size of a moving picture, or that of the window.
function size(whole) {
  const box = $("picture").getBoundingClientRect();
  const shorter = (!whole && Number($("size").value)) || Math.min(box.width, box.height) * devicePixelRatio;
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
