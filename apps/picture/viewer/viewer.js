// SPDX-License-Identifier: BSD-3-Clause
// The page as a whole: what is shown, picked and under the pointer.
"use strict";

const kDetailPixels = 16; // poses are drawn as dots if they are farther apart, in pixels

class Viewer {
  constructor() {
    this.scene = readScene();
    document.querySelector("#panel details").open = window.innerWidth > 640;
    isDeep = this.scene.dimension === 3;
    this.view = new View(document.getElementById("canvas"), this.scene);
    this.localMapOf = new Map(this.scene.maps.map((map) => [map, localMapOfPoses(map)]));
    this.sessionOf = new Map(this.scene.maps.map((map) => [map, sessionOfPoses(map)]));
    this.mapWithLocalMaps = this.scene.maps.find((map) => map.localMaps.count > 0);
    this.growing = this.scene.maps.find((map) => map.stops.length > 1);
    this.stop = this.growing ? this.growing.stops.length - 1 : 0;
    this.picked = -1;
    this.layers = [];
    this.medianStep = medianStep(this.scene.maps[0]);
    document.getElementById("title").textContent = this.scene.title;
    this.paint();
    this.view.onDraw.push(() => this.beforeDraw());
    wireLocalMaps(this);
    wireStops(this);
    wireSearch(this);
    this.wire();
  }

  get isWhole() {
    return !this.growing || this.stop === this.growing.stops.length - 1;
  }

  /// Makes all layers anew, in the colours of the theme.
  paint() {
    const isDark = window.matchMedia("(prefers-color-scheme: dark)").matches;
    this.theme = document.documentElement.dataset.theme || (isDark ? "dark" : "light");
    const before = this.layers;
    this.layers = [
      ...truthLayers(this.scene, this.theme),
      ...this.scene.maps.flatMap((_, m) => layersOfMap(this.scene, m, this.theme)),
    ];
    before.forEach((layer, k) => {
      this.layers[k].isOn = layer.isOn;
      if (layer.object) discard(this.view.world, layer.object);
    });
    fillLayers(this);
    this.show();
    this.showExtra();
  }

  /// Shows the layers that are on; their objects are made when they are first shown.
  show() {
    for (const layer of this.layers) {
      const isShown = layer.isOn && (this.isWhole || layer.map !== this.growing);
      if (isShown && !layer.object) {
        layer.object = layer.make(layer.order);
        this.view.world.add(layer.object);
      }
      if (layer.object) layer.object.visible = isShown;
    }
    if (this.ring) this.ring.visible = this.isWhole;
    this.dim();
    this.view.draw();
  }

  /// Fades all layers while a local map is picked.
  dim() {
    for (const layer of this.layers) if (layer.object) fade(layer.object, this.picked >= 0 ? 0.25 : 1);
  }

  beforeDraw() {
    updateScaleBar(this.view);
    fitDots(this.view.world, this.view.camera.zoom);
    for (const layer of this.layers) {
      if (layer.isDetail && layer.object)
        layer.object.visible = layer.isOn && this.isWhole && this.view.camera.zoom * this.medianStep > kDetailPixels;
    }
  }

  pick(m) {
    this.picked = m;
    if (m >= 0 && !this.isWhole) this.goTo(this.growing.stops.length - 1);
    fillLocalMap(this.mapWithLocalMaps, m);
    this.dim();
    this.showExtra();
  }

  goTo(stop) {
    this.stop = Math.min(stop, this.growing.stops.length - 1);
    document.getElementById("stop").value = this.stop;
    if (!this.isWhole && this.picked >= 0) this.pick(-1);
    tellStop(this);
    this.show();
    this.showExtra();
  }

  /// Shows the picked local map, or the stop of joining unless it is the last one, over the layers.
  showExtra() {
    if (this.extra) discard(this.view.world, this.extra);
    this.extra = this.picked >= 0 ? pickedGroup(this) : this.isWhole ? null : stopGroup(this);
    if (this.extra) this.view.world.add(this.extra);
    this.view.draw();
  }

  /// Centres the view on a pose that poseOfId() found, rings it and shows its tip; without one, removes the ring.
  goToPose(found) {
    if (this.ring) discard(this.view.world, this.ring);
    this.ring = null;
    this.tip(null);
    this.view.draw();
    if (!found) return;
    const ring = { colour: kDistinct[1], size: 19, order: 3000, hole: 0.7 };
    this.ring = onTop(dots(placesOf(found.map.poses, [found.index]), ring));
    if (!this.isWhole) this.goTo(this.growing.stops.length - 1);
    this.view.world.add(this.ring);
    this.view.centre(new THREE.Vector3().fromArray(found.map.poses, 3 * found.index));
    const at = {};
    this.view.projector()(found.map.poses, found.index, at);
    this.tip(found, at.x, at.y);
  }

  wire() {
    const { canvas } = this.view;
    canvas.addEventListener("pointermove", (event) => this.hover(event));
    canvas.addEventListener("pointerleave", () => this.tip(null));
    canvas.addEventListener("pointerdown", (event) => (this.pressed = { x: event.clientX, y: event.clientY }));
    canvas.addEventListener("pointerup", (event) => this.click(event));
    document.getElementById("fit").addEventListener("click", () => this.view.fit());
    document.getElementById("theme").addEventListener("click", () => {
      document.documentElement.dataset.theme = this.theme === "dark" ? "light" : "dark";
      this.paint();
    });
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.paint());
    const moving = this.scene.dimension === 2 ? "Drag to move" : "Drag to rotate, right-drag to move";
    const picking = this.mapWithLocalMaps ? ", click to pick a local map" : "";
    document.getElementById("help").textContent = `${moving}, wheel to zoom${picking}. With keys: Tab to the map, arrows to move, + and - to zoom.`;
  }

  hover(event) {
    const found = event.buttons === 0 && this.isWhole ? nearest(this.view, this.layers, event.clientX, event.clientY) : null;
    this.view.canvas.style.cursor = found ? "pointer" : "";
    this.tip(found, event.clientX, event.clientY);
  }

  /// Shows the tip of a pose or feature beside a point of the page; hides it if there is none.
  tip(found, x, y) {
    const tip = document.getElementById("tip");
    tip.hidden = !found;
    if (!found) return;
    tell(this.scene, this.localMapOf, this.mapWithLocalMaps, found, tip);
    placeTip(tip, x, y);
  }

  /// Picks the local map of the pose where the pointer was pressed and released, or none if there is no such pose.
  click(event) {
    const { pressed } = this;
    if (!pressed || !this.mapWithLocalMaps || !this.isWhole) return;
    if (Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) > 4) return;
    const found = nearest(
      this.view,
      this.layers.filter((layer) => layer.tells === "poses"),
      event.clientX,
      event.clientY,
    );
    this.pick(found && found.map === this.mapWithLocalMaps ? this.localMapOf.get(found.map)[found.index] : -1);
  }
}

/// The median distance from pose to pose (m), of a thousand steps or so of a long map; 1 if it is 0 or unknown.
function medianStep(map) {
  const steps = [];
  for (let p = 1; p < map.poses.length / 3; p += 1 + (map.poses.length >> 12)) {
    steps.push(Math.hypot(...[0, 1, 2].map((i) => map.poses[3 * p + i] - map.poses[3 * p - 3 + i])));
  }
  return steps.sort((a, b) => a - b)[steps.length >> 1] || 1;
}

/// The picked local map: its poses as a thick line, its end poses, and its features with rings around them.
function pickedGroup(viewer) {
  const map = viewer.mapWithLocalMaps;
  const { base, end, offsets, features } = map.localMaps;
  const m = viewer.picked;
  const colour = localMapColour(m);
  const group = new THREE.Group();
  const path = map.poses.slice(3 * base[m], 3 * end[m] + 3);
  group.add(wideLines(sessionEnds(path, [0, path.length / 3]), null, { colour, width: 5, order: 2000 }));
  group.add(dots(placesOf(map.poses, [base[m], end[m]]), { colour: kInk[viewer.theme], size: 9, order: 2001 }));
  const seen = features.subarray(offsets[m], offsets[m + 1]);
  group.add(dots(placesOf(map.features, Array.from(seen)), { colour: kDistinct[1], size: 7, order: 2002 }));
  group.add(dots(placesOf(map.features, Array.from(seen)), { colour: kInk[viewer.theme], size: 15, order: 2003, hole: 0.75 }));
  return onTop(group);
}

/// The join of the first maps: its features and poses, tied as in the sessions, with the poses that are new since the stop
/// before in orange.
function stopGroup(viewer) {
  const map = viewer.growing;
  const stop = map.stops[viewer.stop];
  const before = viewer.stop > 0 ? map.stops[viewer.stop - 1].poses.length : 0;
  const count = stop.poses.length;
  const sessionOf = viewer.sessionOf.get(map);
  const order = Array.from({ length: count }, (_, k) => k);
  const isTied = (k) => sessionOf[stop.poses[k - 1]] === sessionOf[stop.poses[k]];
  const group = new THREE.Group();
  group.add(
    dots(stop.featurePlaces, {
      colour: kDistinct[1],
      size: 6.5,
      order: 2000,
      spacing: spacingOf(stop.featurePlaces, viewer.scene.dimension),
    }),
  );
  group.add(wideLines(segmentEnds(stop.posePlaces, order, isTied), null, { colour: kDistinct[0], width: 2.2, order: 2001 }));
  group.add(
    dots(stop.posePlaces, {
      colour: kInk[viewer.theme],
      size: 4,
      order: 2002,
      spacing: spacingOf(stop.posePlaces, viewer.scene.dimension),
    }),
  );
  const fresh = order.slice(Math.max(0, before - 1));
  group.add(
    wideLines(
      segmentEnds(stop.posePlaces, fresh, (k) => isTied(fresh[k])),
      null,
      { colour: kDistinct[4], width: 4, order: 2003 },
    ),
  );
  return group;
}

/// True if the browser has WebGL; otherwise the page says that it has none.
function hasWebGL() {
  const has = Boolean(document.createElement("canvas").getContext("webgl"));
  for (const id of ["panel", "scale"]) document.getElementById(id).hidden = !has;
  document.getElementById("no-webgl").hidden = has;
  return has;
}

const viewer = hasWebGL() ? new Viewer() : null;
