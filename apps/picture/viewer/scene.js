// SPDX-License-Identifier: BSD-3-Clause
// The scene that the page brings along: JSON, with numbers as base64 of little-endian arrays. Places are in metres from
// `centre`.
"use strict";

function bytesOf(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; ++k) bytes[k] = text.charCodeAt(k);
  return bytes.buffer;
}

const floats = (base64) => new Float32Array(bytesOf(base64 || ""));
const doubles = (base64) => new Float64Array(bytesOf(base64 || ""));
const indices = (base64) => new Uint32Array(bytesOf(base64 || ""));
const keys = (base64) => new BigUint64Array(bytesOf(base64 || ""));

/// The local maps as arrays over them; the features of map m are features[offsets[m]] to features[offsets[m + 1] - 1].
function readLocalMaps(raw) {
  return {
    count: raw.count,
    base: indices(raw.base),
    end: indices(raw.end),
    chi2: doubles(raw.chi2),
    rows: indices(raw.rows),
    probability: doubles(raw.probability),
    offsets: indices(raw.offsets),
    features: indices(raw.features),
  };
}

/// The join of the first `maps` maps: the indices and places of its poses, and the places of its features.
function readStop(raw) {
  return {
    maps: raw.maps,
    chi2: raw.chi2,
    poses: indices(raw.poses),
    posePlaces: floats(raw.posePlaces),
    featurePlaces: floats(raw.featurePlaces),
  };
}

function readMap(raw) {
  return {
    name: raw.name,
    isOdometry: raw.isOdometry,
    poses: floats(raw.poses),
    headings: floats(raw.headings),
    poseKeys: keys(raw.poseKeys),
    robots: indices(raw.robots),
    sessions: indices(raw.sessions),
    poseCovariances: floats(raw.poseCovariances),
    features: floats(raw.features),
    featureKeys: keys(raw.featureKeys),
    featureCovariances: floats(raw.featureCovariances),
    odometry: floats(raw.odometry),
    trajectories: raw.trajectories.map((part) => ({ ...part, sessions: indices(part.sessions) })),
    links: raw.links.map((links) => ({ ...links, ends: indices(links.ends) })),
    ellipses: raw.ellipses,
    localMaps: readLocalMaps(raw.localMaps),
    stops: raw.stops.map(readStop),
  };
}

function readScene() {
  const raw = JSON.parse(document.getElementById("scene").textContent);
  return {
    title: raw.title,
    dimension: raw.dimension,
    centre: raw.centre,
    maps: raw.maps.map(readMap),
    truth: raw.truth && { poses: floats(raw.truth.poses), features: floats(raw.truth.features) },
  };
}

const robotOf = (map, pose) => (map.robots.length > 0 ? map.robots[pose] : 0);

/// A key in words: as "17" or, if it is a GTSAM symbol, whose top byte is a letter, as "a17".
function keyText(key) {
  const letter = String.fromCharCode(Number(key >> 56n));
  return /[a-zA-Z]/.test(letter) ? letter + BigInt.asUintN(56, key) : String(key);
}

/// The key that a word is: a number, or a GTSAM symbol.
function keyOf(word) {
  const isSymbol = /^[a-zA-Z]/.test(word);
  return isSymbol ? (BigInt(word.charCodeAt(0)) << 56n) | BigInt(word.slice(1)) : BigInt(word);
}

/// The name of a pose, as "pose 17" or "pose 17 of session 2".
function poseName(map, pose) {
  const robot = robotOf(map, pose);
  return `pose ${keyText(map.poseKeys[pose])}` + (robot === 0 ? "" : ` of session ${robot}`);
}

/// The first pose of an id in words, as "17", "a17", "17 of session 2" or, as commands have it, "2:17": its map and index;
/// undefined if there is none.
function poseOfId(scene, words) {
  const found = words.match(/^(?:pose[\s:]*)?(?:(\d+):)?([a-z]?\d+)(?:\s+of\s+session\s+(\d+))?$/i);
  if (!found) return undefined;
  const [, before, id, behind] = found;
  const wanted = keyOf(id);
  const sessions = [before, behind].filter((word) => word !== undefined).map(Number);
  const isOfThem = (map, pose) => sessions.every((session) => robotOf(map, pose) === session);
  for (const map of scene.maps) {
    const index = map.poseKeys.findIndex((key, pose) => key === wanted && isOfThem(map, pose));
    if (index >= 0) return { kind: "poses", map, index };
  }
  return undefined;
}

const featureName = (map, feature) => `feature ${keyText(map.featureKeys[feature])}`;

/// The local map that starts at or contains each pose, or else one that ends there; -1 if there is none.
function localMapOfPoses(map) {
  const of = new Int32Array(map.poses.length / 3).fill(-1);
  const maps = map.localMaps;
  for (let m = maps.count - 1; m >= 0; --m) {
    for (let p = maps.base[m]; p < maps.end[m]; ++p) of[p] = m;
    if (of[maps.end[m]] < 0) of[maps.end[m]] = m;
  }
  return of;
}

function sessionOfPoses(map) {
  const of = new Uint32Array(map.poses.length / 3);
  for (let s = 0; s < map.sessions.length; s += 2) of.fill(s / 2, map.sessions[s], map.sessions[s + 1]);
  return of;
}

/// The symmetric matrix whose upper triangle, row by row, is entry `k` of a packed array.
function covarianceAt(packed, k, size) {
  const triangle = (size * (size + 1)) / 2;
  const P = Array.from({ length: size }, () => new Array(size).fill(0));
  let next = k * triangle;
  for (let i = 0; i < size; ++i) {
    for (let j = i; j < size; ++j) P[i][j] = P[j][i] = packed[next++];
  }
  return P;
}
