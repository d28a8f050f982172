// SPDX-License-Identifier: BSD-3-Clause
// The pose or feature under the pointer, and the tip that describes it.
"use strict";

const kReach = 12; // pixels

/// The nearest pose or feature within reach among the layers that are shown, or null. Features go before poses that are as near
/// and, in 3D, what is in front before what is behind.
function nearest(view, layers, x, y) {
  const project = view.projector();
  const at = {};
  let best = null;
  const seen = new Set();
  for (const layer of layers) {
    if (!layer.tells || !layer.object || !layer.object.visible) continue;
    const places = layer.tells === "poses" ? layer.map.poses : layer.map.features;
    if (seen.has(places)) continue;
    seen.add(places);
    for (let k = 0; k < places.length / 3; ++k) {
      project(places, k, at);
      const dx = at.x - x;
      const dy = at.y - y;
      const square = dx * dx + dy * dy;
      if (square > kReach * kReach) continue;
      const cost = Math.sqrt(square) - (layer.tells === "features" ? 2 : 0) + (view.dimension === 3 ? 4 * at.depth : 0);
      if (!best || cost < best.cost) best = { cost, kind: layer.tells, map: layer.map, index: k };
    }
  }
  return best;
}

const kPoseNames = { 2: ["x", "y", "φ"], 3: ["x", "y", "z", "rx", "ry", "rz"] };

const metres = (value) => `${value.toFixed(Math.abs(value) < 10 ? 4 : 3)} m`;
const degrees = (radians) => `${((radians * 180) / Math.PI).toPrecision(3)}°`;

function placeInWords(scene, found) {
  const places = found.kind === "poses" ? found.map.poses : found.map.features;
  const names = ["x", "y", "z"].slice(0, scene.dimension);
  const words = names.map((name, i) => `${name} ${metres(places[3 * found.index + i] + scene.centre[i])}`);
  if (found.kind === "poses" && scene.dimension === 2) words.push(`φ ${degrees(found.map.headings[found.index])}`);
  return words.join(", ");
}

/// The covariance of a pose or feature that was found; null if it is unknown.
function covarianceOf(scene, found) {
  const isPose = found.kind === "poses";
  const packed = isPose ? found.map.poseCovariances : found.map.featureCovariances;
  const size = isPose ? kPoseNames[scene.dimension].length : scene.dimension;
  return packed.length > 0 ? covarianceAt(packed, found.index, size) : null;
}

function element(name, text, className) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  if (className) made.className = className;
  return made;
}

function deviationsInWords(P, names, dimension) {
  return names
    .map((name, i) => {
      const deviation = Math.sqrt(Math.max(P[i][i], 0));
      return `σ${name} ${i < dimension ? `${deviation.toPrecision(3)} m` : degrees(deviation)}`;
    })
    .join(", ");
}

function covarianceTable(P, names) {
  const table = element("table");
  const head = table.createTHead().insertRow();
  head.append(element("th"), ...names.map((name) => element("th", name)));
  const body = table.createTBody();
  P.forEach((row, i) => {
    const line = body.insertRow();
    line.append(element("th", names[i]), ...row.map((entry) => element("td", entry === 0 ? "0" : entry.toExponential(2))));
  });
  return table;
}

/// Fills the tip with the name, the place, the local map and the covariance of a pose or feature; local maps of the map
/// `pickable` can be picked.
function tell(scene, localMapOf, pickable, found, tip) {
  const { map, kind, index } = found;
  const isPose = kind === "poses";
  const lines = [element("strong", isPose ? poseName(map, index) : featureName(map, index))];
  if (scene.maps.length > 1) lines.push(element("div", map.name, "quiet"));
  lines.push(element("div", placeInWords(scene, found)));
  const localMap = isPose ? localMapOf.get(map)[index] : -1;
  const picking = map === pickable ? ", click to pick it" : "";
  if (localMap >= 0) lines.push(element("div", `local map ${localMap + 1}${picking}`, "quiet"));
  const P = covarianceOf(scene, found);
  if (P) {
    const names = isPose ? kPoseNames[scene.dimension] : ["x", "y", "z"].slice(0, scene.dimension);
    lines.push(
      element("div", deviationsInWords(P, names, scene.dimension)),
      element("div", "covariance (m, rad)", "quiet"),
      covarianceTable(P, names),
    );
  }
  tip.replaceChildren(...lines);
}

/// Shows the tip beside the pointer, within the page.
function placeTip(tip, x, y) {
  tip.hidden = false;
  const { width, height } = tip.getBoundingClientRect();
  tip.style.left = `${Math.max(8, x + 16 + width > window.innerWidth ? x - width - 16 : x + 16)}px`;
  tip.style.top = `${Math.max(8, Math.min(y + 16, window.innerHeight - height - 8))}px`;
}
