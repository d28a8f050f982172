// SPDX-License-Identifier: BSD-3-Clause
// The panel at the side: layers to switch, a local map to pick, a pose to find, and the joining of map after map.
"use strict";

function swatch(layer) {
  const made = element("span", undefined, `swatch ${layer.kind}`);
  const colours = Array.isArray(layer.colour) ? layer.colour : [layer.colour];
  made.style.setProperty("--paint", colours.length === 1 ? colours[0] : `linear-gradient(90deg, ${colours.join(", ")})`);
  return made;
}

const counted = (count) => count.toLocaleString("en").replace(/,/g, "\u202f");

/// A chi2 with five significant digits or, from 100 000 on, as a whole number.
const figure = (chi2) => (chi2 < 1e5 ? chi2.toPrecision(5) : counted(Math.round(chi2)));

/// Fills the panel with a switch per layer, below the name of its map if there are several.
function fillLayers(viewer) {
  const list = document.getElementById("layers");
  list.replaceChildren();
  let last = "";
  for (const layer of viewer.layers) {
    if (layer.heading !== last) list.append(element("h3", layer.heading));
    last = layer.heading;
    const label = element("label");
    const box = element("input");
    box.type = "checkbox";
    box.checked = layer.isOn;
    box.addEventListener("change", () => {
      layer.isOn = box.checked;
      viewer.show();
    });
    label.append(box, swatch(layer), element("span", layer.name, "name"));
    if (layer.count > 1) label.append(element("span", counted(layer.count), "count"));
    list.append(label);
  }
}

const kFigures = (maps, map, m) => [
  ["poses", `${keyText(map.poseKeys[maps.base[m]])} to ${keyText(map.poseKeys[maps.end[m]])}`],
  ["features", counted(maps.offsets[m + 1] - maps.offsets[m])],
  ["chi2", figure(maps.chi2[m])],
  ["rows", counted(maps.rows[m])],
  ["p", maps.probability[m] < 1e-3 ? maps.probability[m].toExponential(1) : maps.probability[m].toFixed(3)],
];

/// Fills the panel with the number and the figures of local map m, and a warning if it does not fit; m is -1 if none is picked.
function fillLocalMap(map, m) {
  const figures = document.getElementById("local-map-figures");
  document.getElementById("local-map-number").value = m < 0 ? "" : m + 1;
  figures.replaceChildren();
  document.getElementById("local-map-none").hidden = m >= 0;
  if (m < 0) return;
  for (const [name, value] of kFigures(map.localMaps, map, m)) figures.append(element("dt", name), element("dd", value));
  const isPoor = map.localMaps.probability[m] < 1e-3;
  if (isPoor) figures.append(element("dd", "does not fit the others", "poor"));
}

function wireLocalMaps(viewer) {
  const section = document.getElementById("local-maps");
  const map = viewer.mapWithLocalMaps;
  section.hidden = !map;
  if (!map) return;
  const { count } = map.localMaps;
  const number = document.getElementById("local-map-number");
  number.max = count;
  document.getElementById("local-map-count").textContent = counted(count);
  number.addEventListener("change", () => {
    const m = Math.round(number.valueAsNumber) - 1;
    viewer.pick(m >= 0 && m < count ? m : -1);
  });
  const step = (by) => viewer.pick(viewer.picked < 0 ? (by > 0 ? 0 : count - 1) : (viewer.picked + by + count) % count);
  document.getElementById("local-map-before").addEventListener("click", () => step(-1));
  document.getElementById("local-map-next").addEventListener("click", () => step(1));
  document.getElementById("local-map-clear").addEventListener("click", () => viewer.pick(-1));
  fillLocalMap(map, -1);
}

function wireSearch(viewer) {
  document.getElementById("find").addEventListener("submit", (event) => {
    event.preventDefault();
    const words = document.getElementById("find-id").value.trim();
    const found = poseOfId(viewer.scene, words);
    document.getElementById("find-text").textContent = words && !found ? `There is no pose ${words}.` : "";
    viewer.goToPose(found);
  });
}

function tellStop(viewer) {
  const { stops } = viewer.growing;
  const stop = stops[viewer.stop];
  const isLast = viewer.stop === stops.length - 1;
  document.getElementById("stop-text").textContent = isLast
    ? `all ${counted(stop.maps)} maps: the whole map`
    : `${counted(stop.maps)} of ${counted(stops[stops.length - 1].maps)} maps, chi2 ${figure(stop.chi2)}`;
}

/// Plays the stops, all of them in about ten seconds, or pauses.
function playStops(viewer, button) {
  const last = viewer.growing.stops.length - 1;
  if (viewer.timer) {
    clearInterval(viewer.timer);
    viewer.timer = null;
  } else {
    if (viewer.stop === last) viewer.goTo(0);
    viewer.timer = setInterval(
      () => {
        viewer.goTo(viewer.stop + 1);
        if (viewer.stop === last) playStops(viewer, button);
      },
      Math.max(40, 10000 / (last + 1)),
    );
  }
  button.textContent = viewer.timer ? "Pause" : "Play";
}

function wireStops(viewer) {
  const section = document.getElementById("joining");
  section.hidden = !viewer.growing;
  if (!viewer.growing) return;
  const slider = document.getElementById("stop");
  slider.max = viewer.growing.stops.length - 1;
  slider.value = slider.max;
  slider.addEventListener("input", () => viewer.goTo(Number(slider.value)));
  const button = document.getElementById("play");
  button.addEventListener("click", () => playStops(viewer, button));
  tellStop(viewer);
}
