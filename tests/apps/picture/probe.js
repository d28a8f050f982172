// SPDX-License-Identifier: BSD-3-Clause
// Probes of a page of `mapjoin plot` from within, for the tests; what they find is JSON in an element of its own.
"use strict";

/// A number that tells one picture from another; 0 if nothing is drawn.
function fingerprint() {
  viewer.view.drawNow();
  const gl = viewer.view.renderer.getContext();
  const pixels = new Uint8Array(4 * gl.drawingBufferWidth * gl.drawingBufferHeight);
  gl.readPixels(0, 0, gl.drawingBufferWidth, gl.drawingBufferHeight, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  let sum = 0;
  for (let k = 0; k < pixels.length; ++k) sum = (sum + pixels[k] * ((k % 9973) + 1)) % 2 ** 48;
  return sum;
}

/// The name and colour of each layer, whether its switch changes the picture, and whether switching back restores it.
function switchLayers() {
  return Array.from(document.querySelectorAll("#layers label"), (label) => {
    const before = fingerprint();
    label.querySelector("input").click();
    const without = fingerprint();
    label.querySelector("input").click();
    const colour = label.querySelector(".swatch").style.getPropertyValue("--paint");
    return { colour, name: label.querySelector(".name").textContent, changes: without !== before, comesBack: fingerprint() === before };
  });
}

/// The text of the tip over a place in the frame of the map (m); null if none is shown.
function tipOver(...place) {
  const at = {};
  const { centre } = viewer.scene;
  viewer.view.projector()(
    [0, 1, 2].map((i) => (place[i] || 0) - (centre[i] || 0)),
    0,
    at,
  );
  viewer.view.canvas.dispatchEvent(new PointerEvent("pointermove", { clientX: at.x, clientY: at.y, bubbles: true }));
  const tip = document.getElementById("tip");
  return tip.hidden ? null : tip.innerText;
}

/// The result of searching for an id: the words below the field, the tip, and how far the ring around the pose is from the
/// middle of what the panel leaves free (pixels).
function find(id) {
  document.getElementById("find-id").value = id;
  document.getElementById("find").requestSubmit();
  const at = {};
  if (viewer.ring) viewer.view.projector()(viewer.ring.geometry.attributes.position.array, 0, at);
  const tip = document.getElementById("tip");
  return {
    text: document.getElementById("find-text").textContent,
    tip: tip.hidden ? null : tip.innerText,
    isRinged: Boolean(viewer.ring),
    fromMiddle: Math.hypot(at.x - (innerWidth + document.getElementById("panel").offsetWidth + 12) / 2, at.y - innerHeight / 2),
  };
}

const layerNamed = (name) => viewer.layers.find((layer) => layer.name === name);
const pointsOf = (layer) => Array.from(layer.object.geometry.attributes.position.array);

/// The place of a pose on the page (pixels).
function pixelsOf(pose) {
  const at = {};
  viewer.view.projector()(viewer.scene.maps[0].poses, pose, at);
  return [at.x, at.y];
}

/// The places of a pose before and after the wheel is turned over it, and the ratio of the zooms.
function zoomOver(pose) {
  const before = pixelsOf(pose);
  const { zoom } = viewer.view.camera;
  const where = { clientX: before[0], clientY: before[1], bubbles: true, cancelable: true };
  viewer.view.canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -100, ...where }));
  return { before, after: pixelsOf(pose), share: viewer.view.camera.zoom / zoom };
}

/// The places of a pose before and after the pointer is dragged.
function drag(pose, dx, dy) {
  const before = pixelsOf(pose);
  const { canvas } = viewer.view;
  const send = (target, name, x, y) =>
    target.dispatchEvent(new MouseEvent(name, { clientX: x, clientY: y, button: 0, bubbles: true }));
  send(canvas, "mousedown", 400, 300);
  send(document, "mousemove", 400 + dx, 300 + dy);
  send(document, "mouseup", 400 + dx, 300 + dy);
  return { before, after: pixelsOf(pose) };
}

/// The places of a pose before and after a key is pressed on the map, which is reached by Tab; the ratio of the zooms.
function press(pose, init) {
  const { canvas, camera } = viewer.view;
  const before = pixelsOf(pose);
  const { zoom } = camera;
  canvas.focus();
  document.activeElement.dispatchEvent(new KeyboardEvent("keydown", { bubbles: true, cancelable: true, ...init }));
  return { before, after: pixelsOf(pose), share: camera.zoom / zoom };
}

const median = (values) => values.slice().sort((a, b) => a - b)[values.length >> 1];

/// The time of a frame (ms) and its numbers of items at rest, and in motion after twenty frames that took 200 ms; and whether
/// the picture is the same again afterwards.
function moveAndRest() {
  const { view } = viewer;
  const before = fingerprint();
  const gl = view.renderer.getContext();
  const frame = () => {
    const begin = performance.now();
    view.drawNow();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4)); // waits for it
    return performance.now() - begin;
  };
  const seen = () => {
    const ms = median(Array.from({ length: 5 }, frame));
    const { points, lines } = view.renderer.info.render;
    return { ms, points, lines };
  };
  const atRest = seen();
  view.move();
  for (let k = 0; k < 20; ++k) view.adapt(200);
  const inMotion = seen();
  view.stand();
  return { atRest, inMotion, comesBack: fingerprint() === before };
}

/// The words of the panel on the local map of this number, typed in as by a user, and the picture.
function pickLocalMap(number) {
  const field = document.getElementById("local-map-number");
  field.value = number;
  field.dispatchEvent(new Event("change"));
  return { text: document.getElementById("local-map-figures").innerText.split("\n"), picture: fingerprint() };
}

/// The words at a stop of the slider, and the picture.
function slideTo(stop) {
  const slider = document.getElementById("stop");
  slider.value = stop;
  slider.dispatchEvent(new Event("input"));
  return { text: document.getElementById("stop-text").textContent, picture: fingerprint() };
}

/// Calls `probe` and leaves what it returns, with what went wrong on the page, in an element for the test to read.
function report(probe) {
  const found = { errors: window.problems };
  try {
    Object.assign(found, probe());
  } catch (error) {
    found.errors.push(String(error.stack));
  }
  const out = document.createElement("pre");
  out.id = "found";
  out.textContent = `[[[${JSON.stringify(found)}]]]`;
  document.body.append(out);
}
