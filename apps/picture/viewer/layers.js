// SPDX-License-Identifier: BSD-3-Clause
// Layers of a scene, which can be switched on and off, each with the objects that show it.
"use strict";

// The colours of Okabe and Ito, as in SVG pictures.
const kDistinct = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const kLocalMapColours = [kDistinct[0], kDistinct[2], kDistinct[3], kDistinct[5], kDistinct[4]];
const kInk = { light: "#1c2024", dark: "#e6e8eb" };
const kFaint = { light: "#a3a9b3", dark: "#6b7280" };
const kMostEllipses = 5000;
const kManyLinks = 200; // links of one class: so many and more are drawn thin
const kPoseEllipses = 400; // at most so many along a trajectory without local maps

function localMapColour(m) {
  return kLocalMapColours[m % kLocalMapColours.length];
}

/// Every k-th of `count` indices, `most` of them at most.
function everyOf(count, most) {
  const step = Math.max(1, Math.ceil(count / most));
  const chosen = [];
  for (let k = step - 1; k < count; k += step) chosen.push(k);
  return chosen;
}

/// A trajectory in the colours of its local maps: ends of segments and a colour for each end.
function localMapSegments(map) {
  const ends = [];
  const colours = [];
  for (let m = 0; m < map.localMaps.count; ++m) {
    const { r, g, b } = new THREE.Color(localMapColour(m));
    for (let p = map.localMaps.base[m]; p < map.localMaps.end[m]; ++p) {
      for (let i = 3 * p; i < 3 * p + 6; ++i) ends.push(map.poses[i]);
      colours.push(r, g, b, r, g, b);
    }
  }
  return { ends: new Float32Array(ends), colours: new Float32Array(colours) };
}

function placesOf(places, chosen) {
  const some = new Float32Array(3 * chosen.length);
  chosen.forEach((k, n) => some.set(places.subarray(3 * k, 3 * k + 3), 3 * n));
  return some;
}

/// True if local maps cover every step of the sessions, so that the trajectory is theirs.
function isCovered(map) {
  const steps = map.localMaps.end.reduce((sum, end, m) => sum + end - map.localMaps.base[m], 0);
  return steps >= map.poses.length / 3 - map.sessions.length / 2;
}

/// The layers of poses and of the lines through them; `tells` names what the pointer finds in a layer, poses or features.
function pathLayers({ map, colours, dimension, ends, isSingle }) {
  const hasMaps = map.localMaps.count > 0;
  const endPlaces = placesOf(map.poses, ends);
  const makeEnds = (order) =>
    dots(endPlaces, { colour: colours.ink, size: 5, order, spacing: spacingOf(endPlaces, dimension) });
  const makeLocalMaps = (order) => {
    const segments = localMapSegments(map);
    return wideLines(segments.ends, segments.colours, { width: 2.8, order });
  };
  const makePoses = (order) => dots(map.poses, { colour: colours.own, size: 4.5, order });
  const paths = isSingle ? map.trajectories : [{ name: "trajectory", colour: colours.own, sessions: map.sessions }];
  const isOfMaps = isSingle && paths.length === 1;
  const localMapColour = isSingle ? kLocalMapColours : colours.own;
  return [
    {
      name: "end poses",
      count: hasMaps ? ends.length : 0,
      colour: colours.ink,
      kind: "dot",
      make: makeEnds,
      isOn: paths.length === 1,
    },
    {
      name: "local maps",
      count: map.localMaps.count,
      colour: localMapColour,
      kind: "line",
      make: makeLocalMaps,
      tells: "poses",
      isOn: isOfMaps,
    },
    {
      name: "poses",
      count: map.poses.length / 3,
      colour: colours.own,
      kind: "dot",
      make: makePoses,
      tells: "poses",
      isDetail: true,
    },
    ...paths.map(({ name, colour, sessions }) => ({
      name,
      count: sessions.length / 2,
      colour,
      kind: "line",
      make: (order) => wideLines(sessionEnds(map.poses, sessions), null, { colour, width: 1.8, order }),
      tells: "poses",
      isOn: !(isOfMaps && hasMaps && isCovered(map)),
    })),
  ];
}

function featureLayer({ map, colours, dimension }) {
  const spacing = spacingOf(map.features, dimension);
  const make = (order) => dots(map.features, { colour: colours.features, size: 6.5, order, spacing });
  return { name: "features", count: map.features.length / 3, colour: colours.features, kind: "dot", make, tells: "features" };
}

/// The layers of ellipses, empty if covariances are unknown.
function certaintyLayers({ map, colours, dimension, ends }) {
  const poses = map.poseCovariances.length > 0 ? ends : [];
  const features = map.featureCovariances.length > 0 ? everyOf(map.features.length / 3, kMostEllipses) : [];
  const rows = dimension === 2 ? 3 : 6;
  const { cap } = map.ellipses;
  const makePoses = (order) =>
    thinLines(ellipseEnds(map.poses, map.poseCovariances, rows, poses, dimension, cap), null, {
      colour: colours.ink,
      order,
      opacity: 0.7,
    });
  const makeFeatures = (order) =>
    thinLines(ellipseEnds(map.features, map.featureCovariances, dimension, features, dimension, cap), null, {
      colour: colours.features,
      order,
      opacity: 0.8,
    });
  return [
    { name: map.ellipses.ofPoses, count: poses.length, colour: colours.ink, kind: "ring", make: makePoses },
    { name: map.ellipses.ofFeatures, count: features.length, colour: colours.features, kind: "ring", make: makeFeatures },
  ];
}

/// The places at both ends of links; indices of features count on from those of poses.
function linkEnds(map, ends) {
  const places = new Float32Array(map.poses.length + map.features.length);
  places.set(map.poses);
  places.set(map.features, map.poses.length);
  return placesOf(places, ends);
}

/// The layers of closures and observations, in classes by their residuals, the worst first; the more a class has, the fainter
/// it is.
function linkLayers({ map, theme }, isOnTop) {
  const layerOf = ({ name, colours, width, isDashed, ends }) => {
    const colour = colours[theme];
    const opacity = Math.max(0.3, Math.min(1, 2000 / ends.length));
    const draw = isOnTop && ends.length < 2 * kManyLinks ? wideLines : thinLines;
    const make = (order) => {
      const places = linkEnds(map, ends);
      return draw(isDashed ? dashed(places) : places, null, { colour, width: 1.5 * width, order, opacity });
    };
    return { name, count: ends.length / 2, colour, kind: "line", make };
  };
  const layers = map.links.filter((links) => links.isOnTop === isOnTop).map(layerOf);
  return layers.reverse();
}

function odometryLayer({ map, colours }) {
  const make = (order) =>
    wideLines(sessionEnds(map.odometry, map.sessions), null, { colour: colours.faint, width: 1.2, order, opacity: 0.8 });
  const count = map.odometry.length > 0 ? map.sessions.length / 2 : 0;
  return { name: "odometry alone", count, colour: colours.faint, kind: "line", make, isOn: false };
}

/// The layers of one map that have anything in them, the uppermost first; those of earlier maps lie above those of later ones.
function layersOfMap(scene, m, theme) {
  const map = scene.maps[m];
  const isSingle = scene.maps.length === 1;
  const own = kDistinct[m % kDistinct.length];
  const colours = { ink: kInk[theme], faint: kFaint[theme], own, features: isSingle ? kDistinct[1] : own };
  const ends = map.localMaps.count > 0 ? Array.from(map.localMaps.end) : everyOf(map.poses.length / 3, kPoseEllipses);
  const content = { map, theme, colours, ends, isSingle, dimension: scene.dimension };
  const layers = [
    ...linkLayers(content, true),
    ...pathLayers(content),
    featureLayer(content),
    ...certaintyLayers(content),
    ...linkLayers(content, false),
    odometryLayer(content),
  ];
  const top = 100 * (scene.maps.length - m) + layers.length;
  const heading = isSingle ? "" : map.name;
  return layers
    .filter((layer) => layer.count > 0)
    .map((layer, k) => ({ isOn: true, tells: null, map, heading, order: top - k, ...layer }));
}

/// The layer of the truth of the first map, below all maps: its path, dots at poses that are known alone, and
/// rings where features truly are; none without a truth.
function truthLayers(scene, theme) {
  if (!scene.truth) return [];
  const { poses, features } = scene.truth;
  const ink = kInk[theme];
  const map = scene.maps[0];
  const make = (order) => {
    const group = new THREE.Group();
    const sessionOf = sessionOfPoses(map);
    const sequence = Array.from(sessionOf.keys());
    const isStep = (k) => sessionOf[k - 1] === sessionOf[k] && !Number.isNaN(poses[3 * k - 3] + poses[3 * k]);
    group.add(wideLines(segmentEnds(poses, sequence, isStep), null, { colour: ink, width: 1.4, order }));
    const alone = sequence.filter((k) => !Number.isNaN(poses[3 * k]) && !isStep(k) && !isStep(k + 1));
    group.add(dots(placesOf(poses, alone), { colour: ink, size: 6, order }));
    const known = [];
    for (let f = 0; f < features.length / 3; ++f) if (!Number.isNaN(features[3 * f])) known.push(f);
    group.add(dots(placesOf(features, known), { colour: ink, size: 12, order: order + 1, hole: 0.75 }));
    return group;
  };
  return [{ name: "truth", count: 1, colour: ink, kind: "line", map, make, order: 50, isOn: true, tells: null, heading: "" }];
}
