// SPDX-License-Identifier: BSD-3-Clause
// Objects that layers are drawn with: round dots, lines of a width in pixels, thin lines, ellipses.
"use strict";

const kDotVertex = `
  uniform float size;
  void main() {
    gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
    gl_PointSize = size;
  }`;

const kDotFragment = `
  uniform vec3 colour;
  uniform float opacity;
  uniform float size;
  uniform float hole;
  void main() {
    float r = length(gl_PointCoord - 0.5) * size;
    float rim = 0.5 * size;
    float alpha = smoothstep(rim, rim - 1.5, r) * smoothstep(hole * rim - 1.5, hole * rim, r);
    if (alpha < 0.02) discard;
    gl_FragColor = vec4(colour, opacity * alpha);
  }`;

/// True in 3D, where what is nearer lies on top; in 2D what is drawn later does.
let isDeep = false;

function placed(object, order, opacity) {
  object.frustumCulled = false;
  object.renderOrder = order;
  object.userData.opacity = opacity;
  return object;
}

/// Fades an object and all below it to a share of their own opacity.
function fade(object, share) {
  object.traverse(({ material, userData }) => {
    if (!material) return;
    material.opacity = userData.opacity * share;
    if (material.uniforms && material.uniforms.opacity) material.uniforms.opacity.value = material.opacity;
  });
}

/// Draws an object over all others, in 3D too.
function onTop(object) {
  object.traverse(({ material }) => {
    if (material) material.depthTest = false;
  });
  return object;
}

/// Removes an object from the world, and its buffers and materials from the graphics card.
function discard(world, object) {
  world.remove(object);
  object.traverse(({ geometry, material }) => {
    if (geometry) geometry.dispose();
    if (material) material.dispose();
  });
}

const kFew = 4000; // dots or thin segments: an object with no more is drawn whole, however long a frame takes

/// The vertices of all items, in an order any first part of which is spread over the whole: in steps of the golden section.
function spreadVertices({ items, verticesOfOne }) {
  const divisor = (a, b) => (b === 0 ? a : divisor(b, a % b));
  let step = Math.round(0.618 * items);
  while (divisor(items, step) > 1) ++step;
  const vertices = new Uint32Array(verticesOfOne * items);
  for (let k = 0, item = 0; k < vertices.length; item = (item + step) % items) {
    for (let v = 0; v < verticesOfOne; ++v) vertices[k++] = verticesOfOne * item + v;
  }
  return new THREE.BufferAttribute(vertices, 1);
}

/// Draws a share of the dots or thin segments, but at least kFew, of each object that has more; all, in their own order, if the
/// share is 1.
function drawShare(world, share) {
  world.traverse(({ geometry, userData }) => {
    if (!(userData.items > kFew)) return;
    if (share < 1 && !userData.spread) userData.spread = spreadVertices(userData);
    geometry.setIndex(share < 1 ? userData.spread : null);
    geometry.setDrawRange(0, share < 1 ? userData.verticesOfOne * Math.max(kFew, Math.ceil(share * userData.items)) : Infinity);
  });
}

function geometryOf(places) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(places, 3));
  return geometry;
}

/// An estimate of how far places are apart: the diagonal of their box over the root of their number (m).
function spacingOf(places, dimension) {
  const box = new THREE.Box3().setFromArray(places);
  return box.getSize(new THREE.Vector3()).length() / Math.max(1, places.length / 3) ** (1 / dimension);
}

/// Shrinks dots that have a spacing and would hide each other at this zoom, down to a third.
function fitDots(world, zoom) {
  world.traverse(({ userData, material }) => {
    if (!userData.spacing) return;
    const share = Math.min(1, Math.max(0.34, (0.6 * userData.spacing * zoom) / userData.size));
    material.uniforms.size.value = share * userData.size * window.devicePixelRatio;
  });
}

/// Round dots of `size` pixels of the page, or rings with a hole of the share `hole` of that; fitDots() uses `spacing` (m).
function dots(places, { colour, size, order, spacing = 0, opacity = 1, hole = 0 }) {
  const material = new THREE.ShaderMaterial({
    uniforms: {
      colour: { value: new THREE.Color(colour) },
      opacity: { value: opacity },
      size: { value: size * window.devicePixelRatio },
      hole: { value: hole },
    },
    vertexShader: kDotVertex,
    fragmentShader: kDotFragment,
    transparent: true,
    depthTest: isDeep,
    depthWrite: isDeep,
  });
  const object = placed(new THREE.Points(geometryOf(places), material), order, opacity);
  Object.assign(object.userData, { size, spacing, items: places.length / 3, verticesOfOne: 1 });
  return object;
}

/// Lines one pixel wide from each even point to the next; `colours`, three numbers per point, may be null.
function thinLines(ends, colours, { colour, order, opacity = 1 }) {
  const material = new THREE.LineBasicMaterial({
    color: colours ? 0xffffff : new THREE.Color(colour).getHex(),
    vertexColors: colours ? THREE.VertexColors : THREE.NoColors,
    transparent: true,
    opacity,
    depthTest: isDeep,
    depthWrite: false,
  });
  const geometry = geometryOf(ends);
  if (colours) geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
  const object = placed(new THREE.LineSegments(geometry, material), order, opacity);
  Object.assign(object.userData, { items: ends.length / 6, verticesOfOne: 2 });
  return object;
}

const kMostWide = 30000; // segments: more are drawn thin

/// Lines `width` pixels wide from each even point to the next, with `colours` as in thinLines(); one pixel wide, for speed, if
/// there are so many that each is a few pixels long.
function wideLines(ends, colours, { colour, width, order, opacity = 1 }) {
  if (ends.length > 6 * kMostWide) return thinLines(ends, colours, { colour, order, opacity });
  const geometry = new THREE.LineSegmentsGeometry();
  geometry.setPositions(ends);
  if (colours) geometry.setColors(colours);
  const material = new THREE.LineMaterial({
    color: colours ? 0xffffff : new THREE.Color(colour).getHex(),
    linewidth: width,
    vertexColors: colours ? THREE.VertexColors : THREE.NoColors,
    transparent: true,
    opacity,
    depthTest: isDeep,
  });
  material.resolution.set(window.innerWidth, window.innerHeight);
  return placed(new THREE.LineSegments2(geometry, material), order, opacity);
}

/// The ends of the segments of a path over `places` through the points of `order`, broken before its k-th point if isTied(k) is
/// false, and at unknown places.
function segmentEnds(places, order, isTied) {
  const ends = [];
  for (let k = 1; k < order.length; ++k) {
    const a = 3 * order[k - 1];
    const b = 3 * order[k];
    if (!isTied(k) || Number.isNaN(places[a] + places[b])) continue;
    ends.push(places[a], places[a + 1], places[a + 2], places[b], places[b + 1], places[b + 2]);
  }
  return new Float32Array(ends);
}

/// The ends of the five dashes of each segment.
function dashed(ends) {
  const dashes = [];
  for (let k = 0; k < ends.length; k += 6) {
    for (const ninth of [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]) {
      for (let i = k; i < k + 3; ++i) dashes.push(ends[i] + (ninth / 9) * (ends[i + 3] - ends[i]));
    }
  }
  return new Float32Array(dashes);
}

/// The ends of the segments between successive poses of each session.
function sessionEnds(places, sessions) {
  let count = 0;
  for (let s = 0; s < sessions.length; s += 2) count += Math.max(0, sessions[s + 1] - sessions[s] - 1);
  const ends = new Float32Array(6 * count);
  let next = 0;
  for (let s = 0; s < sessions.length; s += 2) {
    for (let p = sessions[s] + 1; p < sessions[s + 1]; ++p, next += 6) ends.set(places.subarray(3 * p - 3, 3 * p + 3), next);
  }
  return ends;
}

/// The lower triangular L with L Lᵀ = P; a column is zero where P has no positive pivot.
function cholesky(P) {
  const size = P.length;
  const L = P.map((row) => row.map(() => 0));
  for (let j = 0; j < size; ++j) {
    let pivot = P[j][j];
    for (let k = 0; k < j; ++k) pivot -= L[j][k] ** 2;
    L[j][j] = Math.sqrt(Math.max(pivot, 0));
    for (let i = j + 1; i < size && L[j][j] > 0; ++i) {
      let entry = P[i][j];
      for (let k = 0; k < j; ++k) entry -= L[i][k] * L[j][k];
      L[i][j] = entry / L[j][j];
    }
  }
  return L;
}

const kCorners = 32;

/// Appends the segments of the ellipse of three standard deviations or, in 3D, of three ellipses on the ellipsoid: the unit
/// circles times 3 L, with L Lᵀ the covariance of the position. Points farther than `cap` (m) from the centre are drawn at that
/// distance.
function addEllipse(centre, covariance, dimension, cap, ends) {
  const L = cholesky(covariance.slice(0, dimension).map((row) => row.slice(0, dimension)));
  const planes =
    dimension === 2
      ? [[0, 1]]
      : [
          [0, 1],
          [1, 2],
          [2, 0],
        ];
  const middle = new THREE.Vector3(...centre);
  const corner = (plane, k) => {
    const angle = (2 * Math.PI * k) / kCorners;
    const unit = [0, 0, 0];
    unit[plane[0]] = 3 * Math.cos(angle);
    unit[plane[1]] = 3 * Math.sin(angle);
    const offset = new THREE.Vector3(...L.map((row) => row.reduce((sum, l, j) => sum + l * unit[j], 0)), 0);
    return offset.clampLength(0, cap).add(middle).toArray();
  };
  for (const plane of planes) {
    for (let k = 0; k < kCorners; ++k) ends.push(...corner(plane, k), ...corner(plane, k + 1));
  }
}

/// The ends of the segments of ellipses at the chosen places; their packed covariances have so many rows.
function ellipseEnds(places, packed, rows, chosen, dimension, cap) {
  const ends = [];
  for (const k of chosen) addEllipse(places.subarray(3 * k, 3 * k + 3), covarianceAt(packed, k, rows), dimension, cap, ends);
  return new Float32Array(ends);
}
